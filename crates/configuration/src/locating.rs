//! The configuration of locating: what a file may say in its tables `[locating.…]`.
//!
//! Every key has the default of the crate `locating`, so an empty file is a good one:
//!
//! ```toml
//! [locating]
//! emitters_max = 1000
//! [locating.motion]
//! filter = "auto"             # auto, fixed or straight
//! speed_sigma_mps = 30.0
//! [locating.selection]
//! select = "staged"           # auto, none, interval, minimum or staged
//! position_sigma_max_m = 500.0
//! interval_s = 250.0
//! ```

use std::path::Path;

use locating::selection::{AboveThreshold, Select, SelectionSettings};
use locating::settings::{
    AssociationSettings, ConsistencySettings, FilterChoice, MotionSettings, Settings as LocatingSettings,
};
use serde::Deserialize;

use super::ConfigError;
use super::check::{Checked, problem};
use super::locate::line_at;

/// Reads the text of `path`: the table `[locating]`, and nothing else.
///
/// # Errors
/// [`ConfigError`] with file, line, key, value and remedy.
pub fn locating_settings(path: &Path, text: &str) -> Result<LocatingSettings, ConfigError> {
    let raw: RawFile = toml::from_str(text).map_err(|error: toml::de::Error| ConfigError {
        file: path.to_owned(),
        line: error.span().map(|span| line_at(text, span.start)),
        what: error.message().replace('\n', " "),
    })?;
    check_locating(&raw.locating, "locating").map_err(|problem| problem.in_file(path, text))
}

/// The settings that a table says, found in the file under `key`.
pub(super) fn check_locating(raw: &RawLocating, key: &str) -> Checked<LocatingSettings> {
    let settings = raw.settings();
    match settings.fault() {
        None => Ok(settings),
        Some(fault) if fault.key == "selection.variance_max_m2" => {
            let value = raw.selection.position_sigma_max_m;
            let what = format!("{value} is not usable; it must be greater than 0");
            Err(problem(format!("{key}.selection.position_sigma_max_m"), what))
        }
        Some(fault) => Err(problem(format!("{key}.{}", fault.key), fault.what)),
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFile {
    #[serde(default)]
    locating: RawLocating,
}

/// `[locating]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct RawLocating {
    emitters_max: usize,
    motion: RawMotion,
    consistency: RawConsistency,
    selection: RawSelection,
    association: RawAssociation,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct RawMotion {
    filter: Filter,
    range_sigma_m: f64,
    speed_sigma_mps: f64,
    wandering_noise_m2ps: f64,
    manoeuvring_noise_m2ps3: f64,
    evidence_min: f64,
    evidence_bearings: u32,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct RawConsistency {
    limit: f64,
    limit_turning: f64,
    turning_deg_per_s: f64,
    disagreement_max_s: f64,
    disagreement_bearings: u32,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct RawSelection {
    select: Selection,
    position_sigma_max_m: f64,
    interval_s: f64,
    above_threshold: Above,
    minimum_rise: f64,
    minimum_gap_s: f64,
    settled_minima: u32,
    minimum_wait_s: f64,
    steering_s: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct RawAssociation {
    frequency_tolerance_hz: f64,
    gate: f64,
    rate_max_deg_per_s: f64,
    silent_max_s: f64,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Filter {
    Auto,
    Fixed,
    Straight,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Selection {
    Auto,
    None,
    Interval,
    Minimum,
    Staged,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Above {
    Continue,
    UseCrossings,
}

impl RawLocating {
    fn settings(&self) -> LocatingSettings {
        let (motion, consistency) = (&self.motion, &self.consistency);
        let (selection, association) = (&self.selection, &self.association);
        LocatingSettings {
            emitters_max: self.emitters_max,
            motion: MotionSettings {
                filter: match motion.filter {
                    Filter::Auto => FilterChoice::Auto,
                    Filter::Fixed => FilterChoice::Fixed,
                    Filter::Straight => FilterChoice::Straight,
                },
                range_sigma_m: motion.range_sigma_m,
                speed_sigma_mps: motion.speed_sigma_mps,
                wandering_noise_m2ps: motion.wandering_noise_m2ps,
                manoeuvring_noise_m2ps3: motion.manoeuvring_noise_m2ps3,
                evidence_min: motion.evidence_min,
                evidence_bearings: motion.evidence_bearings,
            },
            consistency: ConsistencySettings {
                limit: consistency.limit,
                limit_turning: consistency.limit_turning,
                turning_rad_per_s: consistency.turning_deg_per_s.to_radians(),
                disagreement_max_s: consistency.disagreement_max_s,
                disagreement_bearings: consistency.disagreement_bearings,
            },
            selection: SelectionSettings {
                select: match selection.select {
                    Selection::Auto => Select::Auto,
                    Selection::None => Select::None,
                    Selection::Interval => Select::Interval,
                    Selection::Minimum => Select::Minimum,
                    Selection::Staged => Select::Staged,
                },
                variance_max_m2: selection.position_sigma_max_m * selection.position_sigma_max_m.abs(),
                interval_s: selection.interval_s,
                above: match selection.above_threshold {
                    Above::Continue => AboveThreshold::Continue,
                    Above::UseCrossings => AboveThreshold::UseCrossings,
                },
                minimum_rise: selection.minimum_rise,
                minimum_gap_s: selection.minimum_gap_s,
                settled_minima: selection.settled_minima,
                minimum_wait_s: selection.minimum_wait_s,
                steering_s: selection.steering_s,
            },
            association: AssociationSettings {
                frequency_tolerance_hz: association.frequency_tolerance_hz,
                gate: association.gate,
                rate_max_rad_per_s: association.rate_max_deg_per_s.to_radians(),
                silent_max_s: association.silent_max_s,
            },
        }
    }
}

impl Default for RawLocating {
    fn default() -> Self {
        Self {
            emitters_max: LocatingSettings::default().emitters_max,
            motion: RawMotion::default(),
            consistency: RawConsistency::default(),
            selection: RawSelection::default(),
            association: RawAssociation::default(),
        }
    }
}

impl Default for RawMotion {
    fn default() -> Self {
        let of = MotionSettings::default();
        Self {
            filter: Filter::Auto,
            range_sigma_m: of.range_sigma_m,
            speed_sigma_mps: of.speed_sigma_mps,
            wandering_noise_m2ps: of.wandering_noise_m2ps,
            manoeuvring_noise_m2ps3: of.manoeuvring_noise_m2ps3,
            evidence_min: of.evidence_min,
            evidence_bearings: of.evidence_bearings,
        }
    }
}

impl Default for RawConsistency {
    fn default() -> Self {
        let of = ConsistencySettings::default();
        Self {
            limit: of.limit,
            limit_turning: of.limit_turning,
            turning_deg_per_s: of.turning_rad_per_s.to_degrees(),
            disagreement_max_s: of.disagreement_max_s,
            disagreement_bearings: of.disagreement_bearings,
        }
    }
}

impl Default for RawSelection {
    fn default() -> Self {
        let of = SelectionSettings::default();
        Self {
            select: Selection::Auto,
            position_sigma_max_m: of.variance_max_m2.sqrt(),
            interval_s: of.interval_s,
            above_threshold: Above::Continue,
            minimum_rise: of.minimum_rise,
            minimum_gap_s: of.minimum_gap_s,
            settled_minima: of.settled_minima,
            minimum_wait_s: of.minimum_wait_s,
            steering_s: of.steering_s,
        }
    }
}

impl Default for RawAssociation {
    fn default() -> Self {
        let of = AssociationSettings::default();
        Self {
            frequency_tolerance_hz: of.frequency_tolerance_hz,
            gate: of.gate,
            rate_max_deg_per_s: of.rate_max_rad_per_s.to_degrees(),
            silent_max_s: of.silent_max_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<LocatingSettings, String> {
        locating_settings(Path::new("locate.toml"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn an_empty_file_says_the_defaults() {
        let (found, default) = (read("").unwrap(), LocatingSettings::default());
        assert_eq!(
            (found.motion, found.emitters_max),
            (default.motion, default.emitters_max)
        );
        assert!((found.selection.variance_max_m2 / default.selection.variance_max_m2 - 1.0).abs() < 1e-12);
        assert_eq!(found.selection.select, Select::Auto);
    }

    #[test]
    fn keys_are_taken_over_in_their_units() {
        let text = "[locating]\nemitters_max = 7\n[locating.motion]\nfilter = \"fixed\"\n[locating.selection]\n\
                    select = \"minimum\"\nabove_threshold = \"use-crossings\"\nposition_sigma_max_m = 30.0\n\
                    [locating.consistency]\nturning_deg_per_s = 90.0\n";
        let found = read(text).unwrap();
        assert_eq!((found.emitters_max, found.motion.filter), (7, FilterChoice::Fixed));
        assert_eq!(found.selection.select, Select::Minimum);
        assert_eq!(found.selection.above, AboveThreshold::UseCrossings);
        assert_eq!(found.selection.variance_max_m2, 900.0);
        assert!((found.consistency.turning_rad_per_s - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_is_refused_with_file_line_key_value_and_remedy() {
        for (text, expected) in [
            (
                "[locating.selection]\ninterval_s = 0\n",
                "locate.toml:2: locating.selection.interval_s: 0 is not usable; it must be greater than 0",
            ),
            (
                "[locating.selection]\nposition_sigma_max_m = -5.0\n",
                "locate.toml:2: locating.selection.position_sigma_max_m: -5 is not usable; it must be greater than 0",
            ),
            (
                "\n[locating]\nemitter_max = 3\n",
                "locate.toml:3: unknown field `emitter_max`",
            ),
            (
                "[locating.motion]\nfilter = \"still\"\n",
                "locate.toml:2: unknown variant `still`",
            ),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.starts_with(expected), "{error}");
        }
    }
}

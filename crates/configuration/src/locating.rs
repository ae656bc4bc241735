//! The configuration of `koseki locate`.

use std::path::Path;

use super::ConfigError;

settings::settings! {
    /// A configuration of `koseki locate`; an empty one is a good one.
    pub struct LocatingTable {
        /// How emitters are located.
        locating: ::locating::Settings = ::locating::Settings::default();
        /// Emitters that the platform dropped at a known place and time.
        dropped: Vec<::locating::DroppedEmitter> = Vec::new();
    }
}

/// Reads the text of `path`: the table `[locating]` and the emitters in `[[dropped]]`.
///
/// # Errors
/// [`ConfigError`] with file, line, key, value and remedy.
pub fn locating_settings(
    path: &Path,
    text: &str,
) -> Result<(::locating::Settings, Vec<::locating::DroppedEmitter>), ConfigError> {
    super::read::<LocatingTable>(path, text).map(|table| (table.locating, table.dropped))
}

#[cfg(test)]
mod tests {
    use ::locating::Settings as LocatingSettings;
    use ::locating::selection::{AboveThreshold, Select};
    use ::locating::settings::FilterChoice;

    use super::*;

    fn read(text: &str) -> Result<LocatingSettings, String> {
        let read = locating_settings(Path::new("locate.toml"), text);
        read.map(|(settings, _)| settings).map_err(|error| error.to_string())
    }

    #[test]
    fn an_empty_file_says_the_defaults() {
        let (found, default) = (read("").unwrap(), LocatingSettings::default());
        assert_eq!(found, default);
    }

    #[test]
    fn keys_are_taken_over_in_their_units() {
        let text = "[locating]\nemitters_max = 7\n[locating.motion]\nfilter = \"fixed\"\n[locating.selection]\n\
                    select = \"minimum\"\nabove_threshold = \"use-crossings\"\nposition_sigma_max_m = 30.0\n\
                    [locating.consistency]\nturning_deg_per_s = 90.0\n";
        let found = read(text).unwrap();
        assert_eq!((found.emitters_max, found.motion.filter), (7, FilterChoice::Fixed));
        assert_eq!(found.selection.select, Select::Minimum);
        assert_eq!(found.selection.above_threshold, AboveThreshold::UseCrossings);
        assert_eq!(found.selection.position_sigma_max_m, 30.0);
        assert!((found.consistency.turning_deg_per_s.rad() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn dropped_emitters_have_a_place_and_a_time() {
        let text = "[[dropped]]\nemitter_id = 7\ntime_s = 36000\nposition_m = [10, -20]\n";
        let (_, dropped) = locating_settings(Path::new("locate.toml"), text).unwrap();
        let expected = ::locating::DroppedEmitter {
            emitter_id: 7,
            time_s: 36_000.0,
            position_m: [10.0, -20.0],
            sigma_m: 50.0,
        };
        assert_eq!(dropped, [expected]);
    }

    #[test]
    fn what_cannot_be_is_refused_with_file_line_key_value_and_remedy() {
        for (text, expected) in [
            (
                "[locating.selection]\ninterval_s = 0\n",
                "locate.toml:2: locating.selection.interval_s: 0 is out of range; it must be greater than 0",
            ),
            (
                "[locating.selection]\nposition_sigma_max_m = -5.0\n",
                "locate.toml:2: locating.selection.position_sigma_max_m: -5 is out of range; it must be greater than 0",
            ),
            (
                "\n[locating]\nemitter_max = 3\n",
                "locate.toml:3: locating.emitter_max: unknown key; there are: emitters_max, bearing_sigma_deg, motion",
            ),
            (
                "[[dropped]]\nemitter_id = 7\ntime_s = -1\nposition_m = [0, 0]\n",
                "locate.toml:3: dropped[0].time_s: -1 is out of range; it must lie between 0 and 86400",
            ),
            (
                "[[dropped]]\nemitter_id = 7\ntime_s = 1\n",
                "locate.toml:1: dropped[0].position_m",
            ),
            (
                "[locating.selection]\ninterval = \"bearing\"\n",
                "locate.toml:2: locating.selection.interval: \"bearing\" is not known; there are: time, geometry",
            ),
            (
                "[locating.motion]\nfilter = \"still\"\n",
                "locate.toml:2: locating.motion.filter: \"still\" is not known; there are: auto, fixed",
            ),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.starts_with(expected), "{error}");
        }
    }
}

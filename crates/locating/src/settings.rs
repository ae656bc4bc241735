//! What the locator is told beforehand. Values are in SI units.

use crate::selection::SelectionSettings;

/// Everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How emitters may move (EL-2).
    pub motion: MotionSettings,
    /// When bearings are set aside.
    pub consistency: ConsistencySettings,
    /// Which fixes are used for the output (EL-4 … EL-10).
    pub selection: SelectionSettings,
    /// How bearings without emitter id find their emitter (EL-12).
    pub association: AssociationSettings,
    /// Most emitters at a time.
    pub emitters_max: usize,
}

/// EL-2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionSettings {
    /// Which models compete.
    pub filter: FilterChoice,
    /// Standard deviation of an unknown emitter's position about the platform, metres, along each axis.
    pub range_sigma_m: f64,
    /// Standard deviation of an unknown emitter's velocity, metres per second, along each axis.
    pub speed_sigma_mps: f64,
    /// How fixed points wander, m²/s, in the model that stands by in case that an emitter is no fixed point.
    pub wandering_noise_m2ps: f64,
    /// Spectral density of accelerations, m²/s³, in the model that stands by in case that an emitter does not move straight.
    pub manoeuvring_noise_m2ps3: f64,
    /// A fixed point is given up for straight motion when the bearings are so much likelier by it: logarithm of the Bayes
    /// factor, times 2.
    pub evidence_min: f64,
    /// … for so many bearings, and the other way round.
    pub evidence_bearings: u32,
}

/// Which models compete for an emitter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilterChoice {
    /// Fixed point, straight motion and manoeuvring: the data decide.
    Auto,
    /// Fixed point, and one that wanders.
    Fixed,
    /// Straight motion, and manoeuvring.
    Straight,
}

/// When bearings are set aside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConsistencySettings {
    /// Bearings are set aside when the running sum of their normalised innovations exceeds so many standard deviations …
    pub limit: f64,
    /// … and so many while the platform turns.
    pub limit_turning: f64,
    /// From this rate of the heading on it turns, radians per second.
    pub turning_rad_per_s: f64,
    /// It is the fix that is wrong when bearings disagree for so long without a turn, seconds, …
    pub disagreement_max_s: f64,
    /// … and are at least so many.
    pub disagreement_bearings: u32,
}

/// How bearings without emitter id find their emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AssociationSettings {
    /// Difference up to which two frequencies may be of one emitter, hertz.
    pub frequency_tolerance_hz: f64,
    /// A bearing belongs to an emitter if it differs from what is expected by at most so many standard deviations.
    pub gate: f64,
    /// How fast the bearing of an emitter without a fix may change, radians per second.
    pub rate_max_rad_per_s: f64,
    /// An emitter that was silent for so long may give its place to another, seconds.
    pub silent_max_s: f64,
}

impl FilterChoice {
    /// Every choice.
    pub const ALL: [Self; 3] = [Self::Auto, Self::Fixed, Self::Straight];

    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Fixed => "fixed",
            Self::Straight => "straight",
        }
    }
}

impl Default for MotionSettings {
    fn default() -> Self {
        Self {
            filter: FilterChoice::Auto,
            range_sigma_m: 300e3,
            speed_sigma_mps: 30.0,
            wandering_noise_m2ps: 400.0,
            manoeuvring_noise_m2ps3: 0.01,
            evidence_min: 20.0,
            evidence_bearings: 16,
        }
    }
}

impl Default for ConsistencySettings {
    fn default() -> Self {
        Self {
            limit: 3.5,
            limit_turning: 3.0,
            turning_rad_per_s: 0.02,
            disagreement_max_s: 90.0,
            disagreement_bearings: 40,
        }
    }
}

impl Default for AssociationSettings {
    fn default() -> Self {
        Self {
            frequency_tolerance_hz: 10e3,
            gate: 4.0,
            rate_max_rad_per_s: 0.02,
            silent_max_s: 600.0,
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            motion: MotionSettings::default(),
            consistency: ConsistencySettings::default(),
            selection: SelectionSettings::default(),
            association: AssociationSettings::default(),
            emitters_max: 1024,
        }
    }
}

/// Most emitters that can be configured: 20 kB each.
pub const EMITTERS_MAX: usize = 100_000;

impl Settings {
    /// What is wrong with them, if anything.
    pub fn fault(&self) -> Option<Fault> {
        let (motion, consistency, association) = (&self.motion, &self.consistency, &self.association);
        let above_zero = [
            ("motion.range_sigma_m", motion.range_sigma_m),
            ("motion.speed_sigma_mps", motion.speed_sigma_mps),
            ("motion.wandering_noise_m2ps", motion.wandering_noise_m2ps),
            ("motion.manoeuvring_noise_m2ps3", motion.manoeuvring_noise_m2ps3),
            ("consistency.limit", consistency.limit),
            ("consistency.limit_turning", consistency.limit_turning),
            ("consistency.turning_rad_per_s", consistency.turning_rad_per_s),
            ("consistency.disagreement_max_s", consistency.disagreement_max_s),
            ("association.gate", association.gate),
            ("association.silent_max_s", association.silent_max_s),
        ];
        let not_negative = [
            ("motion.evidence_min", motion.evidence_min),
            ("association.frequency_tolerance_hz", association.frequency_tolerance_hz),
            ("association.rate_max_rad_per_s", association.rate_max_rad_per_s),
        ];
        Fault::not_above_zero(&above_zero)
            .or_else(|| Fault::negative(&not_negative))
            .or_else(|| Fault::outside("emitters_max", self.emitters_max as f64, 1.0, EMITTERS_MAX as f64))
            .or_else(|| self.selection.fault())
    }
}

/// A setting that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Which.
    pub key: &'static str,
    /// Its value, and what it must be.
    pub what: String,
}

impl std::fmt::Display for Fault {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}: {}", self.key, self.what)
    }
}

impl std::error::Error for Fault {}

impl Fault {
    pub(crate) fn not_above_zero(values: &[(&'static str, f64)]) -> Option<Self> {
        let bad = values.iter().find(|(_, value)| !(value.is_finite() && *value > 0.0));
        bad.map(|(key, value)| Self {
            key,
            what: format!("{value} is not usable; it must be greater than 0"),
        })
    }

    pub(crate) fn negative(values: &[(&'static str, f64)]) -> Option<Self> {
        let bad = values.iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0));
        bad.map(|(key, value)| Self {
            key,
            what: format!("{value} is not usable; it must be 0 or greater"),
        })
    }

    fn outside(key: &'static str, value: f64, low: f64, high: f64) -> Option<Self> {
        // Written so that what is no number is outside.
        (!(low..=high).contains(&value)).then(|| Self {
            key,
            what: format!("{value} is out of range; it must lie between {low} and {high}"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_sound_and_faults_name_key_value_and_limit() {
        assert_eq!(Settings::default().fault(), None);
        let mut settings = Settings::default();
        settings.motion.range_sigma_m = f64::NAN;
        assert_eq!(
            settings.fault().unwrap().to_string(),
            "motion.range_sigma_m: NaN is not usable; it must be greater than 0"
        );
        let settings = Settings {
            emitters_max: 0,
            ..Settings::default()
        };
        assert_eq!(
            settings.fault().unwrap().to_string(),
            "emitters_max: 0 is out of range; it must lie between 1 and 100000"
        );
    }
}

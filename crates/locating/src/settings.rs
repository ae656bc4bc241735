//! The locator's settings.

use settings::Degrees;

use crate::selection::SelectionSettings;

settings::settings! {
    /// How emitters are located.
    #[derive(Copy)]
    pub struct Settings {
        /// Most emitters at a time: 20 kB each.
        emitters_max: usize = 1024, in [1, 100_000];
        /// How emitters may move (EL-2).
        motion: MotionSettings = MotionSettings::default();
        /// Consistency of bearings: those that contradict the others are set aside.
        consistency: ConsistencySettings = ConsistencySettings::default();
        /// Which fixes are used for the output (EL-4 … EL-10).
        selection: SelectionSettings = SelectionSettings::default();
        /// How bearings without emitter id find their emitter (EL-12).
        association: AssociationSettings = AssociationSettings::default();
    }

    /// How emitters may move (EL-2).
    #[derive(Copy)]
    pub struct MotionSettings {
        /// Models that compete: `auto`, a fixed point, straight motion and manoeuvring, and the data decide; `fixed`, a
        /// fixed point and one that wanders; `straight`, straight motion and manoeuvring.
        filter: FilterChoice = FilterChoice::Auto;
        /// Standard deviation of an unknown emitter's position about the platform, along each axis.
        range_sigma_m: f64 = 300e3, in [above 0];
        /// Standard deviation of an unknown emitter's velocity, along each axis.
        speed_sigma_mps: f64 = 30.0, in [above 0];
        /// How fixed points wander in the model that stands by in case that an emitter is no fixed point.
        wandering_noise_m2ps: f64 = 400.0, in [above 0];
        /// Spectral density of accelerations in the model that stands by in case that an emitter does not move
        /// straight.
        manoeuvring_noise_m2ps3: f64 = 0.01, in [above 0];
        /// A fixed point is given up for straight motion when the bearings are so much likelier by it: logarithm of the
        /// Bayes factor, times 2.
        evidence_min: f64 = 20.0, in [from 0];
        /// Number of bearings in a row for which that must hold, and for which its opposite must hold to take the fixed
        /// point up again.
        evidence_bearings: u32 = 16;
    }

    /// Consistency of bearings: those that contradict the others are set aside.
    #[derive(Copy)]
    pub struct ConsistencySettings {
        /// Standard deviations: bearings are set aside when the running sum of their normalised innovations exceeds so
        /// many.
        limit: f64 = 3.5, in [above 0];
        /// The same while the platform turns.
        limit_turning: f64 = 3.0, in [above 0];
        /// Rate of the heading from which on the platform turns.
        turning_deg_per_s: Degrees = Degrees::of_rad(0.02), in [above 0];
        /// Time of disagreement without a turn after which it is the fix that is wrong.
        disagreement_max_s: f64 = 90.0, in [above 0];
        /// Number of bearings that must disagree besides.
        disagreement_bearings: u32 = 40;
    }

    /// Association of bearings without emitter id with emitters.
    #[derive(Copy)]
    pub struct AssociationSettings {
        /// Difference up to which two frequencies may be of one emitter.
        frequency_tolerance_hz: f64 = 10e3, in [from 0];
        /// Gate of a bearing of an emitter, standard deviations from the expected bearing.
        gate: f64 = 4.0, in [above 0];
        /// How fast the bearing of an emitter without a fix may change.
        rate_max_deg_per_s: Degrees = Degrees::of_rad(0.02), in [from 0];
        /// Silence after which an emitter may give its place to another.
        silent_max_s: f64 = 600.0, in [above 0];
    }
}

settings::words! {
    /// Models that compete for an emitter.
    pub enum FilterChoice {
        /// Fixed point, straight motion and manoeuvring: the data decide.
        Auto = "auto",
        /// Fixed point, and one that wanders.
        Fixed = "fixed",
        /// Straight motion, and manoeuvring.
        Straight = "straight",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_sound_and_errors_name_key_value_and_limit() {
        assert_eq!(settings::check(&Settings::default()), Ok(()));
        let mut settings = Settings::default();
        settings.motion.range_sigma_m = f64::NAN;
        assert_eq!(
            settings::check(&settings).unwrap_err().to_string(),
            "motion.range_sigma_m: NaN is out of range; it must be greater than 0"
        );
        let settings = Settings {
            emitters_max: 0,
            ..Settings::default()
        };
        assert_eq!(
            settings::check(&settings).unwrap_err().to_string(),
            "emitters_max: 0 is out of range; it must lie between 1 and 100000"
        );
    }
}

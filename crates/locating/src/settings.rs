//! The locator's settings.

use settings::Degrees;

use crate::selection::SelectionSettings;

settings::settings! {
    /// How emitters are located.
    #[derive(Copy)]
    pub struct Settings {
        /// Greatest number of emitters at a time; each needs 20 kB.
        emitters_max: usize = 1024, in [1, 100_000];
        /// How emitters may move (EL-2).
        motion: EmitterMotionSettings = EmitterMotionSettings::default();
        /// Consistency of bearings: bearings that contradict the others are set aside.
        consistency: ConsistencySettings = ConsistencySettings::default();
        /// Which fixes are used for the output (EL-4 … EL-10).
        selection: SelectionSettings = SelectionSettings::default();
        /// How bearings without emitter id find their emitter (EL-12).
        association: BearingAssociationSettings = BearingAssociationSettings::default();
    }

    /// How emitters may move (EL-2).
    #[derive(Copy)]
    pub struct EmitterMotionSettings {
        /// Competing models: `auto`, a fixed point, straight motion and manoeuvring, chosen by the data; `fixed`, a
        /// fixed and a wandering point; `straight`, straight motion and manoeuvring.
        filter: FilterChoice = FilterChoice::Auto;
        /// Standard deviation of an unknown emitter's position about the platform, along each axis.
        range_sigma_m: f64 = 300e3, in [above 0];
        /// Standard deviation of an unknown emitter's velocity, along each axis.
        speed_sigma_mps: f64 = 30.0, in [above 0];
        /// Growth of the variance of position in the model of a wandering point, the alternative to the fixed point.
        wandering_noise_m2ps: f64 = 400.0, in [above 0];
        /// Spectral density of accelerations in the model of manoeuvring, the alternative to straight motion.
        manoeuvring_noise_m2ps3: f64 = 0.01, in [above 0];
        /// Evidence at which straight motion replaces a fixed point: twice the logarithm of the Bayes factor.
        evidence_min: f64 = 20.0, in [from 0];
        /// Number of successive bearings with this evidence before the change. As many with the opposite evidence
        /// restore the fixed point.
        evidence_bearings: u32 = 16;
    }

    /// An emitter that the platform dropped: its first place is known.
    #[derive(Copy)]
    pub struct DroppedEmitter {
        /// Number of the emitter in the bearings.
        emitter_id: u32;
        /// Time of the drop, since midnight (UTC); the day is the one nearest to the emitter's first bearing.
        time_s: f64, in [0, 86400];
        /// Place of the drop, east and north in the system frame.
        position_m: [f64; 2], in [-1e9, 1e9];
        /// Standard deviation of the place, along each axis.
        sigma_m: f64 = 50.0, in [above 0];
    }

    /// Consistency of bearings: bearings that contradict the others are set aside.
    #[derive(Copy)]
    pub struct ConsistencySettings {
        /// Limit of the running sum of normalised innovations, in standard deviations; beyond the limit, bearings are
        /// set aside.
        limit: f64 = 3.5, in [above 0];
        /// The same limit while the platform turns.
        limit_turning: f64 = 3.0, in [above 0];
        /// Rate of change of the heading from which on the platform counts as turning.
        turning_deg_per_s: Degrees = Degrees::of_rad(0.02), in [above 0];
        /// Duration of disagreement without a turn after which the fix counts as wrong, and its filter restarts.
        disagreement_max_s: f64 = 90.0, in [above 0];
        /// Least number of disagreeing bearings for this restart.
        disagreement_bearings: u32 = 40;
    }

    /// Association of bearings without emitter id with emitters.
    #[derive(Copy)]
    pub struct BearingAssociationSettings {
        /// Greatest difference between two frequencies of the same emitter.
        frequency_tolerance_hz: f64 = 10e3, in [from 0];
        /// Gate: greatest difference between an emitter's bearing and the expected bearing, in standard deviations.
        gate: f64 = 4.0, in [above 0];
        /// Greatest rate of change of the bearing of an emitter without a fix.
        rate_max_deg_per_s: Degrees = Degrees::of_rad(0.02), in [from 0];
        /// Time without bearings after which a new emitter may replace an emitter in a full table.
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

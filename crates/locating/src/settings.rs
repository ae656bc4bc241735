//! The locator's settings.

use settings::Degrees;

use crate::selection::SelectionSettings;

settings::settings! {
    /// How emitters are located.
    #[derive(Copy)]
    pub struct Settings {
        /// Greatest number of emitters at a time; each needs 28 kB.
        emitters_max: usize = 1024, in [1, 100_000];
        /// Standard deviation of bearings that state none: those of ASTERIX (category 205).
        bearing_sigma_deg: Degrees = Degrees::of(2.0), in [1e-3, 57];
        /// How emitters may move (EL-2).
        motion: EmitterMotionSettings = EmitterMotionSettings::default();
        /// Consistency of bearings: bearings that contradict the others are set aside.
        consistency: ConsistencySettings = ConsistencySettings::default();
        /// Which fixes are used for the output (EL-4 … EL-10).
        selection: SelectionSettings = SelectionSettings::default();
        /// How bearings without emitter id find their emitter (EL-12).
        association: BearingAssociationSettings = BearingAssociationSettings::default();
        /// Arrival times of transmissions at receivers.
        arrivals: ArrivalSettings = ArrivalSettings::default();
    }

    /// How emitters may move (EL-2).
    #[derive(Copy)]
    pub struct EmitterMotionSettings {
        /// Competing models: `auto`, a fixed point, straight motion and manoeuvring, mixed by the data; `fixed`, a
        /// fixed and a wandering point; `straight`, straight motion and manoeuvring; `none`, as `auto`, but ready-made
        /// fixes pass to the selection as they are.
        filter: FilterChoice = FilterChoice::Auto;
        /// Standard deviation of an unknown emitter's position about the platform, along each axis.
        range_sigma_m: f64 = 300e3, in [above 0];
        /// Standard deviation of a moving emitter's velocity, along each axis, as long as the bearings do not show a
        /// greater velocity. The stated errors of emitters that are much faster are too small at first.
        slow_sigma_mps: Option<f64> = None, in [above 0], usually "2; `speed_sigma_mps` if that is above 30";
        /// Greatest standard deviation of a moving emitter's velocity, along each axis.
        speed_sigma_mps: f64 = 30.0, in [above 0];
        /// Standard deviation of the velocity of an emitter that seems fixed but drifts, along each axis; at most half
        /// of `slow_sigma_mps` is used.
        still_sigma_mps: f64 = 0.25, in [above 0];
        /// Probability that an emitter moves, before its first bearing, if the platform is no faster than
        /// `slow_sigma_mps`. The velocity of a moving emitter may be as great as the platform's; the probability that
        /// it is slow falls with the square of the platform's speed.
        moving_probability: f64 = 0.2, in [1e-9, 0.5];
        /// Probability that an emitter drifts with `still_sigma_mps`, likewise.
        drifting_probability: f64 = 0.1, in [1e-9, 0.5];
        /// Growth of the variance of position in the model of a wandering point, the alternative to the fixed point.
        wandering_noise_m2ps: f64 = 400.0, in [above 0];
        /// Spectral density of accelerations in the model of manoeuvring, the alternative to straight motion.
        manoeuvring_noise_m2ps3: f64 = 0.01, in [above 0];
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

/// Greatest standard deviation of the velocity of ships and vehicles, most of which are slow.
const SURFACE_SIGMA_MPS: f64 = 30.0;
/// Standard deviation of the velocity of slow ships.
const SLOW_SIGMA_MPS: f64 = 2.0;

impl EmitterMotionSettings {
    /// Standard deviation of a moving emitter's velocity before the bearings show a greater one, metres per second. Few
    /// aircraft are slow: where `speed_sigma_mps` permits aircraft, slow emitters are not expected.
    pub(crate) fn slow_mps(&self) -> f64 {
        let usual_mps = match self.speed_sigma_mps > SURFACE_SIGMA_MPS {
            true => self.speed_sigma_mps,
            false => SLOW_SIGMA_MPS,
        };
        self.slow_sigma_mps.unwrap_or(usual_mps).min(self.speed_sigma_mps)
    }
}

settings::settings! {
    /// Arrival times of transmissions at receivers.
    #[derive(Copy)]
    pub struct ArrivalSettings {
        /// Speed of propagation.
        propagation_mps: f64 = 299_792_458.0, in [above 0];
        /// Greatest difference between the times (`time_s`) of two arrivals of one transmission.
        together_max_s: f64 = 0.001, in [from 0];
        /// Clocks of the receivers: `exact`; `estimated` from reference emitters; `auto`, exact until a reference
        /// emitter is received.
        clocks: ClockChoice = ClockChoice::Auto;
        /// Standard deviation of the unknown drift between two clocks, seconds per second.
        drift_sigma: f64 = 1e-5, in [above 0];
        /// Growth of the drift's standard deviation in one second; it grows with the root of the time.
        drift_noise_per_root_s: f64 = 1e-12, in [from 0];
        /// Height of emitters in the system frame; the receivers' distances are inclined to it.
        emitter_height_m: f64 = 0.0, in [-100e3, 100e3];
    }
}

settings::words! {
    /// Assumptions on the receivers' clocks.
    pub enum ClockChoice {
        /// Exact until a reference emitter is received, then estimated.
        Auto = "auto",
        /// Exact; reference emitters are not used.
        Exact = "exact",
        /// Estimated; arrivals before the first estimates are not used.
        Estimated = "estimated",
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
        /// Ready-made fixes are selected as they are; other measurements as with `auto`.
        None = "none",
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

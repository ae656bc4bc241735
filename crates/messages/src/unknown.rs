//! What a report leaves unknown, what stands in its place, and when an estimate that began so becomes known.
//!
//! Reports come through many doors: samples in shared memory, lines of text, tables, radio links. At every door a value
//! is unknown if its bit of [`SensorTrack::valid`] is not set, or if its variance is 0: no sensor knows a value
//! exactly, so a variance of 0 is a field that nobody filled in. A value of 0 with a variance is known, and is 0. Each
//! component is judged by itself: a velocity may be known towards the north alone.
//!
//! An unknown value taken for 0 would be believed the more, the more often it is repeated: a ship at 10 m/s would stand
//! still. In its place stands a mean of 0 with the variance of what targets do, which the next positions outweigh.

use crate::{AXES, Covariance, STATE_LEN, SensorTrack, sensor_track_bits as bits};

/// Standard deviation of a velocity that is not known, along each horizontal axis, metres per second.
pub const UNKNOWN_VELOCITY_SIGMA_MPS: f64 = 100.0;
/// Standard deviation of a rate of climb that is not known, metres per second.
pub const UNKNOWN_CLIMB_SIGMA_MPS: f64 = 20.0;
/// Standard deviation of a height that is not known, metres.
pub const UNKNOWN_HEIGHT_SIGMA_M: f64 = 5000.0;

/// Part of the variance of an unknown value below which an estimate is known: half of it came from measurements.
const KNOWN: f64 = 0.5;
/// Bits that must be set for the components of a state to be known.
const BITS: [u16; STATE_LEN] = [0, 0, bits::HEIGHT, bits::VELOCITY, bits::VELOCITY, bits::VERTICAL_RATE];
/// Components of the vertical.
const UP: usize = 2;
const CLIMB: usize = 5;

const fn squared(value: f64) -> f64 {
    value * value
}

/// Variance that stands in place of an unknown component; a position has none.
const VARIANCES: [f64; STATE_LEN] = [
    0.0,
    0.0,
    squared(UNKNOWN_HEIGHT_SIGMA_M),
    squared(UNKNOWN_VELOCITY_SIGMA_MPS),
    squared(UNKNOWN_VELOCITY_SIGMA_MPS),
    squared(UNKNOWN_CLIMB_SIGMA_MPS),
];

impl SensorTrack {
    /// Whether the report states a component of the state (0 to 5: position, then velocity).
    #[inline]
    pub fn states(&self, component: usize) -> bool {
        self.has(BITS[component]) && self.covariance.get(component, component) != 0.0
    }

    /// Whether the report has the trace of its covariance in place of the covariance.
    #[inline]
    pub fn gives_trace(&self) -> bool {
        self.covariance.upper[0] == 0.0 && self.has(bits::TRACE)
    }

    /// Whether the report has what stands in place of an unknown velocity, along one axis at least: it shows nothing of
    /// its source.
    #[inline]
    pub fn has_assumed_velocity(&self) -> bool {
        let is_assumed = |component: usize| self.covariance.get(component, component) == VARIANCES[component];
        !self.has(bits::VELOCITY) && (is_assumed(AXES) || is_assumed(AXES + 1))
    }

    /// Whether a component is unknown, and does not have what stands in its place. Without a height nothing looks at
    /// the vertical: there, any variance above 0 will do.
    #[inline]
    fn lacks(&self, component: usize) -> bool {
        let variance = self.covariance.get(component, component);
        let is_vertical = component == UP || component == CLIMB;
        match is_vertical && !self.has(bits::HEIGHT) {
            true => variance == 0.0,
            false => {
                // A source may know better how fast its targets can be, as long as it does not claim to know the
                // velocity.
                let stands = || {
                    let is_velocity = component >= AXES;
                    let is_wide = variance >= KNOWN * VARIANCES[component];
                    is_velocity && is_wide && self.velocity_mps[component - AXES] == 0.0
                };
                !self.states(component) && !stands()
            }
        }
    }

    /// Whether the report leaves something unknown that does not already have what stands in its place.
    #[inline]
    pub fn is_incomplete(&self) -> bool {
        // Most reports state everything, or all but the vertical.
        let needed = match self.has(bits::HEIGHT) {
            true => bits::VELOCITY | bits::VERTICAL_RATE,
            false => bits::VELOCITY,
        };
        let is_stated = |component: usize| self.covariance.get(component, component) != 0.0;
        let states_all = (0..STATE_LEN).fold(true, |all, component| all & is_stated(component));
        !(states_all && self.valid & needed == needed) && self.lacks_any()
    }

    #[inline(never)]
    fn lacks_any(&self) -> bool {
        (0..STATE_LEN).any(|component| self.lacks(component))
    }

    /// Returns the report with what stands in place of its unknown components, which are no longer correlated with
    /// others. `position_m2` has the variances per axis of a position whose own are 0, m²; an axis without one keeps
    /// its 0. A velocity that is known along one axis alone keeps that axis; its bit means both.
    pub fn completed(&self, position_m2: [Option<f64>; 2]) -> Self {
        let mut report = *self;
        for component in 0..STATE_LEN {
            if !self.lacks(component) {
                continue;
            }
            for other in 0..STATE_LEN {
                report.covariance.set(component, other, 0.0);
            }
            let variance = match position_m2.get(component) {
                Some(position_m2) => position_m2.unwrap_or_default(),
                None => VARIANCES[component].max(self.covariance.get(component, component)),
            };
            report.covariance.set(component, component, variance);
            report.valid &= !BITS[component];
            match component {
                UP => report.position_m[UP] = 0.0,
                AXES.. => report.velocity_mps[component - AXES] = 0.0,
                _ => {}
            }
        }
        report
    }
}

impl Covariance {
    /// Whether the horizontal velocity is known: measurements have halved the variance of an unknown one.
    #[inline]
    pub fn knows_velocity(&self) -> bool {
        let [east, north] = [self.get(AXES, AXES), self.get(AXES + 1, AXES + 1)];
        // Written so that NaN is unknown.
        east + north < 2.0 * KNOWN * squared(UNKNOWN_VELOCITY_SIGMA_MPS)
    }

    /// Whether the rate of climb is known.
    #[inline]
    pub fn knows_climb(&self) -> bool {
        self.get(CLIMB, CLIMB) < KNOWN * squared(UNKNOWN_CLIMB_SIGMA_MPS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: u16 = bits::HEIGHT | bits::VELOCITY | bits::VERTICAL_RATE;

    fn full() -> SensorTrack {
        let mut covariance = Covariance::diagonal([10.0, 20.0, 30.0], [1.0, 2.0, 3.0]);
        for row in 0..STATE_LEN {
            for column in row + 1..STATE_LEN {
                covariance.set(row, column, 0.25);
            }
        }
        SensorTrack {
            valid: ALL,
            position_m: [1e3, 2e3, 3e3],
            velocity_mps: [0.0, 5.0, -2.0],
            covariance,
            ..SensorTrack::default()
        }
    }

    #[test]
    fn what_is_stated_stays_also_if_it_is_zero() {
        let report = full();
        assert!(!report.is_incomplete());
        assert_eq!(report.completed([None; 2]), report);
    }

    #[test]
    fn each_component_is_unknown_by_itself() {
        for component in 0..STATE_LEN {
            let mut report = full();
            report.covariance.set(component, component, 0.0);
            assert!(report.is_incomplete(), "{component}");
            let completed = report.completed([Some(900.0); 2]);
            for row in 0..STATE_LEN {
                for column in row..STATE_LEN {
                    let expected = match (row == component || column == component, row == column) {
                        (false, _) => report.covariance.get(row, column),
                        (true, false) => 0.0,
                        (true, true) if component < 2 => 900.0,
                        (true, true) => VARIANCES[component],
                    };
                    assert_eq!(
                        completed.covariance.get(row, column),
                        expected,
                        "{component}: {row} {column}"
                    );
                }
            }
            assert_eq!(completed.valid, ALL & !BITS[component], "{component}");
        }
        let mut nowhere = full();
        nowhere.covariance.set(0, 0, 0.0);
        assert_eq!(
            nowhere.completed([None; 2]).covariance.get(0, 0),
            0.0,
            "nothing is known"
        );
    }

    #[test]
    fn an_unset_bit_means_unknown_whatever_the_variance_says() {
        // What nothing looks at stays.
        for (bit, unknown) in [
            (bits::HEIGHT, &[][..]),
            (bits::VELOCITY, &[3_usize, 4]),
            (bits::VERTICAL_RATE, &[5]),
        ] {
            let report = SensorTrack {
                valid: ALL & !bit,
                ..full()
            };
            let completed = report.completed([None; 2]);
            for (component, assumed) in VARIANCES.into_iter().enumerate() {
                let expected = match unknown.contains(&component) {
                    true => assumed,
                    false => report.covariance.get(component, component),
                };
                let variance = completed.covariance.get(component, component);
                assert_eq!(variance, expected, "{bit}: {component}");
            }
            assert!(!completed.is_incomplete(), "{bit}");
        }
    }

    #[test]
    fn a_velocity_that_claims_no_knowledge_stays() {
        let mut report = full();
        report.valid &= !(bits::VELOCITY | bits::VERTICAL_RATE);
        report.velocity_mps = [0.0; AXES];
        (AXES..STATE_LEN).for_each(|component| report.covariance.set(component, component, 250.0 * 250.0));
        assert!(!report.is_incomplete() && !report.has_assumed_velocity());
        report.covariance.set(5, 5, 15.0 * 15.0);
        assert!(!report.is_incomplete());
        // A value that nobody states does not.
        report.velocity_mps[0] = 80.0;
        let completed = report.completed([None; 2]);
        assert_eq!(
            (completed.velocity_mps[0], completed.covariance.get(3, 3)),
            (0.0, 250.0 * 250.0)
        );
        report.covariance.set(3, 3, 4.0);
        assert!(report.completed([None; 2]).has_assumed_velocity());
    }

    #[test]
    fn an_estimate_is_known_once_measurements_have_halved_the_variance() {
        let of = |velocity: f64, climb: f64| Covariance::diagonal([1.0; 3], [velocity, velocity, climb]);
        assert!(!of(UNKNOWN_VELOCITY_SIGMA_MPS, 1.0).knows_velocity());
        assert!(of(70.0, 1.0).knows_velocity() && !of(71.0, 1.0).knows_velocity());
        assert!(!of(1.0, UNKNOWN_CLIMB_SIGMA_MPS).knows_climb() && of(1.0, 14.0).knows_climb());
        assert!(!of(f64::NAN, f64::NAN).knows_velocity() && !of(f64::NAN, f64::NAN).knows_climb());
    }
}

//! Distributions of errors, by phase.

use serde::Serialize;
use serde::ser::SerializeMap;

use crate::statistics::{mean, quantile, root_mean};

use super::phases::MOVEMENT_PHASES;
use super::samples::ErrorSample;

/// 95 % of the chi-square distribution with one and two degrees of freedom, per degree.
const CHI_SQUARE_95: [f64; 6] = [5.991 / 2.0, 5.991 / 2.0, 3.841, 3.841, 5.991 / 2.0, 3.841];

/// Distribution of one error; `None` without values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ErrorSpread {
    /// Number of values.
    pub n: u64,
    /// Mean with its sign: a systematic error.
    pub mean: Option<f64>,
    /// Root mean square.
    pub rms: Option<f64>,
    /// Size that half of the errors do not exceed.
    pub p50: Option<f64>,
    /// The same for 90 %.
    pub p90: Option<f64>,
    /// The same for 95 %.
    pub p95: Option<f64>,
    /// The same for 99 %.
    pub p99: Option<f64>,
}

impl ErrorSpread {
    pub(crate) fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.collect();
        let squares: Vec<f64> = values.iter().map(|value| value * value).collect();
        let mean = mean(&values);
        values.iter_mut().for_each(|value| *value = value.abs());
        let mut at = |share| quantile(&mut values, share);
        let [p50, p90, p95, p99] = [0.5, 0.9, 0.95, 0.99].map(&mut at);
        Self {
            n: squares.len() as u64,
            mean,
            rms: root_mean(&squares),
            p50,
            p90,
            p95,
            p99,
        }
    }
}

/// Consistency of one group of a covariance; `None` without covariances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SpreadConsistency {
    /// Number of errors with a usable covariance.
    pub n: u64,
    /// Mean normalised square per degree of freedom: 1 is honest, above 1 too confident, below 1 too timid.
    pub nees: Option<f64>,
    /// Share of the errors within the 95 % region of the covariance.
    pub in95: Option<f64>,
}

impl SpreadConsistency {
    fn of(samples: &[&ErrorSample], group: usize) -> Self {
        let squares: Vec<f64> = samples.iter().filter_map(|sample| sample.normalised[group]).collect();
        let inside = squares.iter().filter(|square| **square < CHI_SQUARE_95[group]).count();
        Self {
            n: squares.len() as u64,
            nees: mean(&squares),
            in95: (!squares.is_empty()).then(|| inside as f64 / squares.len() as f64),
        }
    }
}

/// Consistency of all groups of a covariance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct GroupConsistency {
    /// Position in the plane.
    pub position: SpreadConsistency,
    /// Velocity in the plane.
    pub velocity: SpreadConsistency,
    /// Height.
    pub height: SpreadConsistency,
    /// Rate of climb.
    pub climb: SpreadConsistency,
    /// Velocity in the plane, by the covariance of straight flight where this is the likelier case.
    pub likeliest_velocity: SpreadConsistency,
    /// Rate of climb, by the variance of a constant rate where this is the likelier case.
    pub likeliest_climb: SpreadConsistency,
}

/// Errors of one phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PhaseFigures {
    /// Number of target-seconds with a track.
    pub n: u64,
    /// Position in the plane, metres.
    pub position: ErrorSpread,
    /// Along the target's course, metres.
    pub along: ErrorSpread,
    /// Across the course, to the right, metres.
    pub across: ErrorSpread,
    /// Course, degrees, of targets faster than 3 m/s.
    pub heading_deg: ErrorSpread,
    /// Speed in the plane, m/s.
    pub speed: ErrorSpread,
    /// Velocity vector in the plane, m/s.
    pub velocity: ErrorSpread,
    /// Height, metres.
    pub height: ErrorSpread,
    /// Rate of climb, m/s.
    pub climb: ErrorSpread,
    /// Consistency of the covariances.
    pub consistency: GroupConsistency,
}

impl PhaseFigures {
    pub(crate) fn of(samples: &[&ErrorSample]) -> Self {
        let spread =
            |value: fn(&ErrorSample) -> Option<f64>| ErrorSpread::of(samples.iter().filter_map(|sample| value(sample)));
        Self {
            n: samples.len() as u64,
            position: spread(|sample| Some(sample.position_m)),
            along: spread(|sample| Some(sample.along_across_m?[0])),
            across: spread(|sample| Some(sample.along_across_m?[1])),
            heading_deg: spread(|sample| sample.heading_deg),
            speed: spread(|sample| sample.speed_mps),
            velocity: spread(|sample| sample.velocity_mps),
            height: spread(|sample| sample.height_m),
            climb: spread(|sample| sample.climb_mps),
            consistency: GroupConsistency {
                position: SpreadConsistency::of(samples, 0),
                velocity: SpreadConsistency::of(samples, 1),
                height: SpreadConsistency::of(samples, 2),
                climb: SpreadConsistency::of(samples, 3),
                likeliest_velocity: SpreadConsistency::of(samples, 4),
                likeliest_climb: SpreadConsistency::of(samples, 5),
            },
        }
    }
}

/// Errors of all phases, in the order of [`MOVEMENT_PHASES`]; in JSON by name.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseTable(pub [PhaseFigures; MOVEMENT_PHASES.len()]);

impl PhaseTable {
    pub(crate) fn of(samples: &[&ErrorSample]) -> Self {
        Self(std::array::from_fn(|phase| {
            let in_phase: Vec<&ErrorSample> = samples
                .iter()
                .filter(|sample| sample.phases.has(phase))
                .copied()
                .collect();
            PhaseFigures::of(&in_phase)
        }))
    }

    /// Returns the figures of the phase with this name.
    pub fn named(&self, name: &str) -> Option<&PhaseFigures> {
        let place = MOVEMENT_PHASES.iter().position(|phase| phase.name == name)?;
        Some(&self.0[place])
    }
}

impl Serialize for PhaseTable {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (phase, figures) in MOVEMENT_PHASES.iter().zip(&self.0) {
            map.serialize_entry(phase.name, figures)?;
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distribution_by_hand() {
        // Sizes 1, 2, 3, 4, 10; squares 130; sum 4 − 1 + 2 − 3 − 10.
        let found = ErrorSpread::of([4.0, -1.0, 2.0, -3.0, -10.0].into_iter());
        assert_eq!((found.n, found.mean, found.p50), (5, Some(-1.6), Some(3.0)));
        assert_eq!(found.rms, Some(26f64.sqrt()));
        // Place 0.9·4 = 3.6 between 4 and 10; 3.8; 3.96.
        for (figure, expected) in [(found.p90, 7.6), (found.p95, 8.8), (found.p99, 9.76)] {
            assert!((figure.unwrap() - expected).abs() < 1e-12, "{figure:?}");
        }
        assert_eq!(ErrorSpread::of([].into_iter()), ErrorSpread::default());
    }
}

//! A stretch of a trajectory in the order of time: measurements without the errors of their sources, and wanted times.

use messages::{AXES, NS_PER_S};
use source_models::Measurement;

use super::knowledge::Knowledge;
use crate::update::filter_input::FilterInput;

/// Standard deviation of the initial velocity, beside the variance stated in the first report, m/s.
const BEGINNING_MPS: f64 = 150.0;
/// Factor on the stated variance of the first report's velocity: later measurements are more accurate.
const BEGINNING: f64 = 25.0;

/// Event at a time: a measurement, a wanted state, or both.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    /// Time, nanoseconds.
    pub(super) time_ns: i64,
    /// Time since the moment before, seconds.
    pub(super) passed_s: f64,
    /// Measurements.
    pub(super) measurements: (usize, usize),
    pub(super) is_wanted: bool,
}

/// A stretch of a trajectory between two beginnings.
#[derive(Debug)]
pub(super) struct Stretch {
    pub(super) moments: Vec<Moment>,
    pub(super) measurements: Vec<Measurement>,
    /// Velocity at the first measurement, m/s, and its variances, m²/s².
    pub(super) velocity_mps: [f64; AXES],
    pub(super) velocity_m2ps2: [f64; AXES],
}

impl Stretch {
    /// Measurements of inputs without the sources' errors, and the times of events. The inputs are in the order of
    /// time. The stretch begins at `from_ns`, else with its first input.
    pub(super) fn new(known: &impl Knowledge, inputs: &[FilterInput], wanted_ns: &[i64], from_ns: Option<i64>) -> Self {
        let first = inputs.first();
        let mut stretch = Self {
            moments: Vec::with_capacity(inputs.len() + wanted_ns.len()),
            measurements: inputs.iter().map(|input| corrected(known, input)).collect(),
            velocity_mps: first.map_or([0.0; AXES], |first| first.velocity_mps),
            velocity_m2ps2: first
                .map_or([0.0; AXES], |first| first.velocity_m2ps2)
                .map(|variance| BEGINNING * variance.max(0.0) + BEGINNING_MPS * BEGINNING_MPS),
        };
        let begin_ns = from_ns.or(first.map(|first| first.time_ns)).unwrap_or_default();
        let (mut at_ns, mut next, mut wanted) = (begin_ns, 0, wanted_ns.iter().copied().peekable());
        while next < inputs.len() || wanted.peek().is_some() {
            let measured_ns = inputs.get(next).map_or(i64::MAX, |input| input.time_ns);
            let time_ns = measured_ns.min(wanted.peek().copied().unwrap_or(i64::MAX));
            let begin = next;
            while inputs.get(next).is_some_and(|input| input.time_ns == time_ns) {
                next += 1;
            }
            stretch.moments.push(Moment {
                time_ns,
                passed_s: (time_ns - at_ns) as f64 / NS_PER_S,
                measurements: (begin, next),
                is_wanted: wanted.next_if_eq(&time_ns).is_some(),
            });
            at_ns = time_ns;
        }
        stretch
    }

    /// Number of moments up to `until_ns`.
    pub(super) fn moments_until(&self, until_ns: i64) -> usize {
        self.moments.partition_point(|moment| moment.time_ns <= until_ns)
    }

    /// Measurements of a moment.
    pub(super) fn measured(&self, moment: &Moment) -> &[Measurement] {
        let (begin, end) = moment.measurements;
        &self.measurements[begin..end]
    }
}

/// The measurement of an input without the errors of its source.
fn corrected(known: &impl Knowledge, input: &FilterInput) -> Measurement {
    let mut measurement = Measurement {
        position_m: input.position_m,
        covariance_m2: input.covariance_m2,
        axes: if input.has_height { AXES } else { 2 },
        has_waited: false,
    };
    measurement.correct(&known.correction(input));
    measurement.refer(input.point_m, input.point_m2);
    measurement
}

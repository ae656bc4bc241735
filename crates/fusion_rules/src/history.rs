//! The last N reports of each sensor track, and the resulting residual V (TI-4 … TI-6).
//!
//! The accuracy of a track is estimated from the track alone: its latest report (the *first position*) and each of up
//! to N earlier reports (the *second positions*) are moved to a common reference time, each with its own velocity.
//! For an accurate track all positions agree; the distance between the first position and the mean of the second
//! positions is the residual V.

use messages::{SensorTrack, sensor_track_bits};
use serde::{Deserialize, Serialize};

use crate::places::{self, TablePlace};
use crate::settings::ResidualKind;

/// The stored part of a report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct StoredReport {
    time_ns: i64,
    position_m: [f64; 3],
    velocity_mps: [f64; 3],
}

impl TablePlace for StoredReport {
    fn is_taken(&self) -> bool {
        *self != Self::default()
    }

    fn free() -> Self {
        Self::default()
    }
}

impl StoredReport {
    fn position_at(&self, time_ns: i64) -> [f64; 3] {
        moved(self.position_m, self.velocity_mps, time_ns - self.time_ns)
    }
}

/// `position` moved along `velocity` for `ns` nanoseconds.
#[inline]
pub fn moved(position_m: [f64; 3], velocity_mps: [f64; 3], ns: i64) -> [f64; 3] {
    let seconds = ns as f64 / messages::NS_PER_S;
    std::array::from_fn(|axis| position_m[axis] + velocity_mps[axis] * seconds)
}

/// Rings of the last N reports, one per sensor-track slot, allocated at once.
#[derive(Debug, Serialize, Deserialize)]
pub struct Histories {
    #[serde(with = "places")]
    stored: Vec<StoredReport>,
    heads: Vec<RingHead>,
    length: usize,
    /// Weight of an earlier report relative to the next newer one; 1 gives the plain mean (TI-5).
    recency: f64,
}

/// Size of a ring of `length` reports, octets.
pub fn bytes_per_track(length: usize) -> usize {
    length * size_of::<StoredReport>() + size_of::<RingHead>()
}

/// State of a ring.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct RingHead {
    newest: usize,
    count: usize,
    /// Measured minus predicted position of the newest report, if measured.
    innovation: Option<[f64; 3]>,
    /// First minus mean second position at the newest report's time, metres, and the growth of this difference, metres
    /// per second: computed once for all reference times. `None` without an earlier report.
    apart: Option<([f64; 3], [f64; 3])>,
}

impl Histories {
    /// Empty histories of `slots` sensor tracks, each of `length` reports; see `RuleSettings::recency`.
    pub fn new(slots: usize, length: usize, recency: f64) -> Self {
        Self {
            stored: vec![StoredReport::default(); slots * length],
            heads: vec![RingHead::default(); slots],
            length,
            recency,
        }
    }

    /// Clears the reports of a sensor track.
    pub fn clear(&mut self, slot: usize) {
        self.heads[slot] = RingHead::default();
    }

    /// Adds a report of a sensor track in place of the oldest.
    #[inline]
    pub fn push(&mut self, slot: usize, report: &SensorTrack) {
        let innovation = self.innovation_of(slot, report);
        let head = &mut self.heads[slot];
        head.innovation = innovation;
        head.newest = if head.count == 0 {
            0
        } else {
            (head.newest + 1) % self.length
        };
        head.count = (head.count + 1).min(self.length);
        self.stored[slot * self.length + head.newest] = StoredReport {
            time_ns: report.time_of_measurement_ns,
            position_m: report.position_m,
            velocity_mps: report.velocity_mps,
        };
        self.heads[slot].apart = self.apart(slot);
    }

    /// See [`RingHead::apart`].
    fn apart(&self, slot: usize) -> Option<([f64; 3], [f64; 3])> {
        let first = self.nth(slot, 0)?;
        let (mut places, mut velocities, mut total, mut weight) = ([0.0; 3], [0.0; 3], 0.0, 1.0);
        let mut back = 1;
        while let Some(earlier) = self.nth(slot, back) {
            let second = earlier.position_at(first.time_ns);
            for axis in 0..3 {
                places[axis] += weight * second[axis];
                velocities[axis] += weight * earlier.velocity_mps[axis];
            }
            total += weight;
            weight *= self.recency;
            back += 1;
        }
        let minus_mean = |first: [f64; 3], sum: [f64; 3]| std::array::from_fn(|axis| first[axis] - sum[axis] / total);
        (back > 1).then(|| {
            (
                minus_mean(first.position_m, places),
                minus_mean(first.velocity_mps, velocities),
            )
        })
    }

    /// Measured minus predicted: the prediction is the previous report's, along its velocity.
    fn innovation_of(&self, slot: usize, report: &SensorTrack) -> Option<[f64; 3]> {
        if !report.has(sensor_track_bits::MEASURED) {
            return None;
        }
        let predicted = self.nth(slot, 0)?.position_at(report.time_of_measurement_ns);
        Some(std::array::from_fn(|axis| report.measured_m[axis] - predicted[axis]))
    }

    /// The report `back` places before the newest.
    fn nth(&self, slot: usize, back: usize) -> Option<&StoredReport> {
        let head = &self.heads[slot];
        if back >= head.count {
            return None;
        }
        let index = (head.newest + self.length - back) % self.length;
        Some(&self.stored[slot * self.length + index])
    }

    /// Position and velocity at `time_ns` between the reports before and after (QF-6); `None` without such reports.
    #[inline]
    pub fn interpolated(&self, slot: usize, time_ns: i64) -> Option<([f64; 3], [f64; 3])> {
        let earlier = (1..self.length).find(|back| self.nth(slot, *back).is_some_and(|r| r.time_ns <= time_ns))?;
        let (before, after) = (self.nth(slot, earlier)?, self.nth(slot, earlier - 1)?);
        let span_ns = after.time_ns - before.time_ns;
        if span_ns <= 0 || after.time_ns < time_ns {
            return None;
        }
        let part = (time_ns - before.time_ns) as f64 / span_ns as f64;
        let between = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|axis| a[axis] + part * (b[axis] - a[axis]));
        Some((
            between(before.position_m, after.position_m),
            between(before.velocity_mps, after.velocity_mps),
        ))
    }

    /// V per axis at the reference time, signed; `None` without an earlier report (TI-10).
    #[inline]
    pub fn residual(&self, slot: usize, kind: ResidualKind, reference_ns: i64) -> Option<[f64; 3]> {
        let head = &self.heads[slot];
        let (apart_m, apart_mps) = head.apart?;
        let position = || {
            let newest_ns = self.stored[slot * self.length + head.newest].time_ns;
            moved(apart_m, apart_mps, reference_ns - newest_ns)
        };
        Some(match kind {
            ResidualKind::Innovation => head.innovation.unwrap_or_else(position),
            ResidualKind::Velocity => apart_mps,
            ResidualKind::Position | ResidualKind::PerAxis => position(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use test_support::S;

    fn report(time_s: i64, x: f64, vx: f64) -> SensorTrack {
        SensorTrack {
            time_of_measurement_ns: time_s * S,
            position_m: [x, 0.0, 0.0],
            velocity_mps: [vx, 0.0, 0.0],
            ..SensorTrack::default()
        }
    }

    #[test]
    fn a_track_that_predicts_itself_has_no_residual() {
        let mut histories = Histories::new(2, 4, 1.0);
        for time in 0..10 {
            histories.push(1, &report(time, 10.0 * time as f64, 10.0));
        }
        let v = histories.residual(1, ResidualKind::Position, 12 * S).unwrap();
        assert!(v[0].abs() < 1e-9);
        assert_eq!(histories.residual(0, ResidualKind::Position, 12 * S), None);
    }

    #[test]
    fn the_residual_is_first_minus_mean_of_second_positions() {
        let mut histories = Histories::new(1, 3, 1.0);
        let mut newer_count_more = Histories::new(1, 3, 0.5);
        // Moved to t = 4: 0 + 4·1 = 4 (dropped: only three are kept), 6 + 3·2 = 12, 10 + 2·0 = 10, first 20 + 1·5 =
        // 25.
        for (time, x, vx) in [(0, 0.0, 1.0), (1, 6.0, 2.0), (2, 10.0, 0.0), (3, 20.0, 5.0)] {
            histories.push(0, &report(time, x, vx));
            newer_count_more.push(0, &report(time, x, vx));
        }
        let plain = histories.residual(0, ResidualKind::Position, 4 * S).unwrap();
        assert!((plain[0] - (25.0 - 11.0)).abs() < 1e-12);
        // Newer reports count more: weights 1 and 1/2 on 10 and 12.
        let weighted = newer_count_more.residual(0, ResidualKind::Position, 4 * S).unwrap();
        assert!((weighted[0] - (25.0 - (10.0 + 0.5 * 12.0) / 1.5)).abs() < 1e-12);
        let velocity = histories.residual(0, ResidualKind::Velocity, 4 * S).unwrap();
        assert!((velocity[0] - (5.0 - 1.0)).abs() < 1e-12);
    }

    #[test]
    fn an_innovation_needs_a_measurement() {
        let mut histories = Histories::new(1, 3, 1.0);
        histories.push(0, &report(0, 0.0, 10.0));
        let mut second = report(1, 11.0, 10.0);
        second.valid |= sensor_track_bits::MEASURED;
        second.measured_m = [13.0, 0.0, 0.0];
        histories.push(0, &second);
        assert_eq!(
            histories.residual(0, ResidualKind::Innovation, S),
            Some([3.0, 0.0, 0.0])
        );
        histories.push(0, &report(2, 21.0, 10.0));
        let v = histories.residual(0, ResidualKind::Innovation, 2 * S).unwrap();
        assert!(
            (v[0] - (21.0 - 20.5)).abs() < 1e-12,
            "falls back to the position residual"
        );
    }

    #[test]
    fn a_time_between_two_reports_is_interpolated_and_no_other() {
        let mut histories = Histories::new(1, 3, 1.0);
        for (time, x, vx) in [(0, 0.0, 1.0), (4, 8.0, 3.0), (8, 40.0, 5.0)] {
            histories.push(0, &report(time, x, vx));
        }
        let (position, velocity) = histories.interpolated(0, 5 * S).unwrap();
        assert!((position[0] - 16.0).abs() < 1e-12 && (velocity[0] - 3.5).abs() < 1e-12);
        assert_eq!(histories.interpolated(0, 4 * S).unwrap().0[0], 8.0);
        assert_eq!(histories.interpolated(0, -1), None);
        assert_eq!(histories.interpolated(0, 9 * S), None);
    }
}

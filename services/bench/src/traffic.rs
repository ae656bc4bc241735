//! Reports sent by the bench: targets on a grid, all moving, each observed by every source in turn.
//!
//! The grid is wide (3 km; 2 km for a million targets) and the targets fly nearly in parallel. Each report therefore
//! belongs to one system track without ambiguity, and yields one state. The measurement covers the processing itself,
//! not a traffic situation. Every second source reports the targets' addresses; reports of the other sources are
//! associated by position.
//!
//! The parts of a report that do not change are built in advance; time and position are set before sending.

use messages::{Covariance, Identity, SensorTrack, StageTimes, TrackState, sensor_track_bits as bits};

const SPACING_M: f64 = 3_000.0;
/// Greatest length of a side of the grid, metres: its corners, and the ways flown, lie within [`RANGE_M`].
const SIDE_MAX_M: f64 = 2_000_000.0;
/// Range of the sources, metres.
pub(crate) const RANGE_M: f64 = 2_000_000.0;
/// Eastward offset of each source's positions relative to the previous source, metres.
const SOURCE_SHIFT_M: f64 = 8.0;

/// Builder of reports.
#[derive(Debug)]
pub(crate) struct Traffic {
    /// Report templates, one for each target, at time 0.
    targets: Vec<SensorTrack>,
    sources: u64,
    batch: u64,
    /// Monotonic time at which the targets are on their grid.
    origin_ns: i64,
    /// UTC minus monotonic time.
    utc_offset_ns: i64,
}

impl Traffic {
    /// Creates the traffic of `targets` observed by `sources`; a batch is `batch` reports of one source, and the
    /// sources take turns.
    pub(crate) fn new(targets: u32, sources: u16, batch: usize, origin_ns: i64, utc_offset_ns: i64) -> Self {
        let side = f64::from(targets).sqrt().ceil() as u32;
        let target = |number: u32| {
            let (column, row) = (f64::from(number % side), f64::from(number / side));
            let middle = f64::from(side) / 2.0;
            let spacing_m = SPACING_M.min(SIDE_MAX_M / f64::from(side));
            SensorTrack {
                track_number: number + 1,
                valid: bits::VELOCITY | bits::HEIGHT,
                identity: Identity::default().with_address(number + 1),
                position_m: [spacing_m * (column - middle), spacing_m * (row - middle), 5_000.0],
                velocity_mps: [100.0 + column % 7.0, row % 11.0 - 5.0, 0.0],
                covariance: Covariance::diagonal([15.0, 15.0, 30.0], [3.0; 3]),
                state: TrackState::Confirmed as u8,
                ..SensorTrack::default()
            }
        };
        Self {
            targets: (0..targets).map(target).collect(),
            sources: u64::from(sources),
            batch: batch as u64,
            origin_ns,
            utc_offset_ns,
        }
    }

    /// Sets another batch size for the same targets.
    pub(crate) fn set_batch(&mut self, batch: usize) {
        self.batch = batch as u64;
    }

    pub(crate) fn batch(&self) -> usize {
        self.batch as usize
    }

    /// Returns the number of batches until every source has reported every target.
    pub(crate) fn round(&self) -> u64 {
        // Each source needs as many whole batches: its last batch may reach into the next round.
        (self.targets.len() as u64).div_ceil(self.batch) * self.sources
    }

    pub(crate) fn sources(&self) -> u64 {
        self.sources
    }

    /// Returns the source of batch number `batch`.
    pub(crate) fn source(&self, batch: u64) -> u16 {
        (batch % self.sources) as u16
    }

    /// Returns UTC at the monotonic time `mono_ns`.
    pub(crate) fn utc_ns(&self, mono_ns: i64) -> i64 {
        mono_ns + self.utc_offset_ns
    }

    /// Returns report number `index` of batch number `batch` of `source`, due at `due_ns`; without stamps.
    pub(crate) fn report(&self, source: u16, batch: u64, index: usize, due_ns: i64) -> SensorTrack {
        let round = batch / self.sources;
        let target = (round * self.batch + index as u64) % self.targets.len() as u64;
        let mut report = self.targets[target as usize];
        let seconds = (due_ns - self.origin_ns) as f64 * 1e-9;
        report.time_of_measurement_ns = self.utc_ns(due_ns);
        report.source = source;
        report.position_m[0] += report.velocity_mps[0] * seconds + SOURCE_SHIFT_M * f64::from(source);
        report.position_m[1] += report.velocity_mps[1] * seconds;
        if source % 2 == 1 {
            report.identity = Identity::default();
        }
        report
    }
}

/// Returns the stamps of a report that was due at `due_ns` and is published at `published_ns`.
pub(crate) fn stamps(due_ns: i64, published_ns: i64) -> StageTimes {
    StageTimes {
        ingested_ns: due_ns,
        published_ns,
        ..StageTimes::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_source_reports_every_target_in_a_round() {
        for batch in [1, 4, 7, 64] {
            let traffic = Traffic::new(28, 4, batch, 0, 5);
            let mut seen = std::collections::BTreeSet::new();
            for number in 0..traffic.round() {
                for index in 0..batch {
                    let report = traffic.report(traffic.source(number), number, index, 1_000_000_000);
                    assert!(
                        seen.insert((report.source, report.track_number)) || batch == 64,
                        "{batch}"
                    );
                    assert_eq!(report.time_of_measurement_ns, 1_000_000_005);
                }
            }
            assert_eq!(seen.len(), 28 * 4, "{batch}");
        }
    }

    #[test]
    fn all_targets_lie_within_the_range_of_the_sources() {
        for targets in [1, 1000, 100_000, 1_000_000] {
            let traffic = Traffic::new(targets, 4, 1, 0, 0);
            let distance_m = |target: &SensorTrack| target.position_m[0].hypot(target.position_m[1]);
            let farthest_m = traffic.targets.iter().map(distance_m).fold(0.0, f64::max);
            // An hour of flight is left.
            assert!(farthest_m + 106.0 * 3600.0 < RANGE_M, "{targets}: {farthest_m}");
        }
    }

    #[test]
    fn targets_move_with_their_velocities_and_stay_apart() {
        let traffic = Traffic::new(400, 2, 1, 0, 0);
        let at = |target: u64, seconds: i64| traffic.report(0, 2 * target, 0, seconds * 1_000_000_000);
        let (before, after) = (at(17, 0), at(17, 10));
        assert_eq!(
            after.position_m[0] - before.position_m[0],
            10.0 * before.velocity_mps[0]
        );
        for first in 0..400 {
            for second in 0..first {
                let (a, b) = (at(first, 120).position_m, at(second, 120).position_m);
                assert!((a[0] - b[0]).hypot(a[1] - b[1]) > 1_000.0);
            }
        }
    }
}

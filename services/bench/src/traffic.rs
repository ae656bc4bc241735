//! Reports sent by the bench: targets on a grid, all moving, each observed by every source in turn.
//!
//! The grid is wide (3 km; 2 km for a million targets) and the targets fly nearly in parallel. Each report therefore
//! belongs to one system track without ambiguity, and yields one state. The measurement covers the processing itself,
//! not a traffic situation. Every second source reports the targets' addresses; reports of the other sources are
//! associated by position.
//!
//! Positions and velocities have independent noise that fits the stated covariance, from source, target and round: the
//! same in each run. Any number of sources therefore agrees as well as it states, and no report is far off.
//!
//! The parts of a report that do not change are built in advance; time and state are set before sending.

use messages::{Covariance, Identity, SensorTrack, StageTimes, TrackState, sensor_track_bits as bits};

const SPACING_M: f64 = 3_000.0;
/// Greatest length of a side of the grid, metres: its corners, and the ways flown, lie within [`RANGE_M`].
const SIDE_MAX_M: f64 = 2_000_000.0;
/// Range of the sources, metres.
pub(crate) const RANGE_M: f64 = 2_000_000.0;
/// Standard deviations of the noise: positions, metres, and velocities, metres per second.
const POSITION_SIGMA_M: [f64; 3] = [15.0, 15.0, 30.0];
const VELOCITY_SIGMA_MPS: f64 = 3.0;

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
                valid: bits::VELOCITY | bits::HEIGHT | bits::VERTICAL_RATE,
                identity: Identity::default().with_address(number + 1),
                position_m: [spacing_m * (column - middle), spacing_m * (row - middle), 5_000.0],
                velocity_mps: [100.0 + column % 7.0, row % 11.0 - 5.0, 0.0],
                covariance: Covariance::diagonal(POSITION_SIGMA_M, [VELOCITY_SIGMA_MPS; 3]),
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
        let number = round * self.batch + index as u64;
        let (target, scan) = (number % self.targets.len() as u64, number / self.targets.len() as u64);
        let mut report = self.targets[target as usize];
        let seconds = (due_ns - self.origin_ns) as f64 * 1e-9;
        report.time_of_measurement_ns = self.utc_ns(due_ns);
        report.source = source;
        let mut words = Words::of(source, target, scan);
        for (axis, sigma_m) in POSITION_SIGMA_M.into_iter().enumerate() {
            report.position_m[axis] += report.velocity_mps[axis] * seconds + sigma_m * words.noise();
        }
        for velocity_mps in &mut report.velocity_mps {
            *velocity_mps += VELOCITY_SIGMA_MPS * words.noise();
        }
        if source % 2 == 1 {
            report.identity = Identity::default();
        }
        report
    }
}

/// Words without pattern, for the noise of one report: splitmix64.
#[derive(Debug)]
struct Words(u64);

impl Words {
    fn of(source: u16, target: u64, scan: u64) -> Self {
        let mut words = Self(u64::from(source) << 52 ^ target << 26 ^ scan);
        // Reports with neighbouring numbers would share most of their words.
        words.0 = words.word();
        words
    }

    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ mixed >> 31
    }

    /// Noise of variance 1, at most 3.5: the sum of four uniform numbers, the quarters of a word. One word for each,
    /// because reports are made beside what is measured.
    fn noise(&mut self) -> f64 {
        /// Standard deviation of the sum of four uniform integers of 16 bits.
        const SIGMA: f64 = 37_837.227_237_2;
        let word = self.word();
        let sum: u64 = (0..4).map(|quarter| word >> (16 * quarter) & 0xffff).sum();
        (sum as f64 - 2.0 * 65_535.0) / SIGMA
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
        // The noise of both is the same, and goes out.
        let velocity_mps = traffic.targets[17].velocity_mps[0];
        assert!((after.position_m[0] - before.position_m[0] - 10.0 * velocity_mps).abs() < 1e-6);
        for first in 0..400 {
            for second in 0..first {
                let (a, b) = (at(first, 120).position_m, at(second, 120).position_m);
                assert!((a[0] - b[0]).hypot(a[1] - b[1]) > 1_000.0);
            }
        }
    }

    /// Normalised errors of all reports of 64 sources on 50 targets in 30 scans, position and velocity, by report.
    fn errors(traffic: &Traffic) -> Vec<[f64; 6]> {
        let mut errors = Vec::new();
        for batch in 0..64 * 50 * 30 {
            let report = traffic.report(traffic.source(batch), batch, 0, 0);
            let exact = &traffic.targets[report.track_number as usize - 1];
            errors.push(std::array::from_fn(|component| {
                let axis = component % 3;
                let error = match component {
                    0..3 => report.position_m[axis] - exact.position_m[axis],
                    _ => report.velocity_mps[axis] - exact.velocity_mps[axis],
                };
                error / report.covariance.get(component, component).sqrt()
            }));
        }
        errors
    }

    #[test]
    fn noise_fits_the_covariance_and_is_independent_of_source_target_scan_and_axis() {
        let traffic = Traffic::new(50, 64, 1, 0, 0);
        let errors = errors(&traffic);
        let count = errors.len() as f64;
        let mean = |of: &dyn Fn(usize) -> f64, until: usize| (0..until).map(of).sum::<f64>() / until as f64;
        for one in 0..6 {
            let middle = mean(&|index| errors[index][one], errors.len());
            let variance = mean(&|index| errors[index][one] * errors[index][one], errors.len());
            let fourth = mean(&|index| errors[index][one].powi(4), errors.len());
            // Five standard deviations of the estimates; the fourth moment of a sum of four uniform numbers is 2.7.
            assert!(middle.abs() < 5.0 / count.sqrt(), "{one}: {middle}");
            assert!((variance - 1.0).abs() < 5.0 * (1.7 / count).sqrt(), "{one}: {variance}");
            assert!((fourth - 2.7).abs() < 0.1, "{one}: {fourth}");
            for other in 0..one {
                let both = mean(&|index| errors[index][one] * errors[index][other], errors.len());
                assert!(both.abs() < 5.0 / count.sqrt(), "{one}, {other}: {both}");
            }
            // The next source, target and scan.
            for step in [1, 64, 64 * 50] {
                let until = errors.len() - step;
                let both = mean(&|index| errors[index][one] * errors[index + step][one], until);
                assert!(both.abs() < 5.0 / (until as f64).sqrt(), "{one}, after {step}: {both}");
            }
        }
    }

    #[test]
    fn no_source_is_shifted() {
        let traffic = Traffic::new(50, 64, 1, 0, 0);
        let errors = errors(&traffic);
        for source in 0..64 {
            for component in 0..6 {
                let of_source = errors.iter().skip(source).step_by(64);
                let middle = of_source.map(|error| error[component]).sum::<f64>() / 1500.0;
                assert!(middle.abs() < 5.0 / 1500.0_f64.sqrt(), "{source}: {middle}");
            }
        }
    }

    #[test]
    fn the_same_report_has_the_same_noise_in_each_run() {
        let made = |batch: usize| Traffic::new(28, 4, batch, 0, 0);
        let (one, again) = (made(7), made(7));
        let report = |traffic: &Traffic| traffic.report(2, 18, 3, 5_000_000_000);
        assert_eq!(report(&one).position_m, report(&again).position_m);
        // Neither does it depend on the length of batches: report 31 of source 2 in both.
        let single = made(1).report(2, 31 * 4 + 2, 0, 5_000_000_000);
        assert_eq!(report(&one).position_m, single.position_m);
    }
}

//! Coverage and probability of detection of each source, from the system tracks since the start of the display.
//!
//! Each source has a grid in polar coordinates about its site: sectors of five degrees, rings of 10 km. A cell counts
//!
//! - **seen**: reports of the source that contributed to a confirmed track there;
//! - **tries** and **hits**: reports that the source owed for a track that another source followed at that time, and
//!   those that came. Their ratio is the probability of detection, including the association.
//!
//! A report after a pause of n periods counts as one hit and n − 1 misses; a source that stops following a track owes
//! a report per period. The period is the median of the differences between the source's reports, at least the
//! configured one. A silent source owes nothing: an outage is not a lack of coverage.
//!
//! Targets on the ground count for nothing: radars for the air do not see them. Targets that no other source follows
//! give no tries. The probability thus holds for targets that the other sources see, as in the evaluation of radars
//! against opportunity traffic (EUROCONTROL, *Standard document for radar surveillance in en-route airspace and major
//! terminal areas*, 1997).

use std::f64::consts::TAU;

use messages::{SystemTrack, TrackState, contribution_bits};
use rustc_hash::FxHashMap;

/// Sectors of a grid.
pub(crate) const SECTORS: usize = 72;
/// Rings of a grid.
const RINGS: usize = 60;
/// Width of a ring, metres.
pub(crate) const RING_M: f64 = 10_000.0;
/// Time between two looks at one track, nanoseconds.
const LOOK_NS: i64 = 1_000_000_000;
/// Periods without a report after which a source owes one, and the most it owes at once.
const OWED_PERIODS: f64 = 2.5;
const OWED_MAX: f64 = 10.0;
/// Silence of a source that ends its debts, nanoseconds, at least this number of periods.
const SILENT_NS: i64 = 10_000_000_000;
const SILENT_PERIODS: i64 = 5;
/// Maximum number of tracks.
const TRACKS_MAX: usize = 50_000;
/// Step of the median of periods, relative.
const MEDIAN_GAIN: f64 = 0.01;
/// Tries from which a cell has a probability.
const TRIES_MIN: f32 = 5.0;

/// Counts of one cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cell {
    pub(crate) seen: f32,
    pub(crate) hits: f32,
    pub(crate) tries: f32,
}

impl Cell {
    /// Returns the probability of detection in [0, 1]; `None` for too few tries.
    pub(crate) fn probability(&self) -> Option<f32> {
        (self.tries >= TRIES_MIN).then(|| (self.hits / self.tries).min(1.0))
    }
}

/// Grid of one source.
#[derive(Clone, Debug)]
struct SourceGrid {
    site_m: [f64; 2],
    cells: Vec<Cell>,
    period_ns: f64,
    period_min_ns: f64,
    /// Time of the latest report, UTC, nanoseconds.
    heard_ns: i64,
}

/// Coverage of all sources, see the module's documentation.
#[derive(Debug, Default)]
pub(crate) struct Coverage {
    sources: Vec<SourceGrid>,
    tracks: FxHashMap<u32, Followed>,
    /// Time of the first look, UTC, nanoseconds.
    pub(crate) since_ns: Option<i64>,
}

/// Reports of each source for one track, counted up to a time.
#[derive(Clone, Debug, Default)]
struct Followed {
    looked_ns: i64,
    /// Source, and time up to which its reports are counted, UTC, nanoseconds.
    counted: Vec<(u16, i64)>,
}

impl Coverage {
    /// Creates empty grids of sources with these sites (metres east and north; `None`: the origin) and periods.
    pub(crate) fn new(sources: impl Iterator<Item = (Option<[f64; 2]>, i64)>) -> Self {
        Self {
            sources: sources
                .map(|(site_m, period_ns)| SourceGrid::new(site_m, period_ns))
                .collect(),
            ..Self::default()
        }
    }

    /// Adds grids up to those of these sources, given by number and period.
    pub(crate) fn make_room(&mut self, sources: impl Iterator<Item = (u16, i64)>) {
        for (number, period_ns) in sources {
            while self.sources.len() <= usize::from(number) {
                self.sources.push(SourceGrid::new(None, period_ns));
            }
        }
    }

    /// Takes a state of a system track.
    pub(crate) fn take(&mut self, track: &SystemTrack) {
        let at_ns = track.reference_time_ns;
        if TrackState::is_off(track.state) {
            self.tracks.remove(&track.track_number);
            return;
        }
        if track.state != TrackState::Confirmed as u8 || track.on_ground != 0 {
            return;
        }
        if !self.tracks.contains_key(&track.track_number) && self.tracks.len() >= TRACKS_MAX {
            return;
        }
        let known = self.tracks.entry(track.track_number).or_default();
        if (0..LOOK_NS).contains(&at_ns.saturating_sub(known.looked_ns)) {
            return;
        }
        known.looked_ns = at_ns;
        self.since_ns.get_or_insert(at_ns);
        let fresh = |source: u16| {
            let parts = track.contributions().iter();
            parts.filter(move |part| part.source == source && part.flags & contribution_bits::FRESH != 0)
        };
        let sources = track.contributions().iter();
        let followers = sources.filter(|part| part.flags & contribution_bits::FRESH != 0);
        let followers: Vec<u16> = followers.map(|part| part.source).collect();
        for (number, grid) in (0_u16..).zip(&mut self.sources) {
            let latest_ns = fresh(number).map(|part| part.time_of_measurement_ns).max();
            let has_other = followers.iter().any(|follower| *follower != number);
            let place = known.counted.iter().position(|(source, _)| *source == number);
            let Some(place) = place else {
                // The first look at this track: nothing was owed before.
                known.counted.push((number, latest_ns.unwrap_or(at_ns)));
                grid.heard_ns = grid.heard_ns.max(latest_ns.unwrap_or(i64::MIN));
                continue;
            };
            let counted_ns = &mut known.counted[place].1;
            grid.count(counted_ns, latest_ns, at_ns, track.position_m, has_other);
        }
    }

    /// Drops tracks that were not looked at since `oldest_ns`.
    pub(crate) fn forget_before(&mut self, oldest_ns: i64) {
        self.tracks.retain(|_, known| known.looked_ns >= oldest_ns);
    }

    /// Returns the cells of a source that have counts: sector, ring, counts.
    pub(crate) fn cells(&self, source: usize) -> impl Iterator<Item = (usize, usize, &Cell)> {
        let cells = self.sources.get(source).map_or(&[][..], |grid| grid.cells.as_slice());
        let placed = cells.iter().enumerate();
        placed
            .filter(|(_, cell)| cell.seen > 0.0 || cell.tries > 0.0)
            .map(|(place, cell)| (place / RINGS, place % RINGS, cell))
    }
}

impl SourceGrid {
    fn new(site_m: Option<[f64; 2]>, period_ns: i64) -> Self {
        Self {
            site_m: site_m.unwrap_or_default(),
            cells: vec![Cell::default(); SECTORS * RINGS],
            period_ns: period_ns.max(1) as f64,
            period_min_ns: period_ns.max(1) as f64,
            heard_ns: i64::MIN,
        }
    }

    /// Counts what came and what was owed for a track at `position_m` and `at_ns`, since `counted_ns`.
    fn count(
        &mut self,
        counted_ns: &mut i64,
        latest_ns: Option<i64>,
        at_ns: i64,
        position_m: [f64; 3],
        has_other: bool,
    ) {
        let (hits, owed) = match latest_ns.filter(|latest_ns| *latest_ns > *counted_ns) {
            Some(latest_ns) => {
                let passed_ns = latest_ns.saturating_sub(*counted_ns) as f64;
                let step = if passed_ns > self.period_ns {
                    MEDIAN_GAIN
                } else {
                    -MEDIAN_GAIN
                };
                self.period_ns = (self.period_ns * (1.0 + step)).max(self.period_min_ns);
                self.heard_ns = self.heard_ns.max(latest_ns);
                *counted_ns = latest_ns;
                (1.0, (passed_ns / self.period_ns).round().clamp(1.0, OWED_MAX))
            }
            None => {
                let passed = at_ns.saturating_sub(*counted_ns) as f64 / self.period_ns;
                if passed < OWED_PERIODS {
                    return;
                }
                let owed = (passed.floor() - 1.0).min(OWED_MAX);
                // One report may still come. After a long pause the rest is not owed.
                let counted_next_ns = counted_ns.saturating_add((owed * self.period_ns) as i64);
                *counted_ns = counted_next_ns.max(at_ns.saturating_sub(2 * self.period_ns as i64));
                let silent_ns = SILENT_NS.max(SILENT_PERIODS * self.period_ns as i64);
                let is_silent = at_ns.saturating_sub(self.heard_ns) > silent_ns;
                (0.0, if is_silent { 0.0 } else { owed })
            }
        };
        let Some(cell) = self.cell(position_m) else { return };
        cell.seen += hits;
        if has_other {
            cell.hits += hits;
            cell.tries += owed as f32;
        }
    }

    fn cell(&mut self, position_m: [f64; 3]) -> Option<&mut Cell> {
        let [east, north] = [0, 1].map(|axis| position_m[axis] - self.site_m[axis]);
        let sector = (east.atan2(north).rem_euclid(TAU) / TAU * SECTORS as f64) as usize % SECTORS;
        let ring = (east.hypot(north) / RING_M) as usize;
        (ring < RINGS).then(|| &mut self.cells[sector * RINGS + ring])
    }
}

#[cfg(test)]
mod tests {
    use messages::Contribution;
    use test_support::S;

    use super::*;

    /// State of track 1, 25 km north, with the latest reports of these sources, seconds.
    fn state(second: i64, reports: &[(u16, i64)]) -> SystemTrack {
        let mut track = SystemTrack {
            track_number: 1,
            reference_time_ns: second * S,
            position_m: [100.0, 25_000.0, 0.0],
            state: TrackState::Confirmed as u8,
            contribution_count: reports.len() as u16,
            ..SystemTrack::default()
        };
        for (part, (source, at)) in track.contributions.iter_mut().zip(reports) {
            *part = Contribution {
                source: *source,
                time_of_measurement_ns: at * S,
                flags: contribution_bits::FRESH,
                ..Contribution::default()
            };
        }
        track
    }

    fn two_sources() -> Coverage {
        Coverage::new([(None, S), (None, 4 * S)].into_iter())
    }

    #[test]
    fn a_radar_that_misses_one_turn_in_four_has_a_probability_of_three_quarters() {
        let mut coverage = two_sources();
        for second in 0..1_600 {
            let turn = second / 4;
            let heard = if turn % 4 == 3 { turn - 1 } else { turn };
            coverage.take(&state(second, &[(0, second), (1, 4 * heard)]));
        }
        let cells: Vec<_> = coverage.cells(1).collect();
        let (sector, ring, cell) = cells[0];
        assert_eq!((cells.len(), sector, ring), (1, 0, 2));
        assert!((cell.probability().unwrap() - 0.75).abs() < 0.01, "{cell:?}");
        let (.., other) = coverage.cells(0).next().unwrap();
        assert_eq!(other.probability(), Some(1.0));
    }

    #[test]
    fn a_source_that_never_sees_owes_each_period_but_not_while_it_is_silent() {
        let mut coverage = two_sources();
        // Source 1 sees another target, so that it is not silent.
        for second in 0..400 {
            coverage.take(&state(second, &[(0, second)]));
            let other = SystemTrack {
                track_number: 2,
                position_m: [-5_000.0, 0.0, 0.0],
                ..state(second, &[(1, second / 4 * 4)])
            };
            coverage.take(&other);
        }
        let blind: Cell = *coverage.cells(1).find(|(sector, ..)| *sector == 0).unwrap().2;
        assert_eq!(blind.probability(), Some(0.0));
        assert!((90.0..=100.0).contains(&blind.tries), "{blind:?}");
        let alone: Cell = *coverage.cells(1).find(|(sector, ..)| *sector != 0).unwrap().2;
        assert!(
            alone.seen > 90.0 && alone.tries == 0.0,
            "no other source follows: {alone:?}"
        );
        for second in 400..800 {
            coverage.take(&state(second, &[(0, second)]));
        }
        let after = coverage.cells(1).find(|(sector, ..)| *sector == 0).unwrap().2;
        assert!(after.tries - blind.tries <= 6.0, "{after:?}");
    }

    #[test]
    fn a_source_that_was_never_heard_owes_nothing() {
        let mut coverage = two_sources();
        for second in 0..100 {
            coverage.take(&state(second, &[(0, second)]));
        }
        assert_eq!(coverage.cells(1).count(), 0);
    }

    #[test]
    fn times_of_any_value_are_taken() {
        let mut coverage = two_sources();
        let extremes = [i64::MIN, -1, 0, i64::MAX];
        for (at_ns, report_ns) in extremes.iter().flat_map(|at| extremes.map(|report| (*at, report))) {
            let mut track = state(0, &[(0, 0)]);
            track.reference_time_ns = at_ns;
            track.contributions[0].time_of_measurement_ns = report_ns;
            coverage.take(&track);
        }
        assert!(
            coverage
                .cells(0)
                .all(|(.., cell)| cell.seen.is_finite() && cell.tries.is_finite())
        );
    }

    #[test]
    fn memory_is_that_of_the_grids_and_far_targets_are_ignored() {
        let mut coverage = two_sources();
        for second in 0..10 {
            let far = SystemTrack {
                position_m: [1e6, 1e6, 0.0],
                ..state(second, &[(0, second)])
            };
            coverage.take(&far);
        }
        assert_eq!(coverage.cells(0).count(), 0);
        coverage.forget_before(100 * S);
        assert!(coverage.tracks.is_empty());
        assert_eq!(coverage.sources[0].cells.len(), SECTORS * RINGS);
    }
}

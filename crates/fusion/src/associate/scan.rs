//! Assignment of all new sensor tracks of a scan together (BF-2).
//!
//! A sensor track that belongs to a system track stays there; its reports need no search. Sensor tracks without a
//! system track, and sensor tracks alone on their own system track, compete: a coarse sensor reports two aircraft in
//! formation nearer to each other than its errors, and choosing the nearest system track for each in turn leaves the
//! remainder to the second. Therefore they wait until their scan is complete, a fraction of the source's period, and
//! are assigned together with the smallest sum of statistical distances.

use association::assignment::{Assignment, Pair};
use serde::{Deserialize, Serialize};

use crate::associate::association_step::Search;
use crate::settings::{Settings, SourceSettings};
use crate::tables::sensor_tracks::SensorSlot;
use crate::tables::system_tracks::SystemSlot;
use crate::tables::tracks::Tracks;

/// Most sensor tracks of a source that are assigned at a time; a larger scan is assigned in parts.
const WAITING_MAX: usize = 4096;
/// Most admissible pairs of a scan.
const PAIRS_MAX: usize = 4 * WAITING_MAX;

/// Sensor tracks waiting for the end of their scan, per source, and room for the assignment.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Scans {
    scans: Vec<WaitingScan>,
    /// Time of completion of the first scan, nanoseconds; never (`i64::MAX`) if none waits.
    due_ns: i64,
    #[serde(skip)]
    pairs: Vec<Pair>,
    /// System tracks of the scan being assigned, by column.
    #[serde(skip)]
    columns: Vec<SystemSlot>,
    #[serde(skip, default = "assignment")]
    assignment: Assignment,
    #[serde(skip)]
    assigned: Vec<ScanAssignment>,
}

/// The waiting part of a source's scan.
#[derive(Debug, Serialize, Deserialize)]
struct WaitingScan {
    waiting: Vec<SensorSlot>,
    first_ns: i64,
    /// Time from the first report of the scan to its completion, nanoseconds.
    duration_ns: i64,
}

impl WaitingScan {
    /// Time of completion of the scan; never (`i64::MAX`) if nothing waits.
    fn complete_ns(&self) -> i64 {
        self.first_ns.saturating_add(self.duration_ns)
    }
}

/// A sensor track of a scan that has been assigned.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScanAssignment {
    pub(crate) sensor: SensorSlot,
    /// The system track, and d²; `None` if no system track fits.
    pub(crate) best: Option<(SystemSlot, f64)>,
}

fn assignment() -> Assignment {
    Assignment::new(WAITING_MAX, PAIRS_MAX, PAIRS_MAX)
}

impl Scans {
    pub(crate) fn new(sources: &[SourceSettings], scan_wait: f64) -> Self {
        let scans = sources.iter().map(|_| WaitingScan {
            waiting: Vec::with_capacity(WAITING_MAX),
            first_ns: i64::MAX,
            duration_ns: 0,
        });
        let mut new = Self {
            scans: scans.collect(),
            due_ns: i64::MAX,
            pairs: Vec::with_capacity(PAIRS_MAX),
            columns: Vec::with_capacity(PAIRS_MAX),
            assignment: assignment(),
            assigned: Vec::with_capacity(WAITING_MAX),
        };
        new.follow_periods(sources, scan_wait);
        new
    }

    /// Sets the durations of scans to `scan_wait` of their sources' periods.
    pub(crate) fn follow_periods(&mut self, sources: &[SourceSettings], scan_wait: f64) {
        for (scan, source) in self.scans.iter_mut().zip(sources) {
            scan.duration_ns = (source.period_ns as f64 * scan_wait) as i64;
        }
    }

    /// Time of completion of the first scan, nanoseconds; never (`i64::MAX`) if none waits.
    pub(crate) fn due_ns(&self) -> i64 {
        self.due_ns
    }

    /// Whether no further sensor track of `source` can wait: then its scan has to be assigned.
    pub(crate) fn is_full(&self, source: u16) -> bool {
        self.scans[usize::from(source)].waiting.len() == WAITING_MAX
    }

    /// Queues a sensor track of `source`, seen at `time_ns`, until the end of its scan, which is not full.
    pub(crate) fn wait(&mut self, sensor: SensorSlot, source: u16, time_ns: i64) {
        let scan = &mut self.scans[usize::from(source)];
        scan.waiting.push(sensor);
        scan.first_ns = scan.first_ns.min(time_ns);
        self.due_ns = self.due_ns.min(scan.complete_ns());
    }

    /// Returns a source with a complete scan at `time_ns`, the source with the smallest number; `None` without one.
    pub(crate) fn complete_at(&mut self, time_ns: i64) -> Option<u16> {
        let complete = |scan: &WaitingScan| !scan.waiting.is_empty() && scan.complete_ns() <= time_ns;
        let source = self.scans.iter().position(complete);
        if source.is_none() {
            self.due_ns = self
                .scans
                .iter()
                .map(WaitingScan::complete_ns)
                .min()
                .unwrap_or(i64::MAX);
        }
        source.map(|source| source as u16)
    }

    /// Assigns the scan of `source`, and thereby ends it; returns the number of assigned sensor tracks, available by
    /// [`Self::assigned`].
    pub(crate) fn assign(&mut self, source: u16, settings: &Settings, tracks: &mut Tracks) -> usize {
        let scan = &mut self.scans[usize::from(source)];
        scan.first_ns = i64::MAX;
        self.assigned.clear();
        let unassigned = |sensor: &SensorSlot| ScanAssignment {
            sensor: *sensor,
            best: None,
        };
        self.assigned.extend(scan.waiting.iter().map(unassigned));
        scan.waiting.clear();
        self.find_pairs(&Search { settings, tracks });
        self.number_columns(tracks);
        let (assigned, columns) = (&mut self.assigned, &self.columns);
        self.assignment
            .solve(&self.pairs, settings.association.scan_gate(), |row, column, d2| {
                assigned[row as usize].best = Some((columns[column as usize], d2));
            });
        self.assigned.len()
    }

    /// The sensor track in a row of the latest assigned scan.
    pub(crate) fn assigned(&self, row: usize) -> ScanAssignment {
        self.assigned[row]
    }

    /// Finds all pairs of a waiting sensor track and an admissible system track.
    fn find_pairs(&mut self, search: &Search<'_>) {
        self.pairs.clear();
        for (row, assigned) in self.assigned.iter().enumerate() {
            if !search.tracks.sensors.get(assigned.sensor).waits {
                continue;
            }
            let first = self.pairs.len();
            search.admissible(assigned.sensor, |system, d2| {
                if self.pairs.len() < PAIRS_MAX {
                    self.pairs.push(Pair {
                        row: row as u32,
                        column: system,
                        cost: d2,
                    });
                }
            });
            // A first report has no velocity: it joins only without an alternative, or waits for the second.
            let tracks = search.tracks;
            let is_one_of_several = self.pairs.len() > first + 1 && !tracks.is_established(assigned.sensor);
            let is_first = tracks.sensors.get(assigned.sensor).reports < 2;
            let may_be_another = || self.pairs.len() > first && is_first && search.may_be_renumbered(assigned.sensor);
            if is_one_of_several || may_be_another() {
                self.pairs.truncate(first);
            }
        }
    }

    /// Numbers the system tracks of all pairs in order of occurrence.
    fn number_columns(&mut self, tracks: &mut Tracks) {
        self.columns.clear();
        for pair in &mut self.pairs {
            let entry = tracks.systems.get_mut(pair.column);
            if self.columns.get(entry.column as usize) != Some(&pair.column) {
                entry.column = self.columns.len() as u32;
                self.columns.push(pair.column);
            }
            pair.column = entry.column;
        }
    }
}

//! The live sensor tracks of all sources: latest report, history, and the system track each belongs to.

use estimation::Gaussian;
use messages::SensorTrack;
use rustc_hash::FxHashMap;

use crate::history::Histories;
use crate::quality::Qualities;

/// Place of a sensor track in its table.
pub(crate) type SensorSlot = u32;

/// [`SensorEntry::system`] of a sensor track that belongs to no system track yet.
pub(crate) const NO_SYSTEM: u32 = u32::MAX;

/// What a sensor track is to its system track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// It speaks for its source.
    Primary,
    /// Its source already has a primary there: another part of the same target, or a number not yet taken over.
    Duplicate,
}

/// One live sensor track. What every report of its system track's other members looks at comes first, in one line of the
/// cache.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct SensorEntry {
    /// Time of `latest`, nanoseconds.
    pub(crate) time_ns: i64,
    /// Share in the estimate of the system track's filter.
    pub(crate) share: f64,
    /// Mean innovation of the system track's filter over the last reports (east, north), its variance per axis, and the
    /// number of innovations so far.
    pub(crate) residual_mean_m: [f64; 2],
    pub(crate) residual_variance_m2: f64,
    pub(crate) residuals: u32,
    /// System track it belongs to, or [`NO_SYSTEM`].
    pub(crate) system: u32,
    /// Next sensor track of the same system track.
    pub(crate) next: Option<SensorSlot>,
    /// Source of `latest`.
    pub(crate) source: u16,
    pub(crate) role: Role,
    pub(crate) latest: SensorTrack,
    /// Whether the covariance of `latest` had to be repaired: then its source is not judged by it.
    pub(crate) repaired: bool,
    /// Reports in a row that did not fit the rest of the system track.
    pub(crate) misfits: u32,
    /// Number of another system track that the last reports fitted, and how many in a row.
    pub(crate) rival: Option<(u32, u32)>,
    /// Whether this place of the table is taken.
    live: bool,
    /// Whether it waits for the end of its scan.
    pub(crate) waits: bool,
    /// By how much the source's known errors have been taken off `latest`, metres.
    pub(crate) shift_m: [f64; 3],
    /// By how much the covariance of `latest` was inflated.
    pub(crate) inflation: f64,
    /// Reports so far.
    pub(crate) reports: u32,
    /// Scans in a row without a report.
    pub(crate) misses: u32,
    /// Time of its first report, nanoseconds.
    pub(crate) started_ns: i64,
    /// Where on the target the source sees it.
    pub(crate) point: DetectionPoint,
}

/// Where on a target a sensor track's detection point lies.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DetectionPoint {
    /// Along and across the target's course, from its reference point, metres.
    pub(crate) offset_m: [f64; 2],
    /// Reports from which that was estimated.
    pub(crate) reports: u32,
    /// Whether it is the reference point itself.
    pub(crate) is_reference: bool,
    /// When that was estimated: see `Engine::points_epoch`.
    pub(crate) epoch: u32,
}

impl Default for SensorEntry {
    fn default() -> Self {
        Self {
            time_ns: 0,
            source: 0,
            latest: SensorTrack::default(),
            role: Role::Duplicate,
            system: NO_SYSTEM,
            next: None,
            repaired: false,
            misfits: 0,
            rival: None,
            live: false,
            waits: false,
            shift_m: [0.0; 3],
            inflation: 1.0,
            reports: 0,
            misses: 0,
            started_ns: 0,
            share: 0.0,
            residuals: 0,
            residual_mean_m: [0.0; 2],
            residual_variance_m2: 0.0,
            point: DetectionPoint::default(),
        }
    }
}

impl SensorEntry {
    /// The latest report as the source gave it, nothing taken off.
    pub(crate) fn as_reported(&self) -> Gaussian {
        let mut state = crate::engine::gaussian_of(&self.latest);
        for axis in 0..messages::AXES {
            state.mean[axis] += self.shift_m[axis];
        }
        if self.inflation != 1.0 {
            state.covariance /= self.inflation;
        }
        state
    }

    /// It is about to belong to another system track: what it was to the last one says nothing.
    pub(crate) fn forget_target(&mut self) {
        self.misfits = 0;
        self.rival = None;
        self.share = 0.0;
        self.residuals = 0;
        self.residual_mean_m = [0.0; 2];
        self.residual_variance_m2 = 0.0;
        self.point = DetectionPoint::default();
    }
}

/// The table: preallocated entries, found by source and track number.
#[derive(Debug)]
pub(crate) struct SensorTracks {
    entries: Vec<SensorEntry>,
    free: Vec<SensorSlot>,
    by_number: FxHashMap<(u16, u32), SensorSlot>,
    /// Where the next look for sensor tracks that nobody hears of any more begins.
    swept: usize,
    pub(crate) histories: Histories,
    pub(crate) qualities: Qualities,
}

impl SensorTracks {
    pub(crate) fn new(capacity: usize, stored_reports: usize) -> Self {
        // With room for twice the entries, the map clears its tombstones in place and never grows.
        let by_number = FxHashMap::with_capacity_and_hasher(2 * capacity, rustc_hash::FxBuildHasher);
        Self {
            entries: vec![SensorEntry::default(); capacity],
            free: (0..capacity as SensorSlot).rev().collect(),
            by_number,
            swept: 0,
            histories: Histories::new(capacity, stored_reports + 1),
            qualities: Qualities::new(capacity),
        }
    }

    pub(crate) fn find(&self, source: u16, number: u32) -> Option<SensorSlot> {
        self.by_number.get(&(source, number)).copied()
    }

    /// A new entry for `report`, not yet linked to a system track; `None` if the table is full.
    pub(crate) fn insert(&mut self, report: &SensorTrack) -> Option<SensorSlot> {
        let slot = self.free.pop()?;
        self.by_number.insert((report.source, report.track_number), slot);
        self.histories.clear(slot as usize);
        self.qualities.clear(slot as usize);
        self.entries[slot as usize] = SensorEntry {
            time_ns: report.time_of_measurement_ns,
            source: report.source,
            latest: *report,
            live: true,
            started_ns: report.time_of_measurement_ns,
            ..SensorEntry::default()
        };
        self.histories.push(slot as usize, report);
        Some(slot)
    }

    /// Stores a further report of the sensor track in `slot`.
    pub(crate) fn update(&mut self, slot: SensorSlot, report: &SensorTrack) {
        let entry = &mut self.entries[slot as usize];
        entry.latest = *report;
        entry.time_ns = report.time_of_measurement_ns;
        self.histories.push(slot as usize, report);
    }

    /// Frees `slot`, which no system track may link to any more.
    pub(crate) fn remove(&mut self, slot: SensorSlot) {
        let entry = &mut self.entries[slot as usize];
        entry.waits = false;
        entry.live = false;
        let latest = &entry.latest;
        self.by_number.remove(&(latest.source, latest.track_number));
        self.free.push(slot);
    }

    /// The next part of the table to be looked through for sensor tracks that nobody hears of any more: their sources need
    /// not say that they have ended. Part by part, so that no look takes long.
    pub(crate) fn next_part(&mut self) -> std::ops::Range<SensorSlot> {
        const PARTS: usize = 16;
        let end = (self.swept + self.entries.len() / PARTS + 1).min(self.entries.len());
        let part = self.swept as SensorSlot..end as SensorSlot;
        self.swept = if end == self.entries.len() { 0 } else { end };
        part
    }

    /// Whether `slot` is taken by a sensor track without report since `since_ns`.
    pub(crate) fn is_silent(&self, slot: SensorSlot, since_ns: i64) -> bool {
        let entry = self.get(slot);
        entry.live && entry.time_ns < since_ns
    }

    pub(crate) fn get(&self, slot: SensorSlot) -> &SensorEntry {
        &self.entries[slot as usize]
    }

    pub(crate) fn get_mut(&mut self, slot: SensorSlot) -> &mut SensorEntry {
        &mut self.entries[slot as usize]
    }
}

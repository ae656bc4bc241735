//! The tracks of child hypotheses (HT-3): continued without a detection, updated with a detection, or begun at a
//! detection.
//!
//! Each track is made for the first child that contains the track, and shared by all children that contain the track.

use messages::NS_PER_S;

use crate::counts::TrackerCounts;
use crate::explanation::TrackEvent;
use crate::gating::NONE;
use crate::hypothesis_store::HypothesisStore;
use crate::identity::FAR;
use crate::joined::JoinedClusters;
use crate::life::Deletion;
use crate::limits::{CLUSTER_TRACKS_MAX, PAIRS_MAX};
use crate::motion::TargetMotion;
use crate::population::Population;
use crate::ranked::ROWS_MAX;
use crate::scan_context::ScanContext;
use crate::splitting::mean_motion;
use crate::track::{NO_DETECTION, Track};
use crate::unresolved::SHARED;

/// Place of a track that has not been made yet, or finds no room.
pub(crate) const UNMADE: u32 = u32::MAX;
/// Place of a track that is given up.
pub(crate) const REMOVED: u32 = u32::MAX - 1;

/// Places in the store of the tracks made so far; working memory, reused for each cluster.
#[derive(Clone, Debug)]
pub(crate) struct Branches {
    /// By track before the scan, by pair, by row.
    missed: Vec<u32>,
    updated: Vec<u32>,
    begun: [u32; ROWS_MAX],
    /// By detection of a pair of tracks: both tracks.
    shared: Vec<[u32; 2]>,
    /// (number, reliability) of confirmed tracks.
    numbers: Vec<(u32, f64)>,
    /// Indices of the branches of each number.
    of_number: Vec<u32>,
}

impl Branches {
    pub(crate) fn new(tracks_max: usize) -> Self {
        Self {
            missed: vec![UNMADE; tracks_max],
            updated: vec![UNMADE; 4 * tracks_max + PAIRS_MAX],
            begun: [UNMADE; ROWS_MAX],
            shared: vec![[UNMADE; 2]; 4 * tracks_max],
            numbers: Vec::with_capacity(CLUSTER_TRACKS_MAX),
            of_number: Vec::with_capacity(CLUSTER_TRACKS_MAX),
        }
    }

    /// Forgets the tracks made of these clusters.
    pub(crate) fn clear(&mut self, joined: &JoinedClusters<'_>) {
        self.begun = [UNMADE; ROWS_MAX];
        let shared = joined.scan.unresolved.detections.len();
        self.shared[..shared].fill([UNMADE; 2]);
        for track in joined.tracks() {
            self.missed[track as usize] = UNMADE;
            self.updated[joined.pairs(track)].fill(UNMADE);
        }
    }

    /// The track `number` with a pair, or, for [`NONE`], as the memory track, unless the track has been silent for too
    /// long.
    pub(crate) fn continued(
        &mut self,
        joined: &JoinedClusters<'_>,
        number: u32,
        pair: u32,
        store: &mut HypothesisStore,
        counts: &mut TrackerCounts,
    ) -> u32 {
        if pair == NONE {
            let made = &mut self.missed[number as usize];
            if *made == UNMADE {
                *made = missed_track(joined, number, counts).map_or(REMOVED, |track| kept(store, track));
            }
            return *made;
        }
        if pair & SHARED != 0 {
            let tracks = joined.scan.unresolved.tracks_of(pair);
            let side = usize::from(tracks[1] == number);
            let made = &mut self.shared[(pair & !SHARED) as usize][side];
            if *made == UNMADE {
                let shared = shared_track(joined, number, tracks[1 - side], pair);
                *made = shared.map_or(REMOVED, |track| kept(store, track));
            }
            return *made;
        }
        let made = &mut self.updated[pair as usize];
        if *made == UNMADE {
            *made = updated_track(joined, number, pair, counts).map_or(REMOVED, |track| kept(store, track));
        }
        *made
    }

    /// Stores the track `number` after its update by directions; `None` deletes the track.
    pub(crate) fn keep_directed(&mut self, number: u32, track: Option<Track>, store: &mut HypothesisStore) {
        self.missed[number as usize] = track.map_or(REMOVED, |track| kept(store, track));
    }

    /// Place in the store of a track kept by [`Self::keep_directed`].
    pub(crate) fn directed(&self, number: u32) -> u32 {
        self.missed[number as usize]
    }

    /// The new track that begins at a row's detection.
    pub(crate) fn begun(
        &mut self,
        joined: &JoinedClusters<'_>,
        row: usize,
        store: &mut HypothesisStore,
        next: &mut Population,
        counts: &mut TrackerCounts,
    ) -> u32 {
        if self.begun[row] == UNMADE {
            let departed = || joined.scan.departures.motion(joined.plots[row].1);
            let inherited = self.parents_motion(joined, row).or_else(departed);
            counts.starts_with_parents_motion += u64::from(inherited.is_some());
            let in_company = u32::from(joined.is_in_confirmed_gate(row));
            self.begun[row] = match begin(joined.scan, joined.plots[row].1, inherited, next.next_root) {
                Some(track) => {
                    next.next_root = next.next_root.wrapping_add(1).max(1);
                    kept(store, Track { in_company, ..track })
                }
                None => REMOVED,
            };
        }
        self.begun[row]
    }

    /// SP-2: the motion of the most reliable confirmed track in whose gate the row's detection lies.
    fn parents_motion(&mut self, joined: &JoinedClusters<'_>, row: usize) -> Option<TargetMotion> {
        let scan = joined.scan;
        let branches_max = scan.settings.splitting.parents_motion?;
        let plot = joined.plots[row].1;
        self.numbers.clear();
        self.of_number.clear();
        for place in joined.tracks() {
            let track = &scan.before.tracks[place as usize];
            let mut pairs = scan.gating.pairs[joined.pairs(place)].iter();
            let mut in_gate = || pairs.any(|pair| pair.plot == plot && !pair.is_far);
            if !track.is_confirmed() || !in_gate() {
                continue;
            }
            self.of_number.push(place);
            match self.numbers.iter_mut().find(|(other, _)| *other == track.number) {
                Some((_, reliability)) => *reliability += track.reliability,
                None => self.numbers.push((track.number, track.reliability)),
            }
        }
        let best = self.numbers.iter();
        let (number, _) = best
            .copied()
            .max_by(|one, other| one.1.total_cmp(&other.1).then(other.0.cmp(&one.0)))?;
        let of = |track: &u32| &scan.before.tracks[*track as usize];
        self.of_number.retain(|track| of(track).number == number);
        self.of_number.sort_unstable_by(|one, other| {
            of(other)
                .reliability
                .total_cmp(&of(one).reliability)
                .then(one.cmp(other))
        });
        let time_ns = scan.plots[plot as usize].time_ns;
        let best = self.of_number.iter().take(branches_max).map(of);
        let motion = &scan.settings.motion;
        let mean = mean_motion(best.map(|track| (track.motion_at(time_ns, motion), track.reliability)));
        mean.map(|mean| mean.leaving(motion))
    }
}

fn kept(store: &mut HypothesisStore, track: Track) -> u32 {
    store.add_track(track).unwrap_or(UNMADE)
}

/// Lets the track, which was `number` before the scan, have no detection; `has_plots` if the cluster has any.
pub(crate) fn miss(scan: &ScanContext<'_>, (number, track): (u32, &mut Track), has_plots: bool) {
    let log_miss = scan.gating.log_misses[number as usize];
    track.missed += 1;
    track.absence = scan.gating.absences[number as usize];
    track.log_likelihood_ratio += log_miss;
    track.seen_by &= !scan.sensor.bit;
    // A fast sensor without detections here must not push the open choices of a slow sensor out of the memory.
    if has_plots || scan.sensor.scan_weight >= 1.0 {
        track.remember(NO_DETECTION);
    }
}

/// `None` if the track is deleted.
fn missed_track(joined: &JoinedClusters<'_>, number: u32, counts: &mut TrackerCounts) -> Option<Track> {
    let scan = joined.scan;
    let mut track = scan.before.tracks[number as usize];
    miss(scan, (number, &mut track), !joined.plots.is_empty());
    if joined.support.shows_all() {
        track.absence = scan.before.tracks[number as usize].absence;
    }
    let deletion = &scan.settings.deletion.of(&track, &scan.settings.identity);
    if deletion.is_met(&track, scan.time_ns) {
        explain_end(scan, &track, deletion, TrackEvent::ENDS);
        return None;
    }
    let early = joined.support.deletion();
    if let Some(early) = early.filter(|deletion| deletion.is_met(&track, scan.time_ns)) {
        counts.wide_area_deletions += 1;
        explain_end(scan, &track, &early, TrackEvent::ABSENT_ENDS);
        return None;
    }
    if lacks_company(scan, joined.confirmed, &track) {
        explain_company(scan, &track);
        return None;
    }
    Some(track)
}

/// `None` if the track is deleted.
fn updated_track(joined: &JoinedClusters<'_>, number: u32, pair: u32, counts: &mut TrackerCounts) -> Option<Track> {
    let scan = joined.scan;
    let found = scan.gating.pairs[pair as usize];
    let plot = &scan.plots[found.plot as usize];
    let mut track = scan.before.tracks[number as usize];
    track.motion = track.motion_at(plot.time_ns, &scan.settings.motion);
    if found.is_far {
        track.motion.widen(FAR);
    }
    track.identity.take(&plot.identity);
    // The update cannot fail: the same comparison succeeded before.
    let _ = track.motion.update(&plot.measurement.weighted(scan.sensor.scan_weight));
    (track.time_ns, track.seen_ns) = (plot.time_ns, plot.time_ns);
    (track.missed, track.absence) = (0, 0.0);
    track.detections += 1;
    track.seen_by |= scan.sensor.bit;
    let row = joined.row_of(found.plot) as usize;
    track.in_company += u32::from(joined.is_in_confirmed_gate(row));
    track.log_likelihood_ratio += scan.sensor.log_detection + found.log_likelihood
        - scan.log_clutter[found.plot as usize]
        - joined.shared[row].log_others;
    track.remember(scan.first_serial.wrapping_add(found.plot));
    if lacks_company(scan, joined.confirmed, &track) {
        counts.out_of_company += 1;
        explain_company(scan, &track);
        return None;
    }
    Some(track)
}

/// The track `number` with a detection between it and another track. `None` for the later track of the two without a
/// detection of its own for too long: both may be of the same target.
fn shared_track(joined: &JoinedClusters<'_>, number: u32, other_number: u32, shared: u32) -> Option<Track> {
    let scan = joined.scan;
    let found = scan.unresolved.detections[(shared & !SHARED) as usize];
    let plot = &scan.plots[found.plot as usize];
    let [mut motion, other] = [number, other_number].map(|track| {
        let track = &scan.before.tracks[track as usize];
        track.motion_at(plot.time_ns, &scan.settings.motion)
    });
    let mut track = scan.before.tracks[number as usize];
    let deletion = &scan.settings.deletion.limits;
    let silent_ns = plot.time_ns.saturating_sub(track.seen_ns);
    if silent_ns >= deletion.silent_s.ns() {
        if track.number > scan.before.tracks[other_number as usize].number {
            explain_end(scan, &track, deletion, TrackEvent::ENDS);
            return None;
        }
        track.seen_ns = plot.time_ns;
    }
    // Without the update, which cannot fail in numbers, the track goes on as predicted.
    let _ = motion.update_half(&other, &plot.measurement.weighted(scan.sensor.scan_weight));
    track.motion = motion;
    track.time_ns = plot.time_ns;
    (track.missed, track.absence) = (0, 0.0);
    track.detections += 1;
    track.seen_by |= scan.sensor.bit;
    track.remember(scan.first_serial.wrapping_add(found.plot));
    Some(track)
}

/// Begins a track with an inherited motion, or with the state of a first detection. `None` for a direction alone.
pub(crate) fn begin(scan: &ScanContext<'_>, plot: u32, inherited: Option<TargetMotion>, root: u32) -> Option<Track> {
    let found = &scan.plots[plot as usize];
    let settings = scan.settings;
    let updated = inherited.and_then(|mut motion| motion.update(&found.measurement).map(|_| motion));
    let motion = updated.or_else(|| TargetMotion::first(&found.measurement, &settings.initiation, &settings.motion))?;
    let serial = scan.first_serial.wrapping_add(plot);
    let mut track = Track {
        log_likelihood_ratio: settings.initiation.new_target_share.ln(),
        seen_by: scan.sensor.bit,
        ..Track::begun(motion, found.time_ns, serial, root)
    };
    track.identity.take(&found.identity);
    Some(track)
}

/// SP-7, in a cluster with so many confirmed tracks.
pub(crate) fn lacks_company(scan: &ScanContext<'_>, confirmed: usize, track: &Track) -> bool {
    let judged = confirmed > 0 && !track.is_confirmed() && track.detections > 1;
    let least = scan.settings.splitting.company_min.filter(|_| judged);
    least.is_some_and(|least| track.company() < least)
}

/// Records the end of a track by misses or by silence.
pub(crate) fn explain_end(
    scan: &ScanContext<'_>,
    track: &Track,
    deletion: &Deletion,
    [missed, silent]: [TrackEvent; 2],
) {
    if deletion.is_missed_too_often(track) {
        scan.explain(missed, track, track.existence(), deletion.existence_min);
    } else {
        let silent_ns = scan.time_ns.saturating_sub(track.seen_ns);
        let [silent_s, limit_s] = [silent_ns, deletion.silent_s.ns()].map(|time_ns| time_ns as f64 / NS_PER_S);
        scan.explain(silent, track, silent_s, limit_s);
    }
}

fn explain_company(scan: &ScanContext<'_>, track: &Track) {
    let limit = scan.settings.splitting.company_min.unwrap_or(f64::NAN);
    scan.explain(TrackEvent::OutOfCompany, track, track.company(), limit);
}

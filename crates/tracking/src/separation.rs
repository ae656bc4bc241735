//! Separation of a cluster into smaller clusters after a scan (HT-4).
//!
//! Tracks separate when nothing is shared any longer: tracks without a common detection in memory and without a common
//! root belong to different clusters. Each part keeps the part's own tracks of every hypothesis; hypotheses that become
//! equal are added up.

use association::components::{join, representative};

use crate::counts::TrackerCounts;
use crate::hypothesis_store::HypothesisStore;
use crate::limits::{CLUSTER_TRACKS_MAX, HISTORY_MAX};
use crate::log_sum::{log_add, log_sum};
use crate::population::{Cluster, Hypothesis, Population};
use crate::settings::Reduction;
use crate::splitting::DetectionCounts;
use crate::track::{NO_DETECTION, Track};

const NONE: u32 = u32::MAX;

/// Working memory, reused for each cluster.
#[derive(Clone, Debug)]
pub(crate) struct Separation {
    /// By track: the representative of the part; [`NONE`] for tracks in no hypothesis.
    part_of: Vec<u32>,
    /// By track: place in the population, while a part is written.
    place: Vec<u32>,
    /// (root or detection, track).
    shared: Vec<(u64, u32)>,
    /// Representatives of the parts.
    parts: Vec<u32>,
}

impl Separation {
    pub(crate) fn new(tracks_max: usize) -> Self {
        Self {
            part_of: Vec::with_capacity(tracks_max),
            place: Vec::with_capacity(tracks_max),
            shared: Vec::with_capacity(tracks_max * (HISTORY_MAX + 1)),
            parts: Vec::with_capacity(tracks_max),
        }
    }

    /// Writes the clusters that the children in the store make up to `next`.
    pub(crate) fn write(
        &mut self,
        store: &mut HypothesisStore,
        next: &mut Population,
        reduction: &Reduction,
        detections: &DetectionCounts,
        counts: &mut TrackerCounts,
    ) {
        self.find_parts_of_bounded_size(store, counts);
        let share = 1.0 / self.parts.len() as f32;
        for place in 0..self.parts.len() {
            let part = self.parts[place];
            let inherited = if self.parts.len() == 1 {
                *detections
            } else {
                detections.part(share, self.present_detections(store, part))
            };
            self.write_part(store, part, next, reduction, &inherited, counts);
        }
    }

    /// Number of the scan's detections that tracks of a part have.
    fn present_detections(&self, store: &HypothesisStore, part: u32) -> usize {
        let of_part = store.tracks.iter().zip(&self.part_of).filter(|(_, of)| **of == part);
        let mut present = 0;
        let mut seen = NO_DETECTION;
        // Branches with the same detection mostly stand side by side; a few counted twice do no harm.
        for (track, _) in of_part {
            let serial = if track.missed == 0 {
                track.history[0]
            } else {
                NO_DETECTION
            };
            present += usize::from(serial != NO_DETECTION && serial != seen);
            seen = serial;
        }
        present
    }

    /// Finds parts of at most [`CLUSTER_TRACKS_MAX`] tracks. Of a larger part only the better half of the hypotheses is
    /// kept, again and again: a single hypothesis has no branches, so the tracks share nothing.
    fn find_parts_of_bounded_size(&mut self, store: &mut HypothesisStore, counts: &mut TrackerCounts) {
        loop {
            self.find_parts(store);
            let size = |part: &u32| self.part_of.iter().filter(|of| *of == part).count();
            let bounded = self.parts.iter().all(|part| size(part) <= CLUSTER_TRACKS_MAX);
            if store.tracks.len() <= CLUSTER_TRACKS_MAX || bounded || store.children.len() == 1 {
                return;
            }
            let kept = store.children.len() / 2;
            counts.hypotheses_pruned += (store.children.len() - kept) as u64;
            store.children.truncate(kept);
        }
    }

    /// Tracks of the same root, or with a detection in common, stay together.
    fn find_parts(&mut self, store: &HypothesisStore) {
        self.part_of.clear();
        self.part_of.resize(store.tracks.len(), NONE);
        for child in &store.children {
            for member in store.members_of(child) {
                self.part_of[*member as usize] = *member;
            }
        }
        self.shared.clear();
        for (number, track) in (0u32..).zip(&store.tracks) {
            if self.part_of[number as usize] == NONE {
                continue;
            }
            self.shared.push((u64::from(track.root), number));
            let serials = track.history.iter().filter(|serial| **serial != NO_DETECTION);
            // Roots and serials are numbers of different things.
            self.shared
                .extend(serials.map(|serial| (1 << 32 | u64::from(*serial), number)));
        }
        self.shared.sort_unstable();
        for place in 1..self.shared.len() {
            let ((what, one), (same, other)) = (self.shared[place - 1], self.shared[place]);
            if what == same {
                join(&mut self.part_of, one, other);
            }
        }
        self.parts.clear();
        for track in 0..store.tracks.len() as u32 {
            if self.part_of[track as usize] == NONE {
                continue;
            }
            let first = representative(&mut self.part_of, track);
            self.part_of[track as usize] = first;
            if first == track {
                self.parts.push(track);
            }
        }
    }

    /// Writes a part as a cluster, unless only the hypothesis without tracks is left.
    fn write_part(
        &mut self,
        store: &HypothesisStore,
        part: u32,
        next: &mut Population,
        reduction: &Reduction,
        detections: &DetectionCounts,
        counts: &mut TrackerCounts,
    ) {
        let begin = (next.tracks.len(), next.hypotheses.len(), next.members.len());
        let tracks = self.part_of.iter().filter(|of| **of == part).count();
        let members: usize = store.children.iter().map(|child| store.members_of(child).len()).sum();
        if !next.has_room(tracks, store.children.len(), members) {
            counts.dropped_tracks += tracks as u64;
            return;
        }
        self.place.clear();
        self.place.resize(store.tracks.len(), NONE);
        for (number, child) in store.children.iter().enumerate() {
            let first = next.members.len();
            let of_child = store.members_of(child).iter();
            let own = of_child.filter(|member| self.part_of[**member as usize] == part);
            next.members.extend(own);
            let same = next.hypotheses[begin.1..].iter().position(|earlier| {
                let earlier = earlier.members.start as usize..earlier.members.end as usize;
                next.members[earlier] == next.members[first..]
            });
            if let Some(same) = same.filter(|_| number > 0) {
                next.members.truncate(first);
                let earlier = &mut next.hypotheses[begin.1 + same];
                earlier.log_reliability = log_add(earlier.log_reliability, child.log_reliability);
            } else {
                next.hypotheses.push(Hypothesis {
                    log_reliability: child.log_reliability,
                    members: first as u32..next.members.len() as u32,
                });
            }
        }
        counts.hypotheses_pruned += finish_hypotheses(next, begin.1, reduction);
        self.place_tracks(store, next, begin.1);
        if next.tracks.len() == begin.0 {
            next.hypotheses.truncate(begin.1);
            next.members.truncate(begin.2);
            return;
        }
        next.clusters.push(Cluster {
            tracks: begin.0 as u32..next.tracks.len() as u32,
            hypotheses: begin.1 as u32..next.hypotheses.len() as u32,
            detections: detections.detections,
            scans: detections.scans,
        });
    }

    /// Copies the tracks contained in the hypotheses from `first` on, sums up the reliabilities, and updates the
    /// members to the new indices.
    fn place_tracks(&mut self, store: &HypothesisStore, next: &mut Population, first: usize) {
        for place in first..next.hypotheses.len() {
            let hypothesis = next.hypotheses[place].clone();
            let reliability = hypothesis.log_reliability.exp();
            for member in hypothesis.members {
                let stored = next.members[member as usize] as usize;
                if self.place[stored] == NONE {
                    self.place[stored] = next.tracks.len() as u32;
                    next.tracks.push(Track {
                        reliability: 0.0,
                        ..store.tracks[stored]
                    });
                }
                next.members[member as usize] = self.place[stored];
                next.tracks[self.place[stored] as usize].reliability += reliability;
            }
        }
    }
}

/// Sorts the hypotheses from `begin` on, most reliable first, drops the unreliable ones, and lets the others sum to 1.
/// Returns how many were dropped.
fn finish_hypotheses(next: &mut Population, begin: usize, reduction: &Reduction) -> u64 {
    let written = &mut next.hypotheses[begin..];
    // Few, and nearly sorted.
    written.sort_unstable_by(|one, other| {
        let members = one.members.start.cmp(&other.members.start);
        other.log_reliability.total_cmp(&one.log_reliability).then(members)
    });
    let least = reduction.reliability_min.ln();
    let kept = written
        .iter()
        .take_while(|hypothesis| hypothesis.log_reliability >= least)
        .count();
    let dropped = written.len() - kept.max(1);
    next.hypotheses.truncate(begin + kept.max(1));
    let written = &mut next.hypotheses[begin..];
    let left = log_sum(written.iter().map(|hypothesis| hypothesis.log_reliability));
    for hypothesis in written {
        hypothesis.log_reliability -= left;
    }
    dropped as u64
}

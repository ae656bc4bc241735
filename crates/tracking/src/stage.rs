//! The hypotheses of one cluster while a scan is worked off: reduction, confirmation, separation (HT-4, HT-9, HT-10).
//!
//! The children that were drawn are first merged: those of the same tracks, and, if so configured, those whose
//! associations over the last scans are the same and that hold as many confirmed tracks; of these the more reliable one
//! stays and takes over the other's reliability. Two hypotheses in which two targets have exchanged their past, for
//! example, become one that way once the exchange is old enough: which was which will never be known.
//!
//! Then what is left of low reliability is dropped; tracks that remain beyond doubt are confirmed; and tracks that no
//! longer share anything part: with no common detection in their memory and no common root, they are of one cluster no
//! more. Each part keeps of every hypothesis its own tracks, and hypotheses that become the same add up.
//!
//! Limit: associations are compared by a sum of 64-bit hashes; that two different ones agree is possible, and never
//! happens.

use std::ops::Range;

use crate::counts::Counts;
use crate::limits::{CLUSTER_TRACKS_MAX, HISTORY_MAX};
use crate::log_sum::{log_add, log_sum};
use crate::population::{Cluster, Hypothesis, Population};
use crate::settings::Reduction;
use crate::splitting::DetectionCounts;
use crate::track::{NO_DETECTION, TENTATIVE, Track};

const NONE: u32 = u32::MAX;

#[derive(Clone, Debug)]
struct Child {
    log_reliability: f64,
    members: Range<u32>,
    key: u64,
}

/// Working memory for one cluster after the other.
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    pub(crate) tracks: Vec<Track>,
    children: Vec<Child>,
    members: Vec<u32>,
    /// By track: one that stands for all that must stay together with it; [`NONE`] of tracks in no hypothesis.
    together: Vec<u32>,
    /// By track: its place in the population, while a part is written.
    place: Vec<u32>,
    /// (what is shared, track).
    shared: Vec<(u64, u32)>,
    /// Parts, by the tracks that stand for them.
    parts: Vec<u32>,
}

impl Stage {
    pub(crate) fn new(tracks_max: usize, children_max: usize, members_max: usize) -> Self {
        Self {
            tracks: Vec::with_capacity(tracks_max),
            children: Vec::with_capacity(children_max),
            members: Vec::with_capacity(members_max),
            together: Vec::with_capacity(tracks_max),
            place: Vec::with_capacity(tracks_max),
            shared: Vec::with_capacity(tracks_max * (HISTORY_MAX + 1)),
            parts: Vec::with_capacity(tracks_max),
        }
    }

    pub(crate) fn clear(&mut self) {
        self.tracks.clear();
        self.children.clear();
        self.members.clear();
    }

    /// Keeps a track for hypotheses to come. `None` if there is no room.
    pub(crate) fn add_track(&mut self, track: Track) -> Option<u32> {
        let room = self.tracks.len() < self.tracks.capacity();
        room.then(|| {
            self.tracks.push(track);
            self.tracks.len() as u32 - 1
        })
    }

    /// Adds a track to the hypothesis that [`Self::finish_child`] will complete. `false` if there is no room.
    pub(crate) fn add_member(&mut self, track: u32) -> bool {
        let room = self.members.len() < self.members.capacity();
        if room {
            self.members.push(track);
        }
        room
    }

    /// How many members have been added since the last hypothesis was completed that are tentative.
    pub(crate) fn tentative_members(&self) -> usize {
        let begun = &self.members[self.begun()..];
        begun
            .iter()
            .filter(|track| !self.tracks[**track as usize].is_confirmed())
            .count()
    }

    pub(crate) fn drop_child(&mut self) {
        self.members.truncate(self.begun());
    }

    /// Completes a hypothesis of the members added since the last one. `false` if there is no room.
    pub(crate) fn finish_child(&mut self, log_reliability: f64) -> bool {
        let begin = self.begun();
        self.members[begin..].sort_unstable();
        let room = self.children.len() < self.children.capacity();
        if room {
            self.children.push(Child {
                log_reliability,
                members: begin as u32..self.members.len() as u32,
                key: 0,
            });
        } else {
            self.drop_child();
        }
        room
    }

    /// Logarithm of the reliability of the hypothesis completed as number `child`, until they are reduced.
    pub(crate) fn log_reliability(&self, child: usize) -> f64 {
        self.children[child].log_reliability
    }

    /// Raises it by so much, or lowers it.
    pub(crate) fn raise(&mut self, child: usize, gain: f64) {
        self.children[child].log_reliability += gain;
    }

    pub(crate) fn len(&self) -> usize {
        self.children.len()
    }

    fn begun(&self) -> usize {
        self.children.last().map_or(0, |child| child.members.end as usize)
    }

    fn members_of(&self, child: &Child) -> &[u32] {
        &self.members[child.members.start as usize..child.members.end as usize]
    }

    /// Merges, drops, normalises (HT-9). Returns the share of the children's probability that was dropped.
    pub(crate) fn reduce(&mut self, reduction: &Reduction, counts: &mut Counts) -> f64 {
        self.find_keys(reduction.merge_scans);
        self.merge(reduction.merge_scans > 0, counts);
        let total = log_sum(self.children.iter().map(|child| child.log_reliability));
        self.children.sort_unstable_by(|one, other| {
            let members = one.members.start.cmp(&other.members.start);
            other.log_reliability.total_cmp(&one.log_reliability).then(members)
        });
        let before = self.children.len();
        let least = total + reduction.reliability_min.ln();
        let reliable = self.children.iter().take(reduction.hypotheses_max);
        let kept = reliable.take_while(|child| child.log_reliability >= least).count();
        self.children.truncate(kept.max(1));
        counts.hypotheses_dropped += (before - self.children.len()) as u64;
        let left = log_sum(self.children.iter().map(|child| child.log_reliability));
        for child in &mut self.children {
            child.log_reliability -= left;
        }
        (1.0 - (left - total).exp()).max(0.0)
    }

    fn find_keys(&mut self, scans: usize) {
        for place in 0..self.children.len() {
            let members = self.members_of(&self.children[place]);
            let key = members.iter().fold(members.len() as u64, |key, member| {
                let track = &self.tracks[*member as usize];
                key.wrapping_add(associations_key(track, scans))
            });
            self.children[place].key = key;
        }
    }

    /// Likeliest first: an earlier one stays and takes over a later one's reliability.
    fn merge(&mut self, by_key: bool, counts: &mut Counts) {
        let mut kept = 0;
        for place in 0..self.children.len() {
            let child = self.children[place].clone();
            let same = (0..kept).find(|earlier| {
                let earlier = &self.children[*earlier];
                earlier.key == child.key && (by_key || self.members_of(earlier) == self.members_of(&child))
            });
            if let Some(earlier) = same {
                let earlier = &mut self.children[earlier];
                earlier.log_reliability = log_add(earlier.log_reliability, child.log_reliability);
                counts.hypotheses_merged += 1;
            } else {
                self.children[kept] = child;
                kept += 1;
            }
        }
        self.children.truncate(kept);
    }

    /// Confirms what may be confirmed (HT-10), with all branches of the same root. Numbers count up from `next_number`.
    pub(crate) fn confirm(&mut self, may_be: impl Fn(&Track) -> bool, next_number: &mut u32, counts: &mut Counts) {
        self.rate();
        for place in 0..self.tracks.len() {
            let track = &self.tracks[place];
            if track.is_confirmed() || !may_be(track) {
                continue;
            }
            let root = track.root;
            for branch in self.tracks.iter_mut().filter(|track| track.root == root) {
                branch.number = *next_number;
            }
            *next_number = next_number.wrapping_add(1).max(1);
            counts.confirmed += 1;
        }
    }

    /// The hypotheses, most reliable first, with their tracks.
    pub(crate) fn hypotheses(&self) -> impl Iterator<Item = (f64, impl Iterator<Item = &Track>)> {
        self.children.iter().map(|child| {
            let members = self.members_of(child).iter();
            let tracks = members.map(|member| &self.tracks[*member as usize]);
            (child.log_reliability.exp(), tracks)
        })
    }

    /// Sums up the tracks' reliabilities.
    fn rate(&mut self) {
        self.tracks.iter_mut().for_each(|track| track.reliability = 0.0);
        for child in &self.children {
            let reliability = child.log_reliability.exp();
            for member in child.members.clone() {
                self.tracks[self.members[member as usize] as usize].reliability += reliability;
            }
        }
    }

    /// Writes the clusters that the cluster falls into (HT-4).
    pub(crate) fn separate(
        &mut self,
        next: &mut Population,
        reduction: &Reduction,
        detections: &DetectionCounts,
        counts: &mut Counts,
    ) {
        self.find_parts_of_bounded_size(counts);
        let latest = |stage: &Self, part: u32| {
            let of_part = (0..stage.tracks.len()).filter(|track| stage.together[*track] == part);
            let mut serials = 0;
            let mut seen = NO_DETECTION;
            // Branches with the same detection mostly stand side by side; a few counted twice do no harm.
            for track in of_part {
                let track = &stage.tracks[track];
                let serial = if track.missed == 0 {
                    track.history[0]
                } else {
                    NO_DETECTION
                };
                serials += usize::from(serial != NO_DETECTION && serial != seen);
                seen = serial;
            }
            serials
        };
        let single = self.parts.len() == 1;
        for place in 0..self.parts.len() {
            let part = self.parts[place];
            let inherited = if single {
                *detections
            } else {
                let present = latest(self, part);
                detections.part(1.0 / self.parts.len() as f32, present)
            };
            self.write(part, next, reduction, &inherited, counts);
        }
    }

    /// Parts of at most [`CLUSTER_TRACKS_MAX`] tracks. Of a larger one only the better half of
    /// the hypotheses is kept, again and again: a single hypothesis has no branches, so its tracks share nothing.
    fn find_parts_of_bounded_size(&mut self, counts: &mut Counts) {
        loop {
            self.find_parts();
            let size = |part: &u32| self.together.iter().filter(|together| *together == part).count();
            let bounded = self.parts.iter().all(|part| size(part) <= CLUSTER_TRACKS_MAX);
            if self.tracks.len() <= CLUSTER_TRACKS_MAX || bounded || self.children.len() == 1 {
                return;
            }
            let kept = self.children.len() / 2;
            counts.hypotheses_dropped += (self.children.len() - kept) as u64;
            self.children.truncate(kept);
        }
    }

    /// Tracks of the same root, or with a detection in common, stay together.
    fn find_parts(&mut self) {
        self.together.clear();
        self.together.resize(self.tracks.len(), NONE);
        for child in &self.children {
            for member in &self.members[child.members.start as usize..child.members.end as usize] {
                self.together[*member as usize] = *member;
            }
        }
        self.shared.clear();
        for (number, track) in (0u32..).zip(&self.tracks) {
            if self.together[number as usize] == NONE {
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
                let (one, other) = (
                    standing_in(&mut self.together, one),
                    standing_in(&mut self.together, other),
                );
                self.together[one.max(other) as usize] = one.min(other);
            }
        }
        self.parts.clear();
        for track in 0..self.tracks.len() as u32 {
            if self.together[track as usize] == NONE {
                continue;
            }
            let standing = standing_in(&mut self.together, track);
            self.together[track as usize] = standing;
            if standing == track {
                self.parts.push(track);
            }
        }
    }

    /// Writes one part as a cluster, unless nothing but the hypothesis without tracks is left of it.
    fn write(
        &mut self,
        part: u32,
        next: &mut Population,
        reduction: &Reduction,
        detections: &DetectionCounts,
        counts: &mut Counts,
    ) {
        let begin = (next.tracks.len(), next.hypotheses.len(), next.members.len());
        let tracks = self.together.iter().filter(|together| **together == part).count();
        let members: usize = self.children.iter().map(|child| child.members.len()).sum();
        if !next.has_room(tracks, self.children.len(), members) {
            counts.refused_tracks += tracks as u64;
            return;
        }
        self.place.clear();
        self.place.resize(self.tracks.len(), NONE);
        for (number, child) in self.children.iter().enumerate() {
            let first = next.members.len();
            let of_child = &self.members[child.members.start as usize..child.members.end as usize];
            let own = of_child
                .iter()
                .filter(|member| self.together[**member as usize] == part);
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
        counts.hypotheses_dropped += finish_hypotheses(next, begin.1, reduction);
        self.place_tracks(next, begin);
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

    /// Copies the tracks that the hypotheses from `begin` on still contain, sums up their reliabilities, and lets the
    /// members name their new places.
    fn place_tracks(&mut self, next: &mut Population, begin: (usize, usize, usize)) {
        for place in begin.1..next.hypotheses.len() {
            let hypothesis = next.hypotheses[place].clone();
            let reliability = hypothesis.log_reliability.exp();
            for member in hypothesis.members {
                let staged = next.members[member as usize] as usize;
                if self.place[staged] == NONE {
                    self.place[staged] = next.tracks.len() as u32;
                    next.tracks.push(Track {
                        reliability: 0.0,
                        ..self.tracks[staged]
                    });
                }
                next.members[member as usize] = self.place[staged];
                next.tracks[self.place[staged] as usize].reliability += reliability;
            }
        }
    }
}

/// Most reliable first, without the unreliable ones, summing to 1. Returns how many were dropped.
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

fn standing_in(together: &mut [u32], track: u32) -> u32 {
    let mut at = track;
    while together[at as usize] != at {
        let above = together[at as usize];
        together[at as usize] = together[above as usize];
        at = above;
    }
    at
}

/// What a track adds to its hypothesis' associations over the last `scans`.
fn associations_key(track: &Track, scans: usize) -> u64 {
    let serials = track.history[..scans].iter();
    let associations = serials.fold(0x9e37_79b9_7f4a_7c15, |key, serial| mixed(key ^ u64::from(*serial)));
    let number = if track.number == TENTATIVE { 0 } else { mixed(1) };
    // Sums of both over all tracks: who has which associations does not matter. Nor does a confirmed track's number: of two
    // numbers for the same associations one is too many.
    associations.wrapping_add(number.rotate_left(17))
}

/// A bijection that leaves no pattern (the finaliser of SplitMix64).
fn mixed(value: u64) -> u64 {
    let value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ (value >> 31)
}

//! The child hypotheses of a cluster while a scan is processed: reduction and confirmation (HT-9, HT-10).
//!
//! Drawn children are merged first. Children with the same tracks merge; if configured, so do children with the same
//! associations over the last scans and as many confirmed tracks. The more reliable child stays and takes over the
//! other's reliability. For example, two hypotheses in which two targets have exchanged the past merge once the
//! exchange is old enough, as the two can no longer be distinguished.
//!
//! Then children of low reliability are dropped, and tracks that remain beyond doubt are confirmed.
//!
//! Limit: associations are compared by a sum of 64-bit hashes; two different sums of associations could agree, but
//! never do.

use std::ops::Range;

use crate::counts::TrackerCounts;
use crate::log_sum::{log_add, log_sum};
use crate::settings::{Confirmation, Reduction, Splitting};
use crate::track::{TENTATIVE, Track};

/// Least share of detections in confirmed tracks' gates of a track that may have split off.
const COMPANY_MIN: f64 = 0.5;

/// A child hypothesis.
#[derive(Clone, Debug)]
pub(crate) struct ChildHypothesis {
    /// Logarithm; the reliabilities of all children sum to 1 after the reduction.
    pub(crate) log_reliability: f64,
    /// Places in the list of members.
    members: Range<u32>,
    /// Hash of the associations over the last scans.
    key: u64,
}

/// Working memory, reused for each cluster.
#[derive(Clone, Debug)]
pub(crate) struct HypothesisStore {
    /// Tracks that children may have.
    pub(crate) tracks: Vec<Track>,
    /// Most reliable first after the reduction.
    pub(crate) children: Vec<ChildHypothesis>,
    members: Vec<u32>,
}

impl HypothesisStore {
    pub(crate) fn new(tracks_max: usize, children_max: usize, members_max: usize) -> Self {
        Self {
            tracks: Vec::with_capacity(tracks_max),
            children: Vec::with_capacity(children_max),
            members: Vec::with_capacity(members_max),
        }
    }

    pub(crate) fn clear(&mut self) {
        self.tracks.clear();
        self.children.clear();
        self.members.clear();
    }

    /// Keeps a track for children to come, and returns the track's place. `None` if there is no room.
    pub(crate) fn add_track(&mut self, track: Track) -> Option<u32> {
        let room = self.tracks.len() < self.tracks.capacity();
        room.then(|| {
            self.tracks.push(track);
            self.tracks.len() as u32 - 1
        })
    }

    /// Adds a track to the child that [`Self::finish_child`] will complete. `false` if there is no room.
    pub(crate) fn add_member(&mut self, track: u32) -> bool {
        let room = self.members.len() < self.members.capacity();
        if room {
            self.members.push(track);
        }
        room
    }

    /// Number of tentative tracks that the child to be completed has so far.
    pub(crate) fn tentative_members(&self) -> usize {
        let begun = &self.members[self.begun()..];
        begun
            .iter()
            .filter(|track| !self.tracks[**track as usize].is_confirmed())
            .count()
    }

    /// Forgets the members added since the last child was completed.
    pub(crate) fn drop_child(&mut self) {
        self.members.truncate(self.begun());
    }

    /// Completes a child of the members added since the last child. `false` if there is no room.
    pub(crate) fn finish_child(&mut self, log_reliability: f64) -> bool {
        let begin = self.begun();
        self.members[begin..].sort_unstable();
        let room = self.children.len() < self.children.capacity();
        if room {
            self.children.push(ChildHypothesis {
                log_reliability,
                members: begin as u32..self.members.len() as u32,
                key: 0,
            });
        } else {
            self.drop_child();
        }
        room
    }

    fn begun(&self) -> usize {
        self.children.last().map_or(0, |child| child.members.end as usize)
    }

    /// Places of a child's tracks.
    pub(crate) fn members_of(&self, child: &ChildHypothesis) -> &[u32] {
        &self.members[child.members.start as usize..child.members.end as usize]
    }

    /// Merges, drops and normalises the children (HT-9). Returns the dropped share of the probability.
    pub(crate) fn reduce(&mut self, reduction: &Reduction, counts: &mut TrackerCounts) -> f64 {
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
        counts.hypotheses_pruned += (before - self.children.len()) as u64;
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

    /// Likeliest first: an earlier child stays and takes over a later child's reliability.
    fn merge(&mut self, by_key: bool, counts: &mut TrackerCounts) {
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

    /// Confirms the trees that may be confirmed (HT-10): a tree is as likely as all branches together, since no
    /// hypothesis has two branches with the same first detection.
    pub(crate) fn confirm_trees(
        &mut self,
        confirmation: &Confirmation,
        splitting: &Splitting,
        next_number: &mut u32,
        counts: &mut TrackerCounts,
    ) {
        self.sum_reliabilities();
        for place in 0..self.tracks.len() {
            let track = &self.tracks[place];
            if track.is_confirmed() || !confirmation.is_seen_enough(track) {
                continue;
            }
            let root = track.root;
            let branches = self.tracks[place..].iter().filter(|branch| branch.root == root);
            let counted = branches.filter(|branch| confirmation.is_seen_enough(branch));
            // A second detection of the same target begins a second tree, in which either has the next detection: so
            // for a split a single branch must be as likely.
            let (together, is_split) = counted.fold((0.0, false), |(all, is_split), branch| {
                let has_split = branch.company() >= COMPANY_MIN && splitting.is_beyond_doubt(branch);
                (all + branch.reliability, is_split || has_split)
            });
            if confirmation.is_beyond_doubt(together) || is_split {
                self.give_number(root, next_number, counts);
            }
        }
    }

    /// Confirms all branches of a root.
    fn give_number(&mut self, root: u32, next_number: &mut u32, counts: &mut TrackerCounts) {
        for branch in self.tracks.iter_mut().filter(|track| track.root == root) {
            branch.number = *next_number;
        }
        *next_number = next_number.wrapping_add(1).max(1);
        counts.confirmed += 1;
    }

    /// Reliabilities of the children with tracks, most reliable first.
    pub(crate) fn hypotheses(&self) -> impl Iterator<Item = (f64, impl Iterator<Item = &Track>)> {
        self.children.iter().map(|child| {
            let members = self.members_of(child).iter();
            let tracks = members.map(|member| &self.tracks[*member as usize]);
            (child.log_reliability.exp(), tracks)
        })
    }

    /// Sums up the reliability of each track over the hypotheses that contain the track.
    pub(crate) fn sum_reliabilities(&mut self) {
        self.tracks.iter_mut().for_each(|track| track.reliability = 0.0);
        for child in &self.children {
            let reliability = child.log_reliability.exp();
            for member in child.members.clone() {
                self.tracks[self.members[member as usize] as usize].reliability += reliability;
            }
        }
    }
}

/// Hash of a track's associations over the last `scans`, for the key of the hypothesis.
fn associations_key(track: &Track, scans: usize) -> u64 {
    let serials = track.history[..scans].iter();
    let associations = serials.fold(0x9e37_79b9_7f4a_7c15, |key, serial| mixed(key ^ u64::from(*serial)));
    let number = if track.number == TENTATIVE { 0 } else { mixed(1) };
    // Sums of both over all tracks: the order of the tracks does not matter. A confirmed track's number does not matter
    // either: the same associations need no second number.
    associations.wrapping_add(number.rotate_left(17))
}

/// A bijection that leaves no pattern (the finaliser of SplitMix64).
fn mixed(value: u64) -> u64 {
    let value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ (value >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::initiation::Initiation;
    use crate::measurement::DetectionMeasurement;
    use crate::motion::TargetMotion;
    use crate::testing::{position, settings};

    /// Numbers after the confirmation of a tree with two branches, each in one hypothesis, and of another track.
    fn numbers(reliabilities: [f64; 3], in_company: u32) -> [u32; 3] {
        let measurement = DetectionMeasurement::of(&position(0, 0.0, 0.0), None).unwrap();
        let chosen = settings();
        let motion = TargetMotion::first(&measurement, &Initiation::default(), &chosen.motion).unwrap();
        let mut store = HypothesisStore::new(8, 8, 8);
        for (place, root) in [(0, 1), (1, 1), (2, 2)] {
            let track = Track {
                detections: 3,
                in_company,
                ..Track::begun(motion, 0, place + 1, root)
            };
            store.add_track(track).unwrap();
            store.add_member(place);
            assert!(store.finish_child(reliabilities[place as usize].ln()));
        }
        let mut next_number = 1;
        let mut counts = TrackerCounts::default();
        store.confirm_trees(&chosen.confirmation, &chosen.splitting, &mut next_number, &mut counts);
        assert_eq!(u64::from(next_number), counts.confirmed + 1);
        [0, 1, 2].map(|place: usize| store.tracks[place].number)
    }

    #[test]
    fn a_tree_is_as_likely_as_its_branches_together() {
        assert_eq!(numbers([0.6, 0.399, 0.001], 0), [1, 1, 0]);
        assert_eq!(numbers([0.6, 0.3, 0.1], 0), [0; 3]);
    }

    #[test]
    fn the_third_detection_of_a_split_needs_even_less() {
        assert_eq!(numbers([0.93, 0.06, 0.01], 2), [1, 1, 0]);
        assert_eq!(numbers([0.89, 0.1, 0.01], 2), [0; 3]);
        assert_eq!(numbers([0.93, 0.06, 0.01], 1), [0; 3], "hardly any company");
    }

    #[test]
    fn a_tree_that_kept_company_needs_less() {
        let between = [0.986, 0.006, 0.008];
        assert_eq!((numbers(between, 1), numbers(between, 2)), ([0; 3], [1, 1, 0]));
    }
}

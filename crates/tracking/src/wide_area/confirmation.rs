//! Earlier confirmation where reports show more targets than the confirmed tracks account for (WA-6).
//!
//! The obvious test compares the report with the number of confirmed tracks in the cluster. The test fails after a
//! mistake. An early confirmation is a guess; the guessed track may survive in an unlikely hypothesis only. There the
//! guessed track follows the target that the likely hypotheses give to another track. Two confirmed tracks on one
//! target would then satisfy a count of two for good, and the track of the other target would never be confirmed.
//! Therefore the confirmed tracks count by their *expected* number: the sum of the reliabilities.
//!
//! Several hypotheses may agree on the place of the unconfirmed target and differ in the past of the target's track. No
//! such track need be reliable alone, so the reliabilities are added.
//!
//! The newly confirmed track and the mistaken one are two histories of the same target: no hypothesis contains both. So
//! the new track takes over number and root. Otherwise the picture would show both until the unlikely hypothesis ends,
//! and each mistake would cost a number.

use crate::hypothesis_store::HypothesisStore;
use crate::limits::HISTORY_MAX;
use crate::track::{NO_DETECTION, Track};

/// Expected number of confirmed tracks: the sum of the reliabilities found by the store.
pub(super) fn expected(store: &HypothesisStore) -> f64 {
    let confirmed = store.tracks.iter().filter(|track| track.is_confirmed());
    confirmed.map(|track| track.reliability).sum()
}

/// Reliability of the tentative track at `place`, together with all tentative tracks of the same detections over the
/// last `scans`: probability that the target has a tentative track, whatever the earlier detections.
pub(super) fn on_same_target(store: &HypothesisStore, place: usize, scans: usize) -> f64 {
    let latest = |track: &Track| -> [u32; HISTORY_MAX] {
        std::array::from_fn(|scan| {
            if scan < scans {
                track.history[scan]
            } else {
                NO_DETECTION
            }
        })
    };
    let own = latest(&store.tracks[place]);
    if own.iter().all(|serial| *serial == NO_DETECTION) {
        return store.tracks[place].reliability;
    }
    let tentative = store.tracks.iter().filter(|track| !track.is_confirmed());
    let same = tentative.filter(|track| latest(track) == own);
    same.map(|track| track.reliability).sum()
}

/// The confirmed track of which the tentative track at `place` is another history: of the confirmed tracks with which
/// no branch of the tentative track shares a hypothesis, the likeliest; of equally likely tracks the lowest number.
pub(super) fn other_history(store: &HypothesisStore, place: usize) -> Option<Track> {
    let root = store.tracks[place].root;
    let reliability = |number: u32| -> f64 {
        let branches = store.tracks.iter().filter(|track| track.number == number);
        branches.map(|track| track.reliability).sum()
    };
    let mut best: Option<(f64, Track)> = None;
    for track in store.tracks.iter().filter(|track| track.is_confirmed()) {
        if best.is_some_and(|(_, best)| best.number == track.number) || !excludes(store, track.number, root) {
            continue;
        }
        let found = (reliability(track.number), *track);
        let is_better =
            |(most, best): &(f64, Track)| found.0 > *most || (found.0 == *most && found.1.number < best.number);
        // A track in no hypothesis has ended.
        if found.0 > 0.0 && best.as_ref().is_none_or(is_better) {
            best = Some(found);
        }
    }
    best.map(|(_, track)| track)
}

/// Whether no hypothesis contains both a track of this number and a branch of this root.
fn excludes(store: &HypothesisStore, number: u32, root: u32) -> bool {
    store.hypotheses().all(|(_, tracks)| {
        let (mut has_number, mut has_root) = (false, false);
        for track in tracks {
            has_number |= track.number == number;
            has_root |= track.root == root;
        }
        !(has_number && has_root)
    })
}

/// Confirms all branches of the track at `place` under `number`, and under the root of that number's track, if there is
/// such a track already: from now on all are branches of the same ancestor.
pub(super) fn number(store: &mut HypothesisStore, place: usize, number: u32, root: u32) {
    let own = store.tracks[place].root;
    for branch in store.tracks.iter_mut().filter(|track| track.root == own) {
        (branch.number, branch.root) = (number, root);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::DetectionMeasurement;
    use crate::motion::TargetMotion;
    use crate::testing::{position, settings};
    use crate::track::TENTATIVE;

    /// Root, number, latest detection.
    type Branch = (u32, u32, u32);

    /// A store of hypotheses, each with probability and tracks.
    fn store(branches: &[Branch], hypotheses: &[(f64, &[u32])]) -> HypothesisStore {
        let settings = settings();
        let measurement = DetectionMeasurement::of(&position(0, 0.0, 0.0), None).unwrap();
        let motion = TargetMotion::first(&measurement, &settings.initiation, &settings.motion).unwrap();
        let mut store = HypothesisStore::new(16, 16, 64);
        for (root, number, serial) in branches {
            let begun = Track::begun(motion, 0, *serial, *root);
            store.add_track(Track {
                number: *number,
                ..begun
            });
        }
        for (reliability, members) in hypotheses {
            assert!(members.iter().all(|member| store.add_member(*member)));
            store.finish_child(reliability.ln());
        }
        store.sum_reliabilities();
        store
    }

    /// Track 21 is on detection 1 and the tentative track 257 on detection 2, or, hardly likely, 21 on 2 and 22 on 1.
    const BRANCHES: [Branch; 4] = [(11, 21, 1), (257, TENTATIVE, 2), (11, 21, 2), (210, 22, 1)];

    #[test]
    fn two_numbers_on_one_target_are_not_two_targets() {
        let mut store = store(&BRANCHES, &[(0.98, &[0, 1]), (0.02, &[2, 3])]);
        assert!((expected(&store) - 1.02).abs() < 1e-12, "{}", expected(&store));
        let other = other_history(&store, 1).unwrap();
        assert_eq!((other.number, other.root), (22, 210));
        number(&mut store, 1, other.number, other.root);
        assert_eq!((store.tracks[1].number, store.tracks[1].root), (22, 210));
        assert!((expected(&store) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_track_that_stands_beside_another_is_no_other_history_of_it() {
        let beside = store(&BRANCHES, &[(0.9, &[0, 1, 3]), (0.1, &[2, 3])]);
        assert_eq!(other_history(&beside, 1), None, "it is a third target");
        let ended = store(&BRANCHES, &[(1.0, &[0, 1])]);
        assert_eq!(
            other_history(&ended, 1),
            None,
            "track 22 is in no hypothesis any longer"
        );
    }

    #[test]
    fn tentative_tracks_of_the_same_detections_are_on_the_same_target() {
        let branches = [
            (11, 21, 1),
            (257, TENTATIVE, 2),
            (300, TENTATIVE, 2),
            (301, TENTATIVE, 1),
            (210, 22, 2),
        ];
        let store = store(&branches, &[(0.5, &[0, 1]), (0.3, &[3, 2]), (0.2, &[0, 4])]);
        let on_target = |place| on_same_target(&store, place, 2);
        assert!((on_target(1) - 0.8).abs() < 1e-12 && (on_target(2) - 0.8).abs() < 1e-12);
        assert!(
            (on_target(3) - 0.3).abs() < 1e-12,
            "confirmed tracks of the detection do not count"
        );
        assert!(
            (on_same_target(&store, 1, 0) - 0.5).abs() < 1e-12,
            "without a scan to compare"
        );
    }
}

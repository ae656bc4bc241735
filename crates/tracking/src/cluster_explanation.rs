//! Records of a cluster's update in a scan, made before the cluster is separated, while all its hypotheses exist.

use crate::counts::TrackerCounts;
use crate::explanation::{ClusterRecord, Explanation, Observer, TrackEvent, TrackRecord};
use crate::hypothesis_store::HypothesisStore;
use crate::joined::JoinedClusters;

/// Records confirmed tracks: numbers from `first_number` on; numbers from `first_early` on were confirmed early.
pub(crate) fn explain_confirmations(
    joined: &JoinedClusters<'_>,
    store: &HypothesisStore,
    [first_number, first_early]: [u32; 2],
) {
    let plain = joined.scan.settings.confirmation.reliability_min;
    let early = joined.support.early_reliability_min();
    for (place, track) in store.tracks.iter().enumerate() {
        let earlier = &store.tracks[..place];
        let is_new = track.number >= first_number && !earlier.iter().any(|other| other.number == track.number);
        if !is_new {
            continue;
        }
        let branches = store.tracks.iter().filter(|other| other.number == track.number);
        let best = branches.max_by(|one, other| one.reliability.total_cmp(&other.reliability));
        let best = best.unwrap_or(track);
        let (event, limit) = match early {
            Some(early) if track.number >= first_early => (TrackEvent::ConfirmedEarly, early),
            _ => (TrackEvent::Confirmed, plain),
        };
        joined.scan.explain(event, best, best.reliability, limit);
    }
}

/// Records tracks without any branch in the remaining hypotheses.
pub(crate) fn explain_ends(joined: &JoinedClusters<'_>, store: &HypothesisStore) {
    let before = &joined.scan.before.tracks;
    for (place, number) in joined.tracks().enumerate() {
        let track = &before[number as usize];
        let is_first = !joined
            .tracks()
            .take(place)
            .any(|earlier| before[earlier as usize].root == track.root);
        let mut left = store.hypotheses().flat_map(|(_, tracks)| tracks);
        if is_first && !left.any(|left| left.root == track.root) {
            joined.scan.explain(TrackEvent::Ended, track, f64::NAN, f64::NAN);
        }
    }
}

/// Records the cluster as a whole, from the counts before and after.
pub(crate) fn explain_cluster(
    joined: &JoinedClusters<'_>,
    observer: &dyn Observer,
    [before, after]: [&TrackerCounts; 2],
    dropped_probability: f64,
) {
    let forbidden = |counts: &TrackerCounts| counts.too_many_new_tracks + counts.too_many_tentative_tracks;
    observer.explain(&Explanation::Cluster(ClusterRecord {
        plots: joined.scan.plots,
        of_cluster: joined.plots,
        tracks: joined.tracks().count(),
        hypotheses: joined.clusters().map(|(_, cluster)| cluster.hypotheses.len()).sum(),
        considered: after.hypotheses_drawn - before.hypotheses_drawn,
        forbidden: forbidden(after) - forbidden(before),
        merged: after.hypotheses_merged - before.hypotheses_merged,
        dropped: after.hypotheses_pruned - before.hypotheses_pruned,
        dropped_probability: dropped_probability.min(1.0),
    }));
}

/// Records the remaining hypotheses with their tracks, the most reliable first.
pub(crate) fn explain_hypotheses(joined: &JoinedClusters<'_>, observer: &dyn Observer, store: &HypothesisStore) {
    let scan = joined.scan;
    for (reliability, tracks) in store.hypotheses() {
        observer.explain(&Explanation::Hypothesis { reliability });
        tracks.for_each(|track| {
            let record = TrackRecord::of(track, scan.plots, scan.first_serial);
            observer.explain(&Explanation::Member(record));
        });
    }
}

//! Clusters of a scan: existing clusters are updated, and new clusters begin at detections outside all gates.

use crate::branching;
use crate::cluster_update::ClusterUpdate;
use crate::counts::TrackerCounts;
use crate::explanation::TrackEvent;
use crate::population::Population;
use crate::quiet;
use crate::scan_context::ScanContext;
use crate::settings::Starts;

/// Updates the clusters, and begins new clusters at detections outside all gates.
pub(crate) fn run_clusters(
    scan: &ScanContext<'_>,
    clusters: &mut ClusterUpdate,
    next: &mut Population,
    counts: &mut TrackerCounts,
) {
    let mut of_none = &scan.gating.plots[..];
    let mut shared = &scan.gating.shared[..];
    for joined in scan.gating.clusters.chunk_by(|one, other| one.0 == other.0) {
        let of_joined = of_none.iter().take_while(|(first, _)| *first == joined[0].0);
        let (plots, rest) = of_none.split_at(of_joined.count());
        of_none = rest;
        let (of_joined, rest) = shared.split_at(plots.len());
        shared = rest;
        if let ([(_, only)], []) = (joined, plots)
            && quiet::update(scan, &scan.before.clusters[*only as usize], next, counts)
        {
            continue;
        }
        clusters.run(scan, joined, (plots, of_joined), next, counts);
    }
    for &(_, plot) in of_none {
        begin_cluster(scan, plot, next, counts);
    }
}

/// A cluster of a single detection in no gate: false, or the first of a new track (HT-4).
fn begin_cluster(scan: &ScanContext<'_>, plot: u32, next: &mut Population, counts: &mut TrackerCounts) {
    if scan.settings.starts == Starts::Designated {
        return;
    }
    let weight = (scan.log_weight + scan.plots[plot as usize].log_weight).exp();
    let inherited = scan.departures.motion(plot);
    let log_clutter = scan.log_clutter[plot as usize];
    let share = weight
        * scan
            .departures
            .new_target_share(plot, log_clutter, false, scan.settings);
    let reliability = share / (1.0 + share);
    if reliability <= 0.0 || reliability < scan.settings.reduction.reliability_min {
        return;
    }
    let Some(mut track) = branching::begin(scan, plot, inherited, next.next_root) else {
        return;
    };
    track.reliability = reliability;
    if !next.add_tentative(track) {
        counts.dropped_tracks += 1;
        return;
    }
    scan.explain(TrackEvent::Started, &track, reliability, f64::NAN);
}

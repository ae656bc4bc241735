//! Clusters joined by a scan and updated together.

use std::ops::Range;

use crate::counts::TrackerCounts;
use crate::gating::NONE;
use crate::plot::SharedPlot;
use crate::population::Cluster;
use crate::ranked::ROWS_MAX;
use crate::scan_context::ScanContext;
use crate::splitting::{DetectionCounts, SplitLimits};
use crate::track::TENTATIVE;
use crate::wide_area::support::ClusterSupport;

/// Detections of the joined clusters as rows of a problem; working memory, reused.
#[derive(Clone, Debug)]
pub(crate) struct DetectionRows {
    /// By detection of the scan: the row.
    row_of: Vec<u32>,
    /// By row: whether the detection lies in a confirmed track's gate.
    in_confirmed_gate: [bool; ROWS_MAX],
    /// Numbers of the confirmed tracks.
    confirmed: Vec<u32>,
}

impl DetectionRows {
    pub(crate) fn new(tracks_max: usize, plots_max: usize) -> Self {
        Self {
            row_of: vec![NONE; plots_max],
            in_confirmed_gate: [false; ROWS_MAX],
            confirmed: Vec::with_capacity(tracks_max),
        }
    }
}

/// Joined clusters and the inputs of the update.
#[derive(Clone, Copy)]
pub(crate) struct JoinedClusters<'a> {
    pub(crate) scan: &'a ScanContext<'a>,
    /// (cluster that represents all, cluster).
    clusters: &'a [(u32, u32)],
    /// (cluster that represents all, detection).
    pub(crate) plots: &'a [(u32, u32)],
    /// By detection of theirs.
    pub(crate) shared: &'a [SharedPlot],
    rows: &'a DetectionRows,
    pub(crate) detections: DetectionCounts,
    /// Number of confirmed tracks, branches not counted.
    pub(crate) confirmed: usize,
    pub(crate) limits: SplitLimits,
    pub(crate) support: ClusterSupport<'a>,
}

impl<'a> JoinedClusters<'a> {
    pub(crate) fn of(
        scan: &'a ScanContext<'a>,
        clusters: &'a [(u32, u32)],
        (plots, shared): (&'a [(u32, u32)], &'a [SharedPlot]),
        rows: &'a mut DetectionRows,
        counts: &mut TrackerCounts,
    ) -> Self {
        rows.in_confirmed_gate = [false; ROWS_MAX];
        rows.confirmed.clear();
        for (row, (_, plot)) in (0..).zip(plots) {
            rows.row_of[*plot as usize] = row;
        }
        let before = scan.before;
        let all = || clusters.iter().map(|(_, cluster)| &before.clusters[*cluster as usize]);
        for track in all().flat_map(|cluster| cluster.tracks.clone()) {
            let number = before.tracks[track as usize].number;
            if number == TENTATIVE {
                continue;
            }
            rows.confirmed.push(number);
            let pairs = &scan.gating.pairs[scan.gating.pairs_of(track)];
            for pair in pairs.iter().filter(|pair| !pair.is_far) {
                rows.in_confirmed_gate[rows.row_of[pair.plot as usize] as usize] = true;
            }
        }
        rows.confirmed.sort_unstable();
        rows.confirmed.dedup();
        let confirmed = rows.confirmed.len();
        let splitting = &scan.settings.splitting;
        if confirmed > 0 && splitting.start_in_confirmed_gates {
            let outside = rows.in_confirmed_gate[..plots.len()].iter();
            counts.starts_forbidden += outside.filter(|inside| !**inside).count() as u64;
        }
        let detections = DetectionCounts::of(all(), plots.len());
        Self {
            scan,
            clusters,
            plots,
            shared,
            rows,
            detections,
            confirmed,
            limits: SplitLimits::of(splitting, confirmed, detections.mean()),
            support: scan.support.of(clusters, confirmed, &scan.settings.wide_area),
        }
    }

    /// The clusters, with places in the population before the scan.
    pub(crate) fn clusters(&self) -> impl Iterator<Item = (u32, &'a Cluster)> + use<'a> {
        let before = self.scan.before;
        let all = self.clusters.iter();
        all.map(|(_, cluster)| (*cluster, &before.clusters[*cluster as usize]))
    }

    /// Places of the tracks in the population before the scan.
    pub(crate) fn tracks(&self) -> impl Iterator<Item = u32> + use<'a> {
        self.clusters().flat_map(|(_, cluster)| cluster.tracks.clone())
    }

    /// Places of a track's pairs.
    pub(crate) fn pairs(&self, track: u32) -> Range<usize> {
        self.scan.gating.pairs_of(track)
    }

    /// Row of a detection of the scan.
    pub(crate) fn row_of(&self, plot: u32) -> u32 {
        self.rows.row_of[plot as usize]
    }

    /// Row of a detection of the scan, if in these clusters.
    pub(crate) fn known_row_of(&self, plot: u32) -> Option<u32> {
        let row = self.row_of(plot);
        let found = self.plots.get(row as usize).is_some_and(|(_, of_row)| *of_row == plot);
        found.then_some(row)
    }

    /// Whether a row's detection lies in a confirmed track's gate.
    pub(crate) fn is_in_confirmed_gate(&self, row: usize) -> bool {
        self.rows.in_confirmed_gate[row]
    }

    /// Returns whether SP-1 forbids new tracks at a row's detection.
    pub(crate) fn is_start_forbidden(&self, row: usize) -> bool {
        !self.shared[row].may_start
            || self.confirmed > 0
                && self.scan.settings.splitting.start_in_confirmed_gates
                && !self.is_in_confirmed_gate(row)
    }
}

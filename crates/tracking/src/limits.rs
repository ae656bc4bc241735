//! Sizes that bound memory and time: every search of the tracker has a named maximum.

/// Most hypotheses of a cluster.
pub const HYPOTHESES_MAX: usize = 64;
/// Most tracks of a cluster, branches included.
pub const CLUSTER_TRACKS_MAX: usize = 256;
/// Most detections with which a track is compared in a scan.
pub const COMPARISONS_MAX: usize = 512;
/// Most detections that a track may take in a scan.
pub const PAIRS_MAX: usize = 16;
/// Scans in a track's memory, without scans of fast sensors that have no detection in the cluster.
pub const HISTORY_MAX: usize = 8;
/// Scans over which a cluster's detections are counted (SP-4).
pub const DETECTION_COUNTS: usize = 5;
/// Most scans that stay open for late scans and for comparison.
pub(crate) const OPEN_SCANS_MAX: usize = 64;

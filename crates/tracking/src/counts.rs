//! Counts of processed, rejected (input) and dropped (for lack of room) items.

/// Counters; never decreasing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackerCounts {
    /// Scans worked off, repetitions after late ones included.
    pub scans: u64,
    /// Scans that came after later scans and were inserted in their place.
    pub late_scans: u64,
    /// Scans rejected: older than every open one, or of an unknown sensor.
    pub rejected_scans: u64,
    /// Detections taken.
    pub detections: u64,
    /// Detections rejected: a value that is no number or cannot be, or no standard deviation.
    pub rejected_detections: u64,
    /// Detections dropped for want of room in the scan.
    pub dropped_detections: u64,
    /// Track–detection comparisons skipped because the track had reached [`COMPARISONS_MAX`](crate::COMPARISONS_MAX).
    pub dropped_comparisons: u64,
    /// Detections in a track's gate that were not considered: others fitted better, or the cluster was full.
    pub dropped_pairs: u64,
    /// Tracks dropped for want of room: not begun, or not kept.
    pub dropped_tracks: u64,
    /// Hypotheses dropped for want of room.
    pub hypotheses_dropped: u64,
    /// Interpretations left out because they have too many new tracks (SP-3, SP-4).
    pub too_many_new_tracks: u64,
    /// Hypotheses dropped because they have too many tentative tracks (SP-5, SP-6).
    pub too_many_tentative_tracks: u64,
    /// Tentative tracks removed because they kept too little company (SP-7).
    pub out_of_company: u64,
    /// New-track columns that SP-1 forbade.
    pub starts_forbidden: u64,
    /// New tracks that began with another track's motion (SP-2).
    pub starts_with_parents_motion: u64,
    /// Hypotheses drawn.
    pub hypotheses_drawn: u64,
    /// Hypotheses that were merged with a hypothesis of the same associations.
    pub hypotheses_merged: u64,
    /// Hypotheses pruned because of low reliability or number.
    pub hypotheses_pruned: u64,
    /// Detections not selected because of their age or accuracy, or kept with less weight (WA-1).
    pub deselected_detections: u64,
    /// Scans that another sensor's at the same time outranks, repetitions after late scans included (WA-1).
    pub outranked_scans: u64,
    /// Wide-area reports taken.
    pub wide_area_reports: u64,
    /// Wide-area reports rejected: no place, a negative or too long delay, too many targets, or no room.
    pub wide_area_reports_rejected: u64,
    /// Wide-area reports, or groups of them, used by a scan, repetitions after late scans included.
    pub wide_area_reports_used: u64,
    /// Reports used that no cluster was near enough to.
    pub wide_area_reports_unmatched: u64,
    /// Clusters with corrected hypotheses or children (WA-4).
    pub wide_area_corrections: u64,
    /// Hypotheses whose children could not be corrected: too many ways to begin the missing tracks.
    pub wide_area_uncorrected: u64,
    /// Tracks given up earlier because a wide-area report shows nothing there (WA-8).
    pub wide_area_deletions: u64,
    /// Tracks confirmed earlier because a wide-area report shows more (WA-6).
    pub wide_area_confirmations: u64,
    /// Emissions taken (WA-9).
    pub emissions: u64,
    /// Emissions rejected: a value that cannot be, too late, no room, or no type described.
    pub emissions_rejected: u64,
    /// Emissions used by a scan, repetitions after late ones included.
    pub emissions_used: u64,
    /// Emissions used with no track, or several tracks, in their direction.
    pub emissions_unclear: u64,
    /// Tentative tracks begun where directions of two sensors cross, repetitions after late scans included.
    pub crossings: u64,
    /// Crossings at which no track was begun, and directions not kept, because there were too many.
    pub crossings_dropped: u64,
    /// Designations of targets that were followed already, counted at their first use.
    pub designations_followed: u64,
    /// Tracks confirmed.
    pub confirmed: u64,
    /// Detections united with another detection of the same scan, nearer than the sensor's resolution.
    pub united_detections: u64,
    /// Updates of clusters, counted per cluster and scan, after joining.
    pub cluster_updates: u64,
    /// Largest share of a cluster's probability that was dropped in a scan, in [0, 1]: an upper bound.
    pub dropped_probability_max: f64,
    /// Sum of those shares over all updates of clusters.
    pub dropped_probability_sum: f64,
}

impl TrackerCounts {
    /// Share of the probability that the bounds and thresholds cut off in the mean update of a cluster (HT-11), in [0,
    /// 1]: an upper bound. 0 before the first.
    pub fn dropped_probability_mean(&self) -> f64 {
        self.dropped_probability_sum / self.cluster_updates.max(1) as f64
    }

    pub(crate) fn drop_probability(&mut self, share: f64) {
        let share = share.clamp(0.0, 1.0);
        self.cluster_updates += 1;
        self.dropped_probability_max = self.dropped_probability_max.max(share);
        self.dropped_probability_sum += share;
    }
}

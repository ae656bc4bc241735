//! Settings of wide-area support, each chosen by itself.
//!
//! Without reports none of it does anything.

use settings::Seconds;

use super::correction::Rule;
use super::distribution::Sharing;
use super::group::Groups;
use super::prior::{Circle, Knowledge};
use super::report::TARGETS_MAX;
use crate::life::{Confirmation, Deletion};
use crate::track::Track;

/// Confirmation where reports show more targets.
fn easier() -> Confirmation {
    Confirmation {
        reliability_min: 0.51,
        ..Confirmation::default()
    }
}

/// Deletion where reports show none: some three scans with a probability of detection of 0.9.
fn earlier() -> Deletion {
    Deletion {
        missed_probability: 1e-3,
        ..Deletion::default()
    }
}

settings::settings! {
    /// Use of a wide-area sensor's reports (WA).
    pub struct WideArea with knowledge: Knowledge {
        /// Correction of reliabilities in the scan in which a report is due (WA-4).
        correction: Option<Rule> = Some(Rule::Share(0.6));
        /// Only clusters with a confirmed track are corrected, so that the search for a second target does not keep the
        /// first one from being believed. `false` is the source's rule.
        corrects_confirmed_only: bool = true;
        /// Correction in the scans after that, for as long as the report is valid: of clusters with a confirmed track,
        /// before the scan only. A small share keeps hypotheses with enough tracks from being dropped until the next
        /// report, without making anything believed; off is the source's rule.
        held: Option<Rule> = Some(Rule::Share(0.1));
        /// Distance from a report at and beyond which clusters are not meant by it (WA-3).
        range_m: f64 = 5000.0, in [1, 1e7];
        /// Clusters with fewer expected tracks are passed over; 0 is the source's rule (WA-3).
        tracks_min: f64 = 0.5, in [0, TARGETS_MAX];
        /// Tracks of other clusters in range are taken off the number first, so that targets that have parted are not
        /// looked for twice (WA-5).
        others_count: bool = true;
        /// Sharing of the number among all clusters in range; off: the nearest cluster gets the whole number (WA-5).
        sharing: Option<Sharing> = None;
        /// Easier confirmation, for clusters with fewer confirmed tracks than reported targets (WA-6).
        confirmation: Option<EarlyConfirmation> = Some(EarlyConfirmation::default());
        /// Earlier deletion, for clusters where a report that covers their place shows none (WA-8).
        deletion: Option<EarlyDeletion> = None;
        /// Publication of unresolved targets as a group (WA-7).
        groups: Option<Groups> = None;
        /// Time after its observation for which a report is used for WA-6, WA-7 and WA-8.
        valid_s: Seconds = Seconds::of(30.0), in [1e-3, 86_400];
        /// Reports that take longer from observation to arrival are refused.
        delay_max_s: Seconds = Seconds::of(120.0), in [0, 86_400];
    }

    /// Easier confirmation (WA-6). The keys of `[confirmation]` set the conditions of a tentative track in this case.
    #[derive(Copy)]
    pub struct EarlyConfirmation with confirmation: Confirmation = easier {
        /// Expected new targets per expected false detection, for hypotheses with fewer tracks than reported.
        new_target_share: f64 = 1.0, in [1e-6, 1e3];
        /// Only in clusters that have a confirmed track, so that no clutter near a report is believed sooner.
        beside_confirmed_only: bool = true;
        /// Least share of the track's detections in gates of confirmed tracks: an unresolved target is near a
        /// confirmed track, clutter usually is not.
        company_min: f64 = 0.5, in [0, 1];
    }

    /// Earlier deletion (WA-8). The keys of `[deletion]` set the conditions of deletion in this case.
    #[derive(Copy)]
    pub struct EarlyDeletion with deletion: Deletion = earlier {
        /// Circle observed by the wide-area sensor: each report excludes further targets in the circle. Without the
        /// key, only reports of zero targets indicate absence, each at its own place.
        coverage: Option<Circle> = None;
    }
}

impl EarlyConfirmation {
    pub(crate) fn is_met(&self, track: &Track) -> bool {
        self.confirmation.is_met(track) && track.company() >= self.company_min
    }
}

impl WideArea {
    /// Returns whether valid reports affect scans without a due report.
    pub(crate) fn lasts(&self) -> bool {
        self.held.is_some() || self.confirmation.is_some() || self.deletion.is_some()
    }

    /// Returns whether the settings affect published tracks.
    pub(crate) fn describes_tracks(&self) -> bool {
        self.groups.is_some() || !self.knowledge.priors.is_empty()
    }
}

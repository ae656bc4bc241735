//! Settings of wide-area support, each chosen by itself.
//!
//! Without reports none of it does anything.

use settings::{Seconds, SettingsError};

use super::correction::Rule;
use super::distribution::Sharing;
use super::group::Groups;
use super::matching::Matching;
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

/// Deletion where reports show none: some three or four scans with a probability of detection of 0.9.
fn earlier() -> Deletion {
    Deletion {
        existence_min: 0.5,
        ..Deletion::default()
    }
}

settings::settings! {
    /// Use of a wide-area sensor's reports (WA).
    pub struct SupportSettings with knowledge: Knowledge {
        check SupportSettings::check;
        /// Correction of reliabilities in the scan in which a report is due (WA-4).
        correction: Option<Rule> = Some(Rule::Share(0.6));
        /// Only clusters with a confirmed track are corrected, so that the search for a second target does not delay
        /// the confirmation of the first target. `false` is the source's rule.
        corrects_confirmed_only: bool = true;
        /// Correction in the following scans while the report is valid: only clusters with a confirmed track, and only
        /// before the scan. A small share keeps hypotheses with enough tracks until the next report, but confirms no
        /// track; off is the source's rule.
        held: Option<Rule> = Some(Rule::Share(0.1));
        /// Distance from a report's place from which on clusters are unaffected by the report (WA-3).
        range_m: f64 = 5000.0, in [1, 1e7];
        /// How reports find their clusters: `nearest`, where reports of the same cluster add up; `one_to_one`, where
        /// reports of the same observation are matched together and no cluster has two of them (WA-3).
        matching: Matching = Matching::Nearest;
        /// Least number of expected tracks of a corrected cluster; 0 is the source's rule (WA-3).
        tracks_min: f64 = 0.5, in [0, TARGETS_MAX];
        /// Tracks of other clusters in range are first subtracted from the number, so that separated targets are not
        /// counted twice (WA-5).
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
        /// Greatest time from observation to arrival; reports that take longer are rejected.
        delay_max_s: Seconds = Seconds::of(120.0), in [0, 86_400];
    }

    /// Easier confirmation (WA-6). The keys of `[confirmation]` set the conditions of a tentative track in this case.
    #[derive(Copy)]
    pub struct EarlyConfirmation with confirmation: Confirmation = easier {
        /// Expected new targets per expected false detection, for hypotheses with fewer tracks than reported.
        new_target_share: f64 = 1.0, in [1e-6, 1e3];
        /// Only in clusters with a confirmed track, so that clutter near a report is not confirmed earlier.
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

impl SupportSettings {
    fn check(&self) -> Result<(), SettingsError> {
        if self.sharing.is_some() && self.matching == Matching::OneToOne {
            let what = "\"one_to_one\" gives each report to one cluster, and sharing to several; leave one of them out";
            return Err(SettingsError::new("matching", what));
        }
        Ok(())
    }

    /// Returns whether valid reports affect scans without a due report.
    pub(crate) fn lasts(&self) -> bool {
        self.held.is_some() || self.confirmation.is_some() || self.deletion.is_some()
    }

    /// Returns whether the settings affect published tracks.
    pub(crate) fn describes_tracks(&self) -> bool {
        self.groups.is_some() || !self.knowledge.priors.is_empty()
    }
}

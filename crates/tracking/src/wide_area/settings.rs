//! What can be chosen of wide-area support, each by itself.
//!
//! Without reports none of it does anything. Times are nanoseconds, lengths metres.

use messages::AXES;

use super::correction::Rule;
use super::distribution::Sharing;
use super::group::Groups;
use super::prior::Knowledge;
use crate::life::{Confirmation, Deletion};
use crate::track::Track;

/// All of it.
#[derive(Clone, Debug, PartialEq)]
pub struct WideArea {
    /// WA-4: how reliabilities are corrected (`None`: not at all).
    pub correction: Option<Rule>,
    /// Only clusters with a confirmed track are corrected, so that the search for a second target does not keep the first one
    /// from being believed. `false` is the source's rule.
    pub corrects_confirmed_only: bool,
    /// How reliabilities are corrected in the scans after that, for as long as the report is valid: of clusters with a
    /// confirmed track, before the scan only. A small share keeps hypotheses with enough tracks from being dropped until
    /// the next report, without making anything believed (`None`: not at all, the source's rule).
    pub held: Option<Rule>,
    /// WA-3: clusters at or beyond this distance from a report are not meant by it.
    pub range_m: f64,
    /// WA-3: clusters with fewer expected tracks are passed over; 0 is the source's rule.
    pub tracks_min: f64,
    /// WA-5: what other clusters in range have in tracks is taken off the number first, so that targets that have parted are
    /// not looked for twice.
    pub others_count: bool,
    /// WA-5: the number is shared among all clusters in range (`None`: the nearest one gets all of it).
    pub sharing: Option<Sharing>,
    /// WA-6: easier confirmation (`None`: as without reports).
    pub confirmation: Option<EarlyConfirmation>,
    /// WA-8: earlier deletion (`None`: as without reports).
    pub deletion: Option<EarlyDeletion>,
    /// WA-7: targets that are not told apart are published as a group (`None`: never).
    pub groups: Option<Groups>,
    /// WA-10: what is known beforehand.
    pub knowledge: Knowledge,
    /// How long after its observation a report says something, for WA-6, WA-7 and WA-8.
    pub valid_ns: i64,
    /// Reports that take longer from observation to arrival are refused.
    pub delay_max_ns: i64,
}

/// WA-6, for clusters with fewer confirmed tracks than reported targets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EarlyConfirmation {
    /// Expected new targets per expected false detection, for hypotheses with fewer tracks than reported.
    pub new_target_share: f64,
    /// Only in clusters that have a confirmed track, so that no clutter near a report is believed sooner.
    pub beside_confirmed_only: bool,
    /// What a tentative track must have instead.
    pub confirmation: Confirmation,
    /// Least share of its detections that lay in confirmed tracks' gates: what is not told apart from a confirmed track is
    /// near it, and clutter mostly is not.
    pub company_min: f64,
}

impl EarlyConfirmation {
    pub(crate) fn is_met(&self, track: &Track) -> bool {
        self.confirmation.is_met(track) && track.company() >= self.company_min
    }
}

/// WA-8, for clusters where a report that covers their place shows none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EarlyDeletion {
    /// When a track is given up instead.
    pub deletion: Deletion,
    /// What the sensor watches, as a circle: each of its reports is taken to say that there is nothing elsewhere in it.
    /// `None`: only reports of no targets speak of absence, and each of its own place.
    pub coverage: Option<Coverage>,
}

/// A circle in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coverage {
    /// East, north, up, metres.
    pub centre_m: [f64; AXES],
    /// Metres.
    pub radius_m: f64,
}

impl Default for EarlyConfirmation {
    fn default() -> Self {
        Self {
            new_target_share: 1.0,
            beside_confirmed_only: true,
            confirmation: Confirmation {
                reliability_min: 0.51,
                detections_min: 2,
                log_likelihood_ratio_min: None,
            },
            company_min: 0.5,
        }
    }
}

impl Default for WideArea {
    fn default() -> Self {
        Self {
            correction: Some(Rule::Share(0.6)),
            corrects_confirmed_only: true,
            held: Some(Rule::Share(0.1)),
            range_m: 5000.0,
            tracks_min: 0.5,
            others_count: true,
            sharing: None,
            confirmation: Some(EarlyConfirmation::default()),
            deletion: None,
            groups: None,
            knowledge: Knowledge::default(),
            valid_ns: 30_000_000_000,
            delay_max_ns: 120_000_000_000,
        }
    }
}

impl WideArea {
    /// What is wrong with the settings, in one sentence; `None` if nothing is.
    pub fn fault(&self) -> Option<String> {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        let checks = [
            (
                [self.correction, self.held]
                    .into_iter()
                    .flatten()
                    .all(|rule| match rule {
                        Rule::Share(share) => share > 0.0 && share < 1.0,
                        Rule::Factor(factor) => factor >= 1.0 && factor.is_finite(),
                    }),
                "a correction's share must lie between 0 and 1, its factor be at least 1",
            ),
            (
                positive(self.range_m),
                "the range of wide-area reports must be positive",
            ),
            (
                self.tracks_min >= 0.0 && self.tracks_min.is_finite(),
                "the least number of expected tracks must not be negative",
            ),
            (
                self.sharing.is_none_or(|sharing| {
                    (1.0..=100.0).contains(&sharing.excess) && sharing.group_m.is_none_or(positive)
                }),
                "shares sum to 1 to 100 times the number, and groups have a positive size",
            ),
            (
                self.confirmation.is_none_or(|early| {
                    let least = early.confirmation.reliability_min;
                    positive(early.new_target_share)
                        && least > 0.5
                        && least <= 1.0
                        && (0.0..=1.0).contains(&early.company_min)
                }),
                "early confirmation needs a positive share of new targets, a reliability above 0.5, at most 1, and a share \
                 of company from 0 to 1",
            ),
            (
                self.deletion.is_none_or(|early| {
                    let Deletion {
                        missed_probability,
                        silent_ns,
                    } = early.deletion;
                    let circle = early.coverage.is_none_or(|circle| {
                        positive(circle.radius_m) && circle.centre_m.iter().all(|value| value.is_finite())
                    });
                    missed_probability > 0.0 && missed_probability < 1.0 && silent_ns > 0 && circle
                }),
                "early deletion must allow tracks to miss something, and a circle of coverage needs a positive radius",
            ),
            (
                self.groups
                    .is_none_or(|groups| groups.probability_min > 0.0 && groups.probability_min <= 1.0),
                "the least probability of groups must be above 0, at most 1",
            ),
            (
                self.valid_ns > 0 && self.delay_max_ns >= 0,
                "reports must be valid for some time, and their longest delay not be negative",
            ),
        ];
        let faulty = checks.iter().find(|(holds, _)| !holds);
        faulty
            .map(|(_, sentence)| (*sentence).to_owned())
            .or_else(|| self.knowledge.fault())
    }

    /// Whether valid reports matter to scans in which none is due.
    pub(crate) fn lasts(&self) -> bool {
        self.held.is_some() || self.confirmation.is_some() || self.deletion.is_some()
    }

    /// Whether they say something of the tracks that are given out.
    pub(crate) fn describes_tracks(&self) -> bool {
        self.groups.is_some() || !self.knowledge.priors.is_empty()
    }
}

//! Records of the tracker's decisions and their reasons.
//!
//! A track gives a target's position, not the reasons for the track: the interpretations, their reliabilities and the
//! decisive evidence. An observer given to [`crate::Tracker::scan_explained`] receives these reasons as records.
//! Records are made from data that exist anyway and are not stored; without an observer, none are made.
//!
//! Order of the records: first the scan. Then for each updated cluster: the fate of the tracks, the correction by a
//! wide-area report, the cluster as a whole, and the hypotheses after reduction, the most reliable first, each with
//! tracks. Tracks that begin at a detection far from all others follow, without a cluster; the published groups come
//! last. After a late scan, the later scans are explained again.

use std::fmt;

use crate::plot::Plot;
use crate::track::{NO_DETECTION, TENTATIVE, Track};

/// Receiver of the records.
pub trait Observer: fmt::Debug {
    /// Takes a record.
    fn explain(&self, what: &Explanation<'_>);
}

/// Record of a decision.
#[derive(Clone, Copy, Debug)]
pub enum Explanation<'a> {
    /// A scan is worked off.
    Scan {
        /// The sensor.
        sensor_id: u32,
        /// Time of the scan, nanoseconds.
        time_ns: i64,
        /// Usable detections.
        detections: usize,
        /// Density of false detections that was assumed, stated (`clutter_density` of the sensor) or learned.
        clutter_density: f64,
    },
    /// A track has changed.
    Track {
        /// The change.
        event: TrackEvent,
        /// The track.
        track: TrackRecord,
        /// Value compared; NaN if nothing was.
        value: f64,
        /// Limit for the value; NaN if there is none.
        limit: f64,
    },
    /// A wide-area report has corrected a cluster's reliabilities (WA-4).
    Correction(CorrectionRecord),
    /// A cluster as a whole.
    Cluster(ClusterRecord<'a>),
    /// A remaining hypothesis of the cluster.
    Hypothesis {
        /// Probability of the hypothesis, in [0, 1].
        reliability: f64,
    },
    /// A track of the hypothesis before.
    Member(TrackRecord),
    /// After a scan: a cluster's tracks are published as a group (WA-7).
    Group {
        /// The group's number.
        number: u32,
        /// Expected number of members.
        members: u32,
        /// Probability that the cluster has fewer tracks than members.
        probability: f64,
        /// The least probability.
        limit: f64,
    },
}

/// Correction of reliabilities by a wide-area report (WA-4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CorrectionRecord {
    /// Targets that the report asks for in the cluster.
    pub targets: f64,
    /// Sum of the reliabilities of the hypotheses with at least so many tracks, before and after.
    pub before: f64,
    /// After.
    pub after: f64,
    /// Set if the hypotheses are the children of this scan; not set for the hypotheses before the scan.
    pub of_children: bool,
}

/// Change of a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackEvent {
    /// The track begins, far from all others: value is the reliability.
    Started,
    /// The track is confirmed: value is the reliability, limit the least.
    Confirmed,
    /// The same earlier than otherwise, because a wide-area report shows more targets (WA-6).
    ConfirmedEarly,
    /// A branch was missed too often for a target that is still there: value that probability, limit the least.
    MissedTooOften,
    /// A branch had no detection for too long: value seconds, limit the most.
    SilentTooLong,
    /// A branch was missed too often, earlier than otherwise, because a wide-area report shows nothing there (WA-8).
    AbsentMissed,
    /// A branch was silent for too long, earlier than otherwise, for the same reason.
    AbsentSilent,
    /// A branch was too rarely in a confirmed track's gate (SP-7): value the share, limit the least.
    OutOfCompany,
    /// No remaining hypothesis contains a branch of the track.
    Ended,
    /// A designation lies in the gate of the track, and changes nothing: value the squared distance, limit the gate.
    Designated,
}

impl TrackEvent {
    /// A branch is given up: missed too often, silent for too long.
    pub(crate) const ENDS: [Self; 2] = [Self::MissedTooOften, Self::SilentTooLong];
    pub(crate) const ABSENT_ENDS: [Self; 2] = [Self::AbsentMissed, Self::AbsentSilent];

    /// The word that tables use.
    pub fn word(self) -> &'static str {
        match self {
            Self::Started => "started",
            Self::Confirmed => "confirmed",
            Self::ConfirmedEarly => "confirmed_early",
            Self::MissedTooOften => "missed_too_often",
            Self::SilentTooLong => "silent_too_long",
            Self::AbsentMissed => "absent_missed_too_often",
            Self::AbsentSilent => "absent_silent_too_long",
            Self::OutOfCompany => "out_of_company",
            Self::Ended => "ended",
            Self::Designated => "designated_again",
        }
    }
}

/// A track, or a branch of a track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackRecord {
    /// Number shared by all branches of the same first detection.
    pub root: u32,
    /// Number of the confirmed track, or 0.
    pub number: u32,
    /// Detections in all.
    pub detections: u32,
    /// Scans since the last detection.
    pub missed: u32,
    /// `detection_id` of the track's detection in this scan.
    pub detection_id: Option<u32>,
    /// Sum over the hypotheses that contain the track, as far as computed yet.
    pub reliability: f64,
    /// Log-likelihood ratio of the detections: from a single target against all false.
    pub log_likelihood_ratio: f64,
}

impl TrackRecord {
    /// `plots` are the detections of the scan; the first has the serial number `first_serial`.
    pub(crate) fn of(track: &Track, plots: &[Plot], first_serial: u32) -> Self {
        let serial = track.history[0];
        let plot = plots.get(serial.wrapping_sub(first_serial) as usize);
        Self {
            root: track.root,
            number: track.number,
            detections: track.detections,
            missed: track.missed,
            detection_id: plot.filter(|_| serial != NO_DETECTION).map(|plot| plot.detection_id),
            reliability: track.reliability,
            log_likelihood_ratio: track.log_likelihood_ratio,
        }
    }

    /// Returns whether the track is confirmed.
    pub fn is_confirmed(&self) -> bool {
        self.number != TENTATIVE
    }
}

/// A processed cluster.
#[derive(Clone, Copy, Debug)]
pub struct ClusterRecord<'a> {
    pub(crate) plots: &'a [Plot],
    pub(crate) of_cluster: &'a [(u32, u32)],
    /// Tracks before the scan, branches included.
    pub tracks: usize,
    /// Hypotheses before the scan.
    pub hypotheses: usize,
    /// Interpretations that were considered: children of hypotheses, likeliest first.
    pub considered: u64,
    /// Interpretations left out by SP-3 to SP-6.
    pub forbidden: u64,
    /// Hypotheses merged with another hypothesis.
    pub merged: u64,
    /// Hypotheses dropped because of low reliability or number.
    pub dropped: u64,
    /// Upper bound of the probability lost with dropped and never considered hypotheses.
    pub dropped_probability: f64,
}

impl ClusterRecord<'_> {
    /// `detection_id` of each of the cluster's detections.
    pub fn detection_ids(&self) -> impl Iterator<Item = u32> {
        self.of_cluster
            .iter()
            .map(|(_, plot)| self.plots[*plot as usize].detection_id)
    }
}

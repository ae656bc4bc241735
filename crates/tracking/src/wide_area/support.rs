//! Interface between the tracker and wide-area support: all calls of the tracker go through this module.
//!
//! A tracker has one [`Support`], and each update of clusters a [`ClusterSupport`] with the content of the reports
//! for these clusters. Without reports, each method returns the value for a tracker without support.

use observations::WideAreaReport;

use super::confirmation;
use super::correction::{Gains, Rule, has_enough, lacking};
use super::description::DescriptionWorkspace;
use super::emission::{Emission, EmissionRejection, Emissions};
use super::expectation::{Expectation, Expectations};
use super::report::{self, ReportList, ReportRejection};
use super::settings::{EarlyConfirmation, SupportSettings};
use crate::counts::TrackerCounts;
use crate::explanation::{CorrectionRecord, Observer};
use crate::hypothesis_store::HypothesisStore;
use crate::life::Deletion;
use crate::population::{Hypothesis, Population};
use crate::settings::Settings;
use crate::track::Track;
use crate::track_report::{BestBranch, TrackReport};

/// Wide-area support of a tracker.
#[derive(Clone, Debug)]
pub(crate) struct Support {
    reports: ReportList,
    emissions: Emissions,
    /// By cluster before the scan at hand.
    expectations: Expectations,
    description: DescriptionWorkspace,
}

impl Support {
    pub(crate) fn new(settings: &SupportSettings, tracks_max: usize) -> Self {
        Self {
            reports: ReportList::new(),
            emissions: Emissions::new(settings.knowledge.types.len()),
            expectations: Expectations::new(tracks_max),
            description: DescriptionWorkspace::new(tracks_max),
        }
    }

    /// Stores a report for scans after `closed_ns` (WA-2), and returns the earliest time of use, nanoseconds.
    ///
    /// # Errors
    /// [`ReportRejection`], counted, if the report cannot be used.
    pub(crate) fn take_report(
        &mut self,
        report: &WideAreaReport,
        closed_ns: i64,
        settings: &SupportSettings,
        counts: &mut TrackerCounts,
    ) -> Result<i64, ReportRejection> {
        let due_ns = report.arrival_ns.max(closed_ns.saturating_add(1));
        let due = WideAreaReport {
            arrival_ns: due_ns,
            ..*report
        };
        report::fault(report, settings.delay_max_s.ns())
            .map_or(Ok(()), Err)
            .and_then(|()| self.reports.keep(due, closed_ns, settings.valid_s.ns()))
            .inspect_err(|_| counts.wide_area_reports_rejected += 1)?;
        counts.wide_area_reports += 1;
        Ok(due_ns)
    }

    /// Stores an emission for scans after `closed_ns` (WA-9), and returns the earliest time of use, nanoseconds.
    ///
    /// # Errors
    /// [`EmissionRejection`], counted, if the emission cannot be used.
    pub(crate) fn take_emission(
        &mut self,
        emission: &Emission,
        closed_ns: i64,
        settings: &SupportSettings,
        counts: &mut TrackerCounts,
    ) -> Result<i64, EmissionRejection> {
        let due_ns = self.emissions.keep(emission, closed_ns, settings.delay_max_s.ns());
        let due_ns = due_ns.inspect_err(|_| counts.emissions_rejected += 1)?;
        counts.emissions += 1;
        Ok(due_ns)
    }

    /// Applies the reports to the clusters before the scan at `time_ns`.
    pub(crate) fn begin_scan(
        &mut self,
        before: &Population,
        time_ns: i64,
        settings: &SupportSettings,
        counts: &mut TrackerCounts,
    ) {
        let reports = self.reports.list();
        self.expectations
            .find(before, time_ns, reports, settings, settings.lasts(), counts);
    }

    /// Whether no report has an effect on any cluster in the scan at hand.
    pub(crate) fn is_silent(&self) -> bool {
        self.expectations.are_none()
    }

    /// Support of clusters that the scan has joined, as (cluster that represents all, cluster), with so many
    /// `confirmed` tracks, branches not counted.
    pub(crate) fn of<'a>(
        &'a self,
        clusters: &'a [(u32, u32)],
        confirmed: usize,
        settings: &'a SupportSettings,
    ) -> ClusterSupport<'a> {
        ClusterSupport {
            settings,
            expectations: &self.expectations,
            clusters,
            confirmed,
        }
    }

    /// Identifies the tracks of `next` from the identification before the scan at `time_ns` (WA-9).
    pub(crate) fn identify(
        &mut self,
        before: &Population,
        next: &mut Population,
        time_ns: i64,
        settings: &SupportSettings,
        counts: &mut TrackerCounts,
    ) {
        let heard = (self.reports.list(), &self.emissions);
        self.description
            .identify(heard, before, next, time_ns, settings, counts);
    }

    /// Adds the identification to the reports of the best branches, and combines the reports of unresolved targets.
    pub(crate) fn amend(
        &mut self,
        population: &Population,
        best: &[BestBranch],
        settings: &Settings,
        observer: Option<&dyn Observer>,
        tracks: &mut Vec<TrackReport>,
    ) {
        let reports = self.reports.list();
        self.description
            .amend(reports, population, best, settings, observer, tracks);
    }
}

/// Support of the update of joined clusters.
#[derive(Clone, Copy)]
pub(crate) struct ClusterSupport<'a> {
    settings: &'a SupportSettings,
    expectations: &'a Expectations,
    clusters: &'a [(u32, u32)],
    confirmed: usize,
}

impl<'a> ClusterSupport<'a> {
    fn expectations(&self) -> impl Iterator<Item = Expectation> + use<'a> {
        let expectations = self.expectations;
        self.clusters.iter().map(|(_, cluster)| expectations.of(*cluster))
    }

    /// WA-4: demand on a cluster, by the rule of a due report, or by the valid rule afterwards.
    pub(crate) fn demand(&self, cluster: u32) -> Demand {
        let expectation = self.expectations.of(cluster);
        let held = self.settings.held;
        let held = held.filter(|_| self.confirmed > 0 && expectation.targets.is_some());
        let correction = self.correction();
        Demand {
            targets: expectation.targets,
            correction: if expectation.is_due { correction } else { held },
            corrects_children: expectation.is_due && correction.is_some(),
        }
    }

    /// Returns whether valid reports show at least as many targets as there are confirmed tracks: then none of several
    /// targets together has gone, though the sensor resolves fewer.
    pub(crate) fn shows_all(&self) -> bool {
        let targets: f64 = self.expectations().filter_map(|expectation| expectation.targets).sum();
        self.confirmed > 1 && targets >= self.confirmed as f64
    }

    /// WA-4: correction rule of the due reports; `None` without a correction.
    pub(crate) fn correction(&self) -> Option<Rule> {
        let settings = self.settings;
        settings
            .correction
            .filter(|_| self.confirmed > 0 || !settings.corrects_confirmed_only)
    }

    /// Number of targets in the due reports.
    pub(crate) fn targets_due(&self) -> f64 {
        let due = self.expectations().filter(|expectation| expectation.is_due);
        due.filter_map(|expectation| expectation.targets).sum()
    }

    /// Expected new targets per expected false detection, for a hypothesis that lacks so many tracks, where otherwise
    /// `plain` are expected (WA-6).
    pub(crate) fn new_target_share(&self, plain: f64, lacking: usize) -> f64 {
        match self.easier_confirmation() {
            Some(early) if lacking > 0 => early.new_target_share.max(plain),
            _ => plain,
        }
    }

    /// WA-8: additional deletion of tracks; `None` without additional deletion.
    pub(crate) fn deletion(&self) -> Option<Deletion> {
        let early = self.settings.deletion?;
        let is_absent = self.expectations().all(|expectation| expectation.is_absent);
        is_absent.then_some(early.deletion)
    }

    /// WA-6: confirms tracks early if reports show more targets than the confirmed tracks account for. Hypotheses agree
    /// on a target by their associations over the last `merge_scans`. `taken_over` receives a track that takes over the
    /// number of another track, the reliability of this track, and the least reliability.
    pub(crate) fn confirm(
        &self,
        store: &mut HypothesisStore,
        merge_scans: usize,
        next_number: &mut u32,
        counts: &mut TrackerCounts,
        taken_over: impl Fn(&Track, f64, f64),
    ) {
        let Some(early) = self.easier_confirmation() else {
            return;
        };
        let targets: f64 = self.expectations().filter_map(|expectation| expectation.targets).sum();
        let mut expected = confirmation::expected(store);
        for place in 0..store.tracks.len() {
            if has_enough(expected.round() as usize, targets) {
                return;
            }
            let track = store.tracks[place];
            if track.is_confirmed() || track.company() < early.company_min {
                continue;
            }
            let reliability = confirmation::on_same_target(store, place, merge_scans);
            let track = Track { reliability, ..track };
            if !early.is_met(&track) {
                continue;
            }
            counts.confirmed += 1;
            counts.wide_area_confirmations += 1;
            if let Some(other) = confirmation::other_history(store, place) {
                confirmation::number(store, place, other.number, other.root);
                taken_over(
                    &store.tracks[place],
                    track.reliability,
                    early.confirmation.reliability_min,
                );
            } else {
                confirmation::number(store, place, *next_number, track.root);
                *next_number = next_number.wrapping_add(1).max(1);
            }
            expected = confirmation::expected(store);
        }
    }

    /// Least reliability of tracks that are confirmed sooner, if any are.
    pub(crate) fn early_reliability_min(&self) -> Option<f64> {
        self.easier_confirmation()
            .map(|early| early.confirmation.reliability_min)
    }

    fn easier_confirmation(&self) -> Option<EarlyConfirmation> {
        let early = self.settings.confirmation;
        early.filter(|early| self.confirmed > 0 || !early.beside_confirmed_only)
    }
}

/// Number of tracks that wide-area reports ask for in a cluster, and how that is enforced.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Demand {
    /// Number of targets, if that is known.
    targets: Option<f64>,
    /// Rule for the reliabilities of the hypotheses; `None` without a correction.
    correction: Option<Rule>,
    /// Set if the reliabilities of the children are corrected, too.
    pub(crate) corrects_children: bool,
}

impl Demand {
    /// Number of tracks that a hypothesis of so many lacks.
    pub(crate) fn lacking(&self, tracks: usize) -> usize {
        self.targets.map_or(0, |targets| lacking(tracks, targets))
    }

    pub(crate) fn is_enough(&self, hypothesis: &Hypothesis) -> bool {
        self.lacking(hypothesis.members.len()) == 0
    }

    /// Gains to be added to the logarithms of these hypotheses' reliabilities.
    pub(crate) fn gains(&self, hypotheses: &[Hypothesis]) -> Gains {
        let rated = hypotheses
            .iter()
            .map(|hypothesis| (hypothesis.log_reliability, self.is_enough(hypothesis)));
        self.correction.map_or(Gains::NONE, |rule| Gains::of_all(rated, rule))
    }

    /// Record of the correction of these hypotheses; `None` without a change.
    pub(crate) fn explained(&self, hypotheses: &[Hypothesis]) -> Option<CorrectionRecord> {
        let gains = self.gains(hypotheses);
        let enough = hypotheses.iter().filter(|hypothesis| self.is_enough(hypothesis));
        let before: f64 = enough.map(|hypothesis| hypothesis.log_reliability.exp()).sum();
        (gains != Gains::NONE).then(|| CorrectionRecord {
            targets: self.targets.unwrap_or(f64::NAN),
            before: before.min(1.0),
            after: (before * gains.gain(true).exp()).min(1.0),
            of_children: false,
        })
    }
}

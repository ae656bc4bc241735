//! Wide-area additions to published tracks: target type and origin (WA-9), and unresolved groups (WA-7).

use estimation::Gaussian;
use messages::TrackState;
use observations::WideAreaReport;

use super::emission::Emissions;
use super::expectation::Expectations;
use super::group::Group;
use super::identification::Whereabouts;
use super::settings::SupportSettings;
use crate::counts::TrackerCounts;
use crate::explanation::{Explanation, Observer};
use crate::motion::MotionSettings;
use crate::population::Population;
use crate::settings::Settings;
use crate::track_report::{BestBranch, TrackReport, find_best, report_of};

/// Working memory, reused for each population.
#[derive(Clone, Debug)]
pub(crate) struct DescriptionWorkspace {
    /// By cluster of the population at hand.
    expectations: Expectations,
    best: Vec<BestBranch>,
}

impl DescriptionWorkspace {
    pub(crate) fn new(tracks_max: usize) -> Self {
        Self {
            expectations: Expectations::new(tracks_max),
            best: Vec::with_capacity(tracks_max),
        }
    }

    /// Derives the identification of the tracks of `next` from the identification before the scan at `time_ns`
    /// (WA-9).
    pub(crate) fn identify(
        &mut self,
        (reports, emissions): (&[WideAreaReport], &Emissions),
        before: &Population,
        next: &mut Population,
        time_ns: i64,
        settings: &SupportSettings,
        counts: &mut TrackerCounts,
    ) {
        let knowledge = &settings.knowledge;
        if knowledge.types.is_empty() {
            return;
        }
        find_best(next, &mut self.best);
        let has_priors = !knowledge.priors.is_empty();
        if has_priors {
            let uncounted = &mut TrackerCounts::default();
            self.expectations
                .find(next, next.time_ns, reports, settings, true, uncounted);
        }
        let (tracks, identities) = (&next.tracks, &mut next.support.identities);
        let numbers = self.best.iter().map(|best| best.number);
        identities.follow(&before.support.identities, numbers);
        if has_priors {
            for (nth, best) in self.best.iter().enumerate() {
                if let Some(origin) = self.expectations.of(best.cluster).origin {
                    identities.came_from(nth, origin);
                }
            }
        }
        for emission in emissions.between(before.support.emissions_ns, time_ns) {
            let best = self.best.iter().map(|best| &tracks[best.track as usize]);
            let heard = best.map(|track| Whereabouts::of(track, emission.time_ns));
            let found = identities.emitted(emission, heard, knowledge);
            counts.emissions_used += 1;
            counts.emissions_unclear += u64::from(found.is_none());
        }
        next.support.emissions_ns = time_ns;
    }

    /// Adds the identification to the reports of the best branches, and combines the reports of unresolved targets.
    pub(crate) fn amend(
        &mut self,
        reports: &[WideAreaReport],
        population: &Population,
        best: &[BestBranch],
        settings: &Settings,
        observer: Option<&dyn Observer>,
        tracks: &mut Vec<TrackReport>,
    ) {
        let wide_area = &settings.wide_area;
        let (describes, uncounted) = (wide_area.describes_tracks(), &mut TrackerCounts::default());
        self.expectations
            .find(population, population.time_ns, reports, wide_area, describes, uncounted);
        let identities = &population.support.identities;
        let mut kept = 0;
        for (nth, branch) in best.iter().enumerate() {
            let group = self.group(population, branch.cluster, wide_area);
            let given_out = match group {
                None => Some(tracks[nth]),
                // The group has the smallest number.
                Some(_) if best[..nth].iter().any(|other| other.cluster == branch.cluster) => None,
                Some(group) => joined(population, branch.cluster, group, settings),
            };
            let Some(report) = given_out else { continue };
            if let (Some(observer), Some(group)) = (observer, group) {
                observer.explain(&Explanation::Group {
                    number: report.number,
                    members: group.members,
                    probability: group.probability,
                    limit: wide_area.groups.map_or(f64::NAN, |groups| groups.probability_min),
                });
            }
            let origin = self.expectations.of(branch.cluster).origin;
            tracks[kept] = TrackReport {
                origin_m: origin.and_then(|origin| origin.reported_m()),
                target_type: identities.target_type(nth, &wide_area.knowledge),
                ..report
            };
            kept += 1;
        }
        tracks.truncate(kept);
    }

    /// WA-7: returns the group of a cluster with unresolved targets.
    fn group(&self, population: &Population, cluster: u32, settings: &SupportSettings) -> Option<Group> {
        let groups = settings.groups?;
        let targets = self.expectations.of(cluster).targets?;
        let hypotheses = &population.clusters[cluster as usize].hypotheses;
        let hypotheses = &population.hypotheses[hypotheses.start as usize..hypotheses.end as usize];
        let rated = hypotheses
            .iter()
            .map(|hypothesis| (hypothesis.log_reliability.exp(), hypothesis.members.len()));
        groups.decide(rated, targets)
    }
}

/// Combines the confirmed tracks of a cluster, including branches: the mean weighted by reliability. `None` without
/// confirmed tracks.
fn joined(population: &Population, cluster: u32, group: Group, settings: &Settings) -> Option<TrackReport> {
    let cluster = &population.clusters[cluster as usize];
    let tracks = population.tracks[cluster.tracks.start as usize..cluster.tracks.end as usize].iter();
    let confirmed = tracks.filter(|track| track.is_confirmed());
    let reports = confirmed.map(|track| report_of(track, cluster, population.time_ns, settings));
    mean_report(reports, group, population.time_ns, &settings.motion)
}

fn mean_report(
    tracks: impl Iterator<Item = TrackReport>,
    group: Group,
    time_ns: i64,
    motion: &MotionSettings,
) -> Option<TrackReport> {
    let mut sum = 0.0;
    let moved = tracks.map(|track| track.moved_to(time_ns, motion.process_noise_m2ps3));
    let joined = moved.reduce(|all, track| {
        sum = if sum == 0.0 { all.reliability } else { sum } + track.reliability;
        let of_one = all.detections >= track.detections;
        TrackReport {
            number: all.number.min(track.number),
            state: if all.missed.min(track.missed) == 0 {
                TrackState::Confirmed
            } else {
                TrackState::Coasted
            },
            estimate: Gaussian::mixture(&all.estimate, &track.estimate, track.reliability / sum),
            reliability: all.reliability.max(track.reliability),
            missed: all.missed.min(track.missed),
            detections: if of_one { all.detections } else { track.detections },
            ..all
        }
    })?;
    Some(TrackReport {
        group: Some(group),
        ..joined
    })
}

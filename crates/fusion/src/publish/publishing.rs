//! Times of weighing system tracks, and the resulting states.

use serde::{Deserialize, Serialize};

use messages::{
    AXES, Contribution, Counter, Covariance, Decision, DecisionKind, SensorTrack, SystemTrack, TrackState,
    sensor_track_bits,
};

use crate::accuracy::Accuracies;
use crate::explanation::Sink;
use crate::publish::outlet::Outlet;
use crate::publish::system_track_message::{list_silent_centres, weight, write};
use crate::publish::weighing::{Weighed, Weigher};
use crate::rules::{self, Candidate, RuleEntry, RuleFunction, RuleMethod};
use crate::settings::{AccuracyBase, BorderSettings, Settings, SourceSet, SourceSettings};
use crate::tables::description::Description;
use crate::tables::sensor_tracks::SensorSlot;
use crate::tables::system_tracks::SystemSlot;
use crate::tables::tracks::Tracks;
use crate::update::filter::TargetFilter;
use crate::update::filter_input::UnseenErrors;
use crate::update::point_errors::unseen_m2;

/// Largest number of joined centres.
const CENTRES_MAX: usize = 8;

/// The weighing of system tracks by the rule.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct TrackPublisher {
    #[serde(with = "rules::by_code")]
    rule: &'static RuleEntry,
    pub(crate) accuracies: Accuracies,
    #[serde(skip)]
    weighed: Box<Weighed>,
    /// See [`Self::set_unseen`].
    unseen: UnseenErrors,
}

impl TrackPublisher {
    /// By `rule`, for these sources.
    pub(crate) fn new(rule: &'static RuleEntry, sources: &[SourceSettings]) -> Self {
        Self {
            rule,
            accuracies: Accuracies::new(sources),
            weighed: Box::default(),
            unseen: UnseenErrors::default(),
        }
    }

    /// Weighs by another rule from now on.
    pub(crate) fn set_rule(&mut self, rule: &'static RuleEntry) {
        self.rule = rule;
    }

    /// The rule for weighing.
    pub(crate) fn rule(&self) -> &'static RuleEntry {
        self.rule
    }

    /// Adds variances to states of the filter, for errors invisible in innovations.
    pub(crate) fn set_unseen(&mut self, unseen: UnseenErrors) {
        self.unseen = unseen;
    }

    pub(crate) fn unseen(&self) -> UnseenErrors {
        self.unseen
    }

    /// Weighs a system track after a report of a primary source, unless states come at uniform times.
    pub(crate) fn refresh<S: Sink>(
        &mut self,
        settings: &Settings,
        tracks: &mut Tracks,
        (system, report): (SystemSlot, &SensorTrack),
        out: &mut Outlet<'_, S>,
    ) {
        let time_ns = tracks.systems.get(system).state.time_ns;
        let reference_ns = time_ns.max(report.time_of_measurement_ns);
        if settings.refresh_s.is_none() {
            self.weigh(settings, tracks, (system, reference_ns, Some(report)), out);
        } else if learns(&settings.sources, report.source) {
            // A report teaches once, even if its system track is weighed several times.
            self.gather(settings, tracks, system, reference_ns);
            self.learn(&settings.sources, report.source);
        }
    }

    /// Weighs every live system track at `time_ns`, in the order of the table.
    pub(crate) fn weigh_all<S: Sink>(
        &mut self,
        settings: &Settings,
        tracks: &mut Tracks,
        time_ns: i64,
        out: &mut Outlet<'_, S>,
    ) {
        for system in tracks.systems.slots() {
            let entry = tracks.systems.get(system);
            let lives = !matches!(entry.life, TrackState::Suspended | TrackState::Terminated);
            if lives && entry.state.time_ns <= time_ns {
                self.weigh(settings, tracks, (system, time_ns, None), out);
            }
        }
    }

    fn gather(&mut self, settings: &Settings, tracks: &Tracks, system: SystemSlot, reference_ns: i64) {
        let weigher = Weigher {
            settings,
            tracks,
            accuracies: &self.accuracies,
            method: self.rule.method,
        };
        weigher.gather(system, reference_ns, &mut self.weighed);
    }

    /// Updates the accuracy of `source` from its residual.
    fn learn(&mut self, sources: &[SourceSettings], source: u16) {
        let mut candidates = self.weighed.candidates().iter();
        if let Some(residual) = candidates.find(|c| c.source == source).and_then(|c| c.residual) {
            self.accuracies.learn(sources, source, residual);
        }
    }

    /// Weighs the contributions to a system track at a reference time, and stores and publishes the state. The cause is
    /// the triggering report.
    fn weigh<S: Sink>(
        &mut self,
        settings: &Settings,
        tracks: &mut Tracks,
        (system, reference_ns, cause): (SystemSlot, i64, Option<&SensorTrack>),
        out: &mut Outlet<'_, S>,
    ) {
        self.gather(settings, tracks, system, reference_ns);
        if let Some(report) = cause
            && learns(&settings.sources, report.source)
        {
            self.learn(&settings.sources, report.source);
        }
        let is_usable = match self.rule.method {
            RuleMethod::Filter => {
                let is_usable = self.weighed.share_out();
                if is_usable {
                    self.take_over_filter(tracks, system, reference_ns);
                }
                is_usable
            }
            RuleMethod::Candidates(rule) => self.fuse(settings, tracks, rule, (system, reference_ns), out),
        };
        if is_usable && settings.exchange && Self::is_exchanged(&settings.border, tracks, system) {
            let weighed = Some(&*self.weighed);
            out.own_track(|message| {
                write(message, settings, tracks, system, cause, weighed);
                list_contributors(message, &settings.sources, tracks.systems.get(system).contributors);
            });
        }
        let has_centres = self.weighed.has_centres();
        let is_usable = has_centres && self.join_centres(tracks, (system, reference_ns), is_usable) || is_usable;
        if !settings.border.regions.is_empty() {
            self.find_owner(&settings.border, tracks, system);
        }
        self.describe(tracks, system);
        if !is_usable {
            let entry = tracks.systems.get_mut(system);
            entry.state = entry.state.at(reference_ns, settings.process_noise_m2ps3);
            if entry.life == TrackState::Confirmed {
                tracks.systems.set_life(system, TrackState::Coasted);
            }
        }
        let weighed = Some(&*self.weighed);
        let is_published = out.track(|message| {
            write(message, settings, tracks, system, cause, weighed);
            if has_centres {
                list_silent_centres(message, tracks, system);
            }
        });
        if !is_published {
            restart(tracks, system);
        }
        tracks.keep(system);
    }

    /// Returns whether other centres receive a system track.
    fn is_exchanged(settings: &BorderSettings, tracks: &Tracks, system: SystemSlot) -> bool {
        let [east, north, _] = tracks.systems.get(system).state.position_m;
        settings.is_in_strip([east, north])
    }

    /// Decides the owner of the target.
    #[cold]
    fn find_owner(&self, settings: &BorderSettings, tracks: &mut Tracks, system: SystemSlot) {
        let entry = tracks.systems.get(system);
        let [east, north, _] = entry.state.position_m;
        let mut ownership = entry.ownership;
        ownership.look(settings, [east, north], entry.state.time_ns);
        for member in self.weighed.members() {
            let latest = &tracks.sensors.get(*member).latest;
            ownership.hear(latest.origin, latest.track_number);
        }
        tracks.systems.get_mut(system).ownership = ownership;
    }

    /// Stores the description of the target by its contributions.
    fn describe(&self, tracks: &mut Tracks, system: SystemSlot) {
        let stated = self.weighed.stated();
        let description = if stated.is_described {
            self.stated_description(tracks)
        } else {
            Description::default()
        };
        let entry = tracks.systems.get_mut(system);
        entry.alerts = stated.alerts;
        entry.on_ground = stated.on_ground;
        entry.description = description;
    }

    #[cold]
    fn stated_description(&self, tracks: &Tracks) -> Description {
        let weights = self.weighed.shares().iter().map(weight).chain(std::iter::repeat(0.0));
        let members = self.weighed.members().iter().zip(weights);
        Description::of(members.map(|(member, weight)| (&tracks.sensors.get(*member).latest, weight)))
    }

    /// Sets the state to the estimate of the target's filter, with the additional variance.
    fn take_over_filter(&self, tracks: &mut Tracks, system: SystemSlot, reference_ns: i64) {
        let points_m2 = match tracks.systems.get(system).has_points {
            true => unseen_m2(tracks, system),
            false => 0.0,
        };
        let entry = tracks.systems.get_mut(system);
        let motion = tracks.sources.motion(entry.filter.velocity_mps());
        entry.filter.write_state_at(reference_ns, motion, &mut entry.state);
        let [velocity_m2ps2, climb_m2ps2] = entry.filter.unnoticed_m2ps2(motion);
        let variances = &mut entry.state.covariance.upper;
        for axis in 0..2 {
            let velocity = axis + AXES;
            variances[Covariance::index(axis, axis)] += self.unseen.per_axis_m2 + points_m2;
            variances[Covariance::index(velocity, velocity)] += velocity_m2ps2;
        }
        // The point to be kept may soon be another.
        let [east_m, north_m] = entry.aside_m.map(f64::from);
        for ((row, column), m2) in [
            ((0, 0), east_m * east_m),
            ((0, 1), east_m * north_m),
            ((1, 1), north_m * north_m),
        ] {
            variances[Covariance::index(row, column)] += m2;
        }
        let climb = 2 + AXES;
        variances[Covariance::index(climb, climb)] += climb_m2ps2;
        if tracks.sources.has_coarse_stamps() {
            self.widen_along_course(tracks, system);
        }
        if tracks.sources.has_slow_heights() {
            self.widen_height(tracks, system);
        }
    }

    /// Adds slow errors of heights to the covariance of a state.
    #[cold]
    fn widen_height(&self, tracks: &mut Tracks, system: SystemSlot) {
        let shares = self.weighed.candidates().iter().zip(self.weighed.shares());
        let weights = shares.map(|(candidate, share)| (candidate.source, share.weight[2]));
        let height_m2 = tracks.sources.height_m2(weights);
        tracks.systems.get_mut(system).state.covariance.upper[Covariance::index(2, 2)] += height_m2;
    }

    /// Adds the errors of coarse time stamps to the covariance of a state.
    #[cold]
    fn widen_along_course(&self, tracks: &mut Tracks, system: SystemSlot) {
        let shares = self.weighed.candidates().iter().zip(self.weighed.shares());
        let weights = shares.map(|(candidate, share)| (candidate.source, share.weight[0]));
        let course_s2 = tracks.sources.course_s2(weights);
        let state = &mut tracks.systems.get_mut(system).state;
        state.covariance.widen_along_course(state.velocity_mps, course_s2);
    }

    /// Sets the state to the result of `rule` for the contributions; `false` if the rule can use none.
    fn fuse<S: Sink>(
        &mut self,
        settings: &Settings,
        tracks: &mut Tracks,
        rule: RuleFunction,
        (system, reference_ns): (SystemSlot, i64),
        out: &mut Outlet<'_, S>,
    ) -> bool {
        let (entry, memory) = tracks.systems.get_with_memory(system);
        let last = memory.selected[0];
        let fused = self.weighed.fuse(rule, settings, &entry.state, memory, reference_ns);
        let (chosen, is_usable) = (memory.selected[0], fused.is_some());
        if let Some(state) = fused {
            entry.state = state;
        }
        if last != chosen && last != rules::NO_SOURCE {
            out.count(chosen, Counter::HandOvers);
            out.decision(&self.hand_over(entry.number, reference_ns, (last, chosen)));
        }
        for (share, candidate) in self.weighed.shares().iter().zip(self.weighed.candidates()) {
            if share.trace_unusable {
                out.count(candidate.source, Counter::TracesRejected);
            }
            if share.repaired {
                out.count(candidate.source, Counter::CovariancesRepaired);
            }
        }
        is_usable
    }

    /// Joins the state of the local sources, if it `is_usable`, with the states of other centres; returns whether there
    /// are any.
    #[cold]
    fn join_centres(
        &mut self,
        tracks: &mut Tracks,
        (system, reference_ns): (SystemSlot, i64),
        is_usable: bool,
    ) -> bool {
        let is_foreign = |member: SensorSlot| tracks.sensors.get(member).is_foreign;
        if !tracks.contributing(system, reference_ns).any(is_foreign) {
            return false;
        }
        let mut centres = [(SensorSlot::default(), Candidate::default()); CENTRES_MAX];
        let entry = tracks.systems.get(system);
        let (mut count, mut shares_none) = (0, true);
        for member in tracks.contributing(system, reference_ns) {
            let centre = tracks.sensors.get(member);
            if !centre.is_foreign || count == CENTRES_MAX {
                continue;
            }
            let latest = TargetFilter::of_report(&centre.latest);
            let candidate = Candidate {
                source: centre.source,
                state: latest.state_at(reference_ns, tracks.sources.motion(latest.velocity_mps())),
                ..Candidate::default()
            };
            let knows = centre.latest.has(sensor_track_bits::CONTRIBUTORS);
            shares_none &= knows
                && !entry
                    .contributors
                    .meets(SourceSet::of_bits([centre.latest.shared_sources, 0]));
            centres[count] = (member, candidate);
            count += 1;
        }
        let centres = &mut centres[..count];
        centres.sort_unstable_by_key(|(_, candidate)| candidate.source);
        let own = is_usable.then_some(&entry.state);
        let joined = self.weighed.join_centres(own, centres, shares_none);
        self.weighed.collect_stated(tracks);
        if let Some(state) = joined {
            tracks.systems.get_mut(system).state = state;
        }
        joined.is_some()
    }

    fn hand_over(&self, system_track: u32, time_ns: i64, (last, chosen): (u16, u16)) -> Decision {
        let accuracy = |source: u16| {
            let mut candidates = self.weighed.candidates().iter();
            candidates
                .find(|candidate| candidate.source == source)
                .map_or(f64::NAN, |candidate| candidate.lambda)
        };
        Decision {
            time_ns,
            kind: DecisionKind::HandOver.code(),
            system_track,
            source: chosen,
            other_source: last,
            value: accuracy(chosen),
            limit: accuracy(last),
            ..Decision::default()
        }
    }
}

/// Lists, after the contributions, `contributors` without a present contribution: their information
/// is in the state.
fn list_contributors(message: &mut SystemTrack, sources: &[SourceSettings], contributors: SourceSet) {
    for (number, source) in (0..).zip(sources) {
        let is_listed = message.contributions().iter().any(|listed| listed.source == number);
        if !contributors.contains(number) || is_listed {
            continue;
        }
        message.source_count += 1;
        if let Some(place) = message.contributions.get_mut(usize::from(message.contribution_count)) {
            *place = Contribution {
                source: number,
                sensor_uid: source.sensor_uid,
                accuracy: f64::NAN,
                ..Contribution::default()
            };
            message.contribution_count += 1;
        }
    }
}

/// Restarts a state with non-finite values from the latest report of a member.
#[cold]
fn restart(tracks: &mut Tracks, system: SystemSlot) {
    if let Some(member) = tracks.systems.get(system).members {
        tracks.restart_filter(member);
    }
    tracks.systems.forget_state(system);
}

/// Whether the accuracy of `source` is estimated from its reports.
fn learns(sources: &[SourceSettings], source: u16) -> bool {
    let accuracy = &sources[usize::from(source)].accuracy;
    matches!(accuracy.base, AccuracyBase::Estimated { .. })
}

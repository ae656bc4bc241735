//! When a system track is weighed, and what is said of it.

use messages::{
    AXES, Contribution, Counter, Covariance, NO_SOURCE, SensorTrack, StageTimes, SystemTrack, TrackState,
    contribution_bits,
};

use crate::description::Description;
use crate::engine::Engine;
use crate::explanation::{Decision, DecisionKind, Sink};
use crate::rules::{self, Fuse, Method, Share};
use crate::settings::AccuracyBase;
use crate::system_tracks::SystemSlot;
use crate::weighing::{Weighed, Weigher};

impl Engine {
    /// A report of a speaker has been taken: unless states come at uniform times, its system track is weighed anew.
    pub(crate) fn refresh(&mut self, system: SystemSlot, report: &SensorTrack, sink: &mut impl Sink) {
        let time_ns = self.systems.get(system).state.time_ns;
        let reference_ns = time_ns.max(report.time_of_measurement_ns);
        if self.settings.refresh_ns.is_none() {
            self.weigh(system, reference_ns, Some(report), sink);
        } else if self.learns(report.source)
            && let Some(mut weighed) = self.weighed.take()
        {
            // A report teaches once, however often its system track is weighed.
            self.weigher().gather(system, reference_ns, &mut weighed);
            self.learn(report.source, &weighed);
            self.weighed = Some(weighed);
        }
    }

    fn weigher(&self) -> Weigher<'_> {
        Weigher {
            search: self.search(),
            accuracies: &self.accuracies,
        }
    }

    fn learns(&self, source: u16) -> bool {
        let accuracy = &self.settings.sources[usize::from(source)].accuracy;
        matches!(accuracy.base, AccuracyBase::Estimated { .. })
    }

    /// Lets the accuracy of `source` learn from its residual.
    fn learn(&mut self, source: u16, weighed: &Weighed) {
        let mut candidates = weighed.candidates().iter();
        if let Some(residual) = candidates.find(|c| c.source == source).and_then(|c| c.residual) {
            self.accuracies.learn(&self.settings, source, residual);
        }
    }

    /// Weighs the contributions to `system` at `reference_ns`, stores what comes out and hands it to `sink`. `cause` is
    /// the report that made it necessary.
    fn weigh(&mut self, system: SystemSlot, reference_ns: i64, cause: Option<&SensorTrack>, sink: &mut impl Sink) {
        let Some(mut weighed) = self.weighed.take() else {
            return;
        };
        self.weigher().gather(system, reference_ns, &mut weighed);
        if let Some(report) = cause
            && self.learns(report.source)
        {
            self.learn(report.source, &weighed);
        }
        self.fuse(system, reference_ns, &mut weighed, sink);
        sink.track(&self.message(system, cause, Some(&weighed)));
        self.weighed = Some(weighed);
    }

    /// Lets the rule weigh what was gathered, and stores the state that comes out.
    fn fuse(&mut self, system: SystemSlot, reference_ns: i64, weighed: &mut Weighed, sink: &mut impl Sink) {
        let usable = match self.settings.rule.rule.method {
            Method::Filter => weighed.share_out() && self.take_over_filter(system, reference_ns),
            Method::Candidates(rule) => self.fuse_candidates(rule, system, reference_ns, weighed, sink),
        };
        let members = weighed.members().iter().map(|member| self.sensors.get(*member));
        let said = members.map(|member| (member.alerts, member.on_ground, member.is_described));
        let (alerts, on_ground, is_described) = said.fold((0, false, false), |all, one| {
            (all.0 | one.0, all.1 | one.1, all.2 | one.2)
        });
        let description = if is_described {
            self.described(weighed)
        } else {
            Description::default()
        };
        let entry = self.systems.get_mut(system);
        entry.alerts = alerts;
        entry.on_ground = on_ground;
        entry.description = description;
        if !usable {
            entry.state = entry.state.at(reference_ns, self.settings.process_noise_m2ps3);
            if entry.life == TrackState::Confirmed {
                self.systems.set_life(system, TrackState::Coasted);
            }
        }
    }

    /// What the contributions say that the target is.
    fn described(&self, weighed: &Weighed) -> Description {
        let weights = weighed.shares().iter().map(weight).chain(std::iter::repeat(0.0));
        let members = weighed.members().iter().zip(weights);
        Description::of(members.map(|(member, weight)| (&self.sensors.get(*member).latest, weight)))
    }

    /// Makes the estimate of the target's filter its state.
    fn take_over_filter(&mut self, system: SystemSlot, reference_ns: i64) -> bool {
        let entry = self.systems.get_mut(system);
        entry.state = entry.filter.state_at(reference_ns, &self.motion);
        for axis in 0..2 {
            entry.state.covariance.upper[Covariance::index(axis, axis)] += self.point_spread_m2;
        }
        true
    }

    /// Makes the target's state what `rule` makes of the contributions; `false` if it can use none of them.
    fn fuse_candidates(
        &mut self,
        rule: Fuse,
        system: SystemSlot,
        reference_ns: i64,
        weighed: &mut Weighed,
        sink: &mut impl Sink,
    ) -> bool {
        let (entry, memory) = self.systems.get_with_memory(system);
        let last = memory.selected[0];
        let fused = weighed.fuse(rule, &self.settings, &entry.state, memory, reference_ns);
        let (chosen, usable) = (memory.selected[0], fused.is_some());
        if let Some(state) = fused {
            entry.state = state;
        }
        if last != chosen && last != rules::NO_SOURCE {
            self.counts.add(chosen, Counter::HandOvers);
            self.tell_hand_over(system, reference_ns, (last, chosen), weighed, sink);
        }
        for (share, candidate) in weighed.shares().iter().zip(weighed.candidates()) {
            if share.trace_unusable {
                self.counts.add(candidate.source, Counter::TracesRejected);
            }
            if share.repaired {
                self.counts.add(candidate.source, Counter::CovariancesRepaired);
            }
        }
        usable
    }

    fn tell_hand_over(
        &self,
        system: SystemSlot,
        time_ns: i64,
        (last, chosen): (u16, u16),
        weighed: &Weighed,
        sink: &mut impl Sink,
    ) {
        let accuracy = |source: u16| {
            let mut candidates = weighed.candidates().iter();
            candidates
                .find(|candidate| candidate.source == source)
                .map_or(f64::NAN, |candidate| candidate.lambda)
        };
        sink.decision(&Decision {
            time_ns,
            kind: DecisionKind::HandOver,
            system_track: self.systems.get(system).number,
            other_system_track: 0,
            source: chosen,
            other_source: last,
            sensor_track: 0,
            value: accuracy(chosen),
            limit: accuracy(last),
        });
    }

    /// Weighs every live system track at `time_ns`, in the order of their places in the table.
    pub(crate) fn weigh_all(&mut self, time_ns: i64, sink: &mut impl Sink) {
        for system in self.systems.slots() {
            let entry = self.systems.get(system);
            if entry.life != TrackState::Terminated && entry.state.time_ns <= time_ns {
                self.weigh(system, time_ns, None, sink);
            }
        }
    }

    /// The life of a system track has changed without a report. At uniform times, the next refresh shows it.
    pub(crate) fn tell(&mut self, slot: SystemSlot, now_ns: i64, sink: &mut impl Sink) {
        if self.settings.refresh_ns.is_none() {
            self.tell_carried_on(slot, now_ns, sink);
        }
    }

    /// Hands out the state as it is carried on.
    pub(crate) fn tell_carried_on(&mut self, slot: SystemSlot, now_ns: i64, sink: &mut impl Sink) {
        let process_noise = self.settings.process_noise_m2ps3;
        let entry = self.systems.get_mut(slot);
        entry.state = entry.state.at(now_ns.max(entry.state.time_ns), process_noise);
        sink.track(&self.message(slot, None, None));
    }

    fn message(&self, slot: SystemSlot, cause: Option<&SensorTrack>, weighed: Option<&Weighed>) -> SystemTrack {
        let entry = self.systems.get(slot);
        let members = weighed.map_or(&[][..], Weighed::members);
        let shares = weighed.map_or(&[][..], Weighed::shares);
        let candidates = weighed.map_or(&[][..], Weighed::candidates);
        let mut message = SystemTrack {
            reference_time_ns: entry.state.time_ns,
            time_of_measurement_ns: cause.map_or(entry.state.time_ns, |report| report.time_of_measurement_ns),
            stages: cause.map_or(StageTimes::default(), |report| report.stages),
            track_number: entry.number,
            trigger_source: cause.map_or(NO_SOURCE, |report| report.source),
            selected_source: NO_SOURCE,
            identity: entry.identity,
            position_m: entry.state.position_m,
            velocity_mps: entry.state.velocity_mps,
            covariance: entry.state.covariance,
            source_count: members.len() as u16,
            contribution_count: members.len() as u16,
            state: entry.life as u8,
            height_valid: u8::from(entry.state.has_height),
            rule: self.settings.rule.rule.code.code(),
            alerts: entry.alerts,
            merged_into: entry.merged_into,
            on_ground: u8::from(entry.on_ground),
            kind: entry.description.kind as u8,
            members: entry.description.members,
            target_type: entry.description.target_type,
            ..SystemTrack::default()
        };
        let mut heaviest = 0.0;
        for (index, share) in shares.iter().enumerate() {
            let member = self.sensors.get(members[index]);
            let weight = weight(share);
            let fresh = if candidates[index].stale {
                0
            } else {
                contribution_bits::FRESH
            };
            let scored = if share.accuracy.is_finite() {
                contribution_bits::SCORED
            } else {
                0
            };
            message.contributions[index] = Contribution {
                time_of_measurement_ns: member.time_ns,
                track_number: member.track_number,
                source: member.source,
                flags: fresh | scored,
                weight,
                accuracy: if share.accuracy.is_finite() {
                    share.accuracy
                } else {
                    f64::NAN
                },
                sensor_uid: self.settings.sources[usize::from(member.source)].sensor_uid,
                ..Contribution::default()
            };
            if weight > heaviest {
                heaviest = weight;
                message.selected_source = member.source;
            }
        }
        message
    }
}

/// Mean over the axes of what a contribution weighs.
fn weight(share: &Share) -> f64 {
    share.weight.iter().sum::<f64>() / AXES as f64
}

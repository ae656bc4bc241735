//! The life of a system track: tentative, confirmed, coasted, terminated (QF-8), by evidence where there is any.

use messages::{Counter, NO_SOURCE, SensorTrack, TrackState};

use crate::engine::Engine;
use crate::existence::{Claim, GONE, MISSES_MAX};
use crate::explanation::{Decision, DecisionKind, Sink};
use crate::system_tracks::SystemSlot;

/// Time between two looks, per system track, at which sources follow it, nanoseconds.
const COVERAGE_EVERY_NS: i64 = 4_000_000_000;

/// Periods that a source needs to find a target: its silence before says nothing.
const CHANCE_PERIODS: i64 = 3;
/// A source that follows fewer targets than this here need not be waited for.
const FOLLOWS_SELDOM: f64 = 0.1;

impl Engine {
    /// A report has come in: is there enough evidence now to show the system track?
    pub(crate) fn judge_existence(&mut self, system: SystemSlot, report: &SensorTrack, sink: &mut impl Sink) {
        let entry = self.systems.get(system);
        let now_ns = report.time_of_measurement_ns;
        match entry.life {
            TrackState::Coasted => self.systems.set_life(system, TrackState::Confirmed),
            TrackState::Tentative => {
                let (believed, worth) = self.evidence(system, now_ns);
                if believed {
                    self.systems.set_life(system, TrackState::Confirmed);
                    let first = !std::mem::replace(&mut self.systems.get_mut(system).was_shown, true);
                    if first {
                        self.counts.add(report.source, Counter::TracksConfirmed);
                    }
                    self.decide_on(system, DecisionKind::Confirmed, now_ns, worth, sink);
                }
            }
            TrackState::Confirmed if now_ns >= entry.coverage_due_ns => self.learn_coverage(system, now_ns),
            TrackState::Confirmed | TrackState::Terminated => {}
        }
    }

    /// Whether there is a target, and what that rests on: the number of sources, or what a single one's claim is worth.
    fn evidence(&self, system: SystemSlot, now_ns: i64) -> (bool, f64) {
        let search = self.search();
        let (mut sources, mut established, mut reports) = (0u64, 0u32, 0u32);
        for member in search.fresh_primaries(system, now_ns) {
            let entry = self.sensors.get(member);
            sources |= 1 << entry.source;
            established += u32::from(search.is_established(member));
            reports = reports.saturating_add(entry.reports);
        }
        if reports < self.settings.life.confirm_reports {
            return (false, f64::NAN);
        }
        if established >= 2 {
            return (true, f64::from(established));
        }
        let entry = self.systems.get(system);
        let age_ns = now_ns - entry.first_seen.0;
        let (mut silence, mut had_their_chance) = (0.0, true);
        for source in 0..self.settings.sources.len() as u16 {
            if sources & (1 << source) == 0 && self.may_see(source, system) {
                let follows = self.coverage.follows(source, entry.filter.estimate.position_m());
                let period_ns = self.settings.sources[usize::from(source)].period_ns;
                silence += (1.0 - follows).ln();
                had_their_chance &= follows < FOLLOWS_SELDOM || age_ns >= CHANCE_PERIODS * period_ns;
            }
        }
        let claim = Claim {
            silence,
            reports,
            has_address: entry.identity.unique_number().is_some(),
        };
        (
            claim.is_believed() && (had_their_chance || claim.has_address),
            claim.worth(),
        )
    }

    /// Whether the target is not higher than the source can see.
    fn may_see(&self, source: u16, system: SystemSlot) -> bool {
        let filter = &self.systems.get(system).filter;
        !filter.has_height || filter.estimate.mean[2] <= self.settings.sources[usize::from(source)].ceiling_m
    }

    /// Notes which sources follow a confirmed track here.
    fn learn_coverage(&mut self, system: SystemSlot, now_ns: i64) {
        let sources = self.search().sources_of(system, now_ns);
        let entry = self.systems.get_mut(system);
        entry.coverage_due_ns = now_ns.saturating_add(COVERAGE_EVERY_NS);
        let [x, y, _] = entry.filter.estimate.position_m();
        self.coverage.learn(x, y, |source| sources & (1 << source) != 0);
    }

    /// A contributing source has seen nothing, `misses` times in a row.
    pub(crate) fn count_miss(&mut self, system: SystemSlot, report: &SensorTrack, misses: u32, sink: &mut impl Sink) {
        let model = &mut self.models[usize::from(report.source)];
        let entry = self.systems.get_mut(system);
        if entry.life == TrackState::Tentative {
            return;
        }
        model.learn_detection(false);
        if misses <= MISSES_MAX {
            entry.absence += (1.0 - model.detection).ln();
        }
        if entry.absence < GONE {
            self.withhold(system, report.time_of_measurement_ns, sink);
        }
    }

    /// The sources say that they no longer see the target: it is not shown until one does.
    pub(crate) fn withhold(&mut self, system: SystemSlot, now_ns: i64, sink: &mut impl Sink) {
        let entry = self.systems.get(system);
        if !matches!(entry.life, TrackState::Confirmed | TrackState::Coasted) {
            return;
        }
        let absence = entry.absence;
        self.systems.set_life(system, TrackState::Tentative);
        self.decide_on(system, DecisionKind::Withheld, now_ns, absence, sink);
        self.tell(system, now_ns, sink);
    }

    /// Works off the earliest deadline before `time_ns`, up to which nothing else happens; whether there was one.
    pub(crate) fn meet_deadline_before(&mut self, time_ns: i64, sink: &mut impl Sink) -> bool {
        let Some((deadline_ns, slot)) = self.systems.due_before(time_ns) else {
            return false;
        };
        if let Some(due_ns) = self.meet_deadline(slot, deadline_ns, sink) {
            self.systems
                .put_back(slot, due_ns.min(self.look_after(deadline_ns, time_ns)));
        } else {
            self.systems.free(slot);
        }
        true
    }

    /// When the deadline of a system track that was looked at at `looked_ns` must be looked at again, if until `until_ns`
    /// nothing can bring it forward: looks lie whole multiples of the shortest time apart in which that may happen.
    fn look_after(&self, looked_ns: i64, until_ns: i64) -> i64 {
        let step_ns = self.shortest_fresh_ns;
        let missing_ns = until_ns.saturating_sub(looked_ns).saturating_sub(1);
        let whole_ns = if missing_ns < step_ns {
            0
        } else {
            missing_ns - missing_ns % step_ns
        };
        looked_ns.saturating_add(whole_ns).saturating_add(step_ns)
    }

    /// A deadline of `slot` has come up: it coasts or ends, or it is too early. When the next one is due; `None` if it has
    /// ended.
    fn meet_deadline(&mut self, slot: SystemSlot, deadline_ns: i64, sink: &mut impl Sink) -> Option<i64> {
        let life = self.settings.life;
        let entry = self.systems.get(slot);
        let (coast_ns, last_ns) = (entry.fresh_until_ns, entry.last_report_ns);
        let end_ns = last_ns.saturating_add(life.terminate_ns);
        let due_ns = match entry.life {
            TrackState::Terminated => return None,
            TrackState::Tentative if entry.was_shown => end_ns,
            TrackState::Tentative => last_ns.saturating_add(life.tentative_ns),
            TrackState::Confirmed => coast_ns,
            TrackState::Coasted => end_ns,
        };
        if deadline_ns < due_ns {
            return Some(due_ns);
        }
        if entry.life == TrackState::Confirmed && coast_ns < end_ns {
            self.systems.set_life(slot, TrackState::Coasted);
            self.decide_on(slot, DecisionKind::Coasted, deadline_ns, f64::NAN, sink);
            self.tell(slot, deadline_ns, sink);
            return Some(end_ns);
        }
        self.end(slot, deadline_ns, 0, sink);
        None
    }

    /// Ends a system track; its remaining sensor tracks, all stale, go with it.
    pub(crate) fn end(&mut self, slot: SystemSlot, now_ns: i64, merged_into: u32, sink: &mut impl Sink) {
        while let Some(member) = self.systems.get(slot).members {
            self.drop_sensor_track(member);
        }
        self.systems.end(slot);
        self.systems.get_mut(slot).merged_into = merged_into;
        self.counts.add(NO_SOURCE, Counter::TracksTerminated);
        self.decide_on(slot, DecisionKind::Ended, now_ns, f64::NAN, sink);
        self.tell_carried_on(slot, now_ns, sink);
    }

    pub(crate) fn decide_on(
        &self,
        system: SystemSlot,
        kind: DecisionKind,
        time_ns: i64,
        value: f64,
        sink: &mut impl Sink,
    ) {
        sink.decision(&Decision {
            time_ns,
            kind,
            system_track: self.systems.get(system).number,
            other_system_track: self.systems.get(system).merged_into,
            source: NO_SOURCE,
            other_source: NO_SOURCE,
            sensor_track: 0,
            value,
            limit: f64::NAN,
        });
    }
}

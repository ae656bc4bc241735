//! The engine: one report in, the states of the system tracks it changes out.

use messages::{
    AXES, CONTRIBUTIONS_MAX, Contribution, Counter, NO_SOURCE, STATE_LEN, SensorTrack, StageTimes, SystemTrack,
    TrackState, contribution_bits, sensor_track_bits,
};

use crate::accuracy::Accuracies;
use crate::association_step::Search;
use crate::counts::Counts;
use crate::rules;
use crate::sensor_tracks::{NO_SYSTEM, Role, SensorSlot, SensorTracks};
use crate::settings::{AccuracyBase, Settings, SettingsError};
use crate::state::State;
use crate::system_tracks::{SystemSlot, SystemTracks};
use crate::weighing::{Weighed, Weigher};

/// Fusion of sensor tracks into system tracks.
#[derive(Debug)]
pub struct Engine {
    settings: Settings,
    sensors: SensorTracks,
    systems: SystemTracks,
    accuracies: Accuracies,
    counts: Counts,
    /// No entry is left unlooked-at for longer than this, so that its deadline can be put off but never missed.
    shortest_fresh_ns: i64,
    /// The next whole multiple of the refresh time; `None` before the first report, and where reports refresh.
    next_refresh_ns: Option<i64>,
}

impl Engine {
    /// An engine with all tables allocated.
    ///
    /// # Errors
    /// If a setting cannot work.
    pub fn new(settings: Settings) -> Result<Self, SettingsError> {
        settings.check()?;
        let capacity = settings.capacity;
        let sources = settings.sources.len();
        Ok(Self {
            sensors: SensorTracks::new(capacity.sensor_tracks, capacity.stored_reports),
            systems: SystemTracks::new(capacity.system_tracks, settings.association.cell_m),
            accuracies: Accuracies::new(sources),
            counts: Counts::new(sources),
            shortest_fresh_ns: settings.sources.iter().map(|source| source.fresh_ns).min().unwrap_or(1),
            next_refresh_ns: None,
            settings,
        })
    }

    /// What has been counted so far.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }

    /// How many system tracks are in `state` now.
    pub fn count_in_state(&self, state: TrackState) -> usize {
        self.systems.count_in_state(state)
    }

    /// For what the caller counts on the engine's behalf: losses and queues lie before it.
    pub fn counts_mut(&mut self) -> &mut Counts {
        &mut self.counts
    }

    /// The settings it runs with.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// From now on the named condition (weather) holds (TI-7); "normal" at the start. `false` if no source names it: then
    /// nothing changes.
    pub fn set_condition(&mut self, name: &str) -> bool {
        self.accuracies.set_condition(&self.settings, name)
    }

    /// Lets time pass up to `now_ns` (UTC): no report measured before that will follow. System tracks whose
    /// contributions have become too old coast, then end; each such change is handed to `sink`. With a refresh time set,
    /// so is the state of every system track at each whole multiple of it.
    pub fn advance(&mut self, now_ns: i64, sink: &mut impl FnMut(&SystemTrack)) {
        while let Some(refresh_ns) = self.refresh_due_before(now_ns) {
            self.meet_deadlines(refresh_ns + self.settings.refresh_delay_ns, sink);
            self.refresh_all(refresh_ns, sink);
        }
        self.meet_deadlines(now_ns, sink);
    }

    fn meet_deadlines(&mut self, now_ns: i64, sink: &mut impl FnMut(&SystemTrack)) {
        while let Some((deadline_ns, slot)) = self.systems.due_before(now_ns) {
            self.meet_deadline(slot, deadline_ns, sink);
        }
    }

    /// Takes one report. Every system-track state that it changes is handed to `sink`.
    ///
    /// Reports should come in the order of their times; one older than its own sensor track's latest is refused.
    pub fn take(&mut self, report: &SensorTrack, sink: &mut impl FnMut(&SystemTrack)) {
        if !self.is_valid(report) {
            self.counts.add(report.source, Counter::Invalid);
            return;
        }
        self.advance(report.time_of_measurement_ns, sink);
        if report.state == TrackState::Coasted as u8 {
            // The source has seen nothing. Its extrapolation agrees with itself perfectly, which says nothing about the
            // target: scored like an observation, it would win. So it is a missing report (TI-4).
            self.counts.add(report.source, Counter::Extrapolated);
            return;
        }
        let Some(sensor) = self.store(report) else {
            return;
        };
        if report.state == TrackState::Terminated as u8 {
            self.drop_sensor_track(sensor);
            self.counts.add(report.source, Counter::TracksEnded);
            return;
        }
        if self.sensors.get(sensor).system == NO_SYSTEM {
            if !self.associate(sensor, None) {
                self.sensors.remove(sensor);
                return;
            }
        } else {
            self.reconsider(sensor, sink);
        }
        self.assign_role(sensor);
        if self.sensors.get(sensor).role == Role::Primary {
            self.refresh(sensor, sink);
        } else {
            self.counts.add(report.source, Counter::Duplicates);
        }
    }

    fn is_valid(&self, report: &SensorTrack) -> bool {
        let numbers = report
            .position_m
            .iter()
            .chain(&report.velocity_mps)
            .chain(&report.covariance.upper);
        usize::from(report.source) < self.settings.sources.len()
            && TrackState::from_code(report.state).is_some()
            && numbers.into_iter().all(|value| value.is_finite())
            && (0..STATE_LEN).all(|index| report.covariance.get(index, index) >= 0.0)
            && (0..2).all(|index| report.covariance.get(index, index) > 0.0)
    }

    /// Stores the report in its sensor track's entry, a new one if need be (then not linked yet).
    fn store(&mut self, report: &SensorTrack) -> Option<SensorSlot> {
        let sensor = self.find_entry(report)?;
        let period_ns = self.settings.sources[usize::from(report.source)].period_ns;
        let confirmed = report.state == TrackState::Confirmed as u8;
        let time_ns = report.time_of_measurement_ns;
        self.sensors
            .qualities
            .push(sensor as usize, time_ns, period_ns, confirmed);
        Some(sensor)
    }

    fn find_entry(&mut self, report: &SensorTrack) -> Option<SensorSlot> {
        if let Some(sensor) = self.sensors.find(report.source, report.track_number) {
            let age_ns = report.time_of_measurement_ns - self.sensors.get(sensor).latest.time_of_measurement_ns;
            if age_ns < 0 {
                self.counts.add(report.source, Counter::OutOfOrder);
                return None;
            }
            if age_ns <= self.settings.life.terminate_ns {
                self.sensors.update(sensor, report);
                return Some(sensor);
            }
            // The source has used the number again for something else.
            self.drop_sensor_track(sensor);
        }
        let sensor = self.sensors.insert(report);
        if sensor.is_none() {
            self.counts.add(report.source, Counter::TableFull);
        }
        sensor
    }

    fn drop_sensor_track(&mut self, sensor: SensorSlot) {
        if self.sensors.get(sensor).system != NO_SYSTEM {
            self.systems.unlink(&mut self.sensors, sensor);
        }
        self.sensors.remove(sensor);
    }

    fn search(&self) -> Search<'_> {
        Search {
            settings: &self.settings,
            sensors: &self.sensors,
            systems: &self.systems,
        }
    }

    /// Finds or starts a system track for an unlinked sensor track; `false` if the table is full.
    fn associate(&mut self, sensor: SensorSlot, not: Option<SystemSlot>) -> bool {
        let report = self.sensors.get(sensor).latest;
        let found = self
            .by_identity(&report)
            .or_else(|| self.search().best(&report, sensor, not));
        let found = found.or_else(|| self.start_system_track(&report));
        let Some(system) = found else {
            self.counts.add(report.source, Counter::TableFull);
            return false;
        };
        self.join(sensor, system);
        true
    }

    fn by_identity(&self, report: &SensorTrack) -> Option<SystemSlot> {
        if !self.settings.association.use_identity {
            return None;
        }
        self.systems.with_address(report.identity.address()?)
    }

    fn start_system_track(&mut self, report: &SensorTrack) -> Option<SystemSlot> {
        let deadline_ns = report.time_of_measurement_ns + self.shortest_fresh_ns;
        let system = self.systems.insert(State::of_report(report), deadline_ns)?;
        self.counts.add(report.source, Counter::TracksStarted);
        Some(system)
    }

    /// Links an unlinked sensor track to `system`.
    fn join(&mut self, sensor: SensorSlot, system: SystemSlot) {
        self.systems.link(&mut self.sensors, sensor, system);
        self.sensors.get_mut(sensor).role = Role::Duplicate;
        let identity = self.sensors.get(sensor).latest.identity;
        self.systems.identify(system, &identity);
    }

    /// Whether the sensor track may stay where it is, and if not, where it goes.
    fn reconsider(&mut self, sensor: SensorSlot, sink: &mut impl FnMut(&SystemTrack)) {
        let entry = self.sensors.get(sensor);
        let (report, system) = (entry.latest, entry.system);
        let mine = report
            .identity
            .address()
            .filter(|_| self.settings.association.use_identity);
        if let Some(mine) = mine {
            let theirs = self.systems.get(system).identity.address();
            if theirs.is_some_and(|theirs| theirs != mine) {
                self.counts.add(report.source, Counter::IdentityConflicts);
                self.systems.unlink(&mut self.sensors, sensor);
                self.reassociate(sensor, system);
                return;
            }
            if let Some(other) = self.systems.with_address(mine).filter(|other| *other != system) {
                self.move_to(sensor, other, sink);
                return;
            }
            self.systems.identify(system, &report.identity);
        }
        let search = self.search();
        let now_ns = report.time_of_measurement_ns;
        if search.is_alone(sensor, now_ns) {
            self.look_for_twin(sensor, sink);
        } else if mine.is_some() || search.still_fits(&report, sensor) {
            self.sensors.get_mut(sensor).misfits = 0;
        } else {
            let entry = self.sensors.get_mut(sensor);
            entry.misfits += 1;
            if entry.misfits >= self.settings.association.split_reports {
                self.counts.add(report.source, Counter::ContributionsSplit);
                self.systems.unlink(&mut self.sensors, sensor);
                self.reassociate(sensor, system);
            }
        }
    }

    /// Finds a system track for a sensor track that has just been taken out of `left`.
    fn reassociate(&mut self, sensor: SensorSlot, left: SystemSlot) {
        if !self.associate(sensor, Some(left)) {
            // No room for a system track of its own: it goes back, and the refusal has been counted.
            self.systems.link(&mut self.sensors, sensor, left);
        }
    }

    /// A lone sensor track looks whether its target has a second system track, and moves there if it keeps finding it.
    fn look_for_twin(&mut self, sensor: SensorSlot, sink: &mut impl FnMut(&SystemTrack)) {
        let entry = self.sensors.get(sensor);
        let (report, system, last) = (entry.latest, entry.system, entry.rival);
        let search = self.search();
        let twin = search.best(&report, sensor, Some(system)).filter(|twin| {
            // Of two lone ones the younger moves, so that the older number stays and they do not swap places.
            let younger = self.systems.get(*twin).number > self.systems.get(system).number;
            !(younger && search.has_one_source(*twin, report.time_of_measurement_ns))
        });
        let rival = twin.map(|twin| match last {
            Some((slot, hits)) if slot == twin => (twin, hits + 1),
            _ => (twin, 1),
        });
        self.sensors.get_mut(sensor).rival = rival;
        if let Some((twin, hits)) = rival
            && hits >= self.settings.association.merge_reports
        {
            self.move_to(sensor, twin, sink);
        }
    }

    /// Moves a sensor track to another system track. If nothing fresh stays behind, the old one ends, merged.
    fn move_to(&mut self, sensor: SensorSlot, target: SystemSlot, sink: &mut impl FnMut(&SystemTrack)) {
        let entry = self.sensors.get(sensor);
        let (old, now_ns, source) = (entry.system, entry.latest.time_of_measurement_ns, entry.latest.source);
        self.systems.unlink(&mut self.sensors, sensor);
        self.join(sensor, target);
        if self.search().fresh_primaries(old, now_ns).next().is_some() {
            return;
        }
        while let Some(rest) = self.systems.get(old).members {
            self.systems.unlink(&mut self.sensors, rest);
            self.join(rest, target);
        }
        let into = self.systems.get(target).number;
        self.counts.add(source, Counter::TracksMerged);
        self.end(old, now_ns, into, sink);
    }

    /// One sensor track of a source speaks for it; it goes on doing so while it is fresh.
    fn assign_role(&mut self, sensor: SensorSlot) {
        let entry = self.sensors.get(sensor);
        let (system, source, now_ns) = (entry.system, entry.latest.source, entry.latest.time_of_measurement_ns);
        if entry.role == Role::Primary || self.search().speaker(system, source, sensor, now_ns).is_some() {
            return;
        }
        let mut at = self.systems.get(system).members;
        while let Some(member) = at {
            let entry = self.sensors.get_mut(member);
            if entry.latest.source == source {
                entry.role = Role::Duplicate;
            }
            at = entry.next;
        }
        self.sensors.get_mut(sensor).role = Role::Primary;
    }

    /// A report of a speaker has been stored: its system track is kept alive and, unless states come at uniform times,
    /// weighed anew.
    fn refresh(&mut self, sensor: SensorSlot, sink: &mut impl FnMut(&SystemTrack)) {
        let entry = self.sensors.get(sensor);
        let (system, report) = (entry.system, entry.latest);
        let fresh_until_ns = self.fresh_until(system);
        let entry = self.systems.get_mut(system);
        entry.last_report_ns = entry.last_report_ns.max(report.time_of_measurement_ns);
        entry.fresh_until_ns = fresh_until_ns;
        entry.reports = entry.reports.saturating_add(1);
        let reference_ns = entry.state.time_ns.max(report.time_of_measurement_ns);
        self.systems.identify(system, &report.identity);
        if self.settings.refresh_ns.is_none() {
            self.weigh(system, reference_ns, Some(&report), sink);
            return;
        }
        let [x, y, _] = report.position_m;
        self.systems.grid.place(system, x, y);
        if self.learns(report.source) {
            // A report teaches once, however often its system track is weighed.
            let weighed = self.weigher().weigh(system, reference_ns);
            self.learn(report.source, &weighed);
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
    fn weigh(
        &mut self,
        system: SystemSlot,
        reference_ns: i64,
        cause: Option<&SensorTrack>,
        sink: &mut impl FnMut(&SystemTrack),
    ) {
        let weighed = self.weigher().weigh(system, reference_ns);
        if let Some(report) = cause {
            self.learn(report.source, &weighed);
        }
        let latest = || {
            let members = weighed.members().iter();
            members.map(|member| &self.sensors.get(*member).latest)
        };
        let alerts = latest().fold(0, |alerts, report| alerts | report.alerts);
        let on_ground = latest().any(|report| report.has(sensor_track_bits::ON_GROUND));
        let process_noise = self.settings.process_noise_m2ps3;
        let entry = self.systems.get_mut(system);
        let (last, chosen) = (entry.memory.selected[0], weighed.memory.selected[0]);
        entry.alerts = alerts;
        entry.on_ground = on_ground;
        entry.memory = weighed.memory;
        entry.state = match weighed.state {
            Some(state) => state,
            None => entry.state.at(reference_ns, process_noise),
        };
        let (life, reports, position_m) = (entry.life, entry.reports, entry.state.position_m);
        if last != chosen && last != rules::NO_SOURCE {
            self.counts.add(chosen, Counter::HandOvers);
        }
        if weighed.state.is_none() {
            if life == TrackState::Confirmed {
                self.systems.set_life(system, TrackState::Coasted);
            }
        } else if life == TrackState::Coasted {
            self.systems.set_life(system, TrackState::Confirmed);
        } else if life == TrackState::Tentative && reports >= self.settings.life.confirm_reports {
            self.systems.set_life(system, TrackState::Confirmed);
            let source = cause.map_or(NO_SOURCE, |report| report.source);
            self.counts.add(source, Counter::TracksConfirmed);
        }
        self.systems.grid.place(system, position_m[0], position_m[1]);
        sink(&self.message(system, cause, Some(&weighed)));
    }

    /// The next refresh time that can be worked off: no report measured up to it will follow before `now_ns`.
    fn refresh_due_before(&mut self, now_ns: i64) -> Option<i64> {
        let (period_ns, delay_ns) = (self.settings.refresh_ns?, self.settings.refresh_delay_ns);
        let latest_ns = now_ns
            .saturating_sub(delay_ns)
            .saturating_sub(1)
            .div_euclid(period_ns)
            .saturating_mul(period_ns);
        let nothing_lives = self.systems.is_empty();
        let next_ns = match self.next_refresh_ns {
            Some(next_ns) if !nothing_lives => next_ns,
            // Nothing to be shown meanwhile, however long it was.
            _ => latest_ns.saturating_add(period_ns),
        };
        let due = next_ns <= latest_ns;
        self.next_refresh_ns = Some(if due {
            next_ns.saturating_add(period_ns)
        } else {
            next_ns
        });
        due.then_some(next_ns)
    }

    /// Weighs every live system track at `time_ns`, in the order of their places in the table.
    fn refresh_all(&mut self, time_ns: i64, sink: &mut impl FnMut(&SystemTrack)) {
        for system in self.systems.slots() {
            let entry = self.systems.get(system);
            if entry.life != TrackState::Terminated && entry.state.time_ns <= time_ns {
                self.weigh(system, time_ns, None, sink);
            }
        }
    }

    /// When the last of the present contributions ceases to be fresh.
    fn fresh_until(&self, system: SystemSlot) -> i64 {
        self.systems
            .members(&self.sensors, system)
            .map(|member| {
                let latest = &self.sensors.get(member).latest;
                latest.time_of_measurement_ns + self.settings.sources[usize::from(latest.source)].fresh_ns
            })
            .max()
            .unwrap_or(i64::MIN)
    }

    /// A deadline of `slot` has come up: coast, end, or look again later.
    fn meet_deadline(&mut self, slot: SystemSlot, deadline_ns: i64, sink: &mut impl FnMut(&SystemTrack)) {
        let life = self.settings.life;
        let entry = self.systems.get(slot);
        let (coast_ns, last_ns) = (entry.fresh_until_ns, entry.last_report_ns);
        let due_ns = match entry.life {
            TrackState::Terminated => {
                self.systems.free(slot);
                return;
            }
            TrackState::Tentative => last_ns + life.tentative_ns,
            TrackState::Confirmed => coast_ns,
            TrackState::Coasted => last_ns + life.terminate_ns,
        };
        if deadline_ns < due_ns {
            self.systems
                .put_back(slot, due_ns.min(deadline_ns + self.shortest_fresh_ns));
            return;
        }
        if entry.life == TrackState::Confirmed && coast_ns < last_ns + life.terminate_ns {
            self.coast(slot, deadline_ns, sink);
            self.systems.put_back(
                slot,
                (last_ns + life.terminate_ns).min(deadline_ns + self.shortest_fresh_ns),
            );
        } else {
            self.end(slot, deadline_ns, 0, sink);
            self.systems.free(slot);
        }
    }

    fn coast(&mut self, slot: SystemSlot, now_ns: i64, sink: &mut impl FnMut(&SystemTrack)) {
        self.systems.set_life(slot, TrackState::Coasted);
        if self.settings.refresh_ns.is_some() {
            // The next refresh shows it.
            return;
        }
        let process_noise = self.settings.process_noise_m2ps3;
        let entry = self.systems.get_mut(slot);
        entry.state = entry.state.at(now_ns.max(entry.state.time_ns), process_noise);
        let [x, y, _] = entry.state.position_m;
        self.systems.grid.place(slot, x, y);
        sink(&self.message(slot, None, None));
    }

    /// Ends a system track; its remaining sensor tracks, all stale, go with it.
    fn end(&mut self, slot: SystemSlot, now_ns: i64, merged_into: u32, sink: &mut impl FnMut(&SystemTrack)) {
        while let Some(member) = self.systems.get(slot).members {
            self.drop_sensor_track(member);
        }
        self.systems.end(slot);
        let process_noise = self.settings.process_noise_m2ps3;
        let entry = self.systems.get_mut(slot);
        entry.merged_into = merged_into;
        entry.state = entry.state.at(now_ns.max(entry.state.time_ns), process_noise);
        self.counts.add(NO_SOURCE, Counter::TracksTerminated);
        sink(&self.message(slot, None, None));
    }

    fn message(&self, slot: SystemSlot, cause: Option<&SensorTrack>, weighed: Option<&Weighed>) -> SystemTrack {
        let entry = self.systems.get(slot);
        let (members, shares) = weighed.map_or((&[][..], &[][..]), |weighed| (weighed.members(), weighed.shares()));
        let mut message = SystemTrack {
            reference_time_ns: entry.state.time_ns,
            time_of_measurement_ns: cause.map_or(entry.state.time_ns, |report| report.time_of_measurement_ns),
            sequence: 0,
            stages: cause.map_or(StageTimes::default(), |report| report.stages),
            track_number: entry.number,
            trigger_source: cause.map_or(NO_SOURCE, |report| report.source),
            selected_source: NO_SOURCE,
            identity: entry.identity,
            position_m: entry.state.position_m,
            velocity_mps: entry.state.velocity_mps,
            covariance: entry.state.covariance,
            contributions: [Contribution::default(); CONTRIBUTIONS_MAX],
            source_count: members.len() as u16,
            contribution_count: members.len() as u16,
            state: entry.life as u8,
            height_valid: u8::from(entry.state.has_height),
            rule: rules::code(self.settings.rule.rule),
            alerts: entry.alerts,
            merged_into: entry.merged_into,
            on_ground: u8::from(entry.on_ground),
            reserved: [0; 3],
        };
        let mut heaviest = 0.0;
        for (index, share) in shares.iter().enumerate() {
            let latest = &self.sensors.get(members[index]).latest;
            let weight = share.weight.iter().sum::<f64>() / AXES as f64;
            let scored = if share.accuracy.is_finite() {
                contribution_bits::SCORED
            } else {
                0
            };
            message.contributions[index] = Contribution {
                time_of_measurement_ns: latest.time_of_measurement_ns,
                track_number: latest.track_number,
                source: latest.source,
                flags: contribution_bits::FRESH | scored,
                weight,
                accuracy: if share.accuracy.is_finite() {
                    share.accuracy
                } else {
                    f64::NAN
                },
            };
            if weight > heaviest {
                heaviest = weight;
                message.selected_source = latest.source;
            }
        }
        message
    }
}

#[cfg(test)]
pub(crate) fn test_settings(sources: usize) -> Settings {
    use crate::settings::{
        Accuracy, AccuracyBase, AssociationSettings, Capacity, LifeSettings, RuleSettings, SourceSettings,
    };
    let source = |index: usize| SourceSettings {
        name: format!("source{index}"),
        period_ns: 1_000_000_000,
        fresh_ns: 2_500_000_000,
        accuracy: Accuracy {
            base: AccuracyBase::Constant { sigma_m: 10.0 },
            per_speed_s: 0.0,
            conditions: Vec::new(),
        },
        adjustment: 1.0,
        priority: index as u32,
        ceiling_m: f64::INFINITY,
    };
    Settings {
        sources: (0..sources).map(source).collect(),
        capacity: Capacity {
            system_tracks: 50,
            sensor_tracks: 200,
            stored_reports: 3,
        },
        association: AssociationSettings {
            target_extent_m: 40.0,
            ..AssociationSettings::default()
        },
        life: LifeSettings::default(),
        rule: RuleSettings::default(),
        process_noise_m2ps3: 1.0,
        refresh_ns: None,
        refresh_delay_ns: 0,
    }
}

//! The engine: processes one report at a time and hands out the states of the system tracks that change.
//!
//! A report passes these steps in this order:
//!
//! 1. [`inlet`] validates and completes the report.
//! 2. [`Sources`] removes the known errors of the source and recovers the measurement behind the report.
//! 3. [`Linking`] and [`Scans`] associate the sensor track with a system track (module `association_step` holds the
//!    gate). The engine then updates the filter of the system track.
//! 4. [`Life`] confirms, coasts and terminates system tracks.
//! 5. [`TrackPublisher`] weighs the contributions and publishes the state.
//!
//! Each part owns its learned state; [`Tracks`] is shared by all.

use messages::{Bias, Counter, DecisionKind, NS_PER_S, SensorTrack, TrackState, sensor_track_bits};
use settings::SettingsError;

use association::distance::squared2;

use crate::association_step::Search;
use crate::assumed::assumed_of;
use crate::dependence::Dependence;
use crate::engine_counters::EngineCounters;
use crate::explanation::Sink;
use crate::history::Histories;
use crate::host_clock::HostClock;
use crate::inlet;
use crate::kept_measurements::KeptMeasurements;
use crate::life::{self, Life};
use crate::lifetimes::Lifetimes;
use crate::linking::{Linking, Next};
use crate::measurement::{Content, Correction, FilterInput, Measurement, whole_report};
use crate::order_table::{Configured, IN_FORCE_MAX, OrderTable};
use crate::outlet::EngineOutbox;
use crate::publishing::TrackPublisher;
use crate::purity::Purity;
use crate::reference_point::ReferencePoints;
use crate::registration::SourceErrors;
use crate::rules;
use crate::scan::{ScanAssignment, Scans};
use crate::schedule::Schedule;
use crate::sensor_tracks::{NO_SYSTEM, Role, SensorSlot, SensorTracks};
use crate::settings::Settings;
use crate::source_model::SourceModel;
use crate::sources::Sources;
use crate::system_tracks::{SystemSlot, SystemTracks};
use crate::tracks::Tracks;

/// Largest time of a report ahead of the engine's time, nanoseconds. The limit holds even if the clock of the source
/// is unknown: it bounds the lifetime of tracks and the number of steps through time.
const AHEAD_MAX_NS: i64 = 86_400_000_000_000;
/// Lead of a filter over all reports, nanoseconds, from which a wrong clock is taken as the cause.
const AHEAD_OF_CLOCKS_NS: i64 = 500_000_000;
/// Speed below which the course is meaningless, m/s.
const COURSE_SPEED_MIN_MPS: f64 = 1.0;
/// Distance between report and estimate, in combined standard deviations, beyond which either must be wrong.
const ASTRAY_SIGMAS: f64 = 30.0;

/// Share of a source in a filter from which the filter starts anew where its covariances were wrong.
const OWN_SHARE: f64 = 0.3;

/// Fusion of sensor tracks into system tracks.
#[derive(Debug)]
pub struct Engine {
    pub(crate) settings: Settings,
    pub(crate) tracks: Tracks,
    pub(crate) sources: Sources,
    pub(crate) points: ReferencePoints,
    pub(crate) scans: Scans,
    pub(crate) life: Life,
    pub(crate) publisher: TrackPublisher,
    pub(crate) schedule: Schedule,
    pub(crate) host_clock: HostClock,
    pub(crate) orders: OrderTable,
    pub(crate) outbox: EngineOutbox,
}

impl Engine {
    /// Creates an engine with all tables allocated.
    ///
    /// # Errors
    /// If a setting is invalid or contradicts another.
    pub fn new(settings: Settings) -> Result<Self, SettingsError> {
        settings.check()?;
        let capacity = settings.capacity;
        let sources = settings.sources.len();
        // A rule that takes its state from the filter needs neither history nor memory.
        let rule = rules::entry(settings.rule.name.0);
        let mut settings = settings;
        let remembers = !rule.is_from_filter() || settings.accuracy_values();
        settings.rule.hand_over.ordered.reserve_exact(IN_FORCE_MAX);
        let histories = remembers.then(|| {
            let length = capacity.stored_reports + 1;
            Histories::new(capacity.sensor_tracks(), length, settings.rule.recency)
        });
        Ok(Self {
            tracks: Tracks::new(
                SensorTracks::new(capacity.sensor_tracks(), sources, histories, remembers),
                SystemTracks::new(
                    capacity.system_tracks(),
                    sources,
                    settings.association.cell_m,
                    remembers,
                ),
                Lifetimes::new(&settings.life, &settings.sources),
                (Dependence::new(&settings.sources), Purity::new(sources)),
                KeptMeasurements::new(
                    settings.late_window_ns(),
                    capacity.kept_measurements(),
                    capacity.system_tracks(),
                ),
            ),
            sources: Sources::new(&settings),
            points: ReferencePoints::default(),
            scans: Scans::new(&settings.sources, settings.association.scan_wait),
            life: Life::new(&settings.sources),
            publisher: TrackPublisher::new(rule, &settings.sources),
            schedule: Schedule::new(settings.refresh_ns(), settings.refresh_delay_s.ns()),
            host_clock: HostClock::default(),
            orders: OrderTable::new(Configured::of(&settings)),
            outbox: EngineOutbox::new(sources),
            settings,
        })
    }

    /// Returns the counters since the start.
    pub fn counts(&self) -> &EngineCounters {
        &self.outbox.counts
    }

    /// Returns the number of system tracks in `state`.
    pub fn count_in_state(&self, state: TrackState) -> usize {
        self.tracks.systems.count_in_state(state)
    }

    /// Returns the counters for update by the caller, which counts losses and queues before the engine.
    pub fn counts_mut(&mut self) -> &mut EngineCounters {
        &mut self.outbox.counts
    }

    /// Returns the engine's time, up to which time has passed, nanoseconds; `i64::MIN` at the start.
    pub fn now_ns(&self) -> i64 {
        self.schedule.now_ns()
    }

    /// Returns the settings in force.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Returns the estimated systematic errors of `source` (BF-3); `None` if the source does not exist.
    pub fn source_errors(&self, source: u16) -> Option<&SourceErrors> {
        (usize::from(source) < self.settings.sources.len()).then(|| self.sources.registration.of(source))
    }

    /// Returns the gross error of `source` that unassociated tracks reveal; `None` if there is no error or no such
    /// source.
    pub fn gross_error(&self, source: u16) -> Option<Bias> {
        (usize::from(source) < self.settings.sources.len())
            .then(|| self.sources.alignment.error_of(source))
            .flatten()
    }

    /// Returns the first source of the group on which `source` depends (configured or learned). Returns `None` if
    /// `source` is the first of its group, independent, or does not exist.
    pub fn counts_with(&self, source: u16) -> Option<u16> {
        let is_known = usize::from(source) < self.settings.sources.len();
        is_known
            .then(|| self.tracks.dependence.group_of(source))
            .filter(|first| *first != source)
    }

    /// Returns the factor of covariance scaling of `source`, whose covariances are too small (BF-5). The factor is 1
    /// if the covariances are consistent; `None` if the source does not exist.
    pub fn covariance_scale(&self, source: u16) -> Option<f64> {
        self.sources
            .models
            .get(usize::from(source))
            .map(SourceModel::covariance_scale)
    }

    /// Returns the learned probability that a scan of `source` detects a target it tracks; `None` if the source does
    /// not exist.
    pub fn detection_probability(&self, source: u16) -> Option<f64> {
        self.sources
            .models
            .get(usize::from(source))
            .map(|model| model.detection)
    }

    /// Sets the host offset, the lead of the sources' time over the engine's time, nanoseconds; 0 at the start. The
    /// engine subtracts the offset from the times of reports and adds it to the times of states and decisions.
    pub fn set_host_offset(&mut self, offset_ns: i64) {
        self.host_clock.offset_ns = offset_ns;
    }

    /// Sets the clock offset of `source` against sound clocks, in seconds, as derived from times of receipt; `None`
    /// if unknown.
    pub fn set_source_clock(&mut self, source: u16, offset_s: Option<f64>) {
        self.sources.set_clock(&self.settings.sources, source, offset_s);
    }

    /// Advances the engine's time to `now_ns`; no report measured earlier may follow. System tracks whose
    /// contributions are too old coast, then terminate; each change is handed to `sink`. If a refresh time is set,
    /// the state of every system track is also handed out at each whole multiple of it.
    ///
    /// All events take place at times that reports have set, in the order of these times. The number and size of the
    /// steps therefore does not change the result.
    pub fn advance(&mut self, now_ns: i64, sink: &mut impl Sink) {
        self.pass_time(now_ns, &mut self.host_clock.outward(sink));
    }

    fn pass_time(&mut self, now_ns: i64, sink: &mut impl Sink) {
        loop {
            let event_ns = self.schedule.next_event(|| self.tracks.systems.is_empty());
            let scan_ns = self.scans.due_ns();
            let other_ns = scan_ns.min(event_ns);
            if self.run_timer_before(now_ns.min(other_ns), sink) {
                continue;
            }
            if other_ns >= now_ns {
                break;
            }
            self.schedule.pass(other_ns);
            if self.orders.due_ns == other_ns {
                self.look_at_orders(other_ns, sink);
            } else if scan_ns == other_ns {
                self.finish_scans(scan_ns, sink);
            } else {
                self.refresh_all(event_ns, sink);
            }
        }
        self.schedule.pass(now_ns);
    }

    /// Hands out the state of every system track at the refresh time `due_ns`, including all reports up to that time.
    fn refresh_all(&mut self, due_ns: i64, sink: &mut impl Sink) {
        self.finish_scans(i64::MAX, sink);
        while self.run_timer_before(due_ns, sink) {}
        if let Some(time_ns) = self.schedule.take_refresh() {
            self.publisher.weigh_all(
                &self.settings,
                &mut self.tracks,
                &self.sources,
                time_ns,
                &mut self.outbox.to(sink),
            );
        }
    }

    fn run_timer_before(&mut self, time_ns: i64, sink: &mut impl Sink) -> bool {
        let out = &mut self.outbox.to(sink);
        self.life
            .run_timer_before(&self.settings, &mut self.tracks, time_ns, out)
    }

    /// Processes one report of a time-ordered sequence; the engine's time advances with the reports. Every changed
    /// system-track state is handed to `sink`.
    pub fn take(&mut self, report: &SensorTrack, sink: &mut impl Sink) {
        self.take_at(report, report.time_of_measurement_ns, sink);
    }

    /// Processes one report received at `now_ns` (the engine's time). Time passes up to `now_ns`, independent of the
    /// time in the report. Every changed system-track state is handed to `sink`.
    ///
    /// A report older than the latest report of its sensor track is rejected. A report with an implausible time is
    /// kept out of the tracks.
    pub fn take_at(&mut self, report: &SensorTrack, now_ns: i64, sink: &mut impl Sink) {
        let sink = &mut self.host_clock.outward(sink);
        let inward = self.host_clock.inward(report);
        let report = inward.as_ref().unwrap_or(report);
        let completed = inlet::completed(report, &self.settings.sources);
        let report = completed.as_ref().unwrap_or(report);
        if !inlet::is_valid(report, &self.settings.sources) {
            let counter = inlet::rejection(report, &self.settings.sources);
            self.outbox.counts.add(report.source, counter);
            return;
        }
        let corrected = inlet::corrected(report, &self.settings.sources, now_ns);
        let report = corrected.as_ref().unwrap_or(report);
        self.pass_time(now_ns, sink);
        // Before the first step of time the present is undefined.
        let now_ns = self.schedule.now_ns();
        let aligned = self.sources.align(&self.settings, report, now_ns);
        let report = aligned.as_ref().unwrap_or(report);
        let is_far_ahead = now_ns != i64::MIN && report.time_of_measurement_ns > now_ns.saturating_add(AHEAD_MAX_NS);
        if report.has(sensor_track_bits::WILD_CLOCK) || is_far_ahead {
            self.outbox.counts.add(report.source, Counter::RejectedClock);
            return;
        }
        self.learn_of_sources();
        if self.tracks.kept.is_on() {
            self.learn_lateness(report, now_ns);
        }
        if report.state == TrackState::Coasted as u8 {
            // An extrapolated report contains no observation. Its extrapolation agrees perfectly with itself, so a
            // score as observation would favour it. It therefore counts as a missing report (TI-4).
            self.outbox.counts.add(report.source, Counter::RejectedExtrapolated);
            self.miss(report, sink);
            return;
        }
        let is_foreign = self.settings.sources[usize::from(report.source)].is_centre;
        if !is_foreign {
            self.tracks.dependence.learn(report);
        }
        // Early look-up: the cache miss overlaps with the checks below.
        let known = self.tracks.sensors.find(report.source, report.track_number);
        let known = self.without_outdated(report, known, sink);
        let is_usable = inlet::is_usable(&report.covariance);
        let repaired = if is_usable { None } else { inlet::repaired(report) };
        if !is_usable {
            let counter = match &repaired {
                Some(_) => Counter::CovariancesRepaired,
                None => Counter::RejectedInvalid,
            };
            self.outbox.counts.add(report.source, counter);
            if repaired.is_none() {
                return;
            }
        }
        let report = repaired.as_ref().unwrap_or(report);
        if self.tracks.kept.is_on()
            && let Some(sensor) = known
            && self.take_overtaken(sensor, report, sink)
        {
            return;
        }
        if let Some((sensor, measurement)) = self.store(report, known, !is_usable) {
            self.work_off(sensor, report, measurement.as_ref(), sink);
        }
    }

    /// Returns the entry of the report's sensor track, unless the entry precedes the removal of a gross error. Such a
    /// track is terminated here, since the corrected target lies elsewhere.
    fn without_outdated(
        &mut self,
        report: &SensorTrack,
        known: Option<SensorSlot>,
        sink: &mut impl Sink,
    ) -> Option<SensorSlot> {
        let sensor = known?;
        if self.tracks.sensors.get(sensor).epoch == self.sources.alignment.epoch_of(report.source) {
            return known;
        }
        self.end_sensor_track(sensor, report.time_of_measurement_ns, sink);
        None
    }

    /// Stores a report, free of its source's known errors, as the latest of its sensor track. Returns the sensor
    /// track and the new measurement in the report; `None` if the report is out of order or the table is full.
    fn store(
        &mut self,
        report: &SensorTrack,
        known: Option<SensorSlot>,
        repaired: bool,
    ) -> Option<(SensorSlot, Option<Measurement>)> {
        let (identity, conflict) = if self.settings.association.use_identity {
            inlet::believed_identity(report, &self.tracks.systems)
        } else {
            (report.identity, None)
        };
        if let Some(counter) = conflict {
            self.outbox.counts.add(report.source, counter);
        }
        let earlier = self.earlier(report, known)?;
        let before = earlier.map(|(sensor, seconds)| (self.tracks.sensors.get(sensor), seconds));
        let is_foreign = self.settings.sources[usize::from(report.source)].is_centre;
        let (content, correction) = if is_foreign {
            // The state is the only content of a centre's report, and the newest state replaces the previous state.
            (Content::NONE, Correction::NONE)
        } else {
            let content = self.sources.content_of(report, before, repaired);
            (content, self.sources.correction_of(&self.settings.sources, report))
        };
        let mut measurement = content.measurement;
        if let Some(measurement) = &mut measurement {
            measurement.correct(&correction);
        }
        let sensors = &mut self.tracks.sensors;
        let place = earlier.map(|(sensor, _)| sensor).or_else(|| sensors.insert(report));
        let Some(sensor) = place else {
            self.outbox.counts.add(report.source, Counter::DroppedTable);
            return None;
        };
        let identity = match self.settings.association.use_identity {
            true => sensors.believe(sensor, &report.identity, identity),
            false => identity,
        };
        let entry = sensors.get_mut(sensor);
        entry.take(report, identity, &correction, &content);
        entry.repaired = repaired;
        entry.is_foreign = is_foreign;
        entry.epoch = self.sources.alignment.epoch_of(report.source);
        sensors.note(sensor, self.settings.sources[usize::from(report.source)].period_ns);
        Some((sensor, measurement))
    }

    /// Returns the entry of the report's sensor track and the seconds since its latest report; `Some(None)` if there
    /// is no entry yet; `None` if the report is older.
    fn earlier(&mut self, report: &SensorTrack, known: Option<SensorSlot>) -> Option<Option<(SensorSlot, f64)>> {
        let time_ns = report.time_of_measurement_ns;
        let Some(sensor) = known else {
            self.tracks.lifetimes.learn(report.source, time_ns, None);
            return Some(None);
        };
        let age_ns = time_ns - self.tracks.sensors.get(sensor).time_ns;
        let ends = report.state == TrackState::Terminated as u8;
        if age_ns < 0 || (age_ns == 0 && !ends) {
            self.outbox.counts.add(report.source, Counter::RejectedOutOfOrder);
            return None;
        }
        if age_ns > self.tracks.lifetimes.silence_ns(report.source) {
            // The source has reused the number for another target.
            self.tracks.drop_sensor_track(sensor);
            return Some(None);
        }
        self.tracks.lifetimes.learn(report.source, time_ns, Some(age_ns));
        self.tracks.lifetimes.learn_gap(report.source, age_ns);
        Some(Some((sensor, age_ns as f64 / NS_PER_S)))
    }

    /// Applies a stored report: terminates, associates, checks, then updates the system track.
    fn work_off(
        &mut self,
        sensor: SensorSlot,
        report: &SensorTrack,
        measurement: Option<&Measurement>,
        sink: &mut impl Sink,
    ) {
        if report.state == TrackState::Terminated as u8 {
            self.outbox.counts.add(report.source, Counter::TracksEnded);
            self.end_sensor_track(sensor, report.time_of_measurement_ns, sink);
            return;
        }
        if self.rejects_position(sensor, report.source, sink) {
            return;
        }
        if report.has(sensor_track_bits::PRESSURE_OFFSET) {
            let offset_m = f64::from(report.pressure_offset_m);
            self.tracks.pressure.learn(report.position_m, offset_m);
        }
        let before = self.tracks.sensors.get(sensor).system;
        if before == NO_SYSTEM && self.orders.concerns_tracks {
            self.block(sensor);
        }
        self.associate(sensor, report, sink);
        if self.settings.association.scan_wait == 0.0 && self.tracks.sensors.get(sensor).waits {
            self.finish_scans(i64::MAX, sink);
            if before == NO_SYSTEM {
                return;
            }
        }
        let system = self.tracks.sensors.get(sensor).system;
        if system == NO_SYSTEM {
            return;
        }
        if system != before && self.tracks.systems.get(system).life == TrackState::Suspended {
            self.resume_number(sensor, report, sink);
            return;
        }
        let period_ns = self.settings.sources[usize::from(report.source)].period_ns;
        self.tracks.learn_dependence(sensor, period_ns);
        self.tracks.assign_role(sensor);
        let entry = self.tracks.sensors.get(sensor);
        if entry.role != Role::Primary {
            self.outbox.counts.add(report.source, Counter::RejectedDuplicate);
        } else if !entry.is_foreign && !self.sources.admits(&self.settings.association, &self.tracks, sensor) {
            self.set_aside(sensor, measurement);
        } else if system == before {
            self.update(sensor, report, measurement, sink);
        } else {
            let whole = whole_report(&entry.latest);
            self.update(sensor, report, Some(&whole), sink);
        }
    }

    /// Excludes a sensor track that other sources contradict from the estimate. Its reports are still compared with
    /// theirs.
    #[cold]
    fn set_aside(&mut self, sensor: SensorSlot, measurement: Option<&Measurement>) {
        let entry = self.tracks.sensors.get_mut(sensor);
        entry.role = Role::SetAside;
        let source = entry.source;
        self.outbox.counts.add(source, Counter::RejectedContradicted);
        if let Some(measurement) = measurement {
            self.sources
                .learn_of_contradiction(&self.settings, &self.tracks, (sensor, measurement));
        }
        self.sources
            .compare(&self.settings, &self.tracks, (sensor, measurement));
    }

    /// Associates a sensor track, whose `report` has just been stored, with a system track.
    fn associate(&mut self, sensor: SensorSlot, report: &SensorTrack, sink: &mut impl Sink) {
        let out = &mut self.outbox.to(sink);
        let mut linking = Linking {
            settings: &self.settings,
            tracks: &mut self.tracks,
            sources: &self.sources,
        };
        let next = linking.associate(sensor, report, out);
        self.follow_up(sensor, next, sink);
    }

    /// Executes the step that linking leaves to the engine: nothing, a wait for the scan, or the end of a merged
    /// track.
    fn follow_up(&mut self, sensor: SensorSlot, next: Next, sink: &mut impl Sink) {
        match next {
            Next::Done => {}
            Next::Wait => self.wait_for_scan(sensor, sink),
            Next::End(merged) => {
                let out = &mut self.outbox.to(sink);
                let (ended, into) = (merged.ended, merged.into);
                life::end(&self.settings, &mut self.tracks, ended, merged.time_ns, into, out);
            }
        }
    }

    /// Queues a sensor track until its scan is complete.
    fn wait_for_scan(&mut self, sensor: SensorSlot, sink: &mut impl Sink) {
        let entry = self.tracks.sensors.get_mut(sensor);
        // A clock that is ahead must not delay the scan; the reports of a late scan come late as well.
        let late_ns = self.tracks.lifetimes.late_ns(entry.source);
        let time_ns = entry.time_ns.saturating_add(late_ns).min(self.schedule.now_ns());
        let source = entry.source;
        if std::mem::replace(&mut entry.waits, true) {
            return;
        }
        if self.scans.is_full(source) {
            self.assign_scan(source, sink);
        }
        self.scans.wait(sensor, source, time_ns);
    }

    /// Assigns the scans that are complete at `time_ns`.
    fn finish_scans(&mut self, time_ns: i64, sink: &mut impl Sink) {
        while let Some(source) = self.scans.complete_at(time_ns) {
            self.assign_scan(source, sink);
        }
    }

    fn assign_scan(&mut self, source: u16, sink: &mut impl Sink) {
        let rows = self
            .scans
            .assign(source, &self.settings, &mut self.tracks, &self.sources);
        for row in 0..rows {
            let assigned = self.scans.assigned(row);
            // The sensor track may have ended since it was queued.
            if std::mem::take(&mut self.tracks.sensors.get_mut(assigned.sensor).waits) {
                self.place_assigned(assigned, sink);
            }
        }
    }

    /// Places a sensor track as the assignment of its scan decides.
    fn place_assigned(&mut self, ScanAssignment { sensor, best }: ScanAssignment, sink: &mut impl Sink) {
        let is_unlinked = self.tracks.sensors.get(sensor).system == NO_SYSTEM;
        // The system track may have ended since, merged by another sensor track of this scan.
        let lives = |system: SystemSlot| self.tracks.systems.get(system).life != TrackState::Terminated;
        match best.filter(|(system, _)| lives(*system)) {
            Some((system, d2)) if is_unlinked => self.join_assigned(sensor, system, d2, sink),
            Some((system, d2)) => self.vote_to_merge(sensor, system, d2, sink),
            None if is_unlinked => self.place_alone(sensor, sink),
            None => self.tracks.sensors.get_mut(sensor).competing = None,
        }
    }

    fn join_assigned(&mut self, sensor: SensorSlot, system: SystemSlot, d2: f64, sink: &mut impl Sink) {
        self.tracks.join(sensor, system);
        let gate = self.settings.association.scan_gate();
        sink.decision(&self.tracks.decision(sensor, DecisionKind::Joined, d2, gate));
        self.tracks.assign_role(sensor);
        let entry = self.tracks.sensors.get(sensor);
        if entry.role == Role::Primary {
            let report = entry.latest;
            let mut whole = whole_report(&report);
            whole.has_waited = true;
            self.update(sensor, &report, Some(&whole), sink);
        }
    }

    fn vote_to_merge(&mut self, sensor: SensorSlot, system: SystemSlot, d2: f64, sink: &mut impl Sink) {
        let out = &mut self.outbox.to(sink);
        let mut linking = Linking {
            settings: &self.settings,
            tracks: &mut self.tracks,
            sources: &self.sources,
        };
        if let Some(next) = linking.vote_to_merge(sensor, system, d2, out) {
            self.follow_up(sensor, next, sink);
            self.tracks.assign_role(sensor);
        }
    }

    /// Places a sensor track that fits no available system track. The track is either a further part of a target that
    /// its source already tracks, or a new target.
    fn place_alone(&mut self, sensor: SensorSlot, sink: &mut impl Sink) {
        let search = Search {
            settings: &self.settings,
            tracks: &self.tracks,
            sources: &self.sources,
        };
        if let Some((system, metres)) = search.other_part(sensor) {
            self.tracks.join(sensor, system);
            let limit = self.settings.association.target_extent_m;
            sink.decision(&self.tracks.decision(sensor, DecisionKind::Duplicate, metres, limit));
            let source = self.tracks.sensors.get(sensor).source;
            self.outbox.counts.add(source, Counter::RejectedDuplicate);
            return;
        }
        if !self.tracks.is_established(sensor) {
            // A first report alone may join a target; it starts none.
            return;
        }
        let report = self.tracks.sensors.get(sensor).latest;
        if !self.tracks.systems.has_room(report.source) {
            self.make_room(report.source, sink);
        }
        let out = &mut self.outbox.to(sink);
        let mut linking = Linking {
            settings: &self.settings,
            tracks: &mut self.tracks,
            sources: &self.sources,
        };
        let deadline_ns = self.life.first_deadline_ns(report.time_of_measurement_ns);
        if linking.start(sensor, deadline_ns, out) {
            out.input(|| self.tracks.input(sensor, None));
            self.update(sensor, &report, None, sink);
        }
    }

    /// Updates the system track of a primary sensor track whose `report` has just been stored; `measurement` is the
    /// new information in the report.
    pub(crate) fn update(
        &mut self,
        sensor: SensorSlot,
        report: &SensorTrack,
        measurement: Option<&Measurement>,
        sink: &mut impl Sink,
    ) {
        let system = self.tracks.sensors.get(sensor).system;
        self.tracks.systems.get_mut(system).nis = 0.0;
        if self.tracks.sensors.get(sensor).is_foreign {
            self.follow_centre(sensor);
        } else if self.tracks.systems.get(system).is_foreign {
            // The filter repeats another centre's estimate; this is the first local measurement.
            self.tracks.restart_filter(sensor);
            self.outbox.to(sink).input(|| self.tracks.input(sensor, None));
            self.tracks.sensors.get_mut(sensor).share = 1.0;
        } else if self.sources.credibility.is_misled(&self.tracks, sensor) || self.is_ahead(sensor) {
            self.restart(sensor, sink);
        } else if let Some(measurement) = measurement
            && (self.tracks.is_established(sensor) || !self.points.sees_points())
            && !self.corrects_claims(sensor, sink)
        {
            self.update_filter(sensor, measurement, sink);
        }
        self.keep_alive(sensor, system, report);
        self.sources
            .compare(&self.settings, &self.tracks, (sensor, measurement));
        let out = &mut self.outbox.to(sink);
        let cause = (system, report);
        let was_shown = self.tracks.systems.get(system).was_shown;
        self.life
            .update_existence(&self.settings, &mut self.tracks, &self.sources, cause, out);
        if !was_shown && self.tracks.systems.get(system).was_shown && !self.tracks.systems.silent.is_empty() {
            self.take_former_number(sensor, report.time_of_measurement_ns, sink);
        }
        let out = &mut self.outbox.to(sink);
        self.publisher
            .refresh(&self.settings, &mut self.tracks, &self.sources, cause, out);
    }

    /// Enlarges the covariance of a filter that a source has made too small with covariances that turn out wrong with
    /// this report of the sensor track.
    #[inline]
    fn corrects_claims(&mut self, sensor: SensorSlot, sink: &mut impl Sink) -> bool {
        let entry = self.tracks.sensors.get_mut(sensor);
        let claimed_too_much = std::mem::replace(&mut entry.claimed_too_much, 1.0);
        if claimed_too_much > 1.0 && entry.share > OWN_SHARE {
            self.restart(sensor, sink);
            return true;
        } else if claimed_too_much > 1.0 {
            let factor = 1.0 + entry.share * (claimed_too_much - 1.0);
            let system = entry.system;
            self.tracks.systems.get_mut(system).filter.inflate(factor);
            // Kept states of the filter are as much too sure.
            self.tracks.kept.forget(system);
        }
        false
    }

    /// Returns whether the filter of the system track lies ahead of all reports, led there by a clock that has since
    /// been corrected.
    #[inline]
    fn is_ahead(&self, sensor: SensorSlot) -> bool {
        self.sources.corrects_clocks() && {
            let entry = self.tracks.sensors.get(sensor);
            let latest_ns = entry.time_ns.max(self.schedule.now_ns());
            self.tracks.systems.get(entry.system).filter.time_ns > latest_ns.saturating_add(AHEAD_OF_CLOCKS_NS)
        }
    }

    /// Copies the state of another centre into the filter while no local source tracks the target. Otherwise the
    /// filter ignores other centres: information sent to them must not return from them.
    fn follow_centre(&mut self, sensor: SensorSlot) {
        let entry = self.tracks.sensors.get(sensor);
        let is_followed = self
            .tracks
            .contributing_here(entry.system, entry.time_ns)
            .next()
            .is_some();
        if !is_followed {
            self.tracks.restart_filter(sensor);
        }
    }

    /// Updates the system filter with a measurement, and learns from the innovation.
    fn update_filter(&mut self, sensor: SensorSlot, measurement: &Measurement, sink: &mut impl Sink) {
        let out = &mut self.outbox.to(sink);
        let referred = self
            .points
            .refer(&self.settings, &mut self.tracks, (sensor, measurement), out);
        let entry = self.tracks.sensors.get(sensor);
        let (system, time_ns, source) = (entry.system, entry.time_ns, entry.source);
        let mut relative = *measurement;
        relative.refer(referred.point_m, referred.variance_m2);
        let Self { tracks, sources, .. } = self;
        let filter = &mut tracks.systems.get_mut(system).filter;
        let keeps = tracks.kept.is_on();
        let taken = if keeps && time_ns < filter.time_ns && !relative.has_waited {
            self.take_late_or_carry(sensor, &relative, &referred)
        } else {
            if keeps {
                tracks.kept.begin(system, filter);
            }
            let innovation = filter.take(&relative, time_ns, sources.motion_of(filter), referred.is_usable);
            if keeps {
                let entry = tracks.sensors.get(sensor);
                let used = referred.used(entry, &relative);
                tracks.kept.append(system, filter, &used);
            }
            innovation
        };
        let filter = &self.tracks.systems.get(system).filter;
        // A non-finite value shows in the gain.
        let Some(mut innovation) = taken.filter(|innovation| innovation.gain.is_finite()) else {
            if !filter.is_sound() {
                self.restart(sensor, sink);
            }
            return;
        };
        let velocity = [filter.estimate.mean[3], filter.estimate.mean[4]];
        if self.is_astray(sensor, &innovation) {
            self.restart(sensor, sink);
            return;
        }
        let nis = squared2(innovation.residual_m, innovation.covariance_m2).min(f64::from(f32::MAX));
        self.tracks.dependence.learn_innovation(source, 0.5 * nis);
        self.tracks.systems.get_mut(system).nis = nis as f32;
        if referred.is_usable {
            self.outbox.to(sink).input(|| FilterInput {
                point_m: referred.point_m,
                point_m2: referred.variance_m2,
                assumed: Some(assumed_of(system, &self.tracks, &self.sources, &self.publisher)),
                ..self.tracks.input(sensor, Some(measurement))
            });
        }
        let speed = (velocity[0] * velocity[0] + velocity[1] * velocity[1]).sqrt();
        if speed > COURSE_SPEED_MIN_MPS {
            self.tracks.systems.get_mut(system).course = velocity.map(|part| part / speed);
        }
        for (residual, point) in innovation.residual_m.iter_mut().zip(referred.point_m) {
            *residual += point;
        }
        let is_misled = self.sources.registration.has_misled_filters();
        if self.tracks.systems.get(system).life == TrackState::Confirmed && !is_misled {
            let velocity_mps = [velocity[0], velocity[1], 0.0];
            self.sources.manoeuvres.learn(velocity_mps, &innovation);
        }
        // The shares of all sources in the estimate decay with this contribution.
        self.tracks
            .for_members(system, |member| member.share *= 1.0 - innovation.gain);
        self.tracks.sensors.get_mut(sensor).share += innovation.gain;
        let source = self.tracks.sensors.get(sensor).source;
        self.tracks.systems.get_mut(system).contributors |= 1 << source;
        self.points.learn(&mut self.tracks, sensor, &innovation);
        self.sources
            .learn_of_innovation(&self.settings, &mut self.tracks, sensor, &innovation, measurement);
    }

    /// Returns whether several reports in a row, from any source, lie so far from the estimate that the estimate is
    /// wrong. Covariance scaling and the learned noise of the sources would otherwise defend the estimate against all
    /// of them.
    fn is_astray(&mut self, sensor: SensorSlot, innovation: &crate::filter::FilterInnovation) -> bool {
        let entry = self.tracks.sensors.get(sensor);
        let (system, claimed) = (entry.system, &entry.latest.covariance);
        let entry = self.tracks.systems.get_mut(system);
        let known = &entry.filter.estimate.covariance;
        let variance_m2 = claimed.get(0, 0) + claimed.get(1, 1) + known.get(0, 0) + known.get(1, 1);
        let [east_m, north_m] = innovation.residual_m;
        let is_far = east_m * east_m + north_m * north_m > ASTRAY_SIGMAS * ASTRAY_SIGMAS * variance_m2;
        entry.astray = if is_far { entry.astray + 1 } else { 0 };
        entry.astray >= self.settings.association.split_reports
    }

    /// Restarts the unusable filter of a system track from the latest report of the sensor track.
    #[cold]
    pub(crate) fn restart(&mut self, sensor: SensorSlot, sink: &mut impl Sink) {
        self.tracks.restart_filter(sensor);
        self.outbox.to(sink).input(|| self.tracks.input(sensor, None));
        let entry = self.tracks.sensors.get(sensor);
        let (system, source) = (entry.system, entry.source);
        self.tracks.for_members(system, |member| member.share = 0.0);
        self.tracks.sensors.get_mut(sensor).share = 1.0;
        self.outbox.counts.add(source, Counter::EstimatesRestarted);
    }

    /// Records a fresh report of the system track.
    fn keep_alive(&mut self, sensor: SensorSlot, system: SystemSlot, report: &SensorTrack) {
        let fresh_until_ns = self.tracks.fresh_until(system);
        let systems = &mut self.tracks.systems;
        let entry = systems.get_mut(system);
        if entry.life == TrackState::Confirmed {
            self.sources.models[usize::from(report.source)].learn_detection(true);
        }
        entry.last_report_ns = entry.last_report_ns.max(report.time_of_measurement_ns);
        entry.fresh_until_ns = fresh_until_ns;
        entry.reports = entry.reports.saturating_add(1);
        entry.extrapolations = 0;
        entry.absence = 0.0;
        let [x, y] = [entry.filter.estimate.mean[0], entry.filter.estimate.mean[1]];
        systems.grid.place(system, x, y);
        systems.identify(system, &self.tracks.sensors.get(sensor).latest.identity);
    }

    /// Counts a scan without detection of an expected target.
    fn miss(&mut self, report: &SensorTrack, sink: &mut impl Sink) {
        let Some(sensor) = self.tracks.sensors.find(report.source, report.track_number) else {
            return;
        };
        let entry = self.tracks.sensors.get_mut(sensor);
        if entry.is_foreign {
            return;
        }
        entry.misses = entry.misses.saturating_add(1);
        let (system, role, misses) = (entry.system, entry.role, entry.misses);
        if system != NO_SYSTEM && role == Role::Primary {
            let out = &mut self.outbox.to(sink);
            let miss = (system, report, misses);
            life::count_miss(&self.settings, &mut self.tracks, &mut self.sources, miss, out);
        }
    }

    /// Drops a sensor track that its source has terminated.
    fn end_sensor_track(&mut self, sensor: SensorSlot, now_ns: i64, sink: &mut impl Sink) {
        let system = self.tracks.sensors.get(sensor).system;
        self.tracks.drop_sensor_track(sensor);
        if system != NO_SYSTEM && self.tracks.systems.get(system).members.is_none() {
            let out = &mut self.outbox.to(sink);
            life::suppress(&self.settings, &mut self.tracks, system, now_ns, out);
        }
    }

    /// Evaluates the learned properties of the sources once a second. Long computations are spread over the following
    /// reports, a step per report, so the result depends on the reports alone.
    fn learn_of_sources(&mut self) {
        let due = self.schedule.tick();
        if due {
            self.tracks.sensors.begin_part();
        }
        let confirmed = self.tracks.systems.count_in_state(TrackState::Confirmed);
        let enabled = self.settings.registration.enabled;
        let largest_m = self.settings.target_size.unknown_m;
        self.sources.register(
            due && enabled,
            largest_m,
            (confirmed, self.points.sees_points()),
            |source| {
                self.outbox.counts.add(source, Counter::EstimatesRestarted);
            },
        );
        if due {
            self.points.look(&self.sources, self.publisher.rule().keeps_points);
            let common_m2 = self.sources.registration.common_error_m2();
            self.publisher.set_common_error(self.points.spread_m2() + common_m2);
            self.sources.look_at_motion();
            let now_ns = self.schedule.now_ns();
            if self
                .tracks
                .lifetimes
                .follow(&self.settings.life, &mut self.settings.sources, now_ns)
            {
                self.scans
                    .follow_periods(&self.settings.sources, self.settings.association.scan_wait);
            }
        }
        self.tracks.drop_silent(self.schedule.now_ns());
    }
}

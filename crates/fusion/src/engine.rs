//! The engine: processes one report at a time and hands out the states of the system tracks that change.
//!
//! A report passes six steps, each with a folder:
//!
//! 1. *Admit*: the report is checked and completed ([`inlet`]). Time passes up to the report, and the known errors of
//!    the source's clock and frame are taken off. A late report takes a separate path from here (`update::late`).
//! 2. *Measure*: the measurement behind the report is found and freed of the source's biases (by [`Sources`]), and
//!    stored with the sensor track.
//! 3. *Associate*: [`Linking`] and [`Scans`] find the system track that the sensor track belongs to
//!    (`association_step` holds the gates). A report that the others contradict goes no further (`admit::admitting`).
//! 4. *Update*: the filter of the system track takes the measurement (`update::filtering`), about the point of the
//!    target seen by the source (`reference_point`).
//! 5. *Judge*: [`Life`] confirms, coasts, suspends and ends system tracks.
//! 6. *Publish*: [`TrackPublisher`] weighs the contributions and hands out the state.
//!
//! The engine learns nothing of the sources. The evidence of a report on the source is a [`Fact`], handed to
//! [`Sources::learn`] at its origin. Evidence of one target stays in the tables of [`Tracks`].

use messages::{Counter, SensorTrack, TrackState, sensor_track_bits};
use settings::SettingsError;
use source_models::{Fact, Measurement, ReportFact, Sources, whole_report};

use crate::admit::host_clock::HostClock;
use crate::admit::inlet::{self, SoundCovariances};
use crate::associate::scan::Scans;
use crate::engine_counters::EngineCounters;
use crate::explanation::Sink;
use crate::history::Histories;
use crate::judge::life::{self, Life};
use crate::orders::order_table::{Configured, IN_FORCE_MAX, OrderTable};
use crate::publish::outlet::EngineOutbox;
use crate::publish::publishing::TrackPublisher;
use crate::rules;
use crate::schedule::Schedule;
use crate::settings::Settings;
use crate::tables::sensor_tracks::{NO_SYSTEM, Role, SensorSlot, SensorTracks};
use crate::tables::system_tracks::{SystemSlot, SystemTracks};
use crate::tables::tracks::Tracks;
use crate::update::compared_means::ComparedMeans;
use crate::update::filter_input::UnseenErrors;
use crate::update::kept_measurements::KeptMeasurements;

/// Largest time of a report ahead of the engine's time, nanoseconds. The limit holds even if the clock of the source
/// is unknown: it bounds the lifetime of tracks and the number of steps through time.
const AHEAD_MAX_NS: i64 = 86_400_000_000_000;
/// Lead of a filter over all reports, nanoseconds, from which a wrong clock is taken as the cause.
const AHEAD_OF_CLOCKS_NS: i64 = 500_000_000;

/// Fusion of sensor tracks into system tracks.
#[derive(Debug)]
pub struct Engine {
    pub(crate) settings: Settings,
    pub(crate) tracks: Tracks,
    pub(crate) scans: Scans,
    pub(crate) life: Life,
    pub(crate) publisher: TrackPublisher,
    pub(crate) schedule: Schedule,
    pub(crate) host_clock: HostClock,
    pub(crate) orders: OrderTable,
    pub(crate) outbox: EngineOutbox,
    pub(crate) sound_covariances: SoundCovariances,
    pub(crate) compared: ComparedMeans,
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
        // A rule based on the filter's state needs neither history nor memory.
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
                Sources::new(&settings),
                KeptMeasurements::new(
                    settings.late_window_ns(),
                    capacity.kept_measurements(),
                    capacity.system_tracks(),
                ),
            ),
            scans: Scans::new(&settings.sources, settings.association.scan_wait),
            life: Life::new(&settings.sources),
            publisher: TrackPublisher::new(rule, &settings.sources),
            schedule: Schedule::new(settings.refresh_ns(), settings.refresh_delay_s.ns()),
            host_clock: HostClock::default(),
            orders: OrderTable::new(Configured::of(&settings)),
            outbox: EngineOutbox::new(sources),
            sound_covariances: SoundCovariances::new(sources),
            compared: ComparedMeans::new(sources),
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

    /// Returns the models of the sources.
    pub fn sources(&self) -> &Sources {
        &self.tracks.sources
    }

    /// Returns the settings in force.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Sets the host offset, the lead of the sources' time over the engine's time, nanoseconds; 0 at the start. The
    /// engine subtracts the offset from the times of reports and adds it to the times of states and decisions.
    pub fn set_host_offset(&mut self, offset_ns: i64) {
        self.host_clock.offset_ns = offset_ns;
    }

    /// Sets the clock offset of `source` against sound clocks, in seconds, as derived from times of receipt; `None`
    /// if unknown.
    pub fn set_source_clock(&mut self, source: u16, offset_s: Option<f64>) {
        self.tracks.sources.set_clock(&self.settings.sources, source, offset_s);
    }

    /// Advances the engine's time to `now_ns`; no report measured earlier may follow. System tracks with too old
    /// contributions coast, then terminate; each change is handed to `sink`. If a refresh time is set, the state of
    /// every system track is also handed out at each whole multiple of it.
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
            let until_ns = now_ns.min(other_ns);
            if self.tracks.systems.has_due_before(until_ns) && self.run_timer_before(until_ns, sink) {
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
            self.publisher
                .weigh_all(&self.settings, &mut self.tracks, time_ns, &mut self.outbox.to(sink));
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
        let has_sound_covariance = self.sound_covariances.have(report);
        if !inlet::is_valid(report, &self.settings.sources, has_sound_covariance) {
            let counter = inlet::rejection(report, &self.settings.sources);
            self.outbox.counts.add(report.source, counter);
            return;
        }
        self.tracks.sources.learn(
            &self.settings,
            Fact::Report(ReportFact::Stamped {
                source: report.source,
                time_ns: report.time_of_measurement_ns,
            }),
        );
        let corrected = inlet::corrected(report, &self.settings.sources, now_ns);
        let report = corrected.as_ref().unwrap_or(report);
        self.pass_time(now_ns, sink);
        // Before the first step of time the present is undefined.
        let now_ns = self.schedule.now_ns();
        let aligned = self.tracks.sources.aligned(&self.settings, report, now_ns);
        let report = aligned.as_ref().unwrap_or(report);
        self.tracks
            .sources
            .learn(&self.settings, Fact::Report(ReportFact::Came { report, now_ns }));
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
            // An extrapolated report contains no observation. An extrapolation agrees perfectly with itself, so a score
            // as observation would favour the report. The report therefore counts as missing (TI-4).
            self.outbox.counts.add(report.source, Counter::RejectedExtrapolated);
            self.miss(report, sink);
            return;
        }
        let is_foreign = self.settings.sources[usize::from(report.source)].is_centre;
        if !is_foreign {
            self.tracks
                .sources
                .learn(&self.settings, Fact::Report(ReportFact::Original(report)));
        }
        // Early look-up: the cache miss overlaps with the checks below.
        let known = self.tracks.sensors.find(report.source, report.track_number);
        let known = self.without_outdated(report, known, sink);
        let is_as_given = corrected.is_none() && aligned.is_none();
        let is_usable = self.sound_covariances.judge(report, is_as_given, has_sound_covariance);
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
        if self.tracks.sensors.get(sensor).epoch == self.tracks.sources.epoch_of(report.source) {
            return known;
        }
        self.end_sensor_track(sensor, report.time_of_measurement_ns, sink);
        None
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
            self.tracks
                .sources
                .learn(&self.settings, Fact::Report(ReportFact::Pressure(report)));
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
        self.tracks.learn_dependence(&self.settings, sensor);
        self.tracks.assign_role(sensor);
        let entry = self.tracks.sensors.get(sensor);
        if entry.role != Role::Primary {
            self.outbox.counts.add(report.source, Counter::RejectedDuplicate);
        } else if !entry.is_foreign && !self.admits(sensor) {
            self.set_aside(sensor, measurement);
        } else if system == before {
            self.update(sensor, report, measurement, sink);
        } else {
            let whole = whole_report(&self.tracks.sensors.get(sensor).latest);
            self.update(sensor, report, Some(&whole), sink);
        }
    }

    /// Updates the system track of a primary sensor track after its `report` has been stored; `measurement` is the new
    /// information in the report.
    pub(crate) fn update(
        &mut self,
        sensor: SensorSlot,
        report: &SensorTrack,
        measurement: Option<&Measurement>,
        sink: &mut impl Sink,
    ) {
        let entry = self.tracks.sensors.get(sensor);
        let (system, is_foreign) = (entry.system, entry.is_foreign);
        let target = self.tracks.systems.get_mut(system);
        let (life, was_shown, follows_centre) = (target.life, target.was_shown, target.is_foreign);
        target.nis = 0.0;
        if target.life == TrackState::Tentative && !was_shown {
            self.recognise(sensor, system);
        }
        let adds_nothing = measurement.is_some_and(|measurement| self.adds_nothing(sensor, measurement));
        if is_foreign {
            self.follow_centre(sensor);
        } else if follows_centre {
            // The filter repeats another centre's estimate; this is the first local measurement.
            self.tracks.restart_filter(sensor);
            self.outbox.to(sink).input(|| self.tracks.input(sensor, None));
            self.tracks.sensors.get_mut(sensor).share = 1.0;
        } else if self.is_misled(sensor) || self.is_ahead(sensor) {
            self.restart(sensor, sink);
        } else if let Some(measurement) = measurement
            && (self.tracks.is_established(sensor) || !self.tracks.sources.points().sees_points())
            && !self.corrects_claims(sensor, sink)
        {
            self.update_filter(sensor, measurement, sink);
        }
        self.keep_alive(sensor, system, report);
        self.compare(sensor, measurement);
        let out = &mut self.outbox.to(sink);
        let cause = (system, report);
        life::update_existence(&self.settings, &mut self.tracks, cause, out);
        if !was_shown && self.tracks.systems.get(system).was_shown && !self.tracks.systems.silent.is_empty() {
            self.take_former_number(sensor, report.time_of_measurement_ns, sink);
        }
        // The same state again is no news.
        if !adds_nothing || self.tracks.systems.get(system).life != life {
            let out = &mut self.outbox.to(sink);
            self.publisher.refresh(&self.settings, &mut self.tracks, cause, out);
        }
    }

    /// Returns whether the filter of the system track lies ahead of all reports, led there by a clock that has since
    /// been corrected.
    #[inline]
    fn is_ahead(&self, sensor: SensorSlot) -> bool {
        self.tracks.sources.corrects_clocks() && {
            let entry = self.tracks.sensors.get(sensor);
            let latest_ns = entry.time_ns.max(self.schedule.now_ns());
            self.tracks.systems.get(entry.system).filter.time_ns > latest_ns.saturating_add(AHEAD_OF_CLOCKS_NS)
        }
    }

    /// Records a fresh report of the system track.
    fn keep_alive(&mut self, sensor: SensorSlot, system: SystemSlot, report: &SensorTrack) {
        let mut fresh_until_ns = self.tracks.fresh_until(system);
        let entry = self.tracks.systems.get_mut(system);
        if entry.life == TrackState::Confirmed {
            self.tracks.sources.learn(
                &self.settings,
                Fact::Scan {
                    source: report.source,
                    is_detected: true,
                },
            );
        }
        let fresh_ns = entry.rhythm.fresh_ns();
        let interval_ns = report.time_of_measurement_ns - entry.last_report_ns;
        if entry.reports > 0 && interval_ns > 0 {
            let is_named = entry.identity.unique_number().is_some();
            self.tracks
                .sources
                .follow_rhythm(&mut entry.rhythm, (report.source, is_named), interval_ns);
        }
        entry.last_report_ns = entry.last_report_ns.max(report.time_of_measurement_ns);
        entry.reports = entry.reports.saturating_add(1);
        entry.extrapolations = 0;
        entry.absence = 0.0;
        let [x, y] = [entry.filter.estimate.mean[0], entry.filter.estimate.mean[1]];
        if entry.rhythm.fresh_ns() != fresh_ns {
            fresh_until_ns = self.tracks.fresh_until(system);
        }
        let systems = &mut self.tracks.systems;
        systems.get_mut(system).fresh_until_ns = fresh_until_ns;
        systems.grid.place(system, x, y);
        if systems.identify(system, &self.tracks.sensors.get(sensor).latest.identity) {
            self.outbox.counts.add(report.source, Counter::IdentityConflicts);
        }
    }

    /// Counts a scan without detection of an expected target.
    #[cold]
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
            life::count_miss(&self.settings, &mut self.tracks, miss, out);
        }
    }

    /// Drops a sensor track terminated by the source.
    #[cold]
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
        let begins = due && enabled;
        if begins || self.tracks.sources.is_solving() {
            self.tracks.sources.register(begins, largest_m, confirmed, |source| {
                self.outbox.counts.add(source, Counter::EstimatesRestarted);
            });
        }
        if due {
            let (now_ns, keeps_points) = (self.schedule.now_ns(), self.publisher.rule().keeps_points);
            let has_new_period = self.tracks.sources.tick(&mut self.settings, now_ns, keeps_points);
            self.publisher.set_unseen(UnseenErrors {
                per_axis_m2: self.tracks.sources.common_error_m2(),
                course_s2: self.tracks.sources.mean_course_s2(),
                height_m2: self.tracks.sources.mean_height_m2(),
            });
            if has_new_period {
                self.scans
                    .follow_periods(&self.settings.sources, self.settings.association.scan_wait);
            }
        }
        self.tracks.drop_silent(self.schedule.now_ns());
    }
}

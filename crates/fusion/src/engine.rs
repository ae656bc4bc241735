//! The engine: one report in, the states of the system tracks it changes out.
//!
//! What happens to a report is spread over the files that implement [`Engine`]:
//! `linking` decides to which system track a sensor track belongs, `scan` assigns what is new in a scan as a whole,
//! `feeding` feeds the system filter and learns from it, `life` confirms, coasts and ends, `publishing` weighs and tells.

use estimation::{Gaussian, NearlyConstantVelocity};
use messages::{Counter, Identity, NS_PER_S, STATE_LEN, SensorTrack, TrackState, sensor_track_bits};

use crate::accuracy::Accuracies;
use crate::association_step::Search;
use crate::counts::Counts;
use crate::existence::Coverage;
use crate::explanation::Sink;
use crate::measurement::{Correction, Measurement, as_reported, recovered_measurement, whole_report};
use crate::registration::{Registration, SourceErrors};
use crate::scan::Scans;
use crate::sensor_tracks::{NO_SYSTEM, Role, SensorSlot, SensorTracks};
use crate::settings::{AccuracyBase, Settings, SettingsError};
use crate::source_model::SourceModel;
use crate::system_tracks::SystemTracks;
use crate::weighing::Weighed;

/// Time between two looks at what was learned of the sources, nanoseconds.
const TICK_NS: i64 = 1_000_000_000;
/// Cells of the table in which it is learned where sources see, and their width.
const COVERAGE_CELLS: usize = 4096;
const COVERAGE_CELL_M: f64 = 5000.0;

/// What no sensor on this planet can report: metres, metres per second, and the squares of what it can be unsure of.
const POSITION_MAX_M: f64 = 1e8;
const SPEED_MAX_MPS: f64 = 1e5;
const COVARIANCE_MAX: f64 = 1e14;
/// Farther apart than this, two reports of one address are not of one target, metres.
const ADDRESS_REACH_M: f64 = 10e3;

/// Fusion of sensor tracks into system tracks.
#[derive(Debug)]
pub struct Engine {
    pub(crate) settings: Settings,
    pub(crate) sensors: SensorTracks,
    pub(crate) systems: SystemTracks,
    pub(crate) accuracies: Accuracies,
    pub(crate) counts: Counts,
    /// What was learned of each source.
    pub(crate) models: Vec<SourceModel>,
    pub(crate) registration: Registration,
    pub(crate) coverage: Coverage,
    /// Sensor tracks that wait until their scan is complete.
    pub(crate) scans: Scans,
    /// How targets move, as far as is known.
    pub(crate) motion: NearlyConstantVelocity,
    /// Whether the sources see different points of the targets.
    sees_points: bool,
    /// Whether they do and the rule keeps one per target.
    pub(crate) keeps_points: bool,
    /// How far such points lie from the target's middle, as a variance per axis, m²; 0 where none is kept.
    pub(crate) point_spread_m2: f64,
    /// Counts the changes of `keeps_points`: what was estimated before the last one is void.
    pub(crate) points_epoch: u32,
    /// The latest time that has been said to have passed, nanoseconds.
    now_ns: i64,
    next_tick_ns: Option<i64>,
    /// Room to weigh one system track; taken out meanwhile.
    pub(crate) weighed: Option<Box<Weighed>>,
    /// No entry is left unlooked-at for longer than this, so that its deadline can be put off but never missed.
    pub(crate) shortest_fresh_ns: i64,
    /// The next whole multiple of the refresh time; `None` while nothing lives, and where reports refresh.
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
        let areas = settings.sources.iter().map(|source| source.coverage.clone()).collect();
        let registration = &settings.registration;
        let tick_s = TICK_NS as f64 / NS_PER_S;
        Ok(Self {
            sensors: SensorTracks::new(
                capacity.sensor_tracks,
                // Rules that take their state from the filter do not look back.
                (!settings.rule.rule.is_from_filter()).then_some(capacity.stored_reports),
            ),
            systems: SystemTracks::new(
                capacity.system_tracks,
                settings.association.cell_m,
                !settings.rule.rule.is_from_filter(),
            ),
            accuracies: Accuracies::new(sources),
            counts: Counts::new(sources),
            models: vec![SourceModel::default(); sources],
            registration: Registration::new(sources, registration.reference_source, registration.memory_s, tick_s),
            coverage: Coverage::new(areas, COVERAGE_CELLS, COVERAGE_CELL_M),
            scans: Scans::new(sources),
            motion: NearlyConstantVelocity::new(settings.process_noise_m2ps3, settings.process_noise_m2ps3),
            sees_points: false,
            keeps_points: false,
            point_spread_m2: 0.0,
            points_epoch: 0,
            now_ns: i64::MIN,
            next_tick_ns: None,
            weighed: Some(Box::default()),
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

    /// What is known of the systematic errors of `source` (BF-3); `None` if there is no such source.
    pub fn source_errors(&self, source: u16) -> Option<&SourceErrors> {
        (usize::from(source) < self.settings.sources.len()).then(|| self.registration.of(source))
    }

    /// Factor by which the covariances of `source` are being inflated, since they claim too much (BF-5); 1 if they do not.
    pub fn inflation(&self, source: u16) -> Option<f64> {
        self.models.get(usize::from(source)).map(SourceModel::inflation)
    }

    /// From now on the named condition (weather) holds (TI-7); "normal" at the start. `false` if no source names it: then
    /// nothing changes.
    pub fn set_condition(&mut self, name: &str) -> bool {
        self.accuracies.set_condition(&self.settings, name)
    }

    /// Lets time pass up to `now_ns` (UTC): no report measured before that will follow. System tracks whose
    /// contributions have become too old coast, then end; each such change is handed to `sink`. With a refresh time set,
    /// so is the state of every system track at each whole multiple of it.
    ///
    /// What happens, happens at times that reports have set, in the order of these times; how often and in how large
    /// steps time passes changes nothing.
    pub fn advance(&mut self, now_ns: i64, sink: &mut impl Sink) {
        loop {
            let (scan_ns, refresh_ns) = (self.scans.due_ns(), self.next_refresh());
            let other_ns = scan_ns.min(refresh_ns);
            if self.meet_deadline_before(now_ns.min(other_ns), sink) {
                continue;
            }
            if other_ns >= now_ns {
                break;
            }
            self.now_ns = self.now_ns.max(other_ns);
            if scan_ns == other_ns {
                self.finish_scans(scan_ns, sink);
            } else {
                self.refresh_all(refresh_ns, sink);
            }
        }
        self.now_ns = self.now_ns.max(now_ns);
    }

    /// When the next refresh is due, as nothing measured up to its time follows then: nanoseconds; never (`i64::MAX`)
    /// where there is nothing to show.
    fn next_refresh(&mut self) -> i64 {
        let Some(period_ns) = self.settings.refresh_ns else {
            return i64::MAX;
        };
        if self.systems.is_empty() {
            self.next_refresh_ns = None;
            return i64::MAX;
        }
        let delay_ns = self.settings.refresh_delay_ns;
        let next_ns = *self.next_refresh_ns.get_or_insert_with(|| {
            let past_ns = self.now_ns.saturating_sub(delay_ns).saturating_sub(1);
            past_ns
                .div_euclid(period_ns)
                .saturating_add(1)
                .saturating_mul(period_ns)
        });
        next_ns.saturating_add(delay_ns)
    }

    /// Hands out the state of every system track at the refresh time that is due at `due_ns`. What was reported up to
    /// that time shall be in it.
    fn refresh_all(&mut self, due_ns: i64, sink: &mut impl Sink) {
        self.finish_scans(i64::MAX, sink);
        while self.meet_deadline_before(due_ns, sink) {}
        let time_ns = due_ns - self.settings.refresh_delay_ns;
        self.weigh_all(time_ns, sink);
        self.next_refresh_ns = self
            .settings
            .refresh_ns
            .map(|period_ns| time_ns.saturating_add(period_ns));
    }

    /// Takes one report. Every system-track state that it changes is handed to `sink`.
    ///
    /// Reports should come in the order of their times; one older than its own sensor track's latest is refused.
    pub fn take(&mut self, report: &SensorTrack, sink: &mut impl Sink) {
        if !self.is_valid(report) {
            self.counts.add(report.source, Counter::RejectedInvalid);
            return;
        }
        self.advance(report.time_of_measurement_ns, sink);
        self.tick();
        if report.state == TrackState::Coasted as u8 {
            // The source has seen nothing. Its extrapolation agrees with itself perfectly, which says nothing about the
            // target: scored like an observation, it would win. So it is a missing report (TI-4).
            self.counts.add(report.source, Counter::RejectedExtrapolated);
            self.miss(report, sink);
            return;
        }
        // Asked for early: the answer comes from afar, and until it is needed there is other work.
        let known = self.sensors.find(report.source, report.track_number);
        let repaired = if estimation::is_usable(&report.covariance) {
            None
        } else if let Some(repaired) = self.repaired(report) {
            Some(repaired)
        } else {
            self.counts.add(report.source, Counter::RejectedInvalid);
            return;
        };
        let report = repaired.as_ref().unwrap_or(report);
        let identity = self.believed_identity(report);
        let Some(earlier) = self.earlier(report, known) else {
            return;
        };
        let mut measurement = self.measurement_behind(report, earlier, repaired.is_some());
        let correction = self.correction_of(report);
        if let Some(measurement) = &mut measurement {
            measurement.correct(&correction);
        }
        let Some(sensor) = self.place_of_sensor_track(report, earlier) else {
            return;
        };
        let entry = self.sensors.get_mut(sensor);
        entry.take(report, identity, &correction);
        entry.repaired = repaired.is_some();
        let period_ns = self.settings.sources[usize::from(report.source)].period_ns;
        self.sensors.note(sensor, period_ns);
        if report.state == TrackState::Terminated as u8 {
            self.counts.add(report.source, Counter::TracksEnded);
            self.end_sensor_track(sensor, report.time_of_measurement_ns, sink);
            return;
        }
        let before = self.sensors.get(sensor).system;
        self.relate(sensor, report, sink);
        if self.settings.association.scan_wait == 0.0 && self.sensors.get(sensor).waits {
            self.finish_scans(i64::MAX, sink);
            if before == NO_SYSTEM {
                return;
            }
        }
        let system = self.sensors.get(sensor).system;
        if system == NO_SYSTEM {
            return;
        }
        self.assign_role(sensor);
        if self.sensors.get(sensor).role != Role::Primary {
            self.counts.add(report.source, Counter::RejectedDuplicate);
        } else if system == before {
            self.contribute(sensor, report, measurement.as_ref(), sink);
        } else {
            let whole = whole_report(&self.sensors.get(sensor).latest);
            self.contribute(sensor, report, Some(&whole), sink);
        }
    }

    fn is_valid(&self, report: &SensorTrack) -> bool {
        // Not a number is within no limit. All are looked at, without a branch for each.
        let within = |values: &[f64], limit: f64| values.iter().fold(true, |all, value| all & (value.abs() <= limit));
        usize::from(report.source) < self.settings.sources.len()
            && TrackState::from_code(report.state).is_some()
            && within(&report.position_m, POSITION_MAX_M)
            && within(&report.velocity_mps, SPEED_MAX_MPS)
            && within(&report.covariance.upper, COVARIANCE_MAX)
            && (0..STATE_LEN).all(|index| report.covariance.get(index, index) >= 0.0)
            && (0..2).all(|index| report.covariance.get(index, index) > 0.0)
    }

    /// The report with its covariance, which is not positive definite, made usable. `None` if there is nothing to keep of it.
    #[cold]
    fn repaired(&mut self, report: &SensorTrack) -> Option<SensorTrack> {
        let mut full = estimation::unpacked(&report.covariance);
        for component in 0..STATE_LEN {
            if full[(component, component)] == 0.0 {
                full.row_mut(component).fill(0.0);
                full.column_mut(component).fill(0.0);
                full[(component, component)] = 1.0;
            }
        }
        let covariance = estimation::packed(&estimation::repaired(&full)?);
        self.counts.add(report.source, Counter::CovariancesRepaired);
        Some(SensorTrack { covariance, ..*report })
    }

    /// An address that belongs to a target far away is not believed: transponders are misread, and two can have the same.
    fn believed_identity(&mut self, report: &SensorTrack) -> Identity {
        let identity = report.identity;
        let Some(address) = identity
            .unique_number()
            .filter(|_| self.settings.association.use_identity)
        else {
            return identity;
        };
        let Some(system) = self.systems.with_address(address) else {
            return identity;
        };
        let carried_m = self.systems.get(system).filter.place_at(report.time_of_measurement_ns);
        let apart = |axis: usize| report.position_m[axis] - carried_m[axis];
        if apart(0) * apart(0) + apart(1) * apart(1) <= ADDRESS_REACH_M * ADDRESS_REACH_M {
            return identity;
        }
        self.counts.add(report.source, Counter::IdentityConflicts);
        identity.without_unique_number()
    }

    /// The entry of the report's sensor track: the one it has, or a new one, then not linked yet. `None` if the table is full.
    fn place_of_sensor_track(
        &mut self,
        report: &SensorTrack,
        earlier: Option<(SensorSlot, f64)>,
    ) -> Option<SensorSlot> {
        if let Some((sensor, _)) = earlier {
            return Some(sensor);
        }
        let inserted = self.sensors.insert(report);
        if inserted.is_none() {
            self.counts.add(report.source, Counter::DroppedTable);
        }
        inserted
    }

    /// The entry of the report's sensor track and the seconds since its latest report; `Some(None)` if there is no entry
    /// yet; `None` if the report is older.
    fn earlier(&mut self, report: &SensorTrack, known: Option<SensorSlot>) -> Option<Option<(SensorSlot, f64)>> {
        let Some(sensor) = known else {
            return Some(None);
        };
        let age_ns = report.time_of_measurement_ns - self.sensors.get(sensor).time_ns;
        let ends = report.state == TrackState::Terminated as u8;
        if age_ns < 0 || (age_ns == 0 && !ends) {
            self.counts.add(report.source, Counter::RejectedOutOfOrder);
            return None;
        }
        if age_ns > self.settings.life.terminate_ns {
            // The source has used the number again for something else.
            self.drop_sensor_track(sensor);
            return Some(None);
        }
        Some(Some((sensor, age_ns as f64 / NS_PER_S)))
    }

    /// The measurement that led from the sensor track's latest report, `earlier`, to this one.
    fn measurement_behind(
        &mut self,
        report: &SensorTrack,
        earlier: Option<(SensorSlot, f64)>,
        repaired: bool,
    ) -> Option<Measurement> {
        let model = &mut self.models[usize::from(report.source)];
        let Some((sensor, seconds)) = earlier.filter(|(_, seconds)| *seconds > 0.0) else {
            return Some(as_reported(report));
        };
        let (looks, knows) = (!repaired && model.looks_at_noise(), model.process_noise().is_some());
        if !looks && !knows {
            return Some(as_reported(report));
        }
        let has_height = report.has(sensor_track_bits::HEIGHT);
        let (before, after) = (self.sensors.get(sensor).as_reported().unpacked(), gaussian_of(report));
        if looks {
            model.learn_noise(&before.covariance, &after.covariance, seconds, has_height);
        }
        match model.process_noise() {
            Some(noise) => recovered_measurement(&noise.predicted(&before, seconds), &after, report),
            None => Some(as_reported(report)),
        }
    }

    /// What is known to be wrong with a report.
    fn correction_of(&self, report: &SensorTrack) -> Correction {
        Correction {
            shift_m: self.registration.shift(
                report.source,
                report.position_m,
                report.velocity_mps,
                self.place_of(report.source),
            ),
            inflation: self.models[usize::from(report.source)].inflation(),
        }
    }

    /// Where a source that measures range and azimuth stands.
    pub(crate) fn place_of(&self, source: u16) -> Option<[f64; 2]> {
        match self.settings.sources[usize::from(source)].accuracy.base {
            AccuracyBase::Polar { place_m, .. } => Some(place_m),
            _ => None,
        }
    }

    pub(crate) fn search(&self) -> Search<'_> {
        Search {
            settings: &self.settings,
            sensors: &self.sensors,
            systems: &self.systems,
            models: &self.models,
            motion: &self.motion,
        }
    }

    /// Looks, once a second, at what was learned of the sources as a whole. What takes long is spread over the reports
    /// that follow: a report at a time, so that the result depends on reports alone.
    fn tick(&mut self) {
        let now_ns = self.now_ns;
        let due_ns = *self.next_tick_ns.get_or_insert(now_ns.saturating_add(TICK_NS));
        let due = now_ns >= due_ns;
        if due {
            self.next_tick_ns = Some(now_ns.saturating_add(TICK_NS));
            self.sensors.begin_part();
            if self.settings.registration.enabled {
                self.registration.begin();
            }
        }
        if self.registration.is_solving() && self.registration.step() {
            self.decide_on_errors();
        }
        if due {
            self.look_at_points();
            self.look_at_motion();
        }
        self.drop_silent(now_ns.saturating_sub(self.settings.life.terminate_ns));
    }

    /// The errors of all sources have been estimated anew: which of them are significant?
    fn decide_on_errors(&mut self) {
        let targets = self.systems.count_in_state(TrackState::Confirmed);
        // What one source's points are away from the others', the others' are from its.
        let spread_m2 = self.models.iter().map(SourceModel::spread_m2).fold(0.0, f64::max);
        let known = |source: usize| self.models[source].knows_spread();
        self.registration.decide(known, spread_m2, targets, self.sees_points);
    }

    /// Frees sensor tracks without report since `since_ns`, a few places of the table at a time.
    fn drop_silent(&mut self, since_ns: i64) {
        for sensor in self.sensors.next_places() {
            if self.sensors.is_silent(sensor, since_ns) {
                self.drop_sensor_track(sensor);
            }
        }
    }

    /// Whether some source's detection points lie well apart from the others'.
    fn look_at_points(&mut self) {
        const BEGIN: f64 = 2.0;
        const END: f64 = 1.0;
        let ratio = if self.sees_points { END } else { BEGIN };
        self.sees_points = self.models.iter().any(|model| model.sees_points(ratio));
        let keep = self.sees_points && self.settings.rule.rule.keeps_points;
        // One of several points, taken for the target's middle, is as far off as they are from each other.
        let spread_m2 = self.models.iter().map(SourceModel::spread_m2).fold(0.0, f64::max);
        self.point_spread_m2 = if keep { spread_m2 } else { 0.0 };
        if keep != self.keeps_points {
            self.keeps_points = keep;
            self.points_epoch = self.points_epoch.wrapping_add(1);
        }
    }

    /// The sources' own trackers know how their targets move: the median of what they assume is taken over.
    fn look_at_motion(&mut self) {
        let mut known = [NearlyConstantVelocity::new(0.0, 0.0); crate::settings::SOURCES_MAX];
        let mut count = 0;
        for motion in self.models.iter().filter_map(SourceModel::process_noise) {
            known[count] = motion;
            count += 1;
        }
        if count == 0 {
            return;
        }
        let known = &mut known[..count];
        known.sort_unstable_by(|a, b| a.density_m2ps3[0].total_cmp(&b.density_m2ps3[0]));
        self.motion = known[count / 2];
    }
}

/// A report's state as a Gaussian.
pub(crate) fn gaussian_of(report: &SensorTrack) -> Gaussian {
    Gaussian::from_message(report.position_m, report.velocity_mps, &report.covariance)
}

#[cfg(test)]
pub(crate) fn test_settings(sources: usize) -> Settings {
    use crate::settings::{
        Accuracy, AccuracyBase, AssociationSettings, Capacity, LifeSettings, RegistrationSettings, RuleSettings,
        SourceSettings,
    };
    let source = |index: usize| SourceSettings {
        name: format!("source{index}"),
        sensor_uid: 0,
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
        coverage: None,
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
            scan_wait: 0.0,
            ..AssociationSettings::default()
        },
        life: LifeSettings::default(),
        rule: RuleSettings {
            rule: crate::rules::find("best-source").expect("it is in the registry"),
            ..RuleSettings::default()
        },
        registration: RegistrationSettings::default(),
        consistency: true,
        process_noise_m2ps3: 1.0,
        refresh_ns: None,
        refresh_delay_ns: 0,
    }
}

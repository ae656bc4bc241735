//! A simulated sensor: looks at the truth, tracks what it finds, and delivers sensor tracks.
//!
//! The sensor keeps one track per target and never confuses two targets; what it gets wrong is where they are (noise,
//! biases), whether they are there (misses, dropouts, false targets), and what has become of them (a track that ended
//! comes back with a new number).

use messages::{Identity, SensorTrack, TrackState, sensor_track_bits};
use observations::Truth as Of;
use rand::RngExt as _;
use settings::SettingsError;

use crate::false_target::{self, FalseTarget};
use crate::local_track::LocalTrack;
use crate::measurement::Measurement;
use crate::plot::Plot;
use crate::random::{Purpose, stream};
use crate::resolution::Company;
use crate::schedule::{Aim, Slot};
use crate::sensor_settings::{Checked, Dropouts, SensorIdentity, SensorKind, SensorSettings};
use crate::truth::{TargetState, Truth};

/// Most false targets that one sensor follows at a time; further ones do not appear.
pub const FALSE_TARGETS_MAX: usize = 256;
/// Track numbers set aside per delivery, so that a sensor that begins in mid-scenario does not use numbers again that
/// it gave before: it may make this many new tracks per delivery on average.
const NUMBERS_PER_SLOT: u64 = 64;

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct SimulatedSensor {
    looks: Looks,
    slot: Slot,
    next_number: u32,
    /// By number of the target.
    targets: Vec<Watched>,
    false_targets: Vec<(FalseTarget, Watched)>,
}

impl SimulatedSensor {
    /// A sensor that begins at the scenario's start, which is at `start_utc_ns` (UTC, nanoseconds since 1970). It
    /// reports as source number `source`, which also sets its random numbers apart from those of other sensors.
    ///
    /// # Errors
    /// A setting that cannot be used.
    pub fn new(settings: &SensorSettings, seed: u64, source: u16, start_utc_ns: i64) -> Result<Self, SettingsError> {
        let settings = settings.checked()?;
        Ok(Self {
            slot: Slot::new(0, &settings),
            looks: Looks {
                settings,
                seed,
                source,
                start_utc_ns,
            },
            next_number: 1,
            targets: Vec::new(),
            false_targets: Vec::with_capacity(FALSE_TARGETS_MAX),
        })
    }

    /// Begins anew, without tracks, with the first delivery at or after `time_s` seconds from the scenario's start.
    pub fn restart_at(&mut self, time_s: f64) {
        self.slot = Slot::first_delivered_from(time_s, &self.looks.settings);
        self.next_number = ((self.slot.number * NUMBERS_PER_SLOT) as u32).saturating_add(1);
        self.targets.clear();
        self.false_targets.clear();
    }

    /// When the next delivery is due, seconds from the scenario's start.
    pub fn next_scan_time_s(&self) -> f64 {
        self.slot.delivered_s(&self.looks.settings)
    }

    /// Time of measurement before which no later delivery will report, seconds from the scenario's start.
    pub fn progress_s(&self) -> f64 {
        self.slot.begin_s()
    }

    /// When the period began, seconds from the scenario's start, if the next delivery is its first: a radar's antenna
    /// then pointed north.
    pub fn period_begins_s(&self) -> Option<f64> {
        let (_, slot_of_period) = self.slot.period(&self.looks.settings);
        (slot_of_period == 0).then_some(self.slot.begin_s())
    }

    /// Time between two looks at one target, seconds.
    pub fn period_s(&self) -> f64 {
        self.looks.settings.schedule.period_s
    }

    /// Whether the sensor could see `target` where it is now: within coverage, and with the equipment that the sensor
    /// needs. Misses and dropouts do not count: they are the sensor's failures, not the target's absence.
    pub fn observes(&self, target: &TargetState) -> bool {
        self.looks.settings.coverage.contains(target.position_m) && self.looks.watched(u64::from(target.id)).equipped
    }

    /// Appends what the next delivery reports, in order of the time of measurement, and goes on to the one after it.
    ///
    /// Sequence number and stages are left 0, for the publisher to fill in.
    pub fn scan(&mut self, truth: &Truth, out: &mut Vec<SensorTrack>) {
        self.scan_for(truth, out, None);
    }

    /// As [`SimulatedSensor::scan`], and appends to `plots` what the sensor detected, in order of the time too.
    pub fn scan_with_plots(&mut self, truth: &Truth, out: &mut Vec<SensorTrack>, plots: &mut Vec<Plot>) {
        let first = plots.len();
        let slot = self.slot;
        self.scan_for(truth, out, Some(plots));
        let looks = &self.looks;
        let settings = &looks.settings;
        Plot::false_ones(settings, (looks.seed, looks.source), &slot, |time_s, found| {
            plots.push(looks.plot(&slot, time_s, Of::FalseAlarm, &found));
        });
        // Of one time, targets come in the order of their numbers, false ones after them: the sort is stable.
        plots[first..].sort_by_key(|plot| plot.time_of_measurement_ns);
    }

    fn scan_for(&mut self, truth: &Truth, out: &mut Vec<SensorTrack>, mut plots: Option<&mut Vec<Plot>>) {
        let first = out.len();
        let looks = &self.looks;
        let mut told = Told {
            next_number: &mut self.next_number,
            out,
        };
        for index in self.targets.len()..truth.len() {
            self.targets.push(looks.watched(index as u64));
        }
        let cell = looks.settings.resolution.as_ref().filter(|_| plots.is_some());
        let company = cell.map(|cell| Company::find(cell, looks, &self.slot, truth, &self.targets));
        for index in 0..truth.len() {
            let see = |time_s| Seen::target(truth.target_at(index, time_s), looks);
            let look = looks.look(&self.slot, index as u64, &mut self.targets[index], see, &mut told);
            let (Some((time_s, found)), Some(plots)) = (look, &mut plots) else {
                continue;
            };
            let echo = match &company {
                Some(company) => company.echo(looks, &self.slot, (truth, time_s), &self.targets, (index, found)),
                None => found.map(|found| (Of::Target(index as u32), found)),
            };
            plots.extend(echo.map(|(of, found)| looks.plot(&self.slot, time_s, of, &found)));
        }

        let (period, slot_of_period) = self.slot.period(&looks.settings);
        if slot_of_period == 0 {
            for index in 0..FalseTarget::count(&looks.settings, looks.seed, looks.source, period) {
                let target = FalseTarget::new(&looks.settings, looks.seed, looks.source, period, index);
                if self.false_targets.len() < FALSE_TARGETS_MAX {
                    let watched = looks.watched(target.thing);
                    self.false_targets.push((
                        target,
                        Watched {
                            equipped: true,
                            ..watched
                        },
                    ));
                }
            }
        }
        for (target, watched) in &mut self.false_targets {
            let see = |time_s| Seen::false_target(target, time_s);
            let look = looks.look(&self.slot, target.thing, watched, see, &mut told);
            if let (Some((time_s, Some(found))), Some(plots)) = (look, &mut plots) {
                plots.push(looks.plot(&self.slot, time_s, Of::FalseAlarm, &found));
            }
        }
        let over_s = self.slot.begin_s();
        self.false_targets
            .retain(|(target, watched)| target.lasts_at(over_s) || watched.track.is_some());

        out[first..].sort_unstable_by_key(|report| (report.time_of_measurement_ns, report.track_number));
        self.slot = Slot::new(self.slot.number + 1, &looks.settings);
    }
}

/// What the sensor keeps of one target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Watched {
    /// The target's turn within a period, 0 to 1.
    phase: f64,
    /// Whether it has the equipment that this sensor needs.
    pub(crate) equipped: bool,
    latest_look_s: f64,
    track: Option<LocalTrack>,
}

/// What there is to be seen at the time of a look.
pub(crate) struct Seen {
    position_m: [f64; 3],
    identity: Identity,
    on_ground: bool,
    /// Probability that a look within coverage finds it.
    detection_probability: f64,
}

impl Seen {
    pub(crate) fn target(state: TargetState, looks: &Looks) -> Self {
        Self {
            position_m: state.position_m,
            identity: looks.identity_of(&state),
            // A radar measures a position; whether the target stands on wheels is known from its replies only.
            on_ground: state.on_ground && looks.settings.kind != SensorKind::Radar,
            detection_probability: looks.settings.detection_probability,
        }
    }

    fn false_target(target: &FalseTarget, time_s: f64) -> Self {
        Self {
            position_m: target.position_at(time_s),
            identity: Identity::default(),
            on_ground: false,
            detection_probability: if target.lasts_at(time_s) {
                false_target::DETECTION_PROBABILITY
            } else {
                0.0
            },
        }
    }
}

/// Where the outcome of looks goes.
struct Told<'a> {
    next_number: &'a mut u32,
    out: &'a mut Vec<SensorTrack>,
}

/// All that a look depends on and never changes.
#[derive(Clone, Debug)]
pub(crate) struct Looks {
    pub(crate) settings: Checked,
    pub(crate) seed: u64,
    pub(crate) source: u16,
    start_utc_ns: i64,
}

impl Looks {
    fn watched(&self, thing: u64) -> Watched {
        let mut random = stream(self.seed, Purpose::Acquaintance, self.source, thing, 0);
        Watched {
            phase: random.random_range(0.0..1.0),
            equipped: random.random_bool(self.settings.equipped_share),
            latest_look_s: f64::NEG_INFINITY,
            track: None,
        }
    }

    /// Looks at one thing if its turn comes in this slot, and reports its track if there is one then; when, and what it
    /// found.
    fn look(
        &self,
        slot: &Slot,
        thing: u64,
        watched: &mut Watched,
        see: impl Fn(f64) -> Seen,
        told: &mut Told<'_>,
    ) -> Option<(f64, Option<Measurement>)> {
        let aim = Aim {
            seed: self.seed,
            source: self.source,
            thing,
            phase: watched.phase,
        };
        let time_s = slot.look_s(&self.settings, &aim, |time_s| see(time_s).position_m)?;
        // A target that moves against the antenna's turn at the edge of two sectors must not be counted twice.
        if time_s - watched.latest_look_s < 0.5 * self.settings.schedule.period_s {
            return None;
        }
        watched.latest_look_s = time_s;
        let seen = see(time_s);
        let found = self.find(slot, thing, watched.equipped, time_s, &seen);
        let tracking = &self.settings.tracking;
        match (&mut watched.track, &found) {
            (Some(track), found) => track.look(time_s, found.as_ref(), tracking),
            (None, Some(first)) => {
                watched.track = Some(LocalTrack::new(*told.next_number, time_s, first, tracking));
                *told.next_number = told.next_number.wrapping_add(1).max(1);
            }
            (None, None) => {}
        }
        if let Some(track) = watched.track {
            told.out.push(self.report(&track, time_s, &seen, found.as_ref()));
            if track.state == TrackState::Terminated {
                watched.track = None;
            }
        }
        Some((time_s, found))
    }

    fn plot(&self, slot: &Slot, time_s: f64, of: Of, found: &Measurement) -> Plot {
        let (settings, scan) = (&self.settings, slot.period(&self.settings).0);
        let site_m = settings.coverage.position_m;
        Plot::new((self.utc_ns(time_s), scan), of, found, site_m, &settings.errors)
    }

    fn utc_ns(&self, time_s: f64) -> i64 {
        self.start_utc_ns + (time_s * messages::NS_PER_S).round() as i64
    }

    /// Whether a look at it could find it.
    pub(crate) fn may_find(&self, thing: u64, equipped: bool, time_s: f64, position_m: [f64; 3]) -> bool {
        equipped && self.settings.coverage.contains(position_m) && !self.dropped_out(thing, time_s)
    }

    pub(crate) fn find(
        &self,
        slot: &Slot,
        thing: u64,
        equipped: bool,
        time_s: f64,
        seen: &Seen,
    ) -> Option<Measurement> {
        if !self.may_find(thing, equipped, time_s, seen.position_m) {
            return None;
        }
        let mut random = stream(self.seed, Purpose::Look, self.source, thing, slot.number);
        if !random.random_bool(seen.detection_probability) {
            return None;
        }
        let site = self.settings.coverage.position_m;
        Some(self.settings.errors.measure(site, seen.position_m, &mut random))
    }

    /// Whether the thing has one of its dropouts: one per stretch of time, anywhere in it.
    fn dropped_out(&self, thing: u64, time_s: f64) -> bool {
        let Some(Dropouts { every_s, duration_s }) = self.settings.dropouts else {
            return false;
        };
        let stretch = (time_s / every_s).floor();
        let mut random = stream(self.seed, Purpose::Outage, self.source, thing, stretch as i64 as u64);
        let begin_s = stretch * every_s + random.random_range(0.0..1.0) * (every_s - duration_s);
        (begin_s..begin_s + duration_s).contains(&time_s)
    }

    fn identity_of(&self, state: &TargetState) -> Identity {
        let identity = Identity::default();
        let with_code = |identity: Identity| match state.mode_3a {
            Some(code) => identity.with_mode_3a(code),
            None => identity,
        };
        let with_address = |identity: Identity| identity.with_address(state.address).with_callsign(state.callsign);
        match self.settings.identity {
            SensorIdentity::None => identity,
            SensorIdentity::Mode3A => with_code(identity),
            SensorIdentity::Address => with_address(identity),
            SensorIdentity::Full => with_address(with_code(identity)),
        }
    }

    fn report(&self, track: &LocalTrack, time_s: f64, seen: &Seen, found: Option<&Measurement>) -> SensorTrack {
        use sensor_track_bits::*;
        let height = self.settings.errors.height_sigma_m.is_some();
        let mut valid = OWN_COVARIANCE | TRACE;
        let mut set = |bit: u16, holds: bool| valid |= if holds { bit } else { 0 };
        set(HEIGHT, height);
        set(VELOCITY, track.has_velocity());
        set(VERTICAL_RATE, height && track.has_velocity());
        set(MEASURED, found.is_some());
        set(ON_GROUND, seen.on_ground);
        SensorTrack {
            time_of_measurement_ns: self.utc_ns(time_s),
            track_number: track.number,
            source: self.source,
            valid,
            identity: seen.identity,
            position_m: track.gaussian.position_m(),
            velocity_mps: track.gaussian.velocity_mps(),
            covariance: track.gaussian.covariance,
            measured_m: found.map_or([0.0; 3], |found| found.position_m),
            trace_m2: track.gaussian.horizontal_trace_m2(),
            state: track.state as u8,
            ..SensorTrack::default()
        }
    }
}

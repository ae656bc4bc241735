//! Looks of a sensor at a target: times, detections, and effects on the track.

use messages::{Identity, SensorTrack, TrackState, level_of, sensor_track_bits};
use observations::DetectionTruth as Of;
use rand::RngExt as _;

use crate::false_target::{self, FalseTarget};
use crate::local_track::LocalTrack;
use crate::measurement::SimulatedMeasurement;
use crate::plot::RadarPlot;
use crate::random::{Purpose, stream};
use crate::schedule::{Aim, Slot};
use crate::sensor_settings::{CheckedSensor, Dropouts, SensorIdentity, SensorKind};
use crate::target::TargetState;

/// State of one target in the sensor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SensorTarget {
    /// Position of the target's look within a period, 0 to 1.
    phase: f64,
    /// Whether the target has the equipment that this sensor needs.
    pub(crate) equipped: bool,
    latest_look_s: f64,
    pub(crate) track: Option<LocalTrack>,
}

/// Target as visible at the time of a look.
pub(crate) struct VisibleTarget {
    position_m: [f64; 3],
    height_m: f64,
    identity: Identity,
    on_ground: bool,
    /// Detection probability of a look within coverage.
    detection_probability: f64,
}

impl VisibleTarget {
    pub(crate) fn target(state: TargetState, looks: &LookParameters) -> Self {
        Self {
            position_m: state.position_m,
            height_m: state.height_m,
            identity: looks.identity_of(&state),
            // A radar measures a position; only the target's replies could report contact with the ground.
            on_ground: state.on_ground && looks.settings.kind != SensorKind::Radar,
            detection_probability: looks.settings.detection_probability,
        }
    }

    pub(crate) fn false_target(target: &FalseTarget, time_s: f64) -> Self {
        Self {
            position_m: target.position_at(time_s),
            height_m: target.position_at(time_s)[2],
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

/// Destination of the looks' results.
pub(crate) struct Told<'a> {
    pub(crate) next_number: &'a mut u32,
    pub(crate) out: &'a mut Vec<SensorTrack>,
}

/// Constant parameters of all looks.
#[derive(Clone, Debug)]
pub(crate) struct LookParameters {
    pub(crate) settings: CheckedSensor,
    pub(crate) seed: u64,
    pub(crate) source: u16,
    pub(crate) start_utc_ns: i64,
}

impl LookParameters {
    pub(crate) fn watched(&self, thing: u64) -> SensorTarget {
        let mut random = stream(self.seed, Purpose::Acquaintance, self.source, thing, 0);
        SensorTarget {
            phase: random.random_range(0.0..1.0),
            equipped: random.random_bool(self.settings.equipped_share),
            latest_look_s: f64::NEG_INFINITY,
            track: None,
        }
    }

    /// Looks at a thing if its time lies in this slot, and reports its track, if any; returns the time and the
    /// detection.
    pub(crate) fn look(
        &self,
        slot: &Slot,
        thing: u64,
        watched: &mut SensorTarget,
        see: impl Fn(f64) -> VisibleTarget,
        told: &mut Told<'_>,
    ) -> Option<(f64, Option<SimulatedMeasurement>)> {
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

    pub(crate) fn plot(&self, slot: &Slot, time_s: f64, of: Of, found: &SimulatedMeasurement) -> RadarPlot {
        let (settings, scan) = (&self.settings, slot.period(&self.settings).0);
        let site_m = settings.coverage.position_m;
        RadarPlot::new((self.utc_ns(time_s), scan), of, found, site_m, &settings.errors)
    }

    /// The plot of a target, with the transponder's reply.
    pub(crate) fn replied_plot(
        &self,
        slot: &Slot,
        time_s: f64,
        of: Of,
        (found, state): (&SimulatedMeasurement, &TargetState),
    ) -> RadarPlot {
        let plot = self.plot(slot, time_s, of, found);
        if !self.settings.replies.are_received() || !matches!(of, Of::Target(_)) {
            return plot;
        }
        let height_m = state.height_m + found.position_m[2] - state.position_m[2];
        RadarPlot {
            identity: self.reply(slot, state),
            level: found.height.then_some(height_m).and_then(level_of),
            ..plot
        }
    }

    fn utc_ns(&self, time_s: f64) -> i64 {
        self.start_utc_ns + (time_s * messages::NS_PER_S).round() as i64
    }

    /// Whether a look at this time could detect the thing.
    pub(crate) fn may_find(
        &self,
        thing: u64,
        equipped: bool,
        time_s: f64,
        (position_m, height_m): ([f64; 3], f64),
    ) -> bool {
        equipped && self.settings.coverage.contains(position_m, height_m) && !self.dropped_out(thing, time_s)
    }

    pub(crate) fn find(
        &self,
        slot: &Slot,
        thing: u64,
        equipped: bool,
        time_s: f64,
        seen: &VisibleTarget,
    ) -> Option<SimulatedMeasurement> {
        if !self.may_find(thing, equipped, time_s, (seen.position_m, seen.height_m)) {
            return None;
        }
        let mut random = stream(self.seed, Purpose::Look, self.source, thing, slot.number);
        if !random.random_bool(seen.detection_probability) {
            return None;
        }
        let site = self.settings.coverage.position_m;
        Some(self.settings.errors.measure(site, seen.position_m, &mut random))
    }

    /// Whether the thing is in a dropout: one per stretch of time, anywhere in the stretch.
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

    fn report(
        &self,
        track: &LocalTrack,
        time_s: f64,
        seen: &VisibleTarget,
        found: Option<&SimulatedMeasurement>,
    ) -> SensorTrack {
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

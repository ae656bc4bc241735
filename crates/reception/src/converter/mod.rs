//! An observation into a sensor track of the pipeline, or into a detection, checked.

mod detecting;

use estimation::SourceClock;
use frames::SensorFrame;
use frames::time::DayUnroller;
use messages::{
    Counter, Counters, Covariance, SensorTrack, StageTimes, TrackState, UNKNOWN_VELOCITY_SIGMA_MPS, level_of,
    pressure_correction_m, sensor_track_bits as bits,
};
use rustc_hash::FxHashMap;

use super::accuracy::{self, UNKNOWN_POSITION_SIGMA_M, Velocity};
use super::placing::{Height, RefusedPlace, SystemPosition, place};
use super::plausibility::{TimeCheck, TrackMemory};
use super::truncated_time::complete;
use super::{ConversionModel, Method, PositionForm};
use observations::{Axes, Observation, Position};

/// A track's last height is used for so long where its reports have none, nanoseconds.
const HEIGHT_AGE_MAX_NS: i64 = 30_000_000_000;
/// Fastest climb or descent of an airliner, metres per second.
const CLIMB_MAX_MPS: f64 = 20.0;
const NS_PER_MS: i64 = 1_000_000;
/// Tracks silent for this long are forgotten when room is needed, nanoseconds.
const FORGET_NS: i64 = 120_000_000_000;

/// Time of measurement of a report, UTC.
#[derive(Clone, Copy, Debug)]
struct Stamp {
    time_ns: i64,
    /// Whether it can be; else the source's clock is wild.
    is_believed: bool,
}

impl Stamp {
    /// The time, if it is believed.
    fn believed(self) -> Result<i64, Counter> {
        self.is_believed.then_some(self.time_ns).ok_or(Counter::RejectedTime)
    }
}

/// Converter from a source's observations to sensor tracks; counts rejected observations.
#[derive(Debug)]
pub struct Converter {
    model: ConversionModel,
    day: Option<DayUnroller>,
    first_day_ns: i64,
    /// Time of receipt of the present observation, UTC and by a steady clock, nanoseconds; `None` for recordings.
    received_ns: Option<(i64, i64)>,
    /// The source's clock against times of receipt.
    clock: SourceClock,
    time_check: TimeCheck,
    /// Sender of the latest report; also holds for later reports without a sender.
    sender: Option<(u8, u8)>,
    altitude_correction_m: f64,
    tracks: FxHashMap<u32, TrackMemory>,
    counters: Counters,
    refused_place: Option<RefusedPlace>,
}

impl Converter {
    /// Returns a converter for a source with a first report on the day that begins at `first_day_ns` (UTC,
    /// nanoseconds).
    pub fn new(model: ConversionModel, first_day_ns: i64) -> Self {
        Self {
            model,
            day: None,
            first_day_ns,
            received_ns: None,
            clock: SourceClock::new(model.limits.clock_step().s()),
            time_check: TimeCheck::new(),
            sender: None,
            altitude_correction_m: pressure_correction_m(model.qnh_hpa),
            tracks: FxHashMap::default(),
            counters: Counters::default(),
            refused_place: None,
        }
    }

    /// Sets the time of receipt of the next reports, nanoseconds: `utc_ns` by the machine's UTC, `steady_ns` by a UTC
    /// that is not adjusted while the process runs. A time of day belongs to the day that brings it nearest to
    /// `utc_ns`. Jumps relative to `steady_ns` make a time invalid; a constant offset does not: fusion compares the
    /// offset with other sources' ([`Self::clock`]). A recording has no times of receipt; the source's running time
    /// serves instead.
    pub fn received(&mut self, utc_ns: i64, steady_ns: i64) {
        self.received_ns = Some((utc_ns, steady_ns));
    }

    /// Returns the state of the source's clock, as estimated from times of receipt.
    pub fn clock(&self) -> &SourceClock {
        &self.clock
    }

    /// Everything that has been counted, indexed by [`Counter`].
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Takes the latest position that was refused, if one was since the last call.
    pub fn take_refused_place(&mut self) -> Option<RefusedPlace> {
        self.refused_place.take()
    }

    /// Places the position of a report; remembers one that is refused.
    fn placed(&mut self, position: Position, height: Height) -> Result<SystemPosition, Counter> {
        place(&self.model, position, height).inspect_err(|_| {
            self.refused_place = Some(RefusedPlace::of(&self.model, position));
        })
    }

    /// The source's running time, UTC, nanoseconds; `None` before its first stamp.
    pub fn running_ns(&self) -> Option<i64> {
        self.day.as_ref().map(DayUnroller::running_ns)
    }

    /// Processes a record without a target report, with its time of day; returns the record's UTC (nanoseconds), if
    /// valid.
    pub fn service(&mut self, time_of_day_ns: Option<i64>) -> Option<i64> {
        self.count(Counter::ServiceMessages);
        self.utc(time_of_day_ns?).and_then(Stamp::believed).ok()
    }

    /// Converts `observation` to a sensor track; `None` if rejected. A report with an invalid time is marked and
    /// counted as rejected: it serves only to estimate the clock's error.
    pub fn convert(&mut self, observation: &Observation, ingested_ns: i64) -> Option<SensorTrack> {
        match self.try_convert(observation, ingested_ns) {
            Ok(track) => {
                self.count(if track.has(bits::WILD_CLOCK) {
                    Counter::RejectedTime
                } else if track.state == TrackState::Terminated as u8 {
                    Counter::TracksEnded
                } else {
                    Counter::Reports
                });
                Some(track)
            }
            Err(reason) => {
                self.count(reason);
                None
            }
        }
    }

    fn count(&mut self, counter: Counter) {
        self.counters[counter] += 1;
    }

    fn try_convert(&mut self, observation: &Observation, ingested_ns: i64) -> Result<SensorTrack, Counter> {
        let Stamp { time_ns, is_believed } = self.pass(observation)?;
        let number = observation.track_number.ok_or(Counter::RejectedNoTrackNumber)?;
        let height = self.height(observation, number, time_ns);
        let Some(used) = self.position(observation) else {
            return match observation.state {
                TrackState::Terminated if is_believed => self.end(number, time_ns, ingested_ns),
                _ => Err(Counter::RejectedNoPosition),
            };
        };
        let placed = self.placed(used, height)?;
        let delivered = self.velocity(observation, &placed)?;
        let own = accuracy::own_position(&self.model, observation, used)?;
        let velocity = if is_believed {
            self.remember(number, time_ns, &placed, height, delivered)?
        } else {
            delivered
        };
        if placed.slant.is_some_and(|slant| slant.is_assumed()) {
            self.count(Counter::HeightAssumed);
        }
        let mut track = self.blank(number, time_ns, ingested_ns);
        track.position_m = placed.position_m;
        let known = (height.is_known(), observation.vertical_rate_mps.is_some());
        track.covariance = accuracy::covariance(&self.model, &placed, own, known, velocity);
        let stated = self.level(observation, number, time_ns, is_believed);
        let mut set = |condition: bool, bit: u16| track.valid |= if condition { bit } else { 0 };
        set(!is_believed, bits::WILD_CLOCK);
        set(height.is_known(), bits::HEIGHT);
        set(velocity != Velocity::Unknown, bits::VELOCITY);
        set(matches!(velocity, Velocity::Derived(_)), bits::DERIVED_VELOCITY);
        set(own.is_some(), bits::OWN_COVARIANCE);
        set(stated.is_some(), bits::LEVEL);
        if let Some((level_ns, level)) = stated {
            track.level = level;
            track.level_age_ms = ((time_ns - level_ns) / NS_PER_MS).clamp(0, i64::from(u32::MAX)) as u32;
        }
        let [vx, vy] = velocity.value_mps();
        track.velocity_mps = [vx, vy, observation.vertical_rate_mps.unwrap_or_default()];
        if let Some(measured_m) = self.measured(observation, used, height) {
            track.measured_m = measured_m;
            track.valid |= bits::MEASURED;
        }
        if let Some(offset_m) = self.pressure_offset_m(observation) {
            track.pressure_offset_m = offset_m as f32;
            track.valid |= bits::PRESSURE_OFFSET;
        }
        describe(&mut track, observation);
        track.alerts = self.alerts(observation, number, time_ns, is_believed);
        Ok(track)
    }

    /// UTC of a report of a target, from a sender that is wanted.
    fn pass(&mut self, observation: &Observation) -> Result<Stamp, Counter> {
        self.admit(observation)?;
        let stamp = self.time(observation)?;
        if observation.field_monitor {
            return Err(Counter::RejectedFieldMonitor);
        }
        if observation.test {
            return Err(Counter::RejectedTestTarget);
        }
        Ok(stamp)
    }

    /// Whether the sender is wanted.
    fn admit(&mut self, observation: &Observation) -> Result<(), Counter> {
        self.sender = observation.sac_sic.or(self.sender);
        if self.model.sac_sic.is_some() && self.sender != self.model.sac_sic {
            return Err(Counter::RejectedSource);
        }
        // A track coasted by the radar keeps the method of its last detection.
        let is_known = |number: &u32| self.tracks.contains_key(number);
        let is_meant = match (self.model.method, observation.secondary) {
            (Method::Any, _) => true,
            (method, None) => method.admits(None) && observation.track_number.as_ref().is_some_and(is_known),
            (method, secondary) => method.admits(secondary),
        };
        if is_meant { Ok(()) } else { Err(Counter::RejectedSource) }
    }

    /// UTC of the measurement, checked.
    fn time(&mut self, observation: &Observation) -> Result<Stamp, Counter> {
        let near_ns = self.received_ns.map(|(utc_ns, _)| utc_ns).or(self.running_ns());
        let completed = || Some(complete(observation.truncated_time_ns?, near_ns?));
        let time_of_day_ns = observation.time_of_day_ns.or_else(completed);
        self.utc(time_of_day_ns.ok_or(Counter::RejectedTime)?)
    }

    /// UTC of a time of day, checked against the time of receipt, else against the source's running time. Some radars
    /// count on past midnight in reports that they predict.
    fn utc(&mut self, stated_ns: i64) -> Result<Stamp, Counter> {
        if stated_ns < 0 {
            return Err(Counter::RejectedTime);
        }
        let time_of_day_ns = stated_ns % frames::time::NS_PER_DAY;
        if let Some((received_ns, steady_ns)) = self.received_ns {
            let time_ns = DayUnroller::near(received_ns).utc_ns(time_of_day_ns);
            let is_believed = self.clock.believes(time_ns, steady_ns, None);
            if is_believed {
                self.day
                    .get_or_insert_with(|| DayUnroller::near(time_ns))
                    .advance(time_ns);
            }
            return Ok(Stamp { time_ns, is_believed });
        }
        let first_ns = self.first_day_ns + stated_ns;
        let day = self.day.get_or_insert_with(|| DayUnroller::near(first_ns));
        let utc_ns = day.utc_ns(time_of_day_ns);
        self.time_check.check(&self.model.limits, day.running_ns(), utc_ns)?;
        day.advance(utc_ns);
        Ok(Stamp {
            time_ns: utc_ns,
            is_believed: true,
        })
    }

    /// The height: by the pressure first, which all sources have in common.
    fn height(&mut self, observation: &Observation, number: u32, time_ns: i64) -> Height {
        if let Some(height_m) = self.reported_height(observation) {
            return Height::Known(height_m);
        }
        let last = self.tracks.get(&number).and_then(|memory| memory.last_height);
        match last {
            Some((last_ns, height_m)) if (0..=HEIGHT_AGE_MAX_NS).contains(&(time_ns - last_ns)) => {
                let age_s = (time_ns - last_ns) as f64 / messages::NS_PER_S;
                Height::Remembered {
                    height_m,
                    off_m: CLIMB_MAX_MPS * age_s,
                }
            }
            _ => Height::Unknown,
        }
    }

    /// The height that the report has, if it can be.
    fn reported_height(&mut self, observation: &Observation) -> Option<f64> {
        let by_pressure = observation
            .pressure_altitude_m
            .map(|altitude_m| altitude_m + self.altitude_correction_m);
        let limits = &self.model.limits;
        let height_m = by_pressure.or(observation.geometric_height_m)?;
        let possible = (limits.height_min_m..=limits.height_max_m).contains(&height_m);
        if !possible {
            self.count(Counter::RejectedHeight);
        }
        possible.then_some(height_m)
    }

    /// The height by pressure less the height above the ellipsoid, if the report states both.
    fn pressure_offset_m(&self, observation: &Observation) -> Option<f64> {
        let limits = self.model.limits.height_min_m..=self.model.limits.height_max_m;
        let by_pressure_m = observation.pressure_altitude_m? + self.altitude_correction_m;
        let height_m = observation.ellipsoid_height_m?;
        [by_pressure_m, height_m]
            .iter()
            .all(|height_m| limits.contains(height_m))
            .then_some(by_pressure_m - height_m)
    }

    /// Returns the time (UTC, nanoseconds) and the level of the transponder's latest statement. A report without a
    /// level leaves the earlier level with its age.
    fn level(&mut self, observation: &Observation, number: u32, time_ns: i64, is_believed: bool) -> Option<(i64, i16)> {
        let limits = &self.model.limits;
        let possible = limits.height_min_m..=limits.height_max_m;
        let stated = observation
            .transponder_altitude()
            .filter(|(altitude_m, _)| possible.contains(&(altitude_m + self.altitude_correction_m)))
            .and_then(|(altitude_m, age_ns)| Some((time_ns - age_ns, level_of(altitude_m)?)));
        let Some(memory) = self.tracks.get_mut(&number).filter(|_| is_believed) else {
            return stated;
        };
        let fits = |(level_ns, _): &(i64, i16)| (0..=HEIGHT_AGE_MAX_NS).contains(&(time_ns - level_ns));
        let newest = [memory.last_level, stated].into_iter().flatten().filter(fits);
        memory.last_level = newest.max_by_key(|(level_ns, _)| *level_ns);
        memory.last_level
    }

    /// The track's alerts. A report without a believed time states only its own.
    fn alerts(&mut self, observation: &Observation, number: u32, time_ns: i64, is_believed: bool) -> u8 {
        let Some(memory) = self.tracks.get_mut(&number).filter(|_| is_believed) else {
            return observation.alerts.raised;
        };
        let standing = memory
            .alerts
            .take(time_ns, observation.alerts, observation.identity.mode_3a());
        if standing.got_stuck {
            self.count(Counter::AdvisoriesStuck);
        }
        standing.bits
    }

    /// The position that is used; `None` if the report has none in a form that may be used.
    fn position(&self, observation: &Observation) -> Option<Position> {
        match self.model.positions {
            PositionForm::Any => observation.position(),
            PositionForm::Cartesian => Some(Position::Cartesian(observation.cartesian?, observation.plane)),
            PositionForm::Polar => observation.polar_position(),
        }
    }

    /// The velocity that the source delivers, in the system frame, and checked.
    fn velocity(&self, observation: &Observation, placed: &SystemPosition) -> Result<Velocity, Counter> {
        let Some(velocity) = observation.velocity else {
            return Ok(Velocity::Unknown);
        };
        let system = &self.model.system;
        let axes = match observation.axes {
            Axes::Sensor => self.model.frame,
            Axes::Target => SensorFrame::new(system, system.to_geodetic(placed.position_m), 0.0),
        };
        let [vx, vy] = axes.velocity(velocity);
        // Written so that NaN is refused.
        if (0.0..=self.model.limits.speed_mps).contains(&vx.hypot(vy)) {
            let own = accuracy::own_velocity(&self.model, observation, &axes);
            // The velocity of a track still tentative in the source's tracker is a guess.
            let guess = || (observation.state == TrackState::Tentative).then_some(accuracy::UNKNOWN_VELOCITY);
            Ok(Velocity::Delivered([vx, vy], own.or_else(guess)))
        } else {
            Err(Counter::RejectedSpeed)
        }
    }

    /// Remembers where the track is, if it can be there; gives the velocity, derived where none was delivered.
    fn remember(
        &mut self,
        number: u32,
        time_ns: i64,
        placed: &SystemPosition,
        height: Height,
        delivered: Velocity,
    ) -> Result<Velocity, Counter> {
        self.make_room(number, time_ns)?;
        let memory = self.tracks.entry(number).or_default();
        let [x, y, _] = placed.position_m;
        if !memory.accepts(&self.model.limits, time_ns, [x, y]) {
            return Err(Counter::RejectedJump);
        }
        memory.last_position_m = placed.position_m;
        if let Height::Known(height_m) = height {
            memory.last_height = Some((time_ns, height_m));
        }
        Ok(match delivered {
            Velocity::Unknown => memory.positions.velocity().map_or(Velocity::Unknown, Velocity::Derived),
            delivered => delivered,
        })
    }

    /// Measured position, where the position used is that of the sensor's track.
    fn measured(&self, observation: &Observation, used: Position, height: Height) -> Option<[f64; 3]> {
        // Without detection there may be a range and an azimuth, but they are extrapolated.
        if !matches!(used, Position::Cartesian(..)) || observation.state == TrackState::Coasted {
            return None;
        }
        let measured = place(&self.model, observation.polar_position()?, height);
        measured.ok().map(|placed| placed.position_m)
    }

    /// Sees to it that the track `number` can be remembered.
    fn make_room(&mut self, number: u32, time_ns: i64) -> Result<(), Counter> {
        if self.tracks.len() < self.model.limits.tracks || self.tracks.contains_key(&number) {
            return Ok(());
        }
        let recent = |memory: &TrackMemory| {
            memory
                .positions
                .newest()
                .is_some_and(|(last_ns, _)| time_ns - last_ns < FORGET_NS)
        };
        self.tracks.retain(|_, memory| recent(memory));
        if self.tracks.len() < self.model.limits.tracks {
            Ok(())
        } else {
            Err(Counter::TracksDropped)
        }
    }

    /// Terminates a track at the source's request, without a position.
    fn end(&mut self, number: u32, time_ns: i64, ingested_ns: i64) -> Result<SensorTrack, Counter> {
        let memory = self.tracks.remove(&number).ok_or(Counter::RejectedNoPosition)?;
        let mut track = self.blank(number, time_ns, ingested_ns);
        track.position_m = memory.last_position_m;
        track.state = TrackState::Terminated as u8;
        track.covariance = Covariance::diagonal([UNKNOWN_POSITION_SIGMA_M; 3], [UNKNOWN_VELOCITY_SIGMA_MPS; 3]);
        Ok(track)
    }

    fn blank(&self, number: u32, time_ns: i64, ingested_ns: i64) -> SensorTrack {
        SensorTrack {
            time_of_measurement_ns: time_ns,
            stages: StageTimes {
                ingested_ns,
                ..StageTimes::default()
            },
            track_number: number,
            source: self.model.number,
            ..SensorTrack::default()
        }
    }
}

/// Copies the items that need no conversion.
fn describe(track: &mut SensorTrack, observation: &Observation) {
    track.identity = observation.identity;
    track.state = observation.state as u8;
    if observation.vertical_rate_mps.is_some() {
        track.valid |= bits::VERTICAL_RATE;
    }
    if observation.on_ground {
        track.valid |= bits::ON_GROUND;
    }
}

#[cfg(test)]
mod tests;

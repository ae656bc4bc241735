//! Simulated receivers of AIS: the messages that the ships of the scenario send, and which receivers hear them.
//!
//! A ship reports its position in intervals that its class, its speed and its turns decide (ITU-R M.1371-5, annex 1,
//! tables 1 and 2), and its static data every six minutes. Its receiver of satellites gives a place at each full second
//! of UTC; the report of that second is sent within it. The message is the same for every receiver in range, and each
//! misses it with its own probability: slots collide.
//!
//! Ships of high accuracy keep 10 m at 95 %, others 30 m. These errors of satellite positioning are new in each report,
//! or change slowly (`error_time_s`): the error of an axis is then interpolated between normal numbers, such that its
//! deviation is the same at all times. Errors of speed and course are those that ships' receivers may have (IEC
//! 61108-1), and are new in each report.
//!
//! Limits: all ships are under way; times of arrival, rates of turn and the radio's state are not simulated.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use messages::Callsign;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use settings::{SettingsError, within};

use crate::random::{Purpose, stream};
use crate::target::{TargetKind, TargetState};
use crate::truth::Truth;

const KT_MPS: f64 = 1852.0 / 3600.0;
const NS_PER_S: i64 = 1_000_000_000;
/// Most receivers of a source.
const STATIONS_MAX: usize = 64;
/// Time from the second of a position to the delivery of its report, seconds.
const DELAY_S: f64 = 0.5;
/// Interval of static data, seconds.
const STATIC_INTERVAL_S: f64 = 360.0;
/// Radius that holds 95 % of the places, metres: of ships of low and high accuracy.
const RADIUS95_M: [f64; 2] = [30.0, 10.0];
/// Ratio of this radius to the standard deviation of an axis.
const RADIUS95_SIGMAS: f64 = 2.447_746_8;
/// Half the interval that holds 95 % of a normal distribution, in standard deviations.
const INTERVAL95_SIGMAS: f64 = 1.959_964;
/// Time over which a ship compares its course with the one before, seconds, and the difference that is a turn.
const TURN_S: f64 = 30.0;
const TURN_RAD: f64 = 5.0 * PI / 180.0;
/// Number of the first ship: one of Japan.
const MMSI_FROM: u32 = 431_000_000;
/// Names, which the number of the ship follows.
const NAMES: [&str; 6] = ["ASAHI", "HAYATE", "HOKUTO", "MIZUHO", "SUISEI", "TSURUGI"];

settings::settings! {
    /// Simulated receivers of AIS, whose lines come as one feed.
    pub struct AisSettings {
        check AisSettings::check;
        /// Places of the receivers: east, north, up. A message that several of them hear comes as often, and counts
        /// once.
        stations_m: Vec<[f64; 3]> = vec![[0.0; 3]];
        /// Greatest distance of a ship from a receiver in the plane.
        range_max_m: f64 = 60_000.0, in [1, 1e6];
        /// Probability that a receiver in range hears a message.
        detection_probability: f64 = 0.9, in [1e-3, 1];
        /// Share of the ships that have AIS.
        equipped_share: f64 = 1.0, in [0, 1];
        /// Share of them that are small and have class B.
        class_b_share: f64 = 0.2, in [0, 1];
        /// Share of them that state the high accuracy.
        accurate_share: f64 = 0.5, in [0, 1];
        /// Time in which the errors of positions change; 0: from report to report.
        error_time_s: f64 = 0.0, in [0, 1e5];
    }
}

impl AisSettings {
    fn check(&self) -> Result<(), SettingsError> {
        within("stations_m", self.stations_m.len() as f64, 1.0, STATIONS_MAX as f64)?;
        let mut places = self.stations_m.iter().flatten();
        places.try_for_each(|place| within("stations_m", *place, -1e7, 1e7))
    }
}

/// What a ship states about itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AisShip {
    /// Number of the target.
    pub id: u32,
    /// Number of the station (MMSI).
    pub mmsi: u32,
    /// Whether its equipment is of class B.
    pub is_class_b: bool,
    /// Whether it states the high accuracy.
    pub is_accurate: bool,
    /// Word of its name, before its number.
    pub name: &'static str,
    /// Call sign, padded with blanks.
    pub callsign: Callsign,
    /// Type of ship and cargo.
    pub ship_type: u8,
    /// Distances from the antenna to bow, stern, port and starboard, metres.
    pub distances_m: [u16; 4],
}

/// Report of a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AisReport {
    /// Measured place of the antenna: east, north, up, metres.
    pub position_m: [f64; 3],
    /// Measured velocity, towards east and north, metres per second.
    pub velocity_mps: [f64; 2],
    /// Heading, radians clockwise from the frame's north; `None` without a compass.
    pub heading_rad: Option<f64>,
}

/// A message, as a receiver hears it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AisMessage {
    /// Receiver, from 0.
    pub station: usize,
    /// Whether the second channel had it.
    pub is_on_channel_b: bool,
    /// Sender.
    pub ship: AisShip,
    /// Position; `None` of static data.
    pub report: Option<AisReport>,
}

/// Simulated receivers, see the module's documentation.
#[derive(Clone, Debug)]
pub struct SimulatedAis {
    settings: AisSettings,
    seed: u64,
    source: u16,
    start_utc_ns: i64,
    /// Full second of UTC whose messages come next.
    second: i64,
}

impl SimulatedAis {
    /// Creates receivers that begin at the scenario's start `start_utc_ns` (UTC, nanoseconds since 1970), as source
    /// number `source`. The ships of a seed are the same for all sources.
    ///
    /// # Errors
    /// An invalid setting.
    pub fn new(settings: &AisSettings, seed: u64, source: u16, start_utc_ns: i64) -> Result<Self, SettingsError> {
        settings::check(settings)?;
        Ok(Self {
            settings: settings.clone(),
            seed,
            source,
            start_utc_ns,
            second: start_utc_ns.div_euclid(NS_PER_S) + i64::from(start_utc_ns % NS_PER_S != 0),
        })
    }

    /// Continues with the first delivery at or after `time_s` seconds from the scenario's start.
    pub fn restart_at(&mut self, time_s: f64) {
        let since_1970_s = self.start_utc_ns as f64 / NS_PER_S as f64;
        self.second = self.second.max((since_1970_s + time_s - DELAY_S).ceil() as i64);
    }

    /// Time of the next positions, seconds from the scenario's start.
    pub fn measured_s(&self) -> f64 {
        (self.second * NS_PER_S - self.start_utc_ns) as f64 / NS_PER_S as f64
    }

    /// The same, seconds since 1970 (UTC).
    pub fn second(&self) -> i64 {
        self.second
    }

    /// Time of the next delivery, seconds from the scenario's start.
    pub fn next_delivery_s(&self) -> f64 {
        self.measured_s() + DELAY_S
    }

    /// Whether a receiver may hear `target` at its present position.
    pub fn observes(&self, target: &TargetState) -> bool {
        let mut stations = 0..self.settings.stations_m.len();
        self.ship(target).is_some() && stations.any(|station| self.is_in_range(station, target))
    }

    /// Appends the messages of the next second, ship by ship, each as often as it is heard, and goes on by a second.
    pub fn hear(&mut self, truth: &Truth, out: &mut Vec<AisMessage>) {
        let time_s = self.measured_s();
        for index in 0..truth.len() {
            let target = truth.target_at(index, time_s);
            let Some(ship) = self.ship(&target) else { continue };
            let speed_kt = speed_mps(&target) / KT_MPS;
            let turned_rad = course_rad(&target) - course_rad(&truth.target_at(index, time_s - TURN_S));
            let is_turning = ((turned_rad + PI).rem_euclid(TAU) - PI).abs() > TURN_RAD;
            let mut phases = stream(self.seed, Purpose::Ship, 0, u64::from(target.id), 1);
            if self.sends(interval_s(ship.is_class_b, speed_kt, is_turning), &mut phases) {
                let report = self.report(&ship, &target);
                self.pass(&ship, &target, Some(report), out);
            }
            if self.sends(STATIC_INTERVAL_S, &mut phases) {
                self.pass(&ship, &target, None, out);
            }
        }
        self.second += 1;
    }

    /// Whether a message of this interval, of the next phase, is sent in the present second.
    fn sends(&self, interval_s: f64, phases: &mut ChaCha8Rng) -> bool {
        let phase: f64 = phases.random_range(0.0..1.0);
        let sent_before = |second: i64| (second as f64 / interval_s - phase).floor();
        sent_before(self.second) != sent_before(self.second + 1)
    }

    fn pass(&self, ship: &AisShip, target: &TargetState, report: Option<AisReport>, out: &mut Vec<AisMessage>) {
        let number = 2 * self.second as u64 + u64::from(report.is_some());
        let mut random = stream(self.seed, Purpose::Slot, self.source, u64::from(ship.id), number);
        let is_on_channel_b = random.random_bool(0.5);
        for station in 0..self.settings.stations_m.len() {
            let is_heard = random.random_bool(self.settings.detection_probability);
            if is_heard && self.is_in_range(station, target) {
                out.push(AisMessage {
                    station,
                    is_on_channel_b,
                    ship: *ship,
                    report,
                });
            }
        }
    }

    fn is_in_range(&self, station: usize, target: &TargetState) -> bool {
        let [east, north] = [0, 1].map(|axis| target.position_m[axis] - self.settings.stations_m[station][axis]);
        east.hypot(north) <= self.settings.range_max_m
    }

    /// The ship that a target is; `None` of others, and of ships without AIS.
    fn ship(&self, target: &TargetState) -> Option<AisShip> {
        if target.kind != TargetKind::Ship {
            return None;
        }
        let mut random = stream(self.seed, Purpose::Ship, 0, u64::from(target.id), 0);
        let mut draw = |share: f64| random.random_range(0.0..1.0) < share;
        let settings = &self.settings;
        let [is_equipped, is_class_b, is_accurate] =
            [settings.equipped_share, settings.class_b_share, settings.accurate_share].map(&mut draw);
        let name = NAMES[random.random_range(0..NAMES.len())];
        // Fishing, sailing, pleasure; passengers, cargo, tankers.
        let types = if is_class_b { [30, 36, 37] } else { [60, 70, 80] };
        let length_m: f64 = random.random_range(if is_class_b { 8.0..20.0 } else { 50.0..220.0 });
        let beam_m = length_m / if is_class_b { 3.0 } else { 7.0 };
        // Antennas are on bridges, which are aft.
        let bow_m = length_m * random.random_range(0.5..0.85);
        let port_m = beam_m * random.random_range(0.3..0.7);
        is_equipped.then(|| AisShip {
            id: target.id,
            // Addresses of targets are unique, and so are their last 18 bits.
            mmsi: MMSI_FROM + (target.address & 0x3_ffff),
            is_class_b,
            is_accurate,
            name,
            callsign: target.callsign,
            ship_type: types[random.random_range(0..types.len())],
            distances_m: [bow_m, length_m - bow_m, port_m, beam_m - port_m].map(|distance| distance.round() as u16),
        })
    }

    /// The report of a ship in the present second.
    fn report(&self, ship: &AisShip, target: &TargetState) -> AisReport {
        let heading_rad = course_rad(target);
        let (sine, cosine) = heading_rad.sin_cos();
        let [bow, stern, port, starboard] = ship.distances_m.map(f64::from);
        // From the hull's centre, which is the target's place, to the antenna.
        let [ahead, right] = [(stern - bow) / 2.0, (port - starboard) / 2.0];
        let offset_m = [ahead * sine + right * cosine, ahead * cosine - right * sine];
        let sigma_m = RADIUS95_M[usize::from(ship.is_accurate)] / RADIUS95_SIGMAS;
        let error = self.place_error(ship.id);
        let mut position_m = target.position_m;
        for axis in 0..2 {
            position_m[axis] += offset_m[axis] + sigma_m * error[axis];
        }
        let mut random = stream(self.seed, Purpose::Ship, 1, u64::from(ship.id), self.second as u64);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let speed = speed_mps(target);
        let [along_sigma, across_sigma] = velocity_sigmas_mps(speed);
        let (along, across) = (speed + along_sigma * normal(), across_sigma * normal());
        AisReport {
            position_m,
            velocity_mps: [along * sine + across * cosine, along * cosine - across * sine],
            heading_rad: (!ship.is_class_b).then_some(heading_rad),
        }
    }

    /// Error of a ship's place in the present second, standard deviations east and north. Sine and cosine keep the sum
    /// of the squares of the weights at 1.
    fn place_error(&self, ship: u32) -> [f64; 2] {
        let node = |number: i64| -> [f64; 2] {
            let mut random = stream(self.seed, Purpose::Ship, 2, u64::from(ship), number as u64);
            [0; 2].map(|_| StandardNormal.sample(&mut random))
        };
        if self.settings.error_time_s < 1.0 {
            return node(self.second);
        }
        let nodes = self.second as f64 / self.settings.error_time_s;
        let (sine, cosine) = (FRAC_PI_2 * nodes.fract()).sin_cos();
        let (before, after) = (node(nodes as i64), node(nodes as i64 + 1));
        [0, 1].map(|axis| cosine * before[axis] + sine * after[axis])
    }
}

/// Interval of position reports of ships under way, seconds.
fn interval_s(is_class_b: bool, speed_kt: f64, is_turning: bool) -> f64 {
    match (is_class_b, speed_kt, is_turning) {
        // Carrier sense.
        (true, ..=2.0, _) => 180.0,
        (true, ..) => 30.0,
        (false, ..=0.5, _) => 180.0,
        (false, ..=14.0, false) => 10.0,
        (false, ..=14.0, true) => 10.0 / 3.0,
        (false, ..=23.0, false) => 6.0,
        (false, ..) => 2.0,
    }
}

/// Standard deviations of a measured velocity along the course and across it, metres per second: 95 % within 0.2 kn or
/// 2 % of the speed, and within 3° (1° above 17 kn), but not less than 0.2 kn.
fn velocity_sigmas_mps(speed: f64) -> [f64; 2] {
    let least = 0.2 * KT_MPS;
    let course_deg: f64 = if speed > 17.0 * KT_MPS { 1.0 } else { 3.0 };
    [0.02 * speed, speed * course_deg.to_radians()].map(|limit| limit.max(least) / INTERVAL95_SIGMAS)
}

fn speed_mps(target: &TargetState) -> f64 {
    target.velocity_mps[0].hypot(target.velocity_mps[1])
}

fn course_rad(target: &TargetState) -> f64 {
    target.velocity_mps[0].atan2(target.velocity_mps[1])
}

#[cfg(test)]
#[path = "ais_tests.rs"]
mod tests;

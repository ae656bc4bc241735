//! Merger of the lines of an aircraft into observations.
//!
//! Under good reception, positions of an aircraft come twice a second, velocities as often but in separate lines, and
//! callsign and code every few seconds. The merger stores the latest of each per aircraft, and completes every
//! position with values that are still recent enough:
//!
//! - velocity, rate of climb, altitude and on-ground flag for 5 s: in this time an aircraft in a standard turn
//!   changes its heading by 15°, and a fast climbing aircraft its altitude by 100 m;
//! - callsign and code for a minute: both seldom change, and their lines may be missed.
//!
//! Values in the same line as the position are used as well. A surface position means that the aircraft is on the
//! ground; its altitude is ignored, because receivers fill in zero.
//!
//! Ages are differences of the lines' own times, so that a replayed recording gives the same result as the live feed.
//! Lines of an aircraft may be out of order by up to these ages. After a minute of silence, all stored values of an
//! aircraft are outdated, and another aircraft may take its place in the table. If all places are occupied by
//! aircraft received within the last minute, positions of further aircraft are rejected and counted.

use frames::time::{NS_PER_DAY, NS_PER_S};
use messages::{Callsign, Identity, TrackState, alert_bits};
use rustc_hash::FxHashMap;

use super::line::{LineRejection, SbsError, SbsLine, SbsMessage};
use observations::{Alerts, Axes, Observation};

/// Time for which velocity, rate of climb, altitude and on-ground flag are used after their line, nanoseconds.
pub const MOTION_AGE_MAX_NS: i64 = 5 * NS_PER_S;
/// Time for which a callsign is used after its line, nanoseconds.
pub const CALLSIGN_AGE_MAX_NS: i64 = 60 * NS_PER_S;
/// Time for which a Mode 3/A code is used after its line, nanoseconds.
pub const CODE_AGE_MAX_NS: i64 = 60 * NS_PER_S;
/// After this silence an aircraft may be forgotten, nanoseconds.
pub const SILENCE_MAX_NS: i64 = 60 * NS_PER_S;

/// Transmission of a position on the surface.
const SURFACE_POSITION: u8 = 2;
/// Transmission of a position in the air.
const AIRBORNE_POSITION: u8 = 3;

/// How to read a receiver's lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SbsSettings {
    /// How far the receiver's clock is ahead of UTC, minutes: 60 for a computer set to Central European Time.
    pub ahead_of_utc_min: i32,
    /// Most aircraft that are remembered.
    pub aircraft_max: usize,
}

impl Default for SbsSettings {
    /// UTC, and more aircraft than a receiver receives in a minute.
    fn default() -> Self {
        Self {
            ahead_of_utc_min: 0,
            aircraft_max: 4096,
        }
    }
}

/// Counts of lines. Each line is in exactly one of `messages`, `others` and `rejected`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SbsCounters {
    /// Lines with a transmission of an aircraft.
    pub messages: u64,
    /// Lines about the receiver's window.
    pub others: u64,
    /// Lines that were rejected, by [`LineRejection`].
    pub rejected: [u64; LineRejection::ALL.len()],
    /// Transmissions with a time in their line.
    pub timed: u64,
    /// Observations given.
    pub observations: u64,
    /// Messages that announce a position and hold none.
    pub without_position: u64,
    /// Messages of aircraft for which the table had no room.
    pub refused_aircraft: u64,
}

impl SbsCounters {
    /// Lines rejected for one reason.
    pub fn rejected(&self, reason: LineRejection) -> u64 {
        self.rejected[reason as usize]
    }
}

/// Puts the lines of each aircraft together.
#[derive(Debug)]
pub struct AircraftMerger {
    settings: SbsSettings,
    aircraft: FxHashMap<u32, AircraftValues>,
    counters: SbsCounters,
}

/// Latest values that one aircraft has sent.
#[derive(Clone, Copy, Debug, Default)]
struct AircraftValues {
    last_ns: i64,
    velocity: Option<Dated<[f64; 2]>>,
    vertical_rate: Option<Dated<f64>>,
    altitude: Option<Dated<f64>>,
    on_ground: Option<Dated<bool>>,
    callsign: Option<Dated<Callsign>>,
    code: Option<Dated<u16>>,
    alerts: Option<Dated<Alerts>>,
}

/// A value with the time of day of its line.
#[derive(Clone, Copy, Debug)]
struct Dated<T> {
    time_ns: i64,
    value: T,
}

impl AircraftMerger {
    /// Returns an empty merger with an allocated table.
    pub fn new(settings: SbsSettings) -> Self {
        let mut aircraft = FxHashMap::default();
        aircraft.reserve(settings.aircraft_max);
        Self {
            settings,
            aircraft,
            counters: SbsCounters::default(),
        }
    }

    /// Takes a line without its end, received at `received_utc_ns`; gives an observation if the line holds a position.
    /// The time of receipt is used where the line has no time.
    ///
    /// # Errors
    /// [`SbsError`] if the line was rejected. The rejection is already counted; a caller with published counters
    /// needs no further action.
    pub fn take<'a>(&mut self, line: &'a [u8], received_utc_ns: i64) -> Result<Option<Observation>, SbsError<'a>> {
        match SbsLine::parse(line) {
            Ok(SbsLine::Message(message)) => {
                self.counters.messages += 1;
                self.counters.timed += u64::from(message.stamped_ns().is_some());
                Ok(self.merge(&message, received_utc_ns))
            }
            Ok(SbsLine::Other(_)) => {
                self.counters.others += 1;
                Ok(None)
            }
            Err(error) => {
                self.counters.rejected[error.rejection as usize] += 1;
                Err(error)
            }
        }
    }

    /// Counts so far.
    pub fn counters(&self) -> &SbsCounters {
        &self.counters
    }

    fn merge(&mut self, message: &SbsMessage, received_utc_ns: i64) -> Option<Observation> {
        let time_ns = self.time_of_day_ns(message, received_utc_ns);
        if !self.has_room(message.address, time_ns) {
            self.counters.refused_aircraft += 1;
            return None;
        }
        let heard = self.aircraft.entry(message.address).or_default();
        heard.take(message, time_ns);
        if ![SURFACE_POSITION, AIRBORNE_POSITION].contains(&message.transmission) {
            return None;
        }
        let Some(position) = message.position_rad else {
            self.counters.without_position += 1;
            return None;
        };
        self.counters.observations += 1;
        Some(heard.observation(message, position, time_ns))
    }

    /// UTC time of day: of reception, else of writing, else of receipt here.
    fn time_of_day_ns(&self, message: &SbsMessage, received_utc_ns: i64) -> i64 {
        let ahead_ns = i64::from(self.settings.ahead_of_utc_min) * 60 * NS_PER_S;
        let utc_ns = message
            .stamped_ns()
            .map_or(received_utc_ns, |stamped_ns| stamped_ns - ahead_ns);
        utc_ns.rem_euclid(NS_PER_DAY)
    }

    /// Whether the aircraft is in the table, or can be; forgets silent ones if that is needed.
    fn has_room(&mut self, address: u32, time_ns: i64) -> bool {
        let most = self.settings.aircraft_max;
        if self.aircraft.len() < most || self.aircraft.contains_key(&address) {
            return true;
        }
        self.aircraft
            .retain(|_, heard| within(SILENCE_MAX_NS, time_ns, heard.last_ns));
        self.aircraft.len() < most
    }
}

impl AircraftValues {
    fn take(&mut self, message: &SbsMessage, time_ns: i64) {
        if !within(SILENCE_MAX_NS, time_ns, self.last_ns) {
            *self = Self::default();
            self.last_ns = time_ns;
        }
        if age_ns(time_ns, self.last_ns) > 0 {
            self.last_ns = time_ns;
        }
        let own = Own::of(message);
        put(&mut self.velocity, time_ns, own.velocity);
        put(&mut self.vertical_rate, time_ns, message.vertical_rate_mps);
        put(&mut self.altitude, time_ns, own.altitude);
        put(&mut self.on_ground, time_ns, own.on_ground);
        put(&mut self.callsign, time_ns, message.callsign);
        put(&mut self.code, time_ns, message.mode_3a);
        put(&mut self.alerts, time_ns, own.alerts);
    }

    /// Returns the message's position with the message's own values, completed with stored values.
    fn observation(&self, message: &SbsMessage, position: [f64; 2], time_ns: i64) -> Observation {
        let own = Own::of(message);
        let motion = MOTION_AGE_MAX_NS;
        let mut identity = Identity::default().with_address(message.address);
        let callsign = message.callsign.or(recent(self.callsign, time_ns, CALLSIGN_AGE_MAX_NS));
        if let Some(callsign) = callsign {
            identity = identity.with_callsign(callsign);
        }
        if let Some(code) = message.mode_3a.or(recent(self.code, time_ns, CODE_AGE_MAX_NS)) {
            identity = identity.with_mode_3a(code);
        }
        let altitude = own.altitude.or(recent(self.altitude, time_ns, motion));
        let on_ground = own.on_ground.or(recent(self.on_ground, time_ns, motion));
        let vertical_rate = recent(self.vertical_rate, time_ns, motion);
        Observation {
            time_of_day_ns: Some(time_ns),
            // An aircraft is its own track.
            track_number: Some(message.address),
            identity,
            geodetic: Some(position),
            velocity: own.velocity.or(recent(self.velocity, time_ns, motion)),
            axes: Axes::Target,
            alerts: own
                .alerts
                .or(recent(self.alerts, time_ns, CODE_AGE_MAX_NS))
                .unwrap_or_default(),
            pressure_altitude_m: altitude.filter(|_| message.transmission != SURFACE_POSITION),
            vertical_rate_mps: message.vertical_rate_mps.or(vertical_rate),
            on_ground: on_ground.unwrap_or(false),
            state: TrackState::Confirmed,
            ..Observation::default()
        }
    }
}

/// Consequences of a message beyond its own words.
struct Own {
    velocity: Option<[f64; 2]>,
    altitude: Option<f64>,
    on_ground: Option<bool>,
    /// Statement about alerts, if the message contains any.
    alerts: Option<Alerts>,
}

impl Own {
    fn of(message: &SbsMessage) -> Self {
        let surface = message.transmission == SURFACE_POSITION;
        let velocity = message.ground_speed_mps.zip(message.track_rad);
        Self {
            velocity: velocity.map(components),
            altitude: message.altitude_m.filter(|_| !surface),
            on_ground: if surface { Some(true) } else { message.on_ground },
            alerts: alerts(message),
        }
    }
}

fn alerts(message: &SbsMessage) -> Option<Alerts> {
    let flags = [
        (message.alert, alert_bits::TRANSPONDER_ALERT),
        (message.emergency, alert_bits::EMERGENCY),
        (message.identifies, alert_bits::SPECIAL_IDENTIFICATION),
    ];
    let said = flags
        .iter()
        .filter_map(|(flag, bit)| flag.map(|is_set| Alerts::flag(*bit, is_set)));
    said.reduce(|all, bit| all | bit)
}

/// Replaces an older value.
fn put<T>(place: &mut Option<Dated<T>>, time_ns: i64, value: Option<T>) {
    let newer = |dated: &Dated<T>| age_ns(time_ns, dated.time_ns) >= 0;
    if let Some(value) = value
        && place.as_ref().is_none_or(newer)
    {
        *place = Some(Dated { time_ns, value });
    }
}

fn recent<T>(dated: Option<Dated<T>>, time_ns: i64, age_max_ns: i64) -> Option<T> {
    let dated = dated.filter(|dated| within(age_max_ns, time_ns, dated.time_ns));
    dated.map(|dated| dated.value)
}

fn within(limit_ns: i64, time_ns: i64, other_ns: i64) -> bool {
    age_ns(time_ns, other_ns).abs() <= limit_ns
}

/// From one time of day to another, by the shorter way around midnight.
fn age_ns(time_ns: i64, other_ns: i64) -> i64 {
    (time_ns - other_ns + NS_PER_DAY / 2).rem_euclid(NS_PER_DAY) - NS_PER_DAY / 2
}

/// East and north.
fn components((speed, track): (f64, f64)) -> [f64; 2] {
    let (sine, cosine) = track.sin_cos();
    [speed * sine, speed * cosine]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The end of a line that holds a position.
    const PLACE: &str = "37000,,,51.5,-1.25,,,0,0,0,0";

    fn merger() -> AircraftMerger {
        AircraftMerger::new(SbsSettings {
            aircraft_max: 2,
            ..SbsSettings::default()
        })
    }

    /// Takes a line of an aircraft with a time of reception; the line continues with the callsign.
    fn take(merger: &mut AircraftMerger, kind: u8, address: &str, time: &str, rest: &str) -> Option<Observation> {
        let line = format!("MSG,{kind},1,1,{address},1,2026/01/02,{time},2026/01/02,23:00:00.000,{rest}");
        merger.take(line.as_bytes(), 0).unwrap()
    }

    fn seconds(observation: Observation) -> f64 {
        frames::time::seconds(observation.time_of_day_ns.unwrap())
    }

    #[test]
    fn a_position_takes_along_what_was_heard_before() {
        let mut merger = merger();
        let all = &mut merger;
        assert_eq!(take(all, 1, "3C1A2B", "12:00:00.000", "ABC12XY"), None);
        assert_eq!(take(all, 4, "3C1A2B", "12:00:08.000", ",,100,90,,,-600"), None);
        assert_eq!(take(all, 6, "3C1A2B", "12:00:09.000", ",36900,,,,,,4521,0,0,0,0"), None);
        let found = take(all, 3, "3C1A2B", "12:00:10.250", &format!(",{PLACE}")).unwrap();
        assert_eq!(seconds(found), 43_210.25);
        let identity = Identity::default()
            .with_address(0x3c_1a2b)
            .with_callsign(*b"ABC12XY ")
            .with_mode_3a(0o4521);
        assert_eq!((found.identity, found.track_number), (identity, Some(0x3c_1a2b)));
        assert_eq!(found.geodetic, Some([51.5f64.to_radians(), (-1.25f64).to_radians()]));
        let [east, north] = found.velocity.unwrap();
        assert!((east - 51.444_444).abs() < 1e-5 && north.abs() < 1e-9, "{east} {north}");
        assert!(
            (found.pressure_altitude_m.unwrap() - 11_277.6).abs() < 1e-9,
            "its own, not the older one"
        );
        assert!((found.vertical_rate_mps.unwrap() + 3.048).abs() < 1e-9);
        assert_eq!((found.state, found.on_ground), (TrackState::Confirmed, false));
        assert_eq!((all.counters().messages, all.counters().observations), (4, 1));
    }

    #[test]
    fn what_is_too_old_is_left_out() {
        let mut merger = merger();
        let all = &mut merger;
        take(all, 1, "3C1A2B", "12:00:00.000", "ABC12XY");
        take(all, 4, "3C1A2B", "12:00:00.000", ",,100,90,,,-600");
        take(all, 6, "3C1A2B", "12:00:00.000", ",36900,,,,,,4521,0,0,0,-1");
        let place = ",,,,51.5,-1.25";
        let found = take(all, 3, "3C1A2B", "12:00:05.000", place).unwrap();
        assert!(found.velocity.is_some() && found.vertical_rate_mps.is_some() && found.pressure_altitude_m.is_some());
        assert!(found.on_ground);
        let found = take(all, 3, "3C1A2B", "12:00:05.001", place).unwrap();
        assert_eq!(
            (found.velocity, found.vertical_rate_mps, found.pressure_altitude_m),
            (None, None, None)
        );
        assert!(!found.on_ground);
        let found = take(all, 3, "3C1A2B", "12:01:00.000", place).unwrap();
        assert!(found.identity.callsign().is_some() && found.identity.mode_3a().is_some());
        let found = take(all, 3, "3C1A2B", "12:01:00.001", place).unwrap();
        assert_eq!(found.identity, Identity::default().with_address(0x3c_1a2b));
    }

    #[test]
    fn ages_go_across_midnight_and_late_lines_do_not_win() {
        let mut merger = merger();
        let all = &mut merger;
        take(all, 4, "3C1A2B", "23:59:59.000", ",,100,0,,,0");
        take(all, 1, "3C1A2B", "00:00:01.000", "NEW");
        take(all, 1, "3C1A2B", "23:59:58.000", "OLD");
        let found = take(all, 3, "3C1A2B", "00:00:02.000", &format!(",{PLACE}")).unwrap();
        assert!(found.velocity.is_some());
        assert_eq!(found.identity.callsign(), Some("NEW"));
    }

    #[test]
    fn a_surface_position_is_on_the_ground_and_has_no_altitude() {
        let mut merger = merger();
        let all = &mut merger;
        take(all, 5, "3C1A2C", "12:00:00.000", ",1200,,,,,,,0,,0,0");
        let found = take(all, 2, "3C1A2C", "12:00:01.000", ",0,20,180,51.5,-1.25,,,,,,0").unwrap();
        assert_eq!((found.pressure_altitude_m, found.on_ground), (None, true));
        let [east, north] = found.velocity.unwrap();
        assert!(east.abs() < 1e-9 && (north + 10.288_888).abs() < 1e-5);
    }

    #[test]
    fn times_are_brought_to_utc_and_replaced_where_missing() {
        let mut merger = AircraftMerger::new(SbsSettings {
            ahead_of_utc_min: 120,
            ..SbsSettings::default()
        });
        let mut time = |received: &str, written: &str| {
            let line = format!("MSG,3,1,1,3C1A2B,1,2026/01/02,{received},2026/01/02,{written},,{PLACE}");
            let found = merger.take(line.as_bytes(), 5 * NS_PER_DAY + 42 * NS_PER_S).unwrap();
            seconds(found.unwrap())
        };
        assert_eq!(time("12:00:00.5", "13:00:00"), 36_000.5);
        assert_eq!(time("01:00:00", ""), 82_800.0, "the day before");
        assert_eq!(time("", "13:00:00"), 39_600.0);
        assert_eq!(time("", ""), 42.0, "the time of receipt is UTC already");
    }

    #[test]
    fn a_full_table_refuses_until_an_aircraft_has_been_silent() {
        let mut merger = merger();
        let all = &mut merger;
        let place = format!(",{PLACE}");
        assert!(take(all, 3, "000001", "12:00:00", &place).is_some());
        assert!(take(all, 3, "000002", "12:00:30", &place).is_some());
        assert_eq!(take(all, 3, "000003", "12:01:00", &place), None);
        assert_eq!(all.counters().refused_aircraft, 1);
        assert!(
            take(all, 3, "000002", "12:01:00", &place).is_some(),
            "who is known is served"
        );
        assert!(
            take(all, 3, "000003", "12:01:01", &place).is_some(),
            "the first is forgotten"
        );
        assert_eq!(take(all, 3, "000001", "12:01:01", &place), None);
        assert_eq!(all.aircraft.len(), 2);
    }

    #[test]
    fn every_line_is_counted_once() {
        let mut merger = merger();
        for line in [
            "MSG,3,1,1,3C1A2B,1,,,,",
            "AIR,,1",
            "MSG,3,1,1,XYZ,1,,,,",
            "MSG,0,1,1,3C1A2B,1,,,,",
            "noise",
            "",
        ] {
            let _ = merger.take(line.as_bytes(), 0);
        }
        let counters = merger.counters();
        assert_eq!(
            (counters.messages, counters.others, counters.without_position),
            (1, 1, 1)
        );
        assert_eq!(
            (
                counters.rejected(LineRejection::Address),
                counters.rejected(LineRejection::Transmission)
            ),
            (1, 1)
        );
        assert_eq!(counters.rejected(LineRejection::Kind), 2);
        assert_eq!(counters.rejected.iter().sum::<u64>(), 4);
    }

    proptest! {
        #[test]
        fn nothing_old_is_ever_used(
            lines in prop::collection::vec((1u8..9, 0u32..3, 0i64..200_000, any::<bool>()), 1..60),
        ) {
            let mut merger = merger();
            // By aircraft: when its velocity was sent.
            let mut velocities = vec![Vec::new(); 3];
            for (kind, address, ms, with_velocity) in lines {
                let time_ns = ms * 1_000_000;
                let clock = format!("00:{:02}:{:02}.{:03}", ms / 60_000, ms / 1000 % 60, ms % 1000);
                let velocity = if with_velocity { "100,90" } else { "," };
                let found = take(&mut merger, kind, &format!("00000{address}"), &clock, &format!(",,{velocity},51,1"));
                if with_velocity {
                    velocities[address as usize].push(time_ns);
                }
                let is_position = kind == 2 || kind == 3;
                prop_assert!(is_position || found.is_none());
                if let Some(found) = found {
                    let near = |sent_ns: &i64| (time_ns - sent_ns).abs() <= MOTION_AGE_MAX_NS;
                    prop_assert_eq!(found.time_of_day_ns, Some(time_ns));
                    prop_assert!(found.velocity.is_none() || velocities[address as usize].iter().any(near));
                    prop_assert!(found.velocity.is_some() || !with_velocity);
                }
            }
            prop_assert!(merger.aircraft.len() <= 2);
        }
    }
}

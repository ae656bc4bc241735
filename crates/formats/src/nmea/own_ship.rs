//! State of the ship that carries a radar, from its sentences between those of the targets.
//!
//! Place, heading and velocity come at different times, each of which may fail. A value serves for [`AGE_MAX_NS`]; the
//! place moves on with the velocity until the time of the target. Ages are differences of one clock: times of receipt,
//! where there are any, else the stated times.

use frames::Geodetic;
use frames::time::{DayUnroller, seconds};

use super::reader::{NmeaReader, NmeaSettings};
use super::sentence::NmeaFault;

/// Time for which a value serves after its sentence, nanoseconds. Sentences come every second; a ship turns through a
/// few degrees in some seconds.
const AGE_MAX_NS: i64 = 10_000_000_000;
/// Sentences that state something about own ship, without their talker.
const KINDS: [&str; 7] = ["GGA", "GLL", "RMC", "VTG", "HDT", "THS", "HDG"];

/// State of own ship, or of a station ashore.
#[derive(Debug)]
pub(super) struct OwnShip {
    reader: NmeaReader,
    /// Place of a radar ashore.
    ashore: Option<Geodetic>,
    fix: Option<Aged<Geodetic>>,
    heading_rad: Option<Aged<f64>>,
    velocity_mps: Option<Aged<[f64; 2]>>,
}

/// A value with its time.
#[derive(Clone, Copy, Debug)]
struct Aged<T> {
    value: T,
    /// Time by the clock of ages, nanoseconds.
    clock_ns: i64,
    /// Stated time, UTC, nanoseconds.
    time_ns: i64,
}

impl<T: Copy> Aged<T> {
    fn at(self, now_ns: i64) -> Option<T> {
        let is_recent = now_ns.abs_diff(self.clock_ns) <= AGE_MAX_NS.unsigned_abs();
        is_recent.then_some(self.value)
    }
}

impl OwnShip {
    /// Own ship, or a radar ashore at latitude and longitude `place_deg`, degrees.
    pub(super) fn new(place_deg: Option<[f64; 2]>) -> Self {
        Self {
            // Headings have no use but for their values.
            reader: NmeaReader::new(NmeaSettings {
                receipt_sigma_s: 0.0,
                heading_sigma_rad: 0.0,
            }),
            ashore: place_deg.and_then(|[latitude, longitude]| Geodetic::from_degrees(latitude, longitude, 0.0).ok()),
            fix: None,
            heading_rad: None,
            velocity_mps: None,
        }
    }

    /// Whether the sentence of this name may state something about own ship.
    pub(super) fn reads(name: &str) -> bool {
        name == "PASHR" || name.len() == 5 && name.get(2..).is_some_and(|kind| KINDS.contains(&kind))
    }

    /// Takes a sentence, received at `received_ns` if known; `latest_ns` is the latest time of any line before. Returns
    /// the time of the state, nanoseconds: UTC since 1970, or if no sentence has stated a date, counted from any
    /// midnight; `None` if nothing is used.
    pub(super) fn take(
        &mut self,
        sentence: &str,
        received_ns: Option<i64>,
        latest_ns: Option<i64>,
    ) -> Result<Option<i64>, NmeaFault> {
        // Without a date, the times of day are of any day. RMC states a date.
        let is_dated = sentence.get(3..6) == Some("RMC");
        let near_ns = received_ns.or((!is_dated && latest_ns.is_none()).then_some(0));
        let before = self.reader.counts();
        let mut state = None;
        self.reader
            .take(sentence.as_bytes(), near_ns, |found| state = Some(found));
        self.reader.end(near_ns, |found| state = Some(found));
        if self.reader.counts().refused() > before.refused() {
            let refused = self
                .reader
                .refused()
                .map_or(NmeaFault::NoSentence, |refused| refused.fault);
            return Err(refused);
        }
        let Some(state) = state else { return Ok(None) };
        let clock_ns = received_ns.unwrap_or(state.time_ns);
        let times_ns = [clock_ns, state.time_ns];
        renew(&mut self.fix, state.place, times_ns);
        renew(&mut self.heading_rad, state.heading_rad, times_ns);
        renew(&mut self.velocity_mps, state.velocity_mps, times_ns);
        Ok(Some(clock_ns))
    }

    /// The latest fix at `now_ns`, and the way since then until the time of day `time_of_day_ns` (without one, until
    /// now), metres towards east and north. A station ashore without a receiver stays where it is.
    pub(super) fn place(&self, now_ns: i64, time_of_day_ns: Option<i64>) -> Option<(Geodetic, [f64; 2])> {
        let Some(fix) = self.fix else {
            return self.ashore.map(|place| (place, [0.0; 2]));
        };
        let place = fix.at(now_ns)?;
        let stated_ns = time_of_day_ns
            .map(|time_ns| DayUnroller::near(fix.time_ns).utc_ns(time_ns) - fix.time_ns)
            .filter(|passed_ns| passed_ns.abs() <= AGE_MAX_NS);
        let passed_s = seconds(stated_ns.unwrap_or(now_ns - fix.clock_ns));
        let velocity_mps = self.velocity_mps(now_ns).unwrap_or_default();
        Some((place, velocity_mps.map(|speed| speed * passed_s)))
    }

    /// Direction of the bow at `now_ns`, radians clockwise from true north.
    pub(super) fn heading_rad(&self, now_ns: i64) -> Option<f64> {
        self.heading_rad?.at(now_ns)
    }

    /// Velocity over ground at `now_ns`, towards east and north, metres per second.
    pub(super) fn velocity_mps(&self, now_ns: i64) -> Option<[f64; 2]> {
        let is_ashore = self.fix.is_none() && self.ashore.is_some();
        let recent = self.velocity_mps.and_then(|velocity| velocity.at(now_ns));
        recent.or(is_ashore.then_some([0.0; 2]))
    }
}

/// Replaces a value by a new one, if there is one.
fn renew<T>(aged: &mut Option<Aged<T>>, value: Option<T>, [clock_ns, time_ns]: [i64; 2]) {
    if let Some(value) = value {
        *aged = Some(Aged {
            value,
            clock_ns,
            time_ns,
        });
    }
}

//! Lines with the targets of ships' radars into observations.
//!
//! TTM states a target in relation to the ship that carries the radar, and the ship's own state comes in other
//! sentences of the same lines ([`OwnShip`]). A position is the place of the radar, plus distance and bearing; a
//! relative bearing and course count from the bow, and a relative speed becomes one over ground by adding the ship's
//! own velocity. What a target needs of own ship and is missing makes a refusal with its remedy: a position by an
//! assumed heading would be a wrong one. TLL states latitude and longitude; beside TTM it is a repetition, computed
//! from it.
//!
//! # Times
//!
//! The time of a target is its own field (UTC), else that of its line or of its receipt, else that of the latest line
//! with a time. Files may state no date at all; then times of day count.
//!
//! # Accuracy
//!
//! No sentence states an accuracy. Radars on ships must measure range within 50 m or 1 %, and bearing within 2°, both
//! with a probability of 95 % (IMO, resolution MSC.192(79), 5.25.4.7); half of these are the standard deviations where
//! none are set. The covariance is that of range and bearing from where the ship was.
//!
//! # Limits
//!
//! The antenna is where the fix is: on a large ship, a hundred metres may lie between. A true speed may be one through
//! the water, as the radar's log measures; the sentence does not state which.

use std::hash::BuildHasher;

use frames::time::{DayUnroller, NS_PER_DAY};
use frames::{Geodetic, PolarSigma, SensorFrame, SystemFrame, polar_covariance};
use messages::TrackState;
use observations::{Axes, Observation, Quality};
use rustc_hash::FxBuildHasher;

use super::envelope::{Envelope, LINE_OCTETS_MAX};
use super::own_ship::OwnShip;
use super::radar_targets::{RadarPlace, RadarTarget, Reference, Referred};
use super::sentence::{NmeaFault, summed};
use super::target_counters::{RadarTargetCounters, RadarTargetError, RadarTargetRejection};
use super::target_numbers::{RadarKey, TargetNumbers};

/// Standard deviation of ranges of a radar that meets the performance standard: at least so many metres.
const RANGE_SIGMA_MIN_M: f64 = 25.0;
/// The same, per metre of range.
const RANGE_SIGMA_PER_M: f64 = 0.005;
/// Standard deviation of its bearings, degrees.
const BEARING_SIGMA_DEG: f64 = 1.0;
/// Times from here on have a date: nanoseconds since 1970, in the year 1973.
const DATED_NS: i64 = 100_000_000_000_000_000;

/// How to read the lines of radars.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RadarTargetSettings {
    /// Latitude and longitude of a radar ashore, degrees. A fix in the lines comes before it.
    pub place_deg: Option<[f64; 2]>,
    /// Accuracy of range and bearing; `None`: that of the performance standard.
    pub sigma: Option<PolarSigma>,
}

/// Reader of lines with the targets of one or several radars.
#[derive(Debug)]
pub struct RadarTargetReader {
    settings: RadarTargetSettings,
    own_ship: OwnShip,
    numbers: TargetNumbers,
    counters: RadarTargetCounters,
    /// Latest time that a line has stated around its sentence, UTC, nanoseconds: lines of a group need not repeat it.
    line_ns: Option<i64>,
    /// Time of the latest line, nanoseconds.
    latest_ns: Option<i64>,
}

/// Times of a line.
#[derive(Clone, Copy, Debug)]
struct LineTimes {
    /// Time of receipt, or the one that lines state, UTC, nanoseconds.
    received_ns: Option<i64>,
    /// Whether the data state the time.
    is_stated: bool,
}

impl RadarTargetReader {
    /// Returns a reader that has not read anything.
    pub fn new(settings: RadarTargetSettings) -> Self {
        Self {
            own_ship: OwnShip::new(settings.place_deg),
            settings,
            numbers: TargetNumbers::new(),
            counters: RadarTargetCounters::default(),
            line_ns: None,
            latest_ns: None,
        }
    }

    /// Counts so far.
    pub fn counters(&self) -> &RadarTargetCounters {
        &self.counters
    }

    /// Takes a line without its end, received at `received_utc_ns` (UTC, nanoseconds since 1970); `None` in a file
    /// without times of receipt. Gives the observation of a target.
    ///
    /// # Errors
    /// [`RadarTargetError`] if the line was refused. The refusal is already counted; a caller with published counters
    /// needs no further action.
    pub fn take<'a>(
        &mut self,
        line: &'a [u8],
        received_utc_ns: Option<i64>,
    ) -> Result<Option<Observation>, RadarTargetError<'a>> {
        self.take_line(line, received_utc_ns).map_err(|rejection| {
            self.counters.rejected[rejection as usize] += 1;
            RadarTargetError { rejection, line }
        })
    }

    fn take_line(&mut self, line: &[u8], receipt_ns: Option<i64>) -> Result<Option<Observation>, RadarTargetRejection> {
        let line = line.trim_ascii();
        if line.is_empty() || line.starts_with(b"#") || line.starts_with(b"//") {
            self.counters.others += 1;
            return Ok(None);
        }
        let text = std::str::from_utf8(line)
            .ok()
            .filter(|text| text.len() <= LINE_OCTETS_MAX);
        let text = text.ok_or(RadarTargetRejection::Text)?;
        // The last one: a sentence that was cut may stand before it.
        let start = text.rfind(['!', '$']).ok_or(RadarTargetRejection::NoSentence)?;
        let (before, text) = text.split_at(start);
        let name = text[1..].split([',', '*']).next().unwrap_or_default();
        let is_target = name.len() == 5 && matches!(name.get(2..), Some("TTM" | "TLL"));
        if text.starts_with('!') || !(is_target || OwnShip::reads(name)) {
            if text.starts_with('$') && summed(&text[1..]) == Err(NmeaFault::Checksum) {
                return Err(RadarTargetRejection::Checksum);
            }
            self.counters.others += 1;
            return Ok(None);
        }
        let sum_end = text.find('*').map_or(text.len(), |star| text.len().min(star + 3));
        let (sentence, behind) = text.split_at_checked(sum_end).unwrap_or((text, ""));
        let envelope = Envelope::of(before, behind);
        self.counters.wrong_tags += u64::from(envelope.has_wrong_tag);
        self.line_ns = envelope.received_ns.or(self.line_ns);
        let times = LineTimes {
            received_ns: envelope.received_ns.or(receipt_ns).or(self.line_ns),
            is_stated: envelope.received_ns.is_some() || receipt_ns.is_none(),
        };
        if is_target {
            let radar = FxBuildHasher.hash_one((name.get(..2), envelope.station));
            let target = RadarTarget::parse(sentence.as_bytes())?;
            return target.map_or(Ok(None), |target| self.target(radar, &target, times));
        }
        self.own(sentence, times.received_ns)
    }

    fn own(&mut self, sentence: &str, received_ns: Option<i64>) -> Result<Option<Observation>, RadarTargetRejection> {
        match self.own_ship.take(sentence, received_ns, self.latest_ns)? {
            Some(time_ns) => {
                self.counters.own += 1;
                self.note(time_ns);
            }
            None => self.counters.others += 1,
        }
        Ok(None)
    }

    fn note(&mut self, time_ns: i64) {
        self.latest_ns = Some(time_ns);
        let dated_ns = Some(time_ns).filter(|time_ns| *time_ns >= DATED_NS);
        self.counters.first_stated_ns = self.counters.first_stated_ns.or(dated_ns);
    }

    fn target(
        &mut self,
        radar: RadarKey,
        target: &RadarTarget,
        times: LineTimes,
    ) -> Result<Option<Observation>, RadarTargetRejection> {
        // A leap second is the first moment of the next day.
        let time_of_day_ns = target.time_of_day_ns.map(|time_ns| time_ns % NS_PER_DAY);
        let by_day = |time_ns: i64| DayUnroller::near(self.latest_ns.unwrap_or(time_ns)).utc_ns(time_ns);
        let now_ns = times.received_ns.or(time_of_day_ns.map(by_day)).or(self.latest_ns);
        let now_ns = now_ns.ok_or(RadarTargetRejection::NoTime)?;
        self.note(now_ns);
        let reported = Observation {
            time_of_day_ns: time_of_day_ns.or(Some(now_ns.rem_euclid(NS_PER_DAY))),
            secondary: Some(false),
            state: target.state,
            ..Observation::default()
        };
        let is_timed = u64::from(time_of_day_ns.is_some() || times.is_stated);
        if target.state == TrackState::Terminated {
            let Some(track_number) = self.numbers.lost(radar, target.number) else {
                self.counters.repeats += 1;
                return Ok(None);
            };
            self.counters.ended += 1;
            self.counters.timed += is_timed;
            // The place of the loss is an extrapolated one.
            return Ok(Some(Observation {
                track_number: Some(track_number),
                ..reported
            }));
        }
        let Some(place) = target.place else {
            self.counters.without_position += 1;
            return Ok(None);
        };
        let is_computed = matches!(place, RadarPlace::Geodetic(_));
        if is_computed && self.numbers.has_ttm(radar, target.number, now_ns) {
            self.counters.repeats += 1;
            return Ok(None);
        }
        let (geodetic, quality) = self.place(place, now_ns, time_of_day_ns)?;
        let velocity = target
            .speed_course
            .map(|motion| self.velocity(motion, now_ns))
            .transpose()?;
        let track_number = self.numbers.used(radar, target.number, now_ns)?;
        if !is_computed {
            self.numbers.ttm(radar, target.number, now_ns);
        }
        self.counters.targets += 1;
        self.counters.timed += is_timed;
        Ok(Some(Observation {
            track_number: Some(track_number),
            geodetic: Some(geodetic),
            velocity,
            axes: Axes::Target,
            quality,
            ..reported
        }))
    }

    /// Latitude and longitude of a target, radians, and their accuracy.
    fn place(
        &self,
        place: RadarPlace,
        now_ns: i64,
        time_of_day_ns: Option<i64>,
    ) -> Result<([f64; 2], Quality), RadarTargetRejection> {
        let own = self.own_ship.place(now_ns, time_of_day_ns);
        let (distance_m, bearing) = match place {
            RadarPlace::Polar(distance_m, bearing) => (distance_m, bearing),
            RadarPlace::Geodetic(position) => {
                let [latitude, longitude] = position.map(f64::to_degrees);
                let offset_m = |(own, _): (Geodetic, _)| {
                    let place = Geodetic::from_degrees(latitude, longitude, own.height_m()).ok()?;
                    let [east, north, _] = SystemFrame::at(own).to_local(place);
                    Some([east, north])
                };
                let offset_m = own.and_then(offset_m);
                let quality = offset_m.map_or(Quality::Unstated, |offset_m| self.quality(offset_m));
                return Ok((position, quality));
            }
        };
        let azimuth_rad = self.true_direction(bearing, now_ns)?;
        let (own, moved_m) = own.ok_or(RadarTargetRejection::OwnPlace)?;
        let system = SystemFrame::at(own);
        let [east, north, up] = SensorFrame::new(&system, own, 0.0).slant(distance_m, azimuth_rad, own.height_m());
        let found = system.to_geodetic([east + moved_m[0], north + moved_m[1], up]);
        let position = [found.latitude_deg(), found.longitude_deg()].map(f64::to_radians);
        Ok((position, self.quality([east, north])))
    }

    /// Accuracy of a position at `offset_m` (east, north) from the radar.
    fn quality(&self, offset_m: [f64; 2]) -> Quality {
        let range_m = offset_m[0].hypot(offset_m[1]);
        let sigma = self.settings.sigma.unwrap_or(PolarSigma {
            range_m: RANGE_SIGMA_MIN_M.max(RANGE_SIGMA_PER_M * range_m),
            azimuth_rad: BEARING_SIGMA_DEG.to_radians(),
        });
        Quality::Covariance(polar_covariance(offset_m, sigma))
    }

    /// Velocity over ground towards east and north, metres per second.
    fn velocity(&self, motion: Referred<[f64; 2]>, now_ns: i64) -> Result<[f64; 2], RadarTargetRejection> {
        let [speed_mps, course_rad] = motion.value;
        let course = Referred {
            value: course_rad,
            reference: motion.reference,
        };
        let (sine, cosine) = self.true_direction(course, now_ns)?.sin_cos();
        let own_mps = match motion.reference {
            Reference::True => [0.0; 2],
            Reference::Relative => self
                .own_ship
                .velocity_mps(now_ns)
                .ok_or(RadarTargetRejection::OwnVelocity)?,
        };
        Ok([own_mps[0] + speed_mps * sine, own_mps[1] + speed_mps * cosine])
    }

    /// Direction clockwise from true north, radians.
    fn true_direction(&self, direction: Referred<f64>, now_ns: i64) -> Result<f64, RadarTargetRejection> {
        match direction.reference {
            Reference::True => Ok(direction.value),
            Reference::Relative => {
                let heading_rad = self
                    .own_ship
                    .heading_rad(now_ns)
                    .ok_or(RadarTargetRejection::OwnHeading)?;
                Ok(heading_rad + direction.value)
            }
        }
    }
}

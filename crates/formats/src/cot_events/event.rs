//! XML of an event to values.

use std::ops::RangeInclusive;

use frames::time::NS_PER_DAY;
use jiff::Timestamp;
use messages::{Identity, TrackState};
use observations::{Axes, Observation, Quality, TargetCategory};
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::kind::{category, thing};
use super::reason::{CotReason, Read};
use crate::observation::items::components;
use crate::sbs::callsign;
use crate::target_message::{Refusal, number_of_name};

/// Values of height and error from here on are unknown.
const UNKNOWN: f64 = 999_999.0;
/// Most attributes of an element that is used.
const ATTRIBUTES_MAX: usize = 64;
/// Speeds of things, metres per second: up to those of satellites.
const SPEED_MPS: RangeInclusive<f64> = 0.0..=12_000.0;
/// Lowest height, metres: below all sea floors.
const HEIGHT_MIN_M: f64 = -12_000.0;
/// Slope up to which a rate of climb follows from the speed over ground, degrees.
const SLOPE_MAX_DEGREES: f64 = 80.0;
/// Oldest version of the schema.
const VERSION_MIN: f64 = 2.0;

/// An event of a thing.
#[derive(Clone, Copy, Debug)]
pub(super) struct ThingEvent {
    /// Time, UTC, nanoseconds since 1970.
    pub(super) time_ns: i64,
    /// Number of the track.
    pub(super) number: u32,
    pub(super) category: TargetCategory,
    /// With or without a position.
    pub(super) observation: Observation,
}

/// Attributes of the elements that are used.
#[derive(Debug, Default)]
struct Elements {
    event: Attributes,
    point: Attributes,
    contact: Attributes,
    track: Attributes,
}

/// Attributes of an element, by name.
#[derive(Debug, Default)]
struct Attributes(Vec<(String, String)>);

impl ThingEvent {
    /// Reads an event; `None` if it is not of a thing.
    pub(super) fn read(octets: &[u8]) -> Read<Option<Self>> {
        let text = std::str::from_utf8(octets);
        let text = text.map_err(|error| Refusal::new(CotReason::Text, "octet", error.valid_up_to()))?;
        let elements = Elements::read(text)?;
        let event = &elements.event;
        if let Some(version) = event.get("version") {
            let is_known = version.parse().is_ok_and(|version: f64| version >= VERSION_MIN);
            is_known
                .then_some(())
                .ok_or_else(|| Refusal::new(CotReason::Version, "version", version))?;
        }
        let named = |key| event.get(key).ok_or_else(|| Refusal::new(CotReason::Name, key, ""));
        let (uid, kind) = (named("uid")?, named("type")?);
        let Some(letters) = thing(kind) else {
            return Ok(None);
        };
        let dimension = letters.clone().next().unwrap_or_default();
        let key = if event.get("start").is_some() { "start" } else { "time" };
        let time_ns = event.time_ns(key)?;
        let has_ended = event.get("stale").is_some() && event.time_ns("stale")? <= time_ns;
        let is = |key, mark: &str| event.get(key).is_some_and(|value| value.starts_with(mark));
        let (velocity, vertical_rate_mps) = elements.track.velocity()?;
        let height_m = elements.point.height_m()?;
        let number = number_of_name(uid.as_bytes());
        let (geodetic, quality) = elements.point.position()?;
        let observation = Observation {
            time_of_day_ns: Some(time_ns.rem_euclid(NS_PER_DAY)),
            test: is("how", "m-s") || is("opex", "s"),
            track_number: Some(number),
            identity: elements.contact.identity(dimension == "A"),
            geodetic,
            velocity,
            axes: Axes::Target,
            geometric_height_m: height_m,
            ellipsoid_height_m: height_m,
            vertical_rate_mps,
            on_ground: dimension == "G",
            state: if has_ended {
                TrackState::Terminated
            } else {
                TrackState::Confirmed
            },
            quality,
            ..Observation::default()
        };
        Ok(Some(Self {
            time_ns,
            number,
            category: category(letters),
            observation,
        }))
    }
}

impl Elements {
    fn read(text: &str) -> Read<Self> {
        let wrong = |error: &dyn std::fmt::Display| Refusal::new(CotReason::Xml, "XML", error);
        let mut reader = Reader::from_str(text);
        reader.config_mut().enable_all_checks(true);
        let mut elements = Self::default();
        let (mut depth, mut is_detail) = (0, false);
        loop {
            match reader.read_event().map_err(|error| wrong(&error))? {
                Event::Start(start) => {
                    elements.note(depth, is_detail, &start)?;
                    is_detail = if depth == 1 {
                        start.name().as_ref() == "detail"
                    } else {
                        is_detail
                    };
                    depth += 1;
                }
                Event::Empty(start) => elements.note(depth, is_detail, &start)?,
                Event::End(_) => depth -= 1,
                Event::DocType(_) => return Err(wrong(&"a document type")),
                Event::Eof if depth == 0 => return Ok(elements),
                Event::Eof => return Err(wrong(&"an element has no end")),
                _ => {}
            }
        }
    }

    /// Keeps the attributes of an element that is used, the first of its name.
    fn note(&mut self, depth: usize, is_detail: bool, start: &BytesStart<'_>) -> Read<()> {
        let name = start.name();
        let place = match (depth, name.as_ref()) {
            (0, "event") => &mut self.event,
            (1, "point") => &mut self.point,
            (2, "contact") if is_detail => &mut self.contact,
            (2, "track") if is_detail => &mut self.track,
            _ => return Ok(()),
        };
        if place.0.is_empty() {
            *place = Attributes::read(start)?;
        }
        Ok(())
    }
}

impl Attributes {
    fn read(start: &BytesStart<'_>) -> Read<Self> {
        let wrong = |error: &dyn std::fmt::Display| Refusal::new(CotReason::Xml, "XML", error);
        let mut found = Vec::new();
        for attribute in start.attributes() {
            let attribute = attribute.map_err(|error| wrong(&error))?;
            let value = attribute.normalized_value(XmlVersion::Implicit1_0);
            let value = value.map_err(|error| wrong(&error))?.trim().to_owned();
            found.push((attribute.key.as_ref().to_owned(), value));
            if found.len() > ATTRIBUTES_MAX {
                return Err(wrong(&"too many attributes"));
            }
        }
        Ok(Self(found))
    }

    fn get(&self, key: &str) -> Option<&str> {
        let found = self.0.iter().find(|(name, _)| name == key);
        found.map(|(_, value)| value.as_str()).filter(|value| !value.is_empty())
    }

    /// A number; `None` if the attribute is missing or states NaN.
    fn number(&self, key: &'static str, reason: CotReason) -> Read<Option<f64>> {
        let Some(text) = self.get(key) else {
            return Ok(None);
        };
        let number: f64 = text.parse().map_err(|_| Refusal::new(reason, key, text))?;
        Ok((!number.is_nan()).then_some(number))
    }

    /// A number within a range.
    fn within(&self, key: &'static str, reason: CotReason, range: &RangeInclusive<f64>) -> Read<Option<f64>> {
        match self.number(key, reason)? {
            Some(number) if !range.contains(&number) => Err(Refusal::new(reason, key, number)),
            number => Ok(number),
        }
    }

    fn time_ns(&self, key: &'static str) -> Read<i64> {
        let text = self.get(key).unwrap_or_default();
        let time: Option<Timestamp> = text.parse().ok();
        let time_ns = time.and_then(|time| i64::try_from(time.as_nanosecond()).ok());
        let time_ns = time_ns.filter(|time_ns| *time_ns >= 0);
        time_ns.ok_or_else(|| Refusal::new(CotReason::Time, key, text))
    }

    /// Latitude and longitude, radians, and the error. A phone without a fix has no position.
    fn position(&self) -> Read<(Option<[f64; 2]>, Quality)> {
        let reason = CotReason::Position;
        let degree = |key: &'static str, most: f64| {
            let degrees = self.within(key, reason, &(-most..=most))?;
            degrees.ok_or_else(|| Refusal::new(reason, key, self.get(key).unwrap_or_default()))
        };
        let degrees = [degree("lat", 90.0)?, degree("lon", 180.0)?];
        let circle = |key| self.within(key, CotReason::Error, &(0.0..=f64::MAX));
        let sigma_m = circle("ce")?.filter(|sigma_m| (f64::MIN_POSITIVE..UNKNOWN).contains(sigma_m));
        circle("le")?;
        let has_fix = degrees != [0.0; 2] || sigma_m.is_some();
        let quality = sigma_m.map_or(Quality::Unstated, |sigma_m| {
            let variance_m2 = sigma_m * sigma_m;
            Quality::Covariance([variance_m2, 0.0, variance_m2])
        });
        Ok((has_fix.then(|| degrees.map(f64::to_radians)), quality))
    }

    fn height_m(&self) -> Read<Option<f64>> {
        let height_m = self.within("hae", CotReason::Height, &(HEIGHT_MIN_M..=f64::MAX))?;
        Ok(height_m.filter(|height_m| *height_m < UNKNOWN))
    }

    /// East and north, and the rate of climb, metres per second. Some phones write -1 for an unknown course or speed.
    fn velocity(&self) -> Read<(Option<[f64; 2]>, Option<f64>)> {
        let known = |key: &'static str, range: RangeInclusive<f64>| match self.number(key, CotReason::Velocity)? {
            Some(-1.0) => Ok(None),
            _ => self.within(key, CotReason::Velocity, &range),
        };
        let (speed_mps, course) = (known("speed", SPEED_MPS)?, known("course", 0.0..=360.0)?);
        let slope = self.within("slope", CotReason::Velocity, &(-90.0..=90.0))?;
        let velocity = match (speed_mps, course) {
            (Some(0.0), _) => Some([0.0; 2]),
            (Some(speed_mps), Some(course)) => Some(components([speed_mps, course.to_radians()])),
            _ => None,
        };
        let slope = slope.filter(|slope| slope.abs() <= SLOPE_MAX_DEGREES);
        let climb_mps = speed_mps
            .zip(slope)
            .map(|(speed_mps, slope)| speed_mps * slope.to_radians().tan());
        Ok((velocity, climb_mps))
    }

    fn identity(&self, is_aircraft: bool) -> Identity {
        let identity = Identity::default();
        let text = self
            .get("callsign")
            .filter(|text| text.bytes().all(|octet| (b' '..=b'~').contains(&octet)));
        match (text, text.and_then(callsign)) {
            (Some(_), Some(callsign)) if is_aircraft => identity.with_callsign(callsign),
            (Some(text), _) => identity.with_name(text),
            (None, _) => identity,
        }
    }
}

//! Fields of a line: a JSON object whose fields are taken by name, so that what is left has no meaning.

use frames::{Geodetic, SystemFrame};
use messages::NS_PER_S;
use messages::admission::Fault;
use serde_json::{Map, Value};

/// The fields of a line that have not been taken yet.
#[derive(Debug)]
pub(super) struct Fields(Map<String, Value>);

/// A position in the system frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    /// Metres east, north and up.
    pub(super) position_m: [f64; 3],
    /// Whether the height is known.
    pub(super) has_height: bool,
}

pub(super) fn fault(field: &str, value: impl ToString, limit: &str, remedy: impl Into<String>) -> Fault {
    Fault {
        field: field.to_owned(),
        value: value.to_string(),
        limit: limit.to_owned(),
        remedy: remedy.into(),
    }
}

/// Fault of a field that a line needs.
pub(super) fn missing(field: &str, remedy: &str) -> Fault {
    fault(field, "missing", "the field is needed", remedy)
}

impl Fields {
    pub(super) fn of_line(line: &[u8]) -> Result<Self, Fault> {
        let remedy = "write an object as in {\"latitude\": 41.3, \"longitude\": 2.1, \"sigma_m\": 20}";
        match serde_json::from_slice(line) {
            Ok(Value::Object(fields)) => Ok(Self(fields)),
            Ok(other) => Err(fault(
                "line",
                shortened(&other.to_string()),
                "must be a JSON object",
                remedy,
            )),
            Err(error) => {
                let text = shortened(&String::from_utf8_lossy(line));
                Err(fault("line", text, &format!("must be JSON ({error})"), remedy))
            }
        }
    }

    /// Takes a field; an unknown value (`null`) is no value.
    fn take(&mut self, name: &str) -> Option<Value> {
        self.0.remove(name).filter(|value| !value.is_null())
    }

    pub(super) fn text(&mut self, name: &str) -> Result<Option<String>, Fault> {
        match self.take(name) {
            None => Ok(None),
            Some(Value::String(text)) => Ok(Some(text)),
            Some(other) => Err(fault(name, other, "must be a text", "put it between quotation marks")),
        }
    }

    pub(super) fn number(&mut self, name: &str) -> Result<Option<f64>, Fault> {
        let Some(value) = self.take(name) else { return Ok(None) };
        let number = value.as_f64().ok_or_else(|| wrong_number(name, &value))?;
        Ok(Some(number))
    }

    pub(super) fn whole(&mut self, name: &str) -> Result<Option<u32>, Fault> {
        let Some(value) = self.take(name) else { return Ok(None) };
        let whole = value.as_u64().and_then(|whole| u32::try_from(whole).ok());
        let limit = "must be a whole number from 0 to 4294967295";
        whole
            .map(Some)
            .ok_or_else(|| fault(name, &value, limit, "number the sensor's tracks or scans from 1"))
    }

    /// Takes an array of `least` to `N` numbers; the rest is 0. Returns the values and their number.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        name: &str,
        least: usize,
    ) -> Result<Option<([f64; N], usize)>, Fault> {
        let Some(value) = self.take(name) else { return Ok(None) };
        let wrong = || {
            let limit = format!("must be an array of {least} to {N} numbers");
            fault(
                name,
                shortened(&value.to_string()),
                &limit,
                "write it as in [100.0, 200.0, 300.0]",
            )
        };
        let all: Option<Vec<f64>> = value.as_array().and_then(|all| all.iter().map(Value::as_f64).collect());
        let all = all.filter(|all| (least..=N).contains(&all.len())).ok_or_else(wrong)?;
        let mut numbers = [0.0; N];
        numbers[..all.len()].copy_from_slice(&all);
        Ok(Some((numbers, all.len())))
    }

    /// Takes an angle in degrees (`NAME_deg`) or radians (`NAME_rad`), radians.
    pub(super) fn angle(&mut self, name: &str) -> Result<Option<f64>, Fault> {
        let in_degrees = format!("{name}_deg");
        let degrees = self.number(&in_degrees)?;
        let radians = self.number(&format!("{name}_rad"))?;
        match (degrees, radians) {
            (Some(degrees), Some(_)) => Err(fault(
                &in_degrees,
                degrees,
                "must not stand beside radians",
                "leave one out",
            )),
            (Some(degrees), None) if degrees.abs() > 360.0 => {
                Err(fault(&in_degrees, degrees, "must be from -360 to 360", "give degrees"))
            }
            (degrees, radians) => Ok(degrees.map(f64::to_radians).or(radians)),
        }
    }

    /// Takes the time, UTC, nanoseconds since 1970, with the name of its field; `None` if the line states none.
    pub(super) fn time_ns(&mut self) -> Result<Option<i64>, Fault> {
        let remedy = "write time as in \"2026-05-01T10:00:00.5Z\", or the UTC since 1970 as time_s or time_ns";
        if let Some(value) = self.take("time") {
            let parsed = value.as_str().map(str::parse::<formats::rows::Utc>);
            let Some(Ok(formats::rows::Utc(time_ns))) = parsed else {
                return Err(fault("time", value, "must be a text of UTC", remedy));
            };
            return Ok(Some(time_ns));
        }
        if let Some(seconds) = self.number("time_s")? {
            let range = -4e9..=4e9;
            if !range.contains(&seconds) {
                return Err(fault("time_s", seconds, "must be seconds of UTC since 1970", remedy));
            }
            // In two parts: a number of nanoseconds has more digits than a floating-point number.
            let whole = seconds.floor();
            return Ok(Some(
                whole as i64 * 1_000_000_000 + ((seconds - whole) * NS_PER_S).round() as i64,
            ));
        }
        let Some(value) = self.take("time_ns") else {
            return Ok(None);
        };
        let time_ns = value.as_i64();
        time_ns.map(Some).ok_or_else(|| {
            fault(
                "time_ns",
                value,
                "must be a whole number of nanoseconds since 1970",
                remedy,
            )
        })
    }

    /// Takes a place: `latitude`, `longitude` and `height_m` with the prefix, or `metres`, a position in the frame.
    pub(super) fn place(&mut self, prefix: &str, metres: &str, frame: &SystemFrame) -> Result<Option<Placed>, Fault> {
        let names = ["latitude", "longitude", "height_m"].map(|name| format!("{prefix}{name}"));
        let latitude = self.number(&names[0])?;
        let longitude = self.number(&names[1])?;
        let height_m = self.number(&names[2])?;
        let position = self.numbers::<3>(metres, 2)?;
        let (latitude, longitude) = match (latitude, longitude, position) {
            (None, None, None) if height_m.is_some() => return Err(missing(&names[0], "a height needs a place")),
            (None, None, None) => return Ok(None),
            (None, None, Some((position_m, count))) if height_m.is_none() => {
                return Ok(Some(Placed {
                    position_m,
                    has_height: count == 3,
                }));
            }
            (Some(latitude), Some(longitude), None) => (latitude, longitude),
            (_, _, Some(_)) => {
                let limit = "must not stand beside latitude, longitude and height_m";
                return Err(fault(metres, "present", limit, "leave one of the two forms out"));
            }
            (None, ..) => return Err(missing(&names[0], "give both latitude and longitude")),
            (_, None, _) => return Err(missing(&names[1], "give both latitude and longitude")),
        };
        check_degrees(&names, latitude, longitude)?;
        let place = Geodetic::from_degrees(latitude, longitude, height_m.unwrap_or_default());
        let place = place.map_err(|error| {
            fault(
                &names[2],
                height_m.unwrap_or_default(),
                &error.to_string(),
                "give metres",
            )
        })?;
        Ok(Some(Placed {
            position_m: frame.to_local(place),
            has_height: height_m.is_some(),
        }))
    }

    /// Takes the standard deviation of a value, above 0.
    pub(super) fn sigma(&mut self, name: &str) -> Result<Option<f64>, Fault> {
        let sigma = self.number(name)?;
        match sigma {
            Some(sigma) if !(sigma > 0.0 && sigma <= 1e7) => Err(unusable_sigma(name, sigma)),
            sigma => Ok(sigma),
        }
    }

    /// Refuses what has not been taken.
    pub(super) fn end(self, known: &[&str]) -> Result<(), Fault> {
        let Some((name, value)) = self.0.into_iter().next() else {
            return Ok(());
        };
        let near = settings::nearest(&name, known).map(|near| format!("did you mean {near}? "));
        let remedy = format!("{}`koseki feed --help` lists the fields", near.unwrap_or_default());
        Err(fault(
            &name,
            shortened(&value.to_string()),
            "is no field of such a source",
            remedy,
        ))
    }
}

fn check_degrees(names: &[String; 3], latitude: f64, longitude: f64) -> Result<(), Fault> {
    let (is_latitude, is_longitude) = (latitude.abs() <= 90.0, longitude.abs() <= 180.0);
    if is_latitude && is_longitude {
        return Ok(());
    }
    let remedy = match () {
        () if !is_latitude && latitude.abs() <= 180.0 && longitude.abs() <= 90.0 => {
            "latitude and longitude are exchanged"
        }
        () if latitude.abs() > 360.0 || longitude.abs() > 360.0 => "give metres of the system frame as position_m",
        () => "give degrees, north and east positive",
    };
    Err(match is_latitude {
        false => fault(&names[0], latitude, "must be from -90 to 90 degrees", remedy),
        true => fault(&names[1], longitude, "must be from -180 to 180 degrees", remedy),
    })
}

pub(super) fn unusable_sigma(name: &str, value: impl ToString) -> Fault {
    let remedy = "state the standard deviation of the sensor's error";
    fault(name, value, "must be above 0 and at most 1e7", remedy)
}

fn wrong_number(name: &str, value: &Value) -> Fault {
    fault(
        name,
        shortened(&value.to_string()),
        "must be a number",
        "write digits without quotation marks",
    )
}

/// The begin of a long text.
fn shortened(text: &str) -> String {
    const SHOWN: usize = 60;
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

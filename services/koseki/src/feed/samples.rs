//! Samples of the lines: a detection or a report of a track.

use frames::{Geodetic, SystemFrame};
use messages::admission::Fault;
use messages::{
    Covariance, DetectionKind, Identity, SensorDetection, SensorTrack, TrackState, sensor_detection_bits,
    sensor_track_bits,
};

use super::fields::{Fields, Placed, fault, missing};

/// Fields of every source.
const COMMON: [&str; 15] = [
    "source",
    "time",
    "time_s",
    "time_ns",
    "latitude",
    "longitude",
    "height_m",
    "position_m",
    "sigma_m",
    "height_sigma_m",
    "address",
    "mmsi",
    "callsign",
    "mode_3a",
    "name",
];
/// Further fields of detections.
const OF_DETECTIONS: [&str; 13] = [
    "scan",
    "range_m",
    "bearing_deg",
    "elevation_deg",
    "range_sigma_m",
    "bearing_sigma_deg",
    "elevation_sigma_deg",
    "sensor_latitude",
    "sensor_longitude",
    "sensor_height_m",
    "sensor_m",
    "range_rate_mps",
    "range_rate_sigma_mps",
];
/// Further fields of tracks.
const OF_TRACKS: [&str; 8] = [
    "track",
    "velocity_mps",
    "speed_mps",
    "course_deg",
    "course_rad",
    "climb_mps",
    "velocity_sigma_mps",
    "state",
];

/// Returns the detection of a line that came at `received_ns`, and whether the line states the scan. With `has_sigmas`
/// the configuration has standard deviations for lines without their own.
pub(super) fn detection(
    mut fields: Fields,
    frame: &SystemFrame,
    received_ns: i64,
    has_sigmas: bool,
) -> Result<(SensorDetection, bool), Fault> {
    use sensor_detection_bits as bits;
    let time_ns = fields.time_ns()?.unwrap_or(received_ns);
    let scan = fields.whole("scan")?;
    let identity = identity(&mut fields)?;
    let place = fields.place("", "position_m", frame)?;
    let sensor = fields.place("sensor_", "sensor_m", frame)?;
    let (kind, values, sigmas) = match place {
        Some(placed) => of_position(&mut fields, placed)?,
        None => of_directions(&mut fields, sensor.is_some())?,
    };
    let mut detection = SensorDetection {
        time_of_measurement_ns: time_ns,
        scan: scan.unwrap_or_default(),
        kind: kind as u8,
        values,
        platform_m: sensor.map_or([0.0; 3], |sensor| sensor.position_m),
        identity,
        ..SensorDetection::default()
    };
    match sigmas {
        Some([first, second, third]) => {
            detection.valid |= bits::SIGMAS;
            detection.sigmas = [first, second, third, 0.0];
        }
        None if has_sigmas => {}
        None => {
            let name = if place.is_some() {
                "sigma_m"
            } else {
                "bearing_sigma_deg"
            };
            return Err(missing(name, "give it in each line, or `sigmas` in [source.external]"));
        }
    }
    let rate = fields.number("range_rate_mps")?;
    let rate_sigma = fields.sigma("range_rate_sigma_mps")?;
    if let Some(rate_mps) = rate {
        detection.valid |= bits::RANGE_RATE;
        detection.range_rate_mps = rate_mps;
        match (rate_sigma, detection.valid & bits::SIGMAS != 0) {
            (Some(sigma), true) => detection.sigmas[3] = sigma,
            (None, false) => {}
            _ => {
                return Err(missing(
                    "range_rate_sigma_mps",
                    "give all standard deviations in the line, or none",
                ));
            }
        }
    }
    fields.end(&[&COMMON[..], &OF_DETECTIONS].concat())?;
    Ok((detection, scan.is_some()))
}

/// Kind, values and standard deviations, if stated.
type Measured = (DetectionKind, [f64; 3], Option<[f64; 3]>);

fn of_position(fields: &mut Fields, placed: Placed) -> Result<Measured, Fault> {
    let sigma_m = fields.sigma("sigma_m")?;
    let height_sigma_m = fields.sigma("height_sigma_m")?;
    let [east, north, up] = placed.position_m;
    Ok(match placed.has_height {
        true => {
            let sigmas = sigma_m.map(|sigma_m| [sigma_m, sigma_m, height_sigma_m.unwrap_or(sigma_m)]);
            (DetectionKind::Position3, [east, north, up], sigmas)
        }
        false => {
            let sigmas = sigma_m.map(|sigma_m| [sigma_m, sigma_m, 0.0]);
            (DetectionKind::Position2, [east, north, 0.0], sigmas)
        }
    })
}

fn of_directions(fields: &mut Fields, has_sensor: bool) -> Result<Measured, Fault> {
    let range_m = fields.number("range_m")?;
    let bearing = fields.angle("bearing")?;
    let elevation = fields.angle("elevation")?;
    let Some(bearing) = bearing else {
        return Err(missing(
            "latitude",
            "give latitude and longitude, position_m, or bearing_deg",
        ));
    };
    if !has_sensor {
        return Err(missing(
            "sensor_latitude",
            "bearings need the sensor's place: sensor_latitude and sensor_longitude",
        ));
    }
    let range_sigma = fields.sigma("range_sigma_m")?;
    let bearing_sigma = fields.angle("bearing_sigma")?;
    let elevation_sigma = fields.angle("elevation_sigma")?;
    let (kind, values, sigmas) = match (range_m, elevation) {
        (Some(range), Some(elevation)) => (
            DetectionKind::RangeBearingElevation,
            [range, bearing, elevation],
            [range_sigma, bearing_sigma, elevation_sigma],
        ),
        (Some(range), None) => (
            DetectionKind::RangeBearing,
            [range, bearing, 0.0],
            [range_sigma, bearing_sigma, Some(0.0)],
        ),
        (None, Some(elevation)) => (
            DetectionKind::BearingElevation,
            [bearing, elevation, 0.0],
            [bearing_sigma, elevation_sigma, Some(0.0)],
        ),
        (None, None) => (
            DetectionKind::Bearing,
            [bearing, 0.0, 0.0],
            [bearing_sigma, Some(0.0), Some(0.0)],
        ),
    };
    let measured = kind.quantities().len();
    if sigmas[..measured].iter().all(Option::is_none) {
        return Ok((kind, values, None));
    }
    let names = match range_m {
        Some(_) => ["range_sigma_m", "bearing_sigma_deg", "elevation_sigma_deg"],
        None => ["bearing_sigma_deg", "elevation_sigma_deg", ""],
    };
    let mut stated = [0.0; 3];
    for (place, sigma) in sigmas.into_iter().enumerate() {
        stated[place] =
            sigma.ok_or_else(|| missing(names[place], "give all standard deviations in the line, or none"))?;
    }
    Ok((kind, values, Some(stated)))
}

/// Returns the report of a track of a line that came at `received_ns`.
pub(super) fn track(mut fields: Fields, frame: &SystemFrame, received_ns: i64) -> Result<SensorTrack, Fault> {
    use sensor_track_bits as bits;
    let time_ns = fields.time_ns()?.unwrap_or(received_ns);
    let number = fields.whole("track")?;
    let track_number =
        number.ok_or_else(|| missing("track", "number the sensor's tracks; detections have no number"))?;
    let identity = identity(&mut fields)?;
    let placed = fields.place("", "position_m", frame)?;
    let placed = placed.ok_or_else(|| missing("latitude", "give latitude and longitude, or position_m"))?;
    let sigma_m = fields.sigma("sigma_m")?;
    let sigma_m = sigma_m.ok_or_else(|| missing("sigma_m", "state the standard deviation of the position"))?;
    let height_sigma_m = fields.sigma("height_sigma_m")?.unwrap_or(sigma_m);
    let state = match fields.text("state")? {
        None => TrackState::Confirmed,
        Some(word) => TrackState::from_word(&word).ok_or_else(|| {
            fault(
                "state",
                word,
                "is no state",
                "write tentative, confirmed, coasted or terminated",
            )
        })?,
    };
    let velocity = velocity(&mut fields, placed, frame)?;
    let velocity_sigma = fields.sigma("velocity_sigma_mps")?;
    let mut valid = bits::OWN_COVARIANCE;
    valid |= if placed.has_height { bits::HEIGHT } else { 0 };
    let (velocity_mps, velocity_sigmas) = match (velocity, velocity_sigma) {
        (None, _) => ([0.0; 3], [0.0; 3]),
        (Some(_), None) => {
            return Err(missing(
                "velocity_sigma_mps",
                "state the standard deviation of the velocity",
            ));
        }
        (Some((velocity_mps, has_climb)), Some(sigma)) => {
            valid |= bits::VELOCITY | if has_climb { bits::VERTICAL_RATE } else { 0 };
            (velocity_mps, [sigma, sigma, if has_climb { sigma } else { 0.0 }])
        }
    };
    let [east, north, up] = placed.position_m;
    let up_sigma_m = if placed.has_height { height_sigma_m } else { 0.0 };
    fields.end(&[&COMMON[..], &OF_TRACKS].concat())?;
    Ok(SensorTrack {
        time_of_measurement_ns: time_ns,
        track_number,
        valid,
        identity,
        position_m: [east, north, if placed.has_height { up } else { 0.0 }],
        velocity_mps,
        covariance: Covariance::diagonal([sigma_m, sigma_m, up_sigma_m], velocity_sigmas),
        state: state as u8,
        ..SensorTrack::default()
    })
}

/// Velocity in the system frame, and whether its vertical part is known.
fn velocity(fields: &mut Fields, placed: Placed, frame: &SystemFrame) -> Result<Option<([f64; 3], bool)>, Fault> {
    let components = fields.numbers::<3>("velocity_mps", 2)?;
    let speed = fields.number("speed_mps")?;
    let course = fields.angle("course")?;
    let climb = fields.number("climb_mps")?;
    match (components, speed, course) {
        (Some((velocity_mps, count)), None, None) if climb.is_none() => Ok(Some((velocity_mps, count == 3))),
        (Some(_), ..) => Err(fault(
            "velocity_mps",
            "present",
            "must not stand beside speed_mps, course_deg and climb_mps",
            "leave one of the two forms out",
        )),
        (None, Some(speed), Some(course)) => {
            let [east, north, up] = axes(frame, placed.position_m);
            let parts = [speed * course.sin(), speed * course.cos(), climb.unwrap_or_default()];
            let along = |axis: usize| parts[0] * east[axis] + parts[1] * north[axis] + parts[2] * up[axis];
            Ok(Some(([along(0), along(1), along(2)], climb.is_some())))
        }
        (None, None, None) if climb.is_none() => Ok(None),
        (None, None, _) => Err(missing("speed_mps", "give speed_mps and course_deg together")),
        (None, _, None) => Err(missing("course_deg", "give speed_mps and course_deg together")),
    }
}

/// East, north and up at a place, in the system frame: away from its origin they differ from the frame's axes.
fn axes(frame: &SystemFrame, position_m: [f64; 3]) -> [[f64; 3]; 3] {
    /// About 111 m, of which rounding has no part.
    const STEP_DEG: f64 = 1e-3;
    let place = frame.to_geodetic(position_m);
    let (latitude, height_m) = (place.latitude_deg().clamp(-89.9, 89.9), place.height_m());
    let away = |step_deg: f64| {
        let moved = Geodetic::from_degrees(latitude + step_deg, place.longitude_deg(), height_m);
        moved.map_or(position_m, |moved| frame.to_local(moved))
    };
    let north = unit(difference(away(STEP_DEG), away(-STEP_DEG)));
    let raised = Geodetic::from_degrees(latitude, place.longitude_deg(), height_m.min(90e3) + 1e3);
    let up = unit(difference(
        raised.map_or(position_m, |raised| frame.to_local(raised)),
        away(0.0),
    ));
    [cross(north, up), north, up]
}

fn difference(one: [f64; 3], other: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| one[axis] - other[axis])
}

fn unit(vector: [f64; 3]) -> [f64; 3] {
    let length = vector.iter().map(|part| part * part).sum::<f64>().sqrt();
    vector.map(|part| if length > 0.0 { part / length } else { 0.0 })
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

fn identity(fields: &mut Fields) -> Result<Identity, Fault> {
    let mut identity = Identity::default();
    if let Some(text) = fields.text("address")? {
        let address = u32::from_str_radix(&text, 16).ok().filter(|address| *address < 1 << 24);
        let what = "must be up to six hexadecimal digits";
        identity =
            identity.with_address(address.ok_or_else(|| fault("address", text, what, "write it as in \"3C6589\""))?);
    }
    if let Some(mmsi) = fields.whole("mmsi")? {
        let is_mmsi = (1..=999_999_999).contains(&mmsi);
        let what = || fault("mmsi", mmsi, "must be from 1 to 999999999", "an MMSI has nine digits");
        identity = is_mmsi.then(|| identity.with_mmsi(mmsi)).ok_or_else(what)?;
    }
    if let Some(text) = fields.text("mode_3a")? {
        let code = u16::from_str_radix(&text, 8)
            .ok()
            .filter(|code| *code < 1 << 12 && text.len() == 4);
        let what = "must be four octal digits";
        identity = identity.with_mode_3a(code.ok_or_else(|| fault("mode_3a", text, what, "write it as in \"7000\""))?);
    }
    if let Some(text) = fields.text("callsign")? {
        let mut callsign = [b' '; 8];
        if !text.is_ascii() || text.is_empty() || text.len() > callsign.len() {
            return Err(fault(
                "callsign",
                text,
                "must be one to eight characters of ASCII",
                "shorten it",
            ));
        }
        callsign[..text.len()].copy_from_slice(text.as_bytes());
        identity = identity.with_callsign(callsign);
    }
    if let Some(text) = fields.text("name")? {
        identity = identity.with_name(&text);
    }
    Ok(identity)
}

#[cfg(test)]
#[path = "samples_tests.rs"]
mod tests;

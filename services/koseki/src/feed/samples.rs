//! Observations of the lines: a detection or a report of a track. The client library makes the samples.

use koseki_client::observation::{Fields as _, callsign_of, fault, name_of, numbered};
use koseki_client::{Detection, TrackReport};
use messages::admission::Fault;
use messages::layout::Sample as _;
use messages::{Identity, IdentityText, SensorDetection, SensorTrack, SystemTrack, TrackState};

use super::fields::Fields;

/// Fields of every source that are no numbers of an observation.
const COMMON: [&str; 10] = [
    "source",
    "time",
    "time_s",
    "time_ns",
    "position_m",
    "address",
    "mmsi",
    "callsign",
    "mode_3a",
    "name",
];
/// Further fields of detections.
const OF_DETECTIONS: [&str; 2] = ["scan", "sensor_m"];
/// Further fields of tracks.
const OF_TRACKS: [&str; 3] = ["track", "velocity_mps", "state"];

/// Fields of faults that are none of a source's fields.
const OF_LINES: [&str; 1] = ["line"];

/// Whether this command has a fault's field: an element of a field counts as the field.
pub(super) fn is_known(field: &str) -> bool {
    let name = field.split(['[', '.', ',']).next().unwrap_or_default();
    let degrees = name.replace("_rad", "_deg");
    let all = [
        &COMMON[..],
        &OF_DETECTIONS,
        &OF_TRACKS,
        &OF_LINES,
        Detection::NUMBERS,
        TrackReport::NUMBERS,
    ];
    let named = |known: &&str| *known == name || *known == degrees;
    let mut of_samples = [SensorDetection::LAYOUT, SensorTrack::LAYOUT, SystemTrack::LAYOUT].into_iter();
    all.into_iter().flatten().any(named)
        || of_samples.any(|layout| layout.fields.iter().any(|field| field.name == name))
}

/// Returns the detection of a line. With `has_sigmas` the configuration has standard deviations for lines without own
/// values.
pub(super) fn detection(mut fields: Fields, has_sigmas: bool) -> Result<Detection, Fault> {
    let known = [Detection::NUMBERS, &COMMON, &OF_DETECTIONS].concat();
    fields.rename(&known)?;
    let mut detection = Detection {
        time_ns: fields.time_ns()?,
        scan: fields.whole("scan")?,
        identity: identity(&mut fields)?,
        has_configured_sigmas: has_sigmas,
        ..Detection::default()
    };
    let place = fields.vector("position_m", &["latitude", "longitude", "height_m"])?;
    let sensor = fields.vector("sensor_m", &["sensor_latitude", "sensor_longitude", "sensor_height_m"])?;
    numbers(&mut fields, Detection::NUMBERS, |name, value| {
        detection
            .number_mut(name)
            .into_iter()
            .for_each(|place| *place = Some(value));
    })?;
    [detection.east_m, detection.north_m, detection.up_m] =
        or(place, [detection.east_m, detection.north_m, detection.up_m]);
    let stated = [detection.sensor_east_m, detection.sensor_north_m, detection.sensor_up_m];
    [detection.sensor_east_m, detection.sensor_north_m, detection.sensor_up_m] = or(sensor, stated);
    fields.end(&known)?;
    Ok(detection)
}

/// Returns the report of a track of a line.
pub(super) fn track(mut fields: Fields) -> Result<TrackReport, Fault> {
    let known = [TrackReport::NUMBERS, &COMMON, &OF_TRACKS].concat();
    fields.rename(&known)?;
    let mut report = TrackReport {
        time_ns: fields.time_ns()?,
        track: fields.whole("track")?,
        state: fields.text("state")?.map(|word| state_of(&word)).transpose()?,
        identity: identity(&mut fields)?,
        ..TrackReport::default()
    };
    let place = fields.vector("position_m", &["latitude", "longitude", "height_m"])?;
    let velocity = fields.vector("velocity_mps", &["speed_mps", "course_deg", "climb_mps"])?;
    numbers(&mut fields, TrackReport::NUMBERS, |name, value| {
        report
            .number_mut(name)
            .into_iter()
            .for_each(|place| *place = Some(value));
    })?;
    [report.east_m, report.north_m, report.up_m] = or(place, [report.east_m, report.north_m, report.up_m]);
    let stated = [
        report.velocity_east_mps,
        report.velocity_north_mps,
        report.velocity_up_mps,
    ];
    [
        report.velocity_east_mps,
        report.velocity_north_mps,
        report.velocity_up_mps,
    ] = or(velocity, stated);
    fields.end(&known)?;
    Ok(report)
}

/// Takes all numbers of an observation.
fn numbers(fields: &mut Fields, names: &[&str], mut set: impl FnMut(&str, f64)) -> Result<(), Fault> {
    for name in names {
        if let Some(value) = fields.number(name)? {
            set(name, value);
        }
    }
    Ok(())
}

fn or(values: [Option<f64>; 3], others: [Option<f64>; 3]) -> [Option<f64>; 3] {
    [0, 1, 2].map(|axis| values[axis].or(others[axis]))
}

fn state_of(word: &str) -> Result<TrackState, Fault> {
    let remedy = "write tentative, confirmed, coasted or terminated";
    TrackState::from_word(word).ok_or_else(|| fault("state", word, "is no state", remedy))
}

fn identity(fields: &mut Fields) -> Result<Identity, Fault> {
    let mut identity = Identity::default();
    for spelling in IdentityText::ALL {
        if let Some(number) = fields.digits(spelling)? {
            identity = numbered(identity, spelling, number)?;
        }
    }
    if let Some(text) = fields.text("callsign")? {
        identity = identity.with_callsign(callsign_of(&text)?);
    }
    if let Some(text) = fields.text("name")? {
        identity = identity.with_name(name_of(&text)?);
    }
    Ok(identity)
}

#[cfg(test)]
#[path = "samples_tests.rs"]
mod tests;

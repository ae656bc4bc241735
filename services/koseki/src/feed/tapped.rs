//! Lines of `koseki tap`: whole samples with named fields.
//!
//! Such a line states the nanoseconds of its measurement under the sample's name, which no other line does. A sensor
//! track or a detection goes on with every field; a state of a system track becomes a report of another centre, as over
//! a link. Positions are in metres of the system frame of the tapped deployment; a line with latitude and longitude
//! elsewhere in the fed deployment's frame is refused.

use frames::SystemFrame;
use koseki_client::observation::fault;
use messages::admission::Fault;
use messages::layout::{Layout, Sample};
use messages::{SensorDetection, SensorTrack, SystemTrack};
use sample_text::LineReader;
use serde_json::{Map, Value};

use crate::config::Config;

/// Field that a line of a sample has.
pub(super) const MARK: &str = "time_of_measurement_ns";
/// Largest distance between a position and the stated latitude and longitude, metres.
const APART_MAX_M: f64 = 1.0;
const METRES_PER_DEGREE: f64 = 111_320.0;

/// Reader of lines of `koseki tap`.
#[derive(Debug)]
pub(super) struct TappedLines {
    tracks: LineReader,
    states: LineReader,
    detections: LineReader,
    frame: SystemFrame,
    /// Number of the fed deployment for the exchange of tracks, and the identities of its sensors.
    origin: u32,
    uids: Vec<u32>,
}

impl TappedLines {
    pub(super) fn of(config: &Config) -> Self {
        let names = config.sources.iter().map(|source| source.name.clone()).collect();
        let uids = config.sources.iter().map(|source| source.uid).collect();
        Self::new(names, config.frame, (config.origin, uids))
    }

    /// Lines for a deployment with sources of these names.
    pub(super) fn new(names: Vec<String>, frame: SystemFrame, (origin, uids): (u32, Vec<u32>)) -> Self {
        let reader = |layout: &'static Layout| LineReader::new(layout, names.clone());
        Self {
            tracks: reader(&SensorTrack::LAYOUT),
            states: reader(&SystemTrack::LAYOUT),
            detections: reader(&SensorDetection::LAYOUT),
            frame,
            origin,
            uids,
        }
    }

    /// The report of `source` in a line of a sensor track or of a system track.
    pub(super) fn track(&self, line: &Map<String, Value>, source: u16) -> Result<SensorTrack, Fault> {
        if !line.contains_key("reference_time_ns") {
            let mut track: SensorTrack = read(&self.tracks, line)?;
            nothing_unknown(&mut track.position_m, &mut track.velocity_mps);
            self.check_frame(line, track.position_m)?;
            return Ok(SensorTrack { source, ..track });
        }
        let mut state: SystemTrack = read(&self.states, line)?;
        nothing_unknown(&mut state.position_m, &mut state.velocity_mps);
        self.check_frame(line, state.position_m)?;
        SensorTrack::of_centre(&state, source, self.origin, &self.uids).ok_or_else(|| {
            let remedy = "feed the tracks of another deployment, or those of one sensor";
            fault(
                "origin",
                state.origin,
                "is the fed deployment: it would report its own tracks to itself",
                remedy,
            )
        })
    }

    /// The detection in a line of a detection.
    pub(super) fn detection(&self, line: &Map<String, Value>) -> Result<SensorDetection, Fault> {
        let detection = read(&self.detections, line)?;
        Ok(SensorDetection { source: 0, ..detection })
    }

    fn check_frame(&self, line: &Map<String, Value>, position_m: [f64; 3]) -> Result<(), Fault> {
        let stated = ["latitude", "longitude", "height_m"].map(|name| line.get(name).and_then(Value::as_f64));
        let [Some(latitude), Some(longitude), height_m] = stated else {
            return Ok(());
        };
        let here = self.frame.to_geodetic(position_m);
        let height_m = height_m.unwrap_or(here.height_m());
        let across = (longitude - here.longitude_deg() + 540.0).rem_euclid(360.0) - 180.0;
        let along_deg = (latitude - here.latitude_deg()).hypot(across * latitude.to_radians().cos());
        if (along_deg * METRES_PER_DEGREE).hypot(height_m - here.height_m()) <= APART_MAX_M {
            return Ok(());
        }
        let limit = "must be the place of position_m in the system frame of the fed deployment";
        let remedy = "the frames differ: leave position_m and latitude to lines in degrees, or use a link";
        Err(fault("latitude", latitude, limit, remedy))
    }
}

/// Puts 0 in place of a height and of components of a velocity that a line has as `null`; the bits of the sample mark
/// the known values.
fn nothing_unknown([_, _, up_m]: &mut [f64; 3], velocity_mps: &mut [f64; 3]) {
    for value in velocity_mps.iter_mut().chain([up_m]).filter(|value| value.is_nan()) {
        *value = 0.0;
    }
}

fn read<T: Sample + Default>(reader: &LineReader, line: &Map<String, Value>) -> Result<T, Fault> {
    let mut octets = T::octets(&[T::default()]).to_vec();
    reader.read(line, &mut octets)?;
    Ok(T::of_octets(&octets).unwrap_or_default())
}

#[cfg(test)]
#[path = "tapped_tests.rs"]
mod tests;

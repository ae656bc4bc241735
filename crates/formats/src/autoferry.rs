//! The Autoferry data set: a ferry in a harbour with lidar, radar and two cameras, and two targets with satellite
//! receivers.
//!
//! One of the few public recordings of detections, rather than tracks, with known truth (Helgesen and others,
//! "Heterogeneous multi-sensor tracking for an autonomous surface vehicle in a littoral environment", Ocean Engineering
//! 252, 2022). Each scenario is a JSON list of scans and, in a second file, one list of true positions per scan, joined
//! by their place.
//!
//! The measurement of a scan has several shapes. A camera gives bearings: a list, an empty list, or a number for a
//! single bearing. Lidar and radar give positions: an empty list, a flat list (north, east) for a single position,
//! and for several positions a list of all norths followed by a list of all easts. Positions are relative to the
//! ferry, with axes to north and east; the ferry's own position is added. Bearings are clockwise from north.
//! Detections interpreted in this way are within metres of the true positions.
//!
//! Scans are in the order of the recording, which in some scenarios is not the order of their times: processing of a
//! camera's image takes longer than a radar's turn. The order is kept, so that the data set also tests late
//! detections. Times are seconds since 1970 as floating-point numbers with seven decimals, accurate to a microsecond.

use std::fmt;

use serde::Deserialize;
use serde_json::Value;
use thiserror::Error;

use observations::{Detection, DetectionKind, DetectionPlatform, Quantity, TransponderReply};

/// Latitude and longitude (degrees) and height above the ellipsoid (metres) of the point from which positions count.
pub const ORIGIN: [f64; 3] = [63.438_902_908_3, 10.399_082_78, 39.923];

/// Latest accepted time, seconds since 1970: the range of nanoseconds in 64 bits.
const TIME_MAX_S: f64 = 9.2e9;
/// Characters of a value that an error shows.
const SHOWN_MAX: usize = 60;

/// A sensor on the ferry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FerrySensor {
    /// Positions in the plane.
    Lidar,
    /// Positions in the plane.
    Radar,
    /// Bearings.
    InfraredCamera,
    /// Bearings.
    Camera,
}

/// A turn or an image of a sensor, with or without detections.
#[derive(Clone, Debug, PartialEq)]
pub struct FerryScan {
    /// Sensor that made it.
    pub sensor: FerrySensor,
    /// Number among the scans of its sensor, from 0.
    pub number: u32,
    /// Time of measurement, UTC, nanoseconds since 1970.
    pub time_of_measurement_ns: i64,
    /// Position of the ferry, metres east, north and up of the origin.
    pub platform_m: [f64; 3],
    /// Detections; the data set states no standard deviations.
    pub detections: Vec<Detection>,
    /// Positions of the targets, as last known then.
    pub truth: Vec<TruePosition>,
}

/// Position of a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruePosition {
    /// The target.
    pub target_id: u32,
    /// Time of the position, UTC, nanoseconds since 1970; some hundredths of a second from the time of the scan.
    pub time_ns: i64,
    /// Metres east, north and up of the origin.
    pub position_m: [f64; 3],
}

/// Why a scenario cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AutoferryError {
    /// A file is no JSON, or lacks a field.
    #[error("{file}: {reason}")]
    Json {
        /// Name of the file: one of two.
        file: &'static str,
        /// Fault, with line and column.
        reason: serde_json::Error,
    },

    /// A value is invalid for its field.
    #[error("{file}, entry {entry}, {field}: {value} {reason}")]
    Value {
        /// Name of the file: one of two.
        file: &'static str,
        /// Place in the list, from 0.
        entry: usize,
        /// The field.
        field: &'static str,
        /// The value, or its beginning.
        value: String,
        /// Fault of the value, and the permitted values.
        reason: &'static str,
    },

    /// The files do not belong together.
    #[error("{scans} scans, but true positions for {truths}; take both files of one scenario")]
    Lengths {
        /// Scans in the file of detections.
        scans: usize,
        /// Entries in the file of true positions.
        truths: usize,
    },
}

const DETECTIONS: &str = "detections";
const TRUTH: &str = "ground truth";

#[derive(Deserialize)]
struct RawScan {
    #[serde(rename = "sensorID")]
    sensor: u32,
    #[serde(rename = "ownshipPosition")]
    own_north_east_m: [f64; 2],
    #[serde(rename = "time")]
    time_s: f64,
    measurement: Value,
}

#[derive(Deserialize)]
struct RawTruth {
    #[serde(rename = "targetID")]
    target_id: u32,
    #[serde(rename = "position")]
    north_east_down_m: [f64; 3],
    #[serde(rename = "time")]
    time_s: f64,
}

/// Reads a scenario from the contents of its two files, in the order of recording.
///
/// # Errors
/// [`AutoferryError`] at the first invalid value.
pub fn read(detections: &[u8], ground_truth: &[u8]) -> Result<Vec<FerryScan>, AutoferryError> {
    let mut scans = read_detections(detections)?;
    let truths: Vec<Vec<RawTruth>> = parse(TRUTH, ground_truth)?;
    if scans.len() != truths.len() {
        return Err(AutoferryError::Lengths {
            scans: scans.len(),
            truths: truths.len(),
        });
    }
    for (entry, (scan, truths)) in scans.iter_mut().zip(&truths).enumerate() {
        scan.truth = truths.iter().map(|truth| truth.read(entry)).collect::<Result<_, _>>()?;
    }
    Ok(scans)
}

/// Reads the detections of a scenario alone, in the order of recording; the scans have no truth then.
///
/// # Errors
/// [`AutoferryError`] at the first invalid value.
pub fn read_detections(detections: &[u8]) -> Result<Vec<FerryScan>, AutoferryError> {
    let scans: Vec<RawScan> = parse(DETECTIONS, detections)?;
    let mut next_numbers = [0; FerrySensor::ALL.len()];
    let scans = scans.iter().enumerate();
    scans
        .map(|(entry, scan)| {
            let sensor = FerrySensor::from_id(scan.sensor)
                .ok_or_else(|| fault(DETECTIONS, entry, "sensorID", scan.sensor, "is no sensor; 1 to 4 are"))?;
            let number = next_numbers[sensor as usize];
            next_numbers[sensor as usize] += 1;
            scan.read(entry, sensor, number)
        })
        .collect()
}

impl FerrySensor {
    /// Every sensor, in the order of its number.
    pub const ALL: [Self; 4] = [Self::Lidar, Self::Radar, Self::InfraredCamera, Self::Camera];

    /// The data set's number of the sensor, from 1.
    pub fn id(self) -> u32 {
        self as u32 + 1
    }

    fn from_id(id: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|sensor| sensor.id() == id)
    }
}

impl RawScan {
    fn read(&self, entry: usize, sensor: FerrySensor, number: u32) -> Result<FerryScan, AutoferryError> {
        let time_ns = time_ns(self.time_s).ok_or_else(|| fault(DETECTIONS, entry, "time", self.time_s, NO_TIME))?;
        let [own_north_m, own_east_m] = self.own_north_east_m;
        let platform_m = [own_east_m, own_north_m, 0.0];
        let (kind, values) = match sensor {
            FerrySensor::Lidar | FerrySensor::Radar => {
                let absolute = |[north_m, east_m]: [f64; 2]| [own_east_m + east_m, own_north_m + north_m, 0.0];
                let positions = positions(&self.measurement)
                    .ok_or_else(|| fault(DETECTIONS, entry, "measurement", &self.measurement, NO_POSITIONS))?;
                (DetectionKind::Position2, positions.into_iter().map(absolute).collect())
            }
            FerrySensor::InfraredCamera | FerrySensor::Camera => {
                let bearings = bearings(&self.measurement)
                    .ok_or_else(|| fault(DETECTIONS, entry, "measurement", &self.measurement, NO_BEARINGS))?;
                let values: Vec<_> = bearings.into_iter().map(|bearing| [bearing, 0.0, 0.0]).collect();
                (DetectionKind::Bearing, values)
            }
        };
        let detection = |(place, values): (usize, [f64; 3])| Detection {
            time_of_measurement_ns: time_ns,
            sensor_id: sensor.id(),
            scan: number,
            detection_id: place as u32,
            kind,
            values,
            range_rate_mps: None,
            sigmas: None,
            platform_m,
            platform: DetectionPlatform::default(),
            height: None,
            velocity: None,
            reply: TransponderReply::default(),
            truth: None,
        };
        Ok(FerryScan {
            sensor,
            number,
            time_of_measurement_ns: time_ns,
            platform_m,
            detections: values.into_iter().enumerate().map(detection).collect(),
            truth: Vec::new(),
        })
    }
}

impl RawTruth {
    fn read(&self, entry: usize) -> Result<TruePosition, AutoferryError> {
        let [north_m, east_m, down_m] = self.north_east_down_m;
        Ok(TruePosition {
            target_id: self.target_id,
            time_ns: time_ns(self.time_s).ok_or_else(|| fault(TRUTH, entry, "time", self.time_s, NO_TIME))?,
            position_m: [east_m, north_m, 0.0 - down_m],
        })
    }
}

const NO_TIME: &str = "is no time in seconds since 1970";
const NO_POSITIONS: &str =
    "is neither an empty list, nor one position [north, east], nor as many norths as easts [[…], […]]";
const NO_BEARINGS: &str = "is neither a bearing in radians nor a list of them";

/// Returns norths and easts, for any shape of the measurement.
fn positions(measurement: &Value) -> Option<Vec<[f64; 2]>> {
    let rows = measurement.as_array()?;
    match &rows[..] {
        [] => Some(Vec::new()),
        [Value::Array(norths), Value::Array(easts)] if norths.len() == easts.len() => {
            let pairs = norths.iter().zip(easts);
            pairs
                .map(|(north, east)| Some([north.as_f64()?, east.as_f64()?]))
                .collect()
        }
        [north, east] => Some(vec![[north.as_f64()?, east.as_f64()?]]),
        _ => None,
    }
}

/// Returns bearings, for any shape of the measurement.
fn bearings(measurement: &Value) -> Option<Vec<f64>> {
    let bearing = |value: &Value| value.as_f64().filter(|value| Quantity::Bearing.fault(*value).is_none());
    match measurement {
        Value::Array(list) => list.iter().map(bearing).collect(),
        single => Some(vec![bearing(single)?]),
    }
}

fn time_ns(seconds: f64) -> Option<i64> {
    (0.0..=TIME_MAX_S).contains(&seconds).then(|| frames::time::ns(seconds))
}

fn parse<'a, T: Deserialize<'a>>(file: &'static str, json: &'a [u8]) -> Result<T, AutoferryError> {
    serde_json::from_slice(json).map_err(|reason| AutoferryError::Json { file, reason })
}

fn fault(
    file: &'static str,
    entry: usize,
    field: &'static str,
    value: impl fmt::Display,
    reason: &'static str,
) -> AutoferryError {
    let value = value.to_string();
    AutoferryError::Value {
        file,
        entry,
        field,
        value: match value.char_indices().nth(SHOWN_MAX) {
            Some((end, _)) => format!("{}…", &value[..end]),
            None => value,
        },
        reason,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTHS: &str = r#"[{"targetID": 1, "position": [100.0, -50.5, 2], "time": 1.5E+9}]"#;

    fn scan(sensor: u32, measurement: &str) -> Result<FerryScan, String> {
        let detections = format!(
            r#"[{{"sensorID": {sensor}, "measurements": [], "ownshipPosition": [-10, 20.5],
                 "time": 1.50000000025E+9, "measurement": {measurement}}}]"#
        );
        let scans = read(detections.as_bytes(), format!("[{TRUTHS}]").as_bytes());
        scans
            .map(|mut scans| scans.remove(0))
            .map_err(|error| error.to_string())
    }

    fn values(sensor: u32, measurement: &str) -> Vec<[f64; 3]> {
        let scan = scan(sensor, measurement).unwrap();
        scan.detections.iter().map(|detection| detection.values).collect()
    }

    #[test]
    fn positions_have_three_shapes_and_count_from_the_ferry() {
        assert!(values(1, "[]").is_empty());
        assert_eq!(values(1, "[3, 4]"), [[24.5, -7.0, 0.0]]);
        let three = [[24.5, -7.0, 0.0], [25.5, -6.0, 0.0], [26.5, -5.0, 0.0]];
        assert_eq!(values(2, "[[3, 4, 5], [4, 5, 6]]"), three);
        assert_eq!(values(2, "[[3, 4], [4, 5]]"), three[..2], "norths, then easts");
        assert_eq!(values(2, "[[3], [4]]"), three[..1]);
    }

    #[test]
    fn bearings_have_three_shapes_and_count_from_north() {
        assert!(values(3, "[]").is_empty());
        assert_eq!(values(3, "-2.5"), [[-2.5, 0.0, 0.0]]);
        assert_eq!(values(4, "[0.5, 1.25]"), [[0.5, 0.0, 0.0], [1.25, 0.0, 0.0]]);
    }

    #[test]
    fn a_scan_knows_its_time_platform_and_truth() {
        let scan = scan(4, "[0.5, 1.25]").unwrap();
        assert_eq!((scan.sensor, scan.number), (FerrySensor::Camera, 0));
        assert_eq!(scan.platform_m, [20.5, -10.0, 0.0], "east, north");
        assert!((scan.time_of_measurement_ns - 1_500_000_000_250_000_000).abs() < 1_000);
        let second = scan.detections[1];
        assert_eq!(second.time_of_measurement_ns, scan.time_of_measurement_ns);
        assert_eq!((second.sensor_id, second.scan, second.detection_id), (4, 0, 1));
        assert_eq!(
            (second.kind, second.platform_m),
            (DetectionKind::Bearing, scan.platform_m)
        );
        assert_eq!((second.sigmas, second.truth), (None, None));
        let truth = TruePosition {
            target_id: 1,
            time_ns: 1_500_000_000_000_000_000,
            position_m: [-50.5, 100.0, -2.0],
        };
        assert_eq!(scan.truth, [truth]);
    }

    #[test]
    fn scans_are_numbered_per_sensor() {
        let one = |sensor: u32| {
            format!(r#"{{"sensorID": {sensor}, "ownshipPosition": [0, 0], "time": 1, "measurement": []}}"#)
        };
        let detections = format!("[{}, {}, {}, {}]", one(1), one(3), one(3), one(1));
        let scans = read(detections.as_bytes(), b"[[], [], [], []]").unwrap();
        let numbers: Vec<_> = scans.iter().map(|scan| (scan.sensor.id(), scan.number)).collect();
        assert_eq!(numbers, [(1, 0), (3, 0), (3, 1), (1, 1)]);
    }

    #[test]
    fn what_cannot_be_meant_is_refused_with_place_and_remedy() {
        for (sensor, measurement, expected) in [
            (5, "[]", "detections, entry 0, sensorID: 5 is no sensor; 1 to 4 are"),
            (
                1,
                "3",
                "entry 0, measurement: 3 is neither an empty list, nor one position",
            ),
            (1, "[1, 2, 3]", "measurement: [1,2,3] is neither"),
            (1, "[[1, 2], [3]]", "measurement: [[1,2],[3]] is neither"),
            (2, "[[1, null], [3, 4]]", "measurement: [[1,null],[3,4]] is neither"),
            (2, "[1, [2]]", "measurement: [1,[2]] is neither"),
            (3, "[[0.5]]", "measurement: [[0.5]] is neither a bearing in radians"),
            (3, "270", "measurement: 270 is neither a bearing in radians"),
            (4, "null", "measurement: null is neither a bearing in radians"),
            (1, "[", "detections: expected value at line 2"),
        ] {
            let error = scan(sensor, measurement).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
        let long = scan(3, &format!("[{}null]", "0.5,".repeat(100))).unwrap_err();
        assert!(long.len() < 200 && long.contains('…'), "{long}");
    }

    #[test]
    fn files_that_do_not_belong_together_are_refused() {
        let error = read(b"[]", b"[[]]").unwrap_err().to_string();
        assert!(error.starts_with("0 scans, but true positions for 1"), "{error}");
        let error = read(b"[]", br#"[[{"targetID": 1, "time": 0}]]"#)
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("ground truth: missing field `position` at line 1"),
            "{error}"
        );
        let detections = r#"[{"sensorID": 1, "ownshipPosition": [0, 0], "time": 1, "measurement": []}]"#;
        let truth = TRUTHS.replace("1.5E+9", "1.5E+12");
        let error = read(detections.as_bytes(), format!("[{truth}]").as_bytes())
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("ground truth, entry 0, time: 1500000000000 is no time"),
            "{error}"
        );
    }
}

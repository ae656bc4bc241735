//! Detections in the tracker's form, and the test of a scan's detections for usability.

use observations::{Detection, StatedVelocity};

use crate::counts::TrackerCounts;
use crate::identity::PlotIdentity;
use crate::measurement::DetectionMeasurement;
use crate::selection::Selection;
use crate::settings::SensorFacts;

/// Largest difference of a detection's time from that of the scan, nanoseconds.
const SCAN_HALF_NS: u64 = 60_000_000_000;

/// A detection in the form kept by the tracker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plot {
    pub(crate) time_ns: i64,
    pub(crate) detection_id: u32,
    pub(crate) measurement: DetectionMeasurement,
    /// Logarithm of the weight (WA-1): 0 for nearly all detections.
    pub(crate) log_weight: f64,
    pub(crate) identity: PlotIdentity,
    /// Velocity of a designated target.
    pub(crate) velocity: Option<StatedVelocity>,
}

/// Use of a detection in a cluster, if other clusters may have the detection, too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SharedPlot {
    /// Logarithm of the likelihood that the detection is false or of another cluster, relative to false.
    pub(crate) log_others: f64,
    /// Whether a new track may start at the detection: in a single cluster alone.
    pub(crate) may_start: bool,
}

impl SharedPlot {
    pub(crate) const OWN: Self = Self {
        log_others: 0.0,
        may_start: true,
    };
}

/// A scan in the form kept by the tracker.
#[derive(Clone, Debug)]
pub(crate) struct Scan {
    pub(crate) time_ns: i64,
    /// Place of the sensor in the settings.
    pub(crate) sensor: usize,
    pub(crate) plots: Vec<Plot>,
}

/// Takes over the usable detections.
pub(crate) fn admit(
    detections: &[Detection],
    [time_ns, latest_ns]: [i64; 2],
    sensor: &SensorFacts,
    selection: &Selection,
    plots: &mut Vec<Plot>,
    counts: &mut TrackerCounts,
) {
    plots.clear();
    for detection in detections {
        let near = detection.time_of_measurement_ns.abs_diff(time_ns) <= SCAN_HALF_NS;
        let Some(measurement) = DetectionMeasurement::of(detection, sensor.default_sigmas()).filter(|_| near) else {
            counts.rejected_detections += 1;
            continue;
        };
        if plots.len() == plots.capacity() {
            counts.dropped_detections += 1;
            continue;
        }
        let age_ns = latest_ns.saturating_sub(detection.time_of_measurement_ns);
        let is_refused = selection.rejects(&measurement, age_ns);
        counts.deselected_detections += u64::from(is_refused);
        let log_weight = match selection.log_kept_weight() {
            _ if !is_refused => 0.0,
            Some(log_weight) => log_weight,
            None => continue,
        };
        counts.detections += 1;
        plots.push(Plot {
            time_ns: detection.time_of_measurement_ns,
            detection_id: detection.detection_id,
            measurement,
            log_weight,
            identity: PlotIdentity::of(
                &detection.reply,
                detection.time_of_measurement_ns,
                measurement.has_height(),
            ),
            velocity: detection.velocity,
        });
    }
}

//! Model of a sensor: detection probability and weight of scans.
//!
//! The obvious reading of a probability of detection of 0.9 is that five misses in a row happen to a target once in a
//! hundred thousand times. That holds for a radar that turns once in four seconds. A camera with ten images a second
//! that does not find a boat before a dark shore will not find it in the next ninety images either; taken literally,
//! these misses disprove within half a second a track that the radar has followed for minutes. The errors of a camera
//! repeat likewise: ten bearings within a second are off to the same side.
//!
//! So looks are weighed by time. Within the coherence time T a sensor that looks again sees the same thing again; a
//! scan that follows the sensor's previous one after t < T is worth w = t / T of an independent scan. The likelihood of
//! the scan enters with the power w: a miss counts for w·ln(1 − P), and standard deviations are those of w independent
//! measurements, σ/√w. A sensor that is slower than T is not affected. Which detection belongs to which track is
//! decided with the full likelihood: that is a question within one scan.
//!
//! A miss counts for less, too, the less likely the target is in the field of view ([`crate::field_of_view`]).

use std::f64::consts::TAU;

use estimation::Gaussian;
use messages::NS_PER_S;

use crate::clutter::{ClutterEstimate, SensorArea};
use crate::detection_rate::{DetectionRate, PRIOR};
use crate::field_of_view::FieldOfView;
use crate::identity::FAR;
use crate::measurement::{DIMENSIONS_MAX, MeasurementInnovation};
use crate::motion::MotionSettings;
use crate::plot::Plot;
use crate::resolution_cell::ResolutionCell;
use crate::settings::{SensorFacts, Settings};

/// Smallest weight of a scan: several scans at one time must keep some weight.
const WEIGHT_MIN: f64 = 1e-3;

/// Settings of a sensor, and the known properties of the current scan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sensor {
    /// Bit of the sensor in [`crate::track::Track::seen_by`]; sensors beyond 64 have none.
    pub(crate) bit: u64,
    pub(crate) gates: [f64; DIMENSIONS_MAX],
    pub(crate) motion: MotionSettings,
    pub(crate) detection_probability: f64,
    /// Logarithm of that probability.
    pub(crate) log_detection: f64,
    gate_probability: f64,
    /// Whether the probability is learned.
    pub(crate) learns: bool,
    pub(crate) field_of_view: Option<FieldOfView>,
    coherence_s: f64,
    /// Weight of the scan at hand relative to an independent scan, above 0, at most 1.
    pub(crate) scan_weight: f64,
    /// Position of the sensor at the scan at hand, east and north, metres; `None` if not known.
    pub(crate) platform_m: Option<[f64; 2]>,
    pub(crate) cell: Option<ResolutionCell>,
}

/// State of a sensor that is carried from scan to scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SensorMemory {
    pub(crate) clutter: ClutterEstimate,
    pub(crate) rate: DetectionRate,
    /// Time of the previous scan, nanoseconds.
    time_ns: Option<i64>,
    /// Position of the sensor at the latest detection, east and north, metres.
    platform_m: Option<[f64; 2]>,
    /// Whether the latest scan with detections had directions only.
    directions_only: bool,
}

impl SensorMemory {
    pub(crate) const NONE: Self = Self {
        clutter: ClutterEstimate::NONE,
        rate: DetectionRate::NONE,
        time_ns: None,
        platform_m: None,
        directions_only: false,
    };

    /// Returns whether a sensor with the field of view `view` sees a place; without a field of view, it sees all.
    pub(crate) fn sees(&self, view: Option<&FieldOfView>, place_m: [f64; 2]) -> bool {
        view.is_none_or(|view| view.contains(place_m, self.platform_m))
    }

    /// Probability that a sensor with the field of view `view` sees a target; without a field of view, it sees all.
    pub(crate) fn covers(&self, view: Option<&FieldOfView>, predicted: &Gaussian) -> f64 {
        view.map_or(1.0, |view| view.holds(predicted, self.platform_m))
    }

    /// Returns whether a scan is of directions without ranges; an empty scan is like the scan before.
    pub(crate) fn sees_directions_only(&self) -> bool {
        self.directions_only
    }
}

impl Sensor {
    pub(crate) fn new(sensor: &SensorFacts, settings: &Settings, gates: [f64; DIMENSIONS_MAX]) -> Self {
        Self {
            bit: 0,
            gates,
            motion: settings.motion,
            detection_probability: sensor.model.detection_probability.unwrap_or(PRIOR),
            log_detection: sensor.model.detection_probability.unwrap_or(PRIOR).ln(),
            learns: sensor.model.detection_probability.is_none(),
            gate_probability: settings.gate.probability,
            field_of_view: sensor.model.field_of_view,
            coherence_s: settings.deletion.coherence_s,
            scan_weight: 1.0,
            platform_m: None,
            cell: sensor.model.resolution_cell,
        }
    }

    /// The sensor in this place of the settings.
    pub(crate) fn in_place(self, place: usize) -> Self {
        let bit = u32::try_from(place).ok().and_then(|place| 1_u64.checked_shl(place));
        Self {
            bit: bit.unwrap_or(0),
            ..self
        }
    }

    /// The sensor at a scan, which is remembered.
    pub(crate) fn at(&self, time_ns: i64, plots: &[Plot], memory: &mut SensorMemory) -> Self {
        let since_s = memory
            .time_ns
            .map(|before| time_ns.saturating_sub(before) as f64 / NS_PER_S);
        memory.time_ns = Some(time_ns);
        if let Some(plot) = plots.last() {
            let [east, north, _] = plot.measurement.platform_m;
            memory.platform_m = Some([east, north]);
            memory.directions_only = plots.iter().all(|plot| plot.measurement.place().is_none());
        }
        let scan_weight = since_s.map_or(1.0, |since_s| (since_s / self.coherence_s).clamp(WEIGHT_MIN, 1.0));
        let learned = self.learns && !memory.directions_only;
        let detection_probability = if learned {
            memory.rate.probability()
        } else {
            self.detection_probability
        };
        Self {
            scan_weight,
            detection_probability,
            log_detection: detection_probability.ln(),
            platform_m: memory.platform_m,
            ..*self
        }
    }

    /// Area that the sensor covers.
    pub(crate) fn extent(&self) -> SensorArea {
        let view = self.field_of_view;
        SensorArea {
            width_rad: view.map_or(TAU, |view| view.width_rad()),
            area_m2: view.map(|view| view.area_m2()).filter(|area| area.is_finite()),
        }
    }

    /// Probability that a target is in the field of view.
    pub(crate) fn probability_in_view(&self, predicted: &Gaussian) -> f64 {
        let seen = |view: &FieldOfView| view.holds(predicted, self.platform_m);
        self.field_of_view.as_ref().map_or(1.0, seen)
    }

    /// Probability of no detection in the gate.
    pub(crate) fn miss(&self, seen: f64) -> f64 {
        1.0 - seen * self.detection_probability * self.gate_probability
    }

    /// Logarithm of the density of a detection that names the target, and whether it lies outside the gate; `None` if
    /// farther away than such detections lie ([`crate::identity`]). A detection in the gate was not compared if
    /// unusually far out: the search is for two quantities.
    pub(crate) fn log_far(&self, innovation: &MeasurementInnovation) -> Option<(f64, bool)> {
        let gate = self.gates[innovation.dimension - 1];
        let distance = innovation.squared_distance;
        if distance <= gate {
            return Some((innovation.log_likelihood, false));
        }
        // Written so that NaN is refused.
        if !(gate..=FAR * FAR * gate).contains(&distance) {
            return None;
        }
        let wider = 0.5 * distance * (1.0 - 1.0 / (FAR * FAR)) - innovation.dimension as f64 * FAR.ln();
        let outside = (1.0 - self.gate_probability).ln();
        Some((innovation.log_likelihood + wider + outside, true))
    }

    /// Logarithm of that probability, to the power of the scan's weight: of a target that the sensor's look before did
    /// not find either.
    pub(crate) fn log_miss(&self, seen: f64) -> f64 {
        self.scan_weight * (-seen * self.detection_probability * self.gate_probability).ln_1p()
    }

    /// The probability with this logarithm, computed with less effort where looks are independent.
    pub(crate) fn silence(&self, seen: f64, log_miss: f64) -> f64 {
        if self.scan_weight >= 1.0 {
            self.miss(seen)
        } else {
            log_miss.exp()
        }
    }

    /// Logarithm of the probability of no detection in the gate of a target that the sensor's look before found. A
    /// target found a moment ago is found again, all the more the less time has passed; otherwise two tracks could take
    /// the detections of the same target in turn.
    pub(crate) fn log_lapse(&self, seen: f64) -> f64 {
        if self.scan_weight >= 1.0 {
            return self.log_miss(seen);
        }
        (1.0 - seen + seen * self.scan_weight * self.miss(1.0)).ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identity::PlotIdentity;
    use crate::measurement::DetectionMeasurement;
    use crate::testing::{S, position, settings};

    fn plot(platform_m: [f64; 3]) -> Plot {
        let mut detection = position(0, 5.0, 6.0);
        detection.platform_m = platform_m;
        Plot {
            time_ns: 0,
            detection_id: 0,
            log_weight: 0.0,
            identity: PlotIdentity::NONE,
            velocity: None,
            measurement: DetectionMeasurement::of(&detection, None).unwrap(),
        }
    }

    #[test]
    fn looks_are_worth_the_time_between_them() {
        let settings = settings();
        let sensor = Sensor::new(&settings.sensors[0], &settings, [9.21; 4]);
        let mut memory = SensorMemory::NONE;
        let mut weight = |time_ns| sensor.at(time_ns, &[], &mut memory).scan_weight;
        assert_eq!(weight(0), 1.0, "the first look");
        assert_eq!(weight(4 * S), 1.0, "a slow one");
        assert_eq!(weight(4 * S + S / 10), 0.1);
        assert_eq!(weight(4 * S + S / 10), WEIGHT_MIN);
        // Ten quick misses count as a single miss.
        let quick: f64 = (1..=10)
            .map(|k| {
                let sensor = sensor.at(4 * S + S / 10 + k * S / 10, &[], &mut memory);
                sensor.log_miss(1.0)
            })
            .sum();
        assert!((quick - sensor.log_miss(1.0)).abs() < 1e-9);
        assert!((sensor.log_miss(1.0) - (1.0f64 - 0.9 * 0.99).ln()).abs() < 1e-12);
        assert_eq!((sensor.log_miss(0.0), sensor.miss(0.0)), (0.0, 1.0));
    }

    #[test]
    fn a_moving_sensor_looks_from_where_it_was_last() {
        let mut settings = settings();
        settings.sensors[0].model.field_of_view = Some(FieldOfView {
            range_m: [0.0, 100.0],
            sector_deg: None,
            position_m: None,
        });
        let sensor = Sensor::new(&settings.sensors[0], &settings, [9.21; 4]);
        let mut memory = SensorMemory::NONE;
        let near = Gaussian {
            mean: [1050.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            covariance: messages::Covariance::diagonal([1.0; 3], [1.0; 3]),
        };
        assert_eq!(
            sensor.at(0, &[], &mut memory).probability_in_view(&near),
            0.0,
            "nobody knows"
        );
        assert!(
            sensor
                .at(S, &[plot([1000.0, 0.0, 0.0])], &mut memory)
                .probability_in_view(&near)
                > 0.999
        );
        assert!(
            sensor.at(2 * S, &[], &mut memory).probability_in_view(&near) > 0.999,
            "nothing was seen"
        );
        assert!(
            sensor
                .at(3 * S, &[plot([900.0, 0.0, 0.0])], &mut memory)
                .probability_in_view(&near)
                < 1e-3
        );
    }
}

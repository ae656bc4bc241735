//! Number of targets that a wide-area sensor has seen (WA-2).
//!
//! The user of a report judges its plausibility.

use messages::{StageTimes, WideArea, wide_area_bits};

use crate::{Sampled, flag};

/// Number of targets around a place (WA-2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WideAreaReport {
    /// Time of observation, nanoseconds.
    pub time_ns: i64,
    /// Time of arrival, nanoseconds.
    pub arrival_ns: i64,
    /// East, north, up at the time of observation, metres.
    pub position_m: [f64; 3],
    /// Metres per second.
    pub velocity_mps: [f64; 3],
    /// Number of targets; 0 reports their absence.
    pub targets: u32,
    /// Origin of the targets, east and north in metres, if that is known.
    pub origin_m: Option<[f64; 2]>,
}

impl Sampled for WideAreaReport {
    type Sample = WideArea;

    fn sample(&self, source: u16, stages: StageTimes) -> WideArea {
        WideArea {
            time_of_observation_ns: self.time_ns,
            arrival_ns: self.arrival_ns,
            stages,
            position_m: self.position_m,
            velocity_mps: self.velocity_mps,
            origin_m: self.origin_m.unwrap_or_default(),
            targets: self.targets,
            sensor: source,
            valid: flag(self.origin_m.is_some(), wide_area_bits::ORIGIN),
            ..WideArea::default()
        }
    }

    fn of_sample(sample: &WideArea) -> Option<Self> {
        Some(Self {
            time_ns: sample.time_of_observation_ns,
            arrival_ns: sample.arrival_ns,
            position_m: sample.position_m,
            velocity_mps: sample.velocity_mps,
            targets: sample.targets,
            origin_m: (sample.valid & wide_area_bits::ORIGIN != 0).then_some(sample.origin_m),
        })
    }
}

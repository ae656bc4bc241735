//! Which detections of on-board sensors are used at all (WA-1).
//!
//! Old, inaccurate or second-best detections seldom improve a track, and cost as much as others. They may be refused by
//! their age, by their accuracy, or by the priority of their sensor where several look at the same time. Or they are kept,
//! but what is concluded from them weighs less: with a weight of 0 no hypothesis takes them for a target; with a small one
//! those that do are less reliable and so the first to be dropped.
//!
//! A scan that is outranked and whose detections are refused counts as no look at all: it is nobody's miss.

use crate::measurement::Measurement;

/// Refusals, all off by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Detections that are so much older than the latest scan are refused, nanoseconds.
    pub age_max_ns: Option<i64>,
    /// Detections whose place has a larger standard deviation in some direction are refused, metres. Directions alone have
    /// no place.
    pub sigma_max_m: Option<f64>,
    /// (sensor, priority): of scans at the same time only those of the highest priority are used. Sensors that are not
    /// named have priority 0. Scans are compared while they are open.
    pub priorities: Vec<(u32, u32)>,
    /// How far apart scans are at the same time, nanoseconds.
    pub same_time_ns: i64,
    /// Refused detections are used with this weight, in [0, 1), instead of not at all.
    pub kept_weight: Option<f64>,
}

impl Selection {
    /// What is wrong with the settings; `None` if nothing is.
    pub fn fault(&self) -> Option<&'static str> {
        let checks = [
            (
                self.age_max_ns.is_none_or(|age_ns| age_ns >= 0) && self.same_time_ns >= 0,
                "ages and times between scans must not be negative",
            ),
            (
                self.sigma_max_m.is_none_or(|sigma_m| sigma_m > 0.0),
                "the largest standard deviation must be positive",
            ),
            (
                self.kept_weight.is_none_or(|weight| (0.0..1.0).contains(&weight)),
                "the weight of refused detections must be at least 0 and below 1",
            ),
            (
                self.priorities.iter().enumerate().all(|(place, (sensor, _))| {
                    let before = &self.priorities[..place];
                    before.iter().all(|(other, _)| other != sensor)
                }),
                "a sensor has one priority only",
            ),
        ];
        checks.iter().find(|(holds, _)| !holds).map(|(_, sentence)| *sentence)
    }

    /// Whether a detection is refused by age or accuracy.
    pub(crate) fn refuses(&self, measurement: &Measurement, age_ns: i64) -> bool {
        let too_old = self.age_max_ns.is_some_and(|age_max_ns| age_ns > age_max_ns);
        let sigma_m = measurement.place().map(|(_, sigma_m)| sigma_m);
        let too_coarse = sigma_m
            .zip(self.sigma_max_m)
            .is_some_and(|(sigma_m, most_m)| sigma_m > most_m);
        too_old || too_coarse
    }

    /// Whether a scan of `sensor` is outranked by one of `other` so long after or before it.
    pub(crate) fn outranks(&self, other: u32, sensor: u32, apart_ns: i64) -> bool {
        apart_ns.saturating_abs() <= self.same_time_ns && self.priority(other) > self.priority(sensor)
    }

    fn priority(&self, sensor: u32) -> u32 {
        let named = self.priorities.iter().find(|(number, _)| *number == sensor);
        named.map_or(0, |(_, priority)| *priority)
    }

    /// Logarithm of the weight of refused detections; `None` if they are not kept.
    pub(crate) fn log_kept_weight(&self) -> Option<f64> {
        self.kept_weight.map(f64::ln)
    }
}

//! Times of a sensor's looks at each target, and of the sensor's deliveries.
//!
//! Time is cut into *slots*, one for each delivery in a period; slot n ends with one delivery. The slot number is
//! the entire state of a sensor's clock, so a sensor can start anywhere.
//!
//! - A radar's antenna turns clockwise from north at a constant rate. The look at a target occurs when the antenna
//!   points at it, which depends on the target's position at that time. A few steps of a fixed-point iteration find
//!   the time, because a target moves little while the antenna turns by a sector.
//! - Multilateration measures at the start of the slot. With several deliveries per period, each target belongs to
//!   one delivery.
//! - ADS-B targets broadcast on individual clocks, with a random tenth of a period to either side, so that no two
//!   targets collide for ever.

use std::f64::consts::{PI, TAU};

use rand::RngExt as _;

use crate::random::{Purpose, stream};
use crate::sensor_settings::{CheckedSensor, SensorKind};

/// Iterations to find the time at which a radar's antenna points at a moving target.
const AIMING_STEPS: usize = 4;
/// Maximum deviation of a broadcast from its planned time, as a share of the period.
const BROADCAST_JITTER: f64 = 0.1;

/// Delivery interval of a sensor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slot {
    pub(crate) number: u64,
    begin_s: f64,
    end_s: f64,
}

impl Slot {
    pub(crate) fn new(number: u64, settings: &CheckedSensor) -> Self {
        let schedule = &settings.schedule;
        let deliveries = f64::from(schedule.deliveries);
        let at = |number: u64| schedule.phase_s + number as f64 * schedule.period_s / deliveries;
        Self {
            number,
            begin_s: at(number),
            end_s: at(number + 1),
        }
    }

    /// Returns the first slot whose delivery is not before `time_s`.
    pub(crate) fn first_delivered_from(time_s: f64, settings: &CheckedSensor) -> Self {
        let schedule = &settings.schedule;
        let length_s = schedule.period_s / f64::from(schedule.deliveries);
        let estimate = (time_s - schedule.phase_s - schedule.delay_s) / length_s - 2.0;
        let mut number = estimate.max(0.0) as u64;
        while Self::new(number, settings).delivered_s(settings) < time_s {
            number += 1;
        }
        Self::new(number, settings)
    }

    /// Returns the delivery time of the observations in this slot, seconds.
    pub(crate) fn delivered_s(&self, settings: &CheckedSensor) -> f64 {
        let seen_s = match settings.kind {
            SensorKind::Multilateration => self.begin_s,
            SensorKind::Radar | SensorKind::AdsB => self.end_s,
        };
        seen_s + settings.schedule.delay_s
    }

    /// Returns the start of the slot: no observation in this slot or a later slot is older.
    pub(crate) fn begin_s(&self) -> f64 {
        self.begin_s
    }

    /// Returns a time in this slot: 0 is the start, 1 the end.
    pub(crate) fn time_within_s(&self, share: f64) -> f64 {
        self.begin_s + share * (self.end_s - self.begin_s)
    }

    /// Returns the number of the period, and of the slot within it.
    pub(crate) fn period(&self, settings: &CheckedSensor) -> (u64, u64) {
        let deliveries = u64::from(settings.schedule.deliveries);
        (self.number / deliveries, self.number % deliveries)
    }

    /// Returns the time of the sensor's look at a thing in this slot, seconds; `None` without a look. `position_at`
    /// gives the position of the thing at a time. `phase` (0 to 1) gives the position of the look within each
    /// period, unless the sensor determines that position.
    pub(crate) fn look_s(
        &self,
        settings: &CheckedSensor,
        aim: &Aim,
        position_at: impl Fn(f64) -> [f64; 3],
    ) -> Option<f64> {
        match settings.kind {
            SensorKind::Radar => self.antenna_passes_s(settings, position_at),
            SensorKind::Multilateration => {
                let deliveries = u64::from(settings.schedule.deliveries);
                let turn = ((aim.phase * deliveries as f64) as u64).min(deliveries - 1);
                (turn == self.number % deliveries).then_some(self.begin_s)
            }
            SensorKind::AdsB => self.broadcast_s(settings, aim),
        }
    }

    fn antenna_passes_s(&self, settings: &CheckedSensor, position_at: impl Fn(f64) -> [f64; 3]) -> Option<f64> {
        let schedule = &settings.schedule;
        let site = settings.coverage.position_m;
        // Lag of the antenna behind the target at a time, in seconds of turning.
        let behind_s = |time_s: f64| {
            let position = position_at(time_s);
            let azimuth = (position[0] - site[0]).atan2(position[1] - site[1]);
            let antenna = TAU * ((time_s - schedule.phase_s) / schedule.period_s).fract();
            let angle = (azimuth - antenna + PI).rem_euclid(TAU) - PI;
            angle / TAU * schedule.period_s
        };
        let middle_s = 0.5 * (self.begin_s + self.end_s);
        let mut step_s = behind_s(middle_s);
        // The target is far from this sector in the middle of the slot: further steps can bring the target back
        // only very close to the radar.
        if schedule.deliveries > 4 && step_s.abs() > self.end_s - self.begin_s {
            return None;
        }
        let mut time_s = middle_s + step_s;
        for _ in 1..AIMING_STEPS {
            step_s = behind_s(time_s);
            time_s += step_s;
        }
        (self.begin_s..self.end_s).contains(&time_s).then_some(time_s)
    }

    fn broadcast_s(&self, settings: &CheckedSensor, aim: &Aim) -> Option<f64> {
        let schedule = &settings.schedule;
        // The jitter is less than a period, so only the nearest three broadcasts can fall into this slot.
        let nearest = ((self.begin_s - schedule.phase_s) / schedule.period_s - aim.phase).round();
        [-1.0, 0.0, 1.0].into_iter().find_map(|step| {
            let count = nearest + step;
            let planned_s = schedule.phase_s + (count + aim.phase) * schedule.period_s;
            let margin_s = BROADCAST_JITTER * schedule.period_s;
            if count < 0.0 || planned_s + margin_s < self.begin_s || planned_s - margin_s > self.end_s {
                return None;
            }
            let mut random = stream(aim.seed, Purpose::Broadcast, aim.source, aim.thing, count as u64);
            let time_s = planned_s + margin_s * random.random_range(-1.0..1.0);
            (self.begin_s..self.end_s).contains(&time_s).then_some(time_s)
        })
    }
}

/// Thing with a possible look in a slot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aim {
    pub(crate) seed: u64,
    pub(crate) source: u16,
    /// Number of the thing in the streams of random numbers.
    pub(crate) thing: u64,
    /// Position of the look within a period, 0 to 1.
    pub(crate) phase: f64,
}

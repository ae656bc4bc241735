//! Whether fusion and the sensors work, as health messages tell.
//!
//! A sensor works when its adapter goes on publishing reports of it. One that has published nothing for a while may be
//! broken, or have nothing in view: degraded. One whose adapter says nothing any more is not connected; so is fusion.

use configuration::Config;
use messages::{Counter, Health, NO_SOURCE, ProcessKind};
use outgoing::{Condition, SendBlock, SensorStatus, StatusReports, SystemStatus};
use runtime::Now;

/// A sensor that has not delivered for so long is degraded, nanoseconds.
const DELIVERY_MAX_NS: i64 = 15_000_000_000;
/// A process that has not spoken for so long is gone, nanoseconds; it speaks several times a second.
const SPEECH_MAX_NS: i64 = 2_000_000_000;

/// States of fusion and of the sensors of all sources, in the order of their numbers.
#[derive(Debug)]
pub(crate) struct SensorStates {
    fusion_spoke_ns: i64,
    sensors: Vec<Sensor>,
    statuses: Vec<SensorStatus>,
}

#[derive(Debug)]
struct Sensor {
    adapter: String,
    sac_sic: (u8, u8),
    /// Whether its adapter speaks of it by number.
    by_number: bool,
    spoke_ns: i64,
    published: u64,
    delivered_ns: i64,
}

impl SensorStates {
    pub(crate) fn new(config: &Config) -> Self {
        let sensors = config.sources.iter().map(|source| Sensor {
            adapter: source.adapter.clone(),
            // One without codes of its own is known by its number.
            sac_sic: source.model.sac_sic.unwrap_or((0, (source.number + 1) as u8)),
            by_number: false,
            spoke_ns: i64::MIN,
            published: 0,
            delivered_ns: i64::MIN,
        });
        Self {
            fusion_spoke_ns: i64::MIN,
            sensors: sensors.collect(),
            statuses: Vec::with_capacity(config.sources.len()),
        }
    }

    /// A process has said how it is.
    pub(crate) fn hear(&mut self, health: &Health) {
        match health.kind() {
            Some(ProcessKind::Fusion) => self.fusion_spoke_ns = self.fusion_spoke_ns.max(health.said_ns),
            Some(ProcessKind::Adapter) => self.hear_adapter(health),
            _ => {}
        }
    }

    fn hear_adapter(&mut self, health: &Health) {
        let name = health.name();
        for (number, sensor) in self.sensors.iter_mut().enumerate().filter(|(_, of)| of.adapter == name) {
            sensor.spoke_ns = sensor.spoke_ns.max(health.said_ns);
            let of_sensor = usize::from(health.source) == number;
            sensor.by_number |= of_sensor;
            if of_sensor || (health.source == NO_SOURCE && !sensor.by_number) {
                let published = health.counters[Counter::Published];
                if published != sensor.published {
                    sensor.published = published;
                    sensor.delivered_ns = health.said_ns;
                }
            }
        }
    }

    /// Sends how fusion and the sensors are.
    pub(crate) fn report(&mut self, now: Now, reports: &mut StatusReports, send: &mut SendBlock<'_>) {
        let system = SystemStatus {
            condition: if self.fusion_spoke_ns < now.mono_ns - SPEECH_MAX_NS {
                Condition::NotConnected
            } else {
                Condition::Operational
            },
            ..SystemStatus::default()
        };
        reports.system(now.utc_ns, system, send);
        self.statuses.clear();
        self.statuses
            .extend(self.sensors.iter().map(|sensor| sensor.at(now.mono_ns)));
        reports.sensors(now.utc_ns, &self.statuses, send);
    }
}

impl Sensor {
    /// How it is at `now_ns` (monotonic).
    fn at(&self, now_ns: i64) -> SensorStatus {
        let silent = self.delivered_ns < now_ns - DELIVERY_MAX_NS;
        let condition = if self.spoke_ns < now_ns - SPEECH_MAX_NS {
            Condition::NotConnected
        } else if silent {
            Condition::Degraded
        } else {
            Condition::Operational
        };
        SensorStatus {
            sac: self.sac_sic.0,
            sic: self.sac_sic.1,
            condition,
            silent,
            time_source_invalid: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use configuration::BUILT_IN_DEMO;

    use super::*;
    use test_support::S;

    #[test]
    fn a_sensor_works_as_long_as_it_delivers() {
        let config = Config::read(Path::new(BUILT_IN_DEMO), &[]).unwrap();
        let mut states = SensorStates::new(&config);
        let state = |states: &SensorStates, now_s: i64| states.sensors[0].at(now_s * S).condition;
        assert_eq!(state(&states, 100), Condition::NotConnected);
        let said = |time_s: i64, published: u64| {
            let mut health = Health {
                said_ns: time_s * S,
                kind: ProcessKind::Adapter as u8,
                source: 0,
                ..Health::default()
            };
            health.counters[Counter::Published] = published;
            health.with_name(&config.sources[0].adapter)
        };
        states.hear(&said(100, 0));
        assert_eq!(state(&states, 100), Condition::Degraded, "its adapter is there");
        states.hear(&said(101, 5));
        assert_eq!(state(&states, 101), Condition::Operational);
        for time_s in 102..118 {
            states.hear(&said(time_s, 5));
        }
        assert_eq!(state(&states, 117), Condition::Degraded, "silent for too long");
        states.hear(&said(118, 6));
        assert_eq!(state(&states, 119), Condition::Operational);
        assert_eq!(state(&states, 121), Condition::NotConnected);
        let others = states.sensors[1..].iter();
        assert!(
            others
                .map(|other| other.at(119 * S).condition)
                .all(|other| other == Condition::NotConnected)
        );
    }
}

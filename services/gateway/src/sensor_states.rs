//! State of fusion and of the sensors, by health messages.
//!
//! A sensor is operational while its adapter reads records of it. A sensor that has been silent for several of its
//! periods is degraded: it may be defective or have no target in view. A sensor with an alarm is degraded, too; an
//! alarm about the sensor's clock makes its time source invalid. A sensor is not connected if its adapter publishes
//! no health message. The same holds for fusion.
//!
//! Health messages of fusion contain the estimated bias of each sensor. A bias is sent only while fusion removes the
//! bias from the reports: before, the estimate may be due to chance.

use alarms::{AlarmKind, Present};
use configuration::Config;
use messages::{
    Alarm, AlarmSeverity, BatchHeader, Counter, Health, NO_SOURCE, ProcessKind, Registration, registration_bits,
};
use outgoing::{
    Condition, SendBlock, SensorBiases, SensorStatus, ServiceEvent, StatusReports, SystemStatus, Technology,
};
use runtime::Now;

/// Silence after which a process counts as ended, nanoseconds; health messages come several times a second.
const SPEECH_MAX_NS: i64 = 2_000_000_000;

/// States of fusion and of the sensors of all sources, in the order of the sources' numbers.
#[derive(Debug)]
pub(crate) struct SensorStates {
    fusion_spoke_ns: i64,
    /// Condition sent last, once the system has been operational.
    condition: Option<Condition>,
    /// Value that changes whenever tracks are numbered anew.
    renumbered: bool,
    alarms: Present,
    sensors: Vec<Sensor>,
    statuses: Vec<SensorStatus>,
}

#[derive(Debug)]
struct Sensor {
    adapter: String,
    sac_sic: (u8, u8),
    /// Whether the adapter's health messages contain the sensor's number.
    by_number: bool,
    spoke_ns: i64,
    primary: bool,
    /// Silence after which the sensor is degraded, nanoseconds; `None`: never.
    silent_after_ns: Option<i64>,
    delivered: u64,
    delivered_ns: i64,
    known: Registration,
}

impl SensorStates {
    pub(crate) fn new(config: &Config) -> Self {
        let sensors = config.sources.iter().map(|source| Sensor {
            adapter: source.adapter.clone(),
            // A sensor without SAC and SIC is identified by its number.
            sac_sic: source.model.sac_sic.unwrap_or((0, (source.number + 1) as u8)),
            by_number: false,
            spoke_ns: i64::MIN,
            primary: source.technology == Technology::Primary,
            silent_after_ns: source.silent_after_ns,
            delivered: 0,
            delivered_ns: i64::MIN,
            known: Registration::default(),
        });
        Self {
            fusion_spoke_ns: i64::MIN,
            condition: None,
            renumbered: false,
            alarms: Present::default(),
            sensors: sensors.collect(),
            statuses: Vec::with_capacity(config.sources.len()),
        }
    }

    /// Takes a health message.
    pub(crate) fn hear(&mut self, health: &Health) {
        match health.kind() {
            Some(ProcessKind::Fusion) => {
                self.fusion_spoke_ns = self.fusion_spoke_ns.max(health.said_ns);
                if let Some(sensor) = self.sensors.get_mut(usize::from(health.source)) {
                    sensor.known = health.registration;
                }
            }
            Some(ProcessKind::Adapter) => self.hear_adapter(health),
            _ => {}
        }
    }

    /// Takes the monitor's standing alarms.
    pub(crate) fn hear_alarms(&mut self, header: &BatchHeader, slice: &[Alarm]) {
        self.alarms.hear(header, slice);
    }

    fn hear_adapter(&mut self, health: &Health) {
        let name = health.name();
        for (number, sensor) in self.sensors.iter_mut().enumerate().filter(|(_, of)| of.adapter == name) {
            sensor.spoke_ns = sensor.spoke_ns.max(health.said_ns);
            let of_sensor = usize::from(health.source) == number;
            sensor.by_number |= of_sensor;
            if of_sensor || (health.source == NO_SOURCE && !sensor.by_number) {
                let delivers = [Counter::Records, Counter::Published];
                let delivered = delivers.map(|counter| health.counters[counter]).iter().sum();
                if delivered != sensor.delivered {
                    sensor.delivered = delivered;
                    sensor.delivered_ns = health.said_ns;
                }
            }
        }
    }

    /// Reports an interruption of the service and its end, since tracks are numbered anew, unless the state of the
    /// system reports both.
    pub(crate) fn renumbered(&mut self, now: Now, reports: &mut StatusReports, send: &mut SendBlock<'_>) {
        self.renumbered = !self.renumbered;
        if self.condition.is_some_and(|said| said != Condition::NotConnected) {
            reports.event(now.utc_ns, ServiceEvent::Interrupted, send);
            reports.event(now.utc_ns, ServiceEvent::ReadyAgain, send);
        }
    }

    /// Sends the state of fusion and of the sensors.
    pub(crate) fn report(&mut self, now: Now, reports: &mut StatusReports, send: &mut SendBlock<'_>) {
        let system = self.system(now.mono_ns);
        let before = self.condition.unwrap_or(system.condition);
        if let Some(event) = ServiceEvent::between(before, system.condition) {
            reports.event(now.utc_ns, event, send);
        }
        // Before the first operational state there is no interruption.
        if self.condition.is_some() || system.condition != Condition::NotConnected {
            self.condition = Some(system.condition);
        }
        reports.system(now.utc_ns, system, send);
        let standing = self.alarms.at(now.mono_ns).unwrap_or_default();
        let states = self.sensors.iter().enumerate();
        self.statuses.clear();
        self.statuses
            .extend(states.map(|(number, sensor)| sensor.at(now.mono_ns, number, standing)));
        reports.sensors(now.utc_ns, &self.statuses, send);
    }
}

impl SensorStates {
    /// Returns the state of the system at `now_ns` (monotonic).
    fn system(&self, now_ns: i64) -> SystemStatus {
        let standing = self.alarms.at(now_ns).unwrap_or_default();
        let overload = [
            AlarmKind::SamplesLost,
            AlarmKind::DatagramsDropped,
            AlarmKind::CapacityReached,
        ];
        let critical = |alarm: &Alarm| alarm.severity() == Some(AlarmSeverity::Critical);
        SystemStatus {
            condition: if self.fusion_spoke_ns < now_ns - SPEECH_MAX_NS {
                Condition::NotConnected
            } else if standing.iter().any(critical) {
                Condition::Degraded
            } else {
                Condition::Operational
            },
            overloaded: standing
                .iter()
                .any(|alarm| overload.iter().any(|kind| kind.code() == alarm.code)),
            renumbered: self.renumbered,
            ..SystemStatus::default()
        }
    }
}

impl Sensor {
    /// Returns the state of sensor `number` at `now_ns` (monotonic) under these standing alarms.
    fn at(&self, now_ns: i64, number: usize, standing: &[Alarm]) -> SensorStatus {
        let own = standing
            .iter()
            .filter(|alarm| [alarm.source, alarm.partner].map(usize::from).contains(&number));
        let own: Vec<Option<AlarmKind>> = own.map(|alarm| AlarmKind::from_code(alarm.code)).collect();
        let clock = [AlarmKind::ClockOff, AlarmKind::SourceIsolated];
        let never_delivered = self.delivered_ns == i64::MIN;
        let silent = never_delivered
            || self
                .silent_after_ns
                .is_some_and(|after_ns| self.delivered_ns < now_ns - after_ns);
        let condition = if self.spoke_ns < now_ns - SPEECH_MAX_NS {
            Condition::NotConnected
        } else if silent || !own.is_empty() {
            Condition::Degraded
        } else {
            Condition::Operational
        };
        SensorStatus {
            sac: self.sac_sic.0,
            sic: self.sac_sic.1,
            condition,
            silent,
            time_source_invalid: clock.iter().any(|kind| own.contains(&Some(*kind))),
            biases: self.biases(),
        }
    }

    fn biases(&self) -> SensorBiases {
        let known = |bit, value| self.known.removes(bit).then_some(value);
        SensorBiases {
            time_s: known(registration_bits::TIME, self.known.time_offset_s),
            range_m: known(registration_bits::RANGE, self.known.range_bias_m),
            azimuth_rad: known(registration_bits::AZIMUTH, self.known.azimuth_bias_rad),
            primary: self.primary,
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
        let state = |states: &SensorStates, now_s: i64| states.sensors[0].at(now_s * S, 0, &[]).condition;
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
        for time_s in 102..123 {
            states.hear(&said(time_s, 5));
        }
        assert_eq!(state(&states, 121), Condition::Operational, "five periods of 4 s");
        assert_eq!(state(&states, 122), Condition::Degraded, "silent for too long");
        states.hear(&said(123, 6));
        assert_eq!(state(&states, 124), Condition::Operational);
        assert_eq!(state(&states, 126), Condition::NotConnected);
        let others = states.sensors[1..].iter();
        assert!(
            others
                .map(|other| other.at(124 * S, 1, &[]).condition)
                .all(|other| other == Condition::NotConnected)
        );
    }

    #[test]
    fn alarms_and_learned_biases_show_in_the_states() {
        let config = Config::read(Path::new(BUILT_IN_DEMO), &[]).unwrap();
        let mut states = SensorStates::new(&config);
        let mut fusion = Health {
            said_ns: 100 * S,
            kind: ProcessKind::Fusion as u8,
            source: 0,
            ..Health::default()
        };
        (fusion.registration.range_bias_m, fusion.registration.azimuth_bias_rad) = (90.0, 0.01);
        fusion.registration.removed = registration_bits::RANGE;
        states.hear(&fusion.with_name("fusion"));
        let mut adapter = Health {
            said_ns: 100 * S,
            kind: ProcessKind::Adapter as u8,
            source: 0,
            ..Health::default()
        };
        adapter.counters[Counter::Records] = 1;
        states.hear(&adapter.with_name(&config.sources[0].adapter));
        let header = BatchHeader {
            sent_ns: 100 * S,
            ..BatchHeader::default()
        };
        let alarm = |kind: AlarmKind, source| Alarm {
            code: kind.code(),
            severity: kind.severity().code(),
            source,
            ..Alarm::default()
        };
        let mut at = |slice: &[Alarm]| {
            states.hear_alarms(&header, slice);
            let standing = states.alarms.at(100 * S).unwrap();
            (states.system(100 * S), states.sensors[0].at(100 * S, 0, standing))
        };
        let (system, sensor) = at(&[alarm(AlarmKind::ClockOff, 1)]);
        assert_eq!(
            (system.condition, sensor.condition),
            (Condition::Operational, Condition::Operational)
        );
        assert_eq!((sensor.biases.range_m, sensor.biases.azimuth_rad), (Some(90.0), None));
        let (_, sensor) = at(&[alarm(AlarmKind::ClockOff, 0)]);
        assert_eq!(
            (sensor.condition, sensor.time_source_invalid),
            (Condition::Degraded, true)
        );
        let (system, _) = at(&[
            alarm(AlarmKind::ProcessHung, NO_SOURCE),
            alarm(AlarmKind::SamplesLost, NO_SOURCE),
        ]);
        assert_eq!((system.condition, system.overloaded), (Condition::Degraded, true));
    }
}

//! State of fusion and of the sensors, by health messages.
//!
//! A sensor is operational while its adapter reads records of it. A sensor that has been silent for several of its
//! periods is degraded: it may be defective or have no target in view. A sensor with an alarm is degraded, too; an
//! alarm about the sensor's clock makes its time source invalid. A sensor is not connected if its adapter publishes
//! no health message. The same holds for fusion. Fusion's counts stand for a source without an adapter.
//!
//! Health messages of fusion contain the estimated bias of each sensor. A bias is sent only while fusion removes the
//! bias from the reports: before, the estimate may be due to chance.

use alarms::AlarmKind;
use deployment::{Deployment, Technology};
use messages::{Alarm, AlarmSeverity, registration_bits};
use outgoing::{Condition, SendBlock, SensorBiases, SensorStatus, ServiceEvent, StatusReports, SystemStatus};
use runtime::Now;

/// States of fusion and of the sensors of all sources, in the order of the sources' numbers.
#[derive(Debug)]
pub(crate) struct SensorStates {
    pub(crate) observed: observed::Deployment,
    /// Condition sent last, once the system has been operational.
    condition: Option<Condition>,
    /// Value that changes whenever tracks are numbered anew.
    renumbered: bool,
    sensors: Vec<SensorState>,
    statuses: Vec<SensorStatus>,
}

#[derive(Debug)]
struct SensorState {
    number: u16,
    sac_sic: (u8, u8),
    primary: bool,
}

impl SensorStates {
    pub(crate) fn new(config: &Deployment) -> Self {
        let sensors = config.sources.iter().map(|source| SensorState {
            number: source.number,
            // A sensor without SAC and SIC is identified by its number.
            sac_sic: source.sac_sic.unwrap_or((0, (source.number + 1) as u8)),
            primary: source.technology == Technology::Primary,
        });
        Self {
            observed: observed::Deployment::new(config.observed_sources()),
            condition: None,
            renumbered: false,
            sensors: sensors.collect(),
            statuses: Vec::with_capacity(config.sources.len()),
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
        let states = self.sensors.iter().map(|sensor| sensor.at(&self.observed, now.mono_ns));
        self.statuses.clear();
        self.statuses.extend(states);
        reports.sensors(now.utc_ns, &self.statuses, send);
    }
}

impl SensorStates {
    /// Returns the state of the system at `now_ns` (monotonic).
    fn system(&self, now_ns: i64) -> SystemStatus {
        let standing = self.observed.alarms(now_ns);
        let overload = [
            AlarmKind::SamplesLost,
            AlarmKind::DatagramsDropped,
            AlarmKind::CapacityReached,
        ];
        let critical = |alarm: &Alarm| alarm.severity() == Some(AlarmSeverity::Critical);
        SystemStatus {
            condition: if self.observed.is_fusion_absent(now_ns) {
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

impl SensorState {
    /// Returns the state of the sensor at `now_ns` (monotonic).
    fn at(&self, observed: &observed::Deployment, now_ns: i64) -> SensorStatus {
        let own = observed
            .alarms(now_ns)
            .iter()
            .filter(|alarm| [alarm.source, alarm.partner].contains(&self.number));
        let own: Vec<Option<AlarmKind>> = own.map(|alarm| AlarmKind::from_code(alarm.code)).collect();
        let clock = [AlarmKind::ClockOff, AlarmKind::SourceIsolated];
        let silent = observed.is_source_silent(self.number, now_ns);
        let condition = if observed.is_source_absent(self.number, now_ns) {
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
            biases: self.biases(observed),
        }
    }

    fn biases(&self, observed: &observed::Deployment) -> SensorBiases {
        let learned = observed.book().registration(self.number);
        let known = |bit, value| learned.removes(bit).then_some(value);
        SensorBiases {
            time_s: known(registration_bits::TIME, learned.time_offset_s),
            range_m: known(registration_bits::RANGE, learned.range_bias_m),
            azimuth_rad: known(registration_bits::AZIMUTH, learned.azimuth_bias_rad),
            primary: self.primary,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use configuration::{BUILT_IN_DEMO, Config};
    use messages::{BatchHeader, Counter, Health, LifeState, NO_SOURCE, ProcessKind};

    use super::*;
    use test_support::S;

    #[test]
    fn a_sensor_works_as_long_as_it_delivers() {
        let config = Config::read(Path::new(BUILT_IN_DEMO), &[]).unwrap();
        let mut states = SensorStates::new(&config);
        let state = |states: &SensorStates, now_s: i64| states.sensors[0].at(&states.observed, now_s * S).condition;
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
        states.observed.take_health(&said(100, 0));
        assert_eq!(state(&states, 100), Condition::Degraded, "its adapter is there");
        states.observed.take_health(&said(101, 5));
        assert_eq!(state(&states, 101), Condition::Operational);
        for time_s in 102..123 {
            states.observed.take_health(&said(time_s, 5));
        }
        assert_eq!(state(&states, 121), Condition::Operational, "five periods of 4 s");
        assert_eq!(state(&states, 122), Condition::Degraded, "silent for too long");
        states.observed.take_health(&said(123, 6));
        assert_eq!(state(&states, 124), Condition::Operational);
        assert_eq!(state(&states, 126), Condition::NotConnected);
        let others = states.sensors[1..].iter();
        assert!(
            others
                .map(|other| other.at(&states.observed, 124 * S).condition)
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
            life: LifeState::Running as u8,
            source: 0,
            ..Health::default()
        };
        (fusion.registration.range_bias_m, fusion.registration.azimuth_bias_rad) = (90.0, 0.01);
        fusion.registration.removed = registration_bits::RANGE;
        states.observed.take_health(&fusion.with_name("fusion"));
        let mut adapter = Health {
            said_ns: 100 * S,
            kind: ProcessKind::Adapter as u8,
            source: 0,
            ..Health::default()
        };
        adapter.counters[Counter::Records] = 1;
        states
            .observed
            .take_health(&adapter.with_name(&config.sources[0].adapter));
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
            states.observed.take_alarms(&header, slice);
            (states.system(100 * S), states.sensors[0].at(&states.observed, 100 * S))
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

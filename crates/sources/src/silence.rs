//! Scans without detections by the clock: a sensor that sends nothing has seen nothing (HT-12, WA-11).
//!
//! A scan without detections is information: a present target was missed. A radar reports its north, and rows can state
//! empty scans; of other sensors the next detection showed them at last, and until then tracks stood still. Here the
//! time of a sensor with a known period goes on with the clock, from the latest event. Once the sensor is silent for
//! longer than a period and the wait (a second period without `wait_s`), the sensor's time is stated at each further
//! period, as an event like the sensor's own events. In a tracker process the event is published and recorded, and for
//! a sensor with a separate tracker the empty scan is, so that `koseki track` makes the same tracks of the recording.
//!
//! The clock counts from the latest event as received, so that neither an error of the sensor's clock nor a constant
//! delay matters. After a silence of [`SILENT_SCANS_MAX`] periods, or a silence that raises the alarm, the sensor may
//! be dead: nothing more is stated.

use observations::SensorEvent;
use tracking::cutting::CutterSettings;
use tracking::scans::SILENT_SCANS_MAX;

/// Times of silence of a sensor, nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SilenceRules {
    period_ns: i64,
    patience_ns: i64,
    /// Silence after which the sensor counts as dead.
    dead_ns: i64,
}

impl SilenceRules {
    /// Rules for a sensor with scans `period_ns` apart, and with a silence that raises the alarm after
    /// `silent_after_ns`.
    pub fn new(cutter: &CutterSettings, period_ns: i64, silent_after_ns: Option<i64>) -> Self {
        let wait_ns = cutter.wait_ns.map_or(period_ns, |wait_ns| wait_ns.min(period_ns));
        let longest_ns = period_ns.saturating_mul(i64::from(SILENT_SCANS_MAX));
        Self {
            period_ns,
            patience_ns: period_ns.saturating_add(wait_ns),
            dead_ns: silent_after_ns.unwrap_or(longest_ns).min(longest_ns),
        }
    }
}

/// Time of a sensor that may be silent, nanoseconds.
#[derive(Clone, Copy, Debug)]
pub struct SilentSensor {
    /// Time of the latest event, and the monotonic time of receipt.
    latest: Option<(i64, i64)>,
    /// Latest time of an event, or stated.
    reached_ns: i64,
}

impl Default for SilentSensor {
    fn default() -> Self {
        Self {
            latest: None,
            reached_ns: i64::MIN,
        }
    }
}

impl SilentSensor {
    /// Notes an event of the sensor, received at `came_ns` (monotonic).
    pub fn came(&mut self, time_ns: i64, came_ns: i64) {
        if self.latest.is_none_or(|latest| latest.0 <= time_ns) {
            self.latest = Some((time_ns, came_ns));
            self.reached_ns = self.reached_ns.max(time_ns);
        }
    }

    /// The statement that is due at `now_ns` (monotonic), and the time of the statement without the patience: as much
    /// later than the latest event as the stated time. Must be asked for only when no data of the sensor wait: received
    /// data are not late, however long the process stood still.
    pub fn statement(&mut self, now_ns: i64, rules: &SilenceRules) -> Option<(SensorEvent, i64)> {
        let (time_ns, came_ns) = self.latest?;
        let silent_ns = now_ns.saturating_sub(came_ns);
        let now_ns = time_ns.saturating_add(silent_ns).saturating_sub(rules.patience_ns);
        let is_due = now_ns.saturating_sub(self.reached_ns) >= rules.period_ns && silent_ns < rules.dead_ns;
        is_due.then(|| {
            self.reached_ns = now_ns;
            (SensorEvent::Passed(now_ns), came_ns.saturating_add(now_ns - time_ns))
        })
    }
}

#[cfg(test)]
mod tests {
    use test_support::S;
    use tracking::cutting::Boundaries;

    use super::*;

    /// A period of 2 s, a wait of half a second, and an alarm after 20 s.
    fn rules() -> SilenceRules {
        let cutter = CutterSettings {
            boundaries: Boundaries::Period,
            period_ns: Some(2 * S),
            wait_ns: Some(S / 2),
            waiting_max: 1,
            epoch_ns: 0,
        };
        SilenceRules::new(&cutter, 2 * S, Some(20 * S))
    }

    #[test]
    fn a_silent_sensor_goes_on_with_the_clock_until_it_counts_as_dead() {
        let mut sensor = SilentSensor::default();
        assert_eq!(sensor.statement(50 * S, &rules()), None, "it has never come");
        sensor.came(100 * S, 7 * S);
        // The time is stated from 2 + 2.5 s of silence on.
        let all = (7..60).filter_map(|now_s| sensor.statement(now_s * S, &rules()));
        let times: Vec<i64> = all
            .map(|(event, came_ns)| {
                let apart_ns = event.time_ns() - 100 * S;
                assert_eq!(came_ns - 7 * S, apart_ns, "the clocks stay as far apart");
                event.time_ns() / S
            })
            .collect();
        assert_eq!(times, [102, 104, 106, 108, 110, 112, 114, 116]);
    }

    #[test]
    fn an_event_of_the_sensor_begins_anew() {
        let mut sensor = SilentSensor::default();
        sensor.came(100 * S, 7 * S);
        assert!(sensor.statement(12 * S, &rules()).is_some());
        sensor.came(104 * S, 13 * S);
        assert_eq!(sensor.statement(14 * S, &rules()), None);
        // A late event does not set the clock back.
        sensor.came(90 * S, 15 * S);
        let due = sensor.statement(18 * S, &rules());
        assert_eq!(due, Some((SensorEvent::Passed(106 * S + S / 2), 15 * S + S / 2)));
    }

    #[test]
    fn without_a_wait_a_second_period_is_waited_for() {
        let cutter = CutterSettings {
            boundaries: Boundaries::Stated,
            period_ns: None,
            wait_ns: None,
            waiting_max: 1,
            epoch_ns: 0,
        };
        let mut sensor = SilentSensor::default();
        sensor.came(0, 0);
        let rules = SilenceRules::new(&cutter, S, None);
        assert_eq!(sensor.statement(3 * S - 1, &rules), None);
        assert_eq!(sensor.statement(3 * S, &rules), Some((SensorEvent::Passed(S), S)));
        sensor.came(2 * S, 0);
        assert_eq!(sensor.statement(100 * S, &rules), None, "a hundred periods");
    }
}

//! Scans without detections by the clock: a sensor that sends nothing has seen nothing (HT-12, WA-11).
//!
//! A scan without detections is information: what is there was missed. A radar reports its north, and rows can state
//! empty scans; of other sensors the next detection showed them at last, and until then tracks stood still. Here the
//! time of a sensor with a stated period goes on with the clock, from its latest event. Once the sensor is silent for
//! longer than a period and the wait (a second period without `wait_s`), its time is stated at each further period, as
//! an event like those that it sends itself: published and recorded, so that `koseki track` makes the same tracks of
//! the recording.
//!
//! The clock counts from the latest event as the event came, so that neither an error of the sensor's clock nor a
//! constant delay matters. After a silence of [`SILENT_SCANS_MAX`] periods, or one that raises the alarm, the sensor
//! may be dead: nothing more is stated.
//!
//! Limit: scans that the sensor numbers itself (`stated`) cannot be numbered for it.

use deployment::Source;
use observations::SensorEvent;
use sources::TrackerSettings;
use tracking::cutting::{Boundaries, CutterSettings};
use tracking::scans::SILENT_SCANS_MAX;

/// Times of the sensors of a tracker, by their places.
#[derive(Debug)]
pub(super) struct SilentSensors {
    sensors: Vec<Option<SilentSensor>>,
}

/// Times, nanoseconds.
#[derive(Clone, Copy, Debug)]
struct SilentSensor {
    period_ns: i64,
    patience_ns: i64,
    /// Silence after which the sensor counts as dead.
    dead_ns: i64,
    /// Time of the latest event, and its monotonic time of receipt.
    latest: Option<(i64, i64)>,
    /// Latest time of an event, or stated.
    reached_ns: i64,
}

impl SilentSensors {
    pub(super) fn new(settings: Option<&TrackerSettings>, sensors: &[Source]) -> Self {
        let cutters = settings.map_or(&[][..], |settings| &settings.joining.cutters);
        let of = |(cutter, sensor): (&CutterSettings, &Source)| SilentSensor::new(cutter, sensor.silent_after_ns);
        Self {
            sensors: cutters.iter().zip(sensors).map(of).collect(),
        }
    }

    /// Notes an event of the sensor in this place, received at `came_ns` (monotonic).
    pub(super) fn came(&mut self, place: usize, time_ns: i64, came_ns: i64) {
        let sensor = self.sensors.get_mut(place).and_then(Option::as_mut);
        if let Some(sensor) = sensor.filter(|sensor| sensor.latest.is_none_or(|latest| latest.0 <= time_ns)) {
            sensor.latest = Some((time_ns, came_ns));
            sensor.reached_ns = sensor.reached_ns.max(time_ns);
        }
    }

    /// The statement that is due at `now_ns` (monotonic) of the sensor in this place, and the time at which it would
    /// have come without the patience: as much later than the latest event as its own time. Must be asked for only
    /// when nothing that the sensor has sent waits: what has come is not late, however long the process stood still.
    pub(super) fn statement(&mut self, place: usize, now_ns: i64) -> Option<(SensorEvent, i64)> {
        let sensor = self.sensors.get_mut(place)?.as_mut()?;
        let (time_ns, came_ns) = sensor.latest?;
        let silent_ns = now_ns.saturating_sub(came_ns);
        let now_ns = time_ns.saturating_add(silent_ns).saturating_sub(sensor.patience_ns);
        let is_due = now_ns.saturating_sub(sensor.reached_ns) >= sensor.period_ns && silent_ns < sensor.dead_ns;
        is_due.then(|| {
            sensor.reached_ns = now_ns;
            (SensorEvent::Passed(now_ns), came_ns.saturating_add(now_ns - time_ns))
        })
    }
}

impl SilentSensor {
    /// `None` without a stated period.
    fn new(cutter: &CutterSettings, silent_after_ns: Option<i64>) -> Option<Self> {
        let is_cut = cutter.boundaries != Boundaries::Stated;
        let period_ns = cutter.period_ns.filter(|_| is_cut)?;
        let wait_ns = cutter.wait_ns.map_or(period_ns, |wait_ns| wait_ns.min(period_ns));
        let longest_ns = period_ns.saturating_mul(i64::from(SILENT_SCANS_MAX));
        Some(Self {
            period_ns,
            patience_ns: period_ns + wait_ns,
            dead_ns: silent_after_ns.unwrap_or(longest_ns).min(longest_ns),
            latest: None,
            reached_ns: i64::MIN,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;

    fn sensors(boundaries: Boundaries, period_ns: Option<i64>) -> SilentSensors {
        let cutter = CutterSettings {
            boundaries,
            period_ns,
            wait_ns: Some(S / 2),
            waiting_max: 1,
            epoch_ns: 0,
        };
        SilentSensors {
            sensors: vec![SilentSensor::new(&cutter, Some(20 * S))],
        }
    }

    /// Times stated each second until `end_s` after an event of the time 100 s that came at 7 s.
    fn stated(mut sensors: SilentSensors, end_s: i64) -> Vec<i64> {
        sensors.came(0, 100 * S, 7 * S);
        let all = (7..end_s).filter_map(|now_s| sensors.statement(0, now_s * S));
        all.map(|(event, came_ns)| {
            assert_eq!(
                came_ns - 7 * S,
                event.time_ns() - 100 * S,
                "the clocks stay as far apart"
            );
            event.time_ns() / S
        })
        .collect()
    }

    #[test]
    fn a_silent_sensor_goes_on_with_the_clock_until_it_counts_as_dead() {
        // A period of 2 s and a wait of half a second: the time is stated from 2 + 2.5 s of silence on.
        let all = stated(sensors(Boundaries::Period, Some(2 * S)), 60);
        assert_eq!(all, [102, 104, 106, 108, 110, 112, 114, 116], "{all:?}");
        assert_eq!(
            stated(sensors(Boundaries::Period, None), 60),
            [0; 0],
            "no period is stated"
        );
        assert_eq!(
            stated(sensors(Boundaries::Stated, Some(2 * S)), 60),
            [0; 0],
            "numbers of its own"
        );
    }

    #[test]
    fn an_event_of_the_sensor_begins_anew() {
        let mut sensors = sensors(Boundaries::Turn, Some(2 * S));
        assert_eq!(sensors.statement(0, 50 * S), None, "it has never come");
        sensors.came(0, 100 * S, 7 * S);
        assert!(sensors.statement(0, 12 * S).is_some());
        sensors.came(0, 104 * S, 13 * S);
        assert_eq!(sensors.statement(0, 14 * S), None);
        // A late event does not set the clock back.
        sensors.came(0, 90 * S, 15 * S);
        let due = sensors.statement(0, 18 * S);
        assert_eq!(due, Some((SensorEvent::Passed(106 * S + S / 2), 15 * S + S / 2)));
        assert_eq!(sensors.statement(1, 18 * S), None, "there is no such sensor");
    }
}

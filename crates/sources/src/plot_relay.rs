//! Detections of a sensor of a tracker process: checked, and passed on upon arrival.
//!
//! The tracker process joins the detections of several sensors; each sensor's adapter only reads and checks the
//! detections. Detections of ASTERIX have been checked with the other records of a radar ([`reception::Converter`]).
//! Rows state positions in the system frame, so times and ranges are checked here: a time that the sensor's clock
//! cannot have shown would bring the tracker's other sensors out of order.

use estimation::SourceClock;
use messages::{Counter, Counters, Quantity};
use observations::{Detection, Sampled, SensorEvent};
use reception::PlausibilityLimits;

use crate::detection_tracker::ingested;
use crate::samples::Samples;

/// Largest distance of a sensor's stated place from the origin of the system frame, as of a platform's states, metres.
const PLACE_MAX_M: f64 = 1e6;

/// Relay of a sensor's detections.
#[derive(Debug)]
pub(crate) struct PlotRelay {
    source: u16,
    limits: PlausibilityLimits,
    /// Time of receipt (UTC) of the latest rows, nanoseconds; `None` for recordings.
    received_ns: Option<i64>,
    clock: SourceClock,
    newest_ns: i64,
    detections: u64,
    rows: u64,
    rejected_time: u64,
    rejected_position: u64,
}

impl PlotRelay {
    /// Makes the relay of source number `source`; the detections keep to `limits`.
    pub(crate) fn new(source: u16, limits: PlausibilityLimits) -> Self {
        Self {
            source,
            limits,
            received_ns: None,
            clock: SourceClock::new(limits.clock_step().s()),
            newest_ns: i64::MIN,
            detections: 0,
            rows: 0,
            rejected_time: 0,
            rejected_position: 0,
        }
    }

    /// Clock of the sensor, estimated from the rows' times of receipt.
    pub(crate) fn clock(&self) -> &SourceClock {
        &self.clock
    }

    /// Sets the time of receipt of the following rows, nanoseconds, by a UTC clock without steps.
    pub(crate) fn received(&mut self, received_ns: i64) {
        self.received_ns = Some(received_ns);
    }

    /// Takes an event as stated by a row, received at `ingested_ns` (monotonic, nanoseconds).
    pub(crate) fn row(&mut self, event: &SensorEvent, ingested_ns: i64, samples: &mut Samples) {
        let time_ns = event.time_ns();
        let is_wild = |received_ns: i64| !self.clock.believes(time_ns, received_ns, None);
        if self.received_ns.is_some_and(is_wild) {
            self.rejected_time += 1;
            return;
        }
        if let SensorEvent::Detection(detection) = event {
            if !self.is_near(detection) {
                self.rejected_position += 1;
                return;
            }
            self.rows += 1;
        }
        self.pass(event, ingested_ns, samples);
    }

    /// Passes on an event that has been checked.
    pub(crate) fn pass(&mut self, event: &SensorEvent, ingested_ns: i64, samples: &mut Samples) {
        self.newest_ns = self.newest_ns.max(event.time_ns());
        self.detections += u64::from(matches!(event, SensorEvent::Detection(_)));
        samples
            .detections
            .push(event.sample(self.source, ingested(ingested_ns)));
    }

    /// Time of the latest event, nanoseconds.
    pub(crate) fn progress_ns(&self) -> i64 {
        self.newest_ns
    }

    /// Adds the counts of this relay.
    pub(crate) fn count(&self, counters: &mut Counters) {
        for (counter, count) in [
            (Counter::Reports, self.rows),
            (Counter::Detections, self.detections),
            (Counter::RejectedTime, self.rejected_time),
            (Counter::RejectedPosition, self.rejected_position),
        ] {
            counters[counter] += count;
        }
    }

    /// Whether the detected place may be that of a target, and the stated place that of a sensor; a direction names no
    /// place of a target.
    fn is_near(&self, detection: &Detection) -> bool {
        let [sensor_east, sensor_north, _] = detection.platform_m;
        // Not a number is no place, either.
        let is_placed = sensor_east.hypot(sensor_north) <= PLACE_MAX_M;
        let [east, north, _] = detection.values;
        let distance_m = match detection.kind.quantities() {
            [Quantity::East, ..] => (east - detection.platform_m[0]).hypot(north - detection.platform_m[1]),
            [Quantity::Range, ..] => detection.values[0],
            _ => 0.0,
        };
        is_placed && distance_m <= self.limits.range_m
    }
}

#[cfg(test)]
mod tests {
    use messages::DetectionKind;
    use observations::{DetectionPlatform, TransponderReply};

    use super::*;

    #[test]
    fn a_sensor_beyond_a_thousand_kilometres_is_refused() {
        let mut relay = PlotRelay::new(0, PlausibilityLimits::default());
        let mut samples = Samples::default();
        for (number, east) in [9e5, 1.1e6, f64::NAN].into_iter().enumerate() {
            let detection = Detection {
                time_of_measurement_ns: 1,
                sensor_id: 1,
                scan: 0,
                detection_id: number as u32,
                kind: DetectionKind::Bearing,
                values: [0.1, 0.0, 0.0],
                range_rate_mps: None,
                sigmas: None,
                platform_m: [east, 0.0, 0.0],
                platform: DetectionPlatform::default(),
                height: None,
                velocity: None,
                reply: TransponderReply::default(),
                truth: None,
            };
            relay.row(&SensorEvent::Detection(detection), 0, &mut samples);
        }
        let mut counters = Counters::default();
        relay.count(&mut counters);
        assert_eq!((samples.detections.len(), counters[Counter::RejectedPosition]), (1, 2));
    }
}

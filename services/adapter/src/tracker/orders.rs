//! Designations by order: targets that operators name, as detections of a sensor of the tracker (WA-1).
//!
//! Fusion checks orders, writes the orders into its event log and publishes the states. The tracker takes its orders
//! from these states, so an order takes effect once, independent of the giver, also after a take-over by the standby.
//! Each order becomes a detection of the sensor that takes orders: published among the events of the other sensors and
//! recorded with these, so that `koseki track` makes the same tracks.
//!
//! A designation holds for the time at which the order was given, and the data of the other sensors are behind the
//! clock. Used at once, a designation would be the latest event, and end the wait for scans still under way. A
//! designation therefore waits until the data have come to its time, at most [`PATIENCE_NS`]: then no sensor sends
//! anything.
//!
//! The states are repeated for a minute. A starting tracker takes all states: a killed tracker has perhaps not used the
//! latest orders, and an already used order is in the gate of its track, or too late.

use std::collections::VecDeque;

use bus::{Bus, BusError, SharedMemory, Subscriber};
use deployment::Source;
use frames::{FrameChange, Geodetic, SystemFrame};
use messages::{DesignatedPlace, DetectionKind, Order, OrderKind, OrderState, OrderStatus};
use observations::{Detection, DetectionPlatform, SensorEvent, StatedVelocity, TransponderReply};

/// Longest wait for the data to come to the time of an order, nanoseconds.
const PATIENCE_NS: i64 = 10_000_000_000;
/// Maximum number of orders with remembered tokens: far more than are listed at a time.
const REMEMBERED_MAX: usize = 512;

/// Orders to a tracker.
#[derive(Debug)]
pub(super) struct Orders {
    states: Subscriber<SharedMemory, OrderState>,
    designations: Designations,
}

/// Designations that wait for the data, without the bus.
#[derive(Debug)]
struct Designations {
    tracker: u16,
    /// Place of the sensor that takes orders.
    sensor: usize,
    frame: SystemFrame,
    /// Tokens of the orders taken, oldest first.
    taken: VecDeque<u64>,
    /// Designations with the monotonic end of the wait, nanoseconds, in the order of the designations' times.
    waiting: Vec<(i64, Detection)>,
    /// Latest time of the other sensors' events.
    newest_ns: i64,
    /// Latest time of a designation given to the tracker.
    released_ns: i64,
}

impl Orders {
    /// The orders to a tracker, if any of its `sensors` takes orders.
    ///
    /// # Errors
    /// If shared memory fails.
    pub(super) fn open(
        bus: &Bus<SharedMemory>,
        (tracker, sensors): (u16, &[Source]),
        frame: SystemFrame,
        incarnation: u64,
    ) -> Result<Option<Self>, BusError> {
        let Some(sensor) = sensors.iter().position(|sensor| sensor.takes_orders) else {
            return Ok(None);
        };
        Ok(Some(Self {
            states: bus.subscriber(&messages::order_states(), || incarnation)?,
            designations: Designations::new(tracker, sensor, frame),
        }))
    }

    /// The data of another sensor have come to `time_ns`.
    pub(super) fn came(&mut self, time_ns: i64) {
        let newest_ns = &mut self.designations.newest_ns;
        *newest_ns = time_ns.max(*newest_ns);
    }

    /// Takes new orders, and gives `out` the designations that wait no longer.
    ///
    /// # Errors
    /// If shared memory fails.
    pub(super) fn turn(&mut self, mono_ns: i64, out: &mut Vec<(i64, usize, SensorEvent)>) -> Result<(), BusError> {
        let Self { states, designations } = self;
        states.take(usize::MAX, |_, list| {
            list.iter().for_each(|state| designations.take(state, mono_ns));
        })?;
        designations.release(mono_ns, out);
        Ok(())
    }
}

impl Designations {
    fn new(tracker: u16, sensor: usize, frame: SystemFrame) -> Self {
        Self {
            tracker,
            sensor,
            frame,
            taken: VecDeque::with_capacity(REMEMBERED_MAX),
            waiting: Vec::new(),
            newest_ns: i64::MIN,
            released_ns: i64::MIN,
        }
    }

    /// Takes the state of an order, if the order is new to this tracker.
    fn take(&mut self, state: &OrderState, mono_ns: i64) {
        let order = &state.order;
        let is_obeyed = state.status() == Some(OrderStatus::Done) && order.kind() == Some(OrderKind::Designate);
        if !is_obeyed || order.source != self.tracker || self.taken.contains(&order.token) {
            return;
        }
        if self.taken.len() == REMEMBERED_MAX {
            self.taken.pop_front();
        }
        self.taken.push_back(order.token);
        if let Some(detection) = self.detection(order, state.number) {
            self.waiting.push((mono_ns.saturating_add(PATIENCE_NS), detection));
            self.waiting.sort_by_key(|(_, waiting)| waiting.time_of_measurement_ns);
        }
    }

    /// Releases the due designations.
    fn release(&mut self, mono_ns: i64, out: &mut Vec<(i64, usize, SensorEvent)>) {
        while let Some((until_ns, mut detection)) = self.waiting.first().copied() {
            if detection.time_of_measurement_ns > self.newest_ns && mono_ns < until_ns {
                break;
            }
            self.waiting.remove(0);
            // Each designation is a separate scan, complete at once. Orders of a moment may come in any order: none is
            // late.
            let time_ns = detection.time_of_measurement_ns.max(self.released_ns.saturating_add(2));
            (detection.time_of_measurement_ns, self.released_ns) = (time_ns, time_ns);
            let whole = SensorEvent::Passed(time_ns.saturating_add(1));
            let events = [SensorEvent::Detection(detection), whole];
            out.extend(events.map(|event| (mono_ns, self.sensor, event)));
        }
    }

    /// The detection that designates the target; `None` if the order states no place.
    fn detection(&self, order: &Order, number: u32) -> Option<Detection> {
        let (place, course) = DesignatedPlace::read(order.name())?;
        let ([east, north, up], has_height) = match place {
            DesignatedPlace::Globe {
                latitude_deg,
                longitude_deg,
                height_m,
            } => {
                let place = Geodetic::from_degrees(latitude_deg, longitude_deg, height_m.unwrap_or(0.0)).ok()?;
                (self.frame.to_local(place), height_m.is_some())
            }
            DesignatedPlace::Frame {
                plane_m: [east, north],
                up_m,
            } => ([east, north, up_m.unwrap_or(0.0)], up_m.is_some()),
        };
        let sigma = order.value;
        let (kind, up, sigma_up) = match has_height {
            true => (DetectionKind::Position3, up, sigma),
            false => (DetectionKind::Position2, 0.0, 0.0),
        };
        let velocity = course.map(|course| {
            let [east_mps, north_mps] = self.in_the_frame(&place, course.velocity_mps());
            StatedVelocity {
                velocity_mps: [east_mps as f32, north_mps as f32],
                sigma_mps: course.sigma_mps(),
            }
        });
        Some(Detection {
            time_of_measurement_ns: order.sent_ns,
            sensor_id: 0,
            scan: number,
            detection_id: number,
            kind,
            values: [east, north, up],
            range_rate_mps: None,
            sigmas: Some([sigma, sigma, sigma_up, 0.0]),
            platform_m: [0.0; 3],
            platform: DetectionPlatform::default(),
            height: None,
            velocity,
            reply: TransponderReply::default(),
            truth: None,
        })
    }

    /// A velocity east and north at the place, along the axes of the system frame.
    fn in_the_frame(&self, place: &DesignatedPlace, [east_mps, north_mps]: [f64; 2]) -> [f64; 2] {
        let DesignatedPlace::Globe {
            latitude_deg,
            longitude_deg,
            ..
        } = *place
        else {
            return [east_mps, north_mps];
        };
        let Ok(here) = Geodetic::from_degrees(latitude_deg, longitude_deg, 0.0) else {
            return [east_mps, north_mps];
        };
        let [east, north, _] =
            FrameChange::between(&SystemFrame::at(here), &self.frame).direction([east_mps, north_mps, 0.0]);
        [east, north]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;

    fn designations() -> Designations {
        let origin = Geodetic::from_degrees(59.0, 10.0, 0.0).unwrap();
        Designations::new(3, 1, SystemFrame::at(origin))
    }

    /// State of an order to a tracker at a place, given at a time.
    fn state(tracker: u16, number: u32, place: &str, sent_ns: i64) -> OrderState {
        let order = Order {
            token: u64::from(number),
            sent_ns,
            source: tracker,
            value: 300.0,
            ..Order::new(OrderKind::Designate)
        };
        OrderState {
            order: order.with_name(place).unwrap(),
            number,
            status: OrderStatus::Done.code(),
            ..OrderState::default()
        }
    }

    fn released(designations: &mut Designations, mono_ns: i64) -> Vec<SensorEvent> {
        let mut out = Vec::new();
        designations.release(mono_ns, &mut out);
        assert!(
            out.iter()
                .all(|(came_ns, sensor, _)| (*came_ns, *sensor) == (mono_ns, 1))
        );
        out.into_iter().map(|(_, _, event)| event).collect()
    }

    #[test]
    fn an_order_becomes_one_detection_once_the_data_have_come_to_its_time() {
        let mut designations = designations();
        designations.newest_ns = 99 * S;
        for _ in 0..3 {
            designations.take(&state(3, 7, "59.0,10.0", 100 * S), S);
            assert_eq!(released(&mut designations, S), [], "the data are behind");
        }
        designations.newest_ns = 100 * S;
        let events = released(&mut designations, 2 * S);
        let [SensorEvent::Detection(found), SensorEvent::Passed(passed_ns)] = events[..] else {
            panic!("{events:?}");
        };
        assert_eq!((found.kind, found.scan), (DetectionKind::Position2, 7));
        assert!(found.values[0].abs() < 1e-6 && found.values[1].abs() < 1e-6);
        assert_eq!(found.sigmas.unwrap()[..2], [300.0; 2]);
        assert!(found.time_of_measurement_ns == 100 * S && passed_ns > 100 * S);
        designations.take(&state(3, 7, "59.0,10.0", 100 * S), 3 * S);
        assert_eq!(released(&mut designations, 3 * S), [], "repeated");
    }

    #[test]
    fn an_order_waits_no_longer_than_its_patience_for_silent_sensors() {
        let mut designations = designations();
        designations.take(&state(3, 1, "10m,20m,30m", 100 * S), 5 * S);
        assert_eq!(released(&mut designations, 5 * S + PATIENCE_NS - 1), []);
        let events = released(&mut designations, 5 * S + PATIENCE_NS);
        assert!(matches!(events[0], SensorEvent::Detection(found) if found.values == [10.0, 20.0, 30.0]));
    }

    /// North at a place far to the east is turned to the left in the frame, in the northern hemisphere.
    #[test]
    fn a_course_is_from_the_north_at_the_place() {
        let mut designations = designations();
        designations.newest_ns = 200 * S;
        let mut velocity = |number, place| {
            designations.take(&state(3, number, place, 100 * S), S);
            match released(&mut designations, S)[..] {
                [SensorEvent::Detection(found), _] => found.velocity,
                ref events => panic!("{events:?}"),
            }
        };
        assert_eq!(velocity(1, "59.0,13.0"), None);
        let stated = velocity(2, "59.0,13.0@0/100/4").unwrap();
        let [east_mps, north_mps] = stated.velocity_mps;
        // Three degrees of longitude, by the sine of the latitude.
        let turned_deg = f64::from(east_mps).atan2(f64::from(north_mps)).to_degrees();
        assert!((turned_deg + 2.57).abs() < 0.02, "{turned_deg}");
        assert_eq!(stated.sigma_mps, 4.0);
        assert_eq!(velocity(3, "0m,0m@90/100").unwrap().velocity_mps[0], 100.0);
    }

    #[test]
    fn orders_that_come_the_wrong_way_round_are_both_in_time() {
        let mut designations = designations();
        designations.newest_ns = 200 * S;
        designations.take(&state(3, 2, "0m,0m", 101 * S), S);
        let first = released(&mut designations, S);
        designations.take(&state(3, 1, "0m,0m", 100 * S), S);
        let second = released(&mut designations, S);
        assert!(first[1].time_ns() < second[0].time_ns(), "{first:?} {second:?}");
    }

    #[test]
    fn orders_to_others_and_refused_ones_are_left() {
        let mut designations = designations();
        designations.newest_ns = 200 * S;
        designations.take(&state(4, 1, "0m,0m", 0), S);
        let refused = OrderState {
            status: OrderStatus::Refused.code(),
            ..state(3, 2, "0m,0m", 0)
        };
        designations.take(&refused, S);
        assert_eq!(released(&mut designations, S), []);
    }
}

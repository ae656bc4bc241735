//! Detections of sensors on platforms that move, upstream of a tracker (HT-12, EL-11).
//!
//! A sensor on a ship measures from the ship. The detections wait for the ship's states, and become detections in the
//! system frame (crate `platform`). The marks of such a sensor (a scan without detections, the beginning of a turn)
//! must not overtake the detections that wait: the tracker would cut other scans. Marks wait in the same queue.
//!
//! A refused detection leaves a mark in the same place ([`SensorEvent::Unplaced`]); where too many wait, the mark
//! leaves at once. The tracker process publishes the mark, so a recording holds the refusals. How long a detection
//! waits depends on the times of the sensor's data and on the states so far. The events that leave are recorded in
//! order, and the tracks depend on these events alone.
//!
//! Live and recorded tracker processes and `koseki track --platform` all use this.

use std::collections::VecDeque;

use frames::SystemFrame;
use observations::{Detection, SensorEvent};
use platform::{Assumed, History, Mount, State, WaitingCounts, WaitingRoom};

/// Most detections of a sensor that wait for a state; a further detection is refused.
pub const WAITING_MAX: usize = 4096;

/// A platform: assumptions on the states, the wait for states, and the number of kept states.
#[derive(Clone, Copy, Debug)]
pub struct Carrier {
    /// Assumptions where the states give no value.
    pub assumed: Assumed,
    /// Time by which a sensor's data may run ahead of the states, nanoseconds.
    pub wait_ns: i64,
    /// Number of states that are kept.
    pub states_max: usize,
}

/// Mounting of a sensor on board.
#[derive(Clone, Copy, Debug)]
pub struct CarriedSensor {
    /// Place among the carriers; `None` if the detections state the platform.
    pub carrier: Option<usize>,
    /// Place and directions on the platform.
    pub mount: Mount,
    /// Standard deviations of detections that state none.
    pub default_sigmas: Option<[f64; 4]>,
    /// Interval between two looks as configured, nanoseconds; `None`: as shown by the data.
    pub looks_ns: Option<i64>,
}

/// Carries the detections of a tracker's sensors into the system frame.
#[derive(Debug)]
pub struct Carrying<T> {
    frame: Option<SystemFrame>,
    histories: Vec<History>,
    sensors: Vec<Option<Boarded<T>>>,
    /// Assumptions where detections state the platform.
    own: Assumed,
}

/// A sensor on board, and the events that wait.
#[derive(Debug)]
struct Boarded<T> {
    sensor: CarriedSensor,
    room: WaitingRoom<T>,
    /// Marks in place; `None` is the next detection in the waiting room.
    order: VecDeque<Option<(SensorEvent, T)>>,
    own_counts: WaitingCounts,
}

impl<T> Carrying<T> {
    /// For these sensors, in the order of the tracker's; `None` is a sensor at rest. `own` are the assumptions where
    /// detections state the platform. With a `frame`, the north of sensors with `bearings = "north"` is the north at
    /// the platform.
    pub fn new(
        carriers: &[Carrier],
        sensors: &[Option<CarriedSensor>],
        own: Assumed,
        frame: Option<SystemFrame>,
    ) -> Self {
        let boarded = |sensor: &CarriedSensor| {
            let wait_ns = sensor.carrier.map_or(0, |carrier| carriers[carrier].wait_ns);
            Boarded {
                sensor: *sensor,
                room: WaitingRoom::new(sensor.mount, sensor.default_sigmas, wait_ns, WAITING_MAX)
                    .with_looks(sensor.looks_ns),
                order: VecDeque::new(),
                own_counts: WaitingCounts::default(),
            }
        };
        Self {
            frame,
            histories: carriers
                .iter()
                .map(|carrier| History::new(carrier.assumed, carrier.states_max))
                .collect(),
            sensors: sensors.iter().map(|sensor| sensor.as_ref().map(boarded)).collect(),
            own,
        }
    }

    /// Takes a state of the platform in this place. [`Self::release`] then gives the events that need not wait any
    /// longer.
    pub fn state(&mut self, carrier: usize, state: &State) {
        self.histories[carrier].add(state);
    }

    /// Takes an event of the sensor in this place; `out` gets the events that leave, in order.
    pub fn take(&mut self, place: usize, event: SensorEvent, with_it: T, out: &mut impl FnMut(usize, SensorEvent, T)) {
        let Some(boarded) = self.sensors.get_mut(place).and_then(Option::as_mut) else {
            return out(place, event, with_it);
        };
        let SensorEvent::Detection(detection) = event else {
            boarded.mark(event, with_it);
            return boarded.leave(&self.histories, self.frame.as_ref(), |event, with_it| {
                out(place, event, with_it)
            });
        };
        if boarded.sensor.carrier.is_none() {
            return out(place, boarded.own(&detection, &self.own, self.frame.as_ref()), with_it);
        }
        match boarded.room.take(detection, with_it) {
            Some(full) => out(place, event_of(&full.measured, None), full.with_it),
            None => boarded.order.push_back(None),
        }
        boarded.leave(&self.histories, self.frame.as_ref(), |event, with_it| {
            out(place, event, with_it)
        });
    }

    /// Gives the events that need not wait any longer.
    pub fn release(&mut self, out: &mut impl FnMut(usize, SensorEvent, T)) {
        for (place, boarded) in self.sensors.iter_mut().enumerate() {
            if let Some(boarded) = boarded {
                boarded.leave(&self.histories, self.frame.as_ref(), |event, with_it| {
                    out(place, event, with_it)
                });
            }
        }
    }

    /// No further state comes: no detection waits any longer.
    pub fn states_end(&mut self) {
        self.sensors.iter_mut().flatten().for_each(|boarded| boarded.room.end());
    }

    /// Numbers of detections by outcome.
    pub fn counts(&self) -> WaitingCounts {
        let mut all = WaitingCounts::default();
        for boarded in self.sensors.iter().flatten() {
            all += boarded.room.counts();
            all += boarded.own_counts;
        }
        all
    }
}

impl<T> Boarded<T> {
    fn mark(&mut self, event: SensorEvent, with_it: T) {
        self.room.passed(event.time_ns());
        if let SensorEvent::TurnBegins(time_ns) = event {
            self.room.turned(time_ns);
        }
        // A sensor whose clock stands still sends marks without end, and the detections wait for ever.
        if self.order.len() >= 2 * WAITING_MAX && matches!(self.order.back(), Some(Some(_))) {
            self.order.pop_back();
        }
        self.order.push_back(Some((event, with_it)));
    }

    /// Gives the events at the head of the queue that need not wait.
    fn leave(&mut self, histories: &[History], frame: Option<&SystemFrame>, mut out: impl FnMut(SensorEvent, T)) {
        while let Some(next) = self.order.pop_front() {
            if let Some((mark, with_it)) = next {
                out(mark, with_it);
                continue;
            }
            let history = self.sensor.carrier.and_then(|carrier| histories.get(carrier));
            let Some(departure) = history.and_then(|history| self.room.next(history, frame)) else {
                self.order.push_front(None);
                return;
            };
            let carried = departure.outcome.ok().map(|carried| carried.detection);
            out(event_of(&departure.measured, carried), departure.with_it);
        }
    }

    /// A detection that states the platform; a detection without an attitude is in the system frame already.
    fn own(&mut self, detection: &Detection, assumed: &Assumed, frame: Option<&SystemFrame>) -> SensorEvent {
        if detection.platform.attitude_rad.is_none() {
            return SensorEvent::Detection(*detection);
        }
        let (mount, sigmas) = (self.sensor.mount, self.sensor.default_sigmas);
        let carried = mount.carry_own(detection, assumed, sigmas, frame);
        match &carried {
            Ok(_) => self.own_counts.carried += 1,
            Err(refusal) => self.own_counts.count(*refusal),
        }
        event_of(detection, carried.ok().map(|carried| carried.detection))
    }
}

/// The detection in the system frame, or the mark of the refusal.
fn event_of(measured: &Detection, carried: Option<Detection>) -> SensorEvent {
    let refused = SensorEvent::Unplaced(measured.time_of_measurement_ns);
    carried.map_or(refused, SensorEvent::Detection)
}

//! Detections that wait for the states of their platform.
//!
//! A sensor without elevation does not measure heights, and a tracker assumes its targets to be anywhere within
//! kilometres above and below the sensor. A mast that moves up and down by metres would then seem to reveal their
//! heights, by changes of the slant range that are smaller than its error. The height of such a sensor is therefore
//! held until it has changed by more than [`HELD_WITHIN_M`].

use frames::SystemFrame;
use observations::{Detection, DetectionKind};

use crate::carried::{Carried, Refusal};
use crate::history::History;
use crate::mount::Mount;
use crate::persistence::LookInterval;
use crate::state_queue::{StateQueue, WaitingCounts};

/// Change of its height up to which the height of a sensor without elevation is held, metres.
pub const HELD_WITHIN_M: f64 = 50.0;

/// A detection that leaves, with what came with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departure<T> {
    /// The detection in the system's terms, or why it is refused.
    pub outcome: Result<Carried, Refusal>,
    /// The detection as it was measured.
    pub measured: Detection,
    /// What came with it: its time of receipt, for example.
    pub with_it: T,
}

/// Detections of one sensor on a platform that wait for the platform's states.
#[derive(Clone, Debug)]
pub struct WaitingRoom<T> {
    mount: Mount,
    default_sigmas: Option<[f64; 4]>,
    queue: StateQueue<Detection, T>,
    /// Height in which a sensor without elevation is held, metres.
    held_m: Option<f64>,
}

impl<T> WaitingRoom<T> {
    /// Makes a room for `waiting_max` detections of a sensor, whose data run ahead of the platform's states by at most
    /// `wait_ns`. `default_sigmas` serve detections that state none.
    pub fn new(mount: Mount, default_sigmas: Option<[f64; 4]>, wait_ns: i64, waiting_max: usize) -> Self {
        Self {
            mount,
            default_sigmas,
            queue: StateQueue::new(wait_ns, waiting_max),
            held_m: None,
        }
    }

    /// With the interval between two looks of the sensor as configured, nanoseconds; otherwise the data show it.
    #[must_use]
    pub fn with_looks(mut self, interval_ns: Option<i64>) -> Self {
        self.queue.looks = LookInterval::new(interval_ns);
        self
    }

    /// A turn of the sensor begins at this time, nanoseconds.
    pub fn turned(&mut self, time_ns: i64) {
        self.queue.looks.turned(time_ns);
    }

    /// Takes a detection. A detection without room comes back as a departure.
    pub fn take(&mut self, detection: Detection, with_it: T) -> Option<Departure<T>> {
        let time_ns = detection.time_of_measurement_ns;
        self.passed(time_ns);
        self.queue.looks.detected(detection.scan, time_ns);
        let (measured, with_it) = self.queue.push(time_ns, detection, with_it)?;
        Some(Departure {
            outcome: Err(Refusal::Full),
            measured,
            with_it,
        })
    }

    /// The sensor's data have come to this time, nanoseconds.
    pub fn passed(&mut self, time_ns: i64) {
        self.queue.reached_ns = self.queue.reached_ns.max(time_ns);
    }

    /// The sensor's data have ended: what still waits for a state is refused at the next call of [`Self::next`].
    pub fn end(&mut self) {
        self.queue.reached_ns = i64::MAX;
    }

    /// The next detection that need not wait any longer; `None` if the first one must wait.
    pub fn next(&mut self, history: &History, frame: Option<&SystemFrame>) -> Option<Departure<T>> {
        let (mount, sigmas) = (&self.mount, self.default_sigmas);
        let (outcome, measured, with_it) = self
            .queue
            .next(history, |detection, pose| mount.carry(detection, pose, sigmas, frame))?;
        Some(Departure {
            outcome: outcome.map(|carried| self.held(carried)),
            measured,
            with_it,
        })
    }

    /// A detection without elevation, from the height in which its sensor is held.
    fn held(&mut self, mut carried: Carried) -> Carried {
        let detection = &mut carried.detection;
        if matches!(detection.kind, DetectionKind::RangeBearing | DetectionKind::Bearing) {
            let height_m = detection.platform_m[2];
            let held_m = self.held_m.filter(|held_m| (held_m - height_m).abs() <= HELD_WITHIN_M);
            detection.platform_m[2] = *self.held_m.insert(held_m.unwrap_or(height_m));
        }
        carried
    }

    /// Number of waiting detections.
    pub fn waiting(&self) -> usize {
        self.queue.len()
    }

    /// Numbers of detections by what became of them.
    pub fn counts(&self) -> WaitingCounts {
        self.queue.counts
    }
}

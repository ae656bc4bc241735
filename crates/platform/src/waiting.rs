//! Detections that wait for the states of the platform.
//!
//! A sensor without elevation does not measure heights, and a tracker assumes targets to be anywhere within kilometres
//! above and below the sensor. A mast that moves up and down by metres would then seem to reveal target heights, by
//! changes of the slant range that are smaller than the range's error. The height of such a sensor is therefore held
//! until the height has changed by more than [`HELD_WITHIN_M`].

use frames::SystemFrame;
use observations::{Detection, DetectionKind};

use crate::carried::{Carried, Refusal};
use crate::history::History;
use crate::mount::Mount;
use crate::persistence::LookInterval;
use crate::state_queue::{StateQueue, WaitingCounts};

/// Change of height up to which the height of a sensor without elevation is held, metres.
pub const HELD_WITHIN_M: f64 = 50.0;

/// A detection that leaves, with the attached data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departure<T> {
    /// The detection in the system's terms, or the reason of the refusal.
    pub outcome: Result<Carried, Refusal>,
    /// The detection as measured.
    pub measured: Detection,
    /// Attached data: the time of receipt, for example.
    pub with_it: T,
}

/// Detections of a sensor on a platform that wait for the platform's states.
#[derive(Clone, Debug)]
pub struct WaitingRoom<T> {
    mount: Mount,
    default_sigmas: Option<[f64; 4]>,
    queue: StateQueue<Detection, T>,
    /// Height in which a sensor without elevation is held, metres.
    held_m: Option<f64>,
}

impl<T> WaitingRoom<T> {
    /// Makes a room for `waiting_max` detections of a sensor, with data ahead of the platform's states by at most
    /// `wait_ns`. `default_sigmas` serve detections without stated values.
    pub fn new(mount: Mount, default_sigmas: Option<[f64; 4]>, wait_ns: i64, waiting_max: usize) -> Self {
        Self {
            mount,
            default_sigmas,
            queue: StateQueue::new(wait_ns, waiting_max),
            held_m: None,
        }
    }

    /// With the interval between two looks of the sensor as configured, nanoseconds; otherwise the data show the
    /// interval.
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

    /// The sensor's data have ended: detections still waiting for a state are refused at the next call of
    /// [`Self::next`].
    pub fn end(&mut self) {
        self.queue.reached_ns = i64::MAX;
    }

    /// The next detection that need not wait any longer; `None` if the first detection must wait.
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

    /// A detection without elevation, from the height in which the sensor is held.
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

    /// Numbers of detections by outcome.
    pub fn counts(&self) -> WaitingCounts {
        self.queue.counts
    }
}

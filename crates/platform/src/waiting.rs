//! Detections that wait for the states of their platform.
//!
//! A detection often comes before the state after its time, without which there is no interpolation. It waits; how long
//! depends on the times of the data alone: when the sensor's data have run ahead of a detection by more than the wait,
//! the detection is refused and counted. Detections leave in the order in which they came.
//!
//! A sensor without elevation does not measure heights, and a tracker assumes its targets to be anywhere within
//! kilometres above and below the sensor. A mast that moves up and down by metres would then seem to reveal their
//! heights, by changes of the slant range that are smaller than its error. The height of such a sensor is therefore
//! held until it has changed by more than [`HELD_WITHIN_M`].

use std::collections::VecDeque;
use std::ops::AddAssign;

use frames::SystemFrame;
use observations::{Detection, DetectionKind};

use crate::carried::{Carried, Refusal};
use crate::history::History;
use crate::mount::Mount;
use crate::persistence::{LookInterval, variance_factor};
use crate::pose::{NoState, Pose};

/// Change of its height up to which the height of a sensor without elevation is held, metres.
pub const HELD_WITHIN_M: f64 = 50.0;

/// Numbers of detections by what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WaitingCounts {
    /// Carried into the system's terms.
    pub carried: u64,
    /// Refused: the platform's states did not reach the time within the wait, or none has come.
    pub no_state: u64,
    /// Refused: the states around the time are too far apart.
    pub gap: u64,
    /// Refused: the time is before the oldest kept state.
    pub too_old: u64,
    /// Refused: no room to wait.
    pub full: u64,
    /// Refused: without standard deviations, or without a direction.
    pub unusable: u64,
}

impl WaitingCounts {
    /// Number of refused detections.
    pub fn refused(&self) -> u64 {
        self.no_state + self.gap + self.too_old + self.full + self.unusable
    }

    /// Counts a refusal.
    pub fn count(&mut self, refusal: Refusal) {
        let counter = match refusal {
            Refusal::Position(state) | Refusal::Heading(state) | Refusal::Tilt(state) => match state {
                NoState::None | NoState::NotYet => &mut self.no_state,
                NoState::Gap => &mut self.gap,
                NoState::TooOld => &mut self.too_old,
            },
            Refusal::NoSigmas | Refusal::NoDirection => &mut self.unusable,
            Refusal::Full => &mut self.full,
        };
        *counter += 1;
    }
}

impl AddAssign for WaitingCounts {
    fn add_assign(&mut self, other: Self) {
        self.carried += other.carried;
        self.no_state += other.no_state;
        self.gap += other.gap;
        self.too_old += other.too_old;
        self.full += other.full;
        self.unusable += other.unusable;
    }
}

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
    wait_ns: i64,
    waiting: VecDeque<(Detection, T)>,
    waiting_max: usize,
    /// Latest time of the sensor's data, nanoseconds.
    reached_ns: i64,
    /// Height in which a sensor without elevation is held, metres.
    held_m: Option<f64>,
    looks: LookInterval,
    counts: WaitingCounts,
}

impl<T> WaitingRoom<T> {
    /// Makes a room for `waiting_max` detections of a sensor, whose data run ahead of the platform's states by at most
    /// `wait_ns`. `default_sigmas` serve detections that state none.
    pub fn new(mount: Mount, default_sigmas: Option<[f64; 4]>, wait_ns: i64, waiting_max: usize) -> Self {
        Self {
            mount,
            default_sigmas,
            wait_ns,
            waiting: VecDeque::with_capacity(waiting_max),
            waiting_max,
            reached_ns: i64::MIN,
            held_m: None,
            looks: LookInterval::default(),
            counts: WaitingCounts::default(),
        }
    }

    /// With the interval between two looks of the sensor as configured, nanoseconds; otherwise the data show it.
    #[must_use]
    pub fn with_looks(self, interval_ns: Option<i64>) -> Self {
        Self {
            looks: LookInterval::new(interval_ns),
            ..self
        }
    }

    /// A turn of the sensor begins at this time, nanoseconds.
    pub fn turned(&mut self, time_ns: i64) {
        self.looks.turned(time_ns);
    }

    /// Takes a detection. A detection without room comes back as a departure.
    pub fn take(&mut self, detection: Detection, with_it: T) -> Option<Departure<T>> {
        self.passed(detection.time_of_measurement_ns);
        self.looks.detected(detection.scan, detection.time_of_measurement_ns);
        if self.waiting.len() == self.waiting_max {
            self.counts.count(Refusal::Full);
            return Some(Departure {
                outcome: Err(Refusal::Full),
                measured: detection,
                with_it,
            });
        }
        self.waiting.push_back((detection, with_it));
        None
    }

    /// The sensor's data have come to this time, nanoseconds.
    pub fn passed(&mut self, time_ns: i64) {
        self.reached_ns = self.reached_ns.max(time_ns);
    }

    /// The sensor's data have ended: what still waits for a state is refused at the next call of [`Self::next`].
    pub fn end(&mut self) {
        self.reached_ns = i64::MAX;
    }

    /// The next detection that need not wait any longer; `None` if the first one must wait.
    pub fn next(&mut self, history: &History, frame: Option<&SystemFrame>) -> Option<Departure<T>> {
        let (detection, _) = self.waiting.front()?;
        let time_ns = detection.time_of_measurement_ns;
        let outcome = history
            .at(time_ns)
            .map_err(Refusal::Position)
            .map(|pose| self.persisting(pose, history))
            .and_then(|pose| self.mount.carry(detection, &pose, self.default_sigmas, frame));
        let may_come = matches!(
            outcome,
            Err(Refusal::Position(state) | Refusal::Heading(state) | Refusal::Tilt(state))
                if matches!(state, NoState::NotYet | NoState::None)
        );
        if may_come && self.reached_ns.saturating_sub(time_ns) <= self.wait_ns {
            return None;
        }
        let outcome = outcome.map(|carried| self.held(carried));
        match outcome {
            Ok(_) => self.counts.carried += 1,
            Err(refusal) => self.counts.count(refusal),
        }
        let (measured, with_it) = self.waiting.pop_front()?;
        Some(Departure {
            outcome,
            measured,
            with_it,
        })
    }

    /// The pose with standard deviations for errors that persist from look to look.
    fn persisting(&self, pose: Pose, history: &History) -> Pose {
        let correlation_s = history.assumed().attitude_correlation_s.s();
        match variance_factor(self.looks.s(), correlation_s) {
            1.0 => pose,
            factor => pose.with_angle_sigmas(factor.sqrt()),
        }
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
        self.waiting.len()
    }

    /// Numbers of detections by what became of them.
    pub fn counts(&self) -> WaitingCounts {
        self.counts
    }
}

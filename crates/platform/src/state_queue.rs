//! Measurements of a sensor that wait for the states of the platform.
//!
//! A measurement often comes before the state after the time of measurement, without which there is no interpolation.
//! Such a measurement waits; the duration depends on the times of the data alone: when the sensor's data have run ahead
//! of a measurement by more than the wait, the measurement is refused and counted. Measurements leave in the order of
//! arrival.

use std::collections::VecDeque;
use std::ops::AddAssign;

use crate::carried::Refusal;
use crate::history::History;
use crate::persistence::{LookInterval, variance_factor};
use crate::pose::{NoState, Pose};

/// Numbers of measurements by outcome.
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
    /// Number of refused measurements.
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

/// Measurements of a sensor that wait, each with the attached data.
#[derive(Clone, Debug)]
pub(crate) struct StateQueue<M, T> {
    wait_ns: i64,
    /// Time of each measurement, nanoseconds, the measurement, and the attached data.
    waiting: VecDeque<(i64, M, T)>,
    waiting_max: usize,
    /// Latest time of the sensor's data, nanoseconds.
    pub(crate) reached_ns: i64,
    pub(crate) looks: LookInterval,
    pub(crate) counts: WaitingCounts,
}

impl<M, T> StateQueue<M, T> {
    /// For `waiting_max` measurements of a sensor, with data ahead of the platform's states by at most `wait_ns`.
    pub(crate) fn new(wait_ns: i64, waiting_max: usize) -> Self {
        Self {
            wait_ns,
            waiting: VecDeque::with_capacity(waiting_max),
            waiting_max,
            reached_ns: i64::MIN,
            looks: LookInterval::default(),
            counts: WaitingCounts::default(),
        }
    }

    /// Lets a measurement wait; a measurement without room is counted, and comes back.
    pub(crate) fn push(&mut self, time_ns: i64, measurement: M, with_it: T) -> Option<(M, T)> {
        if self.waiting.len() == self.waiting_max {
            self.counts.count(Refusal::Full);
            return Some((measurement, with_it));
        }
        self.waiting.push_back((time_ns, measurement, with_it));
        None
    }

    /// The first measurement, carried by a pose of the platform or refused, and counted; `None` if the measurement must
    /// wait.
    pub(crate) fn next<C>(
        &mut self,
        history: &History,
        carry: impl Fn(&M, &Pose) -> Result<C, Refusal>,
    ) -> Option<(Result<C, Refusal>, M, T)> {
        let (time_ns, measurement, _) = self.waiting.front()?;
        let pose = history.at(*time_ns).map_err(Refusal::Position);
        let outcome = pose.and_then(|pose| carry(measurement, &self.persisting(pose, history)));
        let may_come = matches!(
            outcome,
            Err(Refusal::Position(state) | Refusal::Heading(state) | Refusal::Tilt(state))
                if matches!(state, NoState::NotYet | NoState::None)
        );
        if may_come && self.reached_ns.saturating_sub(*time_ns) <= self.wait_ns {
            return None;
        }
        match outcome {
            Ok(_) => self.counts.carried += 1,
            Err(refusal) => self.counts.count(refusal),
        }
        let (_, measurement, with_it) = self.waiting.pop_front()?;
        Some((outcome, measurement, with_it))
    }

    /// The pose with standard deviations for errors that persist from look to look.
    fn persisting(&self, pose: Pose, history: &History) -> Pose {
        let correlation_s = history.assumed().attitude_correlation_s.s();
        match variance_factor(self.looks.s(), correlation_s) {
            1.0 => pose,
            factor => pose.with_angle_sigmas(factor.sqrt()),
        }
    }

    /// Number of waiting measurements.
    pub(crate) fn len(&self) -> usize {
        self.waiting.len()
    }
}

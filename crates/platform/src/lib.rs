//! Platforms that move: the detections of a sensor on board in the system's terms (EL-11, HT-12).
//!
//! A sensor on a ship measures directions from the ship: relative to the bow, in a deck that rolls, from a mast that is
//! not where the navigation receiver is. A tracker needs the direction from a place in the system frame. The obvious
//! answer adds the heading to the bearing. This is wrong by degrees on a rolling deck, by the lever arm at short range,
//! and loses the navigation's own error: a heading error of 0.3° is 100 m at 20 km, and a tracker that does not receive
//! this error becomes certain of a wrong place.
//!
//! Three steps, each a pure function of the data:
//!
//! 1. [`History`] keeps the platform's latest states and interpolates these states to the time of a detection
//!    ([`Pose`]). A time in a gap that is too long is refused.
//! 2. [`Mount`] gives place and direction of the sensor on the platform. [`Mount::carry`] turns a detection into the
//!    system's terms, with standard deviations enlarged by the errors of position, heading and attitude (chain rule).
//! 3. [`WaitingRoom`] holds detections until the platform's states have reached the time of detection.
//!
//! `koseki track --platform` uses these three.
//!
//! # What correlation is lost
//!
//! An error of the heading is common to all detections of a scan, and nearly common to successive scans. Here the error
//! enters each detection as if it were that detection's own. A single track's covariance is right for errors that
//! change from scan to scan, also slowly if `attitude_correlation_s` states the slowness, and too small for a constant
//! heading error, as for any bias of a sensor. Two tracks are in truth displaced alike; the relative position of both
//! is better than stated by the covariances. A constant error belongs to the registration of sources in fusion, which
//! estimates an azimuth offset of each source.
//!
//! A detection has a standard deviation of each quantity and no correlations. The roll couples bearing and elevation:
//! [`Carried::covariance`] has the whole matrix, the detection the roots of the diagonal. The mean squared distance is
//! right with the diagonal, since the distance is normalised quantity by quantity.

#![forbid(unsafe_code)]

mod bearing_room;
mod carried;
mod carried_bearing;
mod channel;
mod height;
mod history;
mod jumps;
mod mount;
mod navigation;
mod on_board;
mod persistence;
mod pose;
mod rotation;
mod settings;
mod state;
mod state_queue;
mod waiting;

pub use bearing_room::BearingRoom;
pub use carried::{Carried, Refusal};
pub use history::{Added, History};
pub use jumps::{Jump, JumpLimits, JumpWatch};
pub use mount::{Bearings, Mount};
pub use navigation::{Navigation, Navigator};
pub use on_board::{OfflinePlatform, OnBoardSensor};
pub use pose::{AngleAt, NoState, Pose};
pub use rotation::Attitude;
pub use settings::Assumed;
pub use state::State;
pub use state_queue::WaitingCounts;
pub use waiting::{Departure, HELD_WITHIN_M, WaitingRoom};

//! Location of transmitters from bearings, arrival times and fixes of others (EL).
//!
//! A platform that passes a transmitter and measures only the transmitter's direction can still locate it, because the
//! direction changes as the platform moves. The accuracy depends on the platform's path, and the fixes of filters
//! wander in arcs and jump. This crate makes a trustworthy, smooth position of these fixes, for many emitters at once.
//!
//! Arrival times at several receivers ([`Locator::arrival`]) and ready-made fixes ([`Locator::fix`]) are other lines of
//! position in the same filters, alone or beside bearings.
//!
//! # A bearing's way
//!
//! 1. [`Locator::bearing`] checks the bearing and finds the emitter: by the id in the bearing, or by frequency and
//!    direction.
//! 2. Each model of the emitter's motion processes the bearing: fixed point, straight motion, or manoeuvres.
//!    (`smoother` describes the method and the treatment of wrong bearings.) `bank` mixes the models.
//! 3. If the geometry allows a fix, the fix's position, velocity and variance go through the [`selection`], a state
//!    machine independent of bearings, and becomes the output.
//!
//! ```
//! use observations::Bearing;
//! use locating::{Locator, Settings};
//!
//! let mut locator = Locator::new(Settings::default())?;
//! let emitter = [2_000.0_f64, 9_000.0_f64];
//! let mut last = None;
//! for second in 0..100 {
//!     let platform_m = [100.0 * f64::from(second), 0.0, 3_000.0];
//!     let report = locator.bearing(&Bearing {
//!         time_of_measurement_ns: i64::from(second) * 1_000_000_000,
//!         emitter_id: Some(7),
//!         bearing_rad: (emitter[0] - platform_m[0]).atan2(emitter[1] - platform_m[1]),
//!         sigma_rad: 0.02,
//!         platform_m,
//!         heading_rad: None,
//!         frequency_hz: None,
//!         pulse_interval_s: None,
//!     })?;
//!     last = report.or(last);
//! }
//! let report = last.expect("ten kilometres of baseline are enough");
//! assert!((report.output.position_m[0] - emitter[0]).abs() < 1.0);
//! assert!((report.output.position_m[1] - emitter[1]).abs() < 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Bearings are measured from the phases between antennas by [`music`], where no direction finder delivers ready-made
//! bearings.
//!
//! # Frame and limits
//!
//! Everything is in the plane, east and north of the system frame; a bearing is a horizontal angle, so height is not
//! observed. Over the distances of such measurements the plane and the earth differ by less than the bearings' errors.
//!
//! # Memory and time
//!
//! All memory is allocated in [`Locator::new`], some 28 kB per emitter. The cost of a bearing is bounded: each model
//! keeps [`LINES_MAX`] lines of bearing at most. Nothing here performs I/O or reads a clock; the same bearings give the
//! same bits.

#![forbid(unsafe_code)]

mod arrivals;
mod bank;
mod counts;
mod cue;
mod explanation;
mod gauss_newton;
mod kinematics;
mod line_of_bearing;
mod linear;
mod locator;
mod mixture;
mod motion;
pub mod music;
mod ranges;
mod rejection;
mod resumption;
mod search_start;
pub mod selection;
pub mod settings;
mod smoother;
mod triangulation;
mod window;

pub use bank::RawFix;
pub use counts::LocatorCounts;
pub use cue::TurnSide;
pub use explanation::{Decision, LocatorDecisionKind};
pub use locator::{EmitterReport, Locator, OWN_NUMBERS};
pub use motion::MotionModel;
pub use rejection::BearingRejection;
pub use resumption::{EmitterMemory, LeftEmitters};
pub use settings::{DroppedEmitter, Settings};
pub use window::WINDOW_MAX as LINES_MAX;

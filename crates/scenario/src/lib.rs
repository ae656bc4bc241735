//! A simulated world: targets that move by known laws, and sensors that see them imperfectly.
//!
//! A demonstration or a test needs reports whose truth is known. [`Truth`] says where every target is at any time;
//! a [`SimulatedSensor`] looks at it as a radar, a multilateration system or an ADS-B receiver would, tracks what it
//! sees with a filter of its own, and delivers sensor tracks; a [`SimulatedDirectionFinder`] flies about and measures
//! bearings of those that transmit; a [`SimulatedWideAreaSensor`] says from afar how many there are.
//!
//! Everything is a pure function of settings, seed and time. Truth is closed-form in time, so it can be asked for any
//! moment in any order and by any process, and never ends. Every random number is drawn from a stream of its own,
//! named by what it is for (seed, sensor, target, look), so no result depends on which other draws were made before.
//! A sensor process that is restarted in mid-scenario therefore finds the same truth and the same measurements; only
//! its tracks begin anew, as those of a real sensor would.
//!
//! Heights are above the ellipsoid ([`Truth::round`]), so that far from the origin targets are where the curvature of
//! the earth puts them. Simplifications: paths are drawn in the plane of the system's frame, radars measure the range
//! already corrected for slant, false targets have their heights above the plane, and no sensor confuses two targets
//! with each other; a radar that delivers plots may see several as one.

#![forbid(unsafe_code)]

mod direction_finder;
mod false_target;
mod formation;
mod formation_settings;
mod grouping;
mod local_track;
mod look;
mod measurement;
mod path;
mod plot;
mod random;
mod resolution;
mod schedule;
mod sensor;
mod sensor_settings;
mod settings;
mod target;
mod traffic;
mod truth;
mod wide_area;

pub use direction_finder::{DirectionFinderSettings, PlatformPose, SimulatedDirectionFinder};
pub use formation_settings::FormationSettings;
pub use plot::Plot;
pub use sensor::{FALSE_TARGETS_MAX, SimulatedSensor};
pub use sensor_settings::{SensorIdentity, SensorKind, SensorSettings};
pub use settings::{ScenarioSettings, TARGETS_MAX};
pub use target::{TargetKind, TargetState};
pub use truth::Truth;
pub use wide_area::{SimulatedWideAreaSensor, WideAreaSettings};

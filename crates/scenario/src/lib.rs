//! Simulated world: targets that follow known laws of motion, and sensors with imperfect observations.
//!
//! A demonstration or a test needs reports with known truth.
//!
//! - [`Truth`] gives the position of every target at any time.
//! - A [`SimulatedSensor`] observes the truth like a radar, a multilateration system or an ADS-B receiver. The
//!   sensor tracks the detections with a separate filter and delivers sensor tracks.
//! - A [`SimulatedDirectionFinder`] flies along a path and measures bearings of transmitters.
//! - A [`SimulatedAis`] receives what ships report about themselves.
//! - A [`SimulatedWideAreaSensor`] counts targets from afar.
//! - A [`Voyage`] is that of a rolling ship with a radar on board.
//!
//! Everything is a pure function of settings, seed and time. The truth is closed-form and unlimited in time: any
//! process can request any moment in any order. Every random number comes from a stream keyed by its purpose (seed,
//! sensor, target, look), so no result depends on earlier draws. A sensor process restarted in mid-scenario
//! therefore finds the same truth and the same measurements. Only its tracks restart, like those of a real sensor.
//!
//! Heights are above the ellipsoid ([`Truth::round`]), so that far from the origin targets follow the curvature of
//! the Earth. Simplifications: paths are drawn in the plane of the system's frame, radars measure the range already
//! corrected for slant, false targets have their heights above the plane, and no sensor confuses two targets with
//! each other. A radar that delivers plots may merge several targets.

#![forbid(unsafe_code)]

mod ais;
mod direction_finder;
mod false_target;
mod formation;
mod formation_settings;
mod grouping;
mod local_track;
mod look;
mod measurement;
mod on_board;
mod path;
mod plot;
mod random;
mod reply;
mod resolution;
mod schedule;
mod sensor;
mod sensor_settings;
mod settings;
mod simulated_array;
mod target;
mod traffic;
mod truth;
mod wide_area;
mod world;

pub use ais::{AisMessage, AisReport, AisSettings, AisShip, SimulatedAis};
pub use direction_finder::{DirectionFinderSettings, PlatformPose, SimulatedDirectionFinder};
pub use formation_settings::FormationSettings;
pub use on_board::{OnBoardSettings, SeaTarget, SimulatedShip, Voyage};
pub use plot::RadarPlot;
pub use sensor::{FALSE_TARGETS_MAX, SimulatedSensor};
pub use sensor_settings::{SensorIdentity, SensorKind, SensorSettings};
pub use settings::{ScenarioSettings, TARGETS_MAX};
pub use simulated_array::ArrayGeometry;
pub use target::{TargetKind, TargetState};
pub use truth::Truth;
pub use wide_area::{SimulatedWideAreaSensor, WideAreaSettings};
pub use world::{Instrument, VisibleTargets, World};

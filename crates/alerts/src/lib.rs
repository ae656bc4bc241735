//! Alerts: events and dangers about targets, by rules, from the states of system tracks.
//!
//! A threshold on an extrapolated state raises an alert for every error of a velocity. The states of Koseki have
//! covariances, so an alert is a statement about *futures*: a target's state is drawn many times from its Gaussian and
//! its motion models (`futures`), every draw goes on as its model does, and the share of draws in which the event
//! happens within the look-ahead is the probability of the event. An alert is raised at the rule's `probability`, and
//! cleared below half of it. So it neither comes and goes with the noise, nor waits for a number of repetitions.
//!
//! 1. A state becomes a `Target`: its place on the ground, its height, and their uncertainty.
//! 2. The rules judge it: one target (`area_rules`, `own_rules`), or with each of its neighbours (`pair_rules`).
//! 3. The `board` raises, keeps and clears: one alert for a rule, an area and a target or pair.
//!
//! The engine reads no clock and no topic. Its time is the reference time of the states, and the order is theirs: the
//! same states give the same alerts to the bit, whether they come from shared memory, a recording or a file.
//!
//! Sources: ICAO Doc 4444, *Air Traffic Management*, chapter 5 (separation minima); EUROCONTROL, *Guidelines for
//! Short Term Conflict Alert*, *for Minimum Safe Altitude Warning* and *for Area Proximity Warning* (2017); IMO
//! resolution MSC.192(79), 5.29 (closest point of approach).

#![forbid(unsafe_code)]

mod area_rules;
mod areas_of;
mod board;
mod engine;
mod futures;
mod own_rules;
mod pair_rules;
mod sentence;
mod settings;
mod target;
mod targets;

pub use areas_of::{AreaFile, AreaRefusal, NamedArea, named_areas};
pub use board::IN_FORCE_MAX;
pub use engine::AlertEngine;
pub use settings::{AlertRules, AlertSettings, AreaSettings, CircleSettings, Kind, Severity, Traffic};

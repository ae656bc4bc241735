//! Deployments on hosts that know each other only by their links: each with a folder of its own for what processes
//! share, and a relay between them that delays what passes.
//!
//! The executable of Koseki is taken from `$KOSEKI`, or from the workspace's target folder; without it the tests say
//! `skipped`, unless `$KOSEKI_REQUIRE_DATA` is set.

mod alarms;
mod arrival;
mod centres;
mod certificates;
mod clocks;
mod host;
mod kills;
mod mirror;
mod mistakes;
mod network;
mod reboot;
mod refusals;
mod relay;
mod remote_sensor;
mod silent;
mod two_centres;

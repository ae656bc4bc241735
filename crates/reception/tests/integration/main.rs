//! Records on their way to observations, sensor tracks and detections, from outside.

#[path = "../../../asterix/tests/files/mod.rs"]
mod files;
#[path = "../../../asterix/tests/integration/generator.rs"]
mod generator;
mod observation;
mod radar_plots;

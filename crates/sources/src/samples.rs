//! Samples that a source publishes.

use messages::{Cue, PlatformState, SensorBearing, SensorDetection, SensorTrack};

/// Samples of a source, each kind in the order of publication.
#[derive(Debug, Default)]
pub struct Samples {
    /// Detections of which tracks were made, to be published before these.
    pub detections: Vec<SensorDetection>,
    /// States of the platform from which bearings were measured.
    pub platforms: Vec<PlatformState>,
    /// Bearings of which tracks were made, to be published before these.
    pub bearings: Vec<SensorBearing>,
    /// Sensor tracks.
    pub tracks: Vec<SensorTrack>,
    /// Places where the sensor should look next, to be published after the tracks.
    pub cues: Vec<Cue>,
}

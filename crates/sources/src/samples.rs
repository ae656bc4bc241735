//! Samples published by a source.

use messages::{
    Cue, PlatformState, SensorArrival, SensorBearing, SensorDetection, SensorFix, SensorSpectrum, SensorTrack,
};

/// Samples of a source, each kind in the order of publication.
#[derive(Debug, Default)]
pub struct Samples {
    /// Detections behind the tracks, to be published before the tracks.
    pub detections: Vec<SensorDetection>,
    /// States of the platform from which bearings were measured.
    pub platforms: Vec<PlatformState>,
    /// Bearings behind the tracks, to be published before the tracks.
    pub bearings: Vec<SensorBearing>,
    /// Arrival times behind the tracks, to be published before the tracks.
    pub arrivals: Vec<SensorArrival>,
    /// Ready-made fixes behind the tracks, to be published before the tracks.
    pub fixes: Vec<SensorFix>,
    /// Spectra behind the bearings, if the spectra have a receiver.
    pub spectra: Vec<SensorSpectrum>,
    /// Sensor tracks.
    pub tracks: Vec<SensorTrack>,
    /// Whether `tracks` holds a picture of all tracks at an even time. The picture is to be published before the
    /// following scan, so that the order in a recording determines which scans the picture contains.
    pub has_picture: bool,
    /// Search regions for the sensor's next look, to be published after the tracks.
    pub cues: Vec<Cue>,
}

impl Samples {
    /// Number of samples of the kind of which there are most.
    pub fn most(&self) -> usize {
        let (measured, made) = (self.detections.len().max(self.bearings.len()), self.tracks.len());
        measured.max(made).max(self.arrivals.len()).max(self.fixes.len())
    }
}

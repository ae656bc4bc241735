//! The product under test: its executable, and what the bench does not start as a process.
//!
//! The program that runs the bench implements the trait. The bench therefore depends on no algorithm and on no
//! configuration, and an edit there does not rebuild the bench.

use std::path::Path;

use deployment::Deployment;
use messages::{SensorDetection, SensorTrack, SystemTrack};

/// Product under test.
pub trait Product: Sync {
    /// Executable of the processes.
    fn executable(&self) -> &Path;

    /// Reads `text` as the configuration in the file `path`.
    ///
    /// # Errors
    /// If the configuration is refused.
    fn deployment(&self, path: &Path, text: &str) -> anyhow::Result<Deployment>;

    /// Creates the fusion engine of the configuration `text`.
    ///
    /// # Errors
    /// If the configuration is refused.
    fn engine(&self, text: &str) -> anyhow::Result<Box<dyn Engine>>;

    /// Creates the engine of the first tracker process of the configuration `text`.
    ///
    /// # Errors
    /// If the configuration is refused, or has no tracker process.
    fn tracker(&self, text: &str) -> anyhow::Result<Box<dyn TrackerStage>>;
}

/// Fusion engine of a product.
pub trait Engine {
    /// Processes a report, and passes each changed system track to `changed`.
    fn take(&mut self, report: &SensorTrack, changed: &mut dyn FnMut(&SystemTrack));
}

/// Engine of a tracker process of a product: from an event of a sensor to samples of tracks.
pub trait TrackerStage {
    /// Processes an event of the sensor in this place. Returns the number of tracks made.
    fn event(&mut self, sensor: usize, event: &SensorDetection) -> usize;

    /// Time of the latest scan with tracks, nanoseconds.
    fn progress_ns(&self) -> i64;
}

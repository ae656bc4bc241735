//! The product under test, as far as the bench does not start it as a process.
//!
//! The executable implements the trait. The bench therefore depends on no algorithm and on no configuration, and an
//! edit there does not rebuild the bench.

use std::path::Path;

use deployment::Deployment;
use messages::{SensorTrack, SystemTrack};

/// Product under test.
pub trait Product: Sync {
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
}

/// Fusion engine of a product.
pub trait Engine {
    /// Processes a report, and passes each changed system track to `changed`.
    fn take(&mut self, report: &SensorTrack, changed: &mut dyn FnMut(&SystemTrack));
}

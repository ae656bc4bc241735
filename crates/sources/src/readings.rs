//! How adapters read the data of a deployment's sensors, by the numbers that the deployment gives.

use platform::{Assumed, JumpLimits, Mount};
use reception::ConversionModel;

use crate::pipeline::Processing;

/// How the data of a source are read.
#[derive(Clone, Debug)]
pub struct SourceReading {
    /// Place of the sensor, and permitted content and accuracy of the reports.
    pub model: ConversionModel,
    /// Place and directions on the platform, if on board a moving platform.
    pub mount: Option<Mount>,
    /// Origin of the tracks.
    pub processing: Processing,
}

/// How the states of a platform are read.
#[derive(Clone, Copy, Debug)]
pub struct PlatformReading {
    /// Assumptions where the states give no value.
    pub assumed: Assumed,
    /// Differences that count as jumps.
    pub jumps: JumpLimits,
}

/// How the data of a deployment are read.
#[derive(Clone, Debug, Default)]
pub struct Readings {
    /// The deployment's sources, then the sensors of tracker processes.
    pub sources: Vec<SourceReading>,
    /// The deployment's platforms.
    pub platforms: Vec<PlatformReading>,
    /// Models of the tracks that wide-area sensors count; `None` for sensors that count themselves.
    pub counted: Vec<Option<ConversionModel>>,
}

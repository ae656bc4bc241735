//! How adapters read what a deployment's sensors send, by the numbers that the deployment gives.

use platform::{Assumed, JumpLimits, Mount};
use reception::ConversionModel;

use crate::pipeline::Processing;

/// How the data of one source are read.
#[derive(Clone, Debug)]
pub struct SourceReading {
    /// Where the sensor stands, what its reports may contain, and how accurate they are.
    pub model: ConversionModel,
    /// Place and directions on the platform, if it is on board one that moves.
    pub mount: Option<Mount>,
    /// How its tracks come about.
    pub processing: Processing,
}

/// How the states of one platform are read.
#[derive(Clone, Copy, Debug)]
pub struct PlatformReading {
    /// Assumptions where its states give no value.
    pub assumed: Assumed,
    /// Differences that count as jumps.
    pub jumps: JumpLimits,
}

/// How the data of a deployment are read.
#[derive(Clone, Debug, Default)]
pub struct Readings {
    /// Its sources, and behind them the sensors of tracker processes.
    pub sources: Vec<SourceReading>,
    /// Its platforms.
    pub platforms: Vec<PlatformReading>,
    /// Models of the tracks that wide-area sensors count; `None` for sensors that count themselves.
    pub counted: Vec<Option<ConversionModel>>,
}

//! `koseki bench tracker`.

use std::path::PathBuf;

use bench_service::{TrackerBench, TrackerLoad};
use clap::Args;
use command_line::values::above_zero;

pub(super) const TRACKER_EXAMPLES: &str = "\
Examples:
  koseki bench tracker                                    8 sensors with 250 scans of 50 detections per second each
  koseki bench tracker --scans 10 --detections 1250       the same detections in larger scans

The tracker process's work without shared memory: joining the sensors' scans, and tracking. Scans are due at fixed
times. A scan begins when it is due and the scans before it are done, so the queue of a tracker that is too slow grows.";

/// `koseki bench tracker`.
#[derive(Debug, Args)]
pub(crate) struct TrackerArgs {
    /// Sensors
    #[arg(long, value_name = "K", default_value_t = 8)]
    sensors: usize,
    /// Targets
    #[arg(long, value_name = "N", default_value_t = 160)]
    targets: usize,
    /// Scans of each sensor per second
    #[arg(long, value_name = "R", default_value_t = 250.0)]
    scans: f64,
    /// Detections in a scan; those beyond the targets in view are false
    #[arg(long, value_name = "D", default_value_t = 50)]
    detections: usize,
    /// Least share of false detections
    #[arg(long = "false", value_name = "SHARE", default_value_t = 0.02)]
    false_share: f64,
    /// Simulated time before the measurement
    #[arg(long, value_name = "SECONDS", default_value_t = 2.0, value_parser = above_zero)]
    warm_up: f64,
    /// Simulated time of the measurement
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0, value_parser = above_zero)]
    seconds: f64,
    /// Core to run on
    #[arg(long, value_name = "CORE", default_value_t = 0)]
    core: usize,
    /// Write all figures to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl TrackerArgs {
    /// Returns the settings.
    pub(crate) fn orders(self) -> TrackerBench {
        TrackerBench {
            load: TrackerLoad {
                sensors: self.sensors,
                targets: self.targets,
                scans_per_s: self.scans,
                detections: self.detections,
                false_share: self.false_share,
                warm_up_s: self.warm_up,
                seconds: self.seconds,
            },
            core: self.core,
            json: self.json,
        }
    }
}

//! Observations: single reports of sensors, before anything has been made of them.
//!
//! - [`Observation`]: a target report of any format, still in the sensor's own terms;
//! - [`Detection`]: a measurement in the system frame, for sensors whose tracks Koseki makes;
//! - [`SensorEvent`]: a detection, or a mark of the sensor's time among its detections;
//! - [`Bearing`]: the direction of an emitter, from a direction finder that measures nothing else;
//! - [`Arrival`]: when a transmission of an emitter arrived at a receiver; [`ReadyFix`]: its position, found by others;
//! - [`SnapshotBlock`]: samples of an antenna array, from which bearings are measured;
//! - [`Statement`]: what a target states beside its motion: category, size, status, intention; places of fixed
//!   stations;
//! - [`WideAreaReport`]: the number of targets that a wide-area sensor has seen.
//!
//! Formats read and write these types, and algorithms process them, independently of each other. [`Sampled`] is the
//! only conversion between such a value and its sample in shared memory.

#![forbid(unsafe_code)]

mod alerts;
mod arrival;
mod bearing;
mod detection;
mod observation;
mod sensor_event;
mod snapshot_block;
mod statement;
mod wide_area;

pub use alerts::Alerts;
pub use arrival::{Arrival, ArrivalTime, EmitterMeasurement, ReadyFix, Receiver, ReceiverName};
pub use bearing::Bearing;
pub use detection::{
    Detection, DetectionPlatform, DetectionTruth, QUANTITIES_MAX, StatedHeight, StatedVelocity, TransponderReply,
};
pub use messages::{AidKind, Emergency, NavigationStatus, TargetCategory};
pub use messages::{DetectionKind, Quantity};
pub use observation::{Axes, Observation, Plane, Position, Quality, RADIUS95_SIGMAS, ServiceMessage, TRUNCATION_NS};
pub use sensor_event::SensorEvent;
pub use snapshot_block::SnapshotBlock;
pub use statement::{FixedStation, Statement};
pub use wide_area::WideAreaReport;

use messages::StageTimes;

/// A value that shared memory carries as a sample.
pub trait Sampled: Sized {
    /// The sample.
    type Sample;

    /// The sample of source or sensor number `source`; sequence number and time of publication are left to the
    /// publisher.
    fn sample(&self, source: u16, stages: StageTimes) -> Self::Sample;

    /// The value of a sample, to the last bit; `None` for a code of another schema.
    fn of_sample(sample: &Self::Sample) -> Option<Self>;
}

/// The id under which files show a source: its place in the configuration, from 1.
pub fn sensor_id(source: u16) -> u32 {
    u32::from(source) + 1
}

/// `bit` if `condition` holds, else no bit.
fn flag<Bits: Default>(condition: bool, bit: Bits) -> Bits {
    if condition { bit } else { Bits::default() }
}

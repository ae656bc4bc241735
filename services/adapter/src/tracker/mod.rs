//! Tracker process: the detections of several sensors become the tracks of a single source (HT-12).
//!
//! Live, each sensor's adapter, or a process of the integrator, publishes the sensor's detections; the tracker process
//! takes the detections from the topics ([`live`]). Recorded sensors are read from files here ([`recorded`]), so that
//! the tracks do not depend on the speed of other processes. Both give the same events to the same tracker
//! ([`sources::DetectionTracker`]), and publish each event before any decision about the event
//! (`sensor/<tracker>/detections`). `koseki track` repeats the tracks from these recorded events.

mod live;
mod on_board;
mod orders;
mod recorded;

use runtime::Agent;
use runtime::Process;

use crate::Processed;
use live::TrackerAgent;

/// The agent of a tracker process.
///
/// # Errors
/// If the input cannot be read, or shared memory fails.
pub(crate) fn agent(process: &Process, tracker: Processed<'_>) -> anyhow::Result<Box<dyn Agent>> {
    Ok(match tracker.source.input.is_recorded() {
        true => Box::new(recorded::replay(process, tracker)?),
        false => Box::new(TrackerAgent::open(process, tracker)?),
    })
}

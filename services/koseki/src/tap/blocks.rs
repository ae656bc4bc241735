//! System tracks as ASTERIX: blocks of CAT062, as sent by a gateway, in the deployment's system frame.

use std::time::Duration;

use anyhow::Context as _;
use asterix::registry;
use bus::{Bus, ReceiveOutcome, SharedMemory, WaitMode};
use frames::{Geodetic, SystemFrame};
use messages::SystemTrack;
use messages::layout::Sample as _;
use offline::Usage;
use outgoing::SystemReports;
use runtime::clock::mono_ns;
use runtime::signals::Stop;

use crate::args::Tap;

/// Largest size of a block, bytes: a block fits a datagram.
const BLOCK_OCTETS_MAX: usize = 1_400;
const CATEGORY: u8 = 62;
/// Longest wait between two checks for a stop request.
const LOOK: Duration = Duration::from_millis(100);

/// Writes system tracks.
pub(super) struct TapBlocks(SystemReports);

impl TapBlocks {
    /// Returns a writer for the deployment on `bus`; `None` after a stop or the deployment's end before the frame
    /// arrives.
    ///
    /// # Errors
    /// If the topic that is tapped is another, or cannot be read.
    pub(super) fn open(tap: &Tap, bus: &Bus<SharedMemory>, stop: &Stop) -> anyhow::Result<Option<Self>> {
        if tap.topic() != messages::system_tracks().name.as_str() {
            return Err(Usage(format!("CAT062 is for system tracks: {} has none", tap.topic())).into());
        }
        let Some(frame) = frame(bus, stop)? else {
            return Ok(None);
        };
        let table = registry::default_edition(CATEGORY).context("CAT062 has a table")?;
        let reports = SystemReports::new(table, tap.sac, tap.sic, frame, &[], BLOCK_OCTETS_MAX)?;
        Ok(Some(Self(reports.with_height(tap.heights))))
    }

    /// Appends the block that a state completes.
    pub(super) fn write(&mut self, sample: &[u8], octets: &mut Vec<u8>) {
        if let Some(track) = SystemTrack::of_octets(sample) {
            self.0.report(&track, &mut |block| octets.extend_from_slice(block));
        }
    }

    /// Appends the block that is being filled.
    pub(super) fn flush(&mut self, octets: &mut Vec<u8>) {
        self.0.flush(&mut |block| octets.extend_from_slice(block));
    }
}

/// Waits for the system frame, which the monitor publishes repeatedly.
fn frame(bus: &Bus<SharedMemory>, stop: &Stop) -> anyhow::Result<Option<SystemFrame>> {
    let topic = messages::frame_origin();
    let mut origins = bus.subscriber(&topic, || mono_ns() as u64)?;
    let mut waiter = bus.waiter(WaitMode::Event);
    waiter.watch(bus, &topic)?;
    while !stop.requested() && bus.goes_on()? {
        if let ReceiveOutcome::Slice(slice) = origins.receive()?
            && let Some(origin) = slice.samples().last()
        {
            let place = Geodetic::from_degrees(origin.latitude_deg, origin.longitude_deg, origin.height_m)?;
            return Ok(Some(SystemFrame::at(place)));
        }
        waiter.wait(LOOK, || origins.has_slices())?;
    }
    Ok(None)
}

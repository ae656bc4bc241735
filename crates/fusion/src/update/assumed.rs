//! Assumptions of fusion beside the measurements, for readers of filter inputs.

use crate::publish::publishing::TrackPublisher;
use crate::tables::system_tracks::SystemSlot;
use crate::tables::tracks::Tracks;
use crate::update::filter_input::Assumed;

/// Returns the assumptions on the target of a system track.
pub(crate) fn assumed_of(system: SystemSlot, tracks: &Tracks, publisher: &TrackPublisher) -> Assumed {
    Assumed {
        motion: *tracks.sources.motion(tracks.systems.get(system).filter.velocity_mps()),
        unseen: publisher.unseen(),
    }
}

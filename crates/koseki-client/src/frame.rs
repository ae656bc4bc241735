//! The system frame of a deployment, as the deployment publishes its origin.

use std::time::Duration;

use bus::Root;
use frames::{Geodetic, SystemFrame};
use messages::FrameOrigin;

use crate::clock::mono_ns;
use crate::error::Error;
use crate::subscription::Subscription;

/// Longest wait for the origin, which a running deployment publishes five times a second.
const PATIENCE: Duration = Duration::from_secs(10);

/// Returns the frame in which the deployment at `root` has its positions: metres east, north and up of an origin.
///
/// # Errors
/// If the deployment does not run, or publishes no origin within 10 s.
pub fn frame(root: &Root) -> Result<SystemFrame, Error> {
    let mut origins = Subscription::at(root, &messages::frame_origin())?;
    let begin = mono_ns();
    let absent = || Error::NoOrigin {
        instance: root.instance().to_owned(),
    };
    loop {
        let waited = Duration::from_nanos(mono_ns() - begin);
        let left = PATIENCE.checked_sub(waited).ok_or_else(absent)?;
        if let Some(slice) = origins.next(left)?
            && let Some(origin) = slice.last()
        {
            return of_origin(origin).ok_or_else(absent);
        }
    }
}

/// Returns the frame with a published origin; `None` if the origin is no place.
fn of_origin(origin: &FrameOrigin) -> Option<SystemFrame> {
    let place = Geodetic::from_degrees(origin.latitude_deg, origin.longitude_deg, origin.height_m);
    place.ok().map(SystemFrame::at)
}

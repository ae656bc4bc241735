//! Topics of other deployments as external sources of this one.
//!
//! Stamps of the other host's monotonic clock are turned into this one's, as far as the clocks have been compared, and
//! positions into this deployment's frame.

use anyhow::anyhow;
use bus::Payload;
use configuration::{Link, RemoteTopic};
use frames::{FrameChange, SystemFrame};
use messages::{FrameOrigin, Outgoing, Topic};

use crate::frame::{self, Placed};
use crate::inbound::{Arrival, Counts, Inlet, Wanted};
use crate::stand_in::StandIn;

/// What `link` receives, for external sources of the deployment whose frame is `frame`.
///
/// # Errors
/// If something is no topic that is fed from outside.
pub(crate) fn wanted(link: &Link, frame: SystemFrame) -> anyhow::Result<Vec<Wanted>> {
    let wanted = |remote: &RemoteTopic| {
        let mut parts = remote.into.split('/');
        let (kind, name) = (parts.next(), parts.next().unwrap_or_default().to_owned());
        let inlet: Box<dyn FnOnce() -> Box<dyn Inlet> + Send> = match kind {
            Some("sensor") => Box::new(move || Feed::open(frame, messages::sensor_tracks(&name))),
            Some("wide-area") => Box::new(move || Feed::open(frame, messages::wide_area(&name))),
            _ => return Err(anyhow!("{} is no topic that is fed from outside", remote.into)),
        };
        Ok(Wanted {
            deployment: remote.deployment.clone(),
            topic: remote.topic.clone(),
            inlet,
        })
    };
    link.receive.iter().map(wanted).collect()
}

struct Feed<T: Payload> {
    stand_in: StandIn<T>,
    frame: SystemFrame,
    /// Frame of what came last, and the change from there; `None` where it is this deployment's.
    change: (FrameOrigin, Option<FrameChange>),
}

impl<T: Outgoing + Payload + Placed> Feed<T> {
    fn open(frame: SystemFrame, topic: Topic<T>) -> Box<dyn Inlet> {
        Box::new(Self {
            stand_in: StandIn::new(topic),
            frame,
            change: (FrameOrigin::default(), None),
        })
    }
}

impl<T: Outgoing + Payload + Placed> Inlet for Feed<T> {
    fn take(&mut self, arrival: Arrival<'_>, counts: &mut Counts) -> anyhow::Result<()> {
        let Some((head, slices)) = self.stand_in.read(&arrival, counts) else {
            return Ok(());
        };
        if self.change.0 != head.frame {
            self.change = match frame::change(&head.frame, &self.frame) {
                Some(change) => (head.frame, change),
                None => {
                    counts.rejected += 1;
                    return Ok(());
                }
            };
        }
        let (change, now) = (self.change.1, arrival.now);
        for (header, samples) in slices {
            let Some(missing) = self.stand_in.missing(&header) else {
                counts.rejected += 1;
                continue;
            };
            counts.missing += missing;
            counts.published += samples.len() as u64;
            let origin = (&header, head.origin);
            self.stand_in
                .publish(arrival.bus, origin, &samples, now, |sample, sequence| {
                    let here_ns = arrival.offset_ns.map(|offset_ns| sample.ingested_ns() - offset_ns);
                    sample.came_in(here_ns.unwrap_or(now.mono_ns));
                    if let Some(change) = &change {
                        sample.change_frame(change);
                    }
                    sample.leave(sequence, now.mono_ns);
                })?;
            self.stand_in.pass(&header, samples.len());
        }
        Ok(())
    }
}

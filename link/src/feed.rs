//! Topics of other deployments as external sources of this one.
//!
//! System tracks of another centre become sensor tracks, each with the sources here that share a sensor with it; echoes
//! of tracks of this deployment are left out.
//!
//! Positions are turned into this deployment's frame. While the hosts' clocks have not been compared, a sample counts
//! as taken in when it came.

use anyhow::anyhow;
use bus::Payload;
use configuration::{Config, Link, RemoteTopic};
use frames::{FrameChange, SystemFrame};
use messages::{FrameOrigin, Outgoing, SensorTrack, SystemTrack, Topic, WideArea, sensor_track_bits};

use crate::frame::{self, Placed};
use crate::inbound::{Arrival, Counts, Inlet, Wanted};
use crate::stand_in::StandIn;

/// What `link` receives, for external sources of the deployment that `config` describes.
///
/// # Errors
/// If something is no topic that is fed from outside.
pub(crate) fn wanted(link: &Link, config: &Config) -> anyhow::Result<Vec<Wanted>> {
    let frame = config.frame;
    let pictures = [messages::own_tracks(), messages::system_tracks()];
    let wanted = |remote: &RemoteTopic| {
        let mut parts = remote.into.split('/');
        let (kind, name) = (parts.next(), parts.next().unwrap_or_default().to_owned());
        let inlet: Box<dyn FnOnce() -> Box<dyn Inlet> + Send> = match kind {
            Some("sensor") if pictures.iter().any(|picture| picture.name.as_str() == remote.topic) => {
                let uids: Vec<u32> = config.sources.iter().map(|source| source.uid).collect();
                let origin = config.origin;
                // The fused picture names those that contribute now, not all that have.
                let names_all = remote.topic == messages::own_tracks().name.as_str();
                let unnamed = if names_all { 0 } else { sensor_track_bits::CONTRIBUTORS };
                let report = move |track: &SystemTrack| {
                    let mut report = SensorTrack::of_centre(track, 0, origin, &uids)?;
                    report.valid &= !unnamed;
                    Some(report)
                };
                Box::new(move || Feed::open(frame, messages::sensor_tracks(&name), report))
            }
            Some("sensor") => {
                let copy = |sample: &SensorTrack| Some(*sample);
                Box::new(move || Feed::open(frame, messages::sensor_tracks(&name), copy))
            }
            Some("wide-area") => {
                let copy = |sample: &WideArea| Some(*sample);
                Box::new(move || Feed::open(frame, messages::wide_area(&name), copy))
            }
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

/// Makes a sample here of one that came; `None` if it is left out.
type Reading<R, T> = Box<dyn Fn(&R) -> Option<T>>;

struct Feed<R, T: Payload> {
    stand_in: StandIn<T>,
    reading: Reading<R, T>,
    frame: SystemFrame,
    /// Frame of what came last, and the change from there; `None` where it is this deployment's.
    change: (FrameOrigin, Option<FrameChange>),
}

impl<R: Payload, T: Outgoing + Payload + Placed> Feed<R, T> {
    fn open(frame: SystemFrame, topic: Topic<T>, reading: impl Fn(&R) -> Option<T> + 'static) -> Box<dyn Inlet> {
        Box::new(Self {
            stand_in: StandIn::new(topic),
            reading: Box::new(reading),
            frame,
            change: (FrameOrigin::default(), None),
        })
    }
}

impl<R: Payload, T: Outgoing + Payload + Placed> Inlet for Feed<R, T> {
    fn take(&mut self, arrival: Arrival<'_>, counts: &mut Counts) -> anyhow::Result<()> {
        let Some((head, slices)) = self.stand_in.read::<R>(&arrival, counts) else {
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
            let taken: Vec<T> = samples.iter().filter_map(&self.reading).collect();
            counts.published += taken.len() as u64;
            let origin = (&header, head.origin);
            self.stand_in
                .publish(arrival.bus, origin, &taken, now, |sample, sequence| {
                    if sample.ingested_ns() == 0 {
                        sample.came_in(now.mono_ns);
                    }
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

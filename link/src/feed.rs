//! Topics of other deployments as external sources of this one.
//!
//! System tracks of another centre become sensor tracks, each with the sources here that share a sensor with it; echoes
//! of tracks of this deployment are left out.
//!
//! Positions are turned into this deployment's frame. While the hosts' clocks have not been compared, a sample counts
//! as taken in when it came.

use anyhow::anyhow;
use bus::{Bus, Payload, SharedMemory};

use deployment::{Deployment, Link, RemoteTopic};
use frames::{FrameChange, SystemFrame};
use messages::{FrameOrigin, Outgoing, SensorTrack, SystemTrack, Topic, WideArea, sensor_track_bits};
use runtime::Now;

use crate::frame::{self, Placed};
use crate::in_order::{InOrder, SlicePublisher};
use crate::inbound::{Arrival, InboundCounts, Inlet, Wanted};
use crate::keys;
use crate::stand_in::{PublisherNumbers, StandIn};
use crate::wire::{Head, SliceCopy};

/// Returns the topics that `link` receives for external sources of the deployment `config`.
///
/// # Errors
/// If something is no topic that is fed from outside.
pub(crate) fn wanted(link: &Link, config: &Deployment) -> anyhow::Result<Vec<Wanted>> {
    let frame = config.frame;
    let pictures = [messages::own_tracks(), messages::system_tracks()];
    let wanted = |remote: &RemoteTopic| {
        let mut parts = remote.into().split('/');
        let (kind, name) = (parts.next(), parts.next().unwrap_or_default().to_owned());
        let again = keys::again(&keys::topic_of_any_layout(&remote.deployment, &remote.topic));
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
                Box::new(move || TopicFeed::open(None, frame, messages::sensor_tracks(&name), report))
            }
            Some("sensor") => {
                let copy = |sample: &SensorTrack| Some(*sample);
                Box::new(move || TopicFeed::open(Some(again), frame, messages::sensor_tracks(&name), copy))
            }
            Some("wide-area") => {
                let copy = |sample: &WideArea| Some(*sample);
                Box::new(move || TopicFeed::open(Some(again), frame, messages::wide_area(&name), copy))
            }
            _ => return Err(anyhow!("{} is no topic that is fed from outside", remote.into())),
        };
        Ok(Wanted {
            deployment: remote.deployment.clone(),
            topic: remote.topic.clone(),
            inlet,
        })
    };
    link.receive.iter().map(wanted).collect()
}

/// Converter from a received to a local sample; `None` if the sample is omitted.
type SampleConverter<R, T> = Box<dyn Fn(&R) -> Option<T>>;

struct TopicFeed<R, T: Payload> {
    stand_in: StandIn<T>,
    reading: SampleConverter<R, T>,
    frame: SystemFrame,
    /// Frame of the latest sample, and the change from this frame; `None` if it is this deployment's frame.
    change: (FrameOrigin, Option<FrameChange>),
}

impl<R: Payload, T: Outgoing + Payload + Placed> TopicFeed<R, T> {
    /// Opens an inlet to the local `topic`; missing samples are requested at the key `again`.
    fn open(
        again: Option<String>,
        frame: SystemFrame,
        topic: Topic<T>,
        reading: impl Fn(&R) -> Option<T> + 'static,
    ) -> Box<dyn Inlet> {
        let feed = Self {
            stand_in: StandIn::new(topic),
            reading: Box::new(reading),
            frame,
            change: (FrameOrigin::default(), None),
        };
        Box::new(InOrder::new(feed, again))
    }
}

impl<R: Payload, T: Outgoing + Payload + Placed> SlicePublisher for TopicFeed<R, T> {
    type Came = R;

    fn read(&mut self, arrival: &Arrival<'_>, counts: &mut InboundCounts) -> Option<(Head, Vec<SliceCopy<R>>)> {
        self.stand_in.read(arrival, counts)
    }

    fn numbers(&self) -> &PublisherNumbers {
        &self.stand_in.numbers
    }

    fn slice_len(&self) -> usize {
        self.stand_in.topic.capacity.slice_len
    }

    fn publish(
        &mut self,
        bus: &Bus<SharedMemory>,
        now: Now,
        (head, (header, samples)): (&Head, &SliceCopy<R>),
        counts: &mut InboundCounts,
    ) -> anyhow::Result<()> {
        if self.change.0 != head.frame {
            self.change = match frame::change(&head.frame, &self.frame) {
                Some(change) => (head.frame, change),
                None => {
                    counts.rejected += 1;
                    return Ok(());
                }
            };
        }
        let change = self.change.1;
        let taken: Vec<T> = samples.iter().filter_map(&self.reading).collect();
        counts.published += taken.len() as u64;
        let origin = (header, head.origin);
        self.stand_in.publish(bus, origin, &taken, now, |sample, sequence| {
            if sample.ingested_ns() == 0 {
                sample.came_in(now.mono_ns);
            }
            if let Some(change) = &change {
                sample.change_frame(change);
            }
            sample.leave(sequence, now.mono_ns);
        })?;
        self.stand_in.pass(header, samples.len());
        Ok(())
    }
}

//! Transports to the two measured processes: fusion, and a bare relay in its place.

use std::time::Duration;

use bus::{BareReceiver, BareSender, BareSettings, Bus, Mark, Publisher, SharedMemory, Subscriber, WaitMode, Waiter};
use messages::{SensorTrack, SystemTrack};
use runtime::clock::mono_ns;

use crate::drive::{ReportSender, SendTime, StateReceiver};
use crate::settings::Settings;

/// Services of the relay.
pub(crate) const RELAY_IN: &str = "bench/relay/in";
pub(crate) const RELAY_OUT: &str = "bench/relay/out";
/// Name of source number `number`.
pub(crate) fn source_name(number: u16) -> String {
    format!("source-{number}")
}

/// Returns the number of reports that the sources' topics hold before dropping the oldest.
pub(crate) fn queues(settings: &Settings) -> usize {
    let depth = messages::sensor_tracks(&source_name(0)).capacity.depth;
    usize::from(settings.sources) * depth * settings.batch
}

/// Returns the common settings of both ends of the relay's services. As many slices wait there as in the topics of all
/// `sources` together: with the depth of one topic, the relay would lose reports that fusion still takes.
pub(crate) fn relay_settings(slice_len: usize, events: bool, sources: u16) -> BareSettings {
    BareSettings {
        depth: usize::from(sources) * messages::sensor_tracks(&source_name(0)).capacity.depth,
        slice_len,
        events,
    }
}

/// Topics of all sources.
#[derive(Debug)]
pub(crate) struct ToFusion(Vec<Publisher<SharedMemory, SensorTrack>>);

impl ToFusion {
    pub(crate) fn open(bus: &Bus<SharedMemory>, settings: &Settings) -> anyhow::Result<Self> {
        let incarnation = mono_ns() as u64;
        let open = |number| bus.publisher(&messages::sensor_tracks(&source_name(number)), incarnation);
        let publishers: Result<_, _> = (0..settings.sources).map(open).collect();
        Ok(Self(publishers?))
    }
}

impl ReportSender for ToFusion {
    fn send(
        &mut self,
        source: u16,
        mark: SendTime,
        count: usize,
        mut fill: impl FnMut(usize) -> SensorTrack,
    ) -> anyhow::Result<()> {
        let mark = Mark {
            progress_ns: mark.progress_ns,
            sent_ns: mark.now_ns,
            end: false,
        };
        self.0[usize::from(source)].send(mark, count, |index, sequence| {
            let mut report = fill(index);
            report.sequence = sequence;
            report
        })?;
        Ok(())
    }
}

/// Topic of the system tracks.
#[derive(Debug)]
pub(crate) struct FromFusion {
    subscriber: Subscriber<SharedMemory, SystemTrack>,
    waiter: Waiter<SharedMemory>,
}

impl FromFusion {
    pub(crate) fn open(bus: &Bus<SharedMemory>, wait: WaitMode) -> anyhow::Result<Self> {
        let topic = messages::system_tracks();
        let mut waiter = bus.waiter(wait);
        waiter.watch(bus, &topic)?;
        Ok(Self {
            subscriber: bus.subscriber(&topic, || mono_ns() as u64)?,
            waiter,
        })
    }
}

impl StateReceiver for FromFusion {
    fn receive(&mut self, visit: impl FnOnce(&[SystemTrack])) -> anyhow::Result<bool> {
        let mut visit = Some(visit);
        let taken = self.subscriber.take(1, |_, tracks| {
            if let Some(visit) = visit.take() {
                visit(tracks);
            }
        })?;
        Ok(taken > 0)
    }

    fn lost(&self) -> u64 {
        self.subscriber.counts().lost
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        self.waiter.wait(at_most, || self.subscriber.has_slices())?;
        Ok(())
    }
}

/// Path to the relay: one service for all sources.
#[derive(Debug)]
pub(crate) struct ToRelay(BareSender<SensorTrack>);

impl ToRelay {
    pub(crate) fn open(bus: &Bus<SharedMemory>, settings: BareSettings) -> anyhow::Result<Self> {
        Ok(Self(BareSender::open(bus, RELAY_IN, settings)?))
    }
}

impl ReportSender for ToRelay {
    fn send(
        &mut self,
        _: u16,
        _: SendTime,
        count: usize,
        fill: impl FnMut(usize) -> SensorTrack,
    ) -> anyhow::Result<()> {
        Ok(self.0.send(count, fill)?)
    }
}

/// Path back from the relay.
#[derive(Debug)]
pub(crate) struct FromRelay(BareReceiver<SystemTrack>);

impl FromRelay {
    pub(crate) fn open(bus: &Bus<SharedMemory>, settings: BareSettings) -> anyhow::Result<Self> {
        Ok(Self(BareReceiver::open(bus, RELAY_OUT, settings)?))
    }
}

impl StateReceiver for FromRelay {
    fn receive(&mut self, visit: impl FnOnce(&[SystemTrack])) -> anyhow::Result<bool> {
        Ok(self.0.receive(visit)?)
    }

    /// Relay slices have no numbers; losses appear as unanswered reports.
    fn lost(&self) -> u64 {
        0
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        Ok(self.0.wait(at_most)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::test_settings;

    #[test]
    fn the_relay_has_the_queues_of_all_sources() {
        let settings = Settings {
            sources: 4,
            batch: 1,
            ..test_settings()
        };
        assert_eq!(relay_settings(16, false, 4).depth, queues(&settings));
    }
}

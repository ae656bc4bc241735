//! Topics of a deployment.

use messages::{Stream, StreamId, SystemTrack, Topic};

use crate::Deployment;

/// Use of published decisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecisionUse {
    /// Recordings and other readers: none may be lost.
    Record,
    /// The display alone, which shows the latest: a burst may exceed the queue of the topic.
    Show,
}

impl Deployment {
    /// Topic of the system tracks, with the longest queue that its readers may request.
    pub fn system_tracks_topic(&self) -> Topic<SystemTrack> {
        let mut topic = messages::system_tracks();
        topic.capacity.depth = self.machine.queue_slices;
        topic
    }

    /// Data streams, each with the name of its source or sensor (of none for those of the system as a whole): source by
    /// source, then the wide-area sensors, then the system.
    pub fn streams(&self) -> impl Iterator<Item = (StreamId, &str)> {
        let of_sources = self.sources.iter().flat_map(|source| {
            let locates = source.publishes_bearings();
            let streams = [
                (Stream::SensorTracks, true),
                (Stream::Detections, source.has_detections()),
                (Stream::Cues, source.has_cues()),
                (Stream::Bearings, locates),
                (Stream::Arrivals, source.has_emitter_rows()),
                (Stream::Fixes, source.has_emitter_rows()),
                (Stream::PlatformStates, locates),
                (Stream::Statements, source.has_statements),
            ];
            let there = streams.into_iter().filter(|(_, is_there)| *is_there);
            there.map(|(stream, _)| (stream, source.number, source.name.as_str()))
        });
        let sensors = self.wide_area_sensors.iter();
        let of_sensors = sensors.map(|sensor| (Stream::WideArea, sensor.number, sensor.name.as_str()));
        let decisions = self.decision_use().map(|_| StreamId::DECISIONS);
        let of_system = [StreamId::SYSTEM_TRACKS, StreamId::ALARMS, StreamId::ORDERS];
        let alerts = self.services.alerts.then_some(StreamId::ALERTS);
        let of_system = of_system.into_iter().chain(decisions).chain(alerts);
        of_sources
            .chain(of_sensors)
            .map(|(stream, number, name)| (StreamId { stream, number }, name))
            .chain(of_system.map(|id| (id, "")))
    }

    /// The [streams](Self::streams) of a recording: decisions only if they are asked for.
    pub fn recorded_streams(&self) -> impl Iterator<Item = (StreamId, &str)> {
        let is_recorded = |id: &StreamId| id.stream != Stream::Decisions || self.fusion.decisions;
        self.streams().filter(move |(id, _)| is_recorded(id))
    }

    /// Use of the published decisions of fusion; `None`: no decisions are published.
    pub fn decision_use(&self) -> Option<DecisionUse> {
        match (self.fusion.decisions, self.services.display) {
            (true, _) => Some(DecisionUse::Record),
            (false, true) => Some(DecisionUse::Show),
            (false, false) => None,
        }
    }
}

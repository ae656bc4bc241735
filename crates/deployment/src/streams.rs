//! Topics of a deployment.

use bus::BusError;
use messages::{Stream, StreamId, SystemTrack, Topic};
use runtime::DecisionUse;
use runtime::instance::Visit;

use crate::Deployment;

impl runtime::DeploymentParts for Deployment {
    fn fusion_core(&self) -> Option<usize> {
        self.fusion.core
    }

    fn first_day_ns(&self) -> Option<i64> {
        self.first_day_ns
    }

    fn each_stream(&self, publishers: usize, visit: &mut impl Visit) -> Result<(), BusError> {
        for (id, name) in self.streams() {
            match id.stream {
                Stream::SensorTracks => visit.visit(&messages::sensor_tracks(name), publishers)?,
                Stream::Detections => visit.visit(&messages::sensor_detections(name), publishers)?,
                Stream::Bearings => visit.visit(&messages::sensor_bearings(name), publishers)?,
                Stream::Arrivals => visit.visit(&messages::sensor_arrivals(name), publishers)?,
                Stream::Fixes => visit.visit(&messages::sensor_fixes(name), publishers)?,
                Stream::PlatformStates => visit.visit(&messages::platform_states(name), publishers)?,
                Stream::Cues => visit.visit(&messages::cues(name), publishers)?,
                Stream::WideArea => visit.visit(&messages::wide_area(name), publishers)?,
                Stream::SystemTracks => visit.visit(&self.system_tracks_topic(), publishers)?,
                Stream::Alarms => visit.visit(&messages::alarms(), publishers)?,
                Stream::Decisions => visit.visit(&messages::decisions(), publishers)?,
                Stream::Orders => visit.visit(&messages::order_states(), publishers)?,
            }
        }
        for sensor in &self.tracker_sensors {
            visit.visit(&messages::sensor_detections(&sensor.name), publishers)?;
        }
        for source in self.sources.iter().filter(|source| source.has_array()) {
            visit.visit(&messages::sensor_spectrum(&source.name), publishers)?;
        }
        for platform in &self.platforms {
            visit.visit(&messages::platform_states(&platform.name), publishers)?;
        }
        if self.system_tracks.exchange {
            visit.visit(&messages::own_tracks(), publishers)?;
        }
        if self.system_tracks.smooths {
            visit.visit(&messages::smoothed_tracks(), publishers)?;
        }
        Ok(())
    }
}

impl Deployment {
    /// Topic of the system tracks, with the longest queue that its readers may request.
    fn system_tracks_topic(&self) -> Topic<SystemTrack> {
        let mut topic = messages::system_tracks();
        topic.capacity.depth = self.machine.queue_slices;
        topic
    }

    /// Data streams, each with the name of its source or sensor (of none for those of the system as a whole): source by
    /// source, then the wide-area sensors, then the system.
    pub fn streams(&self) -> impl Iterator<Item = (StreamId, &str)> {
        let of_sources = self.sources.iter().flat_map(|source| {
            let locates = source.has_bearings();
            let streams = [
                (Stream::SensorTracks, true),
                (Stream::Detections, source.has_detections()),
                (Stream::Cues, source.has_cues()),
                (Stream::Bearings, locates),
                (Stream::Arrivals, source.has_emitter_rows()),
                (Stream::Fixes, source.has_emitter_rows()),
                (Stream::PlatformStates, locates),
            ];
            let there = streams.into_iter().filter(|(_, is_there)| *is_there);
            there.map(|(stream, _)| (stream, source.number, source.name.as_str()))
        });
        let sensors = self.wide_area_sensors.iter();
        let of_sensors = sensors.map(|sensor| (Stream::WideArea, sensor.number, sensor.name.as_str()));
        let decisions = self.decision_use().map(|_| StreamId::DECISIONS);
        let of_system = [StreamId::SYSTEM_TRACKS, StreamId::ALARMS, StreamId::ORDERS];
        let of_system = of_system.into_iter().chain(decisions);
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

#[cfg(test)]
mod tests {
    use crate::Machine;

    #[test]
    fn the_usual_queue_and_the_memory_are_as_stated_for_the_key() {
        let mut topic = messages::system_tracks();
        assert_eq!(Machine::default().queue_slices, topic.capacity.depth);
        for length in [256, 1024, 8192] {
            topic.capacity.depth = length;
            // Fusion and its successor publish.
            let megabytes = bus::needed_bytes(&topic, 2) as f64 / 1e6;
            let stated = 0.41 * length as f64 + 20.0;
            assert!(
                (0.95 * stated - 10.0..=stated).contains(&megabytes),
                "{length}: {megabytes}"
            );
        }
    }
}

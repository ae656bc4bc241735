//! Registry of displayed streams: one entry per kind of sample that enters the world.
//!
//! The same entries serve live topics and the topics of a recording.

use bus::Payload;
use messages::{
    Alarm, BatchHeader, Cue, Decision, OrderState, SensorBearing, SensorDetection, SensorTrack, Stream, Streamed,
    SystemTrack, TargetStatement, TopicName, WideArea,
};
use runtime::Now;

use crate::records::{self, DetectionPlace};
use crate::world::World;

/// Sample of a displayed stream.
pub(crate) trait DisplayedSample: Streamed + Payload {
    /// Puts a slice of samples into the world.
    fn put(world: &mut World, slice: (&BatchHeader, &[Self]), now: Now);
}

/// Task applicable to the samples of every displayed stream.
pub(crate) trait ForDisplayed {
    type Done;

    /// Executes the task for samples `T`.
    fn of<T: DisplayedSample>(self) -> Self::Done;
}

/// Declares the displayed streams: stream, sample, and how a slice of samples enters the world.
macro_rules! displayed {
    ($( $stream:ident: $sample:ident, $put:expr; )*; hidden: $( $hidden:ident ),*) => {
        $( impl DisplayedSample for $sample {
            fn put(world: &mut World, slice: (&BatchHeader, &[Self]), now: Now) {
                let put: fn(&mut World, (&BatchHeader, &[Self]), Now) = $put;
                put(world, slice, now);
            }
        } )*

        /// Executes `task` for the samples of a stream; `None` if the display does not show the stream.
        pub(crate) fn for_displayed<F: ForDisplayed>(stream: Stream, task: F) -> Option<F::Done> {
            match stream {
                $( Stream::$stream => Some(task.of::<$sample>()), )*
                $( Stream::$hidden => None, )*
            }
        }
    };
}

/// Name of the topic of the source or sensor with this name.
pub(crate) struct TopicOf<'a>(pub(crate) &'a str);

impl ForDisplayed for TopicOf<'_> {
    type Done = TopicName;

    fn of<T: DisplayedSample>(self) -> TopicName {
        T::topic(self.0).name
    }
}

/// Returns the stream of the topic `name` and the name of its source or sensor; `None` if the display does not show it.
pub(crate) fn stream_of(name: &str) -> Option<(Stream, &str)> {
    let source = name.split('/').nth(1).unwrap_or_default();
    let is_named =
        |stream: &&Stream| for_displayed(**stream, TopicOf(source)).is_some_and(|topic| topic.as_str() == name);
    Stream::ALL.iter().find(is_named).map(|stream| (*stream, source))
}

displayed! {
    SensorTracks: SensorTrack, |world, (_, reports), now| world.hear_sensor_tracks(reports, now);
    Detections: SensorDetection, |world, (_, detections), _| for detection in detections {
        match records::detection(detection, world.observed.frame()) {
            Some(DetectionPlace::Spot(spot)) => world.pass(detection.time_of_measurement_ns, &spot),
            Some(DetectionPlace::Ray(ray)) => world.pass(detection.time_of_measurement_ns, &ray),
            None => {}
        }
    };
    Bearings: SensorBearing, |world, (_, bearings), _| for bearing in bearings {
        world.pass(bearing.time_of_measurement_ns, &records::bearing(bearing));
    };
    WideArea: WideArea, |world, (_, counts), _| for count in counts {
        world.pass(count.time_of_observation_ns, &records::count(count));
    };
    Cues: Cue, |world, (_, cues), _| for cue in cues {
        world.pass(cue.time_ns, &records::cue(cue));
    };
    SystemTracks: SystemTrack, |world, (header, tracks), now| world.receive(header, tracks, now);
    Alarms: Alarm, |world, (header, alarms), _| world.hear_alarms(header, alarms);
    Decisions: Decision, |world, (_, decisions), _| world.hear_decisions(decisions);
    Orders: OrderState, |world, (_, orders), _| world.observed.take_orders(orders);
    Statements: TargetStatement, |world, (_, stated), _| world.hear_statements(stated);
    ; hidden: Alerts, PlatformStates, Arrivals, Fixes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_have_their_stream_and_their_source() {
        for stream in Stream::ALL {
            if let Some(topic) = for_displayed(stream, TopicOf("radar-1")) {
                let (found, source) = stream_of(topic.as_str()).unwrap();
                assert_eq!(found, stream);
                assert!(source == "radar-1" || topic.as_str().starts_with("system/"), "{topic}");
            }
        }
        assert_eq!(stream_of("system/health"), None);
        assert_eq!(stream_of(""), None);
    }
}

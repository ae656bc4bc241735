//! Registry of displayed streams: one line per kind of sample that enters the world.
//!
//! The same lines serve live topics and the topics of a recording.

use bus::Payload;
use messages::{
    Alarm, BatchHeader, Cue, Decision, OrderState, SensorBearing, SensorDetection, SensorTrack, Stream, Streamed,
    SystemTrack, WideArea,
};
use runtime::Now;

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

displayed! {
    SensorTracks: SensorTrack, |world, (_, reports), now| world.hear_sensor_tracks(reports, now);
    Detections: SensorDetection, |world, (_, detections), _| world.hear_detections(detections);
    Bearings: SensorBearing, |world, (_, bearings), _| world.hear_bearings(bearings);
    WideArea: WideArea, |world, (_, counts), _| world.hear_counts(counts);
    Cues: Cue, |world, (_, cues), _| world.hear_cues(cues);
    SystemTracks: SystemTrack, |world, (header, tracks), now| world.receive(header, tracks, now);
    Alarms: Alarm, |world, (header, alarms), _| world.hear_alarms(header, alarms);
    Decisions: Decision, |world, (_, decisions), _| world.hear_decisions(decisions);
    Orders: OrderState, |world, (_, orders), _| world.observed.take_orders(orders);
    ; hidden: PlatformStates
}

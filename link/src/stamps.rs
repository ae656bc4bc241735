//! Stamps of another host's monotonic clock, as this one's.
//!
//! The monotonic clock of each host has its own start. Local readers compare stamps with the local clock.

use std::any::Any;

use bus::Payload;
use messages::{
    Cue, Health, PlatformState, SensorArrival, SensorBearing, SensorDetection, SensorFix, SensorTrack, StageTimes,
    SystemTrack, TargetStatement, WideArea,
};
use runtime::Now;

/// Converts the stamps of a sample received `now`. `offset_ns` is the other clock minus the local clock; while `None`
/// (unknown), stages count as not reached, and health as of now.
pub(crate) fn bring_here<T: Payload>(sample: &mut T, offset_ns: Option<i64>, now: Now) {
    let any: &mut dyn Any = sample;
    if let Some(said) = any.downcast_mut::<Health>() {
        said.said_ns = offset_ns.map_or(now.mono_ns, |offset_ns| said.said_ns - offset_ns);
    }
    macro_rules! stages {
        ($($sample:ty),*) => { $(
            if let Some(sample) = any.downcast_mut::<$sample>() {
                return stages(&mut sample.stages, offset_ns);
            }
        )* };
    }
    stages!(
        SystemTrack,
        SensorTrack,
        SensorDetection,
        SensorBearing,
        SensorArrival,
        SensorFix,
        TargetStatement,
        PlatformState,
        WideArea,
        Cue
    );
}

fn stages(stages: &mut StageTimes, offset_ns: Option<i64>) {
    for stamp_ns in [
        &mut stages.ingested_ns,
        &mut stages.published_ns,
        &mut stages.taken_ns,
        &mut stages.fused_ns,
    ] {
        if *stamp_ns != 0 {
            *stamp_ns = offset_ns.map_or(0, |offset_ns| *stamp_ns - offset_ns);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_been_reached_is_told_by_the_clock_here_and_nothing_as_long_as_none_is_known() {
        let now = Now { mono_ns: 50, utc_ns: 0 };
        let mut track = SystemTrack::default();
        track.stages.ingested_ns = 1_020;
        let mut unknown = track;
        bring_here(&mut track, Some(1_000), now);
        bring_here(&mut unknown, None, now);
        let stamps = |track: &SystemTrack| (track.stages.ingested_ns, track.stages.fused_ns);
        assert_eq!((stamps(&track), stamps(&unknown)), ((20, 0), (0, 0)));
        for (offset_ns, here_ns) in [(Some(1_000), 30), (None, 50)] {
            let mut said = Health {
                said_ns: 1_030,
                ..Health::default()
            };
            bring_here(&mut said, offset_ns, now);
            assert_eq!(said.said_ns, here_ns);
        }
    }
}

//! Platforms of a tracker process: which platform carries which sensor.
//!
//! The detections of sensors on board wait here for the platform's states ([`sources::carrying`]), before anything is
//! published about the detections.

use std::path::Path;

use anyhow::Context as _;
use deployment::{Platform, PlatformInput};
use formats::platform_states_csv::PlatformStateReader;
use platform::{Assumed, State};
use runtime::Process;
use sources::carrying::{CarriedSensor, Carrier, Carrying};

use crate::Processed;

/// Number of states of a live platform that are kept: half a minute of an inertial sensor.
const STATES_MAX: usize = 4096;

/// Platforms that carry sensors of the tracker, in the order of the numbers.
pub(super) fn platforms<'a>(process: &'a Process, tracker: Processed<'_>) -> Vec<&'a Platform> {
    let sensors = process.config.sensors_of(tracker.source);
    let carries = |platform: &&Platform| {
        let is_own = |number: u16| number == platform.number;
        sensors.iter().any(|sensor| {
            sensor
                .on_board
                .and_then(|on_board| on_board.platform)
                .is_some_and(is_own)
        })
    };
    process.config.platforms.iter().filter(carries).collect()
}

/// Longest time for which detections of the tracker's sensors wait for states, nanoseconds.
pub(super) fn longest_wait_ns(process: &Process, tracker: Processed<'_>) -> i64 {
    let waits = platforms(process, tracker).into_iter().map(|platform| platform.wait_ns);
    waits.max().unwrap_or(0)
}

/// Carries the detections of the tracker's sensors; `states_max` states of each platform are kept.
pub(super) fn carrying<T>(process: &Process, tracker: Processed<'_>, states_max: Option<usize>) -> Carrying<T> {
    let platforms = platforms(process, tracker);
    let carriers: Vec<Carrier> = platforms
        .iter()
        .map(|platform| Carrier {
            assumed: tracker.readings.platforms[usize::from(platform.number)].assumed,
            wait_ns: platform.wait_ns,
            states_max: states_max.unwrap_or(STATES_MAX),
        })
        .collect();
    let (facts, cutters) = tracker
        .reading()
        .processing
        .tracker()
        .map_or((&[][..], &[][..]), |tracker| {
            (&tracker.settings.sensors[..], &tracker.joining.cutters[..])
        });
    let sensors = process.config.sensors_of(tracker.source).iter().zip(facts).zip(cutters);
    let sensors: Vec<Option<CarriedSensor>> = sensors
        .map(|((sensor, facts), cutter)| {
            let on_board = sensor.on_board?;
            let reading = &tracker.readings.sources[usize::from(sensor.number)];
            let place = |number: u16| platforms.iter().position(|platform| platform.number == number);
            Some(CarriedSensor {
                carrier: on_board.platform.and_then(place),
                mount: reading.mount?,
                default_sigmas: facts.default_sigmas(),
                looks_ns: cutter.period_ns,
            })
        })
        .collect();
    Carrying::new(&carriers, &sensors, Assumed::default(), Some(process.config.frame))
}

/// States of a recorded platform.
///
/// # Errors
/// If the file cannot be read.
pub(super) fn recorded_states(platform: &Platform, data: &Path, first_day_ns: i64) -> anyhow::Result<Vec<State>> {
    let PlatformInput::Recorded(file) = &platform.input else {
        anyhow::bail!("platform {} has no recording", platform.name);
    };
    let path = data.join(file);
    let unread = || {
        format!(
            "reading {}, the recording of platform {}",
            path.display(),
            platform.name
        )
    };
    let bytes = std::fs::read(&path).with_context(unread)?;
    let rows = PlatformStateReader::new(bytes.as_slice(), first_day_ns).with_context(unread)?;
    // Unreadable rows count as absent; detections near such rows are refused and counted.
    Ok(rows.filter_map(Result::ok).map(|row| State::of_sample(&row)).collect())
}

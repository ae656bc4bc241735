//! The adapter process: one per sensor or per network input, it turns sensors' data into sensor tracks and publishes
//! them.
//!
//! Where the data come from is one file each: `recording` and `content` decode a recorded file, and `replay` paces it by its own
//! times; `datagrams`, `lines` and `bearings` receive from the network. What they share is the way from there: the source's
//! pipeline makes samples of what was observed ([`sources`]), and, for live sources, `channel` publishes them. Sensors that
//! only count are in `wide_area`, from the network or a recording to what is published.

#![forbid(unsafe_code)]

mod bearings;
mod channel;
mod content;
mod datagrams;
mod lines;
pub mod recording;
mod replay;
mod wide_area;

use anyhow::Context as _;
use configuration::{Input, Process, Source, Transport};
use runtime::Agent;
use sources::{Outputs, Processing, TrackerSettings};

use crate::bearings::Bearings;
use crate::datagrams::Datagrams;
use crate::lines::Lines;

/// Runs the adapter that the process is named after (of the receiver of that name, of the recorded source, or of a wide-area
/// sensor) until it has finished or is told to stop.
///
/// # Errors
/// If there is no such source, its input cannot be read, or shared memory fails.
pub fn run(process: &Process) -> anyhow::Result<()> {
    let (config, name) = (&process.config, &process.name);
    if let Some(sensor) = config.wide_area_sensors.iter().find(|sensor| sensor.adapter == *name) {
        return runtime::service::run(process, wide_area::agent(process, sensor)?.as_mut());
    }
    let sources: Vec<&Source> = config.sources.iter().filter(|source| source.adapter == *name).collect();
    if let Some(receiver) = config.receiver(name) {
        let has_bearings = sources.iter().any(|source| source.locator.is_some());
        let mut agent: Box<dyn Agent> = match &receiver.transport {
            Transport::Udp(settings) if has_bearings => Box::new(Bearings::new(process, settings, &sources)?),
            Transport::Loopback { port } if has_bearings => Box::new(Bearings::loopback(process, *port, &sources)?),
            Transport::Udp(settings) => Box::new(Datagrams::new(process, settings, &sources)?),
            Transport::Loopback { port } => Box::new(Datagrams::loopback(process, *port, &sources)?),
            Transport::Sbs { server, settings } => Box::new(Lines::new(process, *server, *settings, &sources)?),
        };
        return runtime::service::run(process, agent.as_mut());
    }
    let recorded = sources.first().and_then(|source| match &source.input {
        Input::Recorded(recorded) => Some((*source, recorded)),
        _ => None,
    });
    let (source, recorded) = recorded.with_context(|| {
        let path = config.path.display();
        format!("{path}: no receiver and no recorded source is named \"{name}\"")
    })?;
    runtime::service::run(process, &mut replay::Replay::new(process, source, recorded)?)
}

/// How the tracks of `source` come about.
fn processing(source: &Source) -> Processing {
    match (&source.tracker, &source.locator) {
        (Some(tracker), _) => Processing::Detections(Box::new(TrackerSettings {
            settings: tracker.settings.clone(),
            cutter: tracker.cutter,
            outputs: Outputs {
                period_ns: tracker.output_period_ns,
                cues: tracker.cues,
            },
        })),
        (None, Some(locator)) => Processing::Bearings(Box::new(*locator)),
        (None, None) => Processing::Tracks,
    }
}

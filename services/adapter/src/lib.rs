//! Adapter process: a process per sensor or network input, converts sensors' data to sensor tracks and publishes these.
//!
//! Live data arrive in datagrams (`receiver`), which contain ASTERIX (`blocks`), bearings, detections or counts
//! (`tables`) or snapshots of an antenna array (`snapshots`), in rows over a connection (`row_lines`), or as the feed
//! of a receiver (`feed`). The source's pipeline converts observations to samples ([`sources`]), and `channel`
//! publishes them; `capture` stores the received bytes on request. Recorded data are read as a whole: a source's data
//! are decoded piece by piece (`recorded_source`, `content`), a wide-area sensor's data as counts; `replay` publishes
//! both, paced by the data's own times. A tracker process (`tracker`) takes the detections of its sensors from topics,
//! or reads recordings. Sensors that only count are in `wide_area`, the states of platforms that carry sensors in
//! `platform`.

#![forbid(unsafe_code)]

mod bearings;
mod beside;
mod blocks;
mod capture;
mod channel;
mod content;
mod continuity;
mod counted;
mod feed;
mod finder;
mod intake;
mod misfits;
mod outlet;
mod platform;
mod plot_rows;
mod receiver;
pub mod recorded_source;
mod refusals;
mod replay;
mod row_lines;
mod snapshots;
mod statements;
mod tables;
mod tracker;
mod wide_area;

pub use content::{FeedSurvey, TrackRows, rows_of_tracks};

use anyhow::Context as _;
use deployment::{FeedFormat, Input, Platform, ReceiverTransport, Source};
use observations::Observation;
use runtime::Agent;
use runtime::Process;
use sources::{Readings, SourceReading};

use crate::bearings::Bearings;
use crate::blocks::BlockSources;
use crate::content::RecordedFeed;
use crate::feed::{FeedAgent, StatedReceiver};
use crate::plot_rows::PlotRows;
use crate::receiver::DatagramAgent;
use crate::row_lines::RowLineAgent;
use crate::snapshots::Snapshots;

/// Source, and how the deployment's data are read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Processed<'a> {
    pub(crate) source: &'a Source,
    pub(crate) readings: &'a Readings,
}

impl<'a> Processed<'a> {
    /// How the source's data are read.
    pub(crate) fn reading(self) -> &'a SourceReading {
        &self.readings.sources[usize::from(self.source.number)]
    }
}

/// Reads the data of a feed in `bytes` as the adapter of a recording does; `observed` gets each target report. Data
/// that state no receipt were received at `received_ns`, UTC, nanoseconds, if stated.
pub fn survey_feed(
    bytes: &[u8],
    format: FeedFormat,
    (place_deg, received_ns): (Option<[f64; 2]>, Option<i64>),
    observed: &mut dyn FnMut(&Observation),
) -> FeedSurvey {
    let receiver = StatedReceiver {
        place_deg,
        ..StatedReceiver::default()
    };
    RecordedFeed::open((format, receiver, 0), bytes.to_vec()).survey(received_ns, observed)
}

/// Runs the adapter named in `process` (of a receiver, a recorded source or a wide-area sensor) until the work is done
/// or a stop is requested. `readings` are of the deployment.
///
/// # Errors
/// If there is no such source, the input cannot be read, or shared memory fails.
pub fn run(process: &Process, readings: &Readings) -> anyhow::Result<()> {
    let (config, name) = (&process.config, &process.name);
    if let Some(sensor) = config.wide_area_sensors.iter().find(|sensor| sensor.adapter == *name) {
        return runtime::service::run(process, wide_area::agent(process, sensor, readings)?.as_mut());
    }
    let is_named = |platform: &&Platform| platform.has_process() && platform.name == *name;
    if let Some(found) = config.platforms.iter().find(is_named) {
        let reading = &readings.platforms[usize::from(found.number)];
        return runtime::service::run(process, crate::platform::agent(process, (found, reading))?.as_mut());
    }
    let sources = config.sources.iter().chain(&config.tracker_sensors);
    let sources: Vec<Processed<'_>> = sources
        .filter(|source| source.adapter == *name)
        .map(|source| Processed { source, readings })
        .collect();
    if let Some(tracker) = sources
        .iter()
        .find(|processed| matches!(processed.source.input, Input::Tracker(_)))
    {
        return runtime::service::run(process, tracker::agent(process, *tracker)?.as_mut());
    }
    if let Some(receiver) = config.receiver(name) {
        let has_bearings = sources.iter().any(|processed| processed.source.has_bearings());
        let mut agent: Box<dyn Agent> =
            match &receiver.transport {
                ReceiverTransport::Feed(feed) => Box::new(FeedAgent::new(process, feed, &sources)?),
                ReceiverTransport::Rows { server } => {
                    Box::new(RowLineAgent::new(*server, PlotRows::new(process, &sources)?)?)
                }
                transport if sources.iter().any(|processed| processed.source.has_rows()) => Box::new(
                    DatagramAgent::open(process, transport, PlotRows::new(process, &sources)?)?,
                ),
                transport if sources.iter().any(|processed| processed.source.has_array()) => Box::new(
                    DatagramAgent::open(process, transport, Snapshots::new(process, &sources)?)?,
                ),
                transport if has_bearings => Box::new(DatagramAgent::open(
                    process,
                    transport,
                    Bearings::new(process, &sources)?,
                )?),
                transport => Box::new(DatagramAgent::open(
                    process,
                    transport,
                    BlockSources::new(process, &sources)?,
                )?),
            };
        return runtime::service::run(process, agent.as_mut());
    }
    let recorded = sources.first().and_then(|processed| match &processed.source.input {
        Input::Recorded(recorded) => Some((*processed, recorded)),
        _ => None,
    });
    let (source, recorded) = recorded.with_context(|| {
        let path = config.path.display();
        format!("{path}: no receiver and no recorded source is named \"{name}\"")
    })?;
    runtime::service::run(process, &mut recorded_source::replay(process, source, recorded)?)
}

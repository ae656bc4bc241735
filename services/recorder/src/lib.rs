//! Recorder process: writes every data stream of a deployment to a file.
//!
//! Every topic is received once (`intake`), into one stream with positions and losses (`journal`). Tables (`csv`)
//! and files of all topics (`mcap`) are written from it. The tables are:
//!
//! - `sensor_tracks_<name>.csv`: one file per source, in the order of publication.
//! - `system_tracks.csv`: the system tracks in the order of fusion (FM-5). Its last columns give the state in
//!   geographic terms: `utc`, `latitude` and `longitude` (WGS-84, degrees), `flight_level` (hundreds of feet above
//!   the ellipsoid, or the flight level if sources report one; empty if no source observes height), and `level` and
//!   `level_age_s`, the transponder's newest level (hundreds of feet against 1013.25 hPa) and its age.
//! - `detections_<name>.csv`: exact detections, if an adapter forms a source's tracks from detections. `koseki
//!   track` forms the same tracks from them (FM-6), and the same cues as in `cues_<name>.csv`.
//! - `bearings_<name>.csv`: the bearings used from a direction finder, and `platform_states_<name>.csv`: the platform's
//!   positions; `arrivals_<name>.csv` and `fixes_<name>.csv`: the arrival times and the ready-made fixes that came
//!   beside them or in their place. `koseki locate` makes the same fixes from these files (FM-7).
//! - `wide_area_<name>.csv`: exact reports of wide-area sensors.
//!
//! With recorded inputs, neither order depends on scheduling. The files are therefore reproducible: they carry the
//! times of the data and none of the machine.
//!
//! With `format = ["csv", "mcap"]`, every topic, including messages between processes, is recorded bit by bit in
//! `all_topics_<number>.mcap` (see the crate `recording`), with the times of reception and sending, configuration
//! and version. A message between processes that repeats the one before it is recorded every five seconds.
//!
//! A full disk stops a file until there is room, with one message and a count; other files go on, also if a table
//! cannot be made at the start. The process then ends with an error when it is stopped. The note in the recorder's
//! health names the cause of the latest loss.

#![forbid(unsafe_code)]

mod account;
mod agent;
mod bag;
mod gaps;
mod images;
mod intake;
mod journal;
mod recorded;
mod recovery;
mod repeats;
mod segments;
mod settings;
mod slice;
mod start;
mod tables;

pub use agent::RecorderAgent;
pub use recorded::table;
pub use settings::{Format, Keys, Packing, Settings};
pub use start::Start;
pub use tables::Tables;

use runtime::Process;

/// Runs the recorder, of an executable of this `version`, until every topic has ended or a stop is requested.
///
/// # Errors
/// If a file cannot be written, or shared memory fails.
pub fn run(process: &Process, settings: &Settings, version: &str) -> anyhow::Result<()> {
    let (config, options) = (&process.config, &process.options);
    let run = format!(
        "deployment {}, instance {}, configuration {}, started at {}, {} ns since 1970 (UTC)\n",
        config.name,
        options.instance,
        config.path.display(),
        formats::rows::Utc(options.scenario_start_ns),
        options.scenario_start_ns
    );
    let start = Start {
        folder: &options.out,
        run: &run,
        version,
        first_day_ns: process.first_day_ns(),
    };
    let mut agent = RecorderAgent::new((config, settings), &process.bus, process.incarnation, &start)?;
    runtime::service::run(process, &mut agent)
}

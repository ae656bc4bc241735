//! The recorder process: writes every data stream of a deployment to a file.
//!
//! One file per source, `sensor_tracks_<name>.csv`, in the order in which the source published, and one for the system
//! tracks, `system_tracks.csv`, in the order of fusion (FM-5), whose last columns say it in the world's terms: `utc`,
//! `latitude` and `longitude` (WGS-84, degrees), `flight_level` (hundreds of feet above the ellipsoid, the flight level
//! where sources give one; empty if none observes height), and `level` and `level_age_s`, the transponder's newest
//! level (hundreds of feet against 1013.25 hPa) and how old it is. Neither order depends on scheduling when the inputs
//! are recorded, so neither do the files: they carry the times of the data and none of the machine's. Where an adapter
//! makes a source's tracks of detections, `detections_<name>.csv` holds these, exactly: `koseki track` makes the same
//! tracks of them (FM-6), and the same cues as are in `cues_<name>.csv`. Of a direction finder, `bearings_<name>.csv`
//! holds the bearings that were used and `platform_states_<name>.csv` where the platform was: `koseki locate` makes the
//! same fixes of the bearings (FM-7). Reports of wide-area sensors are in `wide_area_<name>.csv`, as exactly.
//!
//! With `format = ["csv", "mcap"]` every topic, talk between processes too, goes to the bit into
//! `all_topics_<number>.mcap` (see the crate `recording`), with the times of taking and sending, configuration and
//! version.
//!
//! A disk that is full stops the recording of all topics, with one message and a count, until there is room; the
//! process then ends with an error when it is stopped. Rows cannot be left out: the recorder that writes them ends, and
//! its successor goes on after the last whole one.

#![forbid(unsafe_code)]

mod agent;
mod all_topics;
mod images;
mod numbering;
mod recorded;
mod recovery;
mod segments;
mod tables;
mod topic_file;

pub use agent::{RecorderAgent, Start};
pub use tables::Tables;

use configuration::Process;

/// Runs the recorder, of an executable of this `version`, until every topic has ended or the process is told to stop.
///
/// # Errors
/// If a file cannot be written, or shared memory fails.
pub fn run(process: &Process, version: &str) -> anyhow::Result<()> {
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
    let mut agent = RecorderAgent::new(config, &process.bus, process.incarnation, &start)?;
    runtime::service::run(process, &mut agent)
}

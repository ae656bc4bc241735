//! `koseki fuse`: files of sensor tracks into one file of system tracks (FM-5).
//!
//! The engine is the engine of the live process, driven in the same order of time (PL-12): the same reports give
//! the same bytes. The command reads its files twice; the first pass determines the engine's settings for the
//! sensors ([`crate::reading`]).

mod picture;
pub(crate) mod rows;
mod summary;

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context as _;
use formats::decisions_csv::DecisionWriter;
use fusion::Engine;
use messages::{Decision, SystemTrack};

use crate::args::Fuse;
use crate::files::check_outputs;
use crate::host::Host;
use crate::reading::{Setup, drive, rule};
use picture::TrackDrawing;
use rows::StateSink;
use settings::Seconds;
use summary::FuseSummary;

/// Runs the fusion.
///
/// # Errors
/// If the arguments are contradictory, or a file cannot be read or written.
pub(crate) fn run(fuse: &Fuse, host: &dyn Host) -> anyhow::Result<()> {
    let outputs = [
        ("--out", Some(&fuse.out)),
        ("--explain", fuse.explain.as_ref()),
        ("--picture", fuse.picture.as_ref()),
    ];
    check_outputs(fuse.input.tracks.iter().chain(&fuse.input.config), &outputs)?;
    let named = fuse.rule.as_deref().map(rule).transpose()?;
    let mut setup = Setup::of(host, &fuse.input)?;
    if let Some(rule) = named {
        setup.settings.rule.name.0 = rule;
    }
    if let Some(refresh) = fuse.refresh {
        setup.settings.refresh_s = Some(Seconds::of_ns(nanoseconds(refresh)));
    }
    let engine = Engine::new(setup.settings.clone())?;
    let mut reports = setup.reports()?;
    let out = host.begin(&fuse.out)?;
    let unwritten = || format!("{} cannot be made", fuse.out.display());
    let mut rows =
        StateSink::begin(out, setup.sensor_ids.clone(), setup.settings.refresh_ns()).with_context(unwritten)?;
    let begin = |path: &PathBuf| {
        let table = DecisionWriter::begin(host.begin(path)?, 0)
            .with_context(|| format!("{} cannot be written", path.display()))?;
        anyhow::Ok(table.with_sensor_ids(setup.sensor_ids.clone()))
    };
    let mut decisions = fuse.explain.as_ref().map(begin).transpose()?;
    let explain = |decision: &Decision| decisions.as_mut().map_or(Ok(()), |table| table.write(decision));
    let mut picture = fuse.picture.as_ref().map(|_| TrackDrawing::new(fuse.track));
    let row = |state: &SystemTrack| {
        if let Some(picture) = &mut picture {
            picture.state(state);
        }
        rows.take(state)
    };
    let (engine, driven) = drive(host, engine, &mut reports, row, explain).with_context(unwritten)?;
    let (out, written) = rows.finish().with_context(unwritten)?;
    out.finish()?;
    if let Some(decisions) = decisions {
        decisions.into_inner().finish()?;
    }
    if let (Some(mut picture), Some(file)) = (picture, &fuse.picture) {
        let mut again = setup.reports()?;
        while let Some(report) = again.next()? {
            picture.report(&report.track);
        }
        picture.draw(file, &setup.sensor_ids)?;
    }
    let summary = FuseSummary {
        out: &fuse.out,
        setup: &setup,
        engine: &engine,
        refusals: &reports.refusals,
        driven,
        written,
    };
    summary.show(host, fuse.json)
}

/// Converts a duration to nanoseconds; the argument parser has checked its range.
pub(crate) fn nanoseconds(time: Duration) -> i64 {
    time.as_nanos() as i64
}

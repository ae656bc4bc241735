//! `koseki fuse`: files of sensor tracks into a single file of system tracks (FM-5).
//!
//! The engine is the engine of the live process, driven in the same order of time (PL-12): the same reports give the
//! same bytes. The command reads the files twice; the first pass determines the engine's settings for the sensors
//! ([`crate::reading`]).

mod alerts;
mod lagging;
mod picture;
pub(crate) mod rows;
mod summary;

use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context as _;
use formats::decisions_csv::DecisionWriter;
use fusion::{Engine, FilterInput};
use messages::{Decision, SystemTrack};

use crate::args::Fuse;
use crate::files::{OutputFile, check_answer, check_outputs};
use crate::host::Host;
use crate::reading::{EngineReader, Setup, drive_into, rule};
use alerts::AlertTable;
use lagging::LaggingRows;
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
        ("--alerts", fuse.alerts.as_ref()),
        ("--picture", fuse.picture.as_ref()),
        ("--smoothed", fuse.smoothed.as_ref()),
    ];
    check_outputs(fuse.input.tracks.iter().chain(&fuse.input.config), &outputs)?;
    check_answer(fuse.json, &outputs)?;
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
    let rows = StateSink::begin(out, &setup).with_context(unwritten)?;
    let begin = |path: &PathBuf| {
        let table = DecisionWriter::begin(host.begin(path)?, 0)
            .with_context(|| format!("{} cannot be written", path.display()))?;
        anyhow::Ok(table.with_sensor_ids(setup.sensor_ids.clone()))
    };
    let decisions = fuse.explain.as_ref().map(begin).transpose()?;
    let alerts = fuse
        .alerts
        .as_ref()
        .map(|path| AlertTable::begin(host.begin(path)?, &setup, host));
    let picture_file = fuse.picture.as_deref().map(OutputFile::begin).transpose()?;
    let mut outputs = FuseOutputs {
        rows,
        decisions,
        alerts: alerts.transpose()?,
        picture: fuse.picture.as_ref().map(|_| TrackDrawing::new(fuse.track)),
        lagging: fuse
            .smoothed
            .as_ref()
            .map(|path| LaggingRows::begin(path, fuse.smoothing_lag, &setup, host))
            .transpose()?,
    };
    let (engine, driven) = drive_into(host, engine, &mut reports, &mut outputs).with_context(unwritten)?;
    let FuseOutputs {
        rows,
        decisions,
        alerts,
        picture,
        lagging,
    } = outputs;
    if let Some(lagging) = lagging {
        lagging.finish()?;
    }
    let (out, written) = rows.finish().with_context(unwritten)?;
    out.finish()?;
    if let Some(decisions) = decisions {
        decisions.into_inner().finish()?;
    }
    let alerts = match alerts {
        Some(table) => {
            let (file, raised) = table.finish();
            file.finish()?;
            Some(raised)
        }
        None => None,
    };
    if let (Some(mut picture), Some(file)) = (picture, picture_file) {
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
        alerts,
    };
    summary.show(host, fuse.json)?;
    // A table without a row looks like a picture without targets.
    match setup.reports()?.next()? {
        Some(first) if summary.is_unused() => {
            let file = fuse.input.tracks[0].display();
            anyhow::bail!("{file}: no report was used: {}", summary.first_rejection(&first))
        }
        _ => Ok(()),
    }
}

/// Outputs of the command.
struct FuseOutputs<W: Write> {
    rows: StateSink<W>,
    decisions: Option<DecisionWriter<W>>,
    alerts: Option<AlertTable<W>>,
    picture: Option<TrackDrawing>,
    lagging: Option<LaggingRows<W>>,
}

impl<W: Write> EngineReader for FuseOutputs<W> {
    fn state(&mut self, state: &SystemTrack) -> io::Result<()> {
        if let Some(picture) = &mut self.picture {
            picture.state(state);
        }
        if let Some(alerts) = &mut self.alerts {
            alerts.state(state)?;
        }
        if let Some(lagging) = &mut self.lagging {
            lagging.state(state)?;
        }
        self.rows.take(state)
    }

    fn decision(&mut self, decision: &Decision) -> io::Result<()> {
        self.decisions.as_mut().map_or(Ok(()), |table| table.write(decision))
    }

    fn follows_inputs(&self) -> bool {
        self.lagging.is_some()
    }

    fn input(&mut self, input: &FilterInput) -> io::Result<()> {
        self.lagging.as_mut().map_or(Ok(()), |lagging| lagging.input(input))
    }
}

/// Converts a duration to nanoseconds; the argument parser has checked the range.
pub(crate) fn nanoseconds(time: Duration) -> i64 {
    time.as_nanos() as i64
}

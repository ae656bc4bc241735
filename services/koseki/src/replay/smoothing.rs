//! `koseki smooth RECORDING`: the recorded system tracks, smoothed with later measurements (FM-17).
//!
//! The recording is fused again twice, as recorded: first for the inputs of all filters, then for the states.

use std::io;
use std::path::Path;

use anyhow::Context as _;
use formats::rows::RowWriter;
use formats::tracks_csv::PlacedTrack;
use frames::time::NS_PER_DAY;
use fusion::smoothing::{SmoothedTracks, Trajectories};
use messages::SystemTrack;
use offline::{OutputFile, Smooth, SmoothTotals, TrackBlocks, check_outputs};

use super::again::{Plan, RunOutcome};
use super::{ReplayResult, configuration, facts, fused_again, topics};
use crate::config::Config;
use crate::recording_export::block_form;
use crate::recording_info::files;

/// Smooths a recording.
///
/// # Errors
/// If the recording cannot be used or the result not be written.
pub(crate) fn run(smooth: &Smooth, recording: &Path) -> anyhow::Result<()> {
    let files = files(recording)?;
    check_outputs(&files, &smooth.outputs())?;
    let config = configuration(&facts(&files[0])?, &files[0])?;
    let plan = Plan {
        settings: config.engine.clone(),
        order: config.order,
        origin: config.origin,
        sources: config.sources.iter().map(|source| Some(source.number)).collect(),
        conditions: config.engine.conditions().map(str::to_owned).collect(),
        tolerates: true,
        restores: true,
    };
    let (again, collected) = fused_again(&files, topics(&config), plan.clone(), Collector::default())?;
    let engine = again
        .engine()
        .context("no report of the recording could be worked off")?;
    let measurements = collected.0.inputs();
    let smoothed = collected.0.smooth(engine, |_| Ok::<(), std::convert::Infallible>(()))?;
    let writer = SmoothedRecording {
        smoothed,
        blocks: smooth
            .asterix
            .as_ref()
            .map(|path| blocks(smooth, &config, path))
            .transpose()?,
        out: Some(OutputFile::begin(&smooth.out)?),
        config,
        rows: None,
        totals: SmoothTotals::new(measurements),
        failed: Ok(()),
    };
    let (_, written) = fused_again(&files, topics(&writer.config), plan, writer)?;
    let totals = written.finish()?;
    let asterix = smooth.asterix.as_deref();
    let host: &dyn offline::Host = &offline::Terminal::default();
    host.show(smooth.json.then(|| totals.as_json(&smooth.out, asterix)), || {
        totals.as_text(&smooth.out, asterix)
    })
}

fn blocks(smooth: &Smooth, config: &Config, path: &Path) -> anyhow::Result<TrackBlocks<OutputFile>> {
    let form = block_form(config, smooth.sac, smooth.sic, smooth.heights)?;
    TrackBlocks::new(OutputFile::begin(path)?, &form, config.frame, &config.sources)
}

/// Collects the data for smoothing.
#[derive(Debug, Default)]
struct Collector(Trajectories);

impl ReplayResult for Collector {
    fn take(&mut self, outcome: RunOutcome<'_>) {
        match outcome {
            RunOutcome::State(state) => self.0.state(state),
            RunOutcome::Input(input) => self.0.input(input),
            RunOutcome::Worked(engine) => self.0.look(engine),
            RunOutcome::Began(..) | RunOutcome::Broke(_) => {}
        }
    }

    fn take_failure(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Writes the smoothed states.
#[derive(Debug)]
struct SmoothedRecording {
    smoothed: SmoothedTracks,
    config: Config,
    out: Option<OutputFile>,
    rows: Option<RowWriter<PlacedTrack, OutputFile>>,
    blocks: Option<TrackBlocks<OutputFile>>,
    totals: SmoothTotals,
    failed: io::Result<()>,
}

impl ReplayResult for SmoothedRecording {
    fn take(&mut self, outcome: RunOutcome<'_>) {
        if let (RunOutcome::State(live), true) = (outcome, self.failed.is_ok()) {
            let state = self.totals.take(live, &self.smoothed);
            self.failed = self.write(&state);
        }
    }

    fn take_failure(&mut self) -> io::Result<()> {
        std::mem::replace(&mut self.failed, Ok(()))
    }
}

impl SmoothedRecording {
    fn write(&mut self, state: &SystemTrack) -> io::Result<()> {
        if let Some(out) = self.out.take() {
            let of_first = || state.reference_time_ns.div_euclid(NS_PER_DAY) * NS_PER_DAY;
            self.rows = Some(RowWriter::begin(
                out,
                self.config.first_day_ns.unwrap_or_else(of_first),
            )?);
        }
        if let Some(rows) = &mut self.rows {
            rows.write(&PlacedTrack::new(state, &self.config.frame))?;
        }
        self.blocks.as_mut().map_or(Ok(()), |blocks| blocks.write(state))
    }

    fn finish(mut self) -> anyhow::Result<SmoothTotals> {
        let rows = self.rows.context("no report of the recording could be worked off")?;
        rows.into_inner().finish()?;
        if let Some(blocks) = self.blocks {
            let (out, counts) = blocks.finish()?;
            out.finish()?;
            self.totals.records = Some(counts.records);
        }
        Ok(self.totals)
    }
}

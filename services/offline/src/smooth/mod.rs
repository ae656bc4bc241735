//! `koseki smooth`: the system tracks of `koseki fuse`, smoothed with later measurements (FM-17).
//!
//! The engine runs twice in the same way as for `koseki fuse`. The first run collects the inputs of all filters and the
//! times of all states; the second writes the same rows with smoothed kinematics. Memory thus holds measurements and
//! smoothed states, but no messages. The executable smooths recordings, and drives the engine by the recorded event
//! logs.

mod blocks;
mod fused;
mod summary;

use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use frames::SystemFrame;
use fusion::smoothing::{SmoothedTracks, Trajectories};
use fusion::{Engine, FilterInput};
use messages::SystemTrack;
use settings::Seconds;

use crate::args::Smooth;
use crate::files::{Usage, check_answer, check_outputs};
use crate::fuse::nanoseconds;
use crate::fuse::rows::{StateSelection, StateSink, TrackRows};
use crate::host::{Host, TableOutput};
use crate::reading::{EngineReader, Setup, drive, drive_into, rule};
use fused::FusedCheck;

pub use blocks::{BlockForm, TrackBlocks};
pub use summary::SmoothTotals;

/// Runs the smoothing.
///
/// # Errors
/// If the arguments are contradictory, or a file cannot be read or written.
pub(crate) fn run(smooth: &Smooth, host: &dyn Host) -> anyhow::Result<()> {
    if let Some(recording) = &smooth.recording {
        let what = "a recording of all topics is smoothed by the executable `koseki` only; give --tracks";
        return Err(Usage(format!("{}: {what}", recording.display())).into());
    }
    let input = smooth.input();
    let inputs = input.tracks.iter().chain(&input.config).chain(&smooth.fused);
    check_outputs(inputs, &smooth.outputs())?;
    check_answer(smooth.json, &smooth.outputs())?;
    let named = smooth.rule.as_deref().map(rule).transpose()?;
    let mut setup = Setup::of(host, &input)?;
    let place = smooth.asterix.as_ref().map(|_| place_of(smooth, &setup)).transpose()?;
    if let Some(rule) = named {
        setup.settings.rule.name.0 = rule;
    }
    if let Some(refresh) = smooth.refresh {
        setup.settings.refresh_s = Some(Seconds::of_ns(nanoseconds(refresh)));
    }
    let mut collector = Collector {
        trajectories: Trajectories::default(),
        fused: smooth
            .fused
            .as_ref()
            .map(|path| existing(path, &setup, host))
            .transpose()?,
    };
    let engine = Engine::new(setup.settings.clone())?;
    let (engine, _) = drive_into(host, engine, &mut setup.reports()?, &mut collector)?;
    let Collector { trajectories, fused } = collector;
    if let (Some(fused), Some(path)) = (fused, &smooth.fused) {
        fused.finish()?.0.finish(path)?;
    }
    let measurements = trajectories.inputs();
    let smoothed = trajectories.smooth(&engine, |done| host.progress(done, measurements))?;
    host.passed();
    let mut rows = SmoothedRows::begin(smooth, (&setup, place), host, SmoothTotals::new(measurements))?;
    let engine = Engine::new(setup.settings.clone())?;
    let mut reports = setup.reports()?;
    let mut selection = StateSelection::new(setup.settings.refresh_ns());
    let unwritten = || format!("{} cannot be made", smooth.out.display());
    let row = |state: &SystemTrack| selection.take(state, |live| rows.write(live, &smoothed));
    drive(host, engine, &mut reports, row, |_| Ok(())).with_context(unwritten)?;
    selection
        .finish(|live| rows.write(live, &smoothed))
        .with_context(unwritten)?;
    let totals = rows.finish()?;
    let asterix = smooth.asterix.as_deref();
    host.show(smooth.json.then(|| totals.as_json(&smooth.out, asterix)), || {
        setup.named.as_text() + &reports.refusals.as_text() + &totals.as_text(&smooth.out, asterix)
    })
}

impl Smooth {
    /// Written files with options.
    pub fn outputs(&self) -> [(&'static str, Option<&PathBuf>); 2] {
        [("--out", Some(&self.out)), ("--asterix", self.asterix.as_ref())]
    }
}

/// The system's plane on the Earth.
fn place_of(smooth: &Smooth, setup: &Setup<'_>) -> Result<SystemFrame, Usage> {
    let of_deployment = setup.deployment.as_ref().map(|deployment| deployment.frame);
    let of_tables = of_deployment.or(setup.named.frame);
    smooth.origin.map(SystemFrame::at).or(of_tables).ok_or_else(|| {
        let remedy = "give --origin LAT,LON, or a deployment in --config";
        Usage(format!(
            "--asterix needs the place of the system's plane on the Earth: {remedy}"
        ))
    })
}

/// The outputs.
struct SmoothedRows {
    rows: TrackRows<Box<dyn TableOutput>>,
    blocks: Option<TrackBlocks<Box<dyn TableOutput>>>,
    totals: SmoothTotals,
}

impl SmoothedRows {
    fn begin(
        smooth: &Smooth,
        (setup, place): (&Setup<'_>, Option<SystemFrame>),
        host: &dyn Host,
        totals: SmoothTotals,
    ) -> anyhow::Result<Self> {
        let unwritten = || format!("{} cannot be made", smooth.out.display());
        let blocks = |(path, frame): (&PathBuf, SystemFrame)| {
            let form = BlockForm {
                table: None,
                sender: [smooth.sac.unwrap_or_default(), smooth.sic.unwrap_or_default()],
                heights: smooth.heights.unwrap_or_default(),
            };
            let sources = setup.deployment.as_ref().map(|deployment| &deployment.sources[..]);
            TrackBlocks::new(host.begin(path)?, &form, frame, sources.unwrap_or_default())
        };
        Ok(Self {
            blocks: smooth.asterix.as_ref().zip(place).map(blocks).transpose()?,
            rows: TrackRows::begin(host.begin(&smooth.out)?, setup.sensor_ids.clone(), setup.named.frame)
                .with_context(unwritten)?,
            totals,
        })
    }

    /// Writes the smoothed row of a fused state.
    fn write(&mut self, live: &SystemTrack, smoothed: &SmoothedTracks) -> io::Result<()> {
        let state = self.totals.take(live, smoothed);
        self.rows.write(&state)?;
        self.blocks.as_mut().map_or(Ok(()), |blocks| blocks.write(&state))
    }

    fn finish(mut self) -> anyhow::Result<SmoothTotals> {
        if let Some(blocks) = self.blocks.take() {
            let (out, counts) = blocks.finish()?;
            out.finish()?;
            self.totals.records = Some(counts.records);
        }
        self.rows.into_inner().finish()?;
        Ok(self.totals)
    }
}

/// Comparison of the fused rows with an existing output.
fn existing(path: &Path, setup: &Setup<'_>, host: &dyn Host) -> anyhow::Result<StateSink<FusedCheck>> {
    let check = FusedCheck::new(host.open(path)?);
    Ok(StateSink::begin(check, setup)?)
}

/// Collects the data for smoothing.
struct Collector {
    trajectories: Trajectories,
    fused: Option<StateSink<FusedCheck>>,
}

impl EngineReader for Collector {
    fn state(&mut self, state: &SystemTrack) -> io::Result<()> {
        self.trajectories.state(state);
        self.fused.as_mut().map_or(Ok(()), |fused| fused.take(state))
    }

    fn follows_inputs(&self) -> bool {
        true
    }

    fn input(&mut self, input: &FilterInput) -> io::Result<()> {
        self.trajectories.input(input);
        Ok(())
    }

    fn look(&mut self, engine: &Engine) {
        self.trajectories.look(engine);
    }
}

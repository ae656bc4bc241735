//! `koseki bench`: runs a measurement, and prints the results.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use bench_service::{MeasurementOutcome, Product};
use configuration::Config;
use deployment::Deployment;
use messages::{SensorDetection, SensorTrack, SystemTrack};
use observations::{Sampled as _, SensorEvent};
use sources::{Pipeline, Samples};
use tracking::wide_area::arrivals::Arrivals;

use crate::args::BenchCommand;
use crate::{print, product};

/// Koseki: its processes, and the engines that stand in them.
struct Koseki {
    executable: PathBuf,
}

impl Product for Koseki {
    fn executable(&self) -> &Path {
        &self.executable
    }

    fn deployment(&self, path: &Path, text: &str) -> anyhow::Result<Deployment> {
        Ok(Config::parse(path, text, &[])?.deployment)
    }

    fn engine(&self, text: &str) -> anyhow::Result<Box<dyn bench_service::Engine>> {
        let config = Config::parse(Path::new("bench.toml"), text, &[])?;
        Ok(Box::new(FusionEngine(fusion::Engine::new(config.engine)?)))
    }

    fn tracker(&self, text: &str) -> anyhow::Result<Box<dyn bench_service::TrackerStage>> {
        let config = Config::parse(Path::new("bench.toml"), text, &[])?;
        let mut trackers = config.readings.sources.iter();
        let reading = trackers.find(|reading| reading.processing.tracker().is_some());
        let reading = reading.context("the configuration has no tracker")?;
        Ok(Box::new(TrackerEngine {
            pipeline: Pipeline::new(reading.model, &reading.processing, 0, Arrivals::new())?,
            samples: Samples::default(),
        }))
    }
}

/// A tracker process without its topics.
struct TrackerEngine {
    pipeline: Pipeline,
    samples: Samples,
}

impl bench_service::TrackerStage for TrackerEngine {
    fn event(&mut self, sensor: usize, event: &SensorDetection) -> usize {
        if let Some(event) = SensorEvent::of_sample(event) {
            self.pipeline.event(sensor, &event, 0, &mut self.samples);
        }
        let made = self.samples.tracks.len();
        self.samples.detections.clear();
        self.samples.tracks.clear();
        made
    }

    fn progress_ns(&self) -> i64 {
        self.pipeline.progress_ns()
    }
}

struct FusionEngine(fusion::Engine);

impl bench_service::Engine for FusionEngine {
    fn take(&mut self, report: &SensorTrack, changed: &mut dyn FnMut(&SystemTrack)) {
        self.0.take(report, &mut |track: &SystemTrack| changed(track));
    }
}

/// Runs a measurement.
///
/// # Errors
/// If the arguments are invalid, the machine cannot run the measurement, or a process fails.
pub(crate) fn run(what: BenchCommand) -> anyhow::Result<()> {
    let koseki = || product::koseki().map(|executable| Koseki { executable });
    match what {
        BenchCommand::Latency(latency) => {
            let (settings, sweep, outputs) = latency.orders();
            show(&bench_service::latency(&koseki()?, &settings, sweep, &outputs)?)
        }
        BenchCommand::Throughput(throughput) => {
            let (settings, probe_seconds, outputs) = throughput.orders();
            show(&bench_service::throughput(
                &koseki()?,
                &settings,
                probe_seconds,
                &outputs,
            )?)
        }
        BenchCommand::Engine(engine) => {
            let (settings, outputs) = engine.orders();
            show(&bench_service::engine(&koseki()?, &settings, &outputs)?)
        }
        BenchCommand::Floor(floor) => {
            let (settings, outputs) = floor.orders();
            show(&bench_service::floor(&koseki()?, &settings, &outputs)?)
        }
        BenchCommand::Tracker(tracker) => print(&bench_service::tracker(&koseki()?, &tracker.orders())?),
        BenchCommand::Watch(watch) => {
            let (settings, with, json) = watch.orders();
            show(&bench_service::watch(&koseki()?, &settings, with, json.as_deref())?)
        }
        BenchCommand::Compare(compare) => {
            print(&bench_service::compare(&compare.before, &compare.after, compare.force)?)
        }
    }
}

fn show(outcome: &MeasurementOutcome) -> anyhow::Result<()> {
    print(&outcome.text)?;
    match &outcome.failure {
        None => Ok(()),
        Some(failure) => Err(anyhow::anyhow!("{failure}")),
    }
}

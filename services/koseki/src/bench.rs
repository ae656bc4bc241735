//! `koseki bench`: runs a measurement, and prints the results.

use std::path::Path;

use bench_service::{MeasurementOutcome, Product};
use deployment::Deployment;
use messages::{SensorTrack, SystemTrack};

use crate::args::BenchCommand;
use crate::config::Config;
use crate::print;

/// This executable, as the product under test.
struct Itself;

impl Product for Itself {
    fn deployment(&self, path: &Path, text: &str) -> anyhow::Result<Deployment> {
        Ok(Config::parse(path, text, &[])?.deployment)
    }

    fn engine(&self, text: &str) -> anyhow::Result<Box<dyn bench_service::Engine>> {
        let config = Config::parse(Path::new("bench.toml"), text, &[])?;
        Ok(Box::new(FusionEngine(fusion::Engine::new(config.engine)?)))
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
    match what {
        BenchCommand::Latency(latency) => {
            let (settings, sweep, outputs) = latency.orders();
            show(&bench_service::latency(&Itself, &settings, sweep, &outputs)?)
        }
        BenchCommand::Throughput(throughput) => {
            let (settings, probe_seconds, outputs) = throughput.orders();
            show(&bench_service::throughput(&Itself, &settings, probe_seconds, &outputs)?)
        }
        BenchCommand::Engine(engine) => {
            let (settings, outputs) = engine.orders();
            print(&bench_service::engine(&Itself, &settings, &outputs)?)
        }
        BenchCommand::Floor(floor) => {
            let (settings, outputs) = floor.orders();
            print(&bench_service::floor(&Itself, &settings, &outputs)?)
        }
        BenchCommand::Watch(watch) => {
            let (settings, with, json) = watch.orders();
            print(&bench_service::watch(&Itself, &settings, with, json.as_deref())?)
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

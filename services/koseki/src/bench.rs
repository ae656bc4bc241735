//! `koseki bench`: runs a measurement, and prints the results.

use bench_service::Outcome;

use crate::args::Bench;
use crate::print;

/// Runs a measurement.
///
/// # Errors
/// If the arguments are invalid, the machine cannot run the measurement, or a process fails.
pub(crate) fn run(what: Bench) -> anyhow::Result<()> {
    match what {
        Bench::Latency(latency) => {
            let (settings, sweep, outputs) = latency.orders();
            show(&bench_service::latency(&settings, sweep, &outputs)?)
        }
        Bench::Throughput(throughput) => {
            let (settings, probe_seconds, outputs) = throughput.orders();
            show(&bench_service::throughput(&settings, probe_seconds, &outputs)?)
        }
        Bench::Engine(engine) => {
            let (settings, outputs) = engine.orders();
            print(&bench_service::engine(&settings, &outputs)?)
        }
        Bench::Watch(watch) => {
            let (settings, with, json) = watch.orders();
            print(&bench_service::watch(&settings, with, json.as_deref())?)
        }
        Bench::Compare(compare) => print(&bench_service::compare(&compare.before, &compare.after, compare.force)?),
    }
}

fn show(outcome: &Outcome) -> anyhow::Result<()> {
    print(&outcome.text)?;
    match &outcome.failure {
        None => Ok(()),
        Some(failure) => Err(anyhow::anyhow!("{failure}")),
    }
}

//! `koseki bench latency`: latency of a report at given rates.
//!
//! For each rate, each run measures the relay, then the pipeline, then the machine alone. Disturbances of a shared
//! machine thus affect all three, and figures are compared within a run. Each measurement starts a fresh process,
//! so that chance effects of a process (its memory layout) do not affect all measurements.

use runtime::signals::Stop;
use telemetry::table::{count, duration};

use crate::distributions::{Distributions, point, run_of, stamps};
use crate::engine_time::{self, EngineTimes};
use crate::machine::{self, MachineFacts};
use crate::measure::{self, LoadPlan};
use crate::outputs::OutputFiles;
use crate::product::Product;
use crate::progress::say;
use crate::report::{BenchReport, MeasurementOutcome, RatePoint};
use crate::settings::Settings;
use crate::site::BenchSite;
use crate::text;
use crate::verdict::verdicts;

/// A sweep ends when the median is this many times that of its first rate.
const KNEE_FACTOR: u64 = 10;
/// Share of a run for watching the machine alone, and for measuring the engine alone.
const ASIDE: f64 = 0.5;

/// Measures `product` at every rate of `settings`; with `sweep`, up to the knee. Returns the text to show, and the
/// reason if the figures are unreliable.
///
/// # Errors
/// If the machine cannot do it, a process fails, or a file cannot be written.
pub fn run(
    product: &dyn Product,
    settings: &Settings,
    sweep: bool,
    outputs: &OutputFiles,
) -> anyhow::Result<MeasurementOutcome> {
    settings.check()?;
    outputs.check()?;
    let stop = Stop::on_signals_to_clear_up()?;
    let (mut machine, notes) = machine::begin(settings);
    let site = BenchSite::prepare(product, settings, &stop)?;
    let first = settings.rates_per_s[0];
    say(&format!(
        "engine alone, {} targets seen by {} sources",
        count(settings.targets.into()),
        settings.sources
    ));
    let (engine, single) = engine_time::measure(product, settings, (first, settings.seconds), || check(&site))?;

    let mut points = Vec::new();
    let mut distributions = Vec::new();
    for rate in &settings.rates_per_s {
        let (point, merged) = measure_rate(&site, settings, *rate)?;
        let beyond = point.pipeline.lost > 0
            || points
                .first()
                .is_some_and(|first: &RatePoint| point.pipeline.p50_ns > KNEE_FACTOR * first.pipeline.p50_ns);
        points.push(point);
        distributions.push(merged);
        if sweep && beyond {
            say("the knee is passed; the sweep ends here");
            break;
        }
    }
    drop(site);
    machine.ended();
    let report = assemble(settings, machine, engine, points, notes);
    outputs.write(&report, &distributions, Some(&single))?;
    Ok(MeasurementOutcome {
        text: text::latency(&report),
        // A sweep continues until reports are lost.
        failure: if sweep {
            report.engine_failure()
        } else {
            report.failure()
        },
    })
}

fn check(site: &BenchSite) -> anyhow::Result<()> {
    anyhow::ensure!(!site.stop_requested(), "stopped before the end; no figures are shown");
    Ok(())
}

fn measure_rate(site: &BenchSite, settings: &Settings, rate: f64) -> anyhow::Result<(RatePoint, Distributions)> {
    let plan = LoadPlan {
        rate_per_s: rate,
        seconds: settings.seconds,
        detailed: true,
    };
    let aside = LoadPlan {
        seconds: ASIDE * settings.seconds,
        ..plan
    };
    let mut runs = Vec::new();
    let mut merged = Distributions::new(rate);
    for number in 1..=settings.runs {
        let floor = measure::relay(site, settings, plan)?;
        let pipeline = measure::pipeline(site, settings, plan)?;
        let jitter = measure::jitter(site, settings, aside)?;
        let run = run_of(settings, &floor, &pipeline, &jitter);
        say(&format!(
            "{} reports/s, run {number} of {}: relay {}, pipeline {} (p50); {} and {} (p99){}",
            count(rate as u64),
            settings.runs,
            duration(run.floor.p50_ns as f64),
            duration(run.pipeline.p50_ns as f64),
            duration(run.floor.p99_ns as f64),
            duration(run.pipeline.p99_ns as f64),
            text::odd(&run.account)
        ));
        merged.add(&floor, &pipeline, &jitter);
        runs.push(run);
    }
    Ok((point(rate, runs, &merged), merged))
}

fn assemble(
    settings: &Settings,
    machine: MachineFacts,
    engine: EngineTimes,
    points: Vec<RatePoint>,
    notes: Vec<String>,
) -> BenchReport {
    let first = points.first().cloned().unwrap_or_default();
    let received = points.iter().filter(|point| point.pipeline.lost == 0);
    BenchReport {
        command: "latency".to_owned(),
        machine,
        settings: Some(settings.clone()),
        floor: first.floor,
        pipeline: first.pipeline,
        stages: first.stages.clone(),
        throughput_per_s: received.map(|point| point.rate_per_s).fold(0.0, f64::max),
        engine_ns_per_update: engine.ns_per_update,
        jitter: first.jitter,
        verdicts: match first.pipeline.lost {
            0 => verdicts(
                settings.wait,
                settings.batch,
                &first.floor,
                &first.pipeline,
                engine.ns_per_update,
                &engine.single,
            ),
            // Answered reports alone do not represent the run.
            _ => Vec::new(),
        },
        stamps: stamps(engine.reading_ns),
        engine,
        points,
        throughput: None,
        layers: Vec::new(),
        notes,
    }
}

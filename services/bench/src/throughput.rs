//! `koseki bench throughput`: the highest rate without loss, and the behaviour beyond.
//!
//! A rate is *held* if all of these are true over a few seconds:
//!
//! - Fusion took every report sent (its own counter of missing sequence numbers stays 0).
//! - Every report came back as a system track received by the bench's reader.
//! - The bench itself sent on time.
//! - The last state came back soon after the last report was sent. Otherwise a queue was growing, and would have
//!   overflowed in a longer probe.
//!
//! The search doubles and bisects the rate until it is known to three percent. The same search on the relay shows
//! the capability of transport and bench.
//!
//! Beyond the highest rate, losses are inevitable. The requirements there are that all losses are counted, and that
//! the queues, and hence the latency of the answered reports, stay bounded.

use runtime::signals::Stop;
use telemetry::Stage;
use telemetry::table::{count, duration};

use crate::distributions::{Distributions, account, point, run_of, stamps};
use crate::engine_time;
use crate::figures::Figures;
use crate::link::queues;
use crate::machine;
use crate::measure::{self, LoadPlan, MeasurementResult};
use crate::outputs::OutputFiles;
use crate::product::Product;
use crate::progress::say;
use crate::recorder::STAGES;
use crate::report::{BenchReport, MeasurementOutcome, Overload, ProbeFigures, Throughput};
use crate::search::highest;
use crate::settings::Settings;
use crate::site::BenchSite;
use crate::text;

/// Start and upper limit of the search, reports per second.
const START_PER_S: f64 = 50_000.0;
const LIMIT_PER_S: f64 = 10e6;
/// Accuracy of the highest rate, and number of failures that reject a rate.
const TOLERANCE: f64 = 1.03;
const TRIES: usize = 2;
/// Maximum lateness of the bench's last report, and of the last state, at a held rate, nanoseconds.
const BEHIND_MAX_NS: i64 = 20_000_000;
/// Rates of the table, as shares of the highest rate.
const PARTS: [f64; 6] = [0.1, 0.25, 0.5, 0.75, 0.9, 1.0];
/// Share of the highest rate at which the long run watches memory.
const LONG_PART: f64 = 0.8;
/// Overload rate as a multiple of the highest rate, and the excess of reports as a multiple of the queues'
/// capacity.
const BEYOND: f64 = 2.0;
const OVERFLOWS: f64 = 3.0;

/// Measures the throughput; `probe_seconds` is the length of a probe, `settings.seconds` that of the long run.
/// Returns the text to show.
///
/// # Errors
/// If the machine cannot do it, a process fails, or a file cannot be written.
pub fn run(
    product: &dyn Product,
    settings: &Settings,
    probe_seconds: f64,
    outputs: &OutputFiles,
) -> anyhow::Result<MeasurementOutcome> {
    settings.check()?;
    outputs.check()?;
    let stop = Stop::on_signals_to_clear_up()?;
    let (mut machine, notes) = machine::begin(settings);
    let site = BenchSite::prepare(product, settings, &stop)?;
    let bench = Bench {
        site: &site,
        settings,
        probe_seconds,
    };
    let watch = || {
        anyhow::ensure!(!site.stop_requested(), "stopped before the end; no figures are shown");
        Ok(())
    };
    let (engine, single) = engine_time::measure(product, settings, (START_PER_S, settings.seconds.min(3.0)), watch)?;
    say(&format!("engine alone: {} per update", duration(engine.ns_per_update)));

    let floor = highest(START_PER_S, LIMIT_PER_S, TOLERANCE, TRIES, |rate| {
        let measured = measure::relay(&site, settings, bench.plan(rate))?;
        Ok(bench.probe("relay", rate, &measured).lossless)
    })?;
    let mut probes = Vec::new();
    let found = highest(START_PER_S, LIMIT_PER_S, TOLERANCE, TRIES, |rate| {
        let measured = measure::pipeline(&site, settings, bench.plan(rate))?;
        let probe = bench.probe("pipeline", rate, &measured);
        probes.push(probe);
        Ok(probe.lossless)
    })?;
    anyhow::ensure!(
        found.held > 0.0,
        "not even {} reports/s were held: the machine is too busy (load {:.1} at the start)",
        count(found.not_held.unwrap_or(0.0) as u64),
        machine.load_before
    );
    for part in PARTS {
        let rate = part * found.held;
        let measured = measure::pipeline(&site, settings, bench.plan(rate))?;
        probes.push(bench.probe("pipeline", rate, &measured));
    }
    let overload = found.not_held.map(|_| bench.overload(found.held)).transpose()?;
    let (point, merged) = bench.long_run(LONG_PART * found.held)?;
    drop(site);
    machine.ended();
    probes.sort_by(|a, b| a.rate_per_s.total_cmp(&b.rate_per_s));
    let report = BenchReport {
        command: "throughput".to_owned(),
        machine,
        settings: Some(settings.clone()),
        floor: point.floor,
        pipeline: point.pipeline,
        stages: point.stages.clone(),
        throughput_per_s: found.held,
        engine_ns_per_update: engine.ns_per_update,
        jitter: point.jitter,
        throughput: Some(Throughput {
            floor_per_s: floor.held,
            probes,
            overload,
            memory: point.runs.first().map(|run| run.memory).unwrap_or_default(),
            memory_seconds: settings.seconds,
        }),
        points: vec![point],
        verdicts: Vec::new(),
        layers: Vec::new(),
        stamps: stamps(engine.reading_ns),
        engine,
        notes,
    };
    outputs.write(&report, &[merged], Some(&single))?;
    Ok(MeasurementOutcome {
        text: text::throughput(&report),
        failure: report.failure(),
    })
}

struct Bench<'a> {
    site: &'a BenchSite,
    settings: &'a Settings,
    probe_seconds: f64,
}

impl Bench<'_> {
    fn plan(&self, rate_per_s: f64) -> LoadPlan {
        LoadPlan {
            rate_per_s,
            seconds: self.probe_seconds,
            detailed: false,
        }
    }

    fn probe(&self, what: &str, rate_per_s: f64, measured: &MeasurementResult) -> ProbeFigures {
        let driven = &measured.driven;
        let behind_ns = driven.last_heard_ns - driven.last_sent_ns;
        let lost = measured.unanswered() + measured.fusion.map_or(0, |counts| counts.lost);
        let lossless = lost == 0 && driven.last_late_ns < BEHIND_MAX_NS && behind_ns < BEHIND_MAX_NS;
        let probe = ProbeFigures {
            rate_per_s,
            lossless,
            latency: Figures::of(measured.recorder.end_to_end(), measured.unanswered()),
            last_late_ns: driven.last_late_ns,
        };
        say(&format!(
            "{what} at {} reports/s: {}{}; p50 {}, p99 {}",
            count(rate_per_s as u64),
            if lossless { "held" } else { "not held" },
            match (lost, driven.last_late_ns) {
                (0, late) if late >= BEHIND_MAX_NS => format!(", the bench was {} late", duration(late as f64)),
                (0, _) => String::new(),
                (lost, _) => format!(", {} lost", count(lost)),
            },
            duration(probe.latency.p50_ns as f64),
            duration(probe.latency.p99_ns as f64)
        ));
        probe
    }

    fn overload(&self, held_per_s: f64) -> anyhow::Result<Overload> {
        let rate_per_s = BEYOND * held_per_s;
        let needed_s = OVERFLOWS * queues(self.settings) as f64 / (rate_per_s - held_per_s);
        let plan = LoadPlan {
            seconds: needed_s.max(self.probe_seconds),
            detailed: true,
            ..self.plan(rate_per_s)
        };
        let measured = measure::pipeline(self.site, self.settings, plan)?;
        self.probe("pipeline", rate_per_s, &measured);
        let account = account(self.settings, &measured);
        let waiting = STAGES.iter().position(|stage| *stage == Stage::PublishToTaken);
        Ok(Overload {
            rate_per_s,
            adds_up: account.adds_up(),
            account,
            latency: Figures::of(measured.recorder.end_to_end(), account.unanswered),
            longest_in_queues_ns: waiting.map_or(0, |index| measured.recorder.stages()[index].max()),
        })
    }

    /// Measures floor, pipeline and machine at one rate, for the configured time.
    fn long_run(&self, rate_per_s: f64) -> anyhow::Result<(crate::report::RatePoint, Distributions)> {
        let plan = LoadPlan {
            rate_per_s,
            seconds: self.settings.seconds,
            detailed: true,
        };
        say(&format!(
            "{} s at {} reports/s, for memory and latency",
            self.settings.seconds,
            count(rate_per_s as u64)
        ));
        let short = self.plan(rate_per_s);
        let floor = measure::relay(self.site, self.settings, short)?;
        let pipeline = measure::pipeline(self.site, self.settings, plan)?;
        let jitter = measure::jitter(self.site, self.settings, short)?;
        let mut merged = Distributions::new(rate_per_s);
        merged.add(&floor, &pipeline, &jitter);
        let run = run_of(self.settings, &floor, &pipeline, &jitter);
        Ok((point(rate_per_s, vec![run], &merged), merged))
    }
}

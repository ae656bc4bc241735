//! `koseki bench latency`: how long a report takes, at given rates.
//!
//! For each rate, in each run: the relay, then the pipeline, then the machine alone, each for the same time. What comes
//! and goes on a shared machine so hits all three, and figures are compared within a run. Each measurement has a fresh
//! process, so that what is chance about one (where its memory lies) is not in all of them.

use hdrhistogram::Histogram;
use runtime::signals::Stop;
use telemetry::table::{count, duration};

use crate::engine_time::{self, EngineTimes};
use crate::figures::Figures;
use crate::jitter::Jitter;
use crate::machine::{self, Machine};
use crate::measure::{self, Measured, Plan};
use crate::outputs::Outputs;
use crate::progress::say;
use crate::recorder::{STAGES, histogram};
use crate::report::{Account, JitterFigures, Point, Report, Run, Stamps};
use crate::settings::Settings;
use crate::site::Site;
use crate::text;
use crate::verdict::verdicts;

/// A sweep ends when the median is this many times that of its first rate.
const KNEE_FACTOR: u64 = 10;
/// Part of a run for which the machine alone is watched, and the engine alone measured.
const ASIDE: f64 = 0.5;

/// Measures every rate of `settings`; with `sweep`, no further than the knee. Returns what is to be shown.
///
/// # Errors
/// If the machine cannot do it, a process fails, or a file cannot be written.
pub fn run(settings: &Settings, sweep: bool, outputs: &Outputs) -> anyhow::Result<String> {
    settings.check()?;
    outputs.check()?;
    let stop = Stop::on_signals()?;
    let (mut machine, notes) = machine::begin(settings);
    let site = Site::prepare(settings, &stop)?;
    let first = settings.rates_per_s[0];
    say(&format!(
        "engine alone, {} targets seen by {} sources",
        count(settings.targets.into()),
        settings.sources
    ));
    let (engine, single) = engine_time::measure(settings, first, settings.seconds, || check(&site))?;

    let mut points = Vec::new();
    let mut distributions = Vec::new();
    for rate in &settings.rates_per_s {
        let (point, merged) = measure_rate(&site, settings, *rate)?;
        let beyond = point.pipeline.lost > 0
            || points
                .first()
                .is_some_and(|first: &Point| point.pipeline.p50_ns > KNEE_FACTOR * first.pipeline.p50_ns);
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
    Ok(text::latency(&report))
}

fn check(site: &Site) -> anyhow::Result<()> {
    anyhow::ensure!(!site.stop_requested(), "stopped before the end; no figures are shown");
    Ok(())
}

/// The distributions of one rate over all runs.
#[derive(Debug)]
pub(crate) struct Distributions {
    pub(crate) rate_per_s: f64,
    pub(crate) floor: Histogram<u64>,
    pub(crate) pipeline: Histogram<u64>,
    pub(crate) flooded: Histogram<u64>,
    pub(crate) stages: [Histogram<u64>; 5],
    pub(crate) jitter: Jitter,
}

impl Distributions {
    pub(crate) fn new(rate_per_s: f64) -> Self {
        Self {
            rate_per_s,
            floor: histogram(),
            pipeline: histogram(),
            flooded: histogram(),
            stages: std::array::from_fn(|_| histogram()),
            jitter: Jitter::new(),
        }
    }

    pub(crate) fn add(&mut self, floor: &Measured, pipeline: &Measured, jitter: &Jitter) {
        let same = "the same bounds";
        self.floor.add(floor.recorder.end_to_end()).expect(same);
        self.pipeline.add(pipeline.recorder.end_to_end()).expect(same);
        self.flooded.add(pipeline.recorder.flooded()).expect(same);
        for (all, of) in self.stages.iter_mut().zip(pipeline.recorder.stages()) {
            all.add(of).expect(same);
        }
        self.jitter.add(jitter);
    }
}

fn measure_rate(site: &Site, settings: &Settings, rate: f64) -> anyhow::Result<(Point, Distributions)> {
    let plan = Plan {
        rate_per_s: rate,
        seconds: settings.seconds,
        detailed: true,
    };
    let aside = Plan {
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

pub(crate) fn run_of(settings: &Settings, floor: &Measured, pipeline: &Measured, jitter: &Jitter) -> Run {
    let stages = STAGES.iter().zip(pipeline.recorder.stages());
    Run {
        floor: Figures::of(floor.recorder.end_to_end(), floor.unanswered()),
        pipeline: Figures::of(pipeline.recorder.end_to_end(), pipeline.unanswered()),
        jitter: jitter_figures(jitter),
        stages: stages
            .map(|(stage, of)| (stage.key().to_owned(), Figures::of(of, 0)))
            .collect(),
        account: account(settings, pipeline),
        warm_up: pipeline.warm_up,
        memory: pipeline.memory,
    }
}

pub(crate) fn account(settings: &Settings, measured: &Measured) -> Account {
    let received = measured.received();
    Account {
        sent: measured.sent(settings.batch),
        answers: received.answers,
        unanswered: measured.unanswered(),
        flood_unanswered: measured.flood_unanswered(),
        beyond_one: measured.recorder.beyond_one(),
        untriggered: received.untriggered,
        unconfirmed: received.unconfirmed,
        bench_late_ns: measured.driven.last_late_ns,
        sent_ever: measured.sent_ever,
        fusion: measured.fusion.unwrap_or_default(),
    }
}

pub(crate) fn jitter_figures(jitter: &Jitter) -> JitterFigures {
    let gaps = &jitter.gaps;
    let away_ns: f64 = gaps
        .iter_recorded()
        .map(|step| step.value_iterated_to() as f64 * step.count_at_value() as f64)
        .sum();
    let all_ns = jitter.readings as f64 * jitter.reading_ns as f64 + away_ns;
    JitterFigures {
        lateness: Figures::of(&jitter.lateness, 0),
        gaps: Figures::of(gaps, 0),
        taken_away: if all_ns > 0.0 { away_ns / all_ns } else { 0.0 },
    }
}

pub(crate) fn point(rate: f64, runs: Vec<Run>, merged: &Distributions) -> Point {
    let of = |figures: fn(&Run) -> Figures| Figures::median(&runs.iter().map(figures).collect::<Vec<_>>());
    let stage = |key: &str| Figures::median(&runs.iter().map(|run| run.stages[key]).collect::<Vec<_>>());
    let lost_of_flood = runs.iter().map(|run| run.account.flood_unanswered).sum();
    Point {
        rate_per_s: rate,
        floor: of(|run| run.floor),
        pipeline: of(|run| run.pipeline),
        stages: STAGES
            .iter()
            .map(|each| (each.key().to_owned(), stage(each.key())))
            .collect(),
        jitter: JitterFigures {
            lateness: of(|run| run.jitter.lateness),
            ..jitter_figures(&merged.jitter)
        },
        flooded: (!merged.flooded.is_empty()).then(|| Figures::of(&merged.flooded, lost_of_flood)),
        runs,
    }
}

fn assemble(
    settings: &Settings,
    machine: Machine,
    engine: EngineTimes,
    points: Vec<Point>,
    notes: Vec<String>,
) -> Report {
    let first = points.first().cloned().unwrap_or_default();
    let received = points.iter().filter(|point| point.pipeline.lost == 0);
    Report {
        command: "latency".to_owned(),
        machine,
        settings: Some(settings.clone()),
        floor: first.floor,
        pipeline: first.pipeline,
        stages: first.stages.clone(),
        throughput_per_s: received.map(|point| point.rate_per_s).fold(0.0, f64::max),
        engine_ns_per_update: engine.ns_per_update,
        jitter: first.jitter,
        verdicts: verdicts(
            settings.wait,
            settings.batch,
            &first.floor,
            &first.pipeline,
            engine.ns_per_update,
            &engine.single,
        ),
        stamps: stamps(engine.reading_ns),
        engine,
        points,
        throughput: None,
        notes,
    }
}

/// Clock readings on the way of a slice: see the agents.
pub(crate) fn stamps(reading_ns: u64) -> Stamps {
    Stamps {
        reading_ns,
        bench_per_slice: 2,
        fusion_per_slice: 4,
    }
}

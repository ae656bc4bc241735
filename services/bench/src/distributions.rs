//! Distributions of one rate over all runs, and the derived figures of the report.

use hdrhistogram::Histogram;

use crate::figures::Figures;
use crate::jitter::Jitter;
use crate::measure::MeasurementResult;
use crate::recorder::{STAGES, histogram};
use crate::report::{JitterFigures, RatePoint, Repetition, ReportAccount, Stamps};
use crate::settings::Settings;

/// Latencies at one rate over all runs, nanoseconds.
#[derive(Debug)]
pub(crate) struct Distributions {
    pub(crate) rate_per_s: f64,
    pub(crate) floor: Histogram<u64>,
    pub(crate) pipeline: Histogram<u64>,
    pub(crate) flooded: Histogram<u64>,
    pub(crate) stages: [Histogram<u64>; 5],
    pub(crate) jitter: Jitter,
    /// Reports sent through the pipeline, and unanswered reports, which no distribution contains.
    pub(crate) sent: u64,
    pub(crate) unanswered: u64,
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
            sent: 0,
            unanswered: 0,
        }
    }

    pub(crate) fn add(&mut self, floor: &MeasurementResult, pipeline: &MeasurementResult, jitter: &Jitter) {
        let same = "the same bounds";
        self.floor.add(floor.recorder.end_to_end()).expect(same);
        self.pipeline.add(pipeline.recorder.end_to_end()).expect(same);
        self.flooded.add(pipeline.recorder.flooded()).expect(same);
        for (all, of) in self.stages.iter_mut().zip(pipeline.recorder.stages()) {
            all.add(of).expect(same);
        }
        self.jitter.add(jitter);
        self.sent += pipeline.recorder.reports(pipeline.driven.batches);
        self.unanswered += pipeline.unanswered();
    }
}

/// Returns the figures of one run: relay, pipeline and machine.
pub(crate) fn run_of(
    settings: &Settings,
    floor: &MeasurementResult,
    pipeline: &MeasurementResult,
    jitter: &Jitter,
) -> Repetition {
    let stages = STAGES.iter().zip(pipeline.recorder.stages());
    Repetition {
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

/// Returns the account of the reports sent in a measurement.
pub(crate) fn account(settings: &Settings, measured: &MeasurementResult) -> ReportAccount {
    let received = measured.received();
    ReportAccount {
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

fn jitter_figures(jitter: &Jitter) -> JitterFigures {
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

/// Returns medians of the `runs` at one rate, reports per second.
pub(crate) fn point(rate: f64, runs: Vec<Repetition>, merged: &Distributions) -> RatePoint {
    let of = |figures: fn(&Repetition) -> Figures| Figures::median(&runs.iter().map(figures).collect::<Vec<_>>());
    let stage = |key: &str| Figures::median(&runs.iter().map(|run| run.stages[key]).collect::<Vec<_>>());
    let lost_of_flood = runs.iter().map(|run| run.account.flood_unanswered).sum();
    RatePoint {
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

/// Returns the clock readings along the path of a slice, in the bench and in the agent of fusion; a reading takes
/// `reading_ns`.
pub(crate) fn stamps(reading_ns: u64) -> Stamps {
    Stamps {
        reading_ns,
        bench_per_slice: 2,
        fusion_per_slice: 4,
    }
}

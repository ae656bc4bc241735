//! Tables for people.

use std::fmt::Write as _;

use telemetry::Stage;
use telemetry::table::{Align, TextTable, count, duration};

use crate::figures::{Figures, median, range};
use crate::link::queues;
use crate::recorder::STAGES;
use crate::report::{BenchReport, JitterFigures, Overload, RatePoint, Repetition, ReportAccount};

/// Lateness at the end of a run above which the bench has fallen behind, nanoseconds.
const BENCH_LATE_NS: i64 = 20_000_000;

/// Returns the text of a search for the highest rate.
pub(crate) fn throughput(report: &BenchReport) -> String {
    let mut text = heading(report);
    let Some(found) = &report.throughput else { return text };
    let _ = writeln!(
        text,
        "\n{} reports/s without loss ({} per report; engine alone {}); bare relay {} reports/s",
        count(report.throughput_per_s as u64),
        duration(1e9 / report.throughput_per_s),
        duration(report.engine_ns_per_update),
        count(found.floor_per_s as u64)
    );
    text.push_str(
        "without loss: every report sent was taken by fusion, every system track received, and no queue was growing\n\n",
    );
    let mut columns = vec![("reports/s", Align::Right), ("held", Align::Left)];
    columns.extend(Figures::NAMES.map(|name| (name, Align::Right)));
    columns.push(("lost", Align::Right));
    let mut table = TextTable::new(&columns);
    for probe in &found.probes {
        let mut cells = vec![
            count(probe.rate_per_s as u64),
            if probe.lossless { "yes" } else { "no" }.to_owned(),
        ];
        cells.extend(probe.latency.values().map(|value| duration(value as f64)));
        cells.push(count(probe.latency.lost));
        table.row(cells);
    }
    let _ = write!(text, "{table}");
    if let Some(overload) = &found.overload {
        text.push_str(&overload_text(overload, report));
    }
    for point in &report.points {
        text.push_str(&point_text(point));
    }
    let [before, after] = found.memory;
    let _ = writeln!(
        text,
        "Memory of fusion over {} s: {} pages resident before, {} after; {} page faults meanwhile, {} of them from disk",
        found.memory_seconds,
        count(before.resident_pages),
        count(after.resident_pages),
        count((after.minor_faults - before.minor_faults) + (after.major_faults - before.major_faults)),
        count(after.major_faults - before.major_faults)
    );
    text.push_str(&stamps(report));
    text.push_str(&footnotes(report));
    text
}

fn overload_text(overload: &Overload, report: &BenchReport) -> String {
    let account = &overload.account;
    let room = report.settings.as_ref().map_or(0.0, |settings| queues(settings) as f64);
    format!(
        "Beyond it, at {} reports/s: {} sent in the process's whole life, {} taken, {} counted as lost by fusion: {}\n\
         99 % of what came through waited no longer than {} from the intended time, and {} at most in the queues; full, \
         these hold {} reports, {} of work at the highest rate\n",
        count(overload.rate_per_s as u64),
        count(account.sent_ever),
        count(account.fusion.taken),
        count(account.fusion.lost),
        if overload.adds_up {
            "it adds up"
        } else {
            "it does NOT add up"
        },
        duration(overload.latency.p99_ns as f64),
        duration(overload.longest_in_queues_ns as f64),
        count(room as u64),
        duration(1e9 * room / report.throughput_per_s)
    )
}

/// Returns the irregularities of a run's reports; empty if there are none.
pub(crate) fn odd(account: &ReportAccount) -> String {
    let mut odd = Vec::new();
    let mut add = |number: u64, what: &str| {
        if number > 0 {
            odd.push(format!("{} {what}", count(number)));
        }
    };
    add(account.unanswered, "unanswered");
    add(account.flood_unanswered, "of the flooding source's share unanswered");
    add(account.beyond_one, "states beyond one a report");
    add(account.unconfirmed, "unconfirmed");
    add(account.fusion.lost, "lost by fusion");
    add(account.fusion.lost_by_reader, "lost by the bench's reader");
    if account.bench_late_ns > BENCH_LATE_NS {
        odd.push(format!(
            "the bench itself was {} late at the end: it cannot send so fast here",
            duration(account.bench_late_ns as f64)
        ));
    }
    if odd.is_empty() {
        String::new()
    } else {
        format!("; {}", odd.join(", "))
    }
}

/// Returns the text of a latency measurement.
pub(crate) fn latency(report: &BenchReport) -> String {
    let mut text = heading(report);
    for point in &report.points {
        text.push_str(&point_text(point));
    }
    let engine = &report.engine;
    let _ = writeln!(
        text,
        "\nEngine alone: {} per update (means of 1,000: {} to {}); single updates p50 {}, p99 {}, max {}",
        duration(engine.ns_per_update),
        duration(engine.ns_per_update_range[0]),
        duration(engine.ns_per_update_range[1]),
        duration(engine.single.p50_ns as f64),
        duration(engine.single.p99_ns as f64),
        duration(engine.single.max_ns as f64)
    );
    text.push_str(&stamps(report));
    if let Some(failure) = report.failure() {
        let _ = writeln!(text, "\nNo verdict: {failure}");
    } else if !report.verdicts.is_empty() {
        let rate = report.points.first().map_or(0.0, |point| point.rate_per_s);
        let _ = writeln!(text, "\nAt {} reports/s:", count(rate as u64));
        for verdict in &report.verdicts {
            let _ = writeln!(text, "  {}", verdict.line());
        }
    }
    text.push_str(&footnotes(report));
    text
}

pub(crate) fn stamps(report: &BenchReport) -> String {
    let stamps = &report.stamps;
    format!(
        "Stamps: a clock reading costs {}; {} of the bench and {} of fusion for each slice\n",
        duration(stamps.reading_ns as f64),
        stamps.bench_per_slice,
        stamps.fusion_per_slice
    )
}

/// Returns the description of machine and settings.
pub(crate) fn heading(report: &BenchReport) -> String {
    let machine = &report.machine;
    let mut text = format!(
        "{} with {} cores, Linux {}{}, load {:.1} before and {:.1} after\n",
        machine.processor,
        machine.cores.len(),
        machine.kernel,
        if machine.virtual_machine {
            " in a virtual machine"
        } else {
            ""
        },
        machine.load_before,
        machine.load_after
    );
    if let Some(settings) = &report.settings {
        let _ = writeln!(
            text,
            "{} targets seen by {} sources, {} reports a slice, wait {}, bench on core {}, fusion on core {}{}{}{}",
            count(settings.targets.into()),
            settings.sources,
            settings.batch,
            settings.wait.word(),
            settings.bench_core,
            settings.fusion_core,
            settings
                .realtime_priority
                .map_or_else(String::new, |priority| format!(", SCHED_FIFO {priority}")),
            if settings.lock_memory { ", memory locked" } else { "" },
            settings
                .rule
                .as_ref()
                .map_or_else(String::new, |rule| format!(", rule {rule}"))
        );
    }
    text
}

pub(crate) fn footnotes(report: &BenchReport) -> String {
    let mut text = String::new();
    for note in &report.notes {
        let _ = writeln!(text, "note: {note}");
    }
    text
}

fn point_text(point: &RatePoint) -> String {
    let runs = &point.runs;
    let seconds = median(&runs.iter().map(|run| run.warm_up.seconds).collect::<Vec<_>>());
    let reports = median(&runs.iter().map(|run| run.warm_up.reports as f64).collect::<Vec<_>>());
    let mut text = format!(
        "\n{} reports/s, {} runs; before each, {} reports in {seconds:.1} s of warm-up that are in no figure\n",
        count(point.rate_per_s as u64),
        runs.len(),
        count(reports as u64)
    );
    text.push_str("median over runs, and from the smallest to the largest:\n");
    let mut columns = vec![("latency from the intended time", Align::Left)];
    columns.extend(Figures::NAMES.map(|name| (name, Align::Right)));
    columns.push(("lost", Align::Right));
    let mut table = TextTable::new(&columns);
    spread_row(&mut table, "relay (floor)", runs, |run| run.floor);
    spread_row(&mut table, "pipeline", runs, |run| run.pipeline);
    spread_row(&mut table, "machine alone", runs, |run| run.jitter.lateness);
    ratio_row(&mut table, runs);
    for stage in STAGES.iter().filter(|stage| **stage != Stage::EndToEnd) {
        let label = match stage {
            Stage::IngestToPublish => "  bench: from due to sent",
            Stage::PublishToTaken => "  transport in",
            Stage::TakenToFused => "  in fusion",
            _ => "  transport out",
        };
        spread_row(&mut table, label, runs, |run| run.stages[stage.key()]);
    }
    if let Some(flooded) = &point.flooded {
        row(&mut table, "flooding source's share", flooded);
    }
    let _ = write!(text, "{table}");
    text.push_str(&jitter_text(&point.jitter));
    text.push_str(&account_text(runs));
    text
}

fn jitter_text(jitter: &JitterFigures) -> String {
    format!(
        "Machine: {} interruptions of the bench's core, {:.2} % of its time; half of them up to {}, 99 % up to {}, the \
         longest {}\n",
        count(jitter.gaps.count),
        100.0 * jitter.taken_away,
        duration(jitter.gaps.p50_ns as f64),
        duration(jitter.gaps.p99_ns as f64),
        duration(jitter.gaps.max_ns as f64)
    )
}

fn account_text(runs: &[Repetition]) -> String {
    let sum = |of: fn(&ReportAccount) -> u64| runs.iter().map(|run| of(&run.account)).sum::<u64>();
    let unsettled = runs.iter().filter(|run| !run.warm_up.settled).count();
    let adds_up = runs.iter().all(|run| run.account.adds_up());
    let mut text = format!(
        "Reports: {} sent, {} answered by one system track each, {} unanswered, {} states beyond one a report, {} \
         without a report; fusion took {} and missed {} of all that was ever sent ({})\n",
        count(sum(|account| account.sent)),
        count(sum(|account| account.answers - account.beyond_one)),
        count(sum(|account| account.unanswered)),
        count(sum(|account| account.beyond_one)),
        count(sum(|account| account.untriggered)),
        count(sum(|account| account.fusion.taken)),
        count(sum(|account| account.fusion.lost)),
        if adds_up { "adds up" } else { "does NOT add up" }
    );
    if unsettled > 0 {
        let _ = writeln!(
            text,
            "{unsettled} runs began before every report was answered by exactly one confirmed track"
        );
    }
    text
}

pub(crate) fn row(table: &mut TextTable, name: &str, figures: &Figures) {
    let mut cells = vec![name.to_owned()];
    cells.extend(figures.values().map(|value| duration(value as f64)));
    cells.push(count(figures.lost));
    table.row(cells);
}

/// Adds two lines: medians, and the range over the runs.
fn spread_row(table: &mut TextTable, name: &str, runs: &[Repetition], of: impl Fn(&Repetition) -> Figures) {
    spread(table, name, &runs.iter().map(of).collect::<Vec<_>>());
}

fn spread(table: &mut TextTable, name: &str, runs: &[Figures]) {
    row(table, name, &Figures::median(runs));
    if runs.len() > 1 {
        let mut cells = vec![String::new()];
        for index in 0..Figures::NAMES.len() {
            let (low, high) = range(&runs.iter().map(|run| run.values()[index] as f64).collect::<Vec<_>>());
            cells.push(format!("{} … {}", duration(low), duration(high)));
        }
        table.row(cells);
    }
}

/// Adds the median of the runs' own ratios: disturbances affect both sides of a ratio.
fn ratio_row(table: &mut TextTable, runs: &[Repetition]) {
    let mut cells = vec!["pipeline / relay, paired".to_owned()];
    for index in 0..Figures::NAMES.len() {
        let ratios: Vec<f64> = runs
            .iter()
            .map(|run| run.pipeline.values()[index] as f64 / (run.floor.values()[index] as f64).max(1.0))
            .collect();
        let (low, high) = range(&ratios);
        let middle = median(&ratios);
        cells.push(match runs.len() {
            1 => format!("{middle:.2}"),
            _ => format!("{middle:.2} ({low:.2} … {high:.2})"),
        });
    }
    table.row(cells);
}

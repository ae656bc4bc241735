//! `koseki bench engine`: cost of one report in the engine, without any bus.

use hdrhistogram::Histogram;
use runtime::signals::Stop;
use telemetry::table::{Align, TextTable, count, duration};

use crate::distributions::stamps;
use crate::engine_time::{self, EngineTimes};
use crate::figures::{Figures, median};
use crate::machine::{self, MachineFacts};
use crate::outputs::OutputFiles;
use crate::product::Product;
use crate::progress::say;
use crate::recorder::histogram;
use crate::report::{BenchReport, MeasurementOutcome};
use crate::settings::Settings;
use crate::text;

/// Measures the engine of `product`; the rate of `settings` only sets the time between reports. Returns the text to
/// show, and the reason if the figures are unreliable.
///
/// # Errors
/// If the settings are invalid, or a file cannot be written.
pub fn run(product: &dyn Product, settings: &Settings, outputs: &OutputFiles) -> anyhow::Result<MeasurementOutcome> {
    settings.check_without_cores()?;
    outputs.check()?;
    let stop = Stop::on_signals_to_clear_up()?;
    let mut machine = MachineFacts::read();
    let notes = machine::notes(settings, &machine);
    for note in &notes {
        say(note);
    }
    let watch = || {
        anyhow::ensure!(!stop.requested(), "stopped before the end; no figures are shown");
        Ok(())
    };
    let mut runs: Vec<EngineTimes> = Vec::new();
    let mut single: Histogram<u64> = histogram();
    for number in 1..=settings.runs {
        let (times, each) =
            engine_time::measure(product, settings, (settings.rates_per_s[0], settings.seconds), watch)?;
        say(&format!(
            "run {number} of {}: {} per update",
            settings.runs,
            duration(times.ns_per_update)
        ));
        single.add(&each).expect("the same bounds");
        runs.push(times);
    }
    machine.ended();
    let all = together(&runs);
    let report = BenchReport {
        command: "engine".to_owned(),
        machine,
        settings: Some(settings.clone()),
        engine_ns_per_update: all.ns_per_update,
        stamps: stamps(all.reading_ns),
        engine: all,
        notes,
        ..BenchReport::default()
    };
    outputs.write(&report, &[], Some(&single))?;
    Ok(MeasurementOutcome {
        text: shown(&report, &runs),
        failure: report.failure(),
    })
}

/// Returns medians over the runs.
fn together(runs: &[EngineTimes]) -> EngineTimes {
    let middle = |of: fn(&EngineTimes) -> f64| median(&runs.iter().map(of).collect::<Vec<_>>());
    let first = runs.first().cloned().unwrap_or_default();
    EngineTimes {
        ns_per_update: middle(|run| run.ns_per_update),
        ns_per_update_range: [
            runs.iter().map(|run| run.ns_per_update).fold(f64::INFINITY, f64::min),
            runs.iter().map(|run| run.ns_per_update).fold(0.0, f64::max),
        ],
        single: Figures::median(&runs.iter().map(|run| run.single).collect::<Vec<_>>()),
        report_ns: middle(|run| run.report_ns),
        chunks: runs.iter().map(|run| run.chunks).sum(),
        paced: Figures::median(&runs.iter().map(|run| run.paced).collect::<Vec<_>>()),
        ..first
    }
}

fn shown(report: &BenchReport, runs: &[EngineTimes]) -> String {
    let mut text = text::heading(report);
    let mut columns = vec![
        ("update of the engine", Align::Left),
        ("median of means of 1,000", Align::Right),
    ];
    columns.extend(Figures::NAMES.map(|name| (name, Align::Right)));
    columns.push(("odd", Align::Right));
    let mut table = TextTable::new(&columns);
    let mut row = |name: String, times: &EngineTimes| {
        let mut cells = vec![name, duration(times.ns_per_update)];
        cells.extend(times.single.values().map(|value| duration(value as f64)));
        cells.push(count(times.single.lost));
        table.row(cells);
    };
    for (number, run) in runs.iter().enumerate() {
        row(format!("run {}", number + 1), run);
    }
    row("median over runs".to_owned(), &report.engine);
    let mut cells = vec!["paced".to_owned(), String::new()];
    cells.extend(report.engine.paced.values().map(|value| duration(value as f64)));
    cells.push(count(report.engine.paced.lost));
    table.row(cells);
    let engine = &report.engine;
    text.push_str(&format!(
        "\n{table}Percentiles are of single updates, less {} for reading the clock; means are less {} for building the report.\n\
         paced: reports at their rate, at most 5,000 a second, other memory read between them; p50 {:.1} times that back to back.\n\
         Memory of the engine: {:.1} kB for each target, with its tables.\n\
         odd: updates that did not yield exactly one confirmed state. Warm-up: {} reports in {:.1} s{}.\n",
        duration(engine.reading_ns as f64),
        duration(engine.report_ns),
        engine.paced.p50_ns as f64 / (engine.single.p50_ns as f64).max(1.0),
        engine.octets_per_target * 1e-3,
        count(engine.warm_up.reports),
        engine.warm_up.seconds,
        if engine.warm_up.settled {
            ""
        } else {
            ", after which some were still odd"
        }
    ));
    text.push_str(&text::footnotes(report));
    text
}

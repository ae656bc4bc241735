//! `koseki bench floor`: what each layer adds to the way of a report, on this machine.
//!
//! Round trips of the same reports at the same rate, through more and more of the whole: two rings between threads, a
//! relay with bare iceoryx2 ports, a relay over the bus with its headers and counts, and fusion. The measurements take
//! turns, so that a disturbance of a shared machine affects all, and both the median over the rounds and the best round
//! are shown: the best is what the machine can do. The engine is measured alone, back to back and paced.

use runtime::signals::Stop;
use telemetry::table::{Align, TextTable, count, duration};

use crate::distributions::stamps;
use crate::engine_time;
use crate::figures::{Figures, median};
use crate::machine;
use crate::measure::{self, LoadPlan, MeasurementResult};
use crate::outputs::OutputFiles;
use crate::product::Product;
use crate::progress::say;
use crate::report::{BenchReport, LayerFigures, MeasurementOutcome};
use crate::settings::Settings;
use crate::site::BenchSite;
use crate::text;

type Measurement = fn(&BenchSite, &Settings, LoadPlan) -> anyhow::Result<MeasurementResult>;

/// The layers, each with all before it, and what it adds.
const LAYERS: [(&str, &str, Measurement); 4] = [
    ("ring", "two queues between threads of one process", measure::ring),
    ("relay", "iceoryx2, another process", measure::relay),
    ("bus", "topics, sequence numbers, marks, counts", measure::over_bus),
    ("fusion", "loop and engine", measure::pipeline),
];

/// Measures all layers; returns the text to show, and the reason if the figures are unreliable.
///
/// # Errors
/// If the settings are invalid, a process fails, or a file cannot be written.
pub fn run(product: &dyn Product, settings: &Settings, outputs: &OutputFiles) -> anyhow::Result<MeasurementOutcome> {
    settings.check()?;
    outputs.check()?;
    let stop = Stop::on_signals_to_clear_up()?;
    let (mut machine, notes) = machine::begin(settings);
    let site = BenchSite::prepare(product, settings, &stop)?;
    let rate = settings.rates_per_s[0];
    let plan = LoadPlan {
        rate_per_s: rate,
        seconds: settings.seconds,
        detailed: false,
    };
    let watch = || {
        anyhow::ensure!(!site.stop_requested(), "stopped before the end; no figures are shown");
        Ok(())
    };
    let (engine, single) = engine_time::measure(product, settings, (rate, settings.seconds), watch)?;
    let mut runs = vec![Vec::new(); LAYERS.len()];
    for number in 1..=settings.runs {
        for ((name, _, measurement), runs) in LAYERS.iter().zip(&mut runs) {
            let measured = measurement(&site, settings, plan)?;
            let figures = Figures::of(measured.recorder.end_to_end(), measured.unanswered());
            say(&format!(
                "round {number} of {}: {name} {} (p50)",
                settings.runs,
                duration(figures.p50_ns as f64)
            ));
            runs.push(figures);
        }
    }
    drop(site);
    machine.ended();
    let layers = LAYERS
        .iter()
        .zip(&runs)
        .map(|((name, ..), runs)| layer(name, runs))
        .collect();
    let report = BenchReport {
        command: "floor".to_owned(),
        machine,
        settings: Some(settings.clone()),
        engine_ns_per_update: engine.ns_per_update,
        stamps: stamps(engine.reading_ns),
        engine,
        layers,
        notes,
        ..BenchReport::default()
    };
    outputs.write(&report, &[], Some(&single))?;
    Ok(MeasurementOutcome {
        text: shown(&report),
        failure: report.failure(),
    })
}

fn layer(name: &str, runs: &[Figures]) -> LayerFigures {
    LayerFigures {
        name: name.to_owned(),
        best_p50_ns: runs.iter().map(|run| run.p50_ns).min().unwrap_or_default(),
        p50_ns: median(&runs.iter().map(|run| run.p50_ns as f64).collect::<Vec<_>>()) as u64,
        p99_ns: median(&runs.iter().map(|run| run.p99_ns as f64).collect::<Vec<_>>()) as u64,
        unanswered: runs.iter().map(|run| run.lost).sum(),
    }
}

fn shown(report: &BenchReport) -> String {
    let mut text = text::heading(report);
    let columns = [
        ("round trip", Align::Left),
        ("with", Align::Left),
        ("best p50", Align::Right),
        ("adds", Align::Right),
        ("median p50", Align::Right),
        ("p99", Align::Right),
        ("unanswered", Align::Right),
    ];
    let mut table = TextTable::new(&columns);
    let mut before_ns = 0;
    for (layer, (_, with, _)) in report.layers.iter().zip(LAYERS) {
        let adds_ns = layer.best_p50_ns as f64 - before_ns as f64;
        before_ns = layer.best_p50_ns;
        table.row(vec![
            layer.name.clone(),
            with.to_owned(),
            duration(layer.best_p50_ns as f64),
            signed(adds_ns),
            duration(layer.p50_ns as f64),
            duration(layer.p99_ns as f64),
            count(layer.unanswered),
        ]);
    }
    let engine = &report.engine;
    let best = |name: &str| {
        let mut layers = report.layers.iter();
        layers
            .find(|layer| layer.name == name)
            .map_or(0.0, |layer| layer.best_p50_ns as f64)
    };
    let whole_ns = best("fusion") - best("bus");
    text.push_str(&format!(
        "\n{table}Of the {} that fusion adds to the bus, the engine takes {} back to back and {} paced, with cold caches; the\n\
         rest is the loop.\n",
        signed(whole_ns),
        duration(engine.single.p50_ns as f64),
        duration(engine.paced.p50_ns as f64),
    ));
    text.push_str(&text::footnotes(report));
    text
}

/// A difference, which noise may make negative.
fn signed(nanoseconds: f64) -> String {
    if nanoseconds < 0.0 {
        format!("-{}", duration(-nanoseconds))
    } else {
        duration(nanoseconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_layer_shows_its_best_round_and_what_it_adds() {
        let figures = |p50_ns: u64| Figures {
            p50_ns,
            p99_ns: 10 * p50_ns,
            lost: 1,
            ..Figures::default()
        };
        let times = [
            [300, 200, 400],
            [1500, 1200, 1900],
            [1400, 1700, 1300],
            [5000, 3300, 4000],
        ];
        let layers = LAYERS
            .iter()
            .zip(times)
            .map(|((name, ..), times)| layer(name, &times.map(figures)))
            .collect();
        let report = BenchReport {
            layers,
            ..BenchReport::default()
        };
        let of_ring = &report.layers[0];
        assert_eq!(
            (of_ring.best_p50_ns, of_ring.p50_ns, of_ring.p99_ns, of_ring.unanswered),
            (200, 300, 3000, 3)
        );
        let text = shown(&report);
        let row = |name: &str| {
            text.lines()
                .find(|line| line.trim_start().starts_with(name))
                .unwrap_or_default()
        };
        assert!(row("relay").contains(&duration(1000.0)), "{text}");
        assert!(row("bus").contains(&duration(100.0)), "{text}");
        assert!(row("fusion").contains(&duration(2000.0)), "{text}");
        assert_eq!(signed(-5.0), format!("-{}", duration(5.0)));
    }
}

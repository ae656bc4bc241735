//! `koseki bench compare`: before and after.
//!
//! Two files are comparable if both measurements used the same settings; the command lists differences. The command
//! reports a change only if the runs of one file all lie on one side of the runs of the other. With five runs each,
//! chance alone causes this once in 126 comparisons of equal figures. The floor is compared as well: a changed
//! floor means a changed machine.

use std::path::Path;

use serde_json::Value;
use telemetry::table::{Align, TextTable, count, duration};

use crate::figures::{Figures, range};
use crate::report::{BenchReport, RatePoint, Repetition};
use crate::settings::MeasurementRefusal;

/// Minimum number of runs on each side for a conclusion.
const RUNS_MIN: usize = 4;

/// Compares two files; `force` permits different settings. Returns the text to show.
///
/// # Errors
/// If a file cannot be read, or the files cannot be compared.
pub fn run(before: &Path, after: &Path, force: bool) -> anyhow::Result<String> {
    let read = |path: &Path| BenchReport::read(path).map_err(|error| MeasurementRefusal(format!("{error:#}")));
    let (a, b) = (read(before)?, read(after)?);
    let different = differences(&a, &b);
    if !different.is_empty() && !force {
        let what = different.join(", ");
        return Err(MeasurementRefusal(format!(
            "the files have different settings: {what}; compare them all the same with --force"
        ))
        .into());
    }
    Ok(shown(&a, &b, &different))
}

/// Returns differing settings, as `name a -> b`.
fn differences(a: &BenchReport, b: &BenchReport) -> Vec<String> {
    let values = |report: &BenchReport| serde_json::to_value(&report.settings).unwrap_or(Value::Null);
    let (before, after) = (values(a), values(b));
    let mut different = Vec::new();
    if a.command != b.command {
        different.push(format!("command {} -> {}", a.command, b.command));
    }
    let empty = serde_json::Map::new();
    let of = |value: &Value| value.as_object().unwrap_or(&empty).clone();
    let (before, after) = (of(&before), of(&after));
    for name in before
        .keys()
        .chain(after.keys().filter(|name| !before.contains_key(*name)))
    {
        let (old, new) = (
            before.get(name).unwrap_or(&Value::Null),
            after.get(name).unwrap_or(&Value::Null),
        );
        if old != new {
            different.push(format!("{name} {old} -> {new}"));
        }
    }
    different
}

fn shown(a: &BenchReport, b: &BenchReport, different: &[String]) -> String {
    let mut text = String::new();
    for each in different {
        text.push_str(&format!("different: {each}\n"));
    }
    let machine = |report: &BenchReport| {
        let machine = &report.machine;
        (machine.processor.clone(), machine.cores.len(), machine.kernel.clone())
    };
    if machine(a) != machine(b) {
        text.push_str(&format!("different machines: {:?} -> {:?}\n", machine(a), machine(b)));
    }
    let load = |report: &BenchReport| report.machine.load_before.max(report.machine.load_after);
    text.push_str(&format!(
        "load: {:.1} before, {:.1} after the change\n\n",
        load(a),
        load(b)
    ));
    let columns = ["figure", "before", "after", "after / before", "change"];
    let mut table = TextTable::new(&columns.map(|name| {
        let align = if name == "figure" || name == "change" {
            Align::Left
        } else {
            Align::Right
        };
        (name, align)
    }));
    for before in &a.points {
        let same_rate = |point: &&RatePoint| point.rate_per_s == before.rate_per_s;
        let Some(after) = b.points.iter().find(same_rate) else {
            continue;
        };
        let rate = count(before.rate_per_s as u64);
        rows(&mut table, &format!("{rate}/s relay"), before, after, |run| run.floor);
        rows(&mut table, &format!("{rate}/s pipeline"), before, after, |run| {
            run.pipeline
        });
        rows(&mut table, &format!("{rate}/s machine"), before, after, |run| {
            run.jitter.lateness
        });
    }
    if a.engine_ns_per_update > 0.0 && b.engine_ns_per_update > 0.0 {
        let (before, after) = (a.engine_ns_per_update, b.engine_ns_per_update);
        let ranges = (a.engine.ns_per_update_range, b.engine.ns_per_update_range);
        let change = judged((ranges.0[0], ranges.0[1]), (ranges.1[0], ranges.1[1]), RUNS_MIN);
        line(&mut table, "engine per update", before, after, change, duration);
    }
    if a.throughput.is_some() && b.throughput.is_some() {
        let per_s = |rate: f64| count(rate as u64);
        line(
            &mut table,
            "reports/s without loss",
            a.throughput_per_s,
            b.throughput_per_s,
            "(one search each)",
            per_s,
        );
    }
    text.push_str(&table.to_string());
    text
}

fn rows(table: &mut TextTable, name: &str, before: &RatePoint, after: &RatePoint, of: fn(&Repetition) -> Figures) {
    let runs = |point: &RatePoint| point.runs.iter().map(of).collect::<Vec<_>>();
    let (old, new) = (runs(before), runs(after));
    let fewest = old.len().min(new.len());
    for (index, figure) in Figures::NAMES.iter().enumerate() {
        let values = |runs: &[Figures]| range(&runs.iter().map(|run| run.values()[index] as f64).collect::<Vec<_>>());
        let middle = |runs: &[Figures]| Figures::median(runs).values()[index] as f64;
        let change = judged(values(&old), values(&new), fewest);
        line(
            table,
            &format!("{name} {figure}"),
            middle(&old),
            middle(&new),
            change,
            duration,
        );
    }
}

fn line(table: &mut TextTable, name: &str, before: f64, after: f64, change: &str, shown: impl Fn(f64) -> String) {
    let ratio = if before > 0.0 {
        format!("{:.2}", after / before)
    } else {
        "-".to_owned()
    };
    table.row([name.to_owned(), shown(before), shown(after), ratio, change.to_owned()]);
}

/// Returns the conclusion from two ranges of runs.
fn judged(before: (f64, f64), after: (f64, f64), runs: usize) -> &'static str {
    if runs < RUNS_MIN {
        "too few runs for a result"
    } else if after.0 > before.1 {
        "MORE, beyond the runs' spread"
    } else if after.1 < before.0 {
        "less, beyond the runs' spread"
    } else {
        "within the runs' spread"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::test_settings;

    fn report(p50_ns: u64) -> BenchReport {
        let run = |run: u64| Repetition {
            pipeline: Figures {
                p50_ns: p50_ns + 10 * run,
                ..Figures::default()
            },
            ..Repetition::default()
        };
        let point = RatePoint {
            rate_per_s: 20_000.0,
            runs: (0..5).map(run).collect(),
            ..RatePoint::default()
        };
        BenchReport {
            command: "latency".to_owned(),
            settings: Some(test_settings()),
            points: vec![point],
            ..BenchReport::default()
        }
    }

    #[test]
    fn a_change_is_one_beyond_the_spread_of_the_runs() {
        let line = |a: u64, b: u64| {
            let text = shown(&report(a), &report(b), &[]);
            text.lines()
                .find(|line| line.contains("pipeline p50"))
                .unwrap()
                .to_owned()
        };
        assert!(
            line(2_000, 4_000).contains("1.99  MORE, beyond"),
            "{}",
            line(2_000, 4_000)
        );
        assert!(line(4_000, 2_000).contains("less, beyond"));
        assert!(line(2_000, 2_030).contains("within the runs' spread"));
        assert_eq!(judged((1.0, 2.0), (5.0, 6.0), 3), "too few runs for a result");
    }

    #[test]
    fn files_of_different_settings_are_refused_unless_forced() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a.json", "b.json"].map(|name| folder.path().join(name));
        report(1_000).write(&a).unwrap();
        let mut other = report(1_000);
        other.settings.as_mut().unwrap().targets = 7;
        other.write(&b).unwrap();
        let refused = run(&a, &b, false).unwrap_err();
        assert!(refused.is::<MeasurementRefusal>());
        assert!(refused.to_string().contains("targets 100 -> 7"), "{refused}");
        assert!(run(&a, &b, true).unwrap().contains("different: targets 100 -> 7"));
        assert!(run(&a, &a, false).is_ok());
        std::fs::write(&b, "{}").unwrap();
        assert!(run(&a, &b, true).unwrap_err().to_string().contains("b.json"));
    }
}

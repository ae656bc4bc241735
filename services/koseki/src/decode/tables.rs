//! The statistics of a recording as tables for people and as JSON for programs.

use std::fmt::Write as _;
use std::path::Path;

use formats::recording::{Rate, RecordingSurvey, Statistics};
use serde_json::json;
use telemetry::table::{Align, TextTable, count};

/// All tables, in sequence.
pub(super) fn tables(file: &Path, survey: &RecordingSurvey, statistics: &Statistics) -> String {
    let mut text = format!("{}, {}\n", file.display(), survey.container);
    let mut section = |table: TextTable| write!(text, "\n{table}").unwrap_or(());
    section(table_of_octets(survey));
    section(table_of_categories(survey));
    section(table_of_senders(statistics));
    if !survey.refusals.by_count().is_empty() {
        section(table_of_refusals(survey));
    }
    text
}

fn table_of_octets(survey: &RecordingSurvey) -> TextTable {
    let mut table = TextTable::new(&[("counted", Align::Right), ("", Align::Left)]);
    for (_, sentence, value) in survey.unpacked.entries() {
        if value > 0 {
            table.row([count(value), sentence.to_owned()]);
        }
    }
    table
}

fn table_of_categories(survey: &RecordingSurvey) -> TextTable {
    let mut table = TextTable::new(&[
        ("category", Align::Left),
        ("edition", Align::Left),
        ("blocks", Align::Right),
        ("refused", Align::Right),
        ("records", Align::Right),
        ("", Align::Left),
    ]);
    for (number, category) in &survey.categories {
        let withheld = category.is_withheld();
        table.row([
            format!("{number:03}"),
            category
                .edition
                .map_or_else(|| "-".to_owned(), |edition| edition.to_string()),
            count(category.blocks),
            count(category.blocks_refused),
            count(if withheld { 0 } else { category.records }),
            if withheld { "withheld" } else { "" }.to_owned(),
        ]);
    }
    table
}

fn table_of_senders(statistics: &Statistics) -> TextTable {
    let mut table = TextTable::new(&[
        ("category", Align::Left),
        ("source", Align::Left),
        ("records", Align::Right),
        ("first", Align::Left),
        ("last", Align::Left),
        ("min/s", Align::Right),
        ("median/s", Align::Right),
        ("max/s", Align::Right),
    ]);
    let unknown = || "-".to_owned();
    for summary in statistics.senders() {
        let rate = |of: fn(Rate) -> u64| summary.rate.map_or_else(unknown, |rate| count(of(rate)));
        let source = summary.sender.source;
        table.row([
            format!("{:03}", summary.sender.category),
            source.map_or_else(unknown, |(area, identification)| format!("{area}/{identification}")),
            count(summary.records),
            summary.first_s.map_or_else(unknown, time_of_day),
            summary.last_s.map_or_else(unknown, time_of_day),
            rate(|rate| rate.min),
            rate(|rate| rate.median),
            rate(|rate| rate.max),
        ]);
    }
    table
}

fn table_of_refusals(survey: &RecordingSurvey) -> TextTable {
    let mut table = TextTable::new(&[
        ("refused", Align::Right),
        ("octets", Align::Right),
        ("category", Align::Left),
        ("item", Align::Left),
        ("reason", Align::Left),
        ("the first", Align::Left),
    ]);
    for refusal in survey.refusals.by_count() {
        table.row([
            count(refusal.count),
            count(refusal.octets),
            refusal
                .category
                .map_or_else(|| "-".to_owned(), |category| format!("{category:03}")),
            refusal.item.unwrap_or("-").to_owned(),
            refusal.reason.to_owned(),
            refusal.first.clone(),
        ]);
    }
    table
}

/// `22:00:01.250`, and on other days than the first `00:00:01.250 +1 d`.
fn time_of_day(seconds: f64) -> String {
    const DAY_MS: i64 = 86_400_000;
    let all_ms = (seconds * 1000.0).round() as i64;
    let (day, ms) = (all_ms.div_euclid(DAY_MS), all_ms.rem_euclid(DAY_MS));
    let (minutes, ms) = (ms / 60_000, ms % 60_000);
    let time = format!(
        "{:02}:{:02}:{:02}.{:03}",
        minutes / 60,
        minutes % 60,
        ms / 1000,
        ms % 1000
    );
    match day {
        0 => time,
        day => format!("{time} {day:+} d"),
    }
}

/// The same as an object.
pub(super) fn as_json(survey: &RecordingSurvey, statistics: &Statistics) -> serde_json::Value {
    let counters = survey
        .unpacked
        .entries()
        .map(|(label, _, value)| (label.to_owned(), json!(value)));
    let categories = survey.categories.iter().map(|(number, category)| {
        json!({
            "category": number,
            "edition": category.edition.map(|edition| edition.to_string()),
            "blocks": category.blocks,
            "blocks_refused": category.blocks_refused,
            "records": category.records,
            "withheld": category.is_withheld(),
        })
    });
    json!({
        "container": survey.container.word(),
        "unpacked": counters.into_iter().collect::<serde_json::Map<_, _>>(),
        "categories": categories.collect::<Vec<_>>(),
        "senders": statistics.senders().collect::<Vec<_>>(),
        "refusals": survey.refusals.by_count(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_show_the_day_they_are_of() {
        assert_eq!(time_of_day(79_201.25), "22:00:01.250");
        assert_eq!(time_of_day(86_461.999_6), "00:01:02.000 +1 d");
        assert_eq!(time_of_day(-1.0), "23:59:59.000 -1 d");
    }
}

//! The comparison as a table: a row for each rule, a column for each figure.

use serde_json::Value;
use telemetry::table::{Align, TextTable};

use super::RuleOutcome;
use crate::printed::digits;

/// Columns that need a truth, and columns that need none, in display order.
const AGAINST_TRUTH: [&str; 15] = [
    "gospa",
    "loc",
    "missed",
    "false",
    "ospa",
    "rmse_pos",
    "rmse_vel",
    "id_switches",
    "breaks",
    "spurious",
    "completeness",
    "wander_p95",
    "wander_max",
    "direction_std_deg",
    "nees_pos",
];
const ALONE: [&str; 5] = ["confirmed_tracks", "hand_overs", "rows", "coasted", "us_per_report"];

/// Returns the table, for a screen or for documents.
///
/// # Errors
/// Never: figures can all be shown as JSON.
pub(super) fn table(outcomes: &[RuleOutcome], markdown: bool) -> anyhow::Result<String> {
    let scored = outcomes.iter().any(|outcome| outcome.score.is_some());
    let columns: Vec<&str> = match scored {
        true => AGAINST_TRUTH.into_iter().chain(ALONE).collect(),
        false => ALONE.to_vec(),
    };
    let mut rows = Vec::new();
    for outcome in outcomes {
        let figures = serde_json::to_value(outcome)?;
        let mut row = vec![outcome.rule.to_owned()];
        row.extend(columns.iter().map(|name| figure(&figures[*name])));
        rows.push(row);
    }
    Ok(if markdown {
        as_markdown(&columns, &rows)
    } else {
        as_text(&columns, rows)
    })
}

fn as_text(columns: &[&str], rows: Vec<Vec<String>>) -> String {
    let figures = columns.iter().map(|name| (*name, Align::Right));
    let headings: Vec<_> = [("rule", Align::Left)].into_iter().chain(figures).collect();
    let mut table = TextTable::new(&headings);
    for row in rows {
        table.row(row);
    }
    table.to_string()
}

fn as_markdown(columns: &[&str], rows: &[Vec<String>]) -> String {
    let mut text = format!("| rule | {} |\n", columns.join(" | "));
    text += &format!("| --- |{}\n", " ---: |".repeat(columns.len()));
    for row in rows {
        text += &format!("| {} |\n", row.join(" | "));
    }
    text
}

fn figure(value: &Value) -> String {
    match value {
        Value::Number(number) if number.is_f64() => digits(number.as_f64().unwrap_or_default()),
        Value::Number(number) => number.to_string(),
        _ => "-".to_owned(),
    }
}

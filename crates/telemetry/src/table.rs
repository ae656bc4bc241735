//! Figures for people: aligned tables, and units that keep numbers short.
//!
//! Tables are plain text without borders, so that they can be read in a log, searched, and pasted.

use std::fmt;

use comfy_table::{CellAlignment, presets};

use crate::summary::Summary;

/// Content of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// Text, aligned left.
    Left,
    /// Numbers, aligned right.
    Right,
}

/// Small table: a line of headings and rows below it. [`fmt::Display`] renders one line per row.
#[derive(Clone, Debug)]
pub struct TextTable {
    table: comfy_table::Table,
}

impl TextTable {
    /// Creates a table without rows; `columns` are headings and contents.
    pub fn new(columns: &[(&str, Align)]) -> Self {
        let mut table = comfy_table::Table::new();
        table
            .load_style(presets::NOTHING)
            .set_header(columns.iter().map(|(heading, _)| *heading));
        for (index, (_, align)) in columns.iter().enumerate() {
            if let Some(column) = table.column_mut(index) {
                // Two blanks between columns, none before the first.
                column.set_padding((if index == 0 { 0 } else { 2 }, 0));
                column.set_cell_alignment(match align {
                    Align::Left => CellAlignment::Left,
                    Align::Right => CellAlignment::Right,
                });
            }
        }
        Self { table }
    }

    /// Adds a row; missing cells stay empty.
    pub fn row<C: Into<String>>(&mut self, cells: impl IntoIterator<Item = C>) -> &mut Self {
        self.table
            .add_row(cells.into_iter().map(|cell| comfy_table::Cell::new(cell.into())));
        self
    }
}

impl fmt::Display for TextTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for line in self.table.lines() {
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

/// Returns the latency table: one line per name (a stage, a source, …) with the figures of its summary, or dashes for
/// `None` (not measured).
pub fn latencies<N: Into<String>, S: Into<Option<Summary>>>(
    heading: &str,
    rows: impl IntoIterator<Item = (N, S)>,
) -> TextTable {
    let figures = ["count", "p50", "p90", "p99", "p99.9", "max", "mean"];
    let mut columns = vec![(heading, Align::Left)];
    columns.extend(figures.map(|figure| (figure, Align::Right)));
    let mut table = TextTable::new(&columns);
    for (name, summary) in rows {
        let Some(summary) = summary.into() else {
            table.row([name.into()].into_iter().chain(figures.map(|_| "-".to_owned())));
            continue;
        };
        let mut cells = vec![name.into(), count(summary.count)];
        if summary.count > 0 {
            let percentiles = [
                summary.p50_ns,
                summary.p90_ns,
                summary.p99_ns,
                summary.p999_ns,
                summary.max_ns,
            ];
            cells.extend(percentiles.map(|value| duration(value as f64)));
            cells.push(duration(summary.mean_ns));
        }
        table.row(cells);
    }
    table
}

/// Returns a number with separators: `1,234,567`.
pub fn count(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Returns a duration to three significant digits, in the unit that keeps it short: `812 ns`, `12.3 µs`, `4.56 ms`,
/// `1,234 s`.
pub fn duration(nanoseconds: f64) -> String {
    if !nanoseconds.is_finite() {
        return "-".to_owned();
    }
    let sign = if nanoseconds < 0.0 { "-" } else { "" };
    let magnitude = nanoseconds.abs();
    if magnitude < 999.5 {
        // Whole nanoseconds, except for means of very few.
        let decimals = usize::from(magnitude < 9.95 && magnitude.fract() != 0.0);
        return format!("{sign}{magnitude:.decimals$} ns");
    }
    for (unit_ns, unit) in [(1e3, "µs"), (1e6, "ms"), (1e9, "s")] {
        let value = magnitude / unit_ns;
        if value < 999.5 {
            return format!("{sign}{} {unit}", three_digits(value));
        }
    }
    format!("{sign}{} s", count((magnitude / 1e9).round() as u64))
}

/// Returns three significant digits of a value below 999.5.
fn three_digits(value: f64) -> String {
    let decimals = match value {
        value if value < 9.995 => 2,
        value if value < 99.95 => 1,
        _ => 0,
    };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_people() {
        let counts = [0, 999, 1000, 1_234_567, 12_345_678].map(count);
        assert_eq!(counts, ["0", "999", "1,000", "1,234,567", "12,345,678"]);
        let cases = [
            (0.0, "0 ns"),
            (1.0, "1 ns"),
            (2.5, "2.5 ns"),
            (812.0, "812 ns"),
            (999.6, "1.00 µs"),
            (12_345.0, "12.3 µs"),
            (99_960.0, "100 µs"),
            (999_400.0, "999 µs"),
            (999_600.0, "1.00 ms"),
            (4_560_000.0, "4.56 ms"),
            (1_234_000_000.0, "1.23 s"),
            (999.9e9, "1,000 s"),
            (1_234_000_000_000.0, "1,234 s"),
            (-1500.0, "-1.50 µs"),
            (f64::NAN, "-"),
        ];
        for (nanoseconds, expected) in cases {
            assert_eq!(duration(nanoseconds), expected);
        }
    }

    #[test]
    fn latency_table() {
        let summary = Summary {
            count: 123_456,
            p50_ns: 812,
            p90_ns: 1_500,
            p99_ns: 23_400,
            p999_ns: 456_000,
            max_ns: 7_890_000,
            mean_ns: 1_043.7,
        };
        let rows = [
            ("transport in", Some(summary)),
            ("fusion", Some(Summary { count: 7, ..summary })),
            ("transport out", None),
            ("age of data", Some(Summary::default())),
        ];
        let expected = "\
stage            count     p50      p90      p99   p99.9      max     mean
transport in   123,456  812 ns  1.50 µs  23.4 µs  456 µs  7.89 ms  1.04 µs
fusion               7  812 ns  1.50 µs  23.4 µs  456 µs  7.89 ms  1.04 µs
transport out        -       -        -        -       -        -        -
age of data          0
";
        assert_eq!(latencies("stage", rows).to_string(), expected);
    }
}

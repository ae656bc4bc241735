//! Refusals in words, for health messages.
//!
//! A count alone leaves a user without the reason. For each of the latest reasons a text is kept: the time of day of
//! the receipt, the line or item, the value, the limit and the remedy. A flood of refusals costs no more than the
//! counts: a reason gets a new text at most every [`RENEWED_NS`].

use std::fmt::Display;

use csv_table::CsvError;
use frames::time::{NS_PER_DAY, NS_PER_S};
use messages::{REFUSAL_MAX, printable};
use reception::RefusedPlace;
use runtime::HealthEntry;

use crate::receiver::ReceiptTime;

/// Reasons that are kept: a health message has room for few more texts.
const REASONS_MAX: usize = 4;
/// Time in which a reason gets no new text, nanoseconds.
const RENEWED_NS: i64 = 200_000_000;
/// Characters of a text.
const TEXT_MAX: usize = 160;
/// Mark between two texts.
const BETWEEN: &str = " | ";

/// Latest refusals, by reason.
#[derive(Clone, Debug, Default)]
pub(crate) struct LatestRefusals {
    /// The latest first.
    kept: Vec<KeptRefusal>,
    /// Lines that were too long so far.
    too_long: u64,
}

#[derive(Clone, Debug)]
struct KeptRefusal {
    /// Kind of the refusal, and the refused column, item or field.
    reason: (&'static str, &'static str),
    mono_ns: i64,
    text: String,
}

impl LatestRefusals {
    /// Takes a refusal for `reason`, of data that came at `received`, in words.
    pub(crate) fn note(&mut self, reason: (&'static str, &'static str), received: ReceiptTime, words: impl Display) {
        let place = self.kept.iter().position(|kept| kept.reason == reason);
        if let Some(kept) = place.and_then(|place| self.kept.get(place))
            && received.mono_ns.saturating_sub(kept.mono_ns) < RENEWED_NS
        {
            return;
        }
        match place {
            Some(place) => drop(self.kept.remove(place)),
            None => self.kept.truncate(REASONS_MAX - 1),
        }
        let text = format!(
            "{}: {}",
            time_of_day(received.utc_ns),
            printable(&words.to_string(), TEXT_MAX)
        );
        let refusal = KeptRefusal {
            reason,
            mono_ns: received.mono_ns,
            text,
        };
        self.kept.insert(0, refusal);
    }

    /// Takes the refusal of a row, or of a whole table. The lines of `error` count on from `lines_before`.
    pub(crate) fn row(&mut self, error: CsvError, lines_before: u64, received: ReceiptTime) {
        let reason = match &error {
            CsvError::Header { column, .. } => ("header", *column),
            CsvError::Length { .. } => ("length", ""),
            CsvError::Quotes { .. } => ("quotes", ""),
            CsvError::Value { column, .. } => ("value", *column),
            _ => ("input", ""),
        };
        self.note(reason, received, error.after_lines(lines_before));
    }

    /// Takes the refusal of a position.
    pub(crate) fn place(&mut self, place: RefusedPlace, received: ReceiptTime) {
        self.note(("position", ""), received, place);
    }

    /// Takes the number of lines so far that did not end in time, counted at `received`.
    pub(crate) fn too_long(&mut self, count: u64, received: impl FnOnce() -> ReceiptTime) {
        if count <= self.too_long {
            return;
        }
        self.too_long = count;
        let received = received();
        self.note(
            ("line", ""),
            received,
            "a line is longer than any can be; end each line with a line feed",
        );
    }

    /// States the refusals in a health message, as far as there is room.
    pub(crate) fn state(&self, health: &mut HealthEntry) {
        let stated = &mut health.refusal;
        for kept in &self.kept {
            if stated.is_empty() {
                stated.push_str(&kept.text);
            } else if stated.len() + BETWEEN.len() + kept.text.len() <= REFUSAL_MAX {
                stated.push_str(BETWEEN);
                stated.push_str(&kept.text);
            }
        }
    }
}

/// Time of the day as in `07:08:09`.
fn time_of_day(utc_ns: i64) -> String {
    let of_day_s = utc_ns.rem_euclid(NS_PER_DAY) / NS_PER_S;
    let (hours, minutes, seconds) = (of_day_s / 3_600, of_day_s / 60 % 60, of_day_s % 60);
    format!("{hours:02}:{minutes:02}:{seconds:02}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(mono_ns: i64) -> ReceiptTime {
        ReceiptTime {
            utc_ns: 25_689_000_000_000,
            mono_ns,
            steady_ns: 0,
        }
    }

    fn stated(refusals: &LatestRefusals) -> String {
        let mut health = HealthEntry::default();
        refusals.state(&mut health);
        health.refusal
    }

    #[test]
    fn each_reason_has_one_text_and_the_latest_comes_first() {
        let mut refusals = LatestRefusals::default();
        assert_eq!(stated(&refusals), "");
        refusals.note(("value", "px"), at(0), "first");
        refusals.note(("value", "py"), at(1), "other");
        refusals.note(("value", "px"), at(RENEWED_NS - 1), "too soon");
        assert_eq!(stated(&refusals), "07:08:09: other | 07:08:09: first");
        refusals.note(("value", "px"), at(RENEWED_NS), "again");
        assert_eq!(stated(&refusals), "07:08:09: again | 07:08:09: other");
        for column in ["a", "b", "c"] {
            refusals.note(("value", column), at(RENEWED_NS), column);
        }
        assert_eq!(
            stated(&refusals),
            "07:08:09: c | 07:08:09: b | 07:08:09: a | 07:08:09: again"
        );
    }
}

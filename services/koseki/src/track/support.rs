//! Reports of a wide-area sensor (FM-6), each given to the tracker when the time of the scans has come to its arrival.

use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::Path;

use formats::csv_table::CsvError;
use formats::wide_area::{WideAreaReader, WideAreaReport};
use tracking::Tracker;

use crate::files::{InputError, open};
use crate::offline::Refusals;

/// Reports in the order of their arrival, and what became of them.
#[derive(Debug, Default)]
pub(super) struct Support {
    reports: Vec<WideAreaReport>,
    given: usize,
    pub(super) refusals: Refusals,
    /// Reports that the tracker refused, by reason.
    pub(super) refused: BTreeMap<String, u64>,
}

impl Support {
    /// Reads a file. Rows that are no reports are left out and counted.
    ///
    /// # Errors
    /// If it cannot be read or lacks a column.
    pub(super) fn read(path: &Path) -> Result<Self, InputError> {
        let mut support = Self::default();
        let reader = WideAreaReader::new(BufReader::new(open(path)?), 0);
        for row in reader.map_err(|error| InputError::new(path, error))? {
            match row {
                Ok(report) => support.reports.push(report),
                Err(error @ (CsvError::Value { .. } | CsvError::Length { .. })) => {
                    support.refusals.unreadable(path, &error);
                }
                Err(error) => return Err(InputError::new(path, error)),
            }
        }
        support
            .reports
            .sort_by_key(|report| (report.arrival_ns, report.time_ns));
        Ok(support)
    }

    /// Gives the tracker what has arrived until `time_ns`.
    pub(super) fn give(&mut self, time_ns: i64, tracker: &mut Tracker) {
        let waiting = &self.reports[self.given..];
        let arrived = waiting.partition_point(|report| report.arrival_ns <= time_ns);
        for report in &waiting[..arrived] {
            if let Err(refusal) = tracker.wide_area(report) {
                *self.refused.entry(refusal.to_string()).or_default() += 1;
            }
        }
        self.given += arrived;
    }

    /// How many reports came after the last scan, and were of no use.
    pub(super) fn left(&self) -> usize {
        self.reports.len() - self.given
    }
}

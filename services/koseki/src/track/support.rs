//! Reports of a wide-area sensor (FM-6), each given to the tracker when the time of the scans has come to its arrival.

use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::Path;

use csv_table::CsvError;
use formats::wide_area_csv::WideAreaReader;
use tracking::Tracker;
use tracking::wide_area::arrivals::Arrivals;

use crate::files::{InputError, open};
use crate::offline::Refusals;

/// Reports in the order of their arrival, and what became of them.
#[derive(Debug)]
pub(super) struct Support {
    arrivals: Arrivals,
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
        let (mut reports, mut refusals) = (Vec::new(), Refusals::default());
        let reader = WideAreaReader::new(BufReader::new(open(path)?), 0);
        for row in reader.map_err(|error| InputError::new(path, error))? {
            match row {
                Ok(report) => reports.push(report),
                Err(error @ (CsvError::Value { .. } | CsvError::Length { .. })) => {
                    refusals.unreadable(path, &error);
                }
                Err(error) => return Err(InputError::new(path, error)),
            }
        }
        Ok(Self {
            arrivals: Arrivals::of(reports),
            refusals,
            refused: BTreeMap::new(),
        })
    }

    /// Gives the tracker what has arrived until `time_ns`.
    pub(super) fn give(&mut self, time_ns: i64, tracker: &mut Tracker) {
        let refused = &mut self.refused;
        self.arrivals.give(time_ns, tracker, |refusal| {
            *refused.entry(refusal.to_string()).or_default() += 1;
        });
    }

    /// How many reports came after the last scan, and were of no use.
    pub(super) fn left(&self) -> usize {
        self.arrivals.waiting()
    }
}

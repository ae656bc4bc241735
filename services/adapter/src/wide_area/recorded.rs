//! A recording of a wide-area sensor, read whole.

use std::io::BufReader;
use std::path::Path;

use anyhow::Context as _;
use deployment::{WideAreaInput, WideAreaSensor};
use formats::containers::RecordedPieces;
use formats::wide_area_csv::WideAreaReader;
use messages::{Counter, Counters, StageTimes, WideArea};
use observations::Sampled;
use sources::Readings;
use tracking::wide_area::WideAreaReport;
use tracking::wide_area::arrivals::order;

use super::RejectedReports;
use super::tracks::OtherSystemTracks;
use crate::replay::Replayed;

/// A recording's reports, in the order of arrival.
#[derive(Debug)]
pub(crate) struct RecordedReports {
    sensor: u16,
    pub(crate) reports: Vec<WideAreaReport>,
    counters: Counters,
    /// Place of the next report that is to be published.
    next: usize,
}

/// Reads the recording of `sensor` in the folder `data`; the first day of the recording begins at `first_day_ns` (UTC,
/// nanoseconds). Unusable rows are skipped and counted.
///
/// # Errors
/// If the recording cannot be read, or lacks a column.
pub(crate) fn read(
    (sensor, readings): (&WideAreaSensor, &Readings),
    data: &Path,
    first_day_ns: i64,
) -> anyhow::Result<RecordedReports> {
    let file = sensor.recording().context("the wide-area sensor has no recording")?;
    let path = data.join(file);
    let mut read = RecordedReports {
        sensor: sensor.number,
        reports: Vec::new(),
        counters: Counters::default(),
        next: 0,
    };
    let done = match &sensor.input {
        WideAreaInput::Tracks(tracks) => super::model(sensor, readings)
            .and_then(|model| read.tracks(OtherSystemTracks::new(tracks, model, first_day_ns), &path)),
        _ => read.rows(&path, first_day_ns),
    };
    done.with_context(|| format!("reading {}", path.display()))?;
    read.reports.sort_by(order);
    Ok(read)
}

impl Replayed for RecordedReports {
    type Sample = WideArea;
    const WAITS_FOR: &'static str = "the recorder";

    fn due_ns(&self, ahead: usize) -> Option<i64> {
        self.reports.get(self.next + ahead).map(|report| report.arrival_ns)
    }

    fn ahead(&self) -> usize {
        self.reports.len() - self.next
    }

    fn next(&mut self) -> Option<(u64, WideArea)> {
        let report = self.reports.get(self.next)?;
        self.next += 1;
        Some((self.next as u64 - 1, report.sample(self.sensor, StageTimes::default())))
    }

    fn skip_to(&mut self, first_needed: u64) {
        self.next = (first_needed as usize).min(self.reports.len());
    }

    fn counters(&self) -> Counters {
        self.counters
    }
}

impl RecordedReports {
    fn rows(&mut self, path: &Path, first_day_ns: i64) -> anyhow::Result<()> {
        let file = std::fs::File::open(path)?;
        let mut rejected = RejectedReports::default();
        for row in WideAreaReader::new(BufReader::new(file), first_day_ns)? {
            self.counters[Counter::Records] += 1;
            match row {
                Ok(report) if rejected.passes(&report) => self.reports.push(report),
                Ok(_) => {}
                Err(error) if error.is_of_row() => {
                    self.counters[Counter::BlocksRejected] += 1;
                }
                Err(error) => return Err(error.into()),
            }
        }
        rejected.count(&mut self.counters);
        Ok(())
    }

    fn tracks(&mut self, mut tracks: OtherSystemTracks, path: &Path) -> anyhow::Result<()> {
        let mut pieces = RecordedPieces::new(std::fs::read(path)?);
        while !pieces.is_exhausted() {
            let (block, length) = pieces.next_block();
            tracks.take(block, length, None, &mut self.reports);
        }
        tracks.end(&mut self.reports);
        tracks.count(&mut self.counters);
        Ok(())
    }
}

//! Which states of tracks become rows: those after each scan, or those at even times (WA-11).

use std::io;
use std::path::Path;
use std::time::Duration;

use formats::tracks_csv::{TrackerTrack, TrackerTrackWriter};
use tracking::wide_area::schedule::Schedule;
use tracking::{TrackReport, Tracker};

use crate::files::OutputFile;

/// Writes rows.
#[derive(Debug)]
pub(super) struct Rows {
    writer: TrackerTrackWriter<OutputFile>,
    schedule: Option<Schedule>,
    /// Tracks of one time.
    reports: Vec<TrackReport>,
    pub(super) written: u64,
}

impl Rows {
    /// Writes the header. With a period, rows come at its whole multiples and not after scans.
    ///
    /// # Errors
    /// If `path` cannot be written.
    pub(super) fn begin(path: &Path, period: Option<Duration>) -> anyhow::Result<Self> {
        Ok(Self {
            writer: TrackerTrackWriter::begin(OutputFile::begin(path)?, 0)?,
            schedule: period.map(|period| Schedule::new(period.as_nanos() as i64)),
            reports: Vec::new(),
            written: 0,
        })
    }

    /// Writes the pictures until `time_ns`, to which no scan that is worked off later belongs.
    ///
    /// # Errors
    /// If the writer fails.
    pub(super) fn pictures(&mut self, time_ns: i64, tracker: &Tracker) -> io::Result<()> {
        while let Some(time_ns) = self.schedule.as_mut().and_then(|schedule| schedule.next(time_ns)) {
            tracker.picture_at(time_ns, &mut self.reports);
            self.write()?;
        }
        Ok(())
    }

    /// Writes the tracks after a scan, in the order of times as an adapter publishes them.
    ///
    /// # Errors
    /// If the writer fails.
    pub(super) fn after_scan(&mut self, tracker: &Tracker) -> io::Result<()> {
        if self.schedule.is_some() {
            return Ok(());
        }
        self.reports.clear();
        self.reports.extend_from_slice(tracker.tracks());
        self.reports.sort_unstable_by_key(TrackReport::order);
        self.write()
    }

    /// Puts the complete file in its place.
    ///
    /// # Errors
    /// If it cannot be written or kept.
    pub(super) fn finish(self) -> anyhow::Result<()> {
        self.writer.into_inner().finish()
    }

    fn write(&mut self) -> io::Result<()> {
        for report in &self.reports {
            self.writer.write(&TrackerTrack {
                track: report.sensor_track(0),
                hypotheses: report.hypotheses,
                reliability: report.reliability,
            })?;
            self.written += 1;
        }
        Ok(())
    }
}

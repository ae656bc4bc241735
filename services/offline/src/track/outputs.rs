//! Outputs of the tracker as tables and figures: the tracks after each scan or at even times (WA-11), and cues for
//! the next look of each sensor (WA-12). docs/wide-area.md explains the columns of cues.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use formats::cues_csv::CueRow;
use formats::rows::{Row, RowWriter};
use formats::tracks_csv::{PlacedTrackerTrack, RepliedTrackerTrack, TrackerTrack};
use frames::SystemFrame;
use messages::{StageTimes, TrackState};
use observations::Sampled as _;
use sources::{SensorScan, TrackSink};
use tracking::wide_area::cue::Cue;
use tracking::wide_area::{EmissionRejection, ReportRejection};
use tracking::{ScanRejection, TrackReport, Tracker};

use super::summary::Tracked;
use super::support::SupportInput;
use crate::host::{Host, TableOutput};

/// Sink of the tracker's outputs.
#[derive(Debug)]
pub(super) struct TrackerSink {
    tracks: TrackTable,
    cues: Option<OutcomeTable<CueRow>>,
    pub(super) tracked: Tracked,
    pub(super) reports: Option<SupportInput>,
    pub(super) emissions: Option<SupportInput>,
    /// Monotonic time of the start of the current scan, nanoseconds.
    begun_ns: i64,
    failed: anyhow::Result<()>,
    /// Time from which the rows' times count, UTC, nanoseconds; 0 if the detections' times count from there already.
    pub(super) first_day_ns: i64,
    /// Whether pictures without a scan since the last picture are marked as coasted, as by a live tracker.
    pub(super) marks_extrapolated: bool,
}

/// Output table.
#[derive(Debug)]
struct OutcomeTable<T> {
    path: PathBuf,
    writer: RowWriter<T, Box<dyn TableOutput>>,
    rows: u64,
}

impl<T: Row> OutcomeTable<T> {
    fn begin(host: &dyn Host, path: &Path) -> anyhow::Result<Self> {
        let writer = RowWriter::begin(host.begin(path)?, 0);
        Ok(Self {
            path: path.to_owned(),
            writer: writer.with_context(|| format!("{} cannot be written", path.display()))?,
            rows: 0,
        })
    }

    fn write(&mut self, row: &T) -> anyhow::Result<()> {
        self.rows += 1;
        let written = self.writer.write(row);
        written.with_context(|| format!("{} cannot be written", self.path.display()))
    }
}

/// Table of tracks: with the columns of replies if any detection has replies, and of places in degrees if the origin of
/// the plane is known, so that other tables stay unchanged.
#[derive(Debug)]
enum TrackTable {
    Plain(OutcomeTable<TrackerTrack>),
    Replied(OutcomeTable<RepliedTrackerTrack>),
    Placed(OutcomeTable<PlacedTrackerTrack>, SystemFrame),
}

impl TrackTable {
    fn begin(host: &dyn Host, path: &Path, (has_replies, frame): (bool, Option<SystemFrame>)) -> anyhow::Result<Self> {
        Ok(match (frame, has_replies) {
            (Some(frame), _) => Self::Placed(OutcomeTable::begin(host, path)?, frame),
            (None, true) => Self::Replied(OutcomeTable::begin(host, path)?),
            (None, false) => Self::Plain(OutcomeTable::begin(host, path)?),
        })
    }

    fn write(&mut self, track: TrackerTrack) -> anyhow::Result<()> {
        match self {
            Self::Plain(table) => table.write(&track),
            Self::Replied(table) => table.write(&RepliedTrackerTrack(track)),
            Self::Placed(table, frame) => {
                let place = frame.to_geodetic(track.track.position_m);
                table.write(&PlacedTrackerTrack(track, place))
            }
        }
    }

    fn rows(&self) -> u64 {
        match self {
            Self::Plain(table) => table.rows,
            Self::Replied(table) => table.rows,
            Self::Placed(table, _) => table.rows,
        }
    }

    fn finish(self) -> anyhow::Result<()> {
        match self {
            Self::Plain(table) => table.writer.into_inner().finish(),
            Self::Replied(table) => table.writer.into_inner().finish(),
            Self::Placed(table, _) => table.writer.into_inner().finish(),
        }
    }
}

impl TrackerSink {
    /// Begins the tables.
    ///
    /// # Errors
    /// If a table cannot be written.
    pub(super) fn begin(
        host: &dyn Host,
        (tracks, has_replies, frame): (&Path, bool, Option<SystemFrame>),
        cues: Option<&Path>,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            tracks: TrackTable::begin(host, tracks, (has_replies, frame))?,
            cues: cues.map(|path| OutcomeTable::begin(host, path)).transpose()?,
            tracked: Tracked::default(),
            reports: None,
            emissions: None,
            begun_ns: 0,
            failed: Ok(()),
            first_day_ns: 0,
            marks_extrapolated: false,
        })
    }

    /// Returns the first failure since the last call.
    ///
    /// # Errors
    /// If a table could not be written.
    pub(super) fn check(&mut self) -> anyhow::Result<()> {
        std::mem::replace(&mut self.failed, Ok(()))
    }

    /// Moves the complete tables to the final places; returns the number of rows of tracks and of cues.
    ///
    /// # Errors
    /// If a table cannot be stored.
    pub(super) fn finish(self) -> anyhow::Result<(u64, Option<u64>)> {
        let rows = (self.tracks.rows(), self.cues.as_ref().map(|cues| cues.rows));
        self.tracks.finish()?;
        self.cues.map_or(Ok(()), |cues| cues.writer.into_inner().finish())?;
        Ok(rows)
    }

    /// Executes `write` unless an earlier write has failed.
    fn attempt(&mut self, write: impl FnOnce(&mut Self) -> anyhow::Result<()>) {
        if self.failed.is_ok() {
            self.failed = write(self);
        }
    }
}

impl TrackSink for TrackerSink {
    fn begins(&mut self) {
        self.begun_ns = runtime::clock::mono_ns();
    }

    fn done(&mut self, scan: &SensorScan<'_>, taken: Result<(), ScanRejection>, tracker: &Tracker) {
        let took_ns = runtime::clock::mono_ns() - self.begun_ns;
        self.tracked.scan(scan, took_ns, taken, tracker);
    }

    fn tracks(&mut self, tracks: &[TrackReport], extrapolated: bool) {
        self.attempt(|written| {
            tracks.iter().try_for_each(|report| {
                let mut track = report.sensor_track(0);
                track.time_of_measurement_ns -= written.first_day_ns;
                if extrapolated && written.marks_extrapolated {
                    track.state = TrackState::Coasted as u8;
                }
                written.tracks.write(TrackerTrack {
                    track,
                    hypotheses: report.hypotheses,
                    reliability: report.reliability,
                })
            })
        });
    }

    fn cues(&mut self, scan_ns: i64, cues: &[Cue]) {
        let first_day_ns = self.first_day_ns;
        let row = |cue: &Cue| {
            let sample = cue.sample(0, StageTimes::default());
            CueRow {
                sensor_id: cue.sensor_id,
                cue: messages::Cue {
                    made_ns: scan_ns - first_day_ns,
                    time_ns: sample.time_ns - first_day_ns,
                    ..sample
                },
            }
        };
        self.attempt(|written| match &mut written.cues {
            Some(table) => cues.iter().try_for_each(|cue| table.write(&row(cue))),
            None => Ok(()),
        });
    }

    fn report_rejected(&mut self, reason: ReportRejection) {
        self.reports.iter_mut().for_each(|support| support.reject(reason));
    }

    fn emission_rejected(&mut self, reason: EmissionRejection) {
        self.emissions.iter_mut().for_each(|support| support.reject(reason));
    }
}

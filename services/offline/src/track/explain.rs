//! Decisions of the tracker and the reasons as a table: a row per record, in chronological order. docs/tracking.md
//! explains the columns.

use std::cell::RefCell;
use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::Path;

use anyhow::Context as _;
use tracking::explanation::{ClusterRecord, CorrectionRecord, Explanation, Observer, TrackEvent, TrackRecord};

use crate::host::{Host, TableOutput};

const COLUMNS: &str = "time_s,sensor_id,cluster,event,hypothesis,track,sensor_track_id,detection_ids,tracks,hypotheses,\
                       considered,forbidden,merged,dropped,probability,value,limit";

/// Table of records.
#[derive(Debug)]
pub(super) struct Explained {
    inner: RefCell<Inner>,
}

#[derive(Debug)]
struct Inner {
    out: Box<dyn TableOutput>,
    time_s: f64,
    sensor_id: u32,
    /// Number of the cluster within the scan, from 1.
    cluster: u32,
    /// Number of the hypothesis within the cluster, from 1; reliability and tracks wait until all hypotheses are known.
    hypothesis: u32,
    waiting: Option<(f64, String)>,
    failed: io::Result<()>,
}

/// Row; columns that do not apply are empty.
#[derive(Default)]
struct ExplanationRow<'a> {
    event: &'a str,
    hypothesis: Option<u32>,
    track: Option<u32>,
    number: Option<u32>,
    detection_ids: &'a str,
    /// Tracks, hypotheses, considered, forbidden, merged, dropped.
    counts: [Option<u64>; 6],
    probability: Option<f64>,
    value: Option<f64>,
    limit: Option<f64>,
}

impl Explained {
    /// Writes the header.
    ///
    /// # Errors
    /// If `path` cannot be written.
    pub(super) fn begin(host: &dyn Host, path: &Path) -> anyhow::Result<Self> {
        let mut out = host.begin(path)?;
        writeln!(out, "{COLUMNS}").with_context(|| format!("{} cannot be written", path.display()))?;
        Ok(Self {
            inner: RefCell::new(Inner {
                out,
                time_s: 0.0,
                sensor_id: 0,
                cluster: 1,
                hypothesis: 0,
                waiting: None,
                failed: Ok(()),
            }),
        })
    }

    /// Moves the complete table to the final place.
    ///
    /// # Errors
    /// If a row could not be written, or the table cannot be stored.
    pub(super) fn finish(self, path: &Path) -> anyhow::Result<()> {
        let mut inner = self.inner.into_inner();
        inner.end_hypothesis();
        inner
            .failed
            .with_context(|| format!("{} cannot be written", path.display()))?;
        inner.out.finish()
    }
}

impl Observer for Explained {
    fn explain(&self, what: &Explanation<'_>) {
        let mut inner = self.inner.borrow_mut();
        if !matches!(what, Explanation::Member(_)) {
            inner.end_hypothesis();
        }
        match what {
            Explanation::Scan {
                sensor_id,
                time_ns,
                detections,
                clutter_density,
            } => inner.scan(*sensor_id, *time_ns, *detections, *clutter_density),
            Explanation::Track {
                event,
                track,
                value,
                limit,
            } => {
                // The fate of a track precedes the record of the cluster.
                inner.next_cluster();
                inner.track(*event, track, *value, *limit);
            }
            Explanation::Correction(correction) => {
                inner.next_cluster();
                inner.correction(correction);
            }
            Explanation::Cluster(cluster) => {
                inner.next_cluster();
                inner.cluster(cluster);
            }
            Explanation::Hypothesis { reliability } => {
                inner.hypothesis += 1;
                inner.waiting = Some((*reliability, String::new()));
            }
            Explanation::Group {
                number,
                members,
                probability,
                limit,
            } => {
                inner.cluster = 0;
                inner.write(&ExplanationRow {
                    event: "group",
                    number: Some(*number),
                    probability: Some(*probability),
                    value: Some(f64::from(*members)),
                    limit: Some(*limit),
                    ..ExplanationRow::default()
                });
            }
            Explanation::Member(track) => {
                if let Some((_, tracks)) = &mut inner.waiting {
                    let joint = if tracks.is_empty() { "" } else { "|" };
                    let _ = write!(tracks, "{joint}{}", track.root);
                    if let Some(id) = track.detection_id {
                        let _ = write!(tracks, "+{id}");
                    }
                }
            }
        }
    }
}

impl Inner {
    fn scan(&mut self, sensor_id: u32, time_ns: i64, detections: usize, clutter_density: f64) {
        self.time_s = frames::time::seconds(time_ns);
        self.sensor_id = sensor_id;
        (self.cluster, self.hypothesis) = (0, 0);
        self.write(&ExplanationRow {
            event: "scan",
            value: Some(detections as f64),
            limit: Some(clutter_density),
            ..ExplanationRow::default()
        });
        self.cluster = 1;
    }

    /// Advances to the next cluster after the hypotheses of a cluster.
    fn next_cluster(&mut self) {
        if self.hypothesis > 0 {
            self.cluster += 1;
            self.hypothesis = 0;
        }
    }

    fn track(&mut self, event: TrackEvent, track: &TrackRecord, value: f64, limit: f64) {
        let id = track.detection_id.map(|id| id.to_string()).unwrap_or_default();
        let number = |value: f64| Some(value).filter(|value| !value.is_nan());
        // A newly started track belongs to no processed cluster.
        let cluster = self.cluster;
        if event == TrackEvent::Started {
            self.cluster = 0;
        }
        self.write(&ExplanationRow {
            event: event.word(),
            track: Some(track.root),
            number: Some(track.number).filter(|_| track.is_confirmed()),
            detection_ids: &id,
            probability: Some(track.reliability),
            value: number(value),
            limit: number(limit),
            ..ExplanationRow::default()
        });
        self.cluster = cluster;
    }

    fn correction(&mut self, correction: &CorrectionRecord) {
        self.write(&ExplanationRow {
            event: if correction.of_children {
                "corrected_children"
            } else {
                "corrected"
            },
            probability: Some(correction.after),
            value: Some(correction.before),
            limit: Some(correction.targets).filter(|targets| targets.is_finite()),
            ..ExplanationRow::default()
        });
    }

    fn cluster(&mut self, cluster: &ClusterRecord<'_>) {
        let mut ids = String::new();
        for id in cluster.detection_ids() {
            let joint = if ids.is_empty() { "" } else { "|" };
            let _ = write!(ids, "{joint}{id}");
        }
        self.write(&ExplanationRow {
            event: "cluster",
            detection_ids: &ids,
            counts: [
                cluster.tracks as u64,
                cluster.hypotheses as u64,
                cluster.considered,
                cluster.forbidden,
                cluster.merged,
                cluster.dropped,
            ]
            .map(Some),
            probability: Some(cluster.dropped_probability),
            ..ExplanationRow::default()
        });
    }

    fn end_hypothesis(&mut self) {
        if let Some((reliability, tracks)) = self.waiting.take() {
            self.write(&ExplanationRow {
                event: "hypothesis",
                hypothesis: Some(self.hypothesis),
                detection_ids: &tracks,
                probability: Some(reliability),
                ..ExplanationRow::default()
            });
        }
    }

    fn write(&mut self, row: &ExplanationRow<'_>) {
        let cluster = Some(self.cluster).filter(|cluster| *cluster > 0);
        let of_track = [row.hypothesis, row.track, row.number].map(shown);
        let counts = row.counts.map(shown);
        let [probability, value, limit] = [row.probability, row.value, row.limit].map(figure);
        let written = writeln!(
            self.out,
            "{:.3},{},{},{},{},{},{},{probability},{value},{limit}",
            self.time_s,
            self.sensor_id,
            shown(cluster),
            row.event,
            of_track.join(","),
            row.detection_ids,
            counts.join(","),
        );
        if self.failed.is_ok() {
            self.failed = written;
        }
    }
}

fn shown<T: ToString>(value: Option<T>) -> String {
    value.map(|value| value.to_string()).unwrap_or_default()
}

fn figure(value: Option<f64>) -> String {
    match value {
        Some(value) if value == 0.0 || (1e-3..1e7).contains(&value.abs()) => format!("{value:.6}"),
        Some(value) => format!("{value:.3e}"),
        None => String::new(),
    }
}

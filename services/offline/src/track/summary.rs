//! Summary of inputs and results, as text or as JSON.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use serde_json::{Value, json};
use sources::SensorScan;
use tracking::{ScanRejection, Tracker, TrackerCounts};

use crate::files::output_name;
use crate::host::Host;

use super::input::DetectionInput;
use super::on_board::OnBoard;
use super::support::SupportInput;

/// Advice for a result without confirmed tracks.
const NONE_CONFIRMED: &str = "no track was confirmed: where a sensor shows one target and nothing else, its learned density of \
                              false detections is too high; give clutter_density or field_of_view in --config";
/// Nanoseconds in a millisecond.
const NS_PER_MS: f64 = 1e6;

/// Sums over the scans.
#[derive(Debug, Default)]
pub(super) struct Tracked {
    by_sensor: BTreeMap<u32, OfSensor>,
    refused_scans: BTreeMap<String, u64>,
    /// Processing time of each scan, nanoseconds.
    times_ns: Vec<i64>,
    /// Detections of confirmed tracks.
    in_tracks: u64,
    /// Maximum number of tracks, branches included.
    branches_max: usize,
    /// Detections in rejected scans.
    pub(super) refused_detections: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct OfSensor {
    scans: u64,
    silent_scans: u64,
    detections: u64,
}

impl Tracked {
    /// Adds a scan with the processing time.
    pub(super) fn scan(
        &mut self,
        scan: &SensorScan<'_>,
        took_ns: i64,
        taken: Result<(), ScanRejection>,
        tracker: &Tracker,
    ) {
        self.times_ns.push(took_ns);
        let of_sensor = self.by_sensor.entry(scan.sensor_id).or_default();
        of_sensor.scans += 1;
        of_sensor.silent_scans += u64::from(scan.detections.is_empty());
        of_sensor.detections += scan.detections.len() as u64;
        match taken {
            Ok(()) => {
                self.in_tracks += tracker.tracks().iter().filter(|track| track.missed == 0).count() as u64;
                self.branches_max = self.branches_max.max(tracker.branches());
            }
            Err(refusal) => {
                *self.refused_scans.entry(refusal.to_string()).or_default() += 1;
                self.refused_detections += scan.detections.len() as u64;
            }
        }
    }
}

/// Contents of the final summary.
pub(super) struct TrackSummary<'a> {
    pub(super) out: &'a Path,
    /// Rows written.
    pub(super) rows: u64,
    /// Cues written, if requested.
    pub(super) cues: Option<u64>,
    pub(super) input: &'a DetectionInput,
    pub(super) support: Option<SupportInput>,
    pub(super) emissions: Option<SupportInput>,
    /// Detections carried into the system's terms, with `--platform`.
    pub(super) carried: Option<OnBoard>,
    pub(super) tracker: &'a Tracker,
    pub(super) tracked: Tracked,
}

impl TrackSummary<'_> {
    /// Shows the summary: as JSON on standard output, else as text on standard error.
    ///
    /// # Errors
    /// If standard output fails.
    pub(super) fn show(mut self, host: &dyn Host, json: bool) -> anyhow::Result<()> {
        self.tracked.times_ns.sort_unstable();
        host.show(json.then(|| self.as_json()), || {
            let mut text = String::new();
            let _ = self.write_text(&mut text); // writing to a string cannot fail
            text
        })
    }

    fn as_json(&self) -> Value {
        let (counts, tracked) = (self.tracker.counts(), &self.tracked);
        let refused: BTreeMap<&str, u64> = refused(counts).map(|(word, _, count)| (word, count)).into();
        let sensors = tracked.by_sensor.iter().map(|(id, sensor)| {
            json!({
                "sensor_id": id,
                "scans": sensor.scans,
                "silent_scans": sensor.silent_scans,
                "detections": sensor.detections,
            })
        });
        json!({
            "out": self.out.display().to_string(),
            "rows": self.rows,
            "cues": self.cues,
            "scans": tracked.times_ns.len(),
            "detections": counts.detections,
            "rows_refused": self.input.refusals.rows(),
            "refused": self.input.refusals.by_reason,
            "first_refused": self.input.refusals.first,
            "assumed": self.input.plane.assumed.iter().collect::<Vec<_>>(),
            "refused_scans": tracked.refused_scans,
            "refused_by_tracker": refused,
            "sensors": sensors.collect::<Vec<_>>(),
            "tracks": counts.confirmed,
            "live_tracks": self.tracker.tracks().len(),
            "false_share": self.false_share(),
            "branches_max": tracked.branches_max,
            "wide_area": self.support.as_ref().map(|support| json!({
                "rows_refused": support.refusals.rows(),
                "refused": support.rejected,
                "after_last_scan": support.left,
                "reports": counts.wide_area_reports,
                "used": counts.wide_area_reports_used,
                "unmatched": counts.wide_area_reports_unmatched,
                "corrections": counts.wide_area_corrections,
                "confirmations": counts.wide_area_confirmations,
                "deletions": counts.wide_area_deletions,
            })),
            "emissions": self.emissions.as_ref().map(|emissions| json!({
                "rows_refused": emissions.refusals.rows(),
                "refused": emissions.rejected,
                "after_last_scan": emissions.left,
                "taken": counts.emissions,
                "used": counts.emissions_used,
                "unclear": counts.emissions_unclear,
            })),
            "platform": self.carried.as_ref().map(OnBoard::as_json),
            "dropped_probability_max": counts.dropped_probability_max,
            "dropped_probability_mean": counts.dropped_probability_mean(),
            "scan_median_ms": self.time_ms(0.5),
            "scan_max_ms": self.time_ms(1.0),
        })
    }

    fn write_text(&self, text: &mut String) -> std::fmt::Result {
        let (counts, tracked) = (self.tracker.counts(), &self.tracked);
        for (id, sensor) in &tracked.by_sensor {
            let OfSensor {
                scans,
                silent_scans,
                detections,
            } = sensor;
            writeln!(
                text,
                "sensor {id:<6} {detections:>9} detections in {scans} scans, {silent_scans} of them silent"
            )?;
        }
        text.push_str(&self.input.refusals.as_text());
        text.push_str(&self.input.plane.as_text());
        if let Some(carried) = &self.carried {
            carried.write_text(text)?;
        }
        for (refusal, scans) in &tracked.refused_scans {
            writeln!(text, "refused: {scans} scans: {refusal}")?;
        }
        if let Some(support) = &self.support {
            text.push_str(&support.refusals.as_text());
            for (refusal, reports) in &support.rejected {
                writeln!(text, "refused: {reports} wide-area reports: {refusal}")?;
            }
            writeln!(
                text,
                "wide area: {} reports, {} used, {} of them near no track; {} clusters corrected, {} tracks confirmed \
                 earlier, {} given up earlier",
                counts.wide_area_reports,
                counts.wide_area_reports_used,
                counts.wide_area_reports_unmatched,
                counts.wide_area_corrections,
                counts.wide_area_confirmations,
                counts.wide_area_deletions
            )?;
            if support.left > 0 {
                writeln!(
                    text,
                    "wide area: {} reports came after the last scan: of no use",
                    support.left
                )?;
            }
        }
        if let Some(emissions) = &self.emissions {
            text.push_str(&emissions.refusals.as_text());
            for (refusal, count) in &emissions.rejected {
                writeln!(text, "refused: {count} emissions: {refusal}")?;
            }
            writeln!(
                text,
                "emissions: {}, {} used, {} of them not clearly of one track",
                counts.emissions, counts.emissions_used, counts.emissions_unclear
            )?;
        }
        for (_, sentence, count) in refused(counts).iter().filter(|(_, _, count)| *count > 0) {
            writeln!(text, "refused: {count} {sentence}")?;
        }
        writeln!(
            text,
            "tracks: {} confirmed, {} live at the end; {:.1} % of the detections are in none",
            counts.confirmed,
            self.tracker.tracks().len(),
            100.0 * self.false_share()
        )?;
        writeln!(
            text,
            "hypotheses: no more than {:.2} % of a cluster's probability dropped per scan, on average; at most {} tracks with \
             branches",
            100.0 * counts.dropped_probability_mean(),
            tracked.branches_max
        )?;
        if counts.confirmed == 0 {
            writeln!(text, "{NONE_CONFIRMED}")?;
        }
        writeln!(
            text,
            "time per scan: median {:.3} ms, worst {:.3} ms",
            self.time_ms(0.5),
            self.time_ms(1.0)
        )?;
        if let Some(cues) = self.cues {
            writeln!(text, "cues: {cues}")?;
        }
        writeln!(text, "{}: {} rows", output_name(self.out), self.rows)
    }

    /// Returns the share of detections outside confirmed tracks.
    fn false_share(&self) -> f64 {
        let detections = self.tracker.counts().detections.max(1);
        1.0 - self.tracked.in_tracks as f64 / detections as f64
    }

    /// Returns the quantile `share` of the processing times, milliseconds.
    fn time_ms(&self, share: f64) -> f64 {
        let times_ns = &self.tracked.times_ns;
        let place = (share * times_ns.len().saturating_sub(1) as f64).round() as usize;
        times_ns.get(place).map_or(0.0, |time_ns| *time_ns as f64 / NS_PER_MS)
    }
}

/// Returns counts of rejections and drops by reason: word, description, number.
fn refused(counts: &TrackerCounts) -> [(&'static str, &'static str, u64); 10] {
    [
        (
            "unusable_detections",
            "detections without usable values or standard deviations, or more than a minute from their scan",
            counts.rejected_detections,
        ),
        (
            "crowded_out_detections",
            "detections for which a scan had no room; raise capacity.detections",
            counts.dropped_detections,
        ),
        (
            "deselected_detections",
            "detections by age or accuracy (selection), or used with kept_weight",
            counts.deselected_detections,
        ),
        (
            "outranked_scans",
            "scans beside one of a sensor of higher priority (selection), or used with kept_weight",
            counts.outranked_scans,
        ),
        (
            "unmade_comparisons",
            "comparisons of a track with detections beyond its share",
            counts.dropped_comparisons,
        ),
        (
            "dropped_pairs",
            "detections in a track's gate because others fitted better or its cluster was full",
            counts.dropped_pairs,
        ),
        (
            "refused_tracks",
            "tracks for want of room; raise capacity.tracks",
            counts.dropped_tracks,
        ),
        (
            "refused_hypotheses",
            "hypotheses for want of room",
            counts.hypotheses_dropped,
        ),
        (
            "dropped_crossings",
            "crossings of directions, and directions, because there were too many to tell targets from ghosts",
            counts.crossings_dropped,
        ),
        (
            "designations_followed",
            "designations of targets that were followed already",
            counts.designations_followed,
        ),
    ]
}

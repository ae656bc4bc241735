//! Summary of a smoothing, as text or as JSON.

use std::fmt::Write as _;
use std::path::Path;

use fusion::smoothing::SmoothedTracks;
use messages::{SystemTrack, TrackState};
use serde_json::{Value, json};

use crate::files::output_name;

/// Sums over the written rows.
#[derive(Clone, Copy, Debug, Default)]
pub struct SmoothTotals {
    /// Number of measurements.
    measurements: u64,
    /// Rows written.
    rows: u64,
    /// Number of these without measurements, which stay as fused.
    unmeasured: u64,
    /// Records of CAT062.
    pub records: Option<u64>,
    /// Sums of variances per axis in the plane over the confirmed rows with measurements: as fused, and smoothed, of
    /// position (m²) and velocity (m²/s²).
    fused: [f64; 2],
    smoothed: [f64; 2],
    confirmed: u64,
}

impl SmoothTotals {
    /// Creates empty sums; the number of measurements is known.
    pub fn new(measurements: u64) -> Self {
        Self {
            measurements,
            ..Self::default()
        }
    }

    /// Adds a row; returns the state that is written.
    pub fn take(&mut self, live: &SystemTrack, tracks: &SmoothedTracks) -> SystemTrack {
        self.rows += 1;
        let Some(state) = tracks.of(live) else {
            self.unmeasured += 1;
            return *live;
        };
        if live.state == TrackState::Confirmed as u8 {
            let variances = |state: &SystemTrack| {
                let per_axis =
                    |axis: usize| 0.5 * (state.covariance.get(axis, axis) + state.covariance.get(axis + 1, axis + 1));
                [per_axis(0), per_axis(3)]
            };
            self.confirmed += 1;
            for (sum, variance) in self.fused.iter_mut().zip(variances(live)) {
                *sum += variance;
            }
            for (sum, variance) in self.smoothed.iter_mut().zip(variances(&state)) {
                *sum += variance;
            }
        }
        state
    }

    /// Root mean squares of the expected errors per axis of position (m) and velocity (m/s).
    fn sigmas(&self, sums: [f64; 2]) -> Option<[f64; 2]> {
        (self.confirmed > 0).then(|| sums.map(|sum| (sum / self.confirmed as f64).sqrt()))
    }

    /// The summary as JSON; `out` and `asterix` are the written files.
    pub fn as_json(&self, out: &Path, asterix: Option<&Path>) -> Value {
        let sigmas = |sums: [f64; 2]| match self.sigmas(sums) {
            Some([position_m, velocity_mps]) => json!({ "position_m": position_m, "velocity_mps": velocity_mps }),
            None => Value::Null,
        };
        json!({
            "out": out.display().to_string(),
            "asterix": asterix.map(|path| path.display().to_string()),
            "rows": self.rows,
            "rows_unmeasured": self.unmeasured,
            "records": self.records,
            "measurements": self.measurements,
            "sigma": { "fused": sigmas(self.fused), "smoothed": sigmas(self.smoothed) },
        })
    }

    /// The summary as text; `out` and `asterix` are the written files.
    pub fn as_text(&self, out: &Path, asterix: Option<&Path>) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write_text(&mut text, out, asterix);
        text
    }

    fn write_text(&self, text: &mut String, out: &Path, asterix: Option<&Path>) -> std::fmt::Result {
        if let (Some([position, velocity]), Some([smooth_position, smooth_velocity])) =
            (self.sigmas(self.fused), self.sigmas(self.smoothed))
        {
            writeln!(
                text,
                "expected error of confirmed tracks per axis: {position:.1} m and {velocity:.2} m/s as fused, \
                 {smooth_position:.1} m and {smooth_velocity:.2} m/s smoothed"
            )?;
        }
        if self.unmeasured > 0 {
            writeln!(
                text,
                "{} rows without measurements of their own stay as fused",
                self.unmeasured
            )?;
        }
        if let (Some(path), Some(records)) = (asterix, self.records) {
            writeln!(text, "{}: {records} records", output_name(path))?;
        }
        writeln!(
            text,
            "{}: {} rows from {} measurements",
            output_name(out),
            self.rows,
            self.measurements
        )
    }
}

//! Where each sensor should look next, as a table (WA-12): after each scan a row for each confirmed track and each sensor of
//! which it is known how often it looks. What the columns mean stands in docs/wide-area.md.

use std::io::{self, Write as _};
use std::path::Path;

use anyhow::Context as _;
use csv_table::write_time;
use observations::Detection;
use tracking::scans::ScanOfDetections;
use tracking::settings::SensorSettings;
use tracking::wide_area::cue::{Cue, Looks, sigma_m};
use tracking::{Settings, Tracker};

use crate::files::OutputFile;

const COLUMNS: &str = "made_s,time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,longer_m,shorter_m,orientation_rad";

/// A table of cues.
#[derive(Debug)]
pub(super) struct Cues {
    out: OutputFile,
    looks: Looks,
    /// Each with the standard deviation of its detections when it last had any, metres; 0 before that.
    sensors: Vec<(SensorSettings, f64)>,
    cues: Vec<Cue>,
    pub(super) written: u64,
}

impl Cues {
    /// Writes the header.
    ///
    /// # Errors
    /// If `path` cannot be written.
    pub(super) fn begin(path: &Path, settings: &Settings) -> anyhow::Result<Self> {
        let mut out = OutputFile::begin(path)?;
        writeln!(out, "{COLUMNS}").with_context(|| format!("{} cannot be written", path.display()))?;
        Ok(Self {
            out,
            looks: Looks::of(settings.sensors.iter().map(|sensor| sensor.sensor_id)),
            sensors: settings.sensors.iter().map(|sensor| (sensor.clone(), 0.0)).collect(),
            cues: Vec::new(),
            written: 0,
        })
    }

    /// Writes where the sensors should look after a scan that has been worked off.
    ///
    /// # Errors
    /// If the writer fails.
    pub(super) fn after_scan(
        &mut self,
        scan: &ScanOfDetections,
        detections: &[Detection],
        tracker: &Tracker,
    ) -> io::Result<()> {
        let of_scan = |(sensor, _): &&mut (SensorSettings, f64)| sensor.sensor_id == scan.sensor_id;
        if let Some((sensor, last_m)) = self.sensors.iter_mut().find(of_scan) {
            *last_m = sigma_m(detections, sensor.sigmas).unwrap_or(*last_m);
        }
        self.looks.saw(scan.sensor_id, scan.time_ns);
        for (sensor_id, time_ns) in self.looks.next() {
            let own = self.sensors.iter().find(|(sensor, _)| sensor.sensor_id == sensor_id);
            let sigma_m = own.map_or(0.0, |(_, sigma_m)| *sigma_m);
            tracker.cues_at((sensor_id, time_ns), sigma_m, &mut self.cues);
            for cue in &self.cues {
                write_cue(&mut self.out, scan.time_ns, cue)?;
                self.written += 1;
            }
        }
        Ok(())
    }

    /// Puts the complete file in its place.
    ///
    /// # Errors
    /// If it cannot be kept.
    pub(super) fn finish(self) -> anyhow::Result<()> {
        self.out.finish()
    }
}

fn write_cue(out: &mut OutputFile, made_ns: i64, cue: &Cue) -> io::Result<()> {
    write_time(out, made_ns)?;
    write!(out, ",")?;
    write_time(out, cue.time_ns)?;
    write!(out, ",{},{}", cue.sensor_id, cue.track_number)?;
    for value in cue.position_m.iter().chain(&cue.velocity_mps).chain(&cue.half_axes_m) {
        write!(out, ",{value:.3}")?;
    }
    writeln!(out, ",{:.6}", cue.orientation_rad)
}

//! Output files of a measurement.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::PathBuf;

use anyhow::Context as _;
use hdrhistogram::Histogram;
use telemetry::write_percentiles;

use crate::distributions::Distributions;
use crate::picture;
use crate::recorder::STAGES;
use crate::report::BenchReport;
use crate::settings::MeasurementRefusal;

/// Requested output files.
#[derive(Clone, Debug, Default)]
pub struct OutputFiles {
    /// All figures as JSON (FM-4).
    pub json: Option<PathBuf>,
    /// Latency against percentile, as SVG.
    pub picture: Option<PathBuf>,
    /// Folder for distributions in the percentile format of HdrHistogram, microseconds.
    pub percentiles: Option<PathBuf>,
}

impl OutputFiles {
    /// Checks that the files can be written, before minutes are spent.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub(crate) fn check(&self) -> Result<(), MeasurementRefusal> {
        for (option, path) in [("--json", &self.json), ("--picture", &self.picture)] {
            let Some(path) = path else { continue };
            let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
            if parent.is_some_and(|parent| !parent.is_dir()) || path.is_dir() {
                return Err(MeasurementRefusal(format!(
                    "{option} {}: it cannot be written there; name a file in a folder that exists",
                    path.display()
                )));
            }
        }
        let made = self
            .percentiles
            .as_ref()
            .map(|folder| (folder, fs::create_dir_all(folder)));
        match made {
            Some((folder, Err(error))) => Err(MeasurementRefusal(format!(
                "--percentiles {}: the folder cannot be made: {error}",
                folder.display()
            ))),
            _ => Ok(()),
        }
    }

    pub(crate) fn write(
        &self,
        report: &BenchReport,
        points: &[Distributions],
        engine: Option<&Histogram<u64>>,
    ) -> anyhow::Result<()> {
        if let Some(path) = &self.json {
            report.write(path)?;
        }
        if let (Some(path), Some(first)) = (&self.picture, points.first()) {
            picture::write(path, first)?;
        }
        let Some(folder) = &self.percentiles else {
            return Ok(());
        };
        let write = |name: String, histogram: &Histogram<u64>| {
            let path = folder.join(name + ".hgrm");
            let file = File::create(&path).with_context(|| format!("writing {}", path.display()))?;
            write_percentiles(BufWriter::new(file), histogram, 1000.0)
                .with_context(|| format!("writing {}", path.display()))
        };
        for point in points {
            let rate = point.rate_per_s.round();
            write(format!("floor-{rate}"), &point.floor)?;
            write(format!("pipeline-{rate}"), &point.pipeline)?;
            write(format!("jitter-lateness-{rate}"), &point.jitter.lateness)?;
            write(format!("jitter-gaps-{rate}"), &point.jitter.gaps)?;
            for (stage, histogram) in STAGES.iter().zip(&point.stages) {
                write(format!("stage-{}-{rate}", stage.key()), histogram)?;
            }
        }
        engine.map_or(Ok(()), |engine| write("engine".to_owned(), engine))
    }
}

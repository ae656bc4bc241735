//! Files of the monitor, in a single folder:
//!
//! - `latency.hlog`: every interval's latencies, per stage and source, in the standard HdrHistogram log format;
//! - `latency_<stage>.hgrm` and `latency_<stage>_<source>.hgrm`: at the end, the distribution of each stage, of all
//!   sources together and of each source with reports, in microseconds, for HdrHistogram's plotter;
//! - `report.json`: at the end, the report; a counter that is absent is 0.
//!
//! After a failed write (a full disk) the log ends; the monitor continues and reports the error at the end.

use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use telemetry::{Histogram, IntervalLog, Span, Stage, Stages, write_percentiles};

use crate::report::Report;

/// Nanoseconds in the unit of the percentile files.
const NS_PER_US: f64 = 1e3;

/// Files of a report.
pub(crate) struct Files {
    folder: PathBuf,
    log: Result<IntervalLog<BufWriter<File>>, anyhow::Error>,
}

impl Files {
    /// Creates the folder and begins the log; the log's times count from `begun_utc_ns`.
    ///
    /// # Errors
    /// If the folder or the log cannot be created.
    pub(crate) fn create(folder: &Path, begun_utc_ns: i64) -> anyhow::Result<Self> {
        fs::create_dir_all(folder).with_context(|| format!("making the folder {}", folder.display()))?;
        let path = folder.join("latency.hlog");
        let file = File::create(&path).with_context(|| format!("creating {}", path.display()))?;
        let log = IntervalLog::begin(BufWriter::new(file), begun_utc_ns)
            .with_context(|| format!("writing {}", path.display()))?;
        Ok(Self {
            folder: folder.to_owned(),
            log: Ok(log),
        })
    }

    /// Logs the latest closed interval of a source, or of all together (`None`). The lines are flushed at once: the
    /// process may be killed.
    pub(crate) fn log_interval<N: AsRef<str>>(
        &mut self,
        stages: &Stages,
        source: Option<u16>,
        begin_utc_ns: i64,
        length_ns: i64,
        source_name: impl Fn(u16) -> N,
    ) {
        let Ok(log) = &mut self.log else { return };
        let written = log
            .write_part(stages, source, begin_utc_ns, length_ns.max(0) as u64, source_name)
            .and_then(|()| log.flush());
        if let Err(error) = written {
            self.log = Err(anyhow::Error::new(error).context("writing latency.hlog"));
        }
    }

    /// Returns the fault in a few words; empty without a fault.
    pub(crate) fn note(&self) -> String {
        let error = self.log.as_ref().err();
        error.map_or_else(String::new, |error| format!("{error:#}"))
    }

    /// Writes the files of the end.
    ///
    /// # Errors
    /// If a file cannot be written, or the log has failed before.
    pub(crate) fn finish<N: AsRef<str>>(
        self,
        stages: &Stages,
        report: &Report,
        source_name: impl Fn(u16) -> N,
    ) -> anyhow::Result<()> {
        for stage in Stage::ALL {
            let key = stage.key();
            if let Some(histogram) = stages.histogram(stage, None, Span::Total) {
                self.write_distribution(&format!("latency_{key}.hgrm"), histogram)?;
            }
            for source in stages.sources() {
                let histogram = stages.histogram(stage, Some(source), Span::Total);
                if let Some(histogram) = histogram.filter(|histogram| !histogram.is_empty()) {
                    let name = source_name(source);
                    self.write_distribution(&format!("latency_{key}_{}.hgrm", name.as_ref()), histogram)?;
                }
            }
        }
        self.write("report.json", |out| {
            serde_json::to_writer_pretty(&mut *out, report)?;
            writeln!(out)
        })?;
        self.log.map(drop)
    }

    fn write_distribution(&self, name: &str, histogram: &Histogram) -> anyhow::Result<()> {
        self.write(name, |out| write_percentiles(out, histogram, NS_PER_US))
    }

    fn write(&self, name: &str, fill: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>) -> anyhow::Result<()> {
        let path = self.folder.join(name);
        let write = || {
            let mut out = BufWriter::new(File::create(&path)?);
            fill(&mut out)?;
            out.flush()
        };
        write().with_context(|| format!("writing {}", path.display()))
    }
}

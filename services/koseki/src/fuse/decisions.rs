//! Decisions of the engine as a table (BF-4): a row per decision, in the order in which they were made.

use std::io::{self, Write as _};
use std::path::Path;

use anyhow::Context as _;
use fusion::Decision;
use messages::NO_SOURCE;

use crate::files::OutputFile;

/// A table of decisions.
#[derive(Debug)]
pub(super) struct Decisions<'a> {
    out: OutputFile,
    sensor_ids: &'a [u32],
}

impl<'a> Decisions<'a> {
    /// Writes the header. Source n is shown as `sensor_ids[n]`.
    ///
    /// # Errors
    /// If `path` cannot be written.
    pub(super) fn begin(path: &Path, sensor_ids: &'a [u32]) -> anyhow::Result<Self> {
        let mut out = OutputFile::begin(path)?;
        let columns = "time_s,decision,system_track_id,other_system_track_id,sensor_id,other_sensor_id,sensor_track_id,\
                       value,limit";
        writeln!(out, "{columns}").with_context(|| format!("{} cannot be written", path.display()))?;
        Ok(Self { out, sensor_ids })
    }

    /// Writes a row; what a decision does not speak of is empty.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(super) fn write(&mut self, decision: &Decision) -> io::Result<()> {
        let number = |number: u32| if number == 0 { String::new() } else { number.to_string() };
        let sensor = |source: u16| match self.sensor_ids.get(usize::from(source)) {
            Some(id) if source != NO_SOURCE => id.to_string(),
            _ => String::new(),
        };
        let figure = |value: f64| match value.is_nan() {
            true => String::new(),
            false => format!("{value:.4}"),
        };
        writeln!(
            self.out,
            "{:.3},{},{},{},{},{},{},{},{}",
            frames::time::seconds(decision.time_ns),
            decision.kind.word(),
            number(decision.system_track),
            number(decision.other_system_track),
            sensor(decision.source),
            sensor(decision.other_source),
            number(decision.sensor_track),
            figure(decision.value),
            figure(decision.limit),
        )
    }

    /// Puts the complete table in its place.
    ///
    /// # Errors
    /// If it cannot be kept.
    pub(super) fn finish(self) -> anyhow::Result<()> {
        self.out.finish()
    }
}

//! Decisions of the locator as a table: a row per decision, in chronological order.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use locating::Decision;

use crate::host::{Host, TableOutput};
use crate::locate_columns::DECISION_COLUMNS;

/// Table of decisions.
#[derive(Debug)]
pub(super) struct Decisions {
    path: PathBuf,
    out: Box<dyn TableOutput>,
}

impl Decisions {
    /// Writes the header.
    ///
    /// # Errors
    /// If `path` cannot be written.
    pub(super) fn begin(host: &dyn Host, path: &Path) -> anyhow::Result<Self> {
        let mut table = Self {
            path: path.to_owned(),
            out: host.begin(path)?,
        };
        writeln!(table.out, "{DECISION_COLUMNS}").with_context(|| table.unwritten())?;
        Ok(table)
    }

    /// Writes rows; columns that do not apply to a decision are empty.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(super) fn write(&mut self, decisions: &[Decision]) -> anyhow::Result<()> {
        let figure = |value: f64| match value.is_finite() {
            true => format!("{value:.3}"),
            false => String::new(),
        };
        for decision in decisions {
            writeln!(
                self.out,
                "{:.3},{},{},{},{},{},{}",
                frames::time::seconds(decision.time_ns),
                decision.emitter,
                decision.kind.word(),
                decision.kind.subject(),
                decision.kind.reason(),
                figure(decision.value),
                figure(decision.limit),
            )
            .with_context(|| format!("{} cannot be written", self.path.display()))?;
        }
        Ok(())
    }

    /// Moves the complete table to the final place.
    ///
    /// # Errors
    /// If the table cannot be stored.
    pub(super) fn finish(self) -> anyhow::Result<()> {
        self.out.finish()
    }

    fn unwritten(&self) -> String {
        format!("{} cannot be written", self.path.display())
    }
}

//! Alerts on the fused targets, by the rules of the configuration.

use std::io::{self, Write};
use std::path::Path;

use alerts::{AlertEngine, named_areas};
use anyhow::Context as _;
use areas::Ground;
use formats::alerts_csv::AlertRow;
use formats::rows::RowWriter;
use messages::{AlarmEvent, Alert, SystemTrack};

use crate::files::Usage;
use crate::host::Host;
use crate::reading::Setup;

/// Table of alerts.
pub(crate) struct AlertTable<W: Write> {
    engine: AlertEngine,
    writer: RowWriter<AlertRow, W>,
    changed: Vec<Alert>,
    raised: u64,
}

impl<W: Write> AlertTable<W> {
    /// Begins the table by the rules of the deployment of `setup`, whose files of areas `host` opens.
    ///
    /// # Errors
    /// If there are no rules, an area cannot be used, or the table cannot be written.
    pub(crate) fn begin(writer: W, setup: &Setup<'_>, host: &dyn Host) -> anyhow::Result<Self> {
        let rules = setup.alerts.as_ref().filter(|alerts| !alerts.rules.is_empty());
        let (Some(alerts), Some(deployment)) = (rules, &setup.deployment) else {
            let what = "--alerts: there are no rules; give a deployment with [[alert]] tables by --config";
            return Err(Usage(what.to_owned()).into());
        };
        let read = |file: &str| {
            host.text(Path::new(file))
                .map_err(|error| io::Error::other(error.to_string()))
        };
        let areas = named_areas(&alerts.areas, &Ground::of(deployment.frame), &read);
        let areas = areas.map_err(|refusal| Usage(format!("{}: {refusal}", deployment.path.display())))?;
        Ok(Self {
            engine: AlertEngine::new(&alerts.rules, areas, deployment.frame, deployment.system_tracks.max),
            writer: RowWriter::begin(writer, 0).context("the table of alerts cannot be written")?,
            changed: Vec::new(),
            raised: 0,
        })
    }

    /// Takes a state.
    ///
    /// # Errors
    /// If the table cannot be written.
    pub(crate) fn state(&mut self, state: &SystemTrack) -> io::Result<()> {
        self.engine.take(state, &mut self.changed);
        for alert in self.changed.drain(..) {
            self.raised += u64::from(alert.event() == Some(AlarmEvent::Raised));
            if let Some(row) = AlertRow::of(&alert) {
                self.writer.write(&row)?;
            }
        }
        Ok(())
    }

    /// Ends the table; returns the output and the number of raised alerts.
    pub(crate) fn finish(self) -> (W, u64) {
        (self.writer.into_inner(), self.raised)
    }
}

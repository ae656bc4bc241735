//! The states of some seconds ago, as published by a deployment on `system/smoothed`.

use std::io::{self, Write};
use std::path::Path;
use std::time::Duration;

use anyhow::Context as _;
use fusion::FilterInput;
use fusion::smoothing::LagSmoother;
use messages::SystemTrack;

use super::nanoseconds;
use super::rows::StateSink;
use crate::host::{Host, TableOutput};
use crate::reading::Setup;

/// Age of the states without another value, nanoseconds.
const USUAL_LAG_NS: i64 = 10_000_000_000;

/// Writer of the states.
pub(super) struct LaggingRows<W: Write> {
    smoother: LagSmoother,
    rows: StateSink<W>,
    /// States that have left the smoother.
    smoothed: Vec<SystemTrack>,
}

impl LaggingRows<Box<dyn TableOutput>> {
    /// Begins the file.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub(super) fn begin(
        path: &Path,
        lag: Option<Duration>,
        setup: &Setup<'_>,
        host: &dyn Host,
    ) -> anyhow::Result<Self> {
        let of_settings = || setup.settings.smoothing_lag_ns().unwrap_or(USUAL_LAG_NS);
        let unwritten = || format!("{} cannot be made", path.display());
        let rows = StateSink::begin(host.begin(path)?, setup);
        Ok(Self {
            smoother: LagSmoother::new(lag.map_or_else(of_settings, nanoseconds)),
            rows: rows.with_context(unwritten)?,
            smoothed: Vec::new(),
        })
    }

    /// Writes the waiting states.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(super) fn finish(mut self) -> anyhow::Result<()> {
        let smoothed = &mut self.smoothed;
        self.smoother.finish(|state| smoothed.push(*state));
        self.write()?;
        self.rows.finish()?.0.finish()?;
        Ok(())
    }
}

impl<W: Write> LaggingRows<W> {
    /// Takes the next state of a system track.
    pub(super) fn state(&mut self, state: &SystemTrack) -> io::Result<()> {
        let smoothed = &mut self.smoothed;
        self.smoother.state(state, |state| smoothed.push(*state));
        self.write()
    }

    /// Takes the next input of a filter.
    pub(super) fn input(&mut self, input: &FilterInput) -> io::Result<()> {
        let smoothed = &mut self.smoothed;
        self.smoother.input(input, |state| smoothed.push(*state));
        self.write()
    }

    fn write(&mut self) -> io::Result<()> {
        self.smoothed.drain(..).try_for_each(|state| self.rows.take(&state))
    }
}

//! Selection of the system track states written as rows.
//!
//! Without a refresh time, every state becomes a row. With a refresh time, rows hold the states at whole multiples of
//! this time, for confirmed and coasted tracks: a row per track and time, in the order of the track numbers.

use std::collections::BTreeMap;
use std::io::{self, Write};

use formats::tracks_csv::SystemTrackWriter;
use messages::{SystemTrack, TrackState};

/// Selects states.
#[derive(Debug)]
pub(crate) struct StateSelection {
    refresh_ns: Option<i64>,
    /// States of a single time, by track; passed on when a later state arrives.
    waiting: BTreeMap<u32, SystemTrack>,
}

/// Writes rows.
#[derive(Debug)]
pub(crate) struct StateSink<W: Write> {
    writer: SystemTrackWriter<W>,
    selection: StateSelection,
    written: u64,
}

impl StateSelection {
    pub(crate) fn new(refresh_ns: Option<i64>) -> Self {
        Self {
            refresh_ns,
            waiting: BTreeMap::new(),
        }
    }

    /// Adds a state; selected states go to `row`.
    ///
    /// # Errors
    /// That of `row`.
    pub(crate) fn take(
        &mut self,
        state: &SystemTrack,
        mut row: impl FnMut(&SystemTrack) -> io::Result<()>,
    ) -> io::Result<()> {
        let Some(refresh_ns) = self.refresh_ns else {
            return row(state);
        };
        let is_shown = [TrackState::Confirmed as u8, TrackState::Coasted as u8].contains(&state.state);
        if state.reference_time_ns % refresh_ns != 0 || !is_shown {
            return Ok(());
        }
        let waits_for = self.waiting.values().next().map(|first| first.reference_time_ns);
        if waits_for.is_some_and(|time_ns| time_ns != state.reference_time_ns) {
            self.finish(row)?;
        }
        self.waiting.insert(state.track_number, *state);
        Ok(())
    }

    /// Passes on the remaining states.
    ///
    /// # Errors
    /// That of `row`.
    pub(crate) fn finish(&mut self, row: impl FnMut(&SystemTrack) -> io::Result<()>) -> io::Result<()> {
        self.waiting.values().try_for_each(row)?;
        self.waiting.clear();
        Ok(())
    }
}

impl<W: Write> StateSink<W> {
    /// Writes the header.
    ///
    /// # Errors
    /// If the writer fails.
    pub(crate) fn begin(writer: W, sensor_ids: Vec<u32>, refresh_ns: Option<i64>) -> io::Result<Self> {
        Ok(Self {
            writer: SystemTrackWriter::begin(writer, 0)?.with_sensor_ids(sensor_ids),
            selection: StateSelection::new(refresh_ns),
            written: 0,
        })
    }

    /// Adds a state.
    ///
    /// # Errors
    /// If the writer fails.
    pub(crate) fn take(&mut self, state: &SystemTrack) -> io::Result<()> {
        let Self {
            writer,
            selection,
            written,
        } = self;
        selection.take(state, |row| {
            *written += 1;
            writer.write(row)
        })
    }

    /// Writes the remaining rows; returns the writer and the number of rows.
    ///
    /// # Errors
    /// If the writer fails.
    pub(crate) fn finish(mut self) -> io::Result<(W, u64)> {
        let Self {
            writer,
            selection,
            written,
        } = &mut self;
        selection.finish(|row| {
            *written += 1;
            writer.write(row)
        })?;
        Ok((self.writer.into_inner(), self.written))
    }
}

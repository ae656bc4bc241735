//! Selection of the system track states written as rows.
//!
//! Without a refresh time, every state becomes a row. With a refresh time, rows hold the states at its whole
//! multiples, for confirmed and coasted tracks: one row per track and time, in the order of the track numbers.

use std::collections::BTreeMap;
use std::io::{self, Write};

use formats::tracks_csv::SystemTrackWriter;
use messages::{SystemTrack, TrackState};

/// Writes rows.
#[derive(Debug)]
pub(crate) struct StateSink<W: Write> {
    writer: SystemTrackWriter<W>,
    refresh_ns: Option<i64>,
    /// States of one time, by track; written when a later state arrives.
    waiting: BTreeMap<u32, SystemTrack>,
    written: u64,
}

impl<W: Write> StateSink<W> {
    /// Writes the header.
    ///
    /// # Errors
    /// If the writer fails.
    pub(crate) fn begin(writer: W, sensor_ids: Vec<u32>, refresh_ns: Option<i64>) -> io::Result<Self> {
        Ok(Self {
            writer: SystemTrackWriter::begin(writer, 0)?.with_sensor_ids(sensor_ids),
            refresh_ns,
            waiting: BTreeMap::new(),
            written: 0,
        })
    }

    /// Adds a state.
    ///
    /// # Errors
    /// If the writer fails.
    pub(crate) fn take(&mut self, state: &SystemTrack) -> io::Result<()> {
        let Some(refresh_ns) = self.refresh_ns else {
            self.written += 1;
            return self.writer.write(state);
        };
        let is_shown = [TrackState::Confirmed as u8, TrackState::Coasted as u8].contains(&state.state);
        if state.reference_time_ns % refresh_ns != 0 || !is_shown {
            return Ok(());
        }
        let waits_for = self.waiting.values().next().map(|first| first.reference_time_ns);
        if waits_for.is_some_and(|time_ns| time_ns != state.reference_time_ns) {
            self.write_waiting()?;
        }
        self.waiting.insert(state.track_number, *state);
        Ok(())
    }

    /// Writes the remaining rows; returns the writer and the number of rows.
    ///
    /// # Errors
    /// If the writer fails.
    pub(crate) fn finish(mut self) -> io::Result<(W, u64)> {
        self.write_waiting()?;
        Ok((self.writer.into_inner(), self.written))
    }

    fn write_waiting(&mut self) -> io::Result<()> {
        for state in self.waiting.values() {
            self.writer.write(state)?;
            self.written += 1;
        }
        self.waiting.clear();
        Ok(())
    }
}

//! Which states of system tracks become rows.
//!
//! Without a refresh time every state does. With one, those at its whole multiples do, of tracks that are confirmed or
//! coasted: one row per track and time, in the order of the tracks' numbers. A state is moved to such a time along its
//! velocity.

use std::collections::BTreeMap;
use std::io::{self, Write};

use formats::tracks_csv::SystemTrackWriter;
use messages::{SystemTrack, TrackState};

/// Writes rows.
#[derive(Debug)]
pub(crate) struct Rows<W: Write> {
    writer: SystemTrackWriter<W>,
    refresh_ns: Option<i64>,
    /// The latest state of each track that has not ended.
    latest: BTreeMap<u32, SystemTrack>,
    /// The next time that gets rows.
    next_ns: Option<i64>,
    written: u64,
}

impl<W: Write> Rows<W> {
    /// Writes the header.
    ///
    /// # Errors
    /// If the writer fails.
    pub(crate) fn begin(writer: W, sensor_ids: Vec<u32>, refresh_ns: Option<i64>) -> io::Result<Self> {
        Ok(Self {
            writer: SystemTrackWriter::begin(writer, 0)?.with_sensor_ids(sensor_ids),
            refresh_ns,
            latest: BTreeMap::new(),
            next_ns: None,
            written: 0,
        })
    }

    /// Takes a state.
    ///
    /// # Errors
    /// If the writer fails.
    pub(crate) fn take(&mut self, state: &SystemTrack) -> io::Result<()> {
        let Some(refresh_ns) = self.refresh_ns else {
            self.written += 1;
            return self.writer.write(state);
        };
        let time_ns = state.reference_time_ns;
        let mut next_ns = self.next_ns.unwrap_or(time_ns + (-time_ns).rem_euclid(refresh_ns));
        while next_ns < time_ns {
            self.write_at(next_ns)?;
            next_ns += refresh_ns;
        }
        self.next_ns = Some(next_ns);
        if state.state == TrackState::Terminated as u8 {
            self.latest.remove(&state.track_number);
        } else {
            self.latest.insert(state.track_number, *state);
        }
        Ok(())
    }

    /// Writes what is left; gives the writer back, and how many rows there are.
    ///
    /// # Errors
    /// If the writer fails.
    pub(crate) fn finish(mut self) -> io::Result<(W, u64)> {
        if let Some(next_ns) = self.next_ns {
            self.write_at(next_ns)?;
        }
        Ok((self.writer.into_inner(), self.written))
    }

    fn write_at(&mut self, time_ns: i64) -> io::Result<()> {
        let shown = [TrackState::Confirmed as u8, TrackState::Coasted as u8];
        for state in self.latest.values().filter(|state| shown.contains(&state.state)) {
            let mut moved = *state;
            let step_s = (time_ns - state.reference_time_ns) as f64 / messages::NS_PER_S;
            for (axis, place) in moved.position_m.iter_mut().enumerate() {
                *place += step_s * state.velocity_mps[axis];
            }
            moved.reference_time_ns = time_ns;
            self.writer.write(&moved)?;
            self.written += 1;
        }
        Ok(())
    }
}

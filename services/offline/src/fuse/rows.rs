//! Selection of the system track states written as rows.
//!
//! Without a refresh time, every state becomes a row. With a refresh time, rows hold the states at whole multiples of
//! this time, for confirmed and coasted tracks: a row per track and time, in the order of the track numbers.
//!
//! Where the place of the plane on the Earth is known from the input, rows have the columns of recorded tables, with
//! degrees behind the columns in metres.

use std::collections::BTreeMap;
use std::io::{self, Write};

use formats::tracks_csv::{PlacedTrack, PlacedTrackWriter, SystemTrackWriter};
use frames::{SystemFrame, Vertical};
use messages::{SystemTrack, TrackState};

use crate::reading::Setup;

/// Selects states.
#[derive(Debug)]
pub(crate) struct StateSelection {
    refresh_ns: Option<i64>,
    /// States of a single time, by track; passed on when a later state arrives.
    waiting: BTreeMap<u32, SystemTrack>,
}

/// Writer of system tracks, without or with their places on the Earth.
#[derive(Debug)]
pub(crate) enum TrackRows<W> {
    Plane(SystemTrackWriter<W>),
    Placed(PlacedTrackWriter<W>, SystemFrame),
}

impl<W: Write> TrackRows<W> {
    /// Writes the header; `frame` is the plane on the Earth, if rows have places there.
    ///
    /// # Errors
    /// If the writer fails.
    pub(crate) fn begin(writer: W, sensor_ids: Vec<u32>, frame: Option<SystemFrame>) -> io::Result<Self> {
        Ok(match frame {
            None => Self::Plane(SystemTrackWriter::begin(writer, 0)?.with_sensor_ids(sensor_ids)),
            Some(frame) => Self::Placed(PlacedTrackWriter::begin(writer, 0)?.with_sensor_ids(sensor_ids), frame),
        })
    }

    /// Writes a row.
    ///
    /// # Errors
    /// If the writer fails.
    pub(crate) fn write(&mut self, track: &SystemTrack) -> io::Result<()> {
        match self {
            Self::Plane(writer) => writer.write(track),
            Self::Placed(writer, frame) => writer.write(&placed(track, frame)),
        }
    }

    /// The writer, not flushed.
    pub(crate) fn into_inner(self) -> W {
        match self {
            Self::Plane(writer) => writer.into_inner(),
            Self::Placed(writer, _) => writer.into_inner(),
        }
    }
}

/// A track with its place on the Earth. Without a height, the target is on the ellipsoid: 200 km from the origin, the
/// point of the plane is 3 km above it, and 100 m aside.
fn placed(track: &SystemTrack, frame: &SystemFrame) -> PlacedTrack {
    if track.height_valid != 0 {
        return PlacedTrack::new(track, frame);
    }
    let ([east, north, _], on_ground) = (
        track.position_m,
        Vertical {
            height_m: 0.0,
            climb_mps: 0.0,
        },
    );
    let [up, _] = frame.above([east, north], [0.0; 2], on_ground);
    PlacedTrack {
        track: *track,
        place: frame.to_geodetic([east, north, up]),
    }
}

/// Writes rows.
#[derive(Debug)]
pub(crate) struct StateSink<W: Write> {
    writer: TrackRows<W>,
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
    /// Writes the header of the output of a run.
    ///
    /// # Errors
    /// If the writer fails.
    pub(crate) fn begin(writer: W, setup: &Setup<'_>) -> io::Result<Self> {
        Ok(Self {
            writer: TrackRows::begin(writer, setup.sensor_ids.clone(), setup.named.frame)?,
            selection: StateSelection::new(setup.settings.refresh_ns()),
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

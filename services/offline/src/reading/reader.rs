//! Reader of a file, whichever its columns.

use csv_table::CsvError;
use formats::named_columns::{NamedTrackReader, RowSource};
use formats::sensor_tracks_csv::SensorTrackReader;
use messages::SensorTrack;

use super::progress::CountingInput;

pub(super) type SourceOf = Box<dyn FnMut(u32) -> Option<u16>>;
type NamedSourceOf = Box<dyn FnMut(&str) -> Option<RowSource>>;

/// Reader of a file of sensor tracks.
pub(super) enum FileReader {
    /// Sensor tracks in metres (FM-5).
    Metres(Box<SensorTrackReader<CountingInput, SourceOf>>),
    /// Named columns.
    Named(Box<NamedTrackReader<CountingInput, NamedSourceOf>>),
}

impl FileReader {
    /// Line, from 1, of the row read last, or of the header.
    pub(super) fn line(&self) -> u64 {
        match self {
            Self::Metres(reader) => reader.line(),
            Self::Named(reader) => reader.line(),
        }
    }

    /// When the row read last arrived, nanoseconds: at its own time, unless the file states another.
    pub(super) fn arrival_ns(&self, track: &SensorTrack) -> i64 {
        match self {
            Self::Metres(reader) => reader.arrival_ns(),
            Self::Named(_) => track.time_of_measurement_ns,
        }
    }
}

impl Iterator for FileReader {
    type Item = Result<SensorTrack, CsvError>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        match self {
            Self::Metres(reader) => reader.next(),
            Self::Named(reader) => reader.next(),
        }
    }
}

//! Content of a recorded file, read piece by piece.

use std::collections::VecDeque;
use std::io::Cursor;

use asterix::{Decoder, blocks};
use configuration::{Recorded, RecordedFormat};
use csv_table::CsvError;
use formats::containers::{Container, datagrams};
use formats::sbs::{Merger, SbsSettings};
use formats::sensor_tracks_csv::SensorTrackReader;
use messages::{Counter, Counters};
use reception::observation::{self, Reading};

use crate::counted::{decoded, merged};
use crate::intake::Intake;

/// A recorded file, and how far it has been read.
#[derive(Debug)]
pub(crate) enum Content {
    /// ASTERIX data blocks, and what reads them.
    Asterix(Packed, Box<Decoder>),
    /// Lines of SBS-1.
    Lines(Lines),
    /// A table of sensor tracks.
    Tracks(Tracks),
}

impl Content {
    /// # Errors
    /// If it is to be a table and its header is none of a table of sensor tracks.
    pub(crate) fn open(bytes: Vec<u8>, recorded: &Recorded, first_day_ns: i64) -> Result<Self, CsvError> {
        Ok(match recorded.format {
            RecordedFormat::Asterix => Self::Asterix(Packed::new(bytes), Box::new(recorded.asterix.decoder())),
            RecordedFormat::Sbs => Self::Lines(Lines {
                bytes,
                offset: 0,
                first_day_ns,
                merger: Merger::new(SbsSettings::default()),
            }),
            RecordedFormat::SensorTracks => Self::Tracks(Tracks::open(bytes, first_day_ns)?),
        })
    }

    /// Whether everything has been read.
    pub(crate) fn is_exhausted(&self) -> bool {
        match self {
            Self::Asterix(packed, _) => packed.is_exhausted(),
            Self::Lines(lines) => lines.offset == lines.bytes.len(),
            Self::Tracks(tracks) => tracks.reader.is_none(),
        }
    }

    /// Reads the next block, line or row.
    pub(crate) fn read_piece(&mut self, intake: &mut Intake) {
        match self {
            Self::Asterix(packed, decoder) => {
                for record in decoder.records(packed.next_block()).flatten() {
                    match observation::read(&record) {
                        Reading::Target(observed) => intake.observe(&observed),
                        Reading::Service(service) => intake.service(&service),
                        Reading::Other => {}
                    }
                }
            }
            Self::Lines(lines) => lines.read_line(intake),
            Self::Tracks(tracks) => tracks.read_row(intake),
        }
    }

    /// Adds what has been counted so far.
    pub(crate) fn count(&self, counters: &mut Counters) {
        match self {
            Self::Asterix(_, decoder) => *counters += &decoded(decoder.counts()),
            Self::Lines(lines) => *counters += &merged(&lines.merger),
            Self::Tracks(tracks) => {
                counters[Counter::Records] += tracks.rows;
                counters[Counter::BlocksRejected] += tracks.rejected;
            }
        }
    }
}

/// Lines of SBS-1 in a file.
#[derive(Debug)]
pub(crate) struct Lines {
    bytes: Vec<u8>,
    offset: usize,
    first_day_ns: i64,
    merger: Merger,
}

impl Lines {
    fn read_line(&mut self, intake: &mut Intake) {
        let rest = &self.bytes[self.offset..];
        let end = rest.iter().position(|octet| *octet == b'\n');
        let line = rest[..end.unwrap_or(rest.len())].trim_ascii_end();
        self.offset += end.map_or(rest.len(), |end| end + 1);
        // A line that was rejected has been counted by reason. Lines without a time are of no use in a file.
        if let Ok(Some(observed)) = self.merger.take(line, self.first_day_ns) {
            intake.observe(&observed);
        }
    }
}

/// Rows of sensor tracks, of whatever sensors; a source is a file.
#[derive(Debug)]
pub(crate) struct Tracks {
    reader: Option<Box<Rows>>,
    rows: u64,
    rejected: u64,
}

type Rows = SensorTrackReader<Cursor<Vec<u8>>, fn(u32) -> Option<u16>>;

impl Tracks {
    fn open(bytes: Vec<u8>, first_day_ns: i64) -> Result<Self, CsvError> {
        let any_sensor: fn(u32) -> Option<u16> = |_| Some(0);
        let reader = SensorTrackReader::new(Cursor::new(bytes), first_day_ns, any_sensor)?;
        Ok(Self {
            reader: Some(Box::new(reader)),
            rows: 0,
            rejected: 0,
        })
    }

    fn read_row(&mut self, intake: &mut Intake) {
        match self.reader.as_mut().and_then(|reader| reader.next()) {
            Some(Ok(track)) => {
                self.rows += 1;
                intake.track(track);
            }
            Some(Err(_)) => self.rejected += 1,
            None => self.reader = None,
        }
    }
}

/// The datagrams of a recording, one after the other.
#[derive(Debug)]
pub(crate) struct Packed {
    bytes: Vec<u8>,
    /// End of each datagram, in their order.
    ends: VecDeque<usize>,
    offset: usize,
}

impl Packed {
    /// Takes datagrams out of what the recording packs them in.
    pub(crate) fn new(bytes: Vec<u8>) -> Self {
        let (mut unpacked, mut ends) = (Vec::new(), VecDeque::new());
        if Container::detect(&bytes) == Container::Raw {
            unpacked = bytes;
            ends.push_back(unpacked.len());
        } else {
            for datagram in datagrams(&bytes).flatten() {
                unpacked.extend_from_slice(&datagram.bytes);
                ends.push_back(unpacked.len());
            }
        }
        ends.retain(|end| *end > 0);
        Self {
            bytes: unpacked,
            ends,
            offset: 0,
        }
    }

    /// Whether every block has been handed out.
    pub(crate) fn is_exhausted(&self) -> bool {
        self.ends.is_empty()
    }

    /// The octets of the next data block. What is no block ends its datagram, and is handed out to be counted.
    pub(crate) fn next_block(&mut self) -> &[u8] {
        let end = self.ends.front().copied().unwrap_or(self.offset);
        let rest = &self.bytes[self.offset..end];
        let length = blocks(rest)
            .next()
            .and_then(Result::ok)
            .map_or(rest.len(), |block| block.bytes.len());
        self.offset += length;
        if self.offset == end {
            self.ends.pop_front();
        }
        &rest[..length]
    }
}

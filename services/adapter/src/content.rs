//! Contents of a recorded file, read piece by piece.

use std::collections::BTreeSet;
use std::fmt;
use std::io::Cursor;

use asterix::{Decoder, StatedTables};
use csv_table::CsvError;
use deployment::{FeedFormat, FeedOrigin, Recorded, RecordedFormat};
use formats::containers::RecordedPieces;
use formats::feed::{Fed, FeedCounts, FeedReader};
use formats::named_columns::{NamedTrackReader, RowSource, TableOutline};
use formats::observation::{self, FinderReports, Reading};
use formats::readsb::documents;
use formats::sensor_tracks_csv::SensorTrackReader;
use frames::SystemFrame;
use messages::{Counter, Counters, SensorTrack};
use observations::Observation;

use crate::counted::decoded;
use crate::feed::{self, StatedReceiver};
use crate::intake::Intake;

/// Longest piece of a recorded feed without lines, bytes.
const PIECE_OCTETS_MAX: usize = 1 << 16;

/// Data blocks of ASTERIX in a file.
#[derive(Debug)]
pub(crate) struct RecordedBlocks {
    pieces: RecordedPieces,
    decoder: Decoder,
    /// Direction finder whose reports are located; `None` of a source of targets.
    finder: Option<FinderReports>,
    first_day_ns: i64,
}

/// Recorded file, and the reader's progress.
#[derive(Debug)]
pub(crate) enum RecordedContent {
    /// ASTERIX data blocks, and the reader of the blocks.
    Asterix(Box<RecordedBlocks>),
    /// Data of a feed.
    Feed(Box<RecordedFeed>, FeedOrigin),
    /// Table of sensor tracks.
    Tracks(RecordedTracks),
}

impl RecordedContent {
    /// # Errors
    /// If the file is configured as a table and the header is not the header of a table of sensor tracks.
    pub(crate) fn open(
        bytes: Vec<u8>,
        recorded: &Recorded,
        (frame, receiver): (SystemFrame, StatedReceiver),
        first_day_ns: i64,
    ) -> Result<Self, CsvError> {
        Ok(match recorded.format.feed() {
            Some(feed) => {
                let read = (feed, receiver, first_day_ns);
                Self::Feed(Box::new(RecordedFeed::open(read, bytes)), recorded.origin)
            }
            None if recorded.format == RecordedFormat::Asterix => {
                let tables = StatedTables::new(&recorded.asterix.editions, recorded.asterix.is_strict);
                Self::Asterix(Box::new(RecordedBlocks {
                    pieces: RecordedPieces::new(bytes),
                    decoder: tables.decoder(),
                    finder: None,
                    first_day_ns,
                }))
            }
            None => Self::Tracks(RecordedTracks::open(bytes, frame, first_day_ns)?),
        })
    }

    /// The same, with the reports of a direction finder located.
    pub(crate) fn with_finder(mut self, finder: Option<FinderReports>) -> Self {
        if let Self::Asterix(blocks) = &mut self {
            blocks.finder = finder;
        }
        self
    }

    /// Whether everything has been read.
    pub(crate) fn is_exhausted(&self) -> bool {
        match self {
            Self::Asterix(blocks) => blocks.pieces.is_exhausted(),
            Self::Feed(feed, _) => feed.pieces.is_exhausted(),
            Self::Tracks(tracks) => tracks.reader.is_none(),
        }
    }

    /// Reads the next block, line or row.
    pub(crate) fn read_piece(&mut self, intake: &mut Intake) {
        match self {
            Self::Asterix(blocks) => blocks.read_block(intake),
            Self::Feed(feed, wanted) => feed.read_piece(&mut |fed| match fed {
                Fed::Target(transmission, observed) if feed::uses(*wanted, transmission.origin) => {
                    intake.heard(transmission, observed);
                }
                Fed::Statement(transmission, stated) if feed::uses(*wanted, transmission.origin) => {
                    intake.state(transmission, stated);
                }
                // Refused data are counted.
                Fed::Target(..) | Fed::Statement(..) | Fed::Refused(..) => {}
            }),
            Self::Tracks(tracks) => tracks.read_row(intake),
        }
    }

    /// Adds the counts so far.
    pub(crate) fn count(&self, counters: &mut Counters) {
        match self {
            Self::Asterix(blocks) => {
                *counters += &decoded(blocks.decoder.counts());
                if let Some(finder) = &blocks.finder {
                    *counters += finder.counters();
                }
            }
            Self::Feed(feed, _) => *counters += &feed::counted(&feed.reader),
            Self::Tracks(tracks) => {
                counters[Counter::Records] += tracks.rows;
                counters[Counter::BlocksRejected] += tracks.rejected;
            }
        }
    }
}

impl RecordedBlocks {
    fn read_block(&mut self, intake: &mut Intake) {
        let (block, length) = self.pieces.next_block();
        for record in self.decoder.records_of(block.into_iter(), length).flatten() {
            match observation::read(&record) {
                Reading::Target(observed) => intake.observe(&observed),
                Reading::Service(service) => intake.service(&service),
                Reading::Other => {
                    let finder = self.finder.as_mut();
                    // Refused reports are counted by reason.
                    let taken = finder.and_then(|finder| finder.take(&record, None, self.first_day_ns).ok());
                    if let Some(measured) = taken.flatten() {
                        intake.emitter(&measured);
                    }
                }
            }
        }
    }
}

/// Data of a feed in a file, or in the datagrams of a capture.
#[derive(Debug)]
pub(crate) struct RecordedFeed {
    pieces: RecordedPieces,
    first_day_ns: i64,
    format: FeedFormat,
    /// Time of receipt of data that state none, UTC, nanoseconds.
    received_ns: Option<i64>,
    reader: FeedReader,
}

impl RecordedFeed {
    /// Opens the data of `bytes`, with what is known of the receiver, and the begin of the first day, UTC, nanoseconds:
    /// ticks of receivers without a date begin there.
    pub(crate) fn open((format, receiver, first_day_ns): (FeedFormat, StatedReceiver, i64), bytes: Vec<u8>) -> Self {
        Self {
            received_ns: None,
            pieces: RecordedPieces::of_feed(bytes),
            format,
            reader: FeedReader::new(feed::settings(format, 0, receiver, first_day_ns)),
            first_day_ns,
        }
    }

    /// Reads the next piece.
    fn read_piece(&mut self, out: &mut dyn FnMut(Fed<'_>)) {
        let (format, is_lines) = (self.format, self.format.is_lines());
        let (piece, received_ns) = self.pieces.next_piece(|rest| {
            let length = match format {
                FeedFormat::Sbs | FeedFormat::Ais | FeedFormat::RadarTargets | FeedFormat::RemoteId => {
                    rest.iter().position(|octet| *octet == b'\n').map(|end| end + 1)
                }
                FeedFormat::ModeS | FeedFormat::Cot => Some(PIECE_OCTETS_MAX),
                FeedFormat::Readsb => {
                    let mut further = documents(rest);
                    further.next();
                    Some(rest.len() - further.rest().len())
                }
            };
            let length = length.map_or(rest.len(), |length| length.min(rest.len()));
            (&rest[..length], length)
        });
        let piece = if is_lines { piece.trim_ascii_end() } else { piece };
        // Lines without a time have no use in a text file; frames may have ticks, and radars send own ship's time.
        let has_receipt = is_lines && format != FeedFormat::RadarTargets;
        let received_ns = received_ns
            .or(self.received_ns)
            .or(has_receipt.then_some(self.first_day_ns));
        // Refused data are counted by reason.
        self.reader.take(piece, received_ns, out);
        if self.pieces.is_exhausted() {
            self.reader.end();
        }
    }

    /// Reads everything as received at `received_ns`, UTC, nanoseconds, unless the data state their receipt; `observed`
    /// gets each target report.
    pub(crate) fn survey(mut self, received_ns: Option<i64>, observed: &mut dyn FnMut(&Observation)) -> FeedSurvey {
        self.received_ns = received_ns;
        let (mut refused, mut stations, mut station_deg) = (None, BTreeSet::new(), None);
        while !self.pieces.is_exhausted() {
            self.read_piece(&mut |fed| match fed {
                Fed::Target(_, report) => observed(report),
                Fed::Refused(_, words) => refused = Some(words.to_string()),
                Fed::Statement(_, stated) => {
                    if let Some(station) = stated.station {
                        stations.insert(stated.track_number);
                        station_deg = station_deg.or(Some(station.place_rad.map(f64::to_degrees)));
                    }
                }
            });
        }
        FeedSurvey {
            stations: stations.len(),
            station_deg,
            counts: self.reader.counts(),
            first_utc_ns: self.reader.first_utc_ns(),
            refused,
        }
    }
}

/// What a file holds as the recording of a feed.
#[derive(Clone, Debug)]
pub struct FeedSurvey {
    /// Counts of the transmissions.
    pub counts: FeedCounts,
    /// First time with a date in the data, UTC, nanoseconds since 1970.
    pub first_utc_ns: Option<i64>,
    /// Number of stations that are no targets: base stations, aids to navigation.
    pub stations: usize,
    /// Latitude and longitude of the first of these, degrees.
    pub station_deg: Option<[f64; 2]>,
    /// Latest refusal in words.
    pub refused: Option<String>,
}

/// Rows of sensor tracks of any sensors; a file is a single source.
pub(crate) struct RecordedTracks {
    reader: Option<Box<TrackRows>>,
    rows: u64,
    rejected: u64,
}

/// Rows of a table, whatever its columns.
pub type TrackRows = dyn Iterator<Item = Result<SensorTrack, CsvError>> + Send;

impl fmt::Debug for RecordedTracks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RecordedTracks")
            .field("rows", &self.rows)
            .finish_non_exhaustive()
    }
}

impl RecordedTracks {
    /// Opens a table of sensor tracks in metres (FM-5), or of named columns, whose degrees are placed in `frame`.
    fn open(bytes: Vec<u8>, frame: SystemFrame, first_day_ns: i64) -> Result<Self, CsvError> {
        Ok(Self {
            reader: Some(rows_of_tracks(bytes, frame, first_day_ns)?),
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

/// Opens a table of sensor tracks in metres (FM-5), or of named columns, whose degrees are placed in `frame`. Times of
/// day count from `first_day_ns` (UTC, nanoseconds).
///
/// # Errors
/// If the header is not one of a table of tracks.
pub fn rows_of_tracks(bytes: Vec<u8>, frame: SystemFrame, first_day_ns: i64) -> Result<Box<TrackRows>, CsvError> {
    let outline = TableOutline::of(&bytes[..])?;
    let input = Cursor::new(bytes);
    let reader: Box<TrackRows> = match outline {
        Some(outline) => {
            let sigma_m = Some(outline.assumed_sigma_m());
            let source = move |_: &str| Some(RowSource { number: 0, sigma_m });
            Box::new(NamedTrackReader::new(input, Some(frame), "", source)?.counting_from(first_day_ns))
        }
        None => {
            let any_sensor: fn(u32) -> Option<u16> = |_| Some(0);
            Box::new(SensorTrackReader::new(input, first_day_ns, any_sensor)?.with_accuracies_of(None))
        }
    };
    Ok(reader)
}

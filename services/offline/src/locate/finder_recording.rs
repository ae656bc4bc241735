//! Recordings of direction finders (ASTERIX, category 205) as measurements of emitters.
//!
//! Adapters make measurements of the reports of live and recorded sources; the same readers do so here: the pieces of
//! the container, the decoder of the records, and [`FinderReports`]. What a source's configuration states beside the
//! reports comes from the options of the command.
//!
//! # Limits
//!
//! A recording is read whole into memory. Records are counted from 1 over all records that can be decoded, as `koseki
//! decode` writes them.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::io::Read;
use std::path::Path;
use std::rc::Rc;

use asterix::{Decoder, StatedTables};
use formats::containers::{Container, RecordedPieces, TimeStamp};
use formats::foreign::Foreign;
use formats::observation::{DirectionFinder, FinderRefusal, FinderReports, finder_report};
use formats::recording::RecordingBytes;
use frames::Geodetic;
use frames::time::NS_PER_DAY;
use messages::Counter;
use observations::EmitterMeasurement;

use crate::files::InputError;
use crate::reading::{BegunFile, FilePlane, RowPlace, SkippedRows};

/// Shortest header of a table, octets: header and first items of a data block are no text of this length.
const HEADER_MIN: usize = 12;

/// What no report states of the finder.
#[derive(Clone, Copy, Debug)]
pub(super) struct StatedFinder {
    /// Standard deviation of bearings, radians, above 0 and at most 1.
    pub(super) sigma_rad: f64,
    /// Place of the finder, or reference point of a system of finders.
    pub(super) place: Option<Geodetic>,
    /// SAC and SIC of the only sender.
    pub(super) sac_sic: Option<(u8, u8)>,
    /// Begin of the first day, UTC, nanoseconds since 1970.
    pub(super) first_day_ns: Option<i64>,
}

/// Recording of the reports of direction finders.
#[derive(Debug)]
pub(super) struct FinderRecording {
    pieces: RecordedPieces,
    decoder: Decoder,
    reports: FinderReports,
    first_day_ns: i64,
    /// Records so far.
    records: u64,
    /// Measurements of the latest block that have not been taken, each with the number of its record.
    ready: VecDeque<(u64, EmitterMeasurement)>,
    octets_read: Rc<RefCell<u64>>,
}

/// Whether a file that begins so is to be read as a recording, and not as a table: all text is a table but the lines of
/// a container. Rows behind a header that are no text are refused row by row.
pub(super) fn is_recording(head: &[u8]) -> bool {
    match Container::detect(head) {
        Container::Raw => {
            let header = head.split(|octet| *octet == b'\n').next().unwrap_or_default();
            let has_header = header.len() >= HEADER_MIN && Foreign::as_text(header).is_some();
            !head.is_empty() && !has_header && Foreign::as_text(head).is_none()
        }
        Container::Pcap | Container::PcapNg | Container::Final | Container::Gps | Container::Hex => true,
    }
}

impl FinderRecording {
    /// Reads a recording into memory.
    ///
    /// # Errors
    /// If the file cannot be read, is of another kind, has no report of a direction finder, or its places cannot be
    /// placed in the plane.
    pub(super) fn read(
        path: &Path,
        file: BegunFile,
        (finder, plane): (&StatedFinder, &mut FilePlane),
        octets_read: &Rc<RefCell<u64>>,
    ) -> Result<Self, InputError> {
        let mut bytes = Vec::new();
        let read = file.whole().0.read_to_end(&mut bytes);
        read.map_err(|error| InputError::unreadable(path, &error))?;
        let outline = RecordingOutline::of(path, &bytes, finder.sac_sic)?;
        let frame = plane.frame_of_recording(path, finder.place, outline.first_place)?;
        let place = finder.place.unwrap_or_else(|| frame.to_geodetic([0.0; 3]));
        let of_reports = DirectionFinder::new(&frame, place, finder.sigma_rad)
            .ok_or_else(|| InputError::new(path, "--bearing-sigma-deg must lie between 0.001 and 57"))?;
        Ok(Self {
            pieces: RecordedPieces::new(bytes),
            decoder: StatedTables::new(&[], false).decoder(),
            reports: FinderReports::new(of_reports, finder.place.is_some(), finder.sac_sic),
            first_day_ns: finder.first_day_ns.or(outline.first_day_ns).unwrap_or_default(),
            records: 0,
            ready: VecDeque::new(),
            octets_read: Rc::clone(octets_read),
        })
    }

    /// Reads the next measurement, with the number of its record. Reports that give none are counted; at the end, so
    /// are those that are none by themselves.
    pub(super) fn next(&mut self, path: &Path, refusals: &mut SkippedRows) -> Option<(u64, EmitterMeasurement)> {
        while self.ready.is_empty() && !self.pieces.is_exhausted() {
            self.read_block(path, refusals);
            if self.pieces.is_exhausted() {
                let counters = self.reports.counters();
                refusals.count_all("another sender", counters[Counter::RejectedSource]);
                let what = "reports that measure nothing new (ends, conflicts, positions made of bearings)";
                refusals.count_all(what, counters[Counter::ServiceMessages]);
            }
        }
        self.ready.pop_front()
    }

    fn read_block(&mut self, path: &Path, refusals: &mut SkippedRows) {
        let at = self.pieces.offset();
        let (block, length) = self.pieces.next_block();
        *self.octets_read.borrow_mut() += length as u64;
        for record in self.decoder.records_of(block.into_iter(), length) {
            let record = match record {
                Ok(record) => record,
                Err(error) => {
                    let why = format!("in the data block at byte {at}, {error}");
                    refusals.refused("a damaged block", path, RowPlace::Record(self.records + 1), why);
                    continue;
                }
            };
            self.records += 1;
            match self.reports.take(&record, None, self.first_day_ns) {
                Ok(Some(measured)) => self.ready.push_back((self.records, measured)),
                Ok(None) => {}
                Err(refusal) => {
                    let remedy = match refusal {
                        FinderRefusal::Position => "; give the finder's place, --place LAT,LON",
                        _ => "",
                    };
                    let why = format!("{refusal}{remedy}");
                    refusals.refused(refusal.label(), path, RowPlace::Record(self.records), why);
                }
            }
        }
    }
}

/// What a first look at a recording shows.
#[derive(Debug, Default)]
struct RecordingOutline {
    /// The first place in a report of the sender, with the number of its record.
    first_place: Option<(Geodetic, u64)>,
    /// Begin of the day of the first time with a date, UTC, nanoseconds since 1970.
    first_day_ns: Option<i64>,
}

impl RecordingOutline {
    fn of(path: &Path, bytes: &[u8], sac_sic: Option<(u8, u8)>) -> Result<Self, InputError> {
        let recording = RecordingBytes::new(bytes);
        let survey = recording.survey();
        let foreign = survey.foreign(bytes).map(|kind| kind.to_string());
        let unread = (survey.records() == 0).then(|| "no record of ASTERIX can be read".to_owned());
        if let Some(why) = foreign.or(unread) {
            let what = format!("{why}; bearings are tables (CSV), or recordings of ASTERIX (category 205)");
            return Err(InputError::new(path, what));
        }
        let (mut outline, mut records, mut reports) = (Self::default(), 0, 0);
        let Ok(()) = recording.for_each(&survey, |found| {
            records += 1;
            if let Some(TimeStamp::Utc { ns }) = found.time_stamp {
                let day_ns = ns.div_euclid(NS_PER_DAY) * NS_PER_DAY;
                outline.first_day_ns.get_or_insert(day_ns);
            }
            if let Some(report) = finder_report(found.record).filter(|report| report.may_be_of(sac_sic)) {
                reports += 1;
                if let Some([latitude, longitude]) = report.geodetic.filter(|_| outline.first_place.is_none()) {
                    let place = Geodetic::from_degrees(latitude.to_degrees(), longitude.to_degrees(), 0.0);
                    outline.first_place = place.ok().map(|place| (place, records));
                }
            }
            Ok::<(), Infallible>(())
        });
        match reports {
            0 => Err(InputError::new(path, no_report(sac_sic, records))),
            _ => Ok(outline),
        }
    }
}

/// The error of a recording without a report to be used.
fn no_report(sac_sic: Option<(u8, u8)>, records: u64) -> String {
    let of_sender = sac_sic.map(|(sac, sic)| format!(" of SAC {sac}, SIC {sic}"));
    format!(
        "none of {records} records of ASTERIX is a report of a direction finder (category 205){}; `koseki decode` shows \
         categories and senders",
        of_sender.unwrap_or_default()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_tables_but_for_lines_of_blocks() {
        let block = [205, 0, 8, 0xC0, 25, 9, 5, 0];
        let hexadecimal = "CD 00 08 C0 19 09 05 00\n".repeat(3);
        for (head, expected) in [
            (&b""[..], false),
            (b"time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz\n", false),
            (b"{\"_c\": 205}\n", false),
            (b"time_s,emitter_id,bearing_rad\n1,1,\0\n", false),
            (&block, true),
            (hexadecimal.as_bytes(), true),
        ] {
            assert_eq!(is_recording(head), expected, "{:?}", String::from_utf8_lossy(head));
        }
    }
}

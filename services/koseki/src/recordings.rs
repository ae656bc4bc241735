//! Check of the recordings against the configuration, before the start of processes.
//!
//! A missing recording, a recording of another sensor, or a truncated recording would otherwise appear only as a source
//! that is silent, or falls silent early. Therefore each file is read, the data blocks are compared with the editions,
//! and the first target report is decoded; `koseki check` decodes everything. An error is a single line: file, byte,
//! found value, expected value, and remedy.
//!
//! Limit: of damage within blocks, only a count is given, as long as most blocks of the category fit the edition. The
//! adapter skips and counts undecodable bytes.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use asterix::{Edition, Error as BlockError, StatedTables, blocks, registry};
use csv_table::CsvError;
use deployment::{
    FeedFormat, FeedOrigin, Input, Platform, PlatformInput, PlotFormat, Recorded, RecordedFormat, SampleDelivery,
    Source, Truncated, WideAreaInput, WideAreaSensor,
};
use formats::autoferry;
use formats::containers::{Container, datagrams};
use formats::foreign::Foreign;
use formats::named_columns::TableOutline;
use formats::observation::{Reading, finder_report, read};
use formats::platform_states_csv::PlatformStateReader;
use formats::recording::{RecordingBytes, RecordingSurvey};
use formats::scan_rows_csv::ScanRowReader;
use formats::wide_area_csv::WideAreaReader;
use frames::time::{NS_PER_DAY, seconds};
use frames::{Geodetic, SystemFrame};
use fusion::Stamps;
use reception::ConversionModel;
use sources::{Pipeline, Processing, Samples, TrackerSettings};
use tracking::turn_time::TurnEstimate;
use tracking::wide_area::arrivals::Arrivals;

use crate::config::Config;
use crate::editions;
use crate::kinds::feed_of;

/// Thoroughness of a look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Depth {
    /// At the headers of all blocks, and for the first target report.
    Blocks,
    /// At every record.
    Records,
}

/// Findings in the recording of a source.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RecordingFindings {
    /// Number of the source.
    pub(crate) source: u16,
    /// The file.
    pub(crate) file: PathBuf,
    /// Length, bytes.
    pub(crate) bytes: usize,
    /// Data blocks.
    pub(crate) blocks: usize,
    /// Records that could be decoded; only records up to the first target report without a further examination.
    pub(crate) records: u64,
    /// Undecodable bytes of the blocks.
    pub(crate) skipped: u64,
    /// Time of day of the first target report, nanoseconds.
    pub(crate) first_time_ns: Option<i64>,
    /// Time of day of the last target report that was looked at, nanoseconds.
    pub(crate) last_time_ns: Option<i64>,
    /// Duration of the antenna turn in the data, for a source tracked from plots, if every record was decoded.
    pub(crate) turn: Option<TurnEstimate>,
    /// Time stamps of the target reports.
    pub(crate) stamps: Stamps,
    /// Sentences on blocks that fit another edition better than the edition in use.
    pub(crate) doubts: Vec<String>,
}

impl RecordingFindings {
    /// Notes the time of a target report, nanoseconds.
    fn note_time(&mut self, time_ns: Option<i64>) {
        self.first_time_ns = self.first_time_ns.or(time_ns);
        self.last_time_ns = time_ns.or(self.last_time_ns);
        if let Some(time_ns) = time_ns {
            self.stamps.learn(time_ns);
        }
    }
}

/// A recording that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{}: {what}", file.display())]
pub(crate) struct UnusableRecording {
    file: PathBuf,
    what: String,
}

/// Owner of a recording.
#[derive(Clone, Debug)]
struct RecordingOwner {
    /// `source "radar"`.
    whose: Box<str>,
    /// Place of the configuration: `source[0].recorded`.
    place: Box<str>,
    /// Latitude and longitude where a source stands, degrees, if stated.
    stands_deg: Option<[f64; 2]>,
    /// Whether its bearings are located.
    locates: bool,
}

impl RecordingOwner {
    fn unreadable(&self, error: &io::Error) -> String {
        let (whose, place) = (&self.whose, &self.place);
        format!(
            "cannot be read: {error}; it is the recording of {whose}: name its folder with --data, or correct {place}.file"
        )
    }

    fn no_table(&self, error: &CsvError, of: &str) -> String {
        format!(
            "{error}; it is the recording of {}, to be read as a table of {of}",
            self.whose
        )
    }
}

/// Looks at the recording of every recorded source.
///
/// # Errors
/// The first that cannot be used.
pub(crate) fn inspect(config: &Config, data: &Path, depth: Depth) -> Result<Vec<RecordingFindings>, UnusableRecording> {
    let mut found = Vec::new();
    for source in &config.sources {
        let Input::Recorded(recorded) = &source.input else {
            continue;
        };
        let key = RecordingOwner {
            whose: format!("source \"{}\"", source.name).into(),
            place: format!("source[{}].recorded", source.number).into(),
            stands_deg: source.stated_place_deg,
            locates: source.has_bearings(),
        };
        let file = data.join(&recorded.file);
        let looked = fs::read(&file)
            .map_err(|error| key.unreadable(&error))
            .and_then(|bytes| {
                let looked = look(&bytes, recorded, &key, depth)?;
                let turn = (depth == Depth::Records).then(|| {
                    turn(
                        &bytes,
                        recorded,
                        config.reading(source).model,
                        config.tracker(source.number),
                    )
                });
                Ok(RecordingFindings {
                    turn: turn.flatten(),
                    ..looked
                })
            });
        match looked {
            Ok(looked) => found.push(RecordingFindings {
                source: source.number,
                file,
                ..looked
            }),
            Err(what) => return Err(UnusableRecording { file, what }),
        }
    }
    for sensor in &config.wide_area_sensors {
        inspect_wide_area(sensor, data, depth)?;
    }
    for sensor in &config.tracker_sensors {
        inspect_plots(sensor, data, depth)?;
    }
    config
        .platforms
        .iter()
        .try_for_each(|platform| inspect_states(platform, data))?;
    Ok(found)
}

/// Checks the recording of a platform, if present.
fn inspect_states(platform: &Platform, data: &Path) -> Result<(), UnusableRecording> {
    let PlatformInput::Recorded(file) = &platform.input else {
        return Ok(());
    };
    let key = RecordingOwner {
        whose: format!("platform \"{}\"", platform.name).into(),
        place: format!("platform[{}].recorded", platform.number).into(),
        stands_deg: None,
        locates: false,
    };
    let file = data.join(file);
    let looked = match fs::read(&file) {
        Err(error) => Err(key.unreadable(&error)),
        Ok(bytes) => PlatformStateReader::new(&bytes[..], 0)
            .map(|_| ())
            .map_err(|error| key.no_table(&error, "states")),
    };
    looked.map_err(|what| UnusableRecording { file, what })
}

/// Checks the recording of a tracker's sensor, if present. The tracker process counts unreadable rows.
fn inspect_plots(sensor: &Source, data: &Path, depth: Depth) -> Result<(), UnusableRecording> {
    let (Input::Recorded(recorded), SampleDelivery::Plots { format, .. }) = (&sensor.input, sensor.delivers) else {
        return Ok(());
    };
    let key = RecordingOwner {
        whose: format!("sensor \"{}\"", sensor.name).into(),
        place: "tracker.sensor.recorded".into(),
        stands_deg: None,
        locates: false,
    };
    let file = data.join(&recorded.file);
    let looked = match fs::read(&file) {
        Err(error) => Err(key.unreadable(&error)),
        Ok(bytes) => match format {
            PlotFormat::Asterix => look(&bytes, recorded, &key, depth).map(|_| ()),
            PlotFormat::Rows => ScanRowReader::new(&bytes[..], 0)
                .map(|_| ())
                .map_err(|error| key.no_table(&error, "detections")),
            PlotFormat::Autoferry => autoferry::read_detections(&bytes)
                .map(|_| ())
                .map_err(|error| format!("{error}; it is the recording of {}", key.whose)),
        },
    };
    looked.map_err(|what| UnusableRecording { file, what })
}

/// Checks the recording of a wide-area sensor, if present. The adapter counts unreadable rows.
fn inspect_wide_area(sensor: &WideAreaSensor, data: &Path, depth: Depth) -> Result<(), UnusableRecording> {
    let Some(file) = sensor.recording().map(|file| data.join(file)) else {
        return Ok(());
    };
    let part = match sensor.input {
        WideAreaInput::Tracks(_) => "tracks",
        _ => "recorded",
    };
    let key = RecordingOwner {
        whose: format!("wide-area sensor \"{}\"", sensor.name).into(),
        place: format!("wide_area_sensor[{}].{part}", sensor.number).into(),
        stands_deg: None,
        locates: false,
    };
    let looked = match fs::read(&file) {
        Err(error) => Err(key.unreadable(&error)),
        Ok(bytes) => match &sensor.input {
            WideAreaInput::Tracks(tracks) => {
                let recorded = Recorded {
                    file: file.clone(),
                    format: RecordedFormat::Asterix,
                    asterix: tracks.asterix.clone(),
                    origin: FeedOrigin::Any,
                    reorder_ns: 0,
                    truncated: Truncated::Accept,
                };
                look(&bytes, &recorded, &key, depth).map(|_| ())
            }
            _ => WideAreaReader::new(&bytes[..], 0)
                .map(|_| ())
                .map_err(|error| key.no_table(&error, "wide-area reports")),
        },
    };
    looked.map_err(|what| UnusableRecording { file, what })
}

fn look(bytes: &[u8], recorded: &Recorded, key: &RecordingOwner, depth: Depth) -> Result<RecordingFindings, String> {
    let (blocks, found) = match recorded.format.feed() {
        Some(feed) => (0, read_feed(bytes, feed, key)?),
        None if recorded.format == RecordedFormat::Asterix => {
            let survey = survey(bytes, recorded);
            check_kind(bytes, recorded, &survey, key)?;
            let doubts = doubts(&survey, recorded, key)?;
            let blocks = count_blocks(bytes, recorded, &survey, key)?;
            let decoded = decode(bytes, recorded, depth, key.locates);
            (blocks, RecordingFindings { doubts, ..decoded })
        }
        None => (0, read_rows(bytes, key)?),
    };
    if found.first_time_ns.is_none() && key.locates {
        return Err(format!(
            "byte 0: found no report of a direction finder (category 205) in any block, expected some for {}: correct \
             {}.file, or leave [source.locator] out",
            key.whose, key.place
        ));
    }
    let is_of_finder =
        |feed: Option<FeedFormat>| feed.is_none() && decode(bytes, recorded, depth, true).first_time_ns.is_some();
    if found.first_time_ns.is_none() && is_of_finder(recorded.format.feed()) {
        return Err(format!(
            "its reports are those of direction finders (category 205), which {} does not locate: add [source.locator] to \
             the source of {}",
            key.whose, key.place
        ));
    }
    if found.first_time_ns.is_none() {
        return Err(format!(
            "byte 0: found no target report in any block, expected some for {}: correct {}.file, or the editions under \
             which it is read",
            key.whose, key.place
        ));
    }
    Ok(RecordingFindings {
        bytes: bytes.len(),
        blocks,
        ..found
    })
}

/// The tables by which a recording is read.
pub(crate) fn tables(recorded: &Recorded) -> StatedTables {
    StatedTables::new(&recorded.asterix.editions, recorded.asterix.is_strict)
}

/// Compares the blocks with the editions that the source's adapter uses.
fn survey(bytes: &[u8], recorded: &Recorded) -> RecordingSurvey {
    let stated = tables(recorded);
    let recording = RecordingBytes::new(bytes).with_mode(stated.mode());
    let tables = stated.tables().iter();
    tables
        .fold(recording, |recording, table| recording.with_table(table))
        .survey()
}

/// Checks that the file is a recording, and of this sensor.
fn check_kind(bytes: &[u8], recorded: &Recorded, survey: &RecordingSurvey, key: &RecordingOwner) -> Result<(), String> {
    let (whose, place) = (&key.whose, &key.place);
    let expected = expected_categories(recorded);
    if let Some(kind) = survey.foreign(bytes).filter(|kind| *kind != Foreign::Empty) {
        return Err(format!(
            "no ASTERIX, expected category {} for {whose}: {kind}; correct {place}.file or .format",
            categories(&expected, "or")
        ));
    }
    let found: Vec<u8> = survey.categories.keys().copied().collect();
    if !found.is_empty() && !found.iter().any(|category| expected.contains(category)) {
        return Err(format!(
            "byte 0: found blocks of category {} only, expected {} for {whose}: correct {place}.file or .editions",
            categories(&found, "and"),
            categories(&expected, "or")
        ));
    }
    Ok(())
}

/// Counts the blocks.
fn count_blocks(
    bytes: &[u8],
    recorded: &Recorded,
    survey: &RecordingSurvey,
    key: &RecordingOwner,
) -> Result<usize, String> {
    let (whose, place) = (&key.whose, &key.place);
    let count = survey.blocks() as usize;
    // A capture may contain other network traffic, which is counted, not an error.
    let is_raw = survey.container == Container::Raw;
    let wrong = is_raw.then(|| blocks(bytes).find_map(Result::err)).flatten();
    match wrong {
        Some(error) if survey.records() == 0 => Err(format!(
            "{error}, and nothing before it is a record: the file is no ASTERIX; it is the recording of {whose}: correct \
             {place}.file or .format"
        )),
        Some(error @ BlockError::BlockLength { .. }) => Err(format!(
            "{error}: nothing from here on can be read; record or copy it anew, or keep the first {} bytes",
            error.offset()
        )),
        Some(_) if recorded.truncated == Truncated::Accept => Ok(count),
        Some(error) if 2 * error.offset() < bytes.len() => Err(format!(
            "{error}: nothing from here on is a data block; record or copy it anew, or use the first {} bytes alone by \
             {place}.truncated = \"accept\"",
            error.offset()
        )),
        Some(error) => Err(format!(
            "{error}: the recording was cut short; copy it anew, or use it without this block by {place}.truncated = \
             \"accept\""
        )),
        None if count == 0 => Err(format!(
            "byte 0: the file is empty, expected data blocks; it is the recording of {whose}: record or copy it anew"
        )),
        None => Ok(count),
    }
}

/// Returns a sentence for each category of which a small part fits another edition better.
///
/// # Errors
/// The sentence on the first category with mostly unfitting blocks: any remaining fit is accidental.
fn doubts(survey: &RecordingSurvey, recorded: &Recorded, key: &RecordingOwner) -> Result<Vec<String>, String> {
    let expected = expected_categories(recorded);
    let mut doubts = Vec::new();
    let read = survey.categories.iter().filter(|(number, _)| expected.contains(number));
    for (number, category) in read {
        let (place, is_strict) = (&key.place, recorded.asterix.is_strict);
        let set = |edition: Edition| format!("set {place}.editions = {{ \"{number}\" = \"{edition}\" }}");
        let sentence = editions::verdict(*number, category, is_strict, set);
        match sentence {
            Some(sentence) if category.is_withheld() => return Err(sentence),
            Some(sentence) if category.better().is_some() => doubts.push(sentence),
            _ => {}
        }
    }
    Ok(doubts)
}

/// The categories of the editions that the configuration lists; without any, all that there are tables for.
fn expected_categories(recorded: &Recorded) -> Vec<u8> {
    let stated = &recorded.asterix.editions;
    if stated.is_empty() {
        return registry::defaults().map(|table| table.number).collect();
    }
    stated.iter().map(|(number, _)| *number).collect()
}

fn decode(bytes: &[u8], recorded: &Recorded, depth: Depth, locates: bool) -> RecordingFindings {
    let mut decoder = tables(recorded).decoder();
    let mut found = RecordingFindings::default();
    'datagrams: for datagram in datagrams(bytes).flatten() {
        for record in decoder.records(&datagram.bytes).flatten() {
            let time_of_day_ns = match read(&record) {
                Reading::Target(report) if !locates => report.time_of_day_ns,
                Reading::Other if locates => finder_report(&record).and_then(|report| report.time_of_day_ns),
                _ => continue,
            };
            found.note_time(time_of_day_ns);
            if depth == Depth::Blocks && found.first_time_ns.is_some() {
                break 'datagrams;
            }
        }
    }
    let counts = decoder.counts();
    found.records = counts.records;
    found.skipped = counts.octets_skipped;
    found
}

/// Turn of the antenna in a recording, found in the same way as by the source's adapter.
fn turn(
    bytes: &[u8],
    recorded: &Recorded,
    model: ConversionModel,
    tracker: Option<&TrackerSettings>,
) -> Option<TurnEstimate> {
    let mut tracker = tracker?.clone();
    tracker.joining.cutters[0].period_ns = None;
    let processing = Processing::Detections(Box::new(tracker));
    let mut pipeline = Pipeline::new(model, &processing, 0, Arrivals::new()).ok()?;
    let (mut decoder, mut samples) = (tables(recorded).decoder(), Samples::default());
    for datagram in datagrams(bytes).flatten() {
        for record in decoder.records(&datagram.bytes).flatten() {
            match read(&record) {
                Reading::Target(report) => pipeline.take(&report, 0, &mut samples),
                Reading::Service(service) => pipeline.service(&service, 0, &mut samples),
                _ => continue,
            }
            if let Some(turn) = pipeline.turn() {
                return Some(turn);
            }
        }
    }
    None
}

/// Reads the data of a feed.
fn read_feed(bytes: &[u8], format: FeedFormat, key: &RecordingOwner) -> Result<RecordingFindings, String> {
    let mut found = RecordingFindings::default();
    let survey = adapter::survey_feed(bytes, format, (key.stands_deg, None), &mut |report| {
        found.note_time(report.time_of_day_ns);
    });
    let counts = survey.counts;
    found.records = counts.records;
    found.skipped = counts.refused_octets;
    let kind = Foreign::of(bytes).filter(|kind| feed_of(*kind) != Some(format) && *kind != Foreign::Empty);
    if let Some(kind) = kind.filter(|_| found.records == 0) {
        let (whose, place) = (&key.whose, &key.place);
        return Err(format!(
            "nothing of format \"{}\", expected some for {whose}: {kind}; correct {place}.file or .format",
            format.word()
        ));
    }
    if let Some(refused) = survey.refused.filter(|_| found.records == 0) {
        return Err(format!(
            "nothing of format \"{}\" can be read for {}: {refused}",
            format.word(),
            key.whose
        ));
    }
    let has_receipts = Container::detect(bytes) != Container::Raw;
    if found.records > 0 && counts.timed == 0 && !has_receipts {
        return Err(format!(
            "nothing has a time: the times of {} are unknown; record the data with their times, or as a capture (pcap)",
            key.whose
        ));
    }
    Ok(found)
}

/// Returns the rows of a table of tracks, in the plane of the first position in degrees.
pub(crate) fn table_rows(bytes: &[u8]) -> Result<Box<adapter::TrackRows>, CsvError> {
    let first = TableOutline::of(bytes)?.and_then(|outline| outline.first_place);
    let equator = || Geodetic::from_degrees(0.0, 0.0, 0.0).expect("it is a place");
    let frame = SystemFrame::at(first.map_or_else(equator, |(place, _)| place));
    adapter::rows_of_tracks(bytes.to_vec(), frame, 0)
}

/// Reads a table of sensor tracks. An unreadable row makes the whole table doubtful.
fn read_rows(bytes: &[u8], key: &RecordingOwner) -> Result<RecordingFindings, String> {
    let table = |error| key.no_table(&error, "sensor tracks");
    let mut found = RecordingFindings::default();
    for track in table_rows(bytes).map_err(table)? {
        let time_ns = track.map_err(table)?.time_of_measurement_ns;
        if let Some(last_ns) = found.last_time_ns.filter(|last_ns| *last_ns - time_ns > NS_PER_DAY / 2) {
            return Err(format!(
                "row {}, column time_s: {} is before {}, the time of the row above; it is the recording of {}: times count \
                 on across midnight, so add 86400 to the times of the next day",
                found.records + 1,
                seconds(time_ns),
                seconds(last_ns),
                key.whose
            ));
        }
        found.records += 1;
        found.note_time(Some(time_ns));
    }
    Ok(found)
}

/// `010, 019 or 020`.
fn categories(numbers: &[u8], last: &str) -> String {
    /// Largest number of printed items: a file without ASTERIX has dozens.
    const SHOWN_MAX: usize = 8;
    let mut words: Vec<String> = numbers
        .iter()
        .take(SHOWN_MAX)
        .map(|number| format!("{number:03}"))
        .collect();
    if numbers.len() > SHOWN_MAX {
        words.push("others".to_owned());
    }
    match words.split_last() {
        Some((end, rest)) if !rest.is_empty() => format!("{} {last} {end}", rest.join(", ")),
        _ => words.concat(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;

    const EDITION_10: &str = "source[0].recorded.editions={ \"10\" = \"1.1\" }";

    /// Inspects `bytes` as the recording of a source that takes category 010.
    fn outcome(bytes: &[u8], more: &[&str]) -> Result<RecordingFindings, String> {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("x.ast"), bytes).unwrap();
        let text = "name = \"t\"\n[frame]\nlatitude_deg = 41.0\nlongitude_deg = 2.0\n[time]\ndate = \"2016-05-10\"\n\
                    [[source]]\nname = \"radar\"\n[source.recorded]\nfile = \"x.ast\"\n";
        let is_asterix = !more.iter().any(|each| each.contains("format="));
        let edition = is_asterix.then_some(&EDITION_10);
        let overrides: Vec<String> = edition.into_iter().chain(more).map(|each| (*each).to_owned()).collect();
        let config = Config::parse(Path::new("t.toml"), text, &overrides).unwrap();
        match inspect(&config, folder.path(), Depth::Records) {
            Ok(mut found) => Ok(found.remove(0)),
            Err(error) => {
                let line = error.to_string();
                assert_eq!(line.lines().count(), 1, "{line}");
                let prefix = format!("{}: ", folder.path().join("x.ast").display());
                Err(line.strip_prefix(&prefix).expect(&line).to_owned())
            }
        }
    }

    #[test]
    fn a_file_of_another_kind_is_named() {
        let expected = "no ASTERIX, expected category 010 for source \"radar\": ";
        for (bytes, kind) in [
            (
                &b"!AIVDM,1,1,,A,13u?etPv2;0n:dDPwUM1U1Cb069D,0*24\n"[..],
                "it is a log of AIS",
            ),
            (b"root:x:0:0:root:/root:/bin/sh\n", "it is text; "),
            (
                b"MSG,3,1,1,4CA2D6,1,2020/01/01,12:00:00.000,,,,,,,,,,,,,,\n",
                "format = \"sbs\"",
            ),
            (b"\x89MCAP0\r\n\x01", "it is a recording of all topics"),
        ] {
            let line = outcome(bytes, &[]).unwrap_err();
            assert!(line.starts_with(expected) && line.contains(kind), "{line}");
        }
    }

    #[test]
    fn lines_of_a_receiver_without_times_are_refused() {
        let line = |date: &str| format!("MSG,3,1,1,4CA2D6,1,{date},{date},,36000,,,41.2,2.1,,,0,0,0,0\n");
        let sbs = ["source[0].recorded.format=\"sbs\""];
        let timed = outcome(line("2016/05/10,12:00:00.000").as_bytes(), &sbs).unwrap();
        assert_eq!((timed.records, timed.first_time_ns), (1, Some(43_200_000_000_000)));
        let refused = outcome(line(",").repeat(3).as_bytes(), &sbs).unwrap_err();
        assert!(refused.starts_with("nothing has a time"), "{refused}");
    }

    /// A CAT010 block with a target report: source, message type and time of day.
    fn report(seconds: u32) -> Vec<u8> {
        let time = (seconds * 128).to_be_bytes();
        // FSPEC: I010/010, /000, (/020 absent), /140.
        vec![10, 0, 10, 0b1101_0000, 0, 7, 1, time[1], time[2], time[3]]
    }

    #[test]
    fn a_sound_recording_is_described() {
        let bytes = [report(100), report(101)].concat();
        let found = outcome(&bytes, &[]).unwrap();
        assert_eq!((found.bytes, found.blocks, found.records, found.skipped), (20, 2, 2, 0));
        assert_eq!(found.first_time_ns, Some(100_000_000_000));
        assert_eq!(found.last_time_ns, Some(101_000_000_000));
    }

    #[test]
    fn another_category_is_named() {
        let line = outcome(&[48, 0, 4, 0, 34, 0, 3], &[]).unwrap_err();
        assert!(
            line.starts_with("byte 0: found blocks of category 034 and 048 only, expected 010 for source \"radar\"")
        );
        assert!(line.contains("source[0].recorded.file"), "{line}");
        // The same blocks, cut as well: the cut does not matter any more.
        let line = outcome(&[48, 0, 4, 0, 34, 0, 9], &[]).unwrap_err();
        assert!(line.contains("category 048"), "{line}");
    }

    #[test]
    fn a_recording_cut_short_is_refused_or_accepted() {
        let mut bytes = [report(100), report(101)].concat();
        bytes.truncate(17);
        let line = outcome(&bytes, &[]).unwrap_err();
        assert!(line.starts_with("byte 10: "), "{line}");
        assert!(line.contains("10 octets") && line.contains("7 left"), "{line}");
        assert!(line.contains("truncated = \"accept\""), "{line}");
        let found = outcome(&bytes, &["source[0].recorded.truncated=\"accept\""]).unwrap();
        assert_eq!((found.blocks, found.records), (1, 1));
    }

    #[test]
    fn a_table_that_begins_again_at_midnight_is_refused() {
        let table = |times: &[f64]| -> String {
            let row = |time_s: &f64| format!("{time_s},1,1,0,0,0,0,0,0,9\n");
            let rows: String = times.iter().map(row).collect();
            format!("time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,trace\n{rows}")
        };
        let format = ["source[0].recorded.format=\"sensor-tracks\""];
        assert_eq!(
            outcome(table(&[86_399.9, 86_400.1]).as_bytes(), &format)
                .unwrap()
                .records,
            2
        );
        let line = outcome(table(&[86_399.9, 0.1]).as_bytes(), &format).unwrap_err();
        assert!(
            line.starts_with("row 2, column time_s: 0.1 is before 86399.9"),
            "{line}"
        );
    }

    #[test]
    fn damage_emptiness_and_silence_are_named() {
        let bytes = [report(100), vec![10, 0, 2, 7]].concat();
        let line = outcome(&bytes, &["source[0].recorded.truncated=\"accept\""]).unwrap_err();
        assert!(
            line.starts_with("byte 10: ") && line.contains("first 10 bytes"),
            "{line}"
        );
        assert!(outcome(&[], &[]).unwrap_err().contains("empty"));
        // Only a record of type "start of update cycle".
        let line = outcome(&[10, 0, 7, 0b1100_0000, 0, 7, 2], &[]).unwrap_err();
        assert!(line.contains("no target report"), "{line}");
    }
}

//! What a file is, by its bytes.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use adapter::FeedSurvey;
use asterix::Edition;
use deployment::FeedFormat;
use flate2::read::MultiGzDecoder;
use formats::containers::{Container, TimeStamp, datagrams};
use formats::foreign::Foreign;
use formats::named_columns::TableOutline;
use formats::observation::{Reading, read};
use formats::recording::RecordingBytes;
use formats::time_base::is_since_1970;
use offline::{InputError, Usage};

use super::names::name_of;
use crate::recordings::table_rows;

/// Bytes at the begin of MCAP files.
const MCAP: &[u8] = b"\x89MCAP0\r\n";
/// Limits of a source whose place is not known.
const ANYWHERE: &str = "# Its place is not known, so its range is not checked.\n[source.limits]\nrange_m = 2000000.0\n";
/// Bytes at the begin of files of gzip.
const GZIP: &[u8] = b"\x1f\x8b\x08";
/// Longest unpacked file, octets.
const UNPACKED_MAX: u64 = 4 << 30;
/// Greatest number of senders in a recording, each of which is a source.
const SENDERS_MAX: usize = 16;

/// A file or feed, judged.
#[derive(Debug)]
pub(super) struct Opened {
    /// Begin of the names of its sources.
    pub(super) label: String,
    pub(super) input: OpenedInput,
    pub(super) sources: Vec<SourceText>,
    /// What was decided, each with its reason.
    pub(super) decisions: Vec<String>,
    /// First position in the data, latitude and longitude, degrees.
    pub(super) first_deg: Option<[f64; 2]>,
    /// First time with a date in the data, UTC, nanoseconds since 1970.
    pub(super) first_utc_ns: Option<i64>,
    /// Whether positions are in metres of a frame without a place.
    pub(super) is_in_metres: bool,
}

/// Where the data come from.
#[derive(Debug)]
pub(super) enum OpenedInput {
    File(PathBuf),
    /// Keys of a receiver.
    Feed(String),
}

/// A source of the configuration.
#[derive(Debug, Default)]
pub(super) struct SourceText {
    /// End of its name.
    pub(super) suffix: String,
    /// Keys of the source, lines.
    pub(super) keys: String,
    /// Keys of its input, lines.
    pub(super) input_keys: String,
    /// Tables below the source.
    pub(super) tables: String,
}

impl Opened {
    /// Whether the data are recorded.
    pub(super) fn is_recorded(&self) -> bool {
        matches!(self.input, OpenedInput::File(_))
    }
}

/// Whether a path is a recording of all topics: a folder, or an MCAP file.
pub(super) fn is_recording(path: &Path) -> bool {
    let begins = |path: &Path| {
        let mut begin = [0; MCAP.len()];
        let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut begin));
        read.is_ok() && begin == MCAP
    };
    path.is_dir() || begins(path)
}

/// Judges a file; `place_deg` is the place of its sensor, latitude and longitude, degrees, where stated. A compressed
/// file is unpacked into `folder`.
///
/// # Errors
/// If the file cannot be read or is of no kind that is read; the error names the kind and the remedy.
pub(super) fn file(path: &Path, place_deg: Option<[f64; 2]>, folder: &Path) -> anyhow::Result<Opened> {
    let bytes = offline::read(path)?;
    if bytes.starts_with(GZIP) {
        return unpacked(path, &bytes, place_deg, folder);
    }
    let recording = RecordingBytes::new(&bytes);
    let survey = recording.survey();
    let foreign = survey.foreign(&bytes);
    let has_another_edition = || survey.categories.values().any(|category| category.better().is_some());
    if foreign.is_none() && (survey.records() > 0 || has_another_edition()) {
        return asterix(path, &bytes, place_deg);
    }
    // A capture of a feed has no block of ASTERIX.
    let kind = match Container::detect(&bytes) {
        Container::Pcap | Container::PcapNg => {
            let content: Vec<u8> = datagrams(&bytes)
                .flatten()
                .flat_map(|datagram| datagram.bytes.to_vec())
                .collect();
            Foreign::of(&content)
        }
        // Lines of hexadecimal digits may be frames.
        _ => foreign.or_else(|| Foreign::of(&bytes)),
    };
    let candidates = kind.map(feeds_of).unwrap_or_default();
    let judged = candidates.iter().map(|format| feed(path, &bytes, *format, place_deg));
    let best = judged.max_by_key(|(_, survey)| survey.counts.records);
    let refused = match best {
        Some((opened, survey)) if survey.counts.records > 0 => return Ok(opened),
        Some((_, survey)) => survey.refused,
        None => None,
    };
    if kind == Some(Foreign::Csv) {
        return table(path, &bytes);
    }
    let what = match kind {
        Some(kind) if refused.is_some() => {
            let formats: Vec<&str> = candidates.iter().map(|format| format.word()).collect();
            let (formats, refused) = (formats.join(", "), refused.unwrap_or_default());
            format!("{kind}; as {formats}, nothing in it can be read: {refused}")
        }
        Some(kind) => format!("{kind}; `koseki open --help` lists what is read"),
        None => "of no kind that is known here; `koseki open --help` lists what is read".to_owned(),
    };
    Err(InputError::new(path, what).into())
}

/// Unpacks a file of gzip, and judges the content.
fn unpacked(path: &Path, bytes: &[u8], place_deg: Option<[f64; 2]>, folder: &Path) -> anyhow::Result<Opened> {
    let mut content = Vec::new();
    let mut reader = MultiGzDecoder::new(bytes).take(UNPACKED_MAX + 1);
    let read = reader
        .read_to_end(&mut content)
        .map_err(|error| format!("cannot be unpacked: {error}"));
    read.map_err(|what| InputError::new(path, what))?;
    if content.len() as u64 > UNPACKED_MAX {
        return Err(InputError::new(path, format!("is more than {UNPACKED_MAX} octets unpacked: unpack it")).into());
    }
    std::fs::create_dir_all(folder)?;
    let unpacked = folder.join(path.file_stem().unwrap_or(path.as_os_str()));
    std::fs::write(&unpacked, &content)?;
    let mut opened = file(&unpacked, place_deg, folder)?;
    opened
        .decisions
        .insert(0, format!("compressed by gzip: unpacked to {}", unpacked.display()));
    Ok(opened)
}

/// Formats of feeds that a kind of file may hold, the likeliest first.
pub(super) fn feeds_of(kind: Foreign) -> &'static [FeedFormat] {
    match kind {
        Foreign::Sbs => &[FeedFormat::Sbs],
        Foreign::Beast | Foreign::ModeS | Foreign::Hex => &[FeedFormat::ModeS],
        Foreign::Ais => &[FeedFormat::Ais],
        Foreign::Json => &[FeedFormat::Readsb, FeedFormat::ModeS, FeedFormat::RemoteId],
        Foreign::Xml => &[FeedFormat::Cot],
        Foreign::Csv | Foreign::Text => &[FeedFormat::ModeS, FeedFormat::Ais],
        _ => &[],
    }
}

/// Judges a file as the recording of a feed.
fn feed(path: &Path, bytes: &[u8], format: FeedFormat, place_deg: Option<[f64; 2]>) -> (Opened, FeedSurvey) {
    let mut first_deg = None;
    let mut positions = 0_u64;
    let survey = adapter::survey_feed(bytes, format, (place_deg, None), &mut |report| {
        positions += 1;
        first_deg = first_deg.or(report.geodetic.map(|position| position.map(f64::to_degrees)));
    });
    let counts = survey.counts;
    let received_ns = datagrams(bytes)
        .flatten()
        .find_map(|datagram| match datagram.time_stamp {
            Some(TimeStamp::Utc { ns }) => Some(ns),
            _ => None,
        });
    let mut decisions = vec![format!(
        "format \"{}\": {} of {} transmissions can be read, with {positions} positions",
        format.word(),
        counts.records,
        counts.records + counts.refused
    )];
    if format == FeedFormat::ModeS && place_deg.is_none() {
        decisions.push("positions on the ground need the receiver's place: --place".to_owned());
    }
    if counts.timed == 0 && received_ns.is_none() && counts.records > 0 {
        decisions
            .push("nothing has a time: all reports are of one moment; record the data with their times".to_owned());
    }
    let label = name_of(&path.display().to_string());
    let source = feed_source(format, place_deg);
    let opened = Opened {
        label,
        input: OpenedInput::File(path.to_owned()),
        sources: vec![SourceText {
            input_keys: format!("format = \"{}\"\n", format.word()),
            ..source
        }],
        decisions,
        first_deg,
        first_utc_ns: survey.first_utc_ns.or(received_ns),
        is_in_metres: false,
    };
    (opened, survey)
}

/// The source of a feed.
pub(super) fn feed_source(format: FeedFormat, place_deg: Option<[f64; 2]>) -> SourceText {
    SourceText {
        keys: period(format).to_owned(),
        tables: place_deg.map_or_else(|| ANYWHERE.to_owned(), place),
        ..SourceText::default()
    }
}

/// Time between two reports of a target, by format: ships at anchor report every three minutes, under way every ten
/// seconds.
fn period(format: FeedFormat) -> &'static str {
    match format {
        FeedFormat::Ais => "period_s = 10.0\nsilent_periods = 0\n",
        FeedFormat::Cot => "period_s = 5.0\nsilent_periods = 0\n",
        FeedFormat::Sbs | FeedFormat::ModeS | FeedFormat::Readsb | FeedFormat::RemoteId => "silent_periods = 0\n",
    }
}

fn place([latitude, longitude]: [f64; 2]) -> String {
    format!("[source.place]\nlatitude_deg = {latitude:?}\nlongitude_deg = {longitude:?}\n")
}

/// Judges a table of tracks: in metres (FM-5), or of named columns.
fn table(path: &Path, bytes: &[u8]) -> anyhow::Result<Opened> {
    let unusable = |error| InputError::new(path, error);
    let outline = TableOutline::of(bytes).map_err(unusable)?;
    let mut decisions = Vec::new();
    match &outline {
        Some(outline) => {
            let (time, sigma_m) = (outline.time_column, outline.assumed_sigma_m());
            decisions.push(format!(
                "a table of named columns, the time in \"{time}\"; positions without sigma_m have a standard deviation \
                 of {sigma_m} m"
            ));
            if !outline.ignored.is_empty() {
                decisions.push(format!("columns that are not read: {}", outline.ignored.join(", ")));
            }
        }
        None => decisions.push("a table of sensor tracks in metres (FM-5)".to_owned()),
    }
    let is_in_metres = outline.is_none();
    let place = outline.and_then(|outline| outline.first_place).map(|(place, _)| place);
    let first = table_rows(bytes).map_err(unusable)?.flatten().next();
    let first_ns = first.map(|track| track.time_of_measurement_ns);
    // Ships under way report every ten seconds. The rhythm of each target is learned.
    let is_ship = first.is_some_and(|track| track.identity.mmsi().is_some());
    let period_s = if is_ship { 10.0 } else { 4.0 };
    Ok(Opened {
        label: name_of(&path.display().to_string()),
        input: OpenedInput::File(path.to_owned()),
        sources: vec![SourceText {
            keys: format!("period_s = {period_s:.1}\n"),
            input_keys: "format = \"sensor-tracks\"\n".to_owned(),
            tables: ANYWHERE.to_owned(),
            ..SourceText::default()
        }],
        decisions,
        first_deg: place.map(|place| [place.latitude_deg(), place.longitude_deg()]),
        is_in_metres,
        first_utc_ns: first_ns.filter(|first_ns| is_since_1970(*first_ns)),
    })
}

/// Target reports of one sender.
#[derive(Debug, Default)]
struct Sender {
    reports: u64,
    /// Reports whose position is relative to the sensor.
    relative: u64,
    categories: BTreeMap<u8, u64>,
}

/// Judges a recording of ASTERIX: each sender is a source.
fn asterix(path: &Path, bytes: &[u8], place_deg: Option<[f64; 2]>) -> anyhow::Result<Opened> {
    let (editions, mut decisions) = editions(bytes);
    let chosen: Vec<_> = editions
        .iter()
        .filter_map(|(category, edition)| asterix::registry::find(*category, *edition))
        .map(asterix::choice::ChosenEdition::Category)
        .collect();
    let recording = RecordingBytes::new(bytes).with_editions(&chosen);
    let survey = recording.survey();
    let mut senders: BTreeMap<Option<(u8, u8)>, Sender> = BTreeMap::new();
    let (mut first_deg, mut first_utc_ns) = (None, None);
    recording.for_each(&survey, |found| {
        if let Some(TimeStamp::Utc { ns }) = found.time_stamp {
            first_utc_ns.get_or_insert(ns);
        }
        if let Reading::Target(report) = read(found.record) {
            let sender = senders.entry(report.sac_sic).or_default();
            sender.reports += 1;
            *sender.categories.entry(found.record.table().number).or_default() += 1;
            match report.geodetic {
                Some(position) => drop(first_deg.get_or_insert(position.map(f64::to_degrees))),
                None => sender.relative += 1,
            }
        }
        Ok::<(), std::convert::Infallible>(())
    })?;
    let of_all: u64 = senders.values().map(|sender| sender.reports).sum();
    if of_all == 0 {
        return Err(InputError::new(path, "has records of ASTERIX and no target report").into());
    }
    // Records without an identity are of the sender before.
    senders.retain(|identity, _| identity.is_some());
    if senders.is_empty() {
        senders.insert(
            None,
            Sender {
                reports: of_all,
                ..Sender::default()
            },
        );
    }
    if senders.len() > SENDERS_MAX {
        let what = format!(
            "has {} senders, more than {SENDERS_MAX}: write a configuration",
            senders.len()
        );
        return Err(InputError::new(path, what).into());
    }
    let relative: Vec<_> = senders
        .iter()
        .filter(|(_, sender)| sender.relative > 0)
        .map(|(identity, _)| *identity)
        .collect();
    if !relative.is_empty() && place_deg.is_none() {
        let names: Vec<String> = relative.iter().map(|identity| named(*identity)).collect();
        return Err(Usage(format!(
            "{}: positions of {} are relative to the sensor: give its place, --place LATITUDE,LONGITUDE",
            path.display(),
            names.join(", ")
        ))
        .into());
    }
    if relative.len() > 1 {
        decisions.push(format!(
            "{} sensors stand at --place; if they stand apart, give each its [source.place] in the configuration",
            relative.len()
        ));
    }
    decisions.push(format!(
        "ASTERIX, {} target reports of {} senders: {}",
        of_all,
        senders.len(),
        senders
            .keys()
            .map(|identity| named(*identity))
            .collect::<Vec<_>>()
            .join(", ")
    ));
    let sources = senders
        .iter()
        .map(|(identity, sender)| source(*identity, sender, &editions, place_deg));
    Ok(Opened {
        label: name_of(&path.display().to_string()),
        input: OpenedInput::File(path.to_owned()),
        sources: sources.collect(),
        decisions,
        first_deg,
        first_utc_ns,
        is_in_metres: false,
    })
}

fn named(identity: Option<(u8, u8)>) -> String {
    identity.map_or_else(|| "an unnamed sender".to_owned(), |(sac, sic)| format!("{sac}/{sic}"))
}

fn source(
    identity: Option<(u8, u8)>,
    sender: &Sender,
    editions: &BTreeMap<u8, Edition>,
    place_deg: Option<[f64; 2]>,
) -> SourceText {
    let mut input_keys = "truncated = \"accept\"\n".to_owned();
    if let Some((sac, sic)) = identity {
        let _ = write!(input_keys, "sac = {sac}\nsic = {sic}\n");
    }
    let stated: Vec<String> = editions
        .iter()
        .map(|(category, edition)| format!("\"{category}\" = \"{edition}\""))
        .collect();
    if !stated.is_empty() {
        let _ = writeln!(input_keys, "editions = {{ {} }}", stated.join(", "));
    }
    let most = sender.categories.iter().max_by_key(|(_, count)| **count);
    SourceText {
        suffix: identity.map(|(sac, sic)| format!("{sac}-{sic}")).unwrap_or_default(),
        // A radar's turn takes seconds; the period of a target is learned.
        keys: match most {
            Some((1 | 48 | 62, _)) => "period_s = 4.0\n".to_owned(),
            _ => String::new(),
        },
        input_keys,
        tables: match place_deg.filter(|_| sender.relative > 0) {
            Some(place_deg) => place(place_deg),
            None => ANYWHERE.to_owned(),
        },
    }
}

/// Returns the edition of each category that the blocks fit best.
fn editions(bytes: &[u8]) -> (BTreeMap<u8, Edition>, Vec<String>) {
    let survey = RecordingBytes::new(bytes).survey();
    let (mut editions, mut decisions) = (BTreeMap::new(), Vec::new());
    for (number, category) in &survey.categories {
        let Some(edition) = category.edition else {
            decisions.push(format!("category {number:03} has no table here: left out"));
            continue;
        };
        let better = category.better().filter(|_| category.is_withheld());
        let (edition, why) = match better.and_then(|(editions, fitting)| Some((*editions.first()?, fitting))) {
            Some((better, fitting)) => {
                let why = format!(
                    "fits {fitting} of {} blocks that edition {edition} does not",
                    category.blocks_refused
                );
                (better, why)
            }
            None => {
                let fitting = category.blocks - category.blocks_refused;
                (edition, format!("fits {fitting} of {} blocks", category.blocks))
            }
        };
        decisions.push(format!("category {number:03}, edition {edition}: {why}"));
        editions.insert(*number, edition);
    }
    (editions, decisions)
}

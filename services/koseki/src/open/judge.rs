//! What a file is, by its bytes.

use std::cmp::Reverse;
use std::io::Read as _;
use std::path::Path;

use adapter::FeedSurvey;
use deployment::FeedFormat;
use flate2::read::MultiGzDecoder;
use formats::containers::{Container, TimeStamp, datagrams};
use formats::foreign::Foreign;
use formats::named_columns::TableOutline;
use formats::recording::RecordingBytes;
use formats::time_base::is_since_1970;
use offline::InputError;

use super::asterix;
use super::names::name_of;
use super::opened::{ANYWHERE, Opened, OpenedInput, SourceText, place};
use crate::recordings::table_rows;

/// Bytes at the begin of MCAP files.
const MCAP: &[u8] = b"\x89MCAP0\r\n";
/// Accuracy of a ship's radar.
const RADAR_ACCURACY: &str = "# Range and bearing of the standard for ships' radars, seen from the ship.\n[source.covariance]\nfrom = \"report\"\n";
/// Bytes at the begin of files of gzip.
const GZIP: &[u8] = b"\x1f\x8b\x08";
/// Longest unpacked file, octets.
const UNPACKED_MAX: u64 = 4 << 30;

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
        return asterix::judged(path, &bytes, place_deg);
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
    let (mut read, unread): (Vec<_>, Vec<_>) = judged.partition(|found| found.survey.counts.records > 0);
    read.sort_by_key(|found| Reverse(found.survey.counts.records));
    if !read.is_empty() {
        return Ok(joined(read));
    }
    let refused = unread.into_iter().find_map(|found| found.survey.refused);
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
        Foreign::Ais => &[FeedFormat::Ais, FeedFormat::RadarTargets],
        Foreign::Nmea => &[FeedFormat::RadarTargets],
        Foreign::Json => &[FeedFormat::Readsb, FeedFormat::ModeS, FeedFormat::RemoteId],
        Foreign::Xml => &[FeedFormat::Cot],
        Foreign::Csv | Foreign::Text => &[FeedFormat::ModeS, FeedFormat::Ais, FeedFormat::RadarTargets],
        _ => &[],
    }
}

/// A file as the recording of a feed.
struct JudgedFeed {
    format: FeedFormat,
    opened: Opened,
    survey: FeedSurvey,
}

/// Joins the formats of one file, the likeliest first: receivers at sea write the sentences of AIS and of a radar into
/// the same file, and each is a source. Of other formats, the first is the file's.
fn joined(read: Vec<JudgedFeed>) -> Opened {
    let is_of_ship = |found: &JudgedFeed| matches!(found.format, FeedFormat::Ais | FeedFormat::RadarTargets);
    let are_of_ship = read.len() > 1 && read.iter().all(is_of_ship);
    let joined = read.into_iter().map(|mut found| {
        if are_of_ship {
            found.opened.sources[0].suffix = found.format.word().to_owned();
        }
        found.opened
    });
    let joined = joined.reduce(|mut first, further| {
        if are_of_ship {
            first.sources.extend(further.sources);
            first.decisions.extend(further.decisions);
            first.first_deg = first.first_deg.or(further.first_deg);
            first.first_utc_ns = first.first_utc_ns.or(further.first_utc_ns);
        }
        first
    });
    joined.expect("a file is judged as at least one format")
}

/// Judges a file as the recording of a feed.
fn feed(path: &Path, bytes: &[u8], format: FeedFormat, place_deg: Option<[f64; 2]>) -> JudgedFeed {
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
    if survey.stations > 0 {
        decisions.push(format!(
            "{} base stations and aids to navigation: shown, not tracked",
            survey.stations
        ));
    }
    if let Some(refused) = survey.refused.as_ref().filter(|_| format == FeedFormat::RadarTargets) {
        decisions.push(format!("refused last: {refused}"));
    }
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
        first_deg: first_deg.or(survey.station_deg),
        first_utc_ns: survey.first_utc_ns.or(received_ns),
        is_in_metres: false,
    };
    JudgedFeed { format, opened, survey }
}

/// The source of a feed.
pub(super) fn feed_source(format: FeedFormat, place_deg: Option<[f64; 2]>) -> SourceText {
    SourceText {
        keys: period(format).to_owned(),
        tables: place_deg.map_or_else(|| ANYWHERE.to_owned(), place) + covariance(format),
        ..SourceText::default()
    }
}

/// Time between two reports of a target, by format: ships at anchor report every three minutes, under way every ten
/// seconds.
fn period(format: FeedFormat) -> &'static str {
    match format {
        FeedFormat::Ais => "period_s = 10.0\nsilent_periods = 0\n",
        // A turn of a ship's antenna.
        FeedFormat::RadarTargets => "period_s = 2.5\nsilent_periods = 0\n",
        FeedFormat::Cot => "period_s = 5.0\nsilent_periods = 0\n",
        FeedFormat::Sbs | FeedFormat::ModeS | FeedFormat::Readsb | FeedFormat::RemoteId => "silent_periods = 0\n",
    }
}

/// Accuracy of a feed whose targets state their own: as stated, down to what clocks and steps of the format permit.
fn covariance(format: FeedFormat) -> &'static str {
    match format {
        FeedFormat::ModeS | FeedFormat::Readsb | FeedFormat::RemoteId => {
            "[source.covariance]\nfrom = \"report\"\nposition_sigma_m = 1.0\nunstated_position_sigma_m = \
             30.0\nvelocity_sigma_mps = 0.5\nunstated_velocity_sigma_mps = 5.0\n"
        }
        FeedFormat::Ais => {
            "[source.covariance]\nfrom = \"report\"\nposition_sigma_m = 1.0\nvelocity_sigma_mps = \
             0.05\nunstated_velocity_sigma_mps = 1.0\n"
        }
        FeedFormat::Cot => {
            "[source.covariance]\nfrom = \"report\"\nposition_sigma_m = 1.0\nunstated_position_sigma_m = 30.0\n"
        }
        FeedFormat::RadarTargets => RADAR_ACCURACY,
        FeedFormat::Sbs => "",
    }
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

//! `koseki open`: files and feeds into a picture, without a configuration.
//!
//! 1. Each file is judged by its bytes, each feed by the first seconds ([`judge`], [`feeds`]): format, editions, first
//!    position, date.
//! 2. The configuration is written from the results ([`text`]), and kept.
//! 3. Files are fused as fast as possible and shown from the recording; feeds are fused and shown live.
//!
//! Nothing is guessed in silence: each decision is printed with its reason, and what the data cannot tell is asked for.

mod asterix;
mod feeds;
mod judge;
mod names;
mod opened;
mod text;

use std::fs;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use anyhow::Context as _;
use bus::Root;
use offline::Usage;
use runtime::{Now, Options, Speed};

use crate::args::{self, OpenArgs};
use crate::config::Config;
use crate::recordings::{self, Depth};
use crate::{launch, replay};

use opened::Opened;
use text::ConfigText;

/// Name of the configuration in the folder of the run.
const FILE: &str = "open.toml";
/// Ports at which the picture is shown: the first that is free.
const PORTS: std::ops::Range<u16> = 8900..8990;

/// Opens files and feeds.
///
/// # Errors
/// If a file or feed is of no kind that is read, a fact is missing, or the run fails.
pub(crate) fn run(open: &OpenArgs) -> anyhow::Result<()> {
    if let [only] = &open.what[..]
        && judge::is_recording(Path::new(only))
    {
        decide(&format!(
            "{only}: a recording of all topics (MCAP): it is shown as it was"
        ));
        return show(Path::new(only), open);
    }
    let place_deg = open.place.as_deref().map(place).transpose()?;
    let name = free_name(&names::name_of(&open.what[0]))?;
    let folder = open.out.clone().unwrap_or_else(|| args::out_folder(None, &name));
    let mut opened = Vec::new();
    for what in &open.what {
        let found = match feeds::address(what) {
            Some(address) => feeds::open(&address?, place_deg)?,
            None => judge::file(Path::new(what), place_deg, &folder)?,
        };
        found
            .decisions
            .iter()
            .for_each(|decision| decide(&format!("{what}: {decision}")));
        opened.push(found);
    }
    let is_recorded = opened.iter().all(Opened::is_recorded);
    if !is_recorded && opened.iter().any(Opened::is_recorded) {
        return Err(Usage("files and feeds are of different times: open them one after the other".to_owned()).into());
    }
    let config = ConfigText {
        name: &name,
        place_deg: origin(place_deg, &opened)?,
        date: if is_recorded { Some(date(open, &opened)?) } else { None },
        listen: (!is_recorded && !open.no_display).then(free_port),
        opened: &opened,
    };
    let path = keep(&config.text(), &folder)?;
    decide(&format!("configuration: {}", path.display()));
    if open.dry_run {
        return Ok(());
    }
    let config = Config::read(&path, &[])?;
    let options = Options {
        overrides: Vec::new(),
        data: PathBuf::from("."),
        out: folder.clone(),
        speed: if is_recorded { Speed::Max } else { Speed::Factor(1.0) },
        seed: 1,
        scenario_start_ns: Now::read().utc_ns,
        launcher: None,
        instance: name,
    };
    for found in recordings::inspect(&config, &options.data, Depth::Blocks)? {
        for doubt in &found.doubts {
            decide(&format!("{}: {doubt}", found.file.display()));
        }
    }
    launch(&config, options, open.seconds, false)?;
    if is_recorded && !open.no_display {
        return show(&folder.join("latest"), open);
    }
    Ok(())
}

/// The name, or the first of `NAME-2`, `NAME-3`, … that no running instance has: several feeds may be open at a time.
fn free_name(name: &str) -> anyhow::Result<String> {
    let (mut candidate, mut number) = (name.to_owned(), 1);
    while Root::new(&candidate)?.holder()?.is_some() {
        number += 1;
        candidate = format!("{name}-{number}");
    }
    Ok(candidate)
}

/// Prints a decision.
fn decide(text: &str) {
    runtime::notice(format_args!("koseki: {text}"));
}

/// Shows a recording.
fn show(recording: &Path, open: &OpenArgs) -> anyhow::Result<()> {
    if open.no_display || open.dry_run {
        return Ok(());
    }
    let settings = display::Settings::unconfigured(None).map_err(|error| Usage(error.what))?;
    replay::show(recording, settings, None)
}

/// Reads a place.
fn place(text: &str) -> Result<[f64; 2], Usage> {
    let refused = || {
        Usage(format!(
            "--place: \"{text}\" is no latitude and longitude in degrees, as in 41.297,2.078"
        ))
    };
    let (latitude, longitude) = text.split_once(',').ok_or_else(refused)?;
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| refused());
    let place = [number(latitude)?, number(longitude)?];
    let is_place = (-90.0..=90.0).contains(&place[0]) && (-180.0..=180.0).contains(&place[1]);
    if is_place { Ok(place) } else { Err(refused()) }
}

/// Returns the origin of the system frame: the stated place, else the first position of the data.
fn origin(stated: Option<[f64; 2]>, opened: &[Opened]) -> Result<[f64; 2], Usage> {
    if let Some(place) = stated {
        decide("origin of the frame: the place of --place");
        return Ok(place);
    }
    if opened.iter().all(|found| found.is_in_metres) {
        decide("origin of the frame: latitude 0, longitude 0, since the data are metres of no stated place (--place)");
        return Ok([0.0; 2]);
    }
    let first = opened.iter().find_map(|found| found.first_deg);
    let [latitude, longitude] = first.ok_or_else(|| {
        Usage(
            "the data state no position in degrees: give the place of the sensor, --place LATITUDE,LONGITUDE"
                .to_owned(),
        )
    })?;
    // A tenth of a degree: the same origin for recordings of one place.
    let rounded = [latitude, longitude].map(|degrees| (degrees * 10.0).round() / 10.0);
    let [latitude, longitude] = rounded;
    decide(&format!(
        "origin of the frame: {latitude}, {longitude}, the first position to a tenth of a degree (--place)"
    ));
    Ok(rounded)
}

/// Returns the first day of the recordings.
fn date(open: &OpenArgs, opened: &[Opened]) -> Result<String, Usage> {
    if let Some(date) = &open.date {
        return Ok(date.clone());
    }
    if let Some(stated_ns) = opened.iter().filter_map(|found| found.first_utc_ns).min() {
        let date = names::date(stated_ns);
        decide(&format!("first day: {date}, as the data state (--date)"));
        return Ok(date);
    }
    let written = fs::metadata(&open.what[0]).and_then(|file| file.modified()).ok();
    let since_1970 = written.and_then(|written| written.duration_since(UNIX_EPOCH).ok());
    let written_ns = since_1970.and_then(|since| i64::try_from(since.as_nanos()).ok());
    let written_ns = written_ns.ok_or_else(|| {
        Usage("the data state no date: give the first day of the recording, --date YYYY-MM-DD".to_owned())
    })?;
    let date = names::date(written_ns);
    decide(&format!(
        "first day: {date}, the date of {}, since the data state none: --date sets another",
        open.what[0]
    ));
    Ok(date)
}

/// Returns the first free address for browsers.
fn free_port() -> String {
    let free = PORTS
        .into_iter()
        .find(|port| TcpListener::bind(("127.0.0.1", *port)).is_ok());
    format!("127.0.0.1:{}", free.unwrap_or(PORTS.start))
}

/// Writes the configuration into the folder of the run.
fn keep(text: &str, folder: &Path) -> anyhow::Result<PathBuf> {
    fs::create_dir_all(folder).with_context(|| format!("{} cannot be made", folder.display()))?;
    let path = folder.join(FILE);
    fs::write(&path, text).with_context(|| format!("{} cannot be written", path.display()))?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_two_numbers_in_range() {
        assert_eq!(place("41.297, 2.078").unwrap(), [41.297, 2.078]);
        assert_eq!(place("-33.9,151.2").unwrap(), [-33.9, 151.2]);
        for wrong in ["", "41", "41;2", "91,0", "0,181", "north,east", "NaN,1"] {
            let refused = place(wrong).unwrap_err().to_string();
            assert!(refused.contains(wrong) && refused.contains("41.297,2.078"), "{refused}");
        }
    }
}

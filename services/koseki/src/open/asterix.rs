//! Judges recordings of ASTERIX: editions, senders, places.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use asterix::Edition;
use formats::containers::TimeStamp;
use formats::observation::{FinderReport, FinderReportKind, Reading, finder_report, read};
use formats::recording::RecordingBytes;
use offline::{InputError, Usage};

use super::names::name_of;
use super::opened::{ANYWHERE, Opened, OpenedInput, SourceText, place};

/// Greatest number of senders in a recording, each of which is a source.
const SENDERS_MAX: usize = 16;

/// Target reports of one sender.
#[derive(Debug, Default)]
struct Sender {
    reports: u64,
    /// Reports whose position is relative to the sensor.
    relative: u64,
    categories: BTreeMap<u8, u64>,
}

/// Judges a recording of ASTERIX: each sender is a source.
pub(super) fn judged(path: &Path, bytes: &[u8], place_deg: Option<[f64; 2]>) -> anyhow::Result<Opened> {
    let (editions, mut decisions) = editions(bytes);
    let chosen: Vec<_> = editions
        .iter()
        .filter_map(|(category, edition)| asterix::registry::find(*category, *edition))
        .map(asterix::choice::ChosenEdition::Category)
        .collect();
    let recording = RecordingBytes::new(bytes).with_editions(&chosen);
    let survey = recording.survey();
    let mut senders: BTreeMap<Option<(u8, u8)>, Sender> = BTreeMap::new();
    let mut finders = Finders::default();
    let (mut first_deg, mut first_utc_ns) = (None, None);
    recording.for_each(&survey, |found| {
        if let Some(TimeStamp::Utc { ns }) = found.time_stamp {
            first_utc_ns.get_or_insert(ns);
        }
        if let Some(report) = finder_report(found.record) {
            finders.take(&report);
            if let Some(position) = report.geodetic {
                first_deg.get_or_insert(position.map(f64::to_degrees));
            }
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
    if of_all == 0 && finders.reports == 0 {
        return Err(InputError::new(path, "has records of ASTERIX and no target report").into());
    }
    // Records without an identity are of the sender before.
    senders.retain(|identity, _| identity.is_some());
    if senders.is_empty() && of_all > 0 {
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
    if finders.unplaced > 0 && place_deg.is_none() {
        let what = format!(
            "{}: direction finders of {} reports state no position: give the place, --place LATITUDE,LONGITUDE",
            path.display(),
            finders.unplaced
        );
        return Err(Usage(what).into());
    }
    if finders.reports > 0 {
        decisions.push(finders.decision());
    }
    if of_all > 0 {
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
    }
    let sources = senders
        .iter()
        .map(|(identity, sender)| source(*identity, sender, &editions, place_deg))
        .chain((finders.reports > 0).then(|| finders.source(&editions, place_deg)));
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

/// Reports of direction finders, whatever their senders: an emitter is located from all of them.
#[derive(Debug, Default)]
struct Finders {
    reports: u64,
    /// Reports that need a place from elsewhere.
    unplaced: u64,
    senders: BTreeSet<Option<(u8, u8)>>,
}

impl Finders {
    fn take(&mut self, report: &FinderReport) {
        if matches!(report.kind, FinderReportKind::End | FinderReportKind::Conflict) {
            return;
        }
        self.reports += 1;
        self.unplaced += u64::from(report.geodetic.is_none());
        self.senders.insert(report.sac_sic);
    }

    fn decision(&self) -> String {
        let names: Vec<String> = self.senders.iter().map(|sender| named(*sender)).collect();
        format!(
            "ASTERIX, {} reports of direction finders (category 205) of {}: emitters are located from all of them, with an \
             assumed standard deviation of 2° ([source.locator] bearing_sigma_deg)",
            self.reports,
            names.join(", ")
        )
    }

    fn source(&self, editions: &BTreeMap<u8, Edition>, place_deg: Option<[f64; 2]>) -> SourceText {
        let place = place_deg.map_or_else(|| ANYWHERE.to_owned(), place);
        SourceText {
            suffix: "finders".to_owned(),
            keys: "period_s = 1.0\n".to_owned(),
            input_keys: format!("truncated = \"accept\"\n{}", stated(editions)),
            tables: format!("{place}[source.locator]\n"),
        }
    }
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
    input_keys.push_str(&stated(editions));
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

/// The key of the editions.
fn stated(editions: &BTreeMap<u8, Edition>) -> String {
    let stated: Vec<String> = editions
        .iter()
        .map(|(category, edition)| format!("\"{category}\" = \"{edition}\""))
        .collect();
    match stated.is_empty() {
        true => String::new(),
        false => format!("editions = {{ {} }}\n", stated.join(", ")),
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

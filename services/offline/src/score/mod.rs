//! `koseki score`: quality of tracks or fixes against a known truth (FM-8).
//!
//! The crate `scoring` defines the figures. This module opens files and prints the figures: a line each with the
//! meaning, or a JSON object with the same names. A scorecard follows: [`card`] has the scorecard as text and JSON,
//! [`html`] as a page.

mod alerts;
mod areas;
mod card;
mod chart;
mod html;
mod pictures;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use csv_table::CsvError;
use scoring::{
    CardReference, CardSettings, CaseSettings, Compared, ConfirmedTracks, FIX_WORDS, FileBasis, FixInputError, FixRuns,
    PICTURE_WORDS, PhaseLimits, PictureError, PictureSettings, RESOLUTION_WORDS, ResolutionScore, ResolutionSettings,
    Scorecard, ScoredArea, TargetsByTime, Timeline, score_card, surveillance_standard,
};

use crate::files::{InputError, Usage};
use crate::host::{Host, TableOutput};
use crate::printed::{digits, figures_text, show};
use crate::score_args::{Score, ScoreFixes, ScoreTracks, ScoreWhat};

/// Files beside the truth of a scripted case.
const SETTINGS_FILE: &str = "meta.json";

/// Scores the inputs and prints the figures.
///
/// # Errors
/// If a file cannot be read, or there is nothing to compare.
pub(crate) fn run(score: &Score, host: &dyn Host) -> anyhow::Result<()> {
    match &score.what {
        None => picture(score, host),
        Some(ScoreWhat::Tracks(tracks)) => resolution(tracks, host),
        Some(ScoreWhat::Fixes(fixes)) => self::fixes(fixes, host),
        Some(ScoreWhat::Alerts(asked)) => alerts::run(asked, host),
    }
}

fn picture(score: &Score, host: &dyn Host) -> anyhow::Result<()> {
    let (Some(truth_file), Some(tracks_file)) = (&score.truth, &score.tracks) else {
        return Err(Usage("score needs --truth and --tracks (see `koseki score --help`)".to_owned()).into());
    };
    let basis = score.card.origin.map(FileBasis::at).unwrap_or_default();
    let tracks = Timeline::tracks_on(basis, host.open(tracks_file)?, score.max_age)
        .map_err(|error| InputError::new(tracks_file, error))?;
    let truth = truth_for(host, truth_file, score.card.reference, &tracks)?;
    let first_s = score.t0.or(truth.compared_from_s()).unwrap_or_default();
    let settings = PictureSettings {
        cut_off_m: score.c,
        age_max_s: score.max_age,
        first_s,
        last_s: score.t1,
        gate_m: score.gate,
        moving_mps: score.moving,
    };
    let found = scoring::score_picture(&truth, &tracks, &settings);
    let found = found.map_err(|error| InputError::new(truth_file, format!("{error}; see --t0 and --t1")))?;
    let areas = match (&score.card.areas, score.card.origin) {
        (Some(file), Some(origin)) => areas::read(host, file, origin)?,
        _ => Vec::new(),
    };
    let page = score.card.html.as_deref().map(|file| host.begin(file)).transpose()?;
    if let Some(period_s) = tracks.period_of_gaps_s() {
        host.say(&format!(
            "koseki: hint: the tracks have a state every {} s or so, which shows for {} s only (--max-age), so they are \
             missing in between; try --max-age {}, or tracks at even times (--refresh, --period)\n",
            digits(period_s),
            score.max_age,
            period_s.ceil()
        ));
    }
    let card = scorecard((score, first_s), &truth, &tracks, &areas);
    let card = card.map_err(|error| InputError::new(truth_file, error))?;
    if let Some(page) = page {
        write_page((score, &found.compared), page, &card, &areas)?;
    }
    if score.json {
        let found = card::ScoredPicture::new(&found, &card);
        return host.print(&format!("{}\n", serde_json::to_string(&found)?));
    }
    let figures = figures_text(&found, PICTURE_WORDS)?;
    host.print(&format!(
        "{}{figures}{}",
        compared_text(&found.compared),
        card::text(&card)
    ))
}

/// Reads the truth for tracks.
fn truth_for(
    host: &dyn Host,
    file: &Path,
    reference: CardReference,
    tracks: &Timeline,
) -> Result<Timeline, InputError> {
    let (basis, rows) = (tracks.basis(), host.open(file)?);
    let truth = match reference {
        CardReference::Truth => Timeline::truth_on(basis, rows),
        CardReference::Independent | CardReference::Smoothed => Timeline::reference_on(basis, rows),
    };
    let truth = truth.map_err(|error| InputError::new(file, with_remedy(&error)))?;
    truth
        .check_times(tracks)
        .map_err(|error| InputError::new(file, format!("{error}; both must count from the same midnight")))?;
    Ok(truth)
}

/// Returns the error of a truth file with a remedy for the file of an instrument.
fn with_remedy(error: &CsvError) -> String {
    match error {
        CsvError::Header { header, .. } if header.split(',').any(|name| name == "sensor_track_id") => {
            format!("{error}; these are tracks of a sensor, and --reference independent compares with an instrument")
        }
        _ => error.to_string(),
    }
}

/// Returns a description of the comparison, in lines that end with an empty line.
fn compared_text(compared: &Compared) -> String {
    let mut text = format!(
        "Compared: {} whole seconds from {} s to {} s, {} targets (target-seconds: {}), {} tracks (track-seconds: {}).\n",
        compared.seconds,
        compared.first_s,
        compared.last_s,
        compared.targets,
        compared.target_seconds,
        compared.tracks,
        compared.track_seconds,
    );
    let remarks = [
        (
            compared.seconds_without_truth,
            "seconds in between without a row of the truth are left out",
        ),
        (
            compared.truth_rows_between,
            "rows of the truth are not at a whole second and are left out",
        ),
        (
            compared.tracks_elsewhere,
            "tracks are not shown in these seconds and do not count",
        ),
        (
            compared.pairs_without_height,
            "pairs have no height on one side: the plane alone is compared",
        ),
        (
            compared.pairs_without_velocity,
            "pairs have no velocity on one side: the position alone is compared",
        ),
    ];
    for (count, remark) in remarks.into_iter().filter(|(count, _)| *count > 0) {
        text += &format!("{count} {remark}.\n");
    }
    text + "\n"
}

fn scorecard(
    (score, first_s): (&Score, i64),
    truth: &Timeline,
    tracks: &Timeline,
    areas: &[ScoredArea],
) -> Result<Scorecard, PictureError> {
    let asked = &score.card;
    let settings = CardSettings {
        first_s,
        last_s: score.t1,
        gate_m: score.gate,
        settle_s: asked.settle,
        limits: PhaseLimits {
            turning_mps2: asked.turning,
            climbing_mps2: asked.climbing,
        },
    };
    let standards: Vec<_> = asked
        .standard
        .iter()
        .filter_map(|word| surveillance_standard(word))
        .collect();
    score_card(truth, tracks, &settings, asked.reference, &standards, areas)
}

fn write_page(
    (score, compared): (&Score, &Compared),
    mut out: Box<dyn TableOutput>,
    card: &Scorecard,
    areas: &[ScoredArea],
) -> anyhow::Result<()> {
    let name = |file: &Option<PathBuf>| {
        file.as_ref()
            .map_or_else(String::new, |file| file.display().to_string())
    };
    let settings = format!(
        "{} whole seconds with truth from {} s to {} s; a target counts from {} s after its first row on. A track belongs to a target \
         nearer than {} m, and shows for {} s. Turns begin at {} m/s², changes of the climb rate at {} m/s².",
        compared.seconds,
        compared.first_s,
        compared.last_s,
        score.card.settle,
        score.gate,
        score.max_age,
        score.card.turning,
        score.card.climbing
    );
    let head = html::PageHead {
        truth: &name(&score.truth),
        tracks: &name(&score.tracks),
        settings: &settings,
    };
    out.write_all(html::page(&head, card, areas).as_bytes())
        .context("--html cannot be written")?;
    out.finish()
}

fn resolution(asked: &ScoreTracks, host: &dyn Host) -> anyhow::Result<()> {
    let settings = ResolutionSettings {
        gate_m: asked.gate,
        since_s: asked.since,
    };
    let mut runs = Vec::new();
    for (truth_file, tracks_file) in in_pairs(("--truth", &asked.truth), ("--tracks", &asked.tracks))? {
        let truth = TargetsByTime::read(host.open(truth_file)?).map_err(|error| InputError::new(truth_file, error))?;
        let tracks = ConfirmedTracks::read(host.open(tracks_file)?, &truth);
        let tracks = tracks.map_err(|error| InputError::new(tracks_file, error))?;
        let run = ResolutionScore::of_run(&truth, &tracks, &settings);
        runs.push(run.map_err(|error| InputError::new(truth_file, format!("{error}; give an earlier --since")))?);
    }
    match ResolutionScore::pooled(&runs) {
        Some(pooled) if runs.len() > 1 => show(host, &pooled, RESOLUTION_WORDS, asked.json),
        _ => show(host, &runs[0], RESOLUTION_WORDS, asked.json),
    }
}

fn fixes(asked: &ScoreFixes, host: &dyn Host) -> anyhow::Result<()> {
    let mut runs: Option<FixRuns> = None;
    for (truth_file, fixes_file) in in_pairs(("--truth", &asked.truth), ("--fixes", &asked.fixes))? {
        let settings_file = truth_file.with_file_name(SETTINGS_FILE);
        let settings = case_settings(host, &settings_file)?;
        let runs = runs.get_or_insert_with(|| FixRuns::new(settings));
        let added = runs.add(&settings, host.open(truth_file)?, host.open(fixes_file)?);
        added.map_err(|error| match error {
            FixInputError::Settings { .. } => InputError::new(&settings_file, error),
            FixInputError::Truth(error) => InputError::new(truth_file, error),
            FixInputError::Fixes(error) => InputError::new(fixes_file, error),
        })?;
    }
    let found = runs.map(|runs| runs.score()).transpose();
    match found.map_err(|error| InputError::new(&asked.fixes[0], error))? {
        Some(found) => show(host, &found, FIX_WORDS, asked.json),
        None => Ok(()),
    }
}

fn case_settings(host: &dyn Host, file: &Path) -> Result<CaseSettings, InputError> {
    let needed =
        "it describes the truth beside it: {\"case\": \"fixed\", \"baseline\": 1e4, \"sigma_deg\": 1, \"runs\": 1}";
    let text = host.text(file).map_err(|error| error.with(needed))?;
    serde_json::from_str(&text).map_err(|error| InputError::new(file, error).with(needed))
}

/// Pairs the files of each run.
fn in_pairs<'a>(
    (truth, truths): (&str, &'a [PathBuf]),
    (other, others): (&str, &'a [PathBuf]),
) -> Result<impl Iterator<Item = (&'a PathBuf, &'a PathBuf)>, Usage> {
    if truths.len() == others.len() {
        return Ok(truths.iter().zip(others));
    }
    Err(Usage(format!(
        "{truth} names {} files and {other} {}: give one of each for every run, in the same order",
        truths.len(),
        others.len()
    )))
}

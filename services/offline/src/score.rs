//! `koseki score`: quality of tracks or fixes against a known truth (FM-8).
//!
//! The crate `scoring` defines the figures. This module opens files and prints the figures: a line each with its
//! meaning, or one JSON object with the same names.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use scoring::{
    CaseSettings, ConfirmedTracks, FIX_WORDS, FixInputError, FixRuns, PICTURE_WORDS, PictureSettings, RESOLUTION_WORDS,
    ResolutionScore, ResolutionSettings, TargetsByTime, Timeline, Word,
};
use serde::Serialize;
use serde_json::Value;

use crate::args::{Score, ScoreFixes, ScoreTracks, ScoreWhat};
use crate::files::{InputError, Usage};
use crate::host::Host;

/// Files beside the truth of a scripted case.
const SETTINGS_FILE: &str = "meta.json";
/// Significant digits on the screen.
const DIGITS: usize = 4;

/// Scores the inputs and prints the figures.
///
/// # Errors
/// If a file cannot be read, or there is nothing to compare.
pub(crate) fn run(score: &Score, host: &dyn Host) -> anyhow::Result<()> {
    match &score.what {
        None => picture(score, host),
        Some(ScoreWhat::Tracks(tracks)) => resolution(tracks, host),
        Some(ScoreWhat::Fixes(fixes)) => self::fixes(fixes, host),
    }
}

fn picture(score: &Score, host: &dyn Host) -> anyhow::Result<()> {
    let (Some(truth_file), Some(tracks_file)) = (&score.truth, &score.tracks) else {
        return Err(Usage("score needs --truth and --tracks (see `koseki score --help`)".to_owned()).into());
    };
    let settings = PictureSettings {
        cut_off_m: score.c,
        age_max_s: score.max_age,
        first_s: score.t0,
        last_s: score.t1,
        gate_m: score.gate,
        moving_mps: score.moving,
    };
    let truth = Timeline::truth(host.open(truth_file)?).map_err(|error| InputError::new(truth_file, error))?;
    let tracks = Timeline::tracks(host.open(tracks_file)?, score.max_age)
        .map_err(|error| InputError::new(tracks_file, error))?;
    let found = scoring::score_picture(&truth, &tracks, &settings);
    let found = found.map_err(|error| InputError::new(truth_file, format!("{error}; see --t0 and --t1")))?;
    if let Some(period_s) = tracks.period_of_gaps_s() {
        host.say(&format!(
            "koseki: hint: the tracks have a state every {} s or so, which shows for {} s only (--max-age), so they are \
             missing in between; try --max-age {}, or tracks at even times (--refresh, --period)\n",
            digits(period_s),
            score.max_age,
            period_s.ceil()
        ));
    }
    show(host, &found, PICTURE_WORDS, score.json)
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
    let text = host.text(file).map_err(|error| {
        let needed = "it says which case the truth beside it is: {\"case\": \"turn\", \"baseline\": 1e4, …}";
        error.with(needed)
    })?;
    serde_json::from_str(&text).map_err(|error| InputError::new(file, error))
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

/// Prints the available figures named by `words`.
pub(crate) fn show(host: &dyn Host, found: &impl Serialize, words: &[Word], json: bool) -> anyhow::Result<()> {
    if json {
        return host.print(&format!("{}\n", serde_json::to_string(found)?));
    }
    let found = serde_json::to_value(found)?;
    let mut text = String::new();
    for word in words {
        let figure = match &found[word.name] {
            Value::Number(number) => match number.as_f64() {
                Some(value) if number.is_f64() => digits(value),
                _ => number.to_string(),
            },
            // The word belongs to another case.
            _ if found.get(word.name).is_none() => continue,
            _ => "-".to_owned(),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:<26} {figure:>9} {:<4} {}", word.name, word.unit, word.meaning);
    }
    host.print(&text)
}

/// Formats a number with the decimals required for its significant digits.
pub(crate) fn digits(value: f64) -> String {
    let magnitude = value.abs().log10().floor();
    let decimals = if magnitude.is_finite() {
        (DIGITS as f64 - 1.0 - magnitude).clamp(0.0, 12.0) as usize
    } else {
        0
    };
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits_where_they_have_so_many() {
        for (value, text) in [
            (641.234, "641.2"),
            (0.98765, "0.9877"),
            (1234.56, "1235"),
            (123_456.7, "123457"),
            (0.000_123_456, "0.0001235"),
            (0.0, "0"),
            (-2.5, "-2.5"),
            (1.0, "1"),
        ] {
            assert_eq!(digits(value), text);
        }
    }
}

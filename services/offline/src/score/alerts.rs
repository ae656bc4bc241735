//! `koseki score alerts`: alerts against a truth.

use std::fmt::Write as _;

use ::areas::{Area, Ground};
use frames::SystemFrame;
use scoring::{
    AlertFigures, AlertScore, AlertScoreSettings, AlertTable, FileBasis, KindReliability, Minima, Timeline,
    score_alerts,
};

use crate::files::InputError;
use crate::host::Host;
use crate::printed::digits;
use crate::score_args::ScoreAlerts;

const NAUTICAL_MILE_M: f64 = 1852.0;
const FOOT_M: f64 = 0.3048;
/// Misses and nuisances that the text lists.
const LISTED_MAX: usize = 20;

/// Scores the alerts and prints the figures.
pub(super) fn run(asked: &ScoreAlerts, host: &dyn Host) -> anyhow::Result<()> {
    let basis = asked.origin.map(FileBasis::at).unwrap_or_default();
    let tracks = Timeline::tracks_on(basis, host.open(&asked.tracks)?, asked.max_age)
        .map_err(|error| InputError::new(&asked.tracks, error))?;
    let truth = super::truth_for(host, &asked.truth, asked.reference, &tracks)?;
    let table = AlertTable::read(tracks.basis(), host.open(&asked.alerts)?)
        .map_err(|error| InputError::new(&asked.alerts, error))?;
    let areas = areas(asked, host)?;
    if let (Some(file), [unknown, ..]) = (&asked.areas, &table.unknown_areas(&areas)[..]) {
        let what = format!(
            "{} has no area \"{unknown}\"; give the file with all areas",
            file.display()
        );
        return Err(InputError::new(&asked.alerts, what).into());
    }
    let settings = AlertScoreSettings {
        minima: Minima {
            horizontal_m: asked.minimum_nm * NAUTICAL_MILE_M,
            vertical_m: asked.minimum_ft * FOOT_M,
            vertical_high_m: asked.minimum_high_ft * FOOT_M,
            ships_m: asked.minimum_ships_nm * NAUTICAL_MILE_M,
        },
        gate_m: asked.gate,
        look_ahead_s: asked.look_ahead,
    };
    let found = score_alerts(&truth, &tracks, &table, &settings, &areas)
        .map_err(|error| InputError::new(&asked.truth, error))?;
    host.print(&match asked.json {
        true => format!("{}\n", serde_json::to_string(&found)?),
        false => text(&found),
    })
}

fn areas(asked: &ScoreAlerts, host: &dyn Host) -> Result<Vec<Area>, InputError> {
    let (Some(file), Some(origin)) = (&asked.areas, asked.origin) else {
        return Ok(Vec::new());
    };
    let ground = Ground::of(SystemFrame::at(origin));
    ::areas::read(&host.text(file)?, &ground).map_err(|error| InputError::new(file, error))
}

fn text(found: &AlertScore) -> String {
    let mut text = format!(
        "Compared: {} s to {} s, {} targets, {} tracks that follow one.\n",
        found.first_s, found.last_s, found.targets, found.tracks
    );
    if !found.heights_above_ellipsoid {
        text += "Heights are those above the plane of the frame, which are wrong far from its origin; give --origin.\n";
    }
    if found.cleared_without_raised > 0 {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{} alerts are cleared and were not raised.",
            found.cleared_without_raised
        );
    }
    for kind in &found.kinds {
        let _ = writeln!(text, "\n{}: {} alerts", kind.kind, kind.alerts);
        match &kind.judged {
            Some(figures) => write_figures(&mut text, figures),
            None => text += "not judged\n",
        }
    }
    for kind in &found.reliability {
        write_reliability(&mut text, kind);
    }
    text
}

fn write_figures(text: &mut String, figures: &AlertFigures) {
    let shown = |figure: Option<f64>| figure.map_or_else(|| "-".to_owned(), digits);
    let lines = [
        ("events", figures.events.to_string(), "violations in the truth"),
        ("hits", figures.hits.to_string(), "those with an alert"),
        ("misses", figures.misses.to_string(), "those without"),
        (
            "misses_without_track",
            figures.misses_without_track.to_string(),
            "misses of targets without a track",
        ),
        (
            "late",
            figures.late.to_string(),
            "hits after the begin of the violation",
        ),
        (
            "duplicates",
            figures.duplicates.to_string(),
            "further alerts of a violation",
        ),
        ("nuisance", figures.nuisance.to_string(), "alerts without a violation"),
        (
            "nuisance_without_target",
            figures.nuisance_without_target.to_string(),
            "those of a track that follows no target",
        ),
        (
            "nuisance_per_hour",
            shown(figures.nuisance_per_hour),
            "nuisances per hour of the truth",
        ),
        (
            "undecided",
            figures.undecided.to_string(),
            "alerts that a longer truth would decide",
        ),
        (
            "lead_s_median",
            shown(figures.lead_s_median),
            "median time from the alert to the violation, s",
        ),
        (
            "in_time",
            shown(figures.in_time),
            "share of hits a minute before, or at the first state",
        ),
    ];
    for (name, figure, meaning) in lines {
        let _ = writeln!(text, "{name:<26} {figure:>9}  {meaning}");
    }
    for missed in figures.missed.iter().take(LISTED_MAX) {
        let targets: Vec<String> = missed.targets.iter().map(i64::to_string).collect();
        let area = missed
            .area
            .as_ref()
            .map_or_else(String::new, |area| format!(" in {area}"));
        let _ = writeln!(
            text,
            "missed: targets {}{area} from {:.1} s",
            targets.join(" and "),
            missed.begins_s
        );
    }
    let nuisances = figures
        .nuisance_alerts
        .iter()
        .take(LISTED_MAX)
        .map(u64::to_string)
        .collect::<Vec<_>>();
    if !nuisances.is_empty() {
        let _ = writeln!(text, "nuisances: alerts {}", nuisances.join(", "));
    }
}

fn write_reliability(text: &mut String, kind: &KindReliability) {
    let brier = kind.brier.map_or_else(|| "-".to_owned(), digits);
    let _ = writeln!(
        text,
        "\n{} predictions: {} compared, {} left out, Brier score {brier}",
        kind.kind, kind.n, kind.left_out
    );
    let _ = writeln!(
        text,
        "{:>11} {:>9} {:>9} {:>9} {:>9}",
        "probability", "n", "violated", "predicted", "observed"
    );
    for bin in &kind.bins {
        let shown = |figure: Option<f64>| figure.map_or_else(|| "-".to_owned(), |figure| format!("{figure:.3}"));
        let _ = writeln!(
            text,
            "{:>5.1} - {:.1} {:>9} {:>9} {:>9} {:>9}",
            bin.from,
            bin.to,
            bin.n,
            bin.violated,
            shown(bin.predicted),
            shown(bin.observed)
        );
    }
}

//! The scorecard as JSON and as text.

use std::fmt::Write as _;

use scoring::{
    AreaCard, CardReference, Compared, ErrorSpread, LineLimit, LineResult, LineVerdict, MOVEMENT_PHASES, PhaseFigures,
    PhaseTable, PictureScore, Scorecard, StandardCard,
};
use serde::Serialize;

use crate::printed::digits;

/// Share of the gate from which errors are so large that some are cut off.
const GATE_SHARE: f64 = 0.8;

/// Figures of a picture with the scorecard.
#[derive(Debug, Serialize)]
pub(super) struct ScoredPicture<'a> {
    #[serde(flatten)]
    picture: &'a PictureScore,
    compared: &'a Compared,
    reference: &'static str,
    #[serde(flatten)]
    all: CardObject<'a>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    areas: Vec<CardObject<'a>>,
}

/// Card of an area as a JSON object.
#[derive(Debug, Serialize)]
struct CardObject<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    kind: Option<&'static str>,
    targets: u64,
    target_seconds: u64,
    phases: &'a PhaseTable,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    standards: &'a [StandardCard],
}

impl<'a> ScoredPicture<'a> {
    pub(super) fn new(picture: &'a PictureScore, card: &'a Scorecard) -> Self {
        Self {
            picture,
            compared: &picture.compared,
            reference: card.reference.word(),
            all: CardObject::new(&card.all),
            areas: card.areas.iter().map(CardObject::new).collect(),
        }
    }
}

impl<'a> CardObject<'a> {
    fn new(card: &'a AreaCard) -> Self {
        Self {
            name: card.name.as_deref(),
            kind: card.kind.map(|kind| kind.word),
            targets: card.targets,
            target_seconds: card.target_seconds,
            phases: &card.phases,
            standards: &card.standards,
        }
    }
}

/// Returns the necessary facts about the reference for a reader.
pub(super) fn about(reference: CardReference) -> &'static str {
    match reference {
        CardReference::Truth => "Compared with the truth: a line passes or fails.",
        CardReference::Independent => {
            "Compared with an independent instrument: all figures contain the errors of the instrument, and tracks of \
             targets that it does not report are not judged."
        }
        CardReference::Smoothed => {
            "Compared with trajectories smoothed from the same data: errors that all sensors share are invisible. The \
             figures show precision only, and no line passes."
        }
    }
}

/// Returns the cards as text; nothing if no target counts and no standard is asked for.
pub(super) fn text(card: &Scorecard) -> String {
    let mut text = String::new();
    for area in std::iter::once(&card.all).chain(&card.areas) {
        if area.target_seconds == 0 && area.standards.is_empty() && area.name.is_none() {
            continue;
        }
        write_area(&mut text, area, card.gate_m);
    }
    if !text.is_empty() {
        text = format!("\n{}\n{text}", about(card.reference));
    }
    text
}

fn write_area(text: &mut String, area: &AreaCard, gate_m: f64) {
    let kind = area.kind.map_or_else(String::new, |kind| format!(" ({})", kind.word));
    let name = area.name.as_deref().unwrap_or("everything");
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "\n{name}{kind}: {} targets, {} target-seconds, {} with a track",
        area.targets, area.target_seconds, area.phases.0[0].n
    );
    write_phases(text, &area.phases);
    for advice in advice(area, gate_m) {
        let _ = writeln!(text, "{advice}");
    }
    for standard in &area.standards {
        let _ = writeln!(text, "\n{}", standard.title);
        for line in &standard.lines {
            write_line(text, line);
        }
    }
}

fn write_phases(text: &mut String, table: &PhaseTable) {
    if table.0[0].n == 0 {
        return;
    }
    let _ = writeln!(
        text,
        "{:<11} {:>7} |{:>30} m |{:>14} m |{:>12} m |{:>11} deg |{:>11} m/s |{:>11} m/s | nees                  | likeliest",
        "", "", "position", "along across", "height", "heading", "speed", "climb"
    );
    let _ = writeln!(
        text,
        "{:<11} {:>7} | {:>6}{:>6}{:>6}{:>6}{:>6}  | {:>7}{:>7}  | {:>6}{:>6}  | {:>6}{:>6}   | {:>6}{:>6}   | {:>6}{:>6}   | {:>5}{:>6}{:>6}{:>6} | {:>5}{:>7}",
        "phase",
        "n",
        "rms",
        "50",
        "90",
        "95",
        "99",
        "rms",
        "rms",
        "rms",
        "95",
        "rms",
        "95",
        "rms",
        "95",
        "rms",
        "95",
        "pos",
        "vel",
        "z",
        "climb",
        "vel",
        "climb"
    );
    for (phase, figures) in MOVEMENT_PHASES.iter().zip(&table.0) {
        if figures.n > 0 {
            write_phase(text, phase.name, figures);
        }
    }
}

fn write_phase(text: &mut String, name: &str, figures: &PhaseFigures) {
    let one = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.1}"));
    let two = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.2}"));
    let both = |spread: &ErrorSpread| format!("{:>6}{:>6}", one(spread.rms), one(spread.p95));
    let position = &figures.position;
    let [p50, p90, p95, p99] = [position.p50, position.p90, position.p95, position.p99].map(one);
    let consistency = &figures.consistency;
    let _ = writeln!(
        text,
        "{name:<11} {:>7} | {:>6}{p50:>6}{p90:>6}{p95:>6}{p99:>6}  | {:>7}{:>7}  | {}  | {}   | {}   | {}   | {:>5}{:>6}{:>6}{:>6} | {:>5}{:>7}",
        figures.n,
        one(position.rms),
        one(figures.along.rms),
        one(figures.across.rms),
        both(&figures.height),
        both(&figures.heading_deg),
        both(&figures.speed),
        both(&figures.climb),
        two(consistency.position.nees),
        two(consistency.velocity.nees),
        two(consistency.height.nees),
        two(consistency.climb.nees),
        two(consistency.likeliest_velocity.nees),
        two(consistency.likeliest_climb.nees),
    );
}

fn write_line(text: &mut String, line: &LineResult) {
    let figure = line.figure.map_or_else(|| "-".to_owned(), digits);
    let limit = line.limit.map_or_else(String::new, limit_text);
    let _ = writeln!(
        text,
        "{:<22} {figure:>9} {:<4} {limit:<11} {:<15} {}{}",
        line.name,
        line.unit,
        line.verdict.word(),
        meaning(line),
        remark(line).map_or_else(String::new, |remark| format!("; {remark}")),
    );
}

/// Returns a limit with the comparison.
pub(super) fn limit_text(limit: LineLimit) -> String {
    let value = limit.value();
    match value < 1e-3 {
        true => format!("{} {value:e}", limit.sign()),
        false => format!("{} {value}", limit.sign()),
    }
}

/// Returns the necessary remarks for a reader before the figures of a card.
pub(super) fn advice(area: &AreaCard, gate_m: f64) -> Vec<String> {
    let mut found = Vec::new();
    let mut lines = area.standards.iter().flat_map(|standard| &standard.lines);
    if area.name.is_none() && lines.any(|line| line.area.is_some()) {
        found.push(
            "Lines for a kind of area are computed from all targets here; --areas judges them where they apply."
                .to_owned(),
        );
    }
    let p99 = area.phases.0[0].position.p99;
    if p99.is_some_and(|p99| p99 > GATE_SHARE * gate_m) {
        found.push(format!(
            "Errors reach the gate of {gate_m} m: larger ones count as missing reports, and the figures of the position \
             are too good. A wider --gate shows them."
        ));
    }
    found
}

/// Returns the meaning of a line, with the areas that the line was written for.
pub(super) fn meaning(line: &LineResult) -> String {
    match line.area {
        Some(area) => format!("for {}: {}", area.word, line.meaning),
        None => line.meaning.to_owned(),
    }
}

/// Returns the reason for caution with a line's verdict.
pub(super) fn remark(line: &LineResult) -> Option<String> {
    let is_good = matches!(line.verdict, LineVerdict::Pass | LineVerdict::PrecisionOnly);
    (is_good && !line.enough).then(|| format!("only {} cases: too few for this limit", line.samples))
}

//! Scorecards: how good tracks are in each phase of movement, and beside the limits of published standards.
//!
//! A mean over everything does not show whether a picture is fit for its purpose. A scorecard has the distribution of
//! each error in straight flight, in turns and in climbs ([`MOVEMENT_PHASES`]), the consistency of the covariances,
//! and the lines of standards for surveillance with figure, limit and verdict ([`SURVEILLANCE_STANDARDS`]). Each
//! area ([`ScoredArea`]) has a card of its own, from the targets within: a runway needs more than an apron.
//!
//! **Limits.** Targets count at whole seconds. A track is shown for a time after its newest state, extrapolated along
//! its velocity, and this time hides gaps: with the display time of 1 s, a report is a state of the last second.

mod areas;
mod figures;
mod measures;
mod phases;
mod samples;
mod standard_lines;
mod standards;

use serde::Serialize;

use crate::picture::{PictureError, Timeline};

pub use self::areas::{AreaKind, ScoredArea};
pub use figures::{ErrorSpread, GroupConsistency, PhaseFigures, PhaseTable, SpreadConsistency};
pub use measures::{LineMeasure, MeasuredFigure};
pub use phases::{MOVEMENT_PHASES, MovementPhase, PhaseLimits, PhaseSet};
pub use samples::{AddressCheck, CardSettings, ErrorSample};
pub use standard_lines::{SURVEILLANCE_STANDARDS, surveillance_standard};
pub use standards::{CardReference, LineLimit, LineResult, LineVerdict, StandardLine, SurveillanceStandard};

use measures::{CardPart, ReportTimes};
use samples::CardSamples;

/// Card of an area, or of everything.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaCard {
    /// Name of the area; `None` for everything.
    pub name: Option<String>,
    /// Kind of the area.
    pub kind: Option<AreaKind>,
    /// Number of targets that count.
    pub targets: u64,
    /// Number of their seconds.
    pub target_seconds: u64,
    /// Errors by phase.
    pub phases: PhaseTable,
    /// Lines of the standards asked for, in their order.
    pub standards: Vec<StandardCard>,
}

/// Lines of one standard.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StandardCard {
    /// Name of the standard on the command line.
    pub standard: &'static str,
    /// Full name.
    pub title: &'static str,
    /// Its lines.
    pub lines: Vec<LineResult>,
}

/// Cards of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Scorecard {
    /// What the tracks were compared with.
    pub reference: CardReference,
    /// Distance from which a track did not belong to a target, metres: no error is larger.
    pub gate_m: f64,
    /// Card of everything.
    pub all: AreaCard,
    /// Cards of the areas, in their order.
    pub areas: Vec<AreaCard>,
    /// Errors behind the figures, in the order of time.
    pub errors: Vec<ErrorSample>,
}

/// Compares tracks with a truth or a reference.
///
/// # Errors
/// If there is no second to compare.
pub fn score_card(
    truth: &Timeline,
    tracks: &Timeline,
    settings: &CardSettings,
    reference: CardReference,
    standards: &[&SurveillanceStandard],
    areas: &[ScoredArea],
) -> Result<Scorecard, PictureError> {
    let samples = CardSamples::collect(truth, tracks, settings)?;
    let card = |area: Option<&ScoredArea>| AreaCard::of(&samples, area, reference, standards);
    Ok(Scorecard {
        reference,
        gate_m: settings.gate_m,
        all: card(None),
        areas: areas.iter().map(|area| card(Some(area))).collect(),
        errors: samples.errors,
    })
}

impl AreaCard {
    fn of(
        samples: &CardSamples,
        area: Option<&ScoredArea>,
        reference: CardReference,
        standards: &[&SurveillanceStandard],
    ) -> Self {
        let inside = |place_m: [f64; 2]| area.is_none_or(|area| area.outline.contains(place_m));
        let errors: Vec<&ErrorSample> = samples.errors.iter().filter(|error| inside(error.place_m)).collect();
        let seconds: Vec<_> = samples.targets.iter().filter(|target| inside(target.place_m)).collect();
        let phases = PhaseTable::of(&errors);
        let part = CardPart {
            errors,
            phases: &phases,
            reports: ReportTimes::of(&seconds),
            tracks: samples.tracks.iter().filter(|track| inside(track.place_m)).collect(),
            seconds: samples.seconds,
            is_complete: reference == CardReference::Truth,
        };
        let kind = area.and_then(|area| area.kind);
        let standard = |standard: &&SurveillanceStandard| StandardCard {
            standard: standard.word,
            title: standard.title,
            lines: standard.judge(&part, kind, reference),
        };
        Self {
            name: area.map(|area| area.name.clone()),
            kind,
            targets: part.reports.targets as u64,
            target_seconds: seconds.len() as u64,
            standards: standards.iter().map(standard).collect(),
            phases,
        }
    }
}

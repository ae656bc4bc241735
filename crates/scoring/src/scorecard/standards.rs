//! Requirements of published standards, line by line.
//!
//! The texts of EUROCAE are sold. Their limits stand here as an open evaluation tool encodes them (OpenATS COMPASS,
//! `eval.json` and its documents); nobody read the texts. The limits of ESASSP are those of its tables 9 and 10 for
//! surveillance without co-operation of the targets (edition 1.3), as a public review of the published text quotes
//! them. A line without a source for its limit has none: the figure is printed, and no verdict is given.
//!
//! **A verdict is worth what the reference is worth.** Against a truth, a figure within its limit passes. Against
//! trajectories smoothed from the same data, the figure shows the precision of the tracks only: errors that all
//! sensors share are in the reference, too. Such a figure never passes.

use serde::{Serialize, Serializer};

use super::areas::AreaKind;
use super::measures::{CardPart, LineMeasure};

/// What the tracks are compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CardReference {
    /// The truth: every target, without error.
    #[default]
    Truth,
    /// Trajectories by an independent instrument, of some of the targets. Its errors are part of all figures.
    Independent,
    /// Trajectories smoothed from the same data.
    Smoothed,
}

impl CardReference {
    /// All references.
    pub const ALL: [Self; 3] = [Self::Truth, Self::Independent, Self::Smoothed];

    /// Name on the command line and in JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::Truth => "truth",
            Self::Independent => "independent",
            Self::Smoothed => "smoothed",
        }
    }
}

/// Limit of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LineLimit {
    /// The figure must not be above.
    AtMost(f64),
    /// The figure must not be below.
    AtLeast(f64),
    /// The figure must be above.
    Above(f64),
}

impl LineLimit {
    fn holds(self, figure: f64) -> bool {
        match self {
            Self::AtMost(limit) => figure <= limit,
            Self::AtLeast(limit) => figure >= limit,
            Self::Above(limit) => figure > limit,
        }
    }

    /// Returns the limit.
    pub fn value(self) -> f64 {
        match self {
            Self::AtMost(limit) | Self::AtLeast(limit) | Self::Above(limit) => limit,
        }
    }

    /// Returns the comparison as text.
    pub fn sign(self) -> &'static str {
        match self {
            Self::AtMost(_) => "<=",
            Self::AtLeast(_) => ">=",
            Self::Above(_) => ">",
        }
    }
}

/// Judgement of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineVerdict {
    /// The figure keeps the limit.
    Pass,
    /// The figure exceeds the limit.
    Fail,
    /// The reference comes from the same data.
    PrecisionOnly,
    /// No limit has a source.
    NoLimitKnown,
    /// The files have no such data.
    NotMeasured,
}

impl LineVerdict {
    /// Returns the verdict as text.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::PrecisionOnly => "precision only",
            Self::NoLimitKnown => "no limit known",
            Self::NotMeasured => "not measured",
        }
    }
}

impl Serialize for LineVerdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word())
    }
}

/// Line of a standard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandardLine {
    /// Name of the line, unique in its standard.
    pub name: &'static str,
    /// Areas to which the line applies; `None`: everywhere.
    pub area: Option<AreaKind>,
    /// Unit of the figure; empty for shares.
    pub unit: &'static str,
    /// Meaning of the figure.
    pub meaning: &'static str,
    /// The figure.
    pub measure: LineMeasure,
    /// The limit, if it has a source.
    pub limit: Option<LineLimit>,
    /// Source of the limit.
    pub source: &'static str,
}

/// Standard with its lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurveillanceStandard {
    /// Name on the command line.
    pub word: &'static str,
    /// Full name.
    pub title: &'static str,
    /// The lines, in the order of output.
    pub lines: &'static [StandardLine],
}

/// Result of a line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LineResult {
    /// Name of the line.
    #[serde(rename = "line")]
    pub name: &'static str,
    /// Kind of the areas to which the line applies.
    #[serde(serialize_with = "area_word")]
    pub area: Option<AreaKind>,
    /// Meaning of the figure.
    pub meaning: &'static str,
    /// Unit of the figure.
    pub unit: &'static str,
    /// The figure; `None` if nothing was measured.
    pub figure: Option<f64>,
    /// Number of cases behind the figure.
    pub samples: u64,
    /// The limit.
    #[serde(serialize_with = "limit_value")]
    pub limit: Option<LineLimit>,
    /// How the figure is compared with the limit.
    pub comparison: Option<&'static str>,
    /// The judgement.
    pub verdict: LineVerdict,
    /// Whether the cases suffice to see a rate as small as the limit.
    pub enough: bool,
    /// Source of the limit.
    pub source: &'static str,
}

fn area_word<S: Serializer>(area: &Option<AreaKind>, serializer: S) -> Result<S::Ok, S::Error> {
    area.map(|kind| kind.word).serialize(serializer)
}

fn limit_value<S: Serializer>(limit: &Option<LineLimit>, serializer: S) -> Result<S::Ok, S::Error> {
    limit.map(LineLimit::value).serialize(serializer)
}

impl SurveillanceStandard {
    /// Judges the part of an area of this kind; without a kind, all lines apply.
    pub(crate) fn judge(
        &self,
        part: &CardPart<'_>,
        kind: Option<AreaKind>,
        reference: CardReference,
    ) -> Vec<LineResult> {
        let applies = |line: &&StandardLine| match (line.area, kind) {
            (Some(of), Some(kind)) => kind.has(of),
            _ => true,
        };
        self.lines
            .iter()
            .filter(applies)
            .map(|line| line.judge(part, reference))
            .collect()
    }
}

impl StandardLine {
    fn judge(&self, part: &CardPart<'_>, reference: CardReference) -> LineResult {
        let found = part.figure(self.measure);
        let verdict = match (found.value, self.limit) {
            (None, _) => LineVerdict::NotMeasured,
            (_, None) => LineVerdict::NoLimitKnown,
            _ if reference == CardReference::Smoothed => LineVerdict::PrecisionOnly,
            (Some(figure), Some(limit)) if limit.holds(figure) => LineVerdict::Pass,
            _ => LineVerdict::Fail,
        };
        LineResult {
            name: self.name,
            area: self.area,
            meaning: self.meaning,
            unit: self.unit,
            figure: found.value,
            samples: found.samples,
            limit: self.limit,
            comparison: self.limit.map(LineLimit::sign),
            verdict,
            enough: self.limit.is_none_or(|limit| self.measure.sees(limit, found.samples)),
            source: self.source,
        }
    }
}

impl LineMeasure {
    /// Whether so many cases show a share as near to 0 or 1 as the limit.
    fn sees(self, limit: LineLimit, samples: u64) -> bool {
        let rare = match self {
            Self::Update(_) | Self::AddressRight | Self::SpeedWithin(..) => 1.0 - limit.value(),
            Self::Gaps(..) | Self::AddressWrong | Self::FalseReports(_) => limit.value(),
            Self::PositionQuantile(share) | Self::CourseQuantile(share) | Self::HeightQuantile(share) => 1.0 - share,
            _ => 1.0,
        };
        // Less than one case by rounding: 1 − 0.9 is below 0.1.
        samples as f64 * rare >= 1.0 - 1e-9
    }
}

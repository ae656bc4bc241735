//! Predicted probabilities beside frequencies.
//!
//! Of all predictions with a probability near 0.3, three in ten should come true. Predictions are put into ten bins of
//! equal width by their probability; each bin has the frequency with which the truth was in violation within the
//! horizon. Predictions whose horizon the truth does not reach are left out, whatever happened: to keep those alone
//! that came true would make the frequencies too great.
//!
//! Source: Murphy and Winkler, *Reliability of Subjective Probability Forecasts of Precipitation and Temperature*,
//! Applied Statistics 26 (1977).

use serde::Serialize;

use super::alert_table::Prediction;
use super::followed::Followed;
use super::judging::subjects;
use super::violations::Violations;
use super::{ALERT_KINDS, APPROACH, AlertScoreSettings, CONFLICT, ENTER};

const BINS: usize = 10;

/// Reliability of the predictions of a kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct KindReliability {
    /// Kind of the predicted violations.
    pub kind: &'static str,
    /// Predictions that count.
    pub n: u64,
    /// Predictions that are left out: their horizon lies beyond the truth, or a track follows no target.
    pub left_out: u64,
    /// Mean squared difference of probability and outcome (Brier score); `None` without predictions.
    pub brier: Option<f64>,
    /// Ten bins.
    pub bins: Vec<ReliabilityBin>,
}

/// Predictions of similar probability.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ReliabilityBin {
    /// Least probability.
    pub from: f64,
    /// Greatest probability, which belongs to the next bin but for 1.
    pub to: f64,
    /// Number of predictions.
    pub n: u64,
    /// Predictions that came true.
    pub violated: u64,
    /// Mean of the probabilities; `None` without predictions.
    pub predicted: Option<f64>,
    /// Share of predictions that came true.
    pub observed: Option<f64>,
}

/// Returns the reliability of each judged kind with predictions.
pub(super) fn reliability(
    violations: &Violations,
    followed: &Followed,
    predictions: &[Prediction],
    settings: &AlertScoreSettings,
) -> Vec<KindReliability> {
    let kinds = ALERT_KINDS
        .into_iter()
        .filter(|kind| [CONFLICT, APPROACH, ENTER].contains(kind));
    let of_kind = |kind: &'static str| {
        let all: Vec<&Prediction> = predictions
            .iter()
            .filter(|prediction| prediction.stated.kind == kind)
            .collect();
        (!all.is_empty()).then(|| of_predictions(kind, (violations, followed), &all, settings))
    };
    kinds.filter_map(of_kind).collect()
}

fn of_predictions(
    kind: &'static str,
    (violations, followed): (&Violations, &Followed),
    predictions: &[&Prediction],
    settings: &AlertScoreSettings,
) -> KindReliability {
    let bin = |place: usize| ReliabilityBin {
        from: place as f64 / BINS as f64,
        to: (place + 1) as f64 / BINS as f64,
        ..ReliabilityBin::default()
    };
    let mut found = KindReliability {
        kind,
        bins: (0..BINS).map(bin).collect(),
        ..KindReliability::default()
    };
    let (mut sums, mut squares) = ([0.0; BINS], 0.0);
    for prediction in predictions {
        let from_s = prediction.stated.time_s;
        let to_s = from_s + prediction.horizon_s.unwrap_or(settings.look_ahead_s(kind));
        let subjects = subjects(&prediction.stated, violations, followed);
        if subjects.is_empty() || subjects.iter().any(|subject| violations.end_s(subject) < to_s) {
            found.left_out += 1;
            continue;
        }
        let is_true = subjects
            .iter()
            .any(|subject| violations.within(subject, from_s, to_s).next().is_some());
        let place = ((prediction.probability * BINS as f64) as usize).min(BINS - 1);
        found.n += 1;
        found.bins[place].n += 1;
        found.bins[place].violated += u64::from(is_true);
        sums[place] += prediction.probability;
        squares += (prediction.probability - f64::from(is_true)).powi(2);
    }
    for (bin, sum) in found.bins.iter_mut().zip(sums).filter(|(bin, _)| bin.n > 0) {
        bin.predicted = Some(sum / bin.n as f64);
        bin.observed = Some(bin.violated as f64 / bin.n as f64);
    }
    found.brier = (found.n > 0).then(|| squares / found.n as f64);
    found
}

//! Model of a source, learned at run time: process noise, truth of the covariances, detection probability.
//!
//! Sources state little about themselves. Three properties decide on the use of the reports, and all three show in the
//! reports:
//! - **Process noise.** Two successive covariances of a sensor track show the process noise of the source's filter
//!   ([`estimation::implied_noise`]). With known process noise, the measurements can be recovered, with independent
//!   errors.
//! - **Truth of the covariance** (BF-5). The normalised innovation squared of a true covariance follows chi-square. The
//!   median is compared, not the mean: manoeuvring targets, a minority at any time, hardly move the median. If the
//!   innovations are larger, the covariances of the source are inflated until the innovations fit.
//! - **Detection points.** A mean innovation of a source over a target, other than 0, does not come from noise: the
//!   source sees another point of the target than the other sources. The spread of these means over the targets shows
//!   the size of the targets.
//!
//! All values are tracked by medians that move by a bounded step, so that no single report can spoil a value.

use estimation::{NearlyConstantVelocity, implied_noise};
use kept::kept;
use messages::Covariance;
use serde::{Deserialize, Serialize};

use crate::corrections::Corrections;
use crate::error_shape::ErrorShape;
use crate::height_errors::HeightErrors;
use crate::median::Median;
use crate::seeker::Seeker;
use crate::tracker_gain::{Change, GainEvidence, TrackerGain, Undone};

/// Median of chi-square with two degrees of freedom.
pub(crate) const CHI2_MEDIAN_2: f64 = 1.386_294_361_119_890_6;
/// Weight of a new innovation in the mean over a sensor track.
pub const MEAN_GAIN: f64 = 0.25;
/// Variance of such a mean relative to the variance of an innovation.
pub const MEAN_VARIANCE: f64 = MEAN_GAIN / (2.0 - MEAN_GAIN);
/// Part of the variance of a mean by which slow errors may enlarge it, a quarter of the largest part: of errors that do
/// not change within the mean.
const SLOW: f64 = 0.25 * (1.0 / MEAN_VARIANCE - 1.0);
/// Number of reports with an implied process noise before the noise is used.
const NOISE_SAMPLES_MIN: u32 = 8;
/// Number of reports after which a filter of unknown noise counts as impossible to undo.
const REPEATED_FIRST: u32 = 32;
/// Number of first pairs of reports that are all examined, and interval between examined pairs thereafter.
const NOISE_SAMPLES_FIRST: u32 = 256;
const NOISE_SAMPLE_EVERY: u32 = 64;
/// Inflation below this value is within the chance of a consistent source.
const COVARIANCE_SCALE_MIN: f64 = 1.3;
/// `ln(COVARIANCE_SCALE_MIN)`, rounded down.
const LOG_COVARIANCE_SCALE_MIN: f64 = 0.26;
/// Largest inflation of a covariance.
const COVARIANCE_SCALE_MAX: f64 = 1000.0;
/// Weight of a new sample in the mean over all sensor tracks.
const COMMON_GAIN: f64 = 1.0 / 64.0;
/// Number of samples of detection points before the spread is used.
const SPREAD_SAMPLES_MIN: u32 = 30;
/// Variance per axis of detection points on a target before the spread is used, m².
const SPREAD_PRIOR_M2: f64 = 6.0 * 6.0;

kept! {
    /// Learned properties of a source.
    #[derive(Clone, Copy, Debug, Serialize, Deserialize)]
    pub(crate) struct SourceModel {
        horizontal_noise: Median,
        vertical_noise: Median,
        /// Share of the examined reports from a filter of the form of [`estimation::implied_noise`].
        filtered_share: f64,
        looked_at: u32,
        process_noise: Option<NearlyConstantVelocity>,
        pub(crate) covariance_scale: Seeker,
        /// Shape of the errors.
        pub(crate) shape: ErrorShape,
        /// Gain of the source's tracker.
        gain: TrackerGain,
        /// Measurements behind tracks whose covariances come from several models of motion.
        pub(crate) corrections: Corrections,
        /// Mean innovation over all sensor tracks: remaining errors of the source, metres.
        mean_offset_m: [f64; 2],
        /// Squared deviation of a track's mean innovation from that mean, relative to the part explained by noise.
        spread_ratio: Median,
        /// Part explained by noise, m² per axis.
        spread_noise_m2: Median,
        /// Variance of recovered measurements, m² per axis.
        measured_m2: Median,
        /// Resulting variance per axis, m²: see [`SourceModel::spread_m2`].
        spread_m2: f64,
        /// Slow errors of heights.
        pub(crate) heights: HeightErrors,
        /// Mean size of the targets, by their types, metres.
        size_m: f64,
        /// Probability that a scan detects a target tracked by the source.
        pub(crate) detection: f64,
    }
}

impl Default for SourceModel {
    fn default() -> Self {
        Self {
            horizontal_noise: Median::default(),
            vertical_noise: Median::default(),
            filtered_share: 0.5,
            looked_at: 0,
            process_noise: None,
            covariance_scale: Seeker::default(),
            shape: ErrorShape::default(),
            gain: TrackerGain::default(),
            corrections: Corrections::default(),
            mean_offset_m: [0.0; 2],
            spread_ratio: Median::default(),
            spread_noise_m2: Median::default(),
            measured_m2: Median::default(),
            spread_m2: 0.0,
            heights: HeightErrors::default(),
            size_m: 0.0,
            detection: 0.9,
        }
    }
}

impl SourceModel {
    /// The process noise of the source's own filter, if known.
    #[inline]
    pub(crate) fn process_noise(&self) -> Option<NearlyConstantVelocity> {
        self.process_noise
    }

    /// Returns whether the covariances of the source's reports show a filter that cannot be undone.
    #[inline]
    pub(crate) fn cannot_be_undone(&self) -> bool {
        self.process_noise.is_none() && !self.corrections.is_used() && self.looked_at >= REPEATED_FIRST
    }

    /// Whether to learn from the next pair of reports: all first pairs, and a few later pairs.
    #[inline]
    pub(crate) fn looks_at_noise(&mut self) -> bool {
        self.looked_at = self.looked_at.wrapping_add(1);
        self.looked_at < NOISE_SAMPLES_FIRST || self.looked_at.is_multiple_of(NOISE_SAMPLE_EVERY)
    }

    /// Learns from two successive reports of a sensor track.
    pub(crate) fn learn_noise(&mut self, before: &Covariance, after: &Covariance, seconds: f64, has_height: bool) {
        let horizontal = implied_noise::<2>(before, after, seconds, 0);
        if let Some(noise) = horizontal {
            self.horizontal_noise.add(noise);
        }
        if has_height && let Some(noise) = implied_noise::<1>(before, after, seconds, 2) {
            self.vertical_noise.add(noise);
        }
        let filtered = f64::from(u8::from(horizontal.is_some()));
        self.filtered_share += (filtered - self.filtered_share) / 16.0;
        let known = self.horizontal_noise.samples() >= NOISE_SAMPLES_MIN && self.filtered_share > 0.5;
        self.process_noise = known.then(|| {
            let horizontal = self.horizontal_noise.value();
            let vertical = match self.vertical_noise.samples() {
                0 => horizontal,
                _ => self.vertical_noise.value(),
            };
            NearlyConstantVelocity::new(horizontal, vertical)
        });
    }

    /// Learns from a change of a sensor track, and undoes the source's tracker; `None` while too little is known. The
    /// report states `stated`, a covariance without a filter.
    pub(crate) fn undo(&mut self, evidence: &mut GainEvidence, change: &Change, stated: &Covariance) -> Option<Undone> {
        if self.process_noise.is_some() {
            return None;
        }
        let was_undone = self.gain.is_undone();
        let undone = self.gain.take(evidence, change, stated);
        if undone.is_some() != was_undone {
            // The learned values hold for the former covariances.
            self.covariance_scale = Seeker::default();
            self.shape = ErrorShape::default();
        }
        undone
    }

    /// Undoes the source's tracker between two states of a track, not necessarily the latest; `None` if the source is
    /// not undone. Learns nothing.
    pub(crate) fn undone_between(
        &self,
        evidence: &GainEvidence,
        change: &Change,
        stated: &Covariance,
    ) -> Option<Undone> {
        if !self.gain.is_undone() {
            return None;
        }
        let (mut gain, mut evidence) = (self.gain, *evidence);
        gain.take(&mut evidence, change, stated)
    }

    /// Factor by which the covariances of the source, without signs of a filter, are too small; `None` if unknown.
    pub(crate) fn claim(&self) -> Option<f64> {
        self.gain.claim().filter(|_| self.process_noise.is_none())
    }

    /// Whether the truth of the source's covariances, without signs of a filter, is undecided.
    #[inline]
    pub(crate) fn is_open(&self) -> bool {
        self.process_noise.is_none() && self.gain.is_open()
    }

    /// Covariance of the first report of a track with `stated`, a covariance without a filter; `None` if the stated
    /// covariance is used.
    pub(crate) fn first_covariance(&self, stated: &Covariance) -> Option<Covariance> {
        match self.process_noise {
            None => self.gain.first(stated),
            Some(_) => None,
        }
    }

    /// Gain of the source's tracker.
    #[inline]
    pub(crate) fn gain(&self) -> &TrackerGain {
        &self.gain
    }

    /// Factor on the source's covariances that makes the innovations consistent; 1 for consistent innovations.
    #[inline]
    pub(crate) fn covariance_scale(&self) -> f64 {
        // Called for every report: a logarithm below the limit needs no exponential.
        if self.covariance_scale.logarithm() < LOG_COVARIANCE_SCALE_MIN {
            return 1.0;
        }
        let covariance_scale = self.covariance_scale.logarithm().exp();
        if covariance_scale < COVARIANCE_SCALE_MIN {
            1.0
        } else {
            covariance_scale
        }
    }

    /// Learns from a normalised innovation squared of the horizontal position.
    #[inline]
    pub(crate) fn learn_consistency(&mut self, normalised_squared: f64) {
        self.covariance_scale
            .step(normalised_squared - CHI2_MEDIAN_2, 0.0, COVARIANCE_SCALE_MAX.ln());
    }

    /// Learns from the mean innovation over a sensor track, east and north: noise explains a variance of `noise_m2`
    /// (sum over both axes). Further inputs are the variance per axis of the measurement and the size of the target. A
    /// common error of all tracks is not due to detection points.
    pub(crate) fn learn_spread(&mut self, offset_m: [f64; 2], noise_m2: f64, measured_m2: f64, size_m: f64) {
        self.size_m += (size_m - self.size_m) * if self.size_m == 0.0 { 1.0 } else { COMMON_GAIN };
        let mut squared_m2 = 0.0;
        for (mean, offset) in self.mean_offset_m.iter_mut().zip(offset_m) {
            squared_m2 += (offset - *mean) * (offset - *mean);
            *mean += COMMON_GAIN * (offset - *mean);
        }
        self.spread_ratio.add(squared_m2 / noise_m2);
        self.spread_noise_m2.add(0.5 * noise_m2);
        self.measured_m2.add(measured_m2);
        self.spread_m2 = self.learned_spread_m2();
    }

    /// Whether enough targets were seen for a known spread of the detection points.
    #[inline]
    pub(crate) fn knows_spread(&self) -> bool {
        self.spread_ratio.samples() >= SPREAD_SAMPLES_MIN
    }

    /// Whether so many targets were seen that further targets matter little.
    #[inline]
    pub(crate) fn knows_spread_well(&self) -> bool {
        self.spread_ratio.samples() >= 16 * SPREAD_SAMPLES_MIN
    }

    /// Variance per axis of this source's detection points on targets, m².
    #[inline]
    pub(crate) fn spread_m2(&self) -> f64 {
        self.spread_m2
    }

    /// [`Self::spread_m2`]; until known, the variance for a large aircraft.
    #[inline]
    pub(crate) fn possible_spread_m2(&self) -> f64 {
        if self.knows_spread() {
            self.spread_m2
        } else {
            SPREAD_PRIOR_M2
        }
    }

    fn learned_spread_m2(&self) -> f64 {
        if !self.knows_spread() {
            return 0.0;
        }
        // The squared length of a mean of noise is half a chi-square with two degrees of freedom.
        let excess = self.spread_ratio.value() / (0.5 * CHI2_MEDIAN_2) - 1.0;
        // Chance alone reaches half of the part explained by noise.
        if excess < 0.5 {
            0.0
        } else {
            excess * self.spread_noise_m2.value()
        }
    }

    /// Returns the largest variance per axis of points of a target, m²: of points at both ends.
    #[inline]
    pub(crate) fn largest_points_m2(&self) -> f64 {
        0.25 * self.size_m * self.size_m
    }

    /// Returns [`Self::spread_m2`] as far as due to detection points: 0 where the spread is larger than a target.
    pub(crate) fn points_m2(&self) -> f64 {
        if self.spread_m2 <= self.largest_points_m2() {
            self.spread_m2
        } else {
            0.0
        }
    }

    /// Returns whether the detection points lie farther apart than `ratio` times the source's measurement error, but no
    /// farther than the size of targets: points farther apart are no points of a target. Slow errors of the compared
    /// sources look like points, so the points must also exceed the variance of single comparisons.
    pub(crate) fn sees_points(&self, ratio: f64) -> bool {
        let points_m2 = self.points_m2();
        let slow_m2 = SLOW * self.spread_noise_m2.value();
        points_m2 > 0.0 && points_m2 > ratio * ratio * self.measured_m2.value().max(slow_m2)
    }

    /// Learns whether a scan detected a target tracked by the source.
    #[inline]
    pub(crate) fn learn_detection(&mut self, seen: bool) {
        let seen = f64::from(u8::from(seen));
        self.detection = (self.detection + (seen - self.detection) / 256.0).clamp(0.5, 0.98);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normalised innovations squared of a source with covariances too small by `factor`, by quantiles.
    fn innovations(factor: f64) -> impl Iterator<Item = f64> {
        // In scrambled order.
        (0..2000u32).map(move |step| -2.0 * factor * (1.0 - (f64::from(step * 617 % 2000) + 0.5) / 2000.0).ln())
    }

    #[test]
    fn a_covariance_that_claims_too_much_is_inflated_by_what_it_lacks() {
        for (factor, least, most) in [(1.0, 1.0, 1.0), (0.25, 1.0, 1.0), (4.0, 2.5, 6.4), (100.0, 62.0, 160.0)] {
            let mut model = SourceModel::default();
            // Inflation reduces the normalised innovations.
            innovations(factor).for_each(|squared| model.learn_consistency(squared / model.covariance_scale()));
            let covariance_scale = model.covariance_scale();
            assert!(
                (least..=most).contains(&covariance_scale),
                "{factor}: {covariance_scale}"
            );
        }
    }

    #[test]
    fn what_is_inflated_comes_down_again_and_stays_below_a_maximum() {
        let mut model = SourceModel::default();
        (0..100_000).for_each(|_| model.learn_consistency(1e12));
        assert!((model.covariance_scale() - COVARIANCE_SCALE_MAX).abs() < 1e-6);
        (0..1000).for_each(|_| model.learn_consistency(0.0));
        assert_eq!(model.covariance_scale(), 1.0);
    }

    #[test]
    fn detection_points_apart_are_told_from_noise() {
        let learned = |apart_m2: f64, off_m: f64| {
            let mut model = SourceModel::default();
            for (target, squared) in (0..1000).zip(innovations(1.0)) {
                // The mean of two axes of noise, and of points this far apart; all with the same offset.
                let offset_m = (0.5 * squared * (2.0 * 9.0 + 2.0 * apart_m2)).sqrt();
                let (sin, cos) = (f64::from(target) * 2.4).sin_cos();
                model.learn_spread([off_m + offset_m * sin, offset_m * cos], 2.0 * 9.0, 25.0, 80.0);
            }
            model
        };
        assert_eq!(learned(0.0, 0.0).spread_m2(), 0.0);
        assert_eq!(learned(0.0, 50.0).spread_m2(), 0.0, "an error of the source");
        let model = learned(400.0, 50.0);
        assert!((300.0..520.0).contains(&model.spread_m2()), "{}", model.spread_m2());
        assert!(model.sees_points(2.0) && !model.sees_points(10.0));
        let far = learned(60.0 * 60.0, 0.0);
        assert!(
            far.spread_m2() > 2000.0 && !far.sees_points(2.0),
            "larger than a target"
        );
    }

    #[test]
    fn a_tracker_is_undone_between_any_two_states_as_between_the_latest() {
        const SECONDS: f64 = 4.0;
        let stated = Covariance::diagonal([40.0; 3], [15.0; 3]);
        let (mut model, mut random) = (SourceModel::default(), test_support::Random::new(3));
        let mut evidence = GainEvidence::NONE;
        let change = |random: &mut test_support::Random| {
            let innovation_m: [f64; 3] = std::array::from_fn(|_| random.between(-90.0, 90.0));
            Change {
                position_m: innovation_m.map(|part| 0.5 * part),
                velocity_mps: innovation_m.map(|part| 0.2 * part / SECONDS),
                seconds: SECONDS,
                has_height: true,
            }
        };
        let unknown = model.undone_between(&evidence, &change(&mut random), &stated);
        assert_eq!(unknown, None, "nothing is known yet");
        for report in 0..2000 {
            if report % 40 == 0 {
                evidence = GainEvidence::NONE;
            }
            model.undo(&mut evidence, &change(&mut random), &stated);
        }
        let next = change(&mut random);
        let between = model.undone_between(&evidence, &next, &stated).unwrap();
        let (innovation_m, _) = between.measurement.unwrap();
        for (innovation, moved) in innovation_m.iter().zip(next.position_m) {
            assert!(
                (innovation - 2.0 * moved).abs() < 0.3 * moved.abs() + 3.0,
                "{innovation_m:?}"
            );
        }
        let again = model.undone_between(&evidence, &next, &stated).unwrap();
        assert_eq!(between, again, "nothing was learned");
    }

    #[test]
    fn how_often_a_source_sees_is_followed_within_limits() {
        let mut model = SourceModel::default();
        (0..4000).for_each(|scan| model.learn_detection(scan % 4 != 0));
        assert!((model.detection - 0.75).abs() < 0.03, "{}", model.detection);
        (0..10_000).for_each(|_| model.learn_detection(false));
        assert_eq!(model.detection, 0.5);
    }
}

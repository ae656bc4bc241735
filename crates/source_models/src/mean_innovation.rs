//! Mean innovations of several sources, and the source with a mean apart from all others.
//!
//! All means contain the common part of the sources, such as the lag of a filter in a turn, and the part of an error
//! absorbed by the filter. The difference of a mean from the other means contains the error of that source alone. No
//! source weighs more than twice as much as the middle source, however accurate: an accurate source may be wrong.

use association::distance::{Symmetric2, squared2};
use serde::{Deserialize, Serialize};

/// Largest squared length of a second source, relative to the greatest squared length.
pub(crate) const SECOND_MAX: f64 = 0.6;

/// Mean innovation of a source, east and north, metres, and its covariance.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct MeanInnovation {
    /// Number of the source among those compared.
    pub source: usize,
    /// East and north, metres.
    pub mean_m: [f64; 2],
    /// Covariance (xx, xy, yy), m².
    pub covariance_m2: Symmetric2,
}

impl MeanInnovation {
    fn variance_m2(&self) -> f64 {
        self.covariance_m2[0] + self.covariance_m2[2]
    }

    /// Returns the difference from the mean of others, and its covariance.
    pub(crate) fn apart(&self, others_m: &[f64; 2], others_m2: &Symmetric2) -> ([f64; 2], Symmetric2) {
        (
            std::array::from_fn(|axis| self.mean_m[axis] - others_m[axis]),
            std::array::from_fn(|place| self.covariance_m2[place] + others_m2[place]),
        )
    }
}

/// Sums of the weighted means of several sources.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Others {
    middle_m2: f64,
    weight: f64,
    sum_m: [f64; 2],
    covariance_m2: Symmetric2,
}

impl Others {
    /// Returns the sums of all sources; `None` for less than two. Changes the order of the means.
    pub(crate) fn of(means: &mut [MeanInnovation]) -> Option<Self> {
        let middle = means.len() / 2;
        if means.len() < 2 {
            return None;
        }
        let by_variance = |a: &MeanInnovation, b: &MeanInnovation| a.variance_m2().total_cmp(&b.variance_m2());
        let mut all = Self {
            middle_m2: means.select_nth_unstable_by(middle, by_variance).1.variance_m2(),
            weight: 0.0,
            sum_m: [0.0; 2],
            covariance_m2: [0.0; 3],
        };
        for mean in means.iter() {
            all.add(mean, 1.0);
        }
        Some(all)
    }

    fn add(&mut self, of: &MeanInnovation, sign: f64) {
        let weight = 1.0 / (of.variance_m2() + self.middle_m2);
        self.weight += sign * weight;
        for (sum, mean) in self.sum_m.iter_mut().zip(of.mean_m) {
            *sum += sign * weight * mean;
        }
        for (sum, value) in self.covariance_m2.iter_mut().zip(of.covariance_m2) {
            *sum += sign * weight * weight * value;
        }
    }

    /// Returns the mean of all sources but `own`, and its covariance.
    pub(crate) fn beside(mut self, own: &MeanInnovation) -> ([f64; 2], Symmetric2) {
        self.add(own, -1.0);
        let share = 1.0 / self.weight;
        (
            self.sum_m.map(|sum| share * sum),
            self.covariance_m2.map(|sum| share * share * sum),
        )
    }
}

/// Returns the source with a mean apart from all others, and the squared statistical length; `None` if a second source
/// comes near, or for two sources.
pub fn odd_one(means: &mut [MeanInnovation]) -> Option<(usize, f64)> {
    let others = Others::of(means).filter(|_| means.len() > 2)?;
    let length = |own: &MeanInnovation| {
        let (others_m, others_m2) = others.beside(own);
        let (by_m, covariance_m2) = own.apart(&others_m, &others_m2);
        squared2(by_m, covariance_m2)
    };
    let (mut best, mut second) = ((0, f64::NEG_INFINITY), 0.0_f64);
    for (place, own) in means.iter().enumerate() {
        let length = length(own);
        if length > best.1 {
            second = second.max(best.1);
            best = (place, length);
        } else {
            second = second.max(length);
        }
    }
    (second < SECOND_MAX * best.1).then_some((means[best.0].source, best.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(source: usize, east_m: f64, variance_m2: f64) -> MeanInnovation {
        MeanInnovation {
            source,
            mean_m: [east_m, 0.0],
            covariance_m2: [variance_m2, 0.0, variance_m2],
        }
    }

    #[test]
    fn the_odd_one_is_apart_from_all_others_whatever_it_states() {
        for variance_m2 in [0.01, 4.0, 100.0] {
            // The filter follows the outlier wholly, half, or not at all.
            for followed in [0.0, 0.5, 1.0] {
                let others_m = -60.0 * followed;
                let mut means = [
                    mean(3, others_m, 4.0),
                    mean(1, 60.0 + others_m, variance_m2),
                    mean(2, others_m, 9.0),
                ];
                assert_eq!(
                    odd_one(&mut means).map(|(source, _)| source),
                    Some(1),
                    "{variance_m2}, {followed}"
                );
            }
        }
    }

    #[test]
    fn of_two_and_of_two_that_are_apart_none_is_the_odd_one() {
        assert_eq!(odd_one(&mut [mean(0, 50.0, 1.0), mean(1, 0.0, 1.0)]), None);
        let mut means = [mean(0, 50.0, 1.0), mean(1, 0.0, 1.0), mean(2, -50.0, 1.0)];
        assert_eq!(odd_one(&mut means), None);
        let mut turn = [mean(0, 50.0, 1.0), mean(1, 50.0, 1.0), mean(2, 50.0, 1.0)];
        assert!(odd_one(&mut turn).is_none_or(|(_, length)| length < 1.0));
    }
}

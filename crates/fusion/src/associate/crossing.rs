//! Crossed sensor tracks: a source has two targets side by side, and each track belongs to the other's system track
//! (BF-2).
//!
//! With long error ellipses, the first reports of a formation do not determine their target among two, and a sensor
//! track stays where it was associated. Later the sources can decide, by the *difference* of their two tracks: dₛ as
//! seen by source s, with covariance Sₛ. Errors common to both targets, above all biases, cancel in the difference.
//! Let σₛ be −1 for crossed sources and +1 for others. The likelihood of all differences, with an estimate of the true
//! difference, grows with ½·vᵀ·Λ⁻¹·v, where v = Σ σₛ·Sₛ⁻¹·dₛ and Λ = Σ Sₛ⁻¹. All σ are tried; the log-likelihood ratio
//! of a source is the best value with the source crossed minus the best value without. The ratios of the source's
//! reports are summed while the same two system tracks are concerned (E. S. Page, *Continuous inspection schemes*,
//! 1954).

use estimation::Estimate;
use messages::{NS_PER_S, SensorTrack};
use nalgebra::{Matrix2, Vector2};
use source_models::gaussian_of;

use crate::associate::association_step::Search;
use crate::tables::sensor_tracks::{Role, SensorEntry, SensorSlot};
use crate::tables::system_tracks::SystemSlot;

/// Sum of log-likelihood ratios from which a sensor track is crossed.
pub(crate) const CROSSED: f64 = 5.0;
/// Share of a ratio that is new relative to the previous ratio: the errors of a source's tracks are correlated from
/// report to report.
const NEW_SHARE: f64 = 0.5;
/// Largest number of sources compared for two targets: each subset is a sign pattern to try.
const COMPARED_MAX: usize = 6;
/// Number of reports of a sensor track between two checks: near another target or after the start, and otherwise.
const EVERY: [u32; 2] = [2, 8];
/// Number of these first reports.
const FIRST_REPORTS: u32 = 16;

/// Two system tracks between which a source's sensor tracks may be crossed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// The other system track.
    pub(crate) there: SystemSlot,
    /// Log-likelihood ratio.
    pub(crate) ratio: f64,
    /// Sensor tracks here and there, a pair for each source of both.
    pairs: Pairs,
    /// Sensor tracks to exchange, as bits.
    crossed: u32,
}

type Pairs = [(SensorSlot, SensorSlot); COMPARED_MAX];

impl Crossing {
    /// The sensor tracks here and there that should change places, a pair for each source.
    pub(crate) fn crossed(&self) -> impl Iterator<Item = (SensorSlot, SensorSlot)> {
        let crossed = self.crossed;
        (0..COMPARED_MAX)
            .filter(move |index| crossed & 1 << index != 0)
            .map(|index| self.pairs[index])
    }
}

/// Returns whether a check of a sensor track for crossing is due.
pub(crate) fn is_due(entry: &SensorEntry) -> bool {
    let is_pressing = entry.reports < FIRST_REPORTS || entry.crossed.is_some();
    entry.role == Role::Primary && !entry.is_foreign && entry.reports.is_multiple_of(EVERY[usize::from(!is_pressing)])
}

impl Search<'_> {
    /// Returns the system track most likely crossed with that of `own`; `None` if the source tracks no other target
    /// nearby.
    pub(crate) fn crossing(&self, own: SensorSlot) -> Option<Crossing> {
        let entry = self.tracks.sensors.get(own);
        let mut best: Option<Crossing> = None;
        self.near(&entry.latest, &gaussian_of(&entry.latest), |there| {
            if there != entry.system
                && let Some(found) = self.crossing_between(own, there)
                && best.is_none_or(|best| (found.ratio, best.there) > (best.ratio, there))
            {
                best = Some(found);
            }
        });
        best
    }

    fn crossing_between(&self, own: SensorSlot, there: SystemSlot) -> Option<Crossing> {
        let entry = self.tracks.sensors.get(own);
        let (here, now_ns) = (entry.system, entry.time_ns);
        self.tracks.primary_of(there, entry.source, own, now_ns)?;
        let mut pairs = Pairs::default();
        let (mut information, mut seen) = (Matrix2::zeros(), [SourceEvidence::default(); COMPARED_MAX]);
        let both = self.tracks.contributing_here(here, now_ns).filter_map(|mine| {
            let source = self.tracks.sensors.get(mine).source;
            Some((mine, self.tracks.primary_of(there, source, mine, now_ns)?))
        });
        let (mut count, mut own_bit) = (0, 0);
        for (mine, theirs) in both.take(COMPARED_MAX) {
            let [a, b] = [mine, theirs].map(|sensor| &self.tracks.sensors.get(sensor).latest);
            if !self.is_compatible(a, there) || !self.is_compatible(b, here) {
                return None;
            }
            let points_m2 = 2.0
                * self
                    .tracks
                    .sources
                    .spread_m2(&self.settings.association, Some(a.source));
            let (from, to) = (horizontal(a, now_ns), horizontal(b, now_ns));
            let inverse = (from.covariance + to.covariance + Matrix2::identity() * points_m2).try_inverse()?;
            information += inverse;
            let shares = [mine, theirs].map(|sensor| self.tracks.sensors.get(sensor).share);
            seen[count] = SourceEvidence {
                pull: inverse * (to.mean - from.mean),
                share: shares[0] + shares[1],
            };
            pairs[count] = (mine, theirs);
            if mine == own {
                own_bit = 1 << count;
            }
            count += 1;
        }
        let (ratio, crossed) = most_likely(&seen[..count], &information.try_inverse()?, own_bit)?;
        Some(Crossing {
            there,
            ratio,
            pairs,
            crossed,
        })
    }
}

/// Difference of a source's tracks of two targets.
#[derive(Clone, Copy, Debug, Default)]
struct SourceEvidence {
    /// Sₛ⁻¹·dₛ.
    pull: Vector2<f64>,
    /// Share of the source in the two system tracks together.
    share: f64,
}

/// Returns the most likely set of crossed sources with `own_bit`, as bits, and its log-likelihood ratio to the most
/// likely set without `own_bit`, given Λ⁻¹. A set never has more than half of the shares: otherwise the other sources
/// are crossed. Thus the states change least, and numbers stay with their targets.
fn most_likely(seen: &[SourceEvidence], covariance: &Matrix2<f64>, own_bit: u32) -> Option<(f64, u32)> {
    let sign = |crossed: u32, index: usize| if crossed & 1 << index == 0 { 1.0 } else { -1.0 };
    let (mut with, mut without) = (None, f64::NEG_INFINITY);
    for crossed in 0..1_u32 << seen.len() {
        let (mut pull, mut majority) = (Vector2::zeros(), 0.0);
        for (index, seen) in seen.iter().enumerate() {
            pull += sign(crossed, index) * seen.pull;
            majority += sign(crossed, index) * seen.share;
        }
        let has_own = crossed & own_bit != 0;
        // Of two halves, the half of the asking source is crossed.
        if majority < 0.0 || (majority == 0.0 && !has_own) {
            continue;
        }
        let log_likelihood = 0.5 * pull.dot(&(covariance * pull));
        if !has_own {
            without = f64::max(without, log_likelihood);
        } else if with.is_none_or(|(most, _)| log_likelihood > most) {
            with = Some((log_likelihood, crossed));
        }
    }
    with.map(|(value, crossed)| (NEW_SHARE * (value - without), crossed))
}

/// The horizontal position that a report gives for `now_ns`.
fn horizontal(report: &SensorTrack, now_ns: i64) -> Estimate<2> {
    let seconds = (now_ns - report.time_of_measurement_ns) as f64 / NS_PER_S;
    let state = gaussian_of(report).moved(seconds, Default::default());
    let [xx, xy, _, yy, ..] = state.position_covariance();
    Estimate {
        mean: Vector2::new(state.mean[0], state.mean[1]),
        covariance: Matrix2::new(xx, xy, xy, yy),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [`most_likely`] of differences with standard deviations along each axis, asked by the first source.
    fn asked(seen: &[([f64; 2], [f64; 2])]) -> (f64, u32) {
        let mut information = Matrix2::zeros();
        let seen: Vec<_> = seen
            .iter()
            .map(|(apart_m, sigma_m)| {
                let inverse = Matrix2::from_diagonal(&Vector2::from(sigma_m.map(|sigma| 1.0 / (sigma * sigma))));
                information += inverse;
                SourceEvidence {
                    pull: inverse * Vector2::from(*apart_m),
                    share: 1.0,
                }
            })
            .collect();
        most_likely(&seen, &information.try_inverse().unwrap(), 1).unwrap()
    }

    #[test]
    fn the_one_that_sees_the_difference_the_other_way_round_is_crossed() {
        let others = [([300.0, 0.0], [50.0, 400.0]), ([280.0, 10.0], [200.0, 50.0])];
        let crossed = asked(&[([-300.0, 0.0], [100.0, 100.0]), others[0], others[1]]);
        // If the second were crossed, the third's 280/200² would be on the other side of v = 300/100² + 300/50² +
        // 280/200²: half of the resulting decrease of ½·v²/Λ, with Λ = 1/100² + 1/50² + 1/200².
        assert!((crossed.0 - 2.0).abs() < 0.01 && crossed.1 == 1, "{crossed:?}");
        let right = asked(&[([300.0, 0.0], [100.0, 100.0]), others[0], others[1]]);
        assert!(right.0 < -3.0, "{right:?}");
    }

    #[test]
    fn one_that_cannot_know_says_nothing_and_two_of_four_turn_together() {
        let across = asked(&[([-300.0, 0.0], [5e3, 10.0]), ([300.0, 0.0], [50.0, 400.0])]);
        assert!(across.0.abs() < 0.1, "{across:?}");
        let (one, other) = (([300.0, 0.0], [50.0, 50.0]), ([-300.0, 0.0], [50.0, 50.0]));
        assert_eq!(asked(&[one, other, one, other]).1, 0b0101);
        assert_eq!(asked(&[other, one, one, one]).1, 0b0001);
        assert!(asked(&[one, other, one, one]).0 < 0.0);
    }
}

//! Search of the state that explains a prior and lines of bearing best: Gauss–Newton iteration with robust weights.

use kept::kept;
use nalgebra::{SMatrix, SVector};

use crate::kinematics::{position, sensitivity};
use crate::line_of_bearing::LineOfBearing;
pub(crate) use crate::line_of_bearing::{DEVIATION_MAX, KNEE};
use crate::linear::Factor;

/// Steps of less than this squared statistical length are not worth another round.
const STEP_SQUARED_MIN: f64 = 1e-4;
/// A first fix is believed if the cost is at most so many standard deviations more than expected.
const COST_SIGMAS: f64 = 4.0;
/// … and if at most a single line in so many lines is far off.
const LINES_PER_OUTLIER: usize = 10;
/// Lines that fit beside a wrong arrival time: two fit anywhere, and two more confirm the fit.
const ARRIVALS_MIN: usize = 4;

/// Prior knowledge of a state.
#[derive(Clone, Debug)]
pub(crate) struct StatePrior<const D: usize> {
    pub(crate) mean: SVector<f64, D>,
    pub(crate) information: SMatrix<f64, D, D>,
}

impl<const D: usize> Default for StatePrior<D> {
    fn default() -> Self {
        Self {
            mean: SVector::zeros(),
            information: SMatrix::zeros(),
        }
    }
}

/// Prior and lines that a state at the reference time is to explain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeastSquaresProblem<'a, const D: usize> {
    pub(crate) reference_ns: i64,
    pub(crate) prior: &'a StatePrior<D>,
    pub(crate) lines: &'a [LineOfBearing],
}

/// Problem, linearised at a state.
pub(crate) struct System<const D: usize> {
    pub(crate) information: SMatrix<f64, D, D>,
    pub(crate) gradient: SVector<f64, D>,
    pub(crate) cost: f64,
    /// Number of lines, and number of these far off: bearings and fixes, and arrival times.
    lines: [usize; 2],
    outliers: [usize; 2],
    /// Cost of the lines that are not far off.
    cost_of_others: f64,
}

/// Result of a search.
pub(crate) struct SearchResult<const D: usize> {
    pub(crate) state: SVector<f64, D>,
    pub(crate) covariance: SMatrix<f64, D, D>,
    pub(crate) has_converged: bool,
    /// Cost of prior and lines.
    pub(crate) cost: f64,
    /// Whether the lines fit together.
    pub(crate) is_plausible: bool,
}

impl<const D: usize> System<D> {
    /// Whether the lines fit together: few are far off, and the cost of the others is chi-square with about as
    /// many degrees of freedom as there are lines.
    fn is_plausible(&self) -> bool {
        let freedom = (self.lines[0] + self.lines[1]) as f64;
        self.outliers[0] <= self.lines[0] / LINES_PER_OUTLIER
            && self.most_arrivals_fit()
            && self.cost_of_others < freedom + COST_SIGMAS * (2.0 * freedom).sqrt() + COST_SIGMAS
    }
}

impl<const D: usize> System<D> {
    /// Whether most arrival times fit, and, if some do not, enough others confirm the position.
    pub(crate) fn most_arrivals_fit(&self) -> bool {
        let [_, wrong] = self.outliers;
        let fitting = self.lines[0] - self.outliers[0] + self.lines[1] - wrong;
        wrong == 0 || (2 * wrong < self.lines[1] && fitting >= ARRIVALS_MIN)
    }

    /// Cost in which all lines that are far off count the same.
    pub(crate) fn flat_cost(&self) -> f64 {
        self.cost_of_others + KNEE * (self.outliers[0] + self.outliers[1]) as f64
    }
}

impl<const D: usize> LeastSquaresProblem<'_, D> {
    /// Searches from `start`, with all lines linearised anew in each round. `None` if the lines do not determine a
    /// state.
    pub(crate) fn search(&self, start: SVector<f64, D>, rounds: usize) -> Option<SearchResult<D>> {
        self.search_with(start, rounds, KNEE)
    }

    /// … where lines count less from this squared normalised innovation on.
    pub(crate) fn search_with(&self, start: SVector<f64, D>, rounds: usize, knee: f64) -> Option<SearchResult<D>> {
        let mut at = start;
        let mut system = self.linearised_with(&at, knee);
        let mut has_converged = false;
        for _ in 0..rounds {
            let step = Factor::of(&system.information)?.solve(&system.gradient);
            if system.gradient.dot(&step) < STEP_SQUARED_MIN {
                has_converged = true;
                at += step;
                break;
            }
            let Some((next, there)) = self.descend(&at, &step, &system, knee) else {
                break;
            };
            (at, system) = (next, there);
        }
        Some(SearchResult {
            state: at,
            covariance: Factor::of(&system.information)?.inverse(),
            has_converged,
            cost: system.cost,
            is_plausible: system.is_plausible(),
        })
    }

    /// Returns the state after a step along `step` at which prior and lines fit better. A step goes at most half of
    /// the way to the platform.
    fn descend(
        &self,
        at: &SVector<f64, D>,
        step: &SVector<f64, D>,
        system: &System<D>,
        knee: f64,
    ) -> Option<(SVector<f64, D>, System<D>)> {
        let range = self
            .lines
            .last()
            .map_or(f64::MAX, |last| last.distance_m([at[0], at[1]]));
        let length = step[0].hypot(step[1]);
        let mut share = (0.5 * range / length.max(f64::MIN_POSITIVE)).min(1.0);
        for _ in 0..5 {
            let next = at + step * share;
            let there = self.linearised_with(&next, knee);
            if there.cost <= system.cost {
                return Some((next, there));
            }
            share *= 0.4;
        }
        None
    }

    /// Linearises the problem at a state.
    pub(crate) fn linearised(&self, at: &SVector<f64, D>) -> System<D> {
        self.linearised_with(at, KNEE)
    }

    /// … where lines count less from this squared normalised innovation on.
    pub(crate) fn linearised_with(&self, at: &SVector<f64, D>, knee: f64) -> System<D> {
        let offset = self.prior.mean - at;
        let gradient = self.prior.information * offset;
        let mut system = System {
            information: self.prior.information,
            gradient,
            cost: offset.dot(&gradient),
            lines: [0; 2],
            outliers: [0; 2],
            cost_of_others: 0.0,
        };
        // In arrays, whose elements stay in registers from line to line.
        let (information, gradient) = (&mut system.information.data.0, &mut system.gradient.data.0[0]);
        for line in self.lines.iter().filter(|line| line.is_used) {
            let after_s = line.after_s(self.reference_ns);
            let Some(residual) = line.residual(position(at, after_s)) else {
                continue;
            };
            let h = sensitivity::<D>(residual.gradient, after_s).data.0[0];
            let squared = residual.innovation_rad * residual.innovation_rad * line.information;
            let (cost, weight) = robust(squared, knee);
            system.cost += cost;
            let kind = usize::from(line.has_outliers());
            system.lines[kind] += 1;
            match weight < 1.0 {
                true => system.outliers[kind] += 1,
                false => system.cost_of_others += cost,
            }
            let weighted = weight * line.information;
            let innovation = weighted * residual.innovation_rad;
            let scaled = h.map(|value| value * weighted);
            for (sum, value) in gradient.iter_mut().zip(h) {
                *sum += value * innovation;
            }
            for (column, value) in information.iter_mut().zip(h) {
                for (sum, scaled) in column.iter_mut().zip(scaled) {
                    *sum += scaled * value;
                }
            }
        }
        system
    }

    /// Cost of prior and lines at a state, as that of [`Self::linearised`].
    pub(crate) fn cost(&self, at: &SVector<f64, D>) -> f64 {
        let offset = self.prior.mean - at;
        let mut cost = offset.dot(&(self.prior.information * offset));
        for line in self.lines.iter().filter(|line| line.is_used) {
            let place = position(at, line.after_s(self.reference_ns));
            if let Some(residual) = line.residual(place) {
                let squared = residual.innovation_rad * residual.innovation_rad * line.information;
                cost += robust(squared, KNEE).0;
            }
        }
        cost
    }
}

/// Cost and weight of a squared normalised innovation: least squares up to the knee; beyond it the weight of Cauchy's
/// estimator, so that the influence of a line falls with the error.
fn robust(squared: f64, knee: f64) -> (f64, f64) {
    if squared <= knee {
        (squared, 1.0)
    } else {
        (knee * (1.0 + (squared / knee).ln()), knee / squared)
    }
}

kept!(StatePrior<2> {
    mean: SVector<f64, 2>,
    information: SMatrix<f64, 2, 2>,
});
kept!(StatePrior<4> {
    mean: SVector<f64, 4>,
    information: SMatrix<f64, 4, 4>,
});

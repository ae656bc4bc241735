//! Measurement models (HT-12): each kind of detection with measured quantities and errors.
//!
//! Sensors of different kinds feed the same tracker, so a detection is never turned into a position first: a bearing
//! alone has no position, and that of a distant radar plot is a narrow ellipse across the beam. Instead the state is
//! compared in the sensor's own quantities. These are nonlinear functions of the state; the extended Kalman filter
//! takes the tangent at the prediction, H. With S = H·P·Hᵀ + R = L·Lᵀ, the innovation has the squared length |L⁻¹·ν|²,
//! and the update is that of `estimation`, with W = L⁻¹·H·P: x + Wᵀ·L⁻¹·ν and P − Wᵀ·W.
//!
//! Limits: a tangent is good where the state is known to within a few degrees of direction. A track that was begun by
//! position and is continued by bearings stays so; bearings alone do not begin tracks ([`crate::initiation`]).
//!
//! Source: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and Navigation* (Wiley,
//! 2001), chapters 5 and 10.

use std::f64::consts::{PI, TAU};

use estimation::Gaussian;
use messages::{AXES, STATE_LEN};
use observations::{Detection, DetectionKind, QUANTITIES_MAX, Quantity};

use crate::turn::TurnRate;

/// Most quantities of a detection: three and the range rate.
pub(crate) const DIMENSIONS_MAX: usize = QUANTITIES_MAX + 1;
/// Squared horizontal distance, m², below which a sensor is at the target, and a direction is without information.
const AT_SENSOR_M2: f64 = 1e-6;

/// The measured part of a detection, with standard deviations of every quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DetectionMeasurement {
    pub(crate) kind: DetectionKind,
    pub(crate) values: [f64; QUANTITIES_MAX],
    pub(crate) range_rate_mps: Option<f64>,
    /// In the order of the values, the range rate's last.
    pub(crate) sigmas: [f64; DIMENSIONS_MAX],
    pub(crate) platform_m: [f64; AXES],
}

/// Innovation of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeasurementInnovation {
    /// Quantities compared.
    pub(crate) dimension: usize,
    /// Chi-square with as many degrees of freedom, if all is as modelled.
    pub(crate) squared_distance: f64,
    /// Logarithm of the density of the measurement, per unit of each quantity.
    pub(crate) log_likelihood: f64,
}

/// A quantity at a state: innovation and derivative.
#[derive(Clone, Copy, Debug)]
struct Tangent {
    residual: f64,
    derivative: [f64; STATE_LEN],
    variance: f64,
}

impl DetectionMeasurement {
    /// The measured part of a detection; `None` if a value or standard deviation is missing or no fit number.
    pub(crate) fn of(detection: &Detection, default_sigmas: Option<[f64; DIMENSIONS_MAX]>) -> Option<Self> {
        let sigmas = detection.sigmas.or(default_sigmas)?;
        let count = detection.kind.quantities().len();
        let faultless = |(quantity, value): (&Quantity, f64)| value.is_finite() && quantity.fault(value).is_none();
        let mut quantities = detection.kind.quantities().iter().zip(detection.values);
        let fit = |sigma: f64| sigma.is_finite() && sigma > 0.0;
        let whole = quantities.all(faultless)
            && sigmas[..count].iter().all(|sigma| fit(*sigma))
            && detection.platform_m.iter().all(|value| value.is_finite())
            && detection
                .range_rate_mps
                .is_none_or(|rate| rate.is_finite() && fit(sigmas[QUANTITIES_MAX]));
        whole.then_some(Self {
            kind: detection.kind,
            values: detection.values,
            range_rate_mps: detection.range_rate_mps,
            sigmas,
            platform_m: detection.platform_m,
        })
    }

    /// Position in the plane, with the largest standard deviation in any direction, metres; `None` of a direction
    /// alone.
    pub(crate) fn place(&self) -> Option<([f64; 2], f64)> {
        let [a, b, elevation] = self.values;
        match self.kind {
            DetectionKind::Position2 | DetectionKind::Position3 => Some(([a, b], self.sigmas[0].max(self.sigmas[1]))),
            DetectionKind::RangeBearing | DetectionKind::RangeBearingElevation => {
                let upward = self.kind == DetectionKind::RangeBearingElevation;
                let ground = if upward { a * elevation.cos() } else { a };
                let across = self.sigmas[1].max(if upward { self.sigmas[2] } else { 0.0 });
                let place = [
                    self.platform_m[0] + ground * b.sin(),
                    self.platform_m[1] + ground * b.cos(),
                ];
                Some((place, self.sigmas[0].max(a * across)))
            }
            DetectionKind::Bearing | DetectionKind::BearingElevation => None,
        }
    }

    /// Measured place with the measured height, else with the height `up_m`, metres; `None` for a direction.
    pub(crate) fn position(&self, up_m: f64) -> Option<[f64; 3]> {
        let ([east, north], _) = self.place()?;
        let up = match self.kind {
            DetectionKind::Position3 => self.values[2],
            DetectionKind::RangeBearingElevation => self.platform_m[2] + self.values[0] * self.values[2].sin(),
            _ => up_m,
        };
        Some([east, north, up])
    }

    /// Whether the height is a part of the measurement.
    pub(crate) fn has_height(&self) -> bool {
        use DetectionKind::{BearingElevation, Position3, RangeBearingElevation};
        matches!(self.kind, Position3 | RangeBearingElevation | BearingElevation)
    }

    /// The mean of several measurements with a common error: with the weight `weight` ≤ 1, the standard deviations are
    /// larger.
    pub(crate) fn weighted(&self, weight: f64) -> Self {
        let sigmas = self.sigmas.map(|sigma| sigma / weight.sqrt());
        Self { sigmas, ..*self }
    }

    /// Compares with a predicted state; `None` if that cannot be done in numbers.
    pub(crate) fn innovation(&self, state: &Gaussian) -> Option<MeasurementInnovation> {
        let mut tangents = Tangents::of(self, state)?;
        tangents.factorise(state)?;
        tangents.innovation()
    }

    /// Updates a predicted state; `None`, and no change, if that cannot be done in numbers.
    pub(crate) fn update(&self, state: &mut Gaussian) -> Option<MeasurementInnovation> {
        let mut tangents = Tangents::of(self, state)?;
        tangents.factorise(state)?;
        let innovation = tangents.innovation()?;
        tangents.apply(state);
        Some(innovation)
    }

    /// Updates a predicted state with the turn rate; `None`, and no change, if that cannot be done in numbers.
    pub(crate) fn update_turning(&self, state: &mut Gaussian, turn: &mut TurnRate) -> Option<MeasurementInnovation> {
        let mut tangents = Tangents::of(self, state)?;
        tangents.factorise(state)?;
        let innovation = tangents.innovation()?;
        let of_turn = tangents.gain_of(&turn.cross());
        let count = tangents.count;
        turn.learn(&tangents.whitened[..count], &tangents.gain[..count], &of_turn[..count]);
        tangents.apply(state);
        Some(innovation)
    }

    /// Updates a predicted state as either of two targets with a single detection between both; `other` is the state of
    /// the other target. `None`, and no change, if that cannot be done in numbers.
    pub(crate) fn update_half(&self, state: &mut Gaussian, other: &Gaussian) -> Option<MeasurementInnovation> {
        let mut tangents = Tangents::of(self, &middle(state, other))?;
        for tangent in &mut tangents.each[..tangents.count] {
            tangent.derivative.iter_mut().for_each(|element| *element *= 0.5);
            for (row, of_row) in tangent.derivative.iter().enumerate() {
                for (column, of_column) in tangent.derivative.iter().enumerate() {
                    tangent.variance += of_row * of_column * other.covariance.get(row, column);
                }
            }
        }
        tangents.factorise(state)?;
        let innovation = tangents.innovation()?;
        tangents.apply(state);
        Some(innovation)
    }

    /// Updates by the range rate alone, if measured.
    pub(crate) fn update_range_rate(&self, state: &mut Gaussian) {
        let Some(sight) = LineOfSight::of(self, state) else {
            return;
        };
        let Some(tangent) = self.range_rate_tangent(&sight, state) else {
            return;
        };
        let mut tangents = Tangents::NONE;
        tangents.push(tangent);
        if tangents.factorise(state).is_some() {
            tangents.apply(state);
        }
    }

    fn range_rate_tangent(&self, sight: &LineOfSight, state: &Gaussian) -> Option<Tangent> {
        let rate = self.range_rate_mps?;
        let velocity = state.velocity_mps();
        let along: f64 = (0..AXES).map(|axis| sight.direction(axis) * velocity[axis]).sum();
        let mut derivative = [0.0; STATE_LEN];
        for axis in 0..AXES {
            derivative[axis] = (velocity[axis] - along * sight.direction(axis)) / sight.range_m;
            derivative[axis + AXES] = sight.direction(axis);
        }
        Some(Tangent {
            residual: rate - along,
            derivative,
            variance: self.sigmas[QUANTITIES_MAX].powi(2),
        })
    }
}

/// The line from sensor to state.
struct LineOfSight {
    /// East, north, up, metres.
    line_m: [f64; AXES],
    range_m: f64,
    ground_m2: f64,
}

impl LineOfSight {
    /// `None` where the state is at the sensor.
    fn of(measurement: &DetectionMeasurement, state: &Gaussian) -> Option<Self> {
        let position = state.position_m();
        let line_m: [f64; AXES] = std::array::from_fn(|axis| position[axis] - measurement.platform_m[axis]);
        let [east, north, up] = line_m;
        let ground_m2 = east * east + north * north;
        (ground_m2 > AT_SENSOR_M2).then_some(Self {
            line_m,
            range_m: (ground_m2 + up * up).sqrt(),
            ground_m2,
        })
    }

    fn direction(&self, axis: usize) -> f64 {
        self.line_m[axis] / self.range_m
    }

    /// Predicted value of a quantity, and the derivative by position.
    fn quantity(&self, quantity: Quantity) -> (f64, [f64; AXES]) {
        let [east, north, up] = self.line_m;
        match quantity {
            Quantity::Range => (self.range_m, std::array::from_fn(|axis| self.direction(axis))),
            Quantity::Bearing => (east.atan2(north), [north / self.ground_m2, -east / self.ground_m2, 0.0]),
            Quantity::Elevation => {
                let ground = self.ground_m2.sqrt();
                let r2 = self.range_m * self.range_m;
                let fall = -up / (r2 * ground);
                (up.atan2(ground), [fall * east, fall * north, ground / r2])
            }
            Quantity::East | Quantity::North | Quantity::Up => unreachable!("a position is not a line of sight"),
        }
    }
}

/// All quantities of a measurement at a state; after factorising, L and W.
struct Tangents {
    count: usize,
    each: [Tangent; DIMENSIONS_MAX],
    lower: [[f64; DIMENSIONS_MAX]; DIMENSIONS_MAX],
    /// L⁻¹·ν.
    whitened: [f64; DIMENSIONS_MAX],
    /// L⁻¹·H·P.
    gain: [[f64; STATE_LEN]; DIMENSIONS_MAX],
}

impl Tangents {
    const NONE: Self = Self {
        count: 0,
        each: [Tangent {
            residual: 0.0,
            derivative: [0.0; STATE_LEN],
            variance: 0.0,
        }; DIMENSIONS_MAX],
        lower: [[0.0; DIMENSIONS_MAX]; DIMENSIONS_MAX],
        whitened: [0.0; DIMENSIONS_MAX],
        gain: [[0.0; STATE_LEN]; DIMENSIONS_MAX],
    };

    fn push(&mut self, tangent: Tangent) {
        self.each[self.count] = tangent;
        self.count += 1;
    }

    fn of(measurement: &DetectionMeasurement, state: &Gaussian) -> Option<Self> {
        let mut tangents = Self::NONE;
        let is_position = matches!(measurement.kind, DetectionKind::Position2 | DetectionKind::Position3);
        let sight = if is_position && measurement.range_rate_mps.is_none() {
            None
        } else {
            Some(LineOfSight::of(measurement, state)?)
        };
        for (place, quantity) in measurement.kind.quantities().iter().enumerate() {
            let mut derivative = [0.0; STATE_LEN];
            let predicted = match (&sight, is_position) {
                (Some(sight), false) => {
                    let (value, by_position) = sight.quantity(*quantity);
                    derivative[..AXES].copy_from_slice(&by_position);
                    value
                }
                _ => {
                    derivative[place] = 1.0;
                    state.mean[place]
                }
            };
            let mut residual = measurement.values[place] - predicted;
            if *quantity == Quantity::Bearing {
                residual = (residual + PI).rem_euclid(TAU) - PI;
            }
            tangents.push(Tangent {
                residual,
                derivative,
                variance: measurement.sigmas[place].powi(2),
            });
        }
        if let Some(tangent) = sight.and_then(|sight| measurement.range_rate_tangent(&sight, state)) {
            tangents.push(tangent);
        }
        Some(tangents)
    }

    /// `None` if S is not positive definite.
    fn factorise(&mut self, state: &Gaussian) -> Option<()> {
        let p = &state.covariance;
        for row in 0..self.count {
            let mut products = [0.0; STATE_LEN];
            // Most derivatives are zero.
            for (k, h) in self.each[row].derivative.iter().enumerate().filter(|(_, h)| **h != 0.0) {
                for (column, product) in products.iter_mut().enumerate() {
                    *product += h * p.get(k, column);
                }
            }
            self.gain[row] = products;
        }
        for row in 0..self.count {
            // H·P is in `gain` for this row and all rows below; the rows above are already whitened.
            let hp = self.gain[row];
            let mut residual = self.each[row].residual;
            let mut whitened = hp;
            let mut diagonal = self.each[row].variance + dot(&hp, &self.each[row].derivative);
            for k in 0..row {
                // (L⁻¹·H·P)ₖ·Hᵀ is L's element in this row.
                let l = dot(&self.gain[k], &self.each[row].derivative);
                self.lower[row][k] = l;
                diagonal -= l * l;
                residual -= l * self.whitened[k];
                for (value, above) in whitened.iter_mut().zip(&self.gain[k]) {
                    *value -= l * above;
                }
            }
            // Written so that NaN is rejected.
            if !(diagonal > 0.0 && diagonal.is_finite()) {
                return None;
            }
            let root = diagonal.sqrt();
            self.lower[row][row] = root;
            self.whitened[row] = residual / root;
            self.gain[row] = whitened.map(|value| value / root);
        }
        Some(())
    }

    /// L⁻¹·H·c for a component outside the state, with covariances c between that component and the state.
    fn gain_of(&self, cross: &[f64; STATE_LEN]) -> [f64; DIMENSIONS_MAX] {
        let mut gain = [0.0; DIMENSIONS_MAX];
        for row in 0..self.count {
            let above: f64 = (0..row).map(|k| self.lower[row][k] * gain[k]).sum();
            gain[row] = (dot(&self.each[row].derivative, cross) - above) / self.lower[row][row];
        }
        gain
    }

    fn innovation(&self) -> Option<MeasurementInnovation> {
        let squared_distance: f64 = self.whitened[..self.count].iter().map(|value| value * value).sum();
        let determinant: f64 = (0..self.count).map(|row| self.lower[row][row]).product();
        let log_likelihood = -0.5 * squared_distance - determinant.ln() - 0.5 * self.count as f64 * TAU.ln();
        log_likelihood.is_finite().then_some(MeasurementInnovation {
            dimension: self.count,
            squared_distance,
            log_likelihood,
        })
    }

    fn apply(&self, state: &mut Gaussian) {
        for (w, whitened) in self.gain[..self.count].iter().zip(&self.whitened) {
            for row in 0..STATE_LEN {
                state.mean[row] += w[row] * whitened;
                for column in row..STATE_LEN {
                    let value = state.covariance.get(row, column) - w[row] * w[column];
                    state.covariance.set(row, column, value);
                }
            }
        }
    }
}

/// Half of the sum of two independent states.
pub(crate) fn middle(one: &Gaussian, other: &Gaussian) -> Gaussian {
    let mut middle = *one;
    for (value, other) in middle.mean.iter_mut().zip(other.mean) {
        *value = 0.5 * (*value + other);
    }
    let elements = middle.covariance.upper.iter_mut();
    for (element, other) in elements.zip(other.covariance.upper) {
        *element = 0.25 * (*element + other);
    }
    middle
}

fn dot(a: &[f64; STATE_LEN], b: &[f64; STATE_LEN]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use messages::Covariance;
    use proptest::prelude::*;

    use super::*;

    fn state(mean: [f64; STATE_LEN]) -> Gaussian {
        let mut covariance = Covariance::diagonal([30.0, 40.0, 50.0], [5.0, 6.0, 7.0]);
        covariance.set(0, 3, 60.0);
        covariance.set(1, 4, -80.0);
        covariance.set(0, 1, 200.0);
        Gaussian { mean, covariance }
    }

    fn any_measurement() -> impl Strategy<Value = DetectionMeasurement> {
        let kind = prop::sample::select(DetectionKind::ALL.to_vec());
        let rate = prop::option::of(-100.0..100.0f64);
        let platform = prop::array::uniform3(-100.0..100.0f64);
        (kind, rate, platform).prop_map(|(kind, range_rate_mps, platform_m)| DetectionMeasurement {
            kind,
            values: [0.3, 0.2, 0.1],
            range_rate_mps,
            sigmas: if matches!(kind, DetectionKind::Bearing | DetectionKind::BearingElevation) {
                [0.01, 0.02, 0.0, 2.0]
            } else if kind == DetectionKind::RangeBearing || kind == DetectionKind::RangeBearingElevation {
                [20.0, 0.01, 0.02, 2.0]
            } else {
                [20.0, 30.0, 40.0, 2.0]
            },
            platform_m,
        })
    }

    fn any_state() -> impl Strategy<Value = Gaussian> {
        let far = prop_oneof![300.0..5e3f64, -5e3..-300.0f64];
        (prop::array::uniform2(far), prop::array::uniform4(-100.0..100.0f64))
            .prop_map(|([east, north], [up, a, b, c])| state([east, north, up, a, b, c]))
    }

    proptest! {
        #[test]
        fn derivatives_are_those_of_the_quantities(measurement in any_measurement(), at in any_state()) {
            let tangents = Tangents::of(&measurement, &at).unwrap();
            for component in 0..STATE_LEN {
                let step = 1e-2;
                let moved = |by: f64| {
                    let mut moved = at;
                    moved.mean[component] += by;
                    Tangents::of(&measurement, &moved).unwrap()
                };
                let (before, after) = (moved(-step), moved(step));
                for row in 0..tangents.count {
                    // Predicted is measured less residual.
                    let mut change = before.each[row].residual - after.each[row].residual;
                    if change.abs() > PI && measurement.kind.quantities().get(row) == Some(&Quantity::Bearing) {
                        change -= TAU.copysign(change);
                    }
                    let numeric = change / (2.0 * step);
                    let exact = tangents.each[row].derivative[component];
                    prop_assert!((numeric - exact).abs() < 1e-6 * (1.0 + exact.abs()), "{numeric} {exact}");
                }
            }
        }

        #[test]
        fn a_measured_position_updates_as_everywhere_else(at in any_state(), shift in prop::array::uniform3(-90.0..90.0f64)) {
            let sigmas = [20.0, 30.0, 40.0, 0.0];
            let values = std::array::from_fn(|axis| at.mean[axis] + shift[axis]);
            let of = |kind| DetectionMeasurement { kind, values, range_rate_mps: None, sigmas, platform_m: [0.0; 3] };
            let (mut plane, mut plane_expected, mut space, mut space_expected) = (at, at, at, at);
            let found = of(DetectionKind::Position2).update(&mut plane).unwrap();
            let expected = plane_expected.update_position::<2>(values, &[400.0, 0.0, 0.0, 900.0, 0.0, 1600.0]).unwrap();
            prop_assert!((found.squared_distance - expected.squared_distance).abs() < 1e-9);
            let likelihood = -0.5 * (expected.squared_distance + expected.log_determinant) - TAU.ln();
            prop_assert!((found.log_likelihood - likelihood).abs() < 1e-9);
            of(DetectionKind::Position3).update(&mut space).unwrap();
            space_expected.update_position::<3>(values, &[400.0, 0.0, 0.0, 900.0, 0.0, 1600.0]).unwrap();
            for (found, expected) in [(plane, plane_expected), (space, space_expected)] {
                for row in 0..STATE_LEN {
                    prop_assert!((found.mean[row] - expected.mean[row]).abs() < 1e-8);
                    for column in 0..STATE_LEN {
                        let (a, b) = (found.covariance.get(row, column), expected.covariance.get(row, column));
                        prop_assert!((a - b).abs() < 1e-8 * 2500.0);
                    }
                }
            }
        }

        #[test]
        fn every_update_leaves_a_usable_covariance_and_comparing_is_updating(
            measurement in any_measurement(), at in any_state(),
        ) {
            let compared = measurement.innovation(&at).unwrap();
            let mut updated = at;
            prop_assert_eq!(measurement.update(&mut updated).unwrap(), compared);
            prop_assert!(estimation::is_usable(&updated.covariance));
            let after = measurement.innovation(&updated).unwrap();
            prop_assert!(after.dimension == compared.dimension);
        }
    }

    #[test]
    fn bearings_wrap() {
        let at = state([-1.0, -1000.0, 0.0, 0.0, 0.0, 0.0]);
        let measurement = DetectionMeasurement {
            kind: DetectionKind::Bearing,
            values: [PI, 0.0, 0.0],
            range_rate_mps: None,
            sigmas: [0.01, 0.0, 0.0, 0.0],
            platform_m: [0.0; 3],
        };
        assert!(measurement.innovation(&at).unwrap().squared_distance < 0.01);
    }

    #[test]
    fn a_target_at_the_sensor_has_no_direction() {
        let mut at = state([0.0; 6]);
        let measurement = DetectionMeasurement {
            kind: DetectionKind::RangeBearing,
            values: [10.0, 0.0, 0.0],
            range_rate_mps: None,
            sigmas: [10.0, 0.01, 0.0, 0.0],
            platform_m: [0.0; 3],
        };
        assert_eq!(measurement.update(&mut at), None);
        assert_eq!(at, state([0.0; 6]));
    }
}

//! Bearings of coherent waves: weighted subspace fitting.
//!
//! One transmitter over two paths reaches the array as two waves with a constant phase between them. Both share a
//! single signal eigenvector, the sum of both steering vectors, which is no steering vector itself: MUSIC finds no
//! minimum. The usual remedy, averaging over parts of a line array, gives up a third of the array and needs equal
//! distances.
//!
//! This fit searches so many bearings together that the span of the steering vectors A contains the signal eigenvectors
//! s with the values λ, weighted by the share of signal (Viberg & Ottersten, "Sensor array processing based on subspace
//! fitting", IEEE Trans. Signal Processing 39 (5), 1991):
//!
//! ```text
//!   V = Σ w |Π s|²,   w = (λ − σ²)² / λ,   Π = I − A (AᴴA)⁻¹ Aᴴ
//! ```
//!
//! The error of the fit reaches the stochastic Cramér–Rao bound with many snapshots, for coherent waves, too. The start
//! is found on MUSIC's grid, a single bearing at a time with the others held (alternating projection: Ziskind & Wax
//! 1988); the Gauss–Newton method on the exact function finds the minimum. The covariance of the bearings is that of
//! the same paper, σ²/N times the inverse of the approximate second derivative of V. The value of the minimum is
//! chi-square distributed, which decides whether as many waves explain the snapshots.
//!
//! The fit allocates, and is called only for snapshots that MUSIC has not resolved, and only if `paths` permits it.

use nalgebra::{Complex, DMatrix, DVector};

use super::accuracy::chi_square_limit;
use super::array::AntennaArray;
use super::eigen::EigenSystem;
use super::null_spectrum::NullSpectrum;

/// Rounds of the search on the grid, and of the Gauss–Newton method.
const ROUNDS_ON_GRID: usize = 20;
const STEPS_MAX: usize = 30;
/// Step at which the bearings are found, radians.
const STEP_MIN_RAD: f64 = 1e-10;
/// Least share of a steering vector outside of the span of the others.
const SHARE_MIN: f64 = 1e-3;

/// Inputs of a fit besides the array: the inputs of the measurement.
#[derive(Clone, Copy, Debug)]
pub(super) struct FitInputs {
    pub(super) snapshots: usize,
    /// Number of signal eigenvectors.
    pub(super) signals: usize,
    pub(super) noise_variance: f64,
    pub(super) phase_sigma_rad: f64,
}

/// Bearing of a wave with the standard deviation, radians.
pub(super) type FittedBearing = (f64, f64);

/// Most waves that the antennas determine (Wax & Ziskind 1989).
pub(super) fn waves_max(antennas: usize, signals: usize) -> usize {
    (antennas + signals).saturating_sub(1) / 2
}

/// Finds the bearings of `waves` waves; `None` if these do not explain the snapshots.
pub(super) fn fit(
    array: &AntennaArray,
    spectrum: &NullSpectrum,
    eigen: &EigenSystem,
    inputs: FitInputs,
    waves: usize,
) -> Option<Vec<FittedBearing>> {
    let signals = weighted(eigen, inputs);
    let mut bearings_rad = start(array, spectrum, &signals, waves)?;
    let mut system = System::at(array, spectrum, &signals, &bearings_rad)?;
    for _ in 0..STEPS_MAX {
        let step = system.step()?;
        let mut share = 1.0;
        let (next_rad, next) = loop {
            let moved: Vec<f64> = bearings_rad.iter().zip(&step).map(|(at, by)| at + share * by).collect();
            match System::at(array, spectrum, &signals, &moved) {
                Some(next) if next.value <= system.value => break (moved, next),
                _ if share < 1e-3 => break (bearings_rad.clone(), system.clone()),
                _ => share *= 0.5,
            }
        };
        let largest = next_rad
            .iter()
            .zip(&bearings_rad)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        (bearings_rad, system) = (next_rad, next);
        if largest < STEP_MIN_RAD {
            break;
        }
    }
    if !system.explains(&signals, inputs) {
        return None;
    }
    let covariance = system.curvature.try_inverse()? * (inputs.noise_variance / inputs.snapshots as f64);
    let sigma = |wave: usize| covariance[(wave, wave)].sqrt();
    let found = bearings_rad
        .iter()
        .enumerate()
        .map(|(wave, bearing_rad)| (*bearing_rad, sigma(wave)));
    let found: Vec<FittedBearing> = found.collect();
    found
        .iter()
        .all(|(_, sigma_rad)| sigma_rad.is_finite())
        .then_some(found)
}

/// The signal eigenvectors, times the roots of the weights.
fn weighted(eigen: &EigenSystem, inputs: FitInputs) -> DMatrix<Complex<f64>> {
    let antennas = eigen.values().len();
    let mut signals = DMatrix::zeros(antennas, inputs.signals);
    for (place, (vector, value)) in eigen.signal(inputs.signals).zip(eigen.values()).enumerate() {
        let root = (value - inputs.noise_variance).max(0.0) / value.sqrt();
        for (row, element) in vector.iter().enumerate() {
            signals[(row, place)] = element * root;
        }
    }
    signals
}

/// Bearings on the grid: each in turn where this bearing explains most of the remainder of the others.
fn start(
    array: &AntennaArray,
    spectrum: &NullSpectrum,
    signals: &DMatrix<Complex<f64>>,
    waves: usize,
) -> Option<Vec<f64>> {
    let mut points: Vec<usize> = Vec::with_capacity(waves);
    for _ in 0..waves {
        points.push(best_point(spectrum, signals, &points, array.len())?);
    }
    for _ in 0..ROUNDS_ON_GRID {
        let before = points.clone();
        for wave in 0..waves {
            let mut others = points.clone();
            others.remove(wave);
            points[wave] = best_point(spectrum, signals, &others, array.len())?;
        }
        if points == before {
            break;
        }
    }
    Some(points.iter().map(|point| spectrum.bearing_rad(*point)).collect())
}

/// Point of the grid with the steering vector that, beside the vectors of `others`, explains most of the signals.
fn best_point(
    spectrum: &NullSpectrum,
    signals: &DMatrix<Complex<f64>>,
    others: &[usize],
    antennas: usize,
) -> Option<usize> {
    let columns: Vec<_> = others
        .iter()
        .map(|point| DVector::from_column_slice(spectrum.steering(*point)))
        .collect();
    let basis = match columns.is_empty() {
        true => DMatrix::zeros(antennas, 0),
        false => DMatrix::from_columns(&columns).qr().q(),
    };
    let mut best: Option<(f64, usize)> = None;
    for point in 0..spectrum.points() {
        let steering = DVector::from_column_slice(spectrum.steering(point));
        let beside = &steering - &basis * basis.ad_mul(&steering);
        let share = beside.norm_squared();
        if share < SHARE_MIN * antennas as f64 {
            continue;
        }
        let explained = signals.ad_mul(&beside).norm_squared() / share;
        if best.is_none_or(|(most, _)| explained > most) {
            best = Some((explained, point));
        }
    }
    best.map(|(_, point)| point)
}

/// The function V and the derivatives at some bearings.
#[derive(Clone, Debug)]
struct System {
    value: f64,
    gradient: DVector<f64>,
    /// Approximate second derivative, without the part that vanishes where the waves explain the signals.
    curvature: DMatrix<f64>,
}

impl System {
    fn at(
        array: &AntennaArray,
        spectrum: &NullSpectrum,
        signals: &DMatrix<Complex<f64>>,
        bearings_rad: &[f64],
    ) -> Option<Self> {
        let (antennas, waves) = (array.len(), bearings_rad.len());
        let (mut steering, mut slope) = (DMatrix::zeros(antennas, waves), DMatrix::zeros(antennas, waves));
        for (wave, bearing_rad) in bearings_rad.iter().enumerate() {
            for (row, response) in array.response(spectrum.wave_number(), *bearing_rad).enumerate() {
                steering[(row, wave)] = response.value;
                slope[(row, wave)] = response.first();
            }
        }
        let inverse = steering.ad_mul(&steering).try_inverse()?;
        let amplitudes: DMatrix<Complex<f64>> = &inverse * steering.ad_mul(signals);
        let left = signals - &steering * &amplitudes;
        let slope_beside = &slope - &steering * (&inverse * steering.ad_mul(&slope));
        let overlap = slope_beside.ad_mul(&slope_beside);
        let power: DMatrix<Complex<f64>> = &amplitudes * amplitudes.adjoint();
        let pull = slope_beside.ad_mul(&left);
        let gradient = |wave: usize| {
            let products = (0..signals.ncols()).map(|k| (amplitudes[(wave, k)].conj() * pull[(wave, k)]).re);
            -2.0 * products.sum::<f64>()
        };
        Some(Self {
            value: left.norm_squared(),
            gradient: DVector::from_fn(waves, |wave, _| gradient(wave)),
            curvature: DMatrix::from_fn(waves, waves, |a, b| 2.0 * (overlap[(a, b)] * power[(b, a)]).re),
        })
    }

    fn step(&self) -> Option<Vec<f64>> {
        let step = self.curvature.clone().cholesky()?.solve(&-&self.gradient);
        Some(step.iter().copied().collect())
    }

    /// Whether the remainder is noise, or an effect of the antennas' phase errors.
    fn explains(&self, signals: &DMatrix<Complex<f64>>, inputs: FitInputs) -> bool {
        let (antennas, waves) = (signals.nrows(), self.gradient.len());
        let freedom = (2 * inputs.signals * (antennas - waves)).saturating_sub(waves);
        if freedom == 0 {
            return false;
        }
        let few = inputs.snapshots as f64 / (inputs.snapshots - inputs.signals) as f64;
        let by_noise = 0.5 * inputs.noise_variance / inputs.snapshots as f64;
        let by_phases = inputs.phase_sigma_rad.powi(2) * signals.norm_squared() / antennas as f64;
        self.value <= few * (by_noise + by_phases) * chi_square_limit(freedom as f64)
    }
}

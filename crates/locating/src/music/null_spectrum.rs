//! The null spectrum: how much of a bearing's steering vector lies in the noise subspace. The minima are the bearings.
//!
//! MUSIC is usually drawn as the reciprocal, with peaks. Minima are easier to search: the null spectrum is a smooth
//! function without poles, with exactly known derivatives.
//!
//! The grid only separates minima. The grid has 32 points in the width of a beam (wavelength over width of the array);
//! the steering vectors are cached for a single frequency. Newton's method on the derivative then finds each minimum to
//! the last digits, with bisection if a step leaves the bracket from the grid.

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;

use super::array::{AntennaArray, Response};
use super::eigen::EigenSystem;
use super::error::MusicError;

/// Grid points in the width of a beam.
const POINTS_PER_BEAM: f64 = 32.0;
/// Fewest grid points in a full circle.
const POINTS_MIN: f64 = 360.0;
/// Widest array that is searched, wavelengths.
const WAVELENGTHS_MAX: f64 = 200.0;
/// Steps of refinement at most; Newton's method needs about four.
const STEPS_MAX: usize = 60;
/// Step below which a bearing is found, radians.
const STEP_MIN_RAD: f64 = 1e-12;

/// Squared cosine between two steering vectors above which the array does not separate the bearings. For two sources on
/// different grid points the value is far below: a sixteenth of a beam apart about 0.99.
const LIKENESS_OF_ONE_SOURCE: f64 = 0.9999;

/// A minimum of the null spectrum, with the inputs of the accuracy.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpectrumMinimum {
    /// Radians clockwise from forward, 0 to 2π.
    pub(super) bearing_rad: f64,
    /// Squared length of the steering vector's part in the noise subspace.
    pub(super) depth: f64,
    /// Squared length of the derivative's part there: by the bearing, per square radian; in a line array by the cosine
    /// of the angle to the line.
    pub(super) sharpness: f64,
    /// Σ σ²λ / (λ − σ²)² |s·a|² over the signal eigenvectors s with the values λ: over the number of snapshots, this is
    /// how much the noise subspace deviates from the true one in the direction of the steering vector a.
    pub(super) deviation: f64,
    /// Number of the source, for grouping minima.
    pub(super) source: usize,
}

/// The null spectrum of an array, with the steering vectors of a single frequency.
#[derive(Clone, Debug)]
pub(super) struct NullSpectrum {
    frequency_max_hz: f64,
    /// Frequency of the steering vectors, hertz, and the wave number, radians per metre.
    frequency_hz: f64,
    wave_number: f64,
    /// First bearing of the grid, and the distance between grid points.
    begin_rad: f64,
    step_rad: f64,
    /// Set if the grid is a closed circle; otherwise the grid reaches from end to end of a line, and is mirrored there.
    closed: bool,
    /// Steering vectors, point after point.
    steering: Vec<Complex<f64>>,
    /// Value at each point of the grid.
    values: Vec<f64>,
    minima: Vec<SpectrumMinimum>,
    /// Responses of the antennas at the bearing that is being refined.
    responses: Vec<Response>,
}

impl NullSpectrum {
    pub(super) fn new(array: &AntennaArray, frequency_max_hz: f64) -> Result<Self, MusicError> {
        let wave_number = AntennaArray::wave_number(frequency_max_hz);
        let wavelengths = array.width_m() * wave_number / TAU;
        if !(frequency_max_hz > 0.0 && wavelengths.is_finite()) {
            return Err(MusicError::Frequency {
                frequency_hz: frequency_max_hz,
                frequency_max_hz: f64::MAX,
            });
        }
        if wavelengths > WAVELENGTHS_MAX {
            let max = WAVELENGTHS_MAX;
            return Err(MusicError::TooWide { wavelengths, max });
        }
        let per_circle = (TAU * POINTS_PER_BEAM * wavelengths).max(POINTS_MIN).ceil();
        let (begin_rad, closed, points) = match array.line_rad() {
            Some(line_rad) => (line_rad, false, (0.5 * per_circle).ceil() as usize + 1),
            None => (0.0, true, per_circle as usize),
        };
        let step_rad = if closed {
            TAU / points as f64
        } else {
            PI / (points - 1) as f64
        };
        let antennas = array.len();
        Ok(Self {
            frequency_max_hz,
            frequency_hz: f64::NAN,
            wave_number,
            begin_rad,
            step_rad,
            closed,
            steering: vec![Complex::ZERO; points * antennas],
            values: vec![0.0; points],
            minima: Vec::with_capacity(points),
            responses: Vec::with_capacity(antennas),
        })
    }

    /// Most minima there can be.
    pub(super) fn capacity(&self) -> usize {
        self.minima.capacity()
    }

    /// Prepares the grid for a frequency.
    pub(super) fn set_frequency(&mut self, array: &AntennaArray, frequency_hz: f64) -> Result<(), MusicError> {
        let frequency_max_hz = self.frequency_max_hz;
        if !(frequency_hz > 0.0 && frequency_hz <= frequency_max_hz) {
            return Err(MusicError::Frequency {
                frequency_hz,
                frequency_max_hz,
            });
        }
        if frequency_hz != self.frequency_hz {
            (self.frequency_hz, self.wave_number) = (frequency_hz, AntennaArray::wave_number(frequency_hz));
            for (point, steering) in self.steering.chunks_exact_mut(array.len()).enumerate() {
                let bearing_rad = self.begin_rad + point as f64 * self.step_rad;
                for (element, response) in steering.iter_mut().zip(array.response(self.wave_number, bearing_rad)) {
                    *element = response.value;
                }
            }
        }
        Ok(())
    }

    /// Finds all minima for so many sources.
    pub(super) fn search(
        &mut self,
        array: &AntennaArray,
        eigen: &EigenSystem,
        (sources, noise_variance): (usize, f64),
    ) {
        for (value, steering) in self.values.iter_mut().zip(self.steering.chunks_exact(array.len())) {
            // The noise subspace holds the remainder of the signal subspace.
            *value = array.len() as f64
                - eigen
                    .signal(sources)
                    .map(|vector| dot(vector, steering).norm_sqr())
                    .sum::<f64>();
        }
        self.minima.clear();
        for point in 0..self.values.len() {
            let [before, after] = self.neighbours(point).map(|neighbour| self.values[neighbour]);
            if self.values[point] < before && self.values[point] <= after {
                let minimum = self.refined(point, array, eigen, (sources, noise_variance));
                self.minima.push(minimum);
            }
        }
        self.minima.sort_unstable_by(|a, b| a.depth.total_cmp(&b.depth));
    }

    /// The minima that were found, the deepest first.
    pub(super) fn minima(&self) -> &[SpectrumMinimum] {
        &self.minima
    }

    /// Forgets the minima that are not to be kept.
    pub(super) fn retain(&mut self, keep: impl FnMut(&SpectrumMinimum) -> bool) {
        self.minima.retain(keep);
    }

    /// Numbers the sources of the minima, minima with the same steering vector as a single source; returns the number
    /// of sources.
    pub(super) fn group(&mut self, array: &AntennaArray) -> usize {
        let mut sources = 0;
        for index in 0..self.minima.len() {
            let bearing_rad = self.minima[index].bearing_rad;
            let alike = |other: &&SpectrumMinimum| {
                self.likeness(array, other.bearing_rad, bearing_rad) > LIKENESS_OF_ONE_SOURCE
            };
            self.minima[index].source = match self.minima[..index].iter().find(alike) {
                Some(other) => other.source,
                None => {
                    sources += 1;
                    sources - 1
                }
            };
        }
        sources
    }

    /// Number of points of the grid.
    pub(super) fn points(&self) -> usize {
        self.values.len()
    }

    /// Bearing of a point of the grid, radians clockwise from forward.
    pub(super) fn bearing_rad(&self, point: usize) -> f64 {
        self.begin_rad + point as f64 * self.step_rad
    }

    /// Steering vector of a point of the grid.
    pub(super) fn steering(&self, point: usize) -> &[Complex<f64>] {
        let antennas = self.steering.len() / self.values.len();
        &self.steering[point * antennas..][..antennas]
    }

    /// Wave number of the present frequency, radians per metre.
    pub(super) fn wave_number(&self) -> f64 {
        self.wave_number
    }

    /// Values of the last search at the points of the grid.
    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    fn neighbours(&self, point: usize) -> [usize; 2] {
        let last = self.values.len() - 1;
        let mirrored = |beyond: usize, wrapped: usize| if self.closed { wrapped } else { beyond };
        [
            if point == 0 { mirrored(1, last) } else { point - 1 },
            if point == last {
                mirrored(last - 1, 0)
            } else {
                point + 1
            },
        ]
    }

    /// The minimum next to a point of the grid.
    fn refined(
        &mut self,
        point: usize,
        array: &AntennaArray,
        eigen: &EigenSystem,
        (sources, noise_variance): (usize, f64),
    ) -> SpectrumMinimum {
        let mut bearing_rad = self.begin_rad + point as f64 * self.step_rad;
        let (mut low_rad, mut high_rad) = (bearing_rad - self.step_rad, bearing_rad + self.step_rad);
        for _ in 0..STEPS_MAX {
            let (slope, curvature) = self.derivatives(array, eigen, sources, bearing_rad);
            if slope == 0.0 {
                break;
            }
            *if slope < 0.0 { &mut low_rad } else { &mut high_rad } = bearing_rad;
            let newton_rad = bearing_rad - slope / curvature;
            // At the last digits Newton's step leads nowhere, to the end of the bracket that was just set.
            let next_rad = if curvature > 0.0 && (low_rad..=high_rad).contains(&newton_rad) {
                newton_rad
            } else {
                0.5 * (low_rad + high_rad)
            };
            let step_rad = (next_rad - bearing_rad).abs();
            bearing_rad = next_rad;
            if step_rad < STEP_MIN_RAD {
                break;
            }
        }
        self.at(bearing_rad, array, eigen, (sources, noise_variance))
    }

    /// First and second derivative of the null spectrum by the bearing, per radian and square radian.
    fn derivatives(
        &mut self,
        array: &AntennaArray,
        eigen: &EigenSystem,
        sources: usize,
        bearing_rad: f64,
    ) -> (f64, f64) {
        self.responses.clear();
        self.responses.extend(array.response(self.wave_number, bearing_rad));
        let (mut slope, mut curvature) = (0.0, 0.0);
        for vector in eigen.noise(sources) {
            let mut parts = [Complex::<f64>::ZERO; 3];
            for (element, response) in vector.iter().zip(&self.responses) {
                parts[0] += element.conj() * response.value;
                parts[1] += element.conj() * response.first();
                parts[2] += element.conj() * response.second();
            }
            slope += 2.0 * (parts[0].conj() * parts[1]).re;
            curvature += 2.0 * (parts[1].norm_sqr() + (parts[0].conj() * parts[2]).re);
        }
        (slope, curvature)
    }

    fn at(
        &mut self,
        bearing_rad: f64,
        array: &AntennaArray,
        eigen: &EigenSystem,
        (sources, noise_variance): (usize, f64),
    ) -> SpectrumMinimum {
        self.responses.clear();
        self.responses.extend(array.response(self.wave_number, bearing_rad));
        let along = |vector: &[Complex<f64>], of: fn(&Response) -> Complex<f64>| {
            let products = vector.iter().zip(&self.responses);
            products
                .map(|(element, response)| element.conj() * of(response))
                .sum::<Complex<f64>>()
                .norm_sqr()
        };
        let noise = |of| eigen.noise(sources).map(|vector| along(vector, of)).sum();
        let deviation = eigen.signal(sources).zip(eigen.values()).map(|(vector, value)| {
            let noise_share = noise_variance / value;
            noise_share / (1.0 - noise_share).powi(2) * along(vector, |response| response.value)
        });
        SpectrumMinimum {
            bearing_rad: bearing_rad.rem_euclid(TAU),
            depth: noise(|response| response.value),
            sharpness: noise(|response| response.value * response.search_slope),
            deviation: deviation.sum(),
            source: 0,
        }
    }

    /// Squared cosine of the angle between the steering vectors of two bearings.
    fn likeness(&self, array: &AntennaArray, a_rad: f64, b_rad: f64) -> f64 {
        let [of_a, of_b] = [a_rad, b_rad].map(|bearing_rad| array.response(self.wave_number, bearing_rad));
        let product: Complex<f64> = of_a.zip(of_b).map(|(a, b)| a.value.conj() * b.value).sum();
        product.norm_sqr() / (array.len() as f64).powi(2)
    }
}

fn dot(a: &[Complex<f64>], b: &[Complex<f64>]) -> Complex<f64> {
    a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
}

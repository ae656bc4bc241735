//! Bearings of transmitters from the phases between antennas (EL-1): the MUSIC method on array snapshots.
//!
//! A plane wave reaches the antennas of an array in succession; the simultaneous samples of all antennas, a *snapshot*,
//! differ by phases that depend on the direction of the wave. With a single transmitter, these phases give the bearing.
//! With several at once, the phases of the sum are useless. The obvious method, a rotating beam that searches for the
//! most power, cannot separate two transmitters within a beam's width, however long the observation.
//!
//! MUSIC (Schmidt 1986) searches where no power is. The covariance of the snapshots has as many large eigenvalues as
//! there are transmitters; the eigenvectors of the others span the *noise subspace*, and the array's response to every
//! true bearing, its steering vector, is perpendicular to it. So:
//!
//! 1. covariance of the snapshots, and its eigen-decomposition (`eigen`);
//! 2. the number of transmitters, given or estimated from the eigenvalues (`order`);
//! 3. bearings: the minima of the *null spectrum*, the squared length of the steering vector's part in the noise
//!    subspace, found on a grid and refined by Newton's method on the exact function (`null_spectrum`);
//! 4. the accuracy of each bearing (`accuracy`), and whether the minimum is as deep as a true bearing's would be.
//!
//! Ambiguities are reported. Antennas in a line receive waves from the left and from the right alike, and antennas
//! more than half a wavelength apart may receive several bearings alike: then a transmitter has several
//! [`WaveBearing`]s with the same `source`, all marked ambiguous. Transmitters too weak or too close together to be
//! separated are counted in [`BearingSet::unresolved`].
//!
//! Limits: waves come along the plane of the array (a wave from an elevation *e* appears as if the frequency were cos
//! *e* times as high); signals are narrow-band; the noise of the antennas is independent and equally strong. Fully
//! correlated signals (one transmitter over two paths) are a single source to MUSIC, which then finds no bearing, or a
//! bearing that may be neither's; with `paths` above 1 such snapshots are explained by several waves (`subspace_fit`).
//!
//! Bearings are radians clockwise from the array's forward axis, 0 to 2π. No allocation after [`Music::new`] for arrays
//! of up to 16 antennas; for larger arrays the eigen-decomposition allocates, and so does the search of coherent waves.
//!
//! R. O. Schmidt, "Multiple emitter location and signal parameter estimation", IEEE Trans. Antennas and Propagation 34
//! (3), 1986; the other sources are named at the place of use.

mod accuracy;
mod array;
mod array_finder;
mod bound;
mod eigen;
mod error;
mod null_spectrum;
mod order;
mod settings;
mod simulation;
mod subspace_fit;

pub use array::AntennaArray;
pub use array_finder::{ArrayFinder, FinderCounts};
pub use bound::stochastic_bound;
pub use error::MusicError;
pub use order::SourceCount;
pub use settings::{ArraySettings, ElementPosition, ModelOrderCriterion};
pub use simulation::{SimulatedArray, SimulatedWaves};

pub use nalgebra::Complex;

use std::f64::consts::TAU;

use accuracy::{AccuracyInputs, UNKNOWN_RAD};
use eigen::EigenSystem;
use null_spectrum::NullSpectrum;
use subspace_fit::FitInputs;

/// Settings of a measurement with an array.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MusicSettings {
    /// Number of transmitters, or the method of estimation.
    pub sources: SourceCount,
    /// Highest frequency that will be measured, hertz: decides the resolution of the search.
    pub frequency_max_hz: f64,
    /// Standard deviation of each antenna's phase error after calibration, radians: part of the bearings' accuracy,
    /// which otherwise would improve without limit with the number of snapshots.
    pub phase_sigma_rad: f64,
    /// Largest number of paths of a transmitter. Above 1, snapshots that MUSIC does not resolve are explained by
    /// coherent waves, if possible.
    pub paths: usize,
}

/// Snapshots of all antennas.
#[derive(Clone, Copy, Debug)]
pub struct Snapshots<'a> {
    /// Complex samples, snapshot after snapshot, each with a single sample per antenna in the order of the array.
    /// Samples of different snapshots have to be independent: as far apart as the signal's bandwidth makes them.
    pub samples: &'a [Complex<f64>],
    /// Frequency of the waves, hertz.
    pub frequency_hz: f64,
}

/// Bearing of a wave; for an ambiguous array, a possible bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveBearing {
    /// Number of the transmitter within this measurement, from 0; several bearings with the same number are
    /// alternatives.
    pub source: usize,
    /// Radians clockwise from the array's forward axis, 0 to 2π.
    pub bearing_rad: f64,
    /// Standard deviation of the bearing, radians; at most that of an unknown bearing, π/√3.
    pub sigma_rad: f64,
    /// Whether other bearings explain the snapshots as well.
    pub ambiguous: bool,
}

/// Bearings measured from a single set of snapshots.
#[derive(Clone, Debug, Default)]
pub struct BearingSet {
    /// Bearings by source, and within a source by bearing.
    pub bearings: Vec<WaveBearing>,
    /// Number of transmitters, as given or estimated.
    pub sources: usize,
    /// Number of transmitters that have no separate bearing: hidden in the noise, or not separable from another
    /// transmitter.
    pub unresolved: usize,
    /// Variance of the noise at an antenna, in squares of the samples' unit.
    pub noise_variance: f64,
}

/// An array with all that is needed to find bearings; see the module's documentation.
#[derive(Clone, Debug)]
pub struct Music {
    array: AntennaArray,
    settings: MusicSettings,
    spectrum: NullSpectrum,
    covariance: Vec<Complex<f64>>,
    eigen: EigenSystem,
    /// Number of signal eigenvectors of the last measurement.
    seen: usize,
    measured: BearingSet,
}

impl Music {
    /// Prepares the search for bearings with `array`.
    ///
    /// # Errors
    /// Settings that cannot be used: a frequency that is no positive number or at which the array is too wide, a number
    /// of sources that the array cannot separate, a phase error that is negative or no number.
    pub fn new(array: AntennaArray, settings: MusicSettings) -> Result<Self, MusicError> {
        let antennas = array.len();
        settings.sources.check(antennas)?;
        let phase_sigma_rad = settings.phase_sigma_rad;
        if !(phase_sigma_rad.is_finite() && phase_sigma_rad >= 0.0) {
            return Err(MusicError::PhaseSigma { phase_sigma_rad });
        }
        let spectrum = NullSpectrum::new(&array, settings.frequency_max_hz)?;
        Ok(Self {
            covariance: vec![Complex::ZERO; antennas * antennas],
            eigen: EigenSystem::new(antennas),
            seen: 0,
            measured: BearingSet {
                bearings: Vec::with_capacity(spectrum.capacity() * array.images()),
                ..BearingSet::default()
            },
            spectrum,
            array,
            settings,
        })
    }

    /// The array.
    pub fn array(&self) -> &AntennaArray {
        &self.array
    }

    /// Bearings from a single set of snapshots. The steering vectors of the last frequency are kept: changing the
    /// frequency with every call costs several times as much.
    ///
    /// # Errors
    /// Snapshots that cannot be used: none, a part of one, a sample that is no number, fewer than the sources need, a
    /// frequency above the highest, or no power at all.
    pub fn measure(&mut self, snapshots: &Snapshots<'_>) -> Result<&BearingSet, MusicError> {
        let count = self.take_covariance(snapshots.samples)?;
        self.spectrum.set_frequency(&self.array, snapshots.frequency_hz)?;
        if !self.eigen.decompose(&self.covariance) {
            return Err(MusicError::NoConvergence);
        }
        let values = self.eigen.values();
        let sources = self.settings.sources.count(values, count)?;
        let noise_variance = order::noise_variance(values, count, sources);
        let seen = order::above_noise(values, count, sources, noise_variance);
        self.measured.bearings.clear();
        (self.measured.sources, self.measured.noise_variance) = (sources, noise_variance);
        self.seen = seen;
        let separated = if seen > 0 { self.find_bearings(count, seen) } else { 0 };
        self.measured.unresolved = sources.saturating_sub(separated);
        if separated < seen && self.settings.paths > 1 {
            self.find_coherent(count, seen);
        }
        Ok(&self.measured)
    }

    /// Result of the last measurement.
    pub fn measured(&self) -> &BearingSet {
        &self.measured
    }

    /// Spectrum of the last measurement: for each of equal parts of a turn, clockwise from forward, the largest
    /// reciprocal of the null spectrum, decibels; 0 in directions without a wave.
    pub fn spectrum_db(&self, parts: &mut [f32]) {
        parts.fill(f32::NEG_INFINITY);
        let (antennas, count) = (self.array.len() as f64, parts.len());
        let mut raise = |bearing_rad: f64, value: f32| {
            let part = (bearing_rad.rem_euclid(TAU) / TAU * count as f64) as usize;
            let part = &mut parts[part.min(count - 1)];
            *part = part.max(value);
        };
        for (point, depth) in self.spectrum.values().iter().enumerate() {
            let depth = if self.seen > 0 { *depth } else { antennas };
            let value = (10.0 * (antennas / depth.max(f64::EPSILON)).log10()) as f32;
            let bearing_rad = self.spectrum.bearing_rad(point);
            raise(bearing_rad, value);
            if let Some(mirrored_rad) = self.array.mirrored(bearing_rad) {
                raise(mirrored_rad, value);
            }
        }
        // The grid has a point in each part but for rounding.
        let mut before = parts
            .iter()
            .copied()
            .find(|value| value.is_finite())
            .unwrap_or_default();
        for part in parts {
            if !part.is_finite() {
                *part = before;
            }
            before = *part;
        }
    }

    /// Explains the snapshots by coherent waves, as few as possible; otherwise MUSIC's bearings stay.
    fn find_coherent(&mut self, snapshots: usize, signals: usize) {
        let inputs = FitInputs {
            snapshots,
            signals,
            noise_variance: self.measured.noise_variance,
            phase_sigma_rad: self.settings.phase_sigma_rad,
        };
        let waves_max = subspace_fit::waves_max(self.array.len(), signals).min(signals * self.settings.paths);
        let (array, spectrum, eigen) = (&self.array, &self.spectrum, &self.eigen);
        let fitted =
            (signals + 1..=waves_max).find_map(|waves| subspace_fit::fit(array, spectrum, eigen, inputs, waves));
        let Some(fitted) = fitted else { return };
        let measured = &mut self.measured;
        measured.bearings.clear();
        measured.unresolved = measured.sources.saturating_sub(fitted.len());
        measured.sources = measured.sources.max(fitted.len());
        for (source, (bearing_rad, sigma_rad)) in fitted.into_iter().enumerate() {
            let mirrored_rad = array.mirrored(bearing_rad);
            for bearing_rad in [Some(bearing_rad), mirrored_rad].into_iter().flatten() {
                measured.bearings.push(WaveBearing {
                    source,
                    bearing_rad: bearing_rad.rem_euclid(TAU),
                    sigma_rad: sigma_rad.min(UNKNOWN_RAD),
                    ambiguous: mirrored_rad.is_some(),
                });
            }
        }
    }

    /// Bearings of the `sources` greatest eigenvalues of so many snapshots; returns how many separate sources these
    /// show.
    fn find_bearings(&mut self, snapshots: usize, sources: usize) -> usize {
        let array = &self.array;
        let accuracy = AccuracyInputs {
            snapshots,
            sources,
            phase_sigma_rad: self.settings.phase_sigma_rad,
        };
        self.spectrum
            .search(array, &self.eigen, (sources, self.measured.noise_variance));
        self.spectrum
            .retain(|minimum| accuracy.may_be_a_source(minimum, array.len()));
        let separated = self.spectrum.group(array);
        let minima = self.spectrum.minima();
        for minimum in minima {
            let alike = minima.iter().filter(|other| other.source == minimum.source).count() > 1;
            let mirrored_rad = array.mirrored(minimum.bearing_rad);
            let bearing = WaveBearing {
                source: minimum.source,
                bearing_rad: minimum.bearing_rad,
                sigma_rad: accuracy.sigma_rad(minimum, array),
                // With more bearings than sources, the array cannot select the true bearings.
                ambiguous: alike || separated > sources || mirrored_rad.is_some(),
            };
            self.measured.bearings.push(bearing);
            if let Some(bearing_rad) = mirrored_rad {
                self.measured.bearings.push(WaveBearing { bearing_rad, ..bearing });
            }
        }
        let by_source =
            |a: &WaveBearing, b: &WaveBearing| a.source.cmp(&b.source).then(a.bearing_rad.total_cmp(&b.bearing_rad));
        self.measured.bearings.sort_unstable_by(by_source);
        separated
    }

    /// Averages the products of the samples; returns the number of snapshots.
    fn take_covariance(&mut self, samples: &[Complex<f64>]) -> Result<usize, MusicError> {
        let antennas = self.array.len();
        let count = samples.len() / antennas;
        if count == 0 || !samples.len().is_multiple_of(antennas) {
            let samples = samples.len();
            return Err(MusicError::SampleCount { samples, antennas });
        }
        if let Some(at) = samples.iter().position(|sample| !sample.is_finite()) {
            let (snapshot, antenna) = (at / antennas, at % antennas);
            return Err(MusicError::Sample { snapshot, antenna });
        }
        self.covariance.fill(Complex::ZERO);
        for snapshot in samples.chunks_exact(antennas) {
            // Only the lower triangle: the decomposition reads no more.
            for (column, of_column) in snapshot.iter().enumerate() {
                let lower = column * (antennas + 1)..(column + 1) * antennas;
                for (element, of_row) in self.covariance[lower].iter_mut().zip(&snapshot[column..]) {
                    *element += of_row * of_column.conj();
                }
            }
        }
        let (mut power, mut finite) = (0.0, true);
        for element in &mut self.covariance {
            *element /= count as f64;
            finite &= element.is_finite();
        }
        for antenna in 0..antennas {
            power += self.covariance[antenna * (antennas + 1)].re;
        }
        if finite && power.is_normal() {
            Ok(count)
        } else {
            Err(MusicError::Power { power })
        }
    }
}

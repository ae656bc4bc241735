//! Simulated array: snapshots of waves with known bearings, from a single seed.
//!
//! Signals and noise are complex normal, the noise of each antenna with variance 1. Signals share a common part, so
//! that any two have the same given correlation: 0 for independent transmitters, 1 for a single transmitter received on
//! several paths. Each run has separate random numbers, independent of earlier runs.

use nalgebra::Complex;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution as _, StandardNormal};

use super::array::AntennaArray;
use super::error::MusicError;

/// Waves that reach the array.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedWaves {
    /// Directions that the waves come from, radians clockwise from the array's forward axis.
    pub bearings_rad: Vec<f64>,
    /// Power of each wave at an antenna over the power of the noise, decibels; in the order of the bearings.
    pub snr_db: Vec<f64>,
    /// Correlation of any two signals, 0 to 1.
    pub correlation: f64,
    /// Frequency, hertz.
    pub frequency_hz: f64,
    /// Number of snapshots in a run.
    pub snapshots: usize,
    /// Standard deviation of each antenna's constant phase error, radians, drawn anew for every run.
    pub phase_sigma_rad: f64,
}

impl SimulatedWaves {
    /// Independent waves of equal strength from these bearings, at an array without phase errors.
    pub fn independent(bearings_rad: &[f64], snr_db: f64, frequency_hz: f64, snapshots: usize) -> Self {
        Self {
            bearings_rad: bearings_rad.to_vec(),
            snr_db: vec![snr_db; bearings_rad.len()],
            correlation: 0.0,
            frequency_hz,
            snapshots,
            phase_sigma_rad: 0.0,
        }
    }

    pub(super) fn check(&self) -> Result<(), MusicError> {
        let refused = |name, value, limit| Err(MusicError::Waves { name, value, limit });
        let (waves, powers) = (self.bearings_rad.len(), self.snr_db.len());
        if waves == 0 || powers != waves {
            return refused(
                "snr_db (number of values)",
                powers as f64,
                "as many as bearings, at least 1",
            );
        }
        if let Some(&bearing) = self.bearings_rad.iter().find(|bearing| !bearing.is_finite()) {
            return refused("bearings_rad", bearing, "a number");
        }
        if let Some(&snr) = self.snr_db.iter().find(|snr| !(-200.0..=200.0).contains(*snr)) {
            return refused("snr_db", snr, "between -200 and 200");
        }
        if !(0.0..=1.0).contains(&self.correlation) {
            return refused("correlation", self.correlation, "between 0 and 1");
        }
        if !(self.frequency_hz.is_finite() && self.frequency_hz > 0.0) {
            return refused("frequency_hz", self.frequency_hz, "above 0");
        }
        if !(self.phase_sigma_rad.is_finite() && self.phase_sigma_rad >= 0.0) {
            return refused("phase_sigma_rad", self.phase_sigma_rad, "from 0 on");
        }
        Ok(())
    }

    /// Covariance of two signals.
    pub(super) fn covariance(&self, a: usize, b: usize) -> f64 {
        let correlation = if a == b { 1.0 } else { self.correlation };
        correlation * self.amplitude(a) * self.amplitude(b)
    }

    fn amplitude(&self, wave: usize) -> f64 {
        10f64.powf(self.snr_db[wave] / 20.0)
    }
}

/// A simulated measurement: snapshots of given waves at the antennas of an array.
#[derive(Clone, Debug)]
pub struct SimulatedArray {
    waves: SimulatedWaves,
    seed: u64,
    /// Response per wave and antenna, times the amplitude.
    responses: Vec<Complex<f64>>,
    antennas: usize,
}

impl SimulatedArray {
    /// `array` in the midst of `waves`.
    ///
    /// # Errors
    /// Waves that cannot be.
    pub fn new(array: &AntennaArray, waves: SimulatedWaves, seed: u64) -> Result<Self, MusicError> {
        waves.check()?;
        let wave_number = AntennaArray::wave_number(waves.frequency_hz);
        let of_wave = |(wave, &bearing_rad): (usize, &f64)| {
            let amplitude = waves.amplitude(wave);
            array
                .response(wave_number, bearing_rad)
                .map(move |response| response.value * amplitude)
        };
        Ok(Self {
            responses: waves.bearings_rad.iter().enumerate().flat_map(of_wave).collect(),
            antennas: array.len(),
            waves,
            seed,
        })
    }

    /// Replaces `samples` by the snapshots of a run: snapshot after snapshot, a single sample per antenna.
    pub fn run(&self, run: u64, samples: &mut Vec<Complex<f64>>) {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(run);
        let errors: Vec<_> = (0..self.antennas)
            .map(|_| {
                let error: f64 = StandardNormal.sample(&mut random);
                Complex::cis(self.waves.phase_sigma_rad * error)
            })
            .collect();
        let (shared, own) = (self.waves.correlation.sqrt(), (1.0 - self.waves.correlation).sqrt());
        samples.clear();
        for _ in 0..self.waves.snapshots {
            let first = samples.len();
            samples.extend((0..self.antennas).map(|_| normal(&mut random)));
            let common = normal(&mut random);
            for responses in self.responses.chunks_exact(self.antennas) {
                let signal = common * shared + normal(&mut random) * own;
                for (antenna, response) in responses.iter().enumerate() {
                    samples[first + antenna] += response * signal * errors[antenna];
                }
            }
        }
    }
}

/// A complex normal number of variance 1.
fn normal(random: &mut ChaCha8Rng) -> Complex<f64> {
    let [re, im]: [f64; 2] = [StandardNormal.sample(random), StandardNormal.sample(random)];
    Complex::new(re, im) * std::f64::consts::FRAC_1_SQRT_2
}

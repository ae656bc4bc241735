//! Simulated antenna array: what its antennas measure of one transmitter's wave.
//!
//! The wave is plane and comes from afar, in the plane of the antennas. Signal and noise are complex normal, the noise
//! of each antenna with variance 1. The array is given by its geometry alone: the estimator that measures the bearings
//! has its own model of the response, which the simulation does not use.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use rand::Rng;
use rand_distr::{Distribution as _, StandardNormal};

/// Speed of light, metres per second.
const LIGHT_MPS: f64 = 299_792_458.0;

/// Antennas on a platform.
#[derive(Clone, Debug, PartialEq)]
pub struct ArrayGeometry {
    /// Positions of the antennas: right and forward in the array's own axes, metres.
    pub antennas_m: Vec<[f64; 2]>,
    /// Direction of the array's forward axis, radians clockwise from the platform's heading.
    pub forward_rad: f64,
    /// Sector covered by the antennas, clockwise from the first angle to the second, radians from the forward axis.
    pub sector_rad: [f64; 2],
    /// Highest frequency that is received, hertz.
    pub frequency_max_hz: f64,
}

impl ArrayGeometry {
    /// Whether a wave of this frequency, from a direction in radians from the forward axis, is received.
    pub(crate) fn receives(&self, direction_rad: f64, frequency_hz: f64) -> bool {
        let [from, to] = self.sector_rad;
        let width = match (to - from).rem_euclid(TAU) {
            0.0 => TAU,
            width => width,
        };
        frequency_hz <= self.frequency_max_hz && (direction_rad - from).rem_euclid(TAU) <= width
    }

    /// Appends `count` snapshots of a wave from a direction, radians from the forward axis: the samples of all
    /// antennas, one snapshot after the other. `amplitude` is that of the signal over that of the noise at one antenna.
    pub(crate) fn measure(
        &self,
        (direction_rad, frequency_hz, amplitude): (f64, f64, f64),
        count: u32,
        random: &mut impl Rng,
        samples: &mut Vec<[f32; 2]>,
    ) {
        let (sine, cosine) = direction_rad.sin_cos();
        let turns = TAU * frequency_hz / LIGHT_MPS;
        for _ in 0..count {
            let signal = normal(random).map(|part| amplitude * part);
            for [right_m, forward_m] in &self.antennas_m {
                // An antenna nearer to the transmitter is ahead in phase.
                let (phase_sine, phase_cosine) = (turns * (right_m * sine + forward_m * cosine)).sin_cos();
                let noise = normal(random);
                samples.push([
                    (signal[0] * phase_cosine - signal[1] * phase_sine + noise[0]) as f32,
                    (signal[0] * phase_sine + signal[1] * phase_cosine + noise[1]) as f32,
                ]);
            }
        }
    }
}

/// Real and imaginary part of a complex normal number of variance 1.
fn normal(random: &mut impl Rng) -> [f64; 2] {
    std::array::from_fn(|_| {
        let part: f64 = StandardNormal.sample(random);
        FRAC_1_SQRT_2 * part
    })
}

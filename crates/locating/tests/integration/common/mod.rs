//! Simulated flights: bearings of an emitter with Gaussian errors, always the same for a seed.

use observations::Bearing;
pub(crate) use test_support::S;

/// Gaussian numbers.
pub(crate) struct Noise(u64);

impl Noise {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    /// Of standard deviation 1 (Box and Muller).
    pub(crate) fn next(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// The bearing from a platform to an emitter, off by `error_rad`.
pub(crate) fn bearing(time_s: f64, platform: [f64; 2], emitter: [f64; 2], sigma_rad: f64, error_rad: f64) -> Bearing {
    let exact = (emitter[0] - platform[0]).atan2(emitter[1] - platform[1]);
    Bearing {
        time_of_measurement_ns: (time_s * S as f64).round() as i64,
        emitter_id: Some(1),
        bearing_rad: exact + error_rad,
        sigma_rad,
        platform_m: [platform[0], platform[1], 3_000.0],
        heading_rad: None,
        frequency_hz: None,
        pulse_interval_s: None,
    }
}

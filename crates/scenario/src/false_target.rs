//! False targets.
//!
//! Reflections and interference make a sensor's tracker follow a false target for a few looks. A false target
//! appears anywhere in the coverage, moves at random, is detected in most looks, and disappears after five periods
//! on average.

use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Poisson, StandardNormal};

use crate::random::{Purpose, stream};
use crate::sensor_settings::CheckedSensor;

/// Detection probability of a false target while present.
pub(crate) const DETECTION_PROBABILITY: f64 = 0.95;
/// Mean life of a false target, periods.
const MEAN_LIFE_PERIODS: f64 = 5.0;
/// Standard deviation of the speed east and north, m/s.
const SPEED_SIGMA_MPS: f64 = 60.0;
/// Range of heights of false targets, metres, limited by the sensor's coverage.
const HEIGHTS_M: [f64; 2] = [500.0, 9000.0];

/// False target, see the module's documentation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FalseTarget {
    /// Number in the streams of random numbers; distinct from the numbers of true targets.
    pub(crate) thing: u64,
    begin_s: f64,
    end_s: f64,
    position_m: [f64; 3],
    velocity_mps: [f64; 2],
}

impl FalseTarget {
    /// Returns the number of false targets appearing in period number `period`.
    pub(crate) fn count(settings: &CheckedSensor, seed: u64, source: u16, period: u64) -> u64 {
        match Poisson::new(settings.false_tracks_per_period) {
            Ok(poisson) => poisson.sample(&mut stream(seed, Purpose::FalseCount, source, period, 0)) as u64,
            // A mean of zero.
            Err(_) => 0,
        }
    }

    /// Creates number `index` of the false targets appearing in period number `period`.
    pub(crate) fn new(settings: &CheckedSensor, seed: u64, source: u16, period: u64, index: u64) -> Self {
        let mut random = stream(seed, Purpose::FalseTarget, source, period, index);
        let coverage = &settings.coverage;
        let range = coverage.range_max_m * random.random_range(0.0..1.0f64).sqrt();
        let (sin, cos) = random.random_range(0.0..std::f64::consts::TAU).sin_cos();
        let height = random.random_range(HEIGHTS_M[0]..HEIGHTS_M[1]);
        let begin_s = settings.schedule.phase_s + period as f64 * settings.schedule.period_s;
        let life = -MEAN_LIFE_PERIODS * (1.0 - random.random_range(0.0..1.0f64)).ln();
        Self {
            thing: 1 << 63 | period << 16 | index,
            begin_s,
            end_s: begin_s + life * settings.schedule.period_s,
            position_m: [
                coverage.position_m[0] + range * sin,
                coverage.position_m[1] + range * cos,
                height.clamp(coverage.height_min_m, coverage.height_max_m),
            ],
            velocity_mps: [speed(&mut random), speed(&mut random)],
        }
    }

    /// Returns the position, also outside the lifetime.
    pub(crate) fn position_at(&self, time_s: f64) -> [f64; 3] {
        let age_s = time_s - self.begin_s;
        [
            self.position_m[0] + self.velocity_mps[0] * age_s,
            self.position_m[1] + self.velocity_mps[1] * age_s,
            self.position_m[2],
        ]
    }

    /// Whether the target exists at a time.
    pub(crate) fn lasts_at(&self, time_s: f64) -> bool {
        (self.begin_s..=self.end_s).contains(&time_s)
    }
}

fn speed(random: &mut ChaCha8Rng) -> f64 {
    let normal: f64 = StandardNormal.sample(random);
    SPEED_SIGMA_MPS * normal
}

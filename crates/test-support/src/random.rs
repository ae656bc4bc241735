//! Numbers without pattern that are the same in every run, on every machine, in every version.

/// A linear congruential generator (multiplier and increment of Knuth's MMIX), good enough to scatter test data.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// Makes a generator with the first state `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next number, uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The next number, uniform between these two.
    pub fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.unit()
    }
}

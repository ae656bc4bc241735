//! What the engine counts.

use messages::{COUNTERS_MAX, Counter};

/// Counters of the engine as a whole and of each source.
#[derive(Clone, Debug)]
pub struct Counts {
    total: [u64; COUNTERS_MAX],
    sources: Vec<[u64; COUNTERS_MAX]>,
}

impl Counts {
    /// All zero, for `sources` sources.
    pub fn new(sources: usize) -> Self {
        Self {
            total: [0; COUNTERS_MAX],
            sources: vec![[0; COUNTERS_MAX]; sources],
        }
    }

    /// One more of `counter`, for the whole and, if it exists, for `source`.
    pub fn add(&mut self, source: u16, counter: Counter) {
        self.add_many(source, counter, 1);
    }

    /// `count` more of `counter`.
    pub fn add_many(&mut self, source: u16, counter: Counter, count: u64) {
        self.total[counter as usize] += count;
        if let Some(counters) = self.sources.get_mut(usize::from(source)) {
            counters[counter as usize] += count;
        }
    }

    /// Sets the level that `counter` shows for the whole.
    pub fn set_level(&mut self, counter: Counter, level: u64) {
        self.total[counter as usize] = level;
    }

    /// Counters of the whole, indexed by [`Counter`].
    pub fn total(&self) -> &[u64; COUNTERS_MAX] {
        &self.total
    }

    /// Counters of one source, indexed by [`Counter`].
    pub fn source(&self, source: u16) -> Option<&[u64; COUNTERS_MAX]> {
        self.sources.get(usize::from(source))
    }

    /// One counter of the whole.
    pub fn get(&self, counter: Counter) -> u64 {
        self.total[counter as usize]
    }
}

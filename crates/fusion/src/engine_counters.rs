//! Counters of the engine.

use messages::{Counter, Counters};

/// Counters of the engine as a whole and of each source.
#[derive(Clone, Debug)]
pub struct EngineCounters {
    total: Counters,
    sources: Vec<Counters>,
}

impl EngineCounters {
    /// All zero, for `sources` sources.
    pub fn new(sources: usize) -> Self {
        Self {
            total: Counters::default(),
            sources: vec![Counters::default(); sources],
        }
    }

    /// Increments `counter`, for the whole and, if present, for `source`.
    pub fn add(&mut self, source: u16, counter: Counter) {
        self.total[counter] += 1;
        if let Some(counters) = self.sources.get_mut(usize::from(source)) {
            counters[counter] += 1;
        }
    }

    /// Counters of the whole, indexed by [`Counter`].
    pub fn total(&self) -> &Counters {
        &self.total
    }

    /// Counters of a source, indexed by [`Counter`].
    pub fn source(&self, source: u16) -> Option<&Counters> {
        self.sources.get(usize::from(source))
    }

    /// A counter of the whole.
    pub fn get(&self, counter: Counter) -> u64 {
        self.total[counter]
    }
}

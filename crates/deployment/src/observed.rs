//! Facts for readers of a running deployment.

use crate::{Deployment, Input};

impl Deployment {
    /// Returns the sources, and behind them the sensors of tracker processes, as readers of the running deployment
    /// use them.
    pub fn observed_sources(&self) -> Vec<observed::SourceFacts> {
        let sources = self.sources.iter().chain(&self.tracker_sensors);
        let sources = sources.map(|source| observed::SourceFacts {
            number: source.number,
            name: source.name.clone(),
            adapter: source.adapter.clone(),
            is_external: matches!(source.input, Input::External) && source.has_tracks(),
            silent_after_ns: source.silent_after_ns,
            period_ns: source.period_ns,
            // Simulated sensors observe with the configured north.
            north_offset_rad: (matches!(source.input, Input::Live(_) | Input::Recorded(_))
                && !source.is_taken_as_it_is())
            .then(|| source.model.frame.north_offset_rad()),
        });
        sources.collect()
    }
}

//! Facts for readers of a running deployment.

use crate::{Deployment, Input};

impl Deployment {
    /// Returns the sources, and behind them the sensors of tracker processes, as readers of the running deployment
    /// use them.
    pub fn observed_sources(&self) -> Vec<observed::SourceFacts> {
        let sensors = self.sources.iter().flat_map(|tracker| {
            let sensors = self.sensors_of(tracker).iter();
            sensors.map(move |sensor| (sensor, Some(tracker.number)))
        });
        let sources = self.sources.iter().map(|source| (source, None)).chain(sensors);
        let sources = sources.map(|(source, sensor_of)| observed::SourceFacts {
            number: source.number,
            name: source.name.clone(),
            adapter: source.adapter.clone(),
            sensor_of,
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

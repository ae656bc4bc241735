//! Facts for readers of a running deployment.

use messages::{Bias, BiasKind};

use crate::{Deployment, Input};

/// Configured facts about a source.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceFacts {
    /// Number.
    pub number: u16,
    /// Name.
    pub name: String,
    /// Name of the adapter process that publishes the source.
    pub adapter: String,
    /// Number of the source whose tracker takes the detections, if this is a sensor of a tracker: then fusion takes
    /// none of its samples.
    pub sensor_of: Option<u16>,
    /// True if a program of others publishes the source, without an adapter.
    pub is_external: bool,
    /// Silence after which the source is silent, nanoseconds; `None`: never.
    pub silent_after_ns: Option<i64>,
    /// Time between two reports of one target, nanoseconds.
    pub period_ns: i64,
    /// Configured direction of the sensor's own north, radians clockwise from true north; `None` where the direction
    /// has no effect on positions.
    pub north_offset_rad: Option<f64>,
}

impl SourceFacts {
    /// Returns the value of `north_offset_deg` that ends a bias of azimuth, in hundredths of a degree; `None` for
    /// another bias, or where the key has no effect.
    pub fn north_offset_against(&self, bias: &Bias) -> Option<f64> {
        let configured_rad = self.north_offset_rad.filter(|_| bias.kind == BiasKind::Azimuth)?;
        let correct_deg = (configured_rad - bias.value[0]).to_degrees();
        // Adding 0 makes a negative zero positive.
        Some((correct_deg * 100.0).round() / 100.0 + 0.0)
    }
}

impl Deployment {
    /// Returns the sources, and behind them the sensors of tracker processes, as readers of the running deployment
    /// use them.
    pub fn observed_sources(&self) -> Vec<SourceFacts> {
        let sensors = self.sources.iter().flat_map(|tracker| {
            let sensors = self.sensors_of(tracker).iter();
            sensors.map(move |sensor| (sensor, Some(tracker.number)))
        });
        let sources = self.sources.iter().map(|source| (source, None)).chain(sensors);
        let sources = sources.map(|(source, sensor_of)| SourceFacts {
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
            .then(|| source.frame.north_offset_rad()),
        });
        sources.collect()
    }
}

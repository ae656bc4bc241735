//! Words of keys of the configuration that belong to no other crate.

settings::words! {
    /// Samples that a separate process publishes for a source.
    pub enum ExternalInput {
        /// Tracks of the sensor.
        Tracks = "tracks",
        /// Detections: a tracker process makes the tracks.
        Detections = "detections",
    }
}

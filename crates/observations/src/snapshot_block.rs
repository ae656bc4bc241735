//! Snapshots of an antenna array as they arrive: part of a measurement, or all of it (EL-1).

/// Successive snapshots of one measurement: samples of all antennas at one frequency, from one place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SnapshotBlock {
    /// Time of the measurement, UTC, nanoseconds since 1970.
    pub time_ns: i64,
    /// Number of the measurement at its sender.
    pub measurement: u32,
    /// Number of snapshots of the whole measurement.
    pub total: u32,
    /// Place of the block's first snapshot in the measurement, from 0.
    pub first: u32,
    /// Number of antennas.
    pub antennas: u16,
    /// Frequency of the waves, hertz.
    pub frequency_hz: f64,
    /// Position of the platform east, north, up in the system frame, metres; `None` if the array states none.
    pub platform_m: Option<[f64; 3]>,
    /// Heading of the platform, radians clockwise from north; `None` if the array states none.
    pub heading_rad: Option<f64>,
    /// Real and imaginary part of each sample: snapshot after snapshot, in the order of the antennas.
    pub samples: Vec<[f32; 2]>,
}

impl SnapshotBlock {
    /// Number of snapshots in the block.
    pub fn snapshots(&self) -> usize {
        self.samples.len() / usize::from(self.antennas).max(1)
    }
}

//! State carried from scan to scan for starts at crossings ([`crate::crossing`]).

use crate::measurement::DetectionMeasurement;

/// Most directions kept of all sensors.
pub(crate) const RAYS_MAX: usize = 64;
/// Most tentative tracks that have begun at crossings.
pub(crate) const ROOTS_MAX: usize = 64;

/// A direction that belongs to no track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ray {
    /// Bit of the sensor.
    pub(crate) sensor: u64,
    pub(crate) time_ns: i64,
    pub(crate) serial: u32,
    /// Expected number of false directions in the ray's scan.
    pub(crate) expected_false: f64,
    pub(crate) measurement: DetectionMeasurement,
}

/// State carried from scan to scan.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CrossingMemory {
    pub(crate) rays: Vec<Ray>,
    /// Roots of the tentative tracks that have begun at crossings.
    pub(crate) roots: Vec<u32>,
    /// Time at which the first of these has begun, nanoseconds.
    pub(crate) since_ns: i64,
}

impl CrossingMemory {
    pub(crate) fn new() -> Self {
        Self {
            rays: Vec::with_capacity(RAYS_MAX),
            roots: Vec::with_capacity(ROOTS_MAX),
            since_ns: 0,
        }
    }

    /// Copies without taking memory.
    pub(crate) fn follow(&mut self, before: &Self) {
        self.rays.clear();
        self.rays.extend_from_slice(&before.rays);
        self.roots.clear();
        self.roots.extend_from_slice(&before.roots);
        self.since_ns = before.since_ns;
    }
}

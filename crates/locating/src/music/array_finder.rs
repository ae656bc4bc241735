//! Usable bearings of an array on a platform: unambiguous, inside the sector, and not too uncertain.

use super::error::MusicError;
use super::settings::ArraySettings;
use super::{BearingSet, Music, Snapshots, WaveBearing};

/// Largest standard deviation of a usable bearing, radians.
const SIGMA_MAX_RAD: f64 = 1.0;

/// Counts of measurements, of usable bearings, and of the others by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FinderCounts {
    /// Measurements with a result.
    pub measurements: u64,
    /// Usable bearings.
    pub bearings: u64,
    /// Bearings beside another bearing that explains the snapshots as well.
    pub ambiguous: u64,
    /// Bearings outside the sector of the array.
    pub outside_sector: u64,
    /// Bearings with a standard deviation of more than 1 rad.
    pub uncertain: u64,
    /// Transmitters without a separate bearing.
    pub unresolved: u64,
}

/// Direction finder: an array, the settings, and the counts.
#[derive(Clone, Debug)]
pub struct ArrayFinder {
    settings: ArraySettings,
    music: Music,
    usable: Vec<WaveBearing>,
    counts: FinderCounts,
}

impl ArrayFinder {
    /// Prepares the array of these settings.
    ///
    /// # Errors
    /// As [`ArraySettings::music`].
    pub fn new(settings: ArraySettings) -> Result<Self, MusicError> {
        Ok(Self {
            music: settings.music()?,
            settings,
            usable: Vec::new(),
            counts: FinderCounts::default(),
        })
    }

    /// Measures the usable bearings of snapshots, clockwise from the platform's heading.
    ///
    /// # Errors
    /// As [`Music::measure`].
    pub fn measure(&mut self, snapshots: &Snapshots<'_>) -> Result<&[WaveBearing], MusicError> {
        let measured = self.music.measure(snapshots)?;
        select(&self.settings, measured, &mut self.usable, &mut self.counts);
        let forward_rad = self.settings.forward_deg.rad();
        for bearing in &mut self.usable {
            bearing.bearing_rad += forward_rad;
        }
        Ok(&self.usable)
    }

    /// Counts so far.
    pub fn counts(&self) -> &FinderCounts {
        &self.counts
    }

    /// Settings of the array.
    pub fn settings(&self) -> &ArraySettings {
        &self.settings
    }

    /// The array's measurement, for the spectrum of the last snapshots.
    pub fn music(&self) -> &Music {
        &self.music
    }
}

/// Selects the usable bearings, and counts all.
fn select(settings: &ArraySettings, measured: &BearingSet, usable: &mut Vec<WaveBearing>, counts: &mut FinderCounts) {
    counts.measurements += 1;
    counts.unresolved += measured.unresolved as u64;
    let hears = |bearing: &WaveBearing| settings.hears(bearing.bearing_rad);
    let of = |source: usize, is_heard: bool| {
        let alike = |other: &&WaveBearing| other.source == source && hears(other) == is_heard;
        measured.bearings.iter().filter(alike).count()
    };
    usable.clear();
    for bearing in &measured.bearings {
        // A bearing ambiguous only with bearings outside the covered sector is unambiguous.
        let is_clear = || !bearing.ambiguous || (of(bearing.source, true) == 1 && of(bearing.source, false) > 0);
        let counter = if !hears(bearing) {
            &mut counts.outside_sector
        } else if !is_clear() {
            &mut counts.ambiguous
        } else if bearing.sigma_rad > SIGMA_MAX_RAD {
            &mut counts.uncertain
        } else {
            usable.push(*bearing);
            &mut counts.bearings
        };
        *counter += 1;
    }
}

//! Snapshots of an antenna array converted into bearings on arrival (EL-1).
//!
//! A measurement arrives in at least one block. A measurement is complete with the last snapshot, or when a later
//! measurement begins: snapshots are independent, so a lost block costs accuracy and not the measurement. Blocks that
//! come twice or after a later measurement are refused; the time of a measurement is greater than the time of the
//! previous measurement.

use std::f64::consts::TAU;

use locating::music::{ArrayFinder, ArraySettings, Complex, MusicError, Snapshots, WaveBearing};
use messages::{Counter, Counters, SPECTRUM_DIRECTIONS, SensorSpectrum, StageTimes};
use observations::{Bearing, SnapshotBlock};

/// Collects measurements of an array, and measures the bearings.
#[derive(Debug)]
pub struct SnapshotIntake {
    array: ArrayFinder,
    /// Head of the measurement that is being collected; the samples are held beside.
    present: Option<MeasurementHead>,
    samples: Vec<Complex<f64>>,
    /// Time of the latest measurement, UTC, nanoseconds.
    latest_ns: i64,
    counts: IntakeCounts,
}

/// Head of a measurement.
#[derive(Clone, Copy, Debug)]
struct MeasurementHead {
    number: u32,
    total: u32,
    /// Place behind the snapshots so far, and how many have come.
    next: u32,
    received: u32,
    time_ns: i64,
    frequency_hz: f64,
    platform_m: Option<[f64; 3]>,
    heading_rad: Option<f64>,
    /// Time of receipt of the latest block, monotonic, nanoseconds.
    ingested_ns: i64,
}

/// Counts of refused blocks by reason, and of measurements.
#[derive(Clone, Copy, Debug, Default)]
struct IntakeCounts {
    blocks: u64,
    antennas: u64,
    conflicting: u64,
    repeated: u64,
    missing: u64,
    unusable: u64,
}

/// Result of a measurement.
#[derive(Debug, Default)]
pub struct ArrayMeasurement {
    /// Usable bearings, clockwise from the bow.
    pub bearings: Vec<Bearing>,
    /// Whether the snapshots state position and heading of the platform.
    pub is_placed: bool,
    /// Spectrum, if requested.
    pub spectrum: Option<Box<SensorSpectrum>>,
    /// Time of receipt of the last block, monotonic, nanoseconds.
    pub ingested_ns: i64,
}

impl SnapshotIntake {
    /// Prepares the array of these settings.
    ///
    /// # Errors
    /// As [`ArraySettings::music`].
    pub fn new(settings: &ArraySettings) -> Result<Self, MusicError> {
        Ok(Self {
            array: ArrayFinder::new(settings.clone())?,
            present: None,
            samples: Vec::new(),
            latest_ns: i64::MIN,
            counts: IntakeCounts::default(),
        })
    }

    /// Takes a block received at `ingested_ns` (monotonic, nanoseconds). `each` gets the complete measurements, with
    /// spectra if `with_spectrum`: the previous measurement, if the block begins another, and the block's own.
    pub fn take(
        &mut self,
        block: &SnapshotBlock,
        ingested_ns: i64,
        with_spectrum: bool,
        mut each: impl FnMut(ArrayMeasurement),
    ) {
        self.counts.blocks += 1;
        if usize::from(block.antennas) != self.array.settings().antennas.len() {
            self.counts.antennas += 1;
            return;
        }
        let is_present = |head: &MeasurementHead| head.number == block.measurement && head.time_ns == block.time_ns;
        if !self.present.as_ref().is_some_and(is_present) {
            if block.time_ns <= self.latest_ns {
                self.counts.repeated += 1;
                return;
            }
            if self.present.is_some() {
                each(self.measure(with_spectrum));
            }
            self.latest_ns = block.time_ns;
            self.present = Some(MeasurementHead::of(block));
        }
        let Some(head) = &mut self.present else { return };
        if !head.fits(block) {
            self.counts.conflicting += 1;
            return;
        }
        if block.first < head.next {
            self.counts.repeated += 1;
            return;
        }
        let snapshots = block.snapshots() as u32;
        head.next = block.first + snapshots;
        head.received += snapshots;
        head.ingested_ns = ingested_ns;
        let is_complete = head.next >= head.total;
        let sample = |[re, im]: &[f32; 2]| Complex::new(f64::from(*re), f64::from(*im));
        self.samples.extend(block.samples.iter().map(sample));
        if is_complete {
            each(self.measure(with_spectrum));
        }
    }

    /// Measures the collected snapshots.
    fn measure(&mut self, with_spectrum: bool) -> ArrayMeasurement {
        let Some(head) = self.present.take() else {
            return ArrayMeasurement::default();
        };
        self.counts.missing += u64::from(head.total - head.received);
        let snapshots = Snapshots {
            samples: &self.samples,
            frequency_hz: head.frequency_hz,
        };
        let mut result = ArrayMeasurement {
            is_placed: head.platform_m.is_some() && head.heading_rad.is_some(),
            ingested_ns: head.ingested_ns,
            ..ArrayMeasurement::default()
        };
        match self.array.measure(&snapshots) {
            Ok(usable) => {
                let bearing = |wave: &WaveBearing| head.bearing(wave.bearing_rad, wave.sigma_rad);
                result.bearings.extend(usable.iter().map(bearing));
                result.spectrum = with_spectrum.then(|| Box::new(self.spectrum(&head)));
            }
            Err(_) => self.counts.unusable += 1,
        }
        self.samples.clear();
        result
    }

    fn spectrum(&self, head: &MeasurementHead) -> SensorSpectrum {
        let music = self.array.music();
        let mut spectrum_db = [0.0; SPECTRUM_DIRECTIONS];
        music.spectrum_db(&mut spectrum_db);
        let (heading_rad, forward_rad) = (
            head.heading_rad.unwrap_or_default(),
            self.array.settings().forward_deg.rad(),
        );
        let measured = music.measured();
        SensorSpectrum {
            time_of_measurement_ns: head.time_ns,
            stages: StageTimes {
                ingested_ns: head.ingested_ns,
                ..StageTimes::default()
            },
            forward_rad: (heading_rad + forward_rad).rem_euclid(TAU),
            frequency_hz: head.frequency_hz,
            noise_variance: measured.noise_variance,
            snapshots: head.received,
            transmitters: measured.sources as u32,
            spectrum_db,
            ..SensorSpectrum::default()
        }
    }

    /// Adds the counts of this intake.
    pub fn count(&self, counters: &mut Counters) {
        let (own, finder) = (&self.counts, self.array.counts());
        for (counter, count) in [
            (Counter::Records, own.blocks),
            (Counter::SnapshotsAntennas, own.antennas),
            (Counter::SnapshotsValue, own.conflicting),
            (Counter::SnapshotsRepeated, own.repeated),
            (Counter::SnapshotsMissing, own.missing),
            (Counter::MeasurementsUnusable, own.unusable),
            (Counter::BearingsAmbiguous, finder.ambiguous),
            (Counter::BearingsOutsideSector, finder.outside_sector),
            (Counter::BearingsUncertain, finder.uncertain),
            (Counter::WavesUnresolved, finder.unresolved),
        ] {
            counters[counter] += count;
        }
    }
}

impl MeasurementHead {
    fn of(block: &SnapshotBlock) -> Self {
        Self {
            number: block.measurement,
            total: block.total,
            next: 0,
            received: 0,
            time_ns: block.time_ns,
            frequency_hz: block.frequency_hz,
            platform_m: block.platform_m,
            heading_rad: block.heading_rad,
            ingested_ns: 0,
        }
    }

    /// Whether a block states the same as the first block.
    fn fits(&self, block: &SnapshotBlock) -> bool {
        self.total == block.total
            && self.frequency_hz == block.frequency_hz
            && self.platform_m == block.platform_m
            && self.heading_rad == block.heading_rad
    }

    /// The bearing of a wave.
    fn bearing(&self, bearing_rad: f64, sigma_rad: f64) -> Bearing {
        Bearing {
            time_of_measurement_ns: self.time_ns,
            emitter_id: None,
            bearing_rad: bearing_rad.rem_euclid(TAU),
            sigma_rad,
            platform_m: self.platform_m.unwrap_or_default(),
            heading_rad: self.heading_rad,
            frequency_hz: Some(self.frequency_hz),
            pulse_interval_s: None,
        }
    }
}

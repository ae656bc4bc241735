//! Tracks of a source that delivers bearings, arrival times or fixes of emitters: each goes through the locator
//! ([`locating`], EL).
//!
//! A bearing contains the platform's position, and is published with this position, before the resulting track. So are
//! arrival times and fixes, each kind on a separate topic, in the order in which the locator takes them. An emitter
//! without sufficient geometry for a fix has no track yet. Nothing waits: a track is as old as the latest bearing. A
//! silent emitter has no further reports, as with any sensor. Only arrival times wait: for the other receivers of the
//! same transmission, until a later row or half a second without arrivals.
//!
//! An antenna array delivers snapshots instead; the bearings are measured here first ([`crate::snapshot_intake`]).

use std::f64::consts::TAU;
use std::sync::atomic::AtomicU64;

use estimation::SourceClock;
use frames::SystemFrame;
use kept::{Memory, MemoryRefusal};
use locating::music::ArraySettings;
use locating::{BearingRejection, DroppedEmitter, EmitterMemory, EmitterReport, LeftEmitters, Locator, Settings};
use messages::{Counter, Counters, SensorTrack};
use observations::{ArrivalTime, Bearing, EmitterMeasurement, Sampled, SnapshotBlock};
use platform::{Assumed, BearingRoom, History, Mount, State};
use reception::PlausibilityLimits;
use settings::SettingsError;

use crate::detection_tracker::ingested;
use crate::last_kept::LastKept;
use crate::samples::Samples;
use crate::snapshot_intake::{ArrayMeasurement, SnapshotIntake};

/// Origin of a direction finder's bearings, and the method of location.
#[derive(Clone, Debug, PartialEq)]
pub struct FinderSettings {
    /// Locator of the transmitters.
    pub locator: Settings,
    /// Array with the snapshots that give the bearings; `None` if the finder delivers bearings.
    pub array: Option<ArraySettings>,
    /// Emitters with a known first place.
    pub dropped: Vec<DroppedEmitter>,
}

/// Most bearings of a finder on board that wait for a state of the platform.
const WAITING_MAX: usize = 4096;
/// States of the platform that are kept: half a minute of an inertial sensor.
const STATES_MAX: usize = 4096;

/// Direction finder on a platform: the bearings are from the bow, and wait for the platform's states.
#[derive(Debug)]
struct BoardedFinder {
    frame: SystemFrame,
    history: History,
    room: BearingRoom<i64>,
}

/// Longest wait of a transmission for another receiver after the latest arrival, nanoseconds.
const ARRIVAL_WAIT_NS: i64 = 500_000_000;

/// Locator of a direction finder, or of a network of receivers.
#[derive(Debug)]
pub struct BearingLocator {
    source: u16,
    limits: PlausibilityLimits,
    locator: Locator,
    /// Array, if bearings are measured here.
    intake: Option<SnapshotIntake>,
    /// Platform that carries the finder, if the finder does not state place and heading.
    boarded: Option<BoardedFinder>,
    /// Whether somebody receives the array's spectra.
    with_spectrum: bool,
    /// Time of receipt (UTC) of the latest bearings, nanoseconds; `None` for recordings.
    received_ns: Option<i64>,
    /// The finder's clock against that.
    clock: SourceClock,
    rejected: RejectionCounts,
    newest_ns: i64,
    /// Time of the latest state of the platform.
    platform_ns: i64,
    /// Place of the latest measurement: platform, receiver or fix.
    origin_m: [f64; 2],
    /// Time of receipt of the latest arrival time that may wait for others.
    arrived_ns: Option<i64>,
    memory: Option<EmitterMemory>,
    kept: LastKept,
}

/// Counts of rejected bearings, and of rejected tracks, by reason.
#[derive(Clone, Copy, Debug, Default)]
struct RejectionCounts {
    time: u64,
    position: u64,
    speed: u64,
    /// Measurements without position and heading of the platform.
    unplaced: u64,
}

impl BearingLocator {
    /// Makes the locator of source number `source`; the tracks keep to `limits`.
    ///
    /// # Errors
    /// The first unusable setting.
    pub fn new(source: u16, limits: PlausibilityLimits, settings: &FinderSettings) -> Result<Self, SettingsError> {
        let intake = settings.array.as_ref().map(SnapshotIntake::new).transpose();
        let mut locator = Locator::new(settings.locator)?;
        locator.set_dropped(&settings.dropped);
        Ok(Self {
            source,
            limits,
            locator,
            intake: intake.map_err(|error| SettingsError::new("array", error.to_string()))?,
            boarded: None,
            with_spectrum: false,
            received_ns: None,
            clock: SourceClock::new(limits.clock_step().s()),
            rejected: RejectionCounts::default(),
            newest_ns: i64::MIN,
            platform_ns: i64::MIN,
            origin_m: [0.0; 2],
            arrived_ns: None,
            memory: None,
            kept: LastKept::default(),
        })
    }

    /// Clock of the direction finder, estimated from times of receipt.
    pub fn clock(&self) -> &SourceClock {
        &self.clock
    }

    /// Sets the time of receipt of the following bearings, nanoseconds, by a UTC clock without steps during the
    /// process.
    pub fn received(&mut self, received_ns: i64) {
        self.received_ns = Some(received_ns);
    }

    /// Sets whether somebody receives the array's spectra; otherwise none is computed.
    pub fn wants_spectrum(&mut self, is_wanted: bool) {
        self.with_spectrum = is_wanted;
    }

    /// Takes snapshots of the array received at `ingested_ns` (monotonic, nanoseconds).
    pub fn snapshots(&mut self, block: &SnapshotBlock, ingested_ns: i64, samples: &mut Samples) {
        // A single time far ahead would make all later measurements too old.
        if !self.believes(block.time_ns) {
            return;
        }
        let Some(mut intake) = self.intake.take() else { return };
        intake.take(block, ingested_ns, self.with_spectrum, |measurement| {
            self.measured(measurement, samples);
        });
        self.intake = Some(intake);
    }

    /// Takes a measurement of the array.
    fn measured(&mut self, measurement: ArrayMeasurement, samples: &mut Samples) {
        let source = self.source;
        samples.spectra.extend(measurement.spectrum.map(|mut spectrum| {
            spectrum.source = source;
            *spectrum
        }));
        for bearing in &measurement.bearings {
            if let Some(boarded) = &mut self.boarded {
                boarded.room.take(*bearing, measurement.ingested_ns);
                continue;
            }
            match bearing.heading_rad.filter(|_| measurement.is_placed) {
                Some(heading_rad) => {
                    let bearing_rad = (heading_rad + bearing.bearing_rad).rem_euclid(TAU);
                    let from_north = Bearing {
                        bearing_rad,
                        ..*bearing
                    };
                    self.locate(
                        &EmitterMeasurement::Bearing(from_north),
                        measurement.ingested_ns,
                        samples,
                    );
                }
                None => self.rejected.unplaced += 1,
            }
        }
        self.release(samples);
    }

    /// Mounts the finder on a platform, with states given to [`Self::state`]. The finder's data run ahead of the states
    /// by at most `wait_ns`.
    pub fn mount_on(&mut self, frame: SystemFrame, mount: Mount, assumed: Assumed, wait_ns: i64) {
        self.boarded = Some(BoardedFinder {
            frame,
            history: History::new(assumed, STATES_MAX),
            room: BearingRoom::new(mount, wait_ns, WAITING_MAX),
        });
    }

    /// Takes a state of the platform that carries the finder.
    pub fn state(&mut self, state: &State, samples: &mut Samples) {
        if let Some(boarded) = &mut self.boarded {
            boarded.history.add(state);
            self.release(samples);
        }
    }

    /// Locates the bearings that need not wait for a state any longer.
    fn release(&mut self, samples: &mut Samples) {
        let Some(mut boarded) = self.boarded.take() else { return };
        while let Some((bearing, ingested_ns)) = boarded.room.next(&boarded.history, Some(&boarded.frame)) {
            self.locate(&EmitterMeasurement::Bearing(bearing), ingested_ns, samples);
        }
        self.boarded = Some(boarded);
    }

    /// Returns whether a time of the finder fits the time of receipt; counts a misfit.
    fn believes(&mut self, time_ns: i64) -> bool {
        let is_wild = |received_ns: i64| !self.clock.believes(time_ns, received_ns, None);
        let is_believed = !self.received_ns.is_some_and(is_wild);
        self.rejected.time += u64::from(!is_believed);
        is_believed
    }

    /// Takes a measurement received at `ingested_ns` (monotonic, nanoseconds).
    pub fn take(&mut self, measured: &EmitterMeasurement, ingested_ns: i64, samples: &mut Samples) {
        if !self.believes(measured.time_ns()) {
            return;
        }
        match (measured, &mut self.boarded) {
            (EmitterMeasurement::Bearing(bearing), Some(boarded)) => {
                boarded.room.take(*bearing, ingested_ns);
                self.release(samples);
            }
            _ => self.locate(measured, ingested_ns, samples),
        }
    }

    fn locate(&mut self, measured: &EmitterMeasurement, ingested_ns: i64, samples: &mut Samples) {
        let time_ns = measured.time_ns();
        self.complete(Some(time_ns), ingested_ns, samples);
        // The locator counts rejected measurements.
        let taken = match measured {
            EmitterMeasurement::Bearing(bearing) => self.locator.bearing(bearing),
            EmitterMeasurement::Arrival(arrival) => self.locator.arrival(arrival),
            EmitterMeasurement::Fix(fix) => self.locator.fix(fix),
        };
        let stages = ingested(ingested_ns);
        if let EmitterMeasurement::Arrival(arrival) = measured
            && !taken.as_ref().is_err_and(BearingRejection::is_of_arrival)
        {
            self.arrived_ns = self.received_ns;
            samples.arrivals.push(arrival.sample(self.source, stages));
        }
        let Ok(report) = taken else { return };
        let [east, north, _] = match measured {
            EmitterMeasurement::Bearing(bearing) => {
                samples.bearings.push(bearing.sample(self.source, stages));
                if time_ns > self.platform_ns {
                    self.platform_ns = time_ns;
                    samples.platforms.push(bearing.platform(self.source, stages));
                }
                bearing.platform_m
            }
            EmitterMeasurement::Arrival(arrival) => match arrival.time {
                ArrivalTime::At { receiver, .. } => receiver.position_m,
                ArrivalTime::Between { receivers, .. } => receivers[0].position_m,
            },
            EmitterMeasurement::Fix(fix) => {
                samples.fixes.push(fix.sample(self.source, stages));
                fix.position_m
            }
        };
        self.origin_m = [east, north];
        self.publish(report, ingested_ns, samples);
    }

    /// The clock has come to `steady_ns`, the UTC of the times given to [`Self::received`], and no received data wait:
    /// a transmission does not wait for ever for another receiver.
    pub fn elapsed(&mut self, steady_ns: i64, ingested_ns: i64, samples: &mut Samples) {
        if self
            .arrived_ns
            .is_some_and(|arrived_ns| steady_ns - arrived_ns > ARRIVAL_WAIT_NS)
        {
            self.arrived_ns = None;
            self.complete(None, ingested_ns, samples);
        }
    }

    /// Processes transmissions that are complete at `now_ns` (UTC, nanoseconds); `None`: all.
    fn complete(&mut self, now_ns: Option<i64>, ingested_ns: i64, samples: &mut Samples) {
        while let Some(taken) = self.locator.complete(now_ns) {
            self.publish(taken.unwrap_or_default(), ingested_ns, samples);
        }
    }

    fn publish(&mut self, report: Option<EmitterReport>, ingested_ns: i64, samples: &mut Samples) {
        let Some(report) = report else { return };
        let mut track = report.sensor_track(self.source);
        track.stages = ingested(ingested_ns);
        if self.can_be(&track) {
            self.newest_ns = self.newest_ns.max(track.time_of_measurement_ns);
            samples.tracks.push(track);
        }
    }

    /// Returns whether a track's position and speed are within the limits of the source's targets; counts a violation.
    fn can_be(&mut self, track: &SensorTrack) -> bool {
        let [east, north] = [0, 1].map(|axis| track.position_m[axis] - self.origin_m[axis]);
        let is_near = east.hypot(north) <= self.limits.range_m;
        let is_slow = track.velocity_mps[0].hypot(track.velocity_mps[1]) <= self.limits.speed_mps;
        self.rejected.position += u64::from(!is_near);
        self.rejected.speed += u64::from(is_near && !is_slow);
        is_near && is_slow
    }

    /// Size in words of the memory for the emitters.
    pub fn kept_words(&self) -> usize {
        EmitterMemory::words(self.locator.settings())
    }

    /// Resumes from another locator's emitters in `memory`, if later than `since_ns` (UTC, nanoseconds); otherwise only
    /// the numbers stay reserved. Must be called before the first bearing.
    ///
    /// # Errors
    /// If the memory is not whole, or not this locator's.
    pub fn resume(&mut self, memory: &[AtomicU64], owner: &str, since_ns: i64) -> Result<(), MemoryRefusal> {
        if let Some(mut left) = LeftEmitters::read(memory, owner, self.locator.settings())? {
            if left.kept_ns() < since_ns {
                left.end();
            }
            self.locator.resume(&left);
        }
        Ok(())
    }

    /// Saves the emitters in `memory` from now on; the memory is blank and has [this size](Self::kept_words).
    pub fn keep_in(&mut self, memory: Box<dyn Memory>, owner: &str) {
        self.memory = Some(EmitterMemory::begin(memory, owner, self.locator.settings()));
    }

    /// Saves the emitters, if due at `now_ns` (UTC, nanoseconds): before the tracks are published.
    pub fn keep(&mut self, now_ns: i64) {
        if let Some(memory) = &mut self.memory
            && self.kept.is_due(self.locator.counts().measurements(), now_ns)
        {
            self.locator.keep(memory, now_ns);
        }
    }

    /// Time of the latest track, nanoseconds.
    pub fn progress_ns(&self) -> i64 {
        self.newest_ns
    }

    /// Adds the counts of this locator.
    pub fn count(&self, counters: &mut Counters) {
        if let Some(intake) = &self.intake {
            intake.count(counters);
        }
        let counts = self.locator.counts();
        let unplaced = self
            .boarded
            .as_ref()
            .map_or(0, |boarded| boarded.room.counts().refused());
        for (counter, count) in [
            (Counter::Detections, counts.measurements()),
            (Counter::DetectionsWithoutFix, counts.without_fix),
            (
                Counter::DetectionsRejected,
                counts.unusable + counts.alone + counts.clock_unknown + counts.impossible,
            ),
            (Counter::RejectedLate, counts.out_of_order),
            (Counter::TracksDropped, counts.table_full),
            (Counter::RejectedTime, self.rejected.time),
            (Counter::RejectedPosition, self.rejected.position),
            (Counter::RejectedSpeed, self.rejected.speed),
            (Counter::RejectedPlatform, self.rejected.unplaced + unplaced),
            (
                Counter::Reports,
                counts.fixes - self.rejected.position - self.rejected.speed,
            ),
        ] {
            counters[counter] += count;
        }
    }
}

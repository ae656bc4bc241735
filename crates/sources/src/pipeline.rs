//! Pipeline of a source, from observations to samples.
//!
//! All records pass the same checks first, in [`Converter`], independent of the further processing. A new way to make
//! tracks is a new kind of [`Processing`]: a file here, a variant, a line in each of the methods of [`Pipeline`].

use std::sync::atomic::AtomicU64;

use frames::SystemFrame;
use kept::{Memory, MemoryRefusal};
use messages::{Counters, NS_PER_S, SensorBearing, sensor_track_bits};
use observations::{EmitterMeasurement, Observation, SensorEvent, ServiceMessage, SnapshotBlock, WideAreaReport};
use platform::{Assumed, Mount, State};
use reception::{ConversionModel, Converter, RefusedPlace};
use settings::SettingsError;
use tracking::turn_time::TurnEstimate;
use tracking::wide_area::arrivals::Arrivals;

use crate::bearing_locator::{BearingLocator, FinderSettings};
use crate::detection_tracker::{DetectionTracker, TrackerSettings};
use crate::plot_relay::PlotRelay;
use crate::samples::Samples;

/// Method for making a source's tracks.
#[derive(Clone, Debug, PartialEq)]
pub enum Processing {
    /// The sensor delivers tracks.
    Tracks,
    /// The sensor's detections are passed on; a tracker process makes tracks of the detections.
    Plots,
    /// Tracker for the source's detections.
    Detections(Box<TrackerSettings>),
    /// Locator for the source's bearings, delivered or measured from snapshots of an array.
    Bearings(Box<FinderSettings>),
}

impl Processing {
    /// Settings of the tracker, if any.
    pub fn tracker(&self) -> Option<&TrackerSettings> {
        match self {
            Self::Detections(settings) => Some(settings),
            Self::Tracks | Self::Plots | Self::Bearings(_) => None,
        }
    }

    /// Settings of the locator, if any.
    pub fn locator(&self) -> Option<&locating::Settings> {
        match self {
            Self::Bearings(settings) => Some(&settings.locator),
            Self::Tracks | Self::Plots | Self::Detections(_) => None,
        }
    }
}

/// Pipeline of a source, from observations to samples.
#[derive(Debug)]
pub struct Pipeline {
    converter: Converter,
    /// Sensor of the source, if to be distinguished from others.
    sac_sic: Option<(u8, u8)>,
    maker: Maker,
    progress_ns: i64,
}

/// Makes the tracks.
#[derive(Debug)]
enum Maker {
    None,
    Plots(Box<PlotRelay>),
    Tracker(Box<DetectionTracker>),
    Locator(Box<BearingLocator>),
}

impl Pipeline {
    /// Makes the pipeline of a source with a first report on the day that begins at `first_day_ns` (UTC,
    /// nanoseconds). A tracker begins with these `reports` of wide-area sensors; more may follow.
    ///
    /// # Errors
    /// The first unusable setting.
    pub fn new(
        model: ConversionModel,
        processing: &Processing,
        first_day_ns: i64,
        reports: Arrivals,
    ) -> Result<Self, SettingsError> {
        let number = model.number;
        let maker = match processing {
            Processing::Tracks => Maker::None,
            Processing::Plots => Maker::Plots(Box::new(PlotRelay::new(number, model.limits))),
            Processing::Detections(settings) => Maker::Tracker(Box::new(DetectionTracker::new(
                number,
                settings,
                first_day_ns,
                reports,
            )?)),
            Processing::Bearings(settings) => {
                let locator = BearingLocator::new(number, model.limits, settings);
                Maker::Locator(Box::new(locator?))
            }
        };
        Ok(Self {
            sac_sic: model.sac_sic,
            converter: Converter::new(model, first_day_ns),
            maker,
            progress_ns: i64::MIN,
        })
    }

    /// Sets the time of receipt of the following data, nanoseconds: see [`Converter::received`].
    pub fn received(&mut self, utc_ns: i64, steady_ns: i64) {
        self.converter.received(utc_ns, steady_ns);
        match &mut self.maker {
            Maker::Locator(locator) => locator.received(steady_ns),
            Maker::Plots(relay) => relay.received(steady_ns),
            Maker::None | Maker::Tracker(_) => {}
        }
    }

    /// Takes the latest position that was refused, if any since the last call.
    pub fn take_refused_place(&mut self) -> Option<RefusedPlace> {
        self.converter.take_refused_place()
    }

    /// Takes a target report received at `ingested_ns` (monotonic, nanoseconds).
    pub fn take(&mut self, observation: &Observation, ingested_ns: i64, samples: &mut Samples) {
        match &mut self.maker {
            Maker::None => {
                if let Some(track) = self.converter.convert(observation, ingested_ns) {
                    if !track.has(sensor_track_bits::WILD_CLOCK) {
                        self.progress_ns = self.progress_ns.max(track.time_of_measurement_ns);
                    }
                    samples.tracks.push(track);
                }
            }
            Maker::Tracker(tracker) => {
                if let Some(detection) = self.converter.detect(observation) {
                    tracker.take(detection, ingested_ns, samples);
                }
            }
            Maker::Plots(relay) => {
                if let Some(detection) = self.converter.detect(observation) {
                    relay.pass(&SensorEvent::Detection(detection), ingested_ns, samples);
                }
            }
            // Such a source has bearings only.
            Maker::Locator(_) => {}
        }
        self.follow();
    }

    /// Takes a measurement of an emitter received at `ingested_ns`.
    pub fn emitter(&mut self, measured: &EmitterMeasurement, ingested_ns: i64, samples: &mut Samples) {
        if let Maker::Locator(locator) = &mut self.maker {
            locator.take(measured, ingested_ns, samples);
        }
        self.follow();
    }

    /// Mounts a direction finder on a platform: the bearings are from the bow, and wait for the platform's states.
    pub fn mount_on(&mut self, frame: SystemFrame, mount: Mount, assumed: Assumed, wait_ns: i64) {
        if let Maker::Locator(locator) = &mut self.maker {
            locator.mount_on(frame, mount, assumed, wait_ns);
        }
    }

    /// Takes a state of the platform that carries the direction finder.
    pub fn platform_state(&mut self, state: &State, samples: &mut Samples) {
        if let Maker::Locator(locator) = &mut self.maker {
            locator.state(state, samples);
        }
        self.follow();
    }

    /// Takes snapshots of an antenna array received at `ingested_ns`; `with_spectrum` if the spectra have a receiver.
    pub fn snapshots(&mut self, block: &SnapshotBlock, ingested_ns: i64, with_spectrum: bool, samples: &mut Samples) {
        if let Maker::Locator(locator) = &mut self.maker {
            locator.wants_spectrum(with_spectrum);
            locator.snapshots(block, ingested_ns, samples);
        }
        self.follow();
    }

    /// Takes an event of a sensor that states detections in the system frame, received at `ingested_ns`.
    pub fn row(&mut self, event: &SensorEvent, ingested_ns: i64, samples: &mut Samples) {
        if let Maker::Plots(relay) = &mut self.maker {
            relay.row(event, ingested_ns, samples);
        }
        self.follow();
    }

    /// Takes an event of the sensor in this place of the tracker's settings, received at `ingested_ns`.
    pub fn event(&mut self, sensor: usize, event: &SensorEvent, ingested_ns: i64, samples: &mut Samples) {
        if let Maker::Tracker(tracker) = &mut self.maker {
            tracker.event(sensor, event, ingested_ns, samples);
        }
        self.follow();
    }

    /// Takes a record about the sensor, received at `ingested_ns`. Records of other sensors are ignored.
    pub fn service(&mut self, service: &ServiceMessage, ingested_ns: i64, samples: &mut Samples) {
        let is_of_another = |own| service.sac_sic.is_some_and(|sender| sender != own);
        if self.sac_sic.is_some_and(is_of_another) {
            return;
        }
        let time_ns = self.converter.service(service.time_of_day_ns);
        match &mut self.maker {
            Maker::None => {
                self.progress_ns = self.progress_ns.max(self.converter.running_ns().unwrap_or(i64::MIN));
            }
            Maker::Tracker(tracker) => {
                if let Some(turn_ns) = service.turn_ns {
                    tracker.turn_takes(turn_ns);
                }
                if let Some(time_ns) = time_ns {
                    tracker.passed(time_ns, service.turn_begins, ingested_ns, samples);
                }
            }
            Maker::Plots(relay) => {
                if let Some(time_ns) = time_ns {
                    let event = match service.turn_begins {
                        true => SensorEvent::TurnBegins(time_ns),
                        false => SensorEvent::Passed(time_ns),
                    };
                    relay.pass(&event, ingested_ns, samples);
                }
            }
            Maker::Locator(_) => {}
        }
        self.follow();
    }

    /// The clock has come to `steady_ns`, the UTC of the times given to [`Self::received`], whether or not data have
    /// come: a tracker's pictures do not wait for a silent sensor (WA-11), nor a transmission for a silent receiver. A
    /// tracker waits until the offset of the source's clock is known.
    pub fn elapsed(&mut self, steady_ns: i64, mono_ns: i64, samples: &mut Samples) {
        if let Maker::Locator(locator) = &mut self.maker {
            locator.elapsed(steady_ns, mono_ns, samples);
        }
        let Maker::Tracker(tracker) = &mut self.maker else {
            return self.follow();
        };
        if let Some((offset_s, _)) = self.converter.clock().offset() {
            tracker.elapsed(steady_ns.saturating_add((NS_PER_S * offset_s) as i64), samples);
        }
        self.follow();
    }

    /// The clock has come to `mono_ns`, and no received data wait: see [`DetectionTracker::silent`].
    pub fn silent(&mut self, mono_ns: i64, silent_after_ns: Option<i64>, samples: &mut Samples) {
        if let Maker::Tracker(tracker) = &mut self.maker {
            tracker.silent(mono_ns, silent_after_ns, samples);
        }
        self.follow();
    }

    /// The clock has come to `mono_ns`, and no received data wait: see [`DetectionTracker::clock`].
    pub fn clock(&mut self, mono_ns: i64, samples: &mut Samples) {
        if let Maker::Tracker(tracker) = &mut self.maker {
            tracker.clock(mono_ns, samples);
        }
        self.follow();
    }

    /// Takes a report of a wide-area sensor that supports the tracker.
    pub fn wide_area(&mut self, report: WideAreaReport) {
        if let Maker::Tracker(tracker) = &mut self.maker {
            tracker.wide_area(report);
        }
    }

    /// Takes a bearing of a direction finder that supports the tracker.
    pub fn emission(&mut self, bearing: &SensorBearing) {
        if let Maker::Tracker(tracker) = &mut self.maker {
            tracker.emission(bearing);
        }
    }

    /// Processes all waiting data at the end of the source's data.
    pub fn end(&mut self, samples: &mut Samples) {
        match &mut self.maker {
            Maker::None | Maker::Plots(_) | Maker::Locator(_) => {}
            Maker::Tracker(tracker) => tracker.end(samples),
        }
        self.follow();
    }

    /// Size in words of the memory for the tracks made here; `None` if none are made.
    pub fn kept_words(&self) -> Option<usize> {
        match &self.maker {
            Maker::None | Maker::Plots(_) => None,
            Maker::Tracker(tracker) => Some(tracker.kept_words()),
            Maker::Locator(locator) => Some(locator.kept_words()),
        }
    }

    /// Resumes from another pipeline's tracks in `memory`; of tracks older than `since_ns` (UTC, nanoseconds) only
    /// the numbers stay reserved. Must be called before all other methods.
    ///
    /// # Errors
    /// If the memory is not whole, or not of this source.
    pub fn resume(&mut self, memory: &[AtomicU64], owner: &str, since_ns: i64) -> Result<(), MemoryRefusal> {
        match &mut self.maker {
            Maker::None | Maker::Plots(_) => Ok(()),
            Maker::Tracker(tracker) => tracker.resume(memory, owner, since_ns),
            Maker::Locator(locator) => locator.resume(memory, owner, since_ns),
        }
    }

    /// Saves the tracks made here in `memory` from now on; the memory is blank and has [this
    /// size](Self::kept_words).
    pub fn keep_in(&mut self, memory: Box<dyn Memory>, owner: &str) {
        match &mut self.maker {
            Maker::None | Maker::Plots(_) => {}
            Maker::Tracker(tracker) => tracker.keep_in(memory, owner),
            Maker::Locator(locator) => locator.keep_in(memory, owner),
        }
    }

    /// Saves the tracks made here, if due at `now_ns` (UTC, nanoseconds): before publication, so that every published
    /// number is saved.
    pub fn keep(&mut self, now_ns: i64) {
        match &mut self.maker {
            Maker::None | Maker::Plots(_) => {}
            Maker::Tracker(tracker) => tracker.keep(now_ns),
            Maker::Locator(locator) => locator.keep(now_ns),
        }
    }

    /// Progress of the source's data time, UTC, nanoseconds; `i64::MIN` before the first data.
    pub fn progress_ns(&self) -> i64 {
        self.progress_ns
    }

    /// Offset of the source's clock against times of receipt and the standard deviation from report to report, seconds;
    /// `None` while unknown.
    pub fn clock_offset(&self) -> Option<(f64, f64)> {
        match &self.maker {
            Maker::None | Maker::Tracker(_) => self.converter.clock().offset(),
            Maker::Plots(relay) => relay.clock().offset().or_else(|| self.converter.clock().offset()),
            Maker::Locator(locator) => locator.clock().offset(),
        }
    }

    /// Turn time estimated so far from the data of a sensor with tracks made here.
    pub fn turn(&self) -> Option<TurnEstimate> {
        match &self.maker {
            Maker::Tracker(tracker) => tracker.turn(),
            Maker::None | Maker::Plots(_) | Maker::Locator(_) => None,
        }
    }

    /// All counters.
    pub fn counters(&self) -> Counters {
        let mut counters = *self.converter.counters();
        match &self.maker {
            Maker::None => {}
            Maker::Plots(relay) => relay.count(&mut counters),
            Maker::Tracker(tracker) => tracker.count(&mut counters),
            Maker::Locator(locator) => locator.count(&mut counters),
        }
        counters
    }

    fn follow(&mut self) {
        let progress_ns = match &self.maker {
            Maker::None => return,
            Maker::Plots(relay) => relay.progress_ns(),
            Maker::Tracker(tracker) => tracker.progress_ns(),
            Maker::Locator(locator) => locator.progress_ns(),
        };
        self.progress_ns = self.progress_ns.max(progress_ns);
    }
}

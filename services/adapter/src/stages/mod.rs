//! The stage between reading and publishing: what was observed becomes sensor tracks (PL-3).
//!
//! Whatever reads data, from a socket, a connection or a recording, hands observations to the [`Stage`] of their source; what
//! comes out is the same for all, and is published. A sensor that delivers tracks has them checked and passed on. One that
//! delivers less has its tracks made here: of detections by [`tracking`], of bearings by [`locating`]. A further way to make tracks is a further kind of
//! stage: a file here, a variant of [`Kind`], a line in each of its methods.
//!
//! What comes as records begins with the same checks, those of [`Converter`], whatever becomes of it; and none of them reads a clock: what comes out depends
//! on what was read and in which order, never on when.

mod locating;
mod tracking;

use ::tracking::wide_area::arrivals::Arrivals;
use configuration::Source;
use messages::{Counters, Cue, PlatformState, SensorBearing, SensorDetection, SensorTrack};
use observations::{Bearing, Observation, Service, WideAreaReport};
use reception::Converter;

use self::locating::Locating;
use self::tracking::Tracking;

/// What a stage has made.
#[derive(Debug, Default)]
pub(crate) struct Made {
    /// Sensor tracks, in the order in which they are to be published.
    pub(crate) tracks: Vec<SensorTrack>,
    /// Detections of which tracks were made, to be published before these.
    pub(crate) detections: Vec<SensorDetection>,
    /// Bearings of which tracks were made, to be published before these.
    pub(crate) bearings: Vec<SensorBearing>,
    /// Where their platform was.
    pub(crate) platforms: Vec<PlatformState>,
    /// Where the sensor should look next, to be published after the tracks.
    pub(crate) cues: Vec<Cue>,
}

/// One source's way from observations to sensor tracks.
#[derive(Debug)]
pub(crate) struct Stage {
    converter: Converter,
    kind: Kind,
    progress_ns: i64,
}

#[derive(Debug)]
enum Kind {
    /// The sensor's own tracks.
    Through,
    /// Tracks made of its detections.
    Tracking(Box<Tracking>),
    /// Tracks made of its bearings.
    Locating(Box<Locating>),
}

impl Stage {
    /// The stage of `source`, whose first report is of the day that begins at `first_day_ns` (UTC, nanoseconds). A tracker begins with
    /// the `counts` of wide-area sensors; more may come.
    ///
    /// # Errors
    /// If the configuration asks for what cannot be made.
    pub(crate) fn new(source: &Source, first_day_ns: i64, counts: Arrivals) -> anyhow::Result<Self> {
        let kind = match (&source.tracker, &source.locator) {
            (Some(tracker), _) => Kind::Tracking(Box::new(Tracking::new(source, tracker, first_day_ns, counts)?)),
            (None, Some(locator)) => Kind::Locating(Box::new(Locating::new(source, locator)?)),
            (None, None) => Kind::Through,
        };
        Ok(Self {
            converter: Converter::new(source.model, first_day_ns),
            kind,
            progress_ns: i64::MIN,
        })
    }

    /// What follows was received at `received_ns` (UTC, nanoseconds).
    pub(crate) fn received(&mut self, received_ns: i64) {
        self.converter.received(received_ns);
        if let Kind::Locating(locating) = &mut self.kind {
            locating.received(received_ns);
        }
    }

    /// Takes a target report that came in at `ingested_ns` (monotonic, nanoseconds).
    pub(crate) fn take(&mut self, observation: &Observation, ingested_ns: i64, made: &mut Made) {
        match &mut self.kind {
            Kind::Through => {
                if let Some(track) = self.converter.convert(observation, ingested_ns) {
                    self.progress_ns = self.progress_ns.max(track.time_of_measurement_ns);
                    made.tracks.push(track);
                }
            }
            Kind::Tracking(tracking) => {
                if let Some(detection) = self.converter.detect(observation) {
                    tracking.take(detection, ingested_ns, made);
                }
            }
            // Such a source has bearings only.
            Kind::Locating(_) => {}
        }
        self.follow();
    }

    /// Takes a bearing that came in at `ingested_ns`.
    pub(crate) fn bearing(&mut self, bearing: &Bearing, ingested_ns: i64, made: &mut Made) {
        if let Kind::Locating(locating) = &mut self.kind {
            locating.take(bearing, ingested_ns, made);
        }
        self.follow();
    }

    /// Takes a record that speaks of the sensor, which came in at `ingested_ns`.
    pub(crate) fn service(&mut self, service: &Service, ingested_ns: i64, made: &mut Made) {
        let time_ns = self.converter.service(service.time_of_day_ns);
        match &mut self.kind {
            Kind::Through => {
                self.progress_ns = self.progress_ns.max(self.converter.running_ns().unwrap_or(i64::MIN));
            }
            Kind::Tracking(tracking) => {
                if let Some(time_ns) = time_ns {
                    tracking.passed(time_ns, service.turn_begins, ingested_ns, made);
                }
            }
            Kind::Locating(_) => {}
        }
        self.follow();
    }

    /// Takes a report of a wide-area sensor that its tracker listens to.
    pub(crate) fn wide_area(&mut self, report: WideAreaReport) {
        if let Kind::Tracking(tracking) = &mut self.kind {
            tracking.wide_area(report);
        }
    }

    /// Takes a bearing that a direction finder has heard to which its tracker listens.
    pub(crate) fn emission(&mut self, bearing: &SensorBearing) {
        if let Kind::Tracking(tracking) = &mut self.kind {
            tracking.emission(bearing);
        }
    }

    /// The source's data have ended: what waits for more is worked off.
    pub(crate) fn end(&mut self, made: &mut Made) {
        match &mut self.kind {
            Kind::Through | Kind::Locating(_) => {}
            Kind::Tracking(tracking) => tracking.end(made),
        }
        self.follow();
    }

    /// How far the source has got, UTC, nanoseconds.
    pub(crate) fn progress_ns(&self) -> i64 {
        self.progress_ns
    }

    /// What has been counted, indexed by [`Counter`](messages::Counter).
    pub(crate) fn counters(&self) -> Counters {
        let mut counters = *self.converter.counters();
        match &self.kind {
            Kind::Through => {}
            Kind::Tracking(tracking) => tracking.count(&mut counters),
            Kind::Locating(locating) => locating.count(&mut counters),
        }
        counters
    }

    fn follow(&mut self) {
        let progress_ns = match &self.kind {
            Kind::Through => return,
            Kind::Tracking(tracking) => tracking.progress_ns(),
            Kind::Locating(locating) => locating.progress_ns(),
        };
        self.progress_ns = self.progress_ns.max(progress_ns);
    }
}

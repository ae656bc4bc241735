//! Path of a source's observations to the source's topics.

use bus::{BusError, Mark, Publisher, SharedMemory, Subscriber};
use deployment::Source;
use messages::{
    Counter, Counters, Cue, NS_PER_S, PlatformState, SensorArrival, SensorBearing, SensorDetection, SensorFix,
    SensorSpectrum, SensorTrack, StageTimes, TargetStatement, WideArea,
};
use observations::{
    EmitterMeasurement, Observation, Sampled, SensorEvent, ServiceMessage, SnapshotBlock, Statement, WideAreaReport,
};
use platform::State;
use reception::RefusedPlace;
use runtime::Process;
use runtime::clock::{SteadyClock, mono_ns};
use runtime::{HealthEntry, Now, Publication};
use sources::{Pipeline, Samples};
use tracking::wide_area::arrivals::Arrivals;

use crate::Processed;
use crate::continuity;
use crate::outlet::TopicOutlet;
use crate::receiver::ReceiptTime;
use crate::statements::StatementBook;

/// Maximum number of reports collected before publication: the reports of a batch of datagrams.
const GATHERED_MAX: usize = 4096;
/// Slices taken at a time from the topics of a tracker's wide-area sensors.
const SLICES_PER_LOOK: usize = 64;

/// Passes observations to the source's pipeline, and publishes the results in slices.
#[derive(Debug)]
pub(crate) struct SourceChannel {
    source: u16,
    has_tracks: bool,
    name: String,
    pipeline: Pipeline,
    /// Tracks kept for a successor.
    kept: Option<Publication>,
    /// Wide-area sensors of the source's tracker.
    counts: Vec<Subscriber<SharedMemory, WideArea>>,
    /// Direction finders with emissions that the tracker uses.
    emissions: Vec<Subscriber<SharedMemory, SensorBearing>>,
    /// States of the platform that carries the source's direction finder.
    platform: Option<Subscriber<SharedMemory, PlatformState>>,
    gathered: Samples,
    /// What targets have stated, and the samples of it to publish.
    statements: StatementBook,
    stated: Vec<TargetStatement>,
    outlets: Outlets,
    /// Clock for the estimate of the source's clock offset.
    steady: Option<SteadyClock>,
    /// Silence of the source that raises the alarm, nanoseconds.
    silent_after_ns: Option<i64>,
}

/// Topics of a source.
#[derive(Debug)]
struct Outlets {
    detections: TopicOutlet<SensorDetection>,
    platforms: TopicOutlet<PlatformState>,
    bearings: TopicOutlet<SensorBearing>,
    arrivals: TopicOutlet<SensorArrival>,
    fixes: TopicOutlet<SensorFix>,
    /// Spectra of an antenna array.
    spectra: Option<Publisher<SharedMemory, SensorSpectrum>>,
    tracks: TopicOutlet<SensorTrack>,
    cues: TopicOutlet<Cue>,
    statements: TopicOutlet<TargetStatement>,
}

impl Outlets {
    fn open(process: &Process, source: &Source) -> Result<Self, BusError> {
        let (name, uid) = (source.name.as_str(), source.uid);
        let (has_detections, has_bearings) = (source.has_detections(), source.has_bearings());
        let has_rows = source.has_emitter_rows();
        let spectra = || {
            let publisher = process
                .bus
                .publisher(&messages::sensor_spectrum(name), process.incarnation)?;
            Ok(publisher.of_sensor(uid))
        };
        Ok(Self {
            detections: TopicOutlet::open(process, &messages::sensor_detections(name), uid, has_detections)?,
            platforms: TopicOutlet::open(process, &messages::platform_states(name), uid, has_bearings)?,
            bearings: TopicOutlet::open(process, &messages::sensor_bearings(name), uid, has_bearings)?,
            arrivals: TopicOutlet::open(process, &messages::sensor_arrivals(name), uid, has_rows)?,
            fixes: TopicOutlet::open(process, &messages::sensor_fixes(name), uid, has_rows)?,
            spectra: source.has_array().then(spectra).transpose()?,
            tracks: TopicOutlet::open(process, &messages::sensor_tracks(name), uid, source.has_tracks())?,
            cues: TopicOutlet::open(process, &messages::cues(name), uid, source.has_cues())?,
            statements: TopicOutlet::open(process, &messages::target_statements(name), uid, source.has_statements)?,
        })
    }

    /// Publishes samples in the order for readers.
    fn send(&mut self, mark: Mark, samples: &mut Samples) -> Result<(), BusError> {
        self.detections.send(mark, &mut samples.detections)?;
        self.platforms.send(mark, &mut samples.platforms)?;
        self.bearings.send(mark, &mut samples.bearings)?;
        self.arrivals.send(mark, &mut samples.arrivals)?;
        self.fixes.send(mark, &mut samples.fixes)?;
        self.tracks.send(mark, &mut samples.tracks)?;
        self.send_spectra(mark, &mut samples.spectra)?;
        self.cues.send(mark, &mut samples.cues)
    }
}

impl Outlets {
    /// Whether spectra have a receiver.
    fn wants_spectra(&self) -> bool {
        self.spectra.as_ref().is_some_and(Publisher::has_subscribers)
    }

    fn send_spectra(&mut self, mark: Mark, spectra: &mut Vec<SensorSpectrum>) -> Result<(), BusError> {
        if let Some(publisher) = self.spectra.as_mut().filter(|_| !spectra.is_empty()) {
            publisher.send(mark, spectra.len(), |index, sequence| {
                let mut spectrum = spectra[index];
                spectrum.sequence = sequence;
                spectrum.stages.published_ns = mark.sent_ns;
                spectrum
            })?;
        }
        spectra.clear();
        Ok(())
    }
}

impl SourceChannel {
    pub(crate) fn open(process: &Process, processed: Processed<'_>) -> anyhow::Result<Self> {
        let (config, source, reading) = (&process.config, processed.source, processed.reading());
        let counts = source.links.wide_area_sensors.iter().map(|number| {
            let topic = messages::wide_area(&config.wide_area_sensors[usize::from(*number)].name);
            process.bus.subscriber(&topic, || process.incarnation)
        });
        let emissions = source.links.emissions.iter().map(|number| {
            let topic = messages::sensor_bearings(&config.sources[usize::from(*number)].name);
            process.bus.subscriber(&topic, || process.incarnation)
        });
        let first_day_ns = process.first_day_ns();
        let mut pipeline = Pipeline::new(reading.model, &reading.processing, first_day_ns, Arrivals::new())?;
        let on_board = source.on_board.filter(|_| source.has_bearings());
        let number = on_board.and_then(|on_board| on_board.platform).map(usize::from);
        let carrier = number.and_then(|number| Some((config.platforms.get(number)?, number, reading.mount?)));
        let platform = carrier.map(|(platform, number, mount)| {
            let assumed = processed.readings.platforms[number].assumed;
            pipeline.mount_on(config.frame, mount, assumed, platform.wait_ns);
            let topic = messages::platform_states(&platform.name);
            process.bus.subscriber(&topic, || process.incarnation)
        });
        let kept = continuity::go_on(process, source, &mut pipeline)?;
        Ok(Self {
            counts: counts.collect::<Result<_, _>>()?,
            emissions: emissions.collect::<Result<_, _>>()?,
            source: source.number,
            has_tracks: source.has_tracks(),
            name: source.name.clone(),
            platform: platform.transpose()?,
            pipeline,
            kept,
            gathered: Samples {
                tracks: Vec::with_capacity(GATHERED_MAX),
                ..Samples::default()
            },
            statements: StatementBook::default(),
            stated: Vec::new(),
            outlets: Outlets::open(process, source)?,
            steady: None,
            silent_after_ns: source.silent_after_ns,
        })
    }

    /// Prepares for data received at `received`. Called before each piece of data, so that a received wide-area
    /// report is used in the scan of its time and not in the next.
    pub(crate) fn received(&mut self, received: ReceiptTime) -> anyhow::Result<()> {
        self.pipeline.received(received.utc_ns, received.steady_ns);
        self.steady = Some(SteadyClock::of(Now {
            mono_ns: received.mono_ns,
            utc_ns: received.steady_ns,
        }));
        self.listen()
    }

    /// Returns the offset of the source's clock against the machine's UTC at `now` and the offset's standard deviation,
    /// seconds.
    fn clock_offset(&self, now: Now) -> Option<(f64, f64)> {
        let ahead_s = self.steady?.ahead_of(now) as f64 / NS_PER_S;
        self.pipeline
            .clock_offset()
            .map(|(offset_s, sigma_s)| (offset_s + ahead_s, sigma_s))
    }

    /// Takes a target report received at `ingested_ns` (monotonic, nanoseconds).
    pub(crate) fn take(&mut self, observation: &Observation, ingested_ns: i64) -> anyhow::Result<()> {
        self.pipeline.take(observation, ingested_ns, &mut self.gathered);
        self.publish_many()
    }

    /// Notes that the target `track_number` has transmitted.
    pub(crate) fn alive(&mut self, track_number: u32, received: ReceiptTime) {
        self.statements.alive(track_number, received.utc_ns);
    }

    /// Takes a statement of a target or station received at `received`.
    pub(crate) fn state(&mut self, stated: &Statement, received: ReceiptTime) {
        if let Some(whole) = self.statements.take(stated, received.utc_ns) {
            self.gather_statement(&whole, received.utc_ns, received.mono_ns);
        }
    }

    fn gather_statement(&mut self, whole: &Statement, utc_ns: i64, mono_ns: i64) {
        let stages = StageTimes {
            ingested_ns: mono_ns,
            ..StageTimes::default()
        };
        self.stated.push(whole.sample(self.source, utc_ns, stages));
    }

    /// Takes the latest refused position, if any was refused since the last call.
    pub(crate) fn take_refused_place(&mut self) -> Option<RefusedPlace> {
        self.pipeline.take_refused_place()
    }

    /// Takes a measurement of an emitter received at `ingested_ns`.
    pub(crate) fn emitter(&mut self, measured: &EmitterMeasurement, ingested_ns: i64) -> anyhow::Result<()> {
        self.pipeline.emitter(measured, ingested_ns, &mut self.gathered);
        self.publish_many()
    }

    /// Takes snapshots of the source's antenna array received at `ingested_ns`.
    pub(crate) fn snapshots(&mut self, block: &SnapshotBlock, ingested_ns: i64) -> anyhow::Result<()> {
        let with_spectrum = self.outlets.wants_spectra();
        self.pipeline
            .snapshots(block, ingested_ns, with_spectrum, &mut self.gathered);
        self.publish_many()
    }

    /// Takes a row of a sensor of a tracker process.
    pub(crate) fn row(&mut self, event: &SensorEvent, ingested_ns: i64) -> anyhow::Result<()> {
        self.pipeline.row(event, ingested_ns, &mut self.gathered);
        self.publish_many()
    }

    /// Takes an event of a sensor of the tracker process.
    pub(crate) fn event(&mut self, sensor: usize, event: &SensorEvent, ingested_ns: i64) -> anyhow::Result<()> {
        self.pipeline.event(sensor, event, ingested_ns, &mut self.gathered);
        self.publish_many()
    }

    /// Takes a record about the sensor.
    pub(crate) fn service(&mut self, service: &ServiceMessage, ingested_ns: i64) -> anyhow::Result<()> {
        self.pipeline.service(service, ingested_ns, &mut self.gathered);
        self.publish_many()
    }

    /// Lets a silent sensor's scans without detections go out by the clock. All data that had come at `mono_ns` must
    /// have been taken: the process may have stood still since then.
    pub(crate) fn silent(&mut self, mono_ns: i64) -> anyhow::Result<()> {
        self.pipeline.silent(mono_ns, self.silent_after_ns, &mut self.gathered);
        self.publish_many()
    }

    /// Lets the pictures that no longer wait for data go out by the clock. Must be called only when no received data
    /// wait: data that have arrived are not late, however long the process has stood still.
    pub(crate) fn elapsed(&mut self, now: Now) -> anyhow::Result<()> {
        let Some(steady) = self.steady else { return Ok(()) };
        let steady_ns = steady.utc_ns(now.mono_ns);
        self.pipeline.elapsed(steady_ns, now.mono_ns, &mut self.gathered);
        self.publish_many()
    }

    /// Lets overdue pictures of a tracker process go out by the clock. Must be called only when no received data wait.
    pub(crate) fn clock(&mut self, mono_ns: i64) -> anyhow::Result<()> {
        self.pipeline.clock(mono_ns, &mut self.gathered);
        self.publish_many()
    }

    /// Publishes the collected results.
    pub(crate) fn publish(&mut self) -> anyhow::Result<()> {
        self.listen()?;
        let now = Now::read();
        self.pipeline.keep(now.utc_ns);
        if let Some(kept) = &mut self.kept {
            kept.tend(now.mono_ns);
        }
        if let Some((offset_s, _)) = self.clock_offset(now) {
            self.outlets.tracks.set_clock_offset(offset_s);
        }
        let mark = Mark {
            progress_ns: self.pipeline.progress_ns(),
            sent_ns: mono_ns(),
            end: false,
        };
        self.gathered.has_picture = false;
        for (whole, heard_ns) in self.statements.due(now.utc_ns) {
            self.gather_statement(&whole, heard_ns, now.mono_ns);
        }
        self.outlets.statements.send(mark, &mut self.stated)?;
        Ok(self.outlets.send(mark, &mut self.gathered)?)
    }

    /// Returns the health of the source; `decoded` are the counts of the source's decoder.
    pub(crate) fn health(&self, decoded: &Counters) -> HealthEntry {
        let mut entry = HealthEntry {
            source: self.source,
            progress_ns: self.pipeline.progress_ns(),
            counters: self.pipeline.counters(),
            // Readers without the configuration, such as `koseki top`, identify sources by number only.
            note: self.name.clone(),
            ..HealthEntry::default()
        };
        entry.registration.set_clock_offset(self.clock_offset(Now::read()));
        entry.counters += decoded;
        entry.counters[Counter::TracksDropped] += self.statements.refused();
        // A tracker's sensor publishes detections.
        let published = match self.has_tracks {
            true => self.outlets.tracks.sent(),
            false => self.outlets.detections.sent(),
        };
        entry.set(Counter::Published, published);
        let lost = self.counts.iter().map(|sensor| sensor.counts());
        let lost = lost.map(|counts| counts.lost + counts.schema_mismatch).sum();
        entry.set(Counter::WideAreaLost, lost);
        let lost = self.emissions.iter().map(|finder| finder.counts());
        let lost: u64 = lost.map(|counts| counts.lost + counts.schema_mismatch).sum();
        entry.counters[Counter::EmissionsRejected] += lost;
        entry
    }

    /// Passes reports of wide-area sensors and direction finders, and states of the platform, to the pipeline.
    pub(crate) fn listen(&mut self) -> anyhow::Result<()> {
        let (pipeline, gathered) = (&mut self.pipeline, &mut self.gathered);
        if let Some(platform) = &mut self.platform {
            platform.take(SLICES_PER_LOOK, |_, states| {
                for state in states {
                    pipeline.platform_state(&State::of_sample(state), gathered);
                }
            })?;
        }
        for sensor in &mut self.counts {
            sensor.take(SLICES_PER_LOOK, |_, samples| {
                let reports = samples.iter().filter_map(WideAreaReport::of_sample);
                reports.for_each(|report| pipeline.wide_area(report));
            })?;
        }
        for finder in &mut self.emissions {
            finder.take(SLICES_PER_LOOK, |_, bearings| {
                bearings.iter().for_each(|bearing| pipeline.emission(bearing));
            })?;
        }
        Ok(())
    }

    fn publish_many(&mut self) -> anyhow::Result<()> {
        let is_full = self.gathered.most() >= GATHERED_MAX;
        // A picture is published before the following scan.
        match is_full || self.gathered.has_picture {
            true => self.publish(),
            false => Ok(()),
        }
    }
}

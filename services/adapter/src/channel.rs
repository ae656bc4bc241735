//! One source's way from observations to its topics.

use bus::{BusError, Mark, Payload, Publisher, SharedMemory, Subscriber};
use configuration::{Process, Source};
use messages::{Counter, Counters, Cue, PlatformState, SensorBearing, SensorDetection, SensorTrack, Topic, WideArea};
use observations::{Bearing, Observation, Sampled, Service, WideAreaReport};
use runtime::HealthEntry;
use runtime::clock::mono_ns;
use sources::{Pipeline, Samples};
use tracking::wide_area::arrivals::Arrivals;

use crate::processing;

/// Reports that are gathered before they are published, at most: those of one batch of datagrams.
const GATHERED_MAX: usize = 4096;
/// Slices taken at a time of what a tracker listens to.
const SLICES_PER_LOOK: usize = 64;

/// Hands what is observed to the source's pipeline, gathers what comes out, and publishes it in slices, in the order in which it
/// came.
#[derive(Debug)]
pub(crate) struct Channel {
    source: u16,
    name: String,
    pipeline: Pipeline,
    publisher: Publisher<SharedMemory, SensorTrack>,
    /// For sources whose tracks are made of detections.
    detections: Option<Publisher<SharedMemory, SensorDetection>>,
    /// For sources whose tracks are made of bearings: these, and where their platform was.
    bearings: Option<Publisher<SharedMemory, SensorBearing>>,
    platforms: Option<Publisher<SharedMemory, PlatformState>>,
    /// For sources that are told where to look next.
    cues: Option<Publisher<SharedMemory, Cue>>,
    /// What the tracker listens to: wide-area sensors.
    counts: Vec<Subscriber<SharedMemory, WideArea>>,
    /// And direction finders, which hear emissions.
    emissions: Vec<Subscriber<SharedMemory, SensorBearing>>,
    gathered: Samples,
}

/// A publisher of what comes from the sensor of `source`.
fn publisher<T: Payload>(
    process: &Process,
    source: &Source,
    topic: &Topic<T>,
) -> Result<Publisher<SharedMemory, T>, BusError> {
    let publisher = process.bus.publisher(topic, process.incarnation)?;
    Ok(publisher.of_sensor(source.uid))
}

impl Channel {
    pub(crate) fn open(process: &Process, source: &Source) -> anyhow::Result<Self> {
        let topic = messages::sensor_tracks(&source.name);
        let detections = messages::sensor_detections(&source.name);
        let open = |_| publisher(process, source, &detections);
        let (bearings, platforms) = (
            messages::sensor_bearings(&source.name),
            messages::platform_states(&source.name),
        );
        let open_bearings = |_| publisher(process, source, &bearings);
        let open_platforms = |_| publisher(process, source, &platforms);
        let listens_to = source.tracker.iter().flat_map(|tracker| &tracker.wide_area_sensors);
        let counts = listens_to.map(|number| {
            let sensor = &process.config.wide_area_sensors[usize::from(*number)];
            let topic = messages::wide_area(&sensor.name);
            process.bus.subscriber(&topic, || process.incarnation)
        });
        let finders = source.tracker.iter().flat_map(|tracker| &tracker.emissions);
        let emissions = finders.map(|number| {
            let finder = &process.config.sources[usize::from(*number)];
            let topic = messages::sensor_bearings(&finder.name);
            process.bus.subscriber(&topic, || process.incarnation)
        });
        let cues = messages::cues(&source.name);
        let cued = source.tracker.as_ref().filter(|tracker| tracker.cues);
        Ok(Self {
            counts: counts.collect::<Result<_, _>>()?,
            emissions: emissions.collect::<Result<_, _>>()?,
            cues: cued.map(|_| publisher(process, source, &cues)).transpose()?,
            source: source.number,
            name: source.name.clone(),
            pipeline: Pipeline::new(
                source.model,
                &processing(source),
                process.first_day_ns(),
                Arrivals::new(),
            )?,
            publisher: publisher(process, source, &topic)?,
            detections: source.tracker.as_ref().map(open).transpose()?,
            bearings: source.locator.as_ref().map(open_bearings).transpose()?,
            platforms: source.locator.as_ref().map(open_platforms).transpose()?,
            gathered: Samples {
                tracks: Vec::with_capacity(GATHERED_MAX),
                ..Samples::default()
            },
        })
    }

    /// What follows was received at `received_ns` (UTC, nanoseconds).
    pub(crate) fn received(&mut self, received_ns: i64) {
        self.pipeline.received(received_ns);
    }

    /// Takes a target report that came in at `ingested_ns` (monotonic, nanoseconds).
    pub(crate) fn take(&mut self, observation: &Observation, ingested_ns: i64) -> anyhow::Result<()> {
        self.listen()?;
        self.pipeline.take(observation, ingested_ns, &mut self.gathered);
        self.publish_many()
    }

    /// Takes a bearing that came in at `ingested_ns`.
    pub(crate) fn bearing(&mut self, bearing: &Bearing, ingested_ns: i64) -> anyhow::Result<()> {
        self.pipeline.bearing(bearing, ingested_ns, &mut self.gathered);
        self.publish_many()
    }

    /// Takes a record that speaks of the sensor.
    pub(crate) fn service(&mut self, service: &Service, ingested_ns: i64) -> anyhow::Result<()> {
        self.listen()?;
        self.pipeline.service(service, ingested_ns, &mut self.gathered);
        self.publish_many()
    }

    /// Hands the pipeline what wide-area sensors and direction finders have said: before each piece of data, so that nothing that has come waits for the
    /// scan after the one that it is for.
    fn listen(&mut self) -> anyhow::Result<()> {
        let pipeline = &mut self.pipeline;
        for sensor in &mut self.counts {
            sensor.take(SLICES_PER_LOOK, |_, samples| {
                for report in samples.iter().filter_map(WideAreaReport::of_sample) {
                    pipeline.wide_area(report);
                }
            })?;
        }
        for finder in &mut self.emissions {
            finder.take(SLICES_PER_LOOK, |_, bearings| {
                bearings.iter().for_each(|bearing| pipeline.emission(bearing))
            })?;
        }
        Ok(())
    }

    /// Publishes what has been gathered.
    pub(crate) fn publish(&mut self) -> anyhow::Result<()> {
        self.listen()?;
        let mark = Mark {
            progress_ns: self.pipeline.progress_ns(),
            sent_ns: mono_ns(),
            end: false,
        };
        let Samples {
            tracks,
            detections,
            bearings,
            platforms,
            cues,
        } = &self.gathered;
        if let Some(publisher) = self.detections.as_mut().filter(|_| !detections.is_empty()) {
            publisher.send(mark, detections.len(), |index, sequence| {
                let mut detection = detections[index];
                detection.sequence = sequence;
                detection.stages.published_ns = mark.sent_ns;
                detection
            })?;
        }
        if let Some(publisher) = self.platforms.as_mut().filter(|_| !platforms.is_empty()) {
            publisher.send(mark, platforms.len(), |index, sequence| {
                let mut platform = platforms[index];
                platform.sequence = sequence;
                platform.stages.published_ns = mark.sent_ns;
                platform
            })?;
        }
        if let Some(publisher) = self.bearings.as_mut().filter(|_| !bearings.is_empty()) {
            publisher.send(mark, bearings.len(), |index, sequence| {
                let mut bearing = bearings[index];
                bearing.sequence = sequence;
                bearing.stages.published_ns = mark.sent_ns;
                bearing
            })?;
        }
        if !tracks.is_empty() {
            self.publisher.send(mark, tracks.len(), |index, sequence| {
                let mut report = tracks[index];
                report.sequence = sequence;
                report.stages.published_ns = mark.sent_ns;
                report
            })?;
        }
        if let Some(publisher) = self.cues.as_mut().filter(|_| !cues.is_empty()) {
            publisher.send(mark, cues.len(), |index, sequence| {
                let mut cue = cues[index];
                cue.sequence = sequence;
                cue.stages.published_ns = mark.sent_ns;
                cue
            })?;
        }
        self.gathered.cues.clear();
        self.gathered.tracks.clear();
        self.gathered.detections.clear();
        self.gathered.bearings.clear();
        self.gathered.platforms.clear();
        Ok(())
    }

    /// How the source is; `decoded` is what its decoder has counted, indexed by [`Counter`].
    pub(crate) fn health(&self, decoded: &Counters) -> HealthEntry {
        let mut entry = HealthEntry {
            source: self.source,
            progress_ns: self.pipeline.progress_ns(),
            counters: self.pipeline.counters(),
            // Readers without the configuration, such as `koseki top`, know sources by their numbers only.
            note: self.name.clone(),
            ..HealthEntry::default()
        };
        entry.counters += decoded;
        entry.set(Counter::Published, self.publisher.counts().samples);
        let lost = self.counts.iter().map(|sensor| sensor.counts());
        let lost = lost.map(|counts| counts.lost + counts.schema_mismatch).sum();
        entry.set(Counter::WideAreaLost, lost);
        let lost = self.emissions.iter().map(|finder| finder.counts());
        let lost: u64 = lost.map(|counts| counts.lost + counts.schema_mismatch).sum();
        entry.counters[Counter::EmissionsRejected] += lost;
        entry
    }

    fn publish_many(&mut self) -> anyhow::Result<()> {
        match self.gathered.tracks.len().max(self.gathered.bearings.len()) < GATHERED_MAX {
            true => Ok(()),
            false => self.publish(),
        }
    }
}

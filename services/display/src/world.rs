//! Knowledge that the display has of a deployment. Pure: samples and times go in, pictures and texts are made of it.
//!
//! Which time the picture has is in [`crate::clock`].

use std::collections::{BTreeMap, VecDeque};

use alarms::Present;
use frames::{Geodetic, SystemFrame};
use messages::picture::{
    PictureArea, PictureBearing, PictureDetection, PictureIdentity, PictureSensorTrack, PictureTrack,
};
use messages::{
    Alarm, BatchHeader, Counter, Cue, Decision, FrameOrigin, Health, LifeState, ProcessKind, SensorBearing,
    SensorDetection, SensorTrack, SystemTrack, TrackState, WideArea,
};
use runtime::Now;
use rustc_hash::FxHashMap;
use telemetry::{DataOffset, HealthBook, Journey, JourneyEnd, Stages};

use crate::clock::PictureClock;
use crate::history::History;
use crate::records::{self, Place};
use crate::reports::Reports;
use crate::wire::{LAYER_AGE_S, Past};

/// Most system tracks, sensor tracks, and identities of the past.
const TRACKS_MAX: usize = 50_000;
/// Detections, bearings or areas that are kept.
const RECENT_MAX: usize = 8_192;
/// Decisions that are kept.
const DECISIONS_MAX: usize = 8_192;
/// Time between two clean-ups, nanoseconds.
const CLEAN_UP_NS: i64 = 1_000_000_000;
const NS_PER_S: i64 = 1_000_000_000;

/// A source, as the configuration has it.
#[derive(Clone, Debug)]
pub(crate) struct SourceFact {
    pub(crate) number: u16,
    pub(crate) name: String,
    /// How it observes, a word.
    pub(crate) kind: &'static str,
    pub(crate) adapter: String,
    /// Where its sensor stands, metres east and north.
    pub(crate) site_m: Option<[f64; 2]>,
}

/// Latest state of a system track.
#[derive(Clone, Debug)]
pub(crate) struct Live {
    /// Rises with each change in the world.
    pub(crate) stamp: u64,
    pub(crate) record: PictureTrack,
    pub(crate) measured_ns: i64,
    pub(crate) track: SystemTrack,
}

/// Something that was heard: when it was true (UTC, nanoseconds), and when it came, as a stamp.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Heard<T> {
    pub(crate) stamp: u64,
    pub(crate) time_ns: i64,
    pub(crate) record: T,
}

/// Recording that is shown, to all pages the same moment of it.
#[derive(Clone, Debug)]
pub(crate) struct Recording {
    pub(crate) name: String,
    /// From when to when it reaches, UTC, nanoseconds.
    pub(crate) span_ns: [i64; 2],
    /// Moment that is shown, UTC, nanoseconds.
    pub(crate) at_ns: i64,
    /// What the clocks said at that moment.
    pub(crate) now: Now,
    /// Moment from which it is played, how fast, and since when, monotonic, nanoseconds.
    pub(crate) wanted: Past,
    pub(crate) since_ns: i64,
}

impl Recording {
    /// Moment to be shown, UTC, nanoseconds.
    pub(crate) fn wanted_ns(&self, mono_ns: i64) -> i64 {
        let [from_ns, to_ns] = self.span_ns;
        frames::time::ns(self.wanted.at_s(mono_ns - self.since_ns)).clamp(from_ns, to_ns)
    }
}

/// See the module's documentation.
#[derive(Debug)]
pub(crate) struct World {
    pub(crate) instance: String,
    /// Recording that is shown; `None`: a deployment that runs.
    pub(crate) recording: Option<Recording>,
    /// Rises when all that was known is forgotten.
    pub(crate) generation: u64,
    pub(crate) sources: Vec<SourceFact>,
    pub(crate) origin: Option<FrameOrigin>,
    pub(crate) frame: Option<SystemFrame>,
    pub(crate) stamp: u64,
    pub(crate) tracks: BTreeMap<u32, Live>,
    pub(crate) identities: FxHashMap<u32, Heard<PictureIdentity>>,
    pub(crate) sensor_tracks: BTreeMap<(u16, u32), Heard<PictureSensorTrack>>,
    pub(crate) detections: VecDeque<Heard<PictureDetection>>,
    pub(crate) bearings: VecDeque<Heard<PictureBearing>>,
    pub(crate) areas: VecDeque<Heard<PictureArea>>,
    pub(crate) decisions: VecDeque<Decision>,
    pub(crate) history: History,
    pub(crate) reports: Reports,
    pub(crate) history_s: i64,
    history_octets: usize,
    pub(crate) book: HealthBook,
    pub(crate) stages: Stages,
    pub(crate) alarms: Present,
    pub(crate) rates: Rates,
    /// Start of the fusion process that the tracks are from.
    fusion: u64,
    /// When fusion last said how it is, monotonic, nanoseconds.
    fusion_said_ns: i64,
    clock: PictureClock,
    /// Offset of the data from the machine's clock.
    data_offset: DataOffset,
    clean_up_ns: i64,
}

/// Rates at which fusion takes the sources' reports.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rates {
    /// When fusion said how many it had taken (monotonic, nanoseconds), how many, and the rate since the time before.
    latest: BTreeMap<u16, (i64, u64, f64)>,
}

impl Rates {
    /// Reports a second of a source.
    pub(crate) fn of(&self, source: u16) -> f64 {
        self.latest.get(&source).map_or(0.0, |(.., rate_hz)| *rate_hz)
    }

    fn look(&mut self, source: u16, said_ns: i64, taken: u64) {
        let (before_ns, before, _) = self.latest.get(&source).copied().unwrap_or((said_ns, taken, 0.0));
        let passed_ns = said_ns - before_ns;
        let grown = taken.saturating_sub(before) as f64;
        let rate_hz = if passed_ns > 0 {
            grown / frames::time::seconds(passed_ns)
        } else {
            0.0
        };
        self.latest.insert(source, (said_ns, taken, rate_hz));
    }
}

impl World {
    /// Nothing is known yet. `history_s` is how far back the past is kept, in at most `history_octets`.
    pub(crate) fn new(instance: &str, sources: Vec<SourceFact>, history_s: i64, history_octets: usize) -> Self {
        let journey = Journey {
            end: JourneyEnd::Published,
            ..Journey::default()
        };
        Self {
            instance: instance.to_owned(),
            recording: None,
            generation: 0,
            origin: None,
            frame: None,
            stamp: 0,
            tracks: BTreeMap::new(),
            identities: FxHashMap::default(),
            sensor_tracks: BTreeMap::new(),
            detections: VecDeque::new(),
            bearings: VecDeque::new(),
            areas: VecDeque::new(),
            decisions: VecDeque::new(),
            // A quarter of the memory is for the sensor tracks.
            history: History::new(history_s * NS_PER_S, history_octets / 4 * 3),
            reports: Reports::new(history_s * NS_PER_S, LAYER_AGE_S * NS_PER_S, history_octets / 4),
            history_s,
            history_octets,
            book: HealthBook::new(sources.len()),
            stages: Stages::new(journey),
            alarms: Present::default(),
            rates: Rates::default(),
            fusion: 0,
            fusion_said_ns: i64::MIN,
            clock: PictureClock::of(false),
            data_offset: DataOffset::default(),
            clean_up_ns: i64::MIN,
            sources,
        }
    }

    /// From now on, the picture has the time of this clock.
    pub(crate) fn set_clock(&mut self, clock: PictureClock) {
        self.clock = clock;
    }

    /// Offset of the data from the clock of the picture, nanoseconds, positive: they are ahead. `None` if that is the
    /// data's own, or no state came lately.
    pub(crate) fn data_offset_ns(&self, now: Now) -> Option<i64> {
        let is_machine = self.recording.is_none() && matches!(self.clock, PictureClock::Machine { .. });
        is_machine.then(|| self.data_offset.ns(now.mono_ns))?
    }

    /// Time of the picture, UTC, nanoseconds.
    pub(crate) fn time_ns(&self, now: Now) -> i64 {
        let running_ns = || self.clock.at(now).unwrap_or(now.utc_ns);
        self.recording
            .as_ref()
            .map_or_else(running_ns, |recording| recording.at_ns)
    }

    /// Time for what is known: of a recording, that at which it was made.
    pub(crate) fn now(&self, now: Now) -> Now {
        self.recording.as_ref().map_or(now, |recording| recording.now)
    }

    /// The recording is at another moment; then, the clocks said `now`.
    pub(crate) fn pass_to(&mut self, at_ns: i64, now: Now) {
        if let Some(recording) = &mut self.recording {
            (recording.at_ns, recording.now) = (at_ns, now);
        }
    }

    /// Forgets everything but what the configuration says.
    pub(crate) fn rewind(&mut self) {
        let sources = std::mem::take(&mut self.sources);
        let empty = Self::new(&self.instance, sources, self.history_s, self.history_octets);
        *self = Self {
            recording: self.recording.take(),
            generation: self.generation + 1,
            origin: self.origin,
            frame: self.frame.take(),
            stamp: self.stamp,
            ..empty
        };
    }

    /// From when to when the past reaches, UTC, nanoseconds; `None` while there is nothing.
    pub(crate) fn span_ns(&self) -> Option<[i64; 2]> {
        let known = || self.history.span_ns();
        self.recording
            .as_ref()
            .map_or_else(known, |recording| Some(recording.span_ns))
    }

    /// Whether fusion has said nothing for longer than it ever should.
    pub(crate) fn is_fusion_silent(&self, now: Now) -> bool {
        now.mono_ns.saturating_sub(self.fusion_said_ns) > 2 * NS_PER_S
    }

    /// A slice of system tracks has come.
    pub(crate) fn receive(&mut self, header: &BatchHeader, tracks: &[SystemTrack], now: Now) {
        // Not a later one always: a fusion that stood by may have started before the one that it follows.
        if header.incarnation != self.fusion {
            // Whoever published the tracks so far is gone; its successor publishes again those that go on.
            if !self.tracks.is_empty() {
                self.history.end_all(self.time_ns(now));
                self.tracks.clear();
            }
            self.fusion = header.incarnation;
            self.clock.restart();
        }
        // Whoever publishes is not silent: health messages are rare in a recording that was made in a hurry.
        self.fusion_said_ns = now.mono_ns;
        for track in tracks {
            self.stages.record(track, now.mono_ns, now.utc_ns);
            self.clock.hear(track.reference_time_ns, now);
            self.data_offset.take(track.reference_time_ns, now.mono_ns, now.utc_ns);
            self.keep(track, self.time_ns(now));
        }
    }

    /// Keeps a state that came when the picture had the time `at_ns`.
    pub(crate) fn keep(&mut self, track: &SystemTrack, at_ns: i64) {
        self.stamp += 1;
        let (number, measured_ns) = (track.track_number, records::measured_ns(track));
        let before = self.tracks.get(&number).map_or(0, |live| live.record.flags);
        let record = records::track(track, self.frame.as_ref(), before);
        self.history.keep(at_ns, record, measured_ns, track);
        let identity = records::identity(track);
        let is_room = self.identities.len() < TRACKS_MAX;
        if let Some(known) = self.identities.get_mut(&number) {
            if known.record != identity {
                (known.record, known.stamp) = (identity, self.stamp);
            }
            known.time_ns = at_ns;
        } else if is_room {
            let heard = Heard {
                stamp: self.stamp,
                time_ns: at_ns,
                record: identity,
            };
            self.identities.insert(number, heard);
        }
        for part in track.contributions() {
            if let Some(heard) = self.sensor_tracks.get_mut(&(part.source, part.track_number))
                && heard.record.system_track != number
            {
                (heard.record.system_track, heard.stamp) = (number, self.stamp);
            }
        }
        if track.state == TrackState::Terminated as u8 {
            self.tracks.remove(&number);
        } else if self.tracks.len() < TRACKS_MAX || self.tracks.contains_key(&number) {
            let live = Live {
                stamp: self.stamp,
                record,
                measured_ns,
                track: *track,
            };
            self.tracks.insert(number, live);
        }
    }

    /// Reports of a source have come.
    pub(crate) fn hear_sensor_tracks(&mut self, reports: &[SensorTrack], now: Now) {
        let at_ns = self.time_ns(now);
        for report in reports {
            self.stamp += 1;
            let key = (report.source, report.track_number);
            let mut heard = Heard {
                stamp: self.stamp,
                time_ns: report.time_of_measurement_ns,
                record: records::sensor_track(report, self.frame.as_ref()),
            };
            let is_room = self.sensor_tracks.len() < TRACKS_MAX;
            if let Some(known) = self.sensor_tracks.get_mut(&key) {
                if known.time_ns <= heard.time_ns {
                    heard.record.system_track = known.record.system_track;
                    *known = heard;
                }
            } else if is_room {
                self.sensor_tracks.insert(key, heard);
            }
            // A recording is its own past.
            if self.recording.is_none() {
                self.reports.keep(at_ns, heard.time_ns, heard.record);
            }
        }
    }

    /// Detections of a source have come.
    pub(crate) fn hear_detections(&mut self, detections: &[SensorDetection]) {
        for detection in detections {
            let time_ns = detection.time_of_measurement_ns;
            match records::detection(detection, self.frame.as_ref()) {
                Some(Place::Spot(record)) => add(&mut self.stamp, &mut self.detections, time_ns, record),
                Some(Place::Ray(record)) => add(&mut self.stamp, &mut self.bearings, time_ns, record),
                None => {}
            }
        }
    }

    /// Bearings of a direction finder have come.
    pub(crate) fn hear_bearings(&mut self, bearings: &[SensorBearing]) {
        for bearing in bearings {
            let record = records::bearing(bearing);
            add(
                &mut self.stamp,
                &mut self.bearings,
                bearing.time_of_measurement_ns,
                record,
            );
        }
    }

    /// Counts of a wide-area sensor have come.
    pub(crate) fn hear_counts(&mut self, counts: &[WideArea]) {
        for count in counts {
            let record = records::count(count);
            add(&mut self.stamp, &mut self.areas, count.time_of_observation_ns, record);
        }
    }

    /// Cues for a sensor have come.
    pub(crate) fn hear_cues(&mut self, cues: &[Cue]) {
        for cue in cues {
            add(&mut self.stamp, &mut self.areas, cue.time_ns, records::cue(cue));
        }
    }

    /// Decisions of fusion have come.
    pub(crate) fn hear_decisions(&mut self, decisions: &[Decision]) {
        for decision in decisions {
            if self.decisions.len() == DECISIONS_MAX {
                self.decisions.pop_front();
            }
            self.decisions.push_back(*decision);
        }
    }

    /// The monitor has said which alarms stand.
    pub(crate) fn hear_alarms(&mut self, header: &BatchHeader, slice: &[Alarm]) {
        self.alarms.hear(header, slice);
    }

    /// A process has said how it is.
    pub(crate) fn hear(&mut self, health: &Health, now: Now) {
        self.book.hear(health);
        let is_alive = health.life() == Some(LifeState::Running);
        if health.kind() == Some(ProcessKind::Fusion) && is_alive {
            self.fusion_said_ns = now.mono_ns;
        }
    }

    /// Somebody has said where the system frame lies; a place that is none is not believed.
    pub(crate) fn place(&mut self, origin: &FrameOrigin) {
        if self.origin == Some(*origin) {
            return;
        }
        let place = Geodetic::from_degrees(origin.latitude_deg, origin.longitude_deg, origin.height_m);
        if let Ok(place) = place {
            (self.origin, self.frame) = (Some(*origin), Some(SystemFrame::at(place)));
            // States that came before had no height.
            self.stamp += 1;
            for live in self.tracks.values_mut() {
                live.stamp = self.stamp;
                live.record = records::track(&live.track, self.frame.as_ref(), live.record.flags);
            }
        }
    }

    /// Forgets now and then what is no longer shown.
    pub(crate) fn clean_up(&mut self, now: Now) {
        if now.mono_ns < self.clean_up_ns {
            return;
        }
        self.clean_up_ns = now.mono_ns + CLEAN_UP_NS;
        self.stages.close_interval();
        for source in &self.sources {
            let fusion = ProcessKind::Fusion;
            if let Some(said) = self.book.said(fusion, fusion.word(), source.number) {
                self.rates
                    .look(source.number, said.said_ns(), said.counters()[Counter::Taken]);
            }
        }
        let oldest_ns = self.time_ns(now) - LAYER_AGE_S * NS_PER_S;
        self.sensor_tracks.retain(|_, heard| heard.time_ns >= oldest_ns);
        let past_ns = self.history.span_ns().map_or(i64::MIN, |[from_ns, _]| from_ns);
        self.identities.retain(|_, heard| heard.time_ns >= past_ns);
    }
}

/// Adds something that has come to what is kept of its kind.
fn add<T>(stamp: &mut u64, recent: &mut VecDeque<Heard<T>>, time_ns: i64, record: T) {
    *stamp += 1;
    if recent.len() == RECENT_MAX {
        recent.pop_front();
    }
    recent.push_back(Heard {
        stamp: *stamp,
        time_ns,
        record,
    });
}

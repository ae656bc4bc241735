//! State of a deployment as known to the display. Pure: samples and times go in; pictures and texts are made from
//! it.
//!
//! [`crate::clock`] describes the picture's time.

use std::collections::BTreeMap;
use std::sync::Arc;

use messages::picture::{LayerRecord, PictureIdentity, PictureSensorTrack, PictureTrack};
use messages::{Alarm, BatchHeader, Decision, FrameOrigin, SensorTrack, SystemTrack, TargetStatement, TrackState};
use observed::Deployment;
use runtime::Now;
use rustc_hash::FxHashMap;

use crate::alarm_book::AlarmBook;
use crate::clock::PictureClock;
use crate::coverage::Coverage;
use crate::decisions::Decisions;
use crate::history::History;
use crate::label_settings::LabelSettings;
use crate::passing::Passing;
use crate::recent::RecentReports;
use crate::records;
use crate::reports::Reports;
use crate::stations::Stations;
use crate::wire::{LAYER_AGE_S, Past};

/// Maximum number of system tracks, of sensor tracks, and of past identities.
const TRACKS_MAX: usize = 50_000;
/// Age of a target's latest transmission at which the target has left, nanoseconds: ships at anchor transmit every
/// three minutes.
const STATEMENT_AGE_NS: i64 = 300 * NS_PER_S;
/// Time between two clean-ups, nanoseconds.
const CLEAN_UP_NS: i64 = 1_000_000_000;
const NS_PER_S: i64 = 1_000_000_000;
/// Offset of the data from the machine's clock from which an instance replays recordings, nanoseconds.
const REPLAYED_OFFSET_NS: i64 = 3_600 * NS_PER_S;
/// Period of a source without configuration, nanoseconds.
const PERIOD_NS: i64 = NS_PER_S;

/// Configured source.
#[derive(Clone, Debug)]
pub(crate) struct SourceFact {
    pub(crate) source: deployment::SourceFacts,
    /// Kind of observation, as a word.
    pub(crate) kind: &'static str,
    /// Position of the sensor, metres east and north.
    pub(crate) site_m: Option<[f64; 2]>,
}

impl SourceFact {
    /// Facts on a source without configuration.
    fn unconfigured(number: u16, name: String) -> Self {
        Self {
            source: deployment::SourceFacts {
                number,
                name,
                adapter: String::new(),
                sensor_of: None,
                is_external: false,
                silent_after_ns: None,
                period_ns: PERIOD_NS,
                north_offset_rad: None,
            },
            kind: "other",
            site_m: None,
        }
    }
}

/// Latest state of a system track.
#[derive(Clone, Debug)]
pub(crate) struct LiveTrack {
    /// Increases with each change in the world.
    pub(crate) stamp: u64,
    pub(crate) record: PictureTrack,
    pub(crate) measured_ns: i64,
    pub(crate) track: SystemTrack,
}

/// Received record: its time of validity (UTC, nanoseconds), and its arrival as a stamp.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReceivedRecord<T> {
    pub(crate) stamp: u64,
    pub(crate) time_ns: i64,
    pub(crate) record: T,
}

/// Replayed recording.
#[derive(Clone, Debug)]
pub(crate) struct ReplayedRecording {
    pub(crate) name: String,
    /// Start and end, UTC, nanoseconds.
    pub(crate) span_ns: [i64; 2],
    /// Shown moment, UTC, nanoseconds.
    pub(crate) at_ns: i64,
    /// Clocks at the shown moment.
    pub(crate) now: Now,
    /// Starting moment and speed of the replay, and its start time, monotonic, nanoseconds.
    pub(crate) wanted: Past,
    pub(crate) since_ns: i64,
    /// Number of wishes for a moment, and the last of them that the world shows.
    pub(crate) edition: u64,
    pub(crate) reached: u64,
}

impl ReplayedRecording {
    /// Creates a recording that is played from its begin, at the clocks `now`.
    pub(crate) fn begin(name: String, span_ns: [i64; 2], now: Now) -> Self {
        Self {
            name,
            span_ns,
            at_ns: span_ns[0],
            now,
            wanted: Past {
                time_s: frames::time::seconds(span_ns[0]),
                speed: 1.0,
            },
            since_ns: now.mono_ns,
            edition: 1,
            reached: 0,
        }
    }

    /// Notes the wish for another moment at `mono_ns`.
    pub(crate) fn want(&mut self, past: Past, mono_ns: i64) {
        (self.wanted, self.since_ns) = (past, mono_ns);
        self.edition += 1;
    }

    /// Whether the world has come to the wanted moment.
    pub(crate) fn is_reached(&self) -> bool {
        self.reached == self.edition
    }

    /// Returns the moment to show, UTC, nanoseconds.
    pub(crate) fn wanted_ns(&self, mono_ns: i64) -> i64 {
        let [from_ns, to_ns] = self.span_ns;
        frames::time::ns(self.wanted.at_s(mono_ns - self.since_ns)).clamp(from_ns, to_ns)
    }
}

/// State of the deployment, see the module's documentation.
#[derive(Debug)]
pub(crate) struct World {
    pub(crate) instance: String,
    /// Shown recording; `None`: a running deployment.
    pub(crate) recording: Option<ReplayedRecording>,
    /// Increases whenever all state is cleared.
    pub(crate) generation: u64,
    pub(crate) sources: Vec<SourceFact>,
    /// Labels of the tracks.
    pub(crate) labels: LabelSettings,
    /// Whether the sources are learned, for lack of a configuration.
    learns_sources: bool,
    /// State derived from health, alarms, origin, orders and latencies.
    pub(crate) observed: Deployment,
    pub(crate) stamp: u64,
    pub(crate) tracks: BTreeMap<u32, LiveTrack>,
    pub(crate) identities: FxHashMap<u32, ReceivedRecord<PictureIdentity>>,
    pub(crate) sensor_tracks: BTreeMap<(u16, u32), ReceivedRecord<PictureSensorTrack>>,
    pub(crate) passing: Passing,
    /// What targets have stated beside their motion, by source and track number.
    pub(crate) statements: FxHashMap<(u16, u32), TargetStatement>,
    pub(crate) stations: Stations,
    pub(crate) alarm_book: AlarmBook,
    pub(crate) coverage: Coverage,
    /// Latest reports of each sensor track.
    pub(crate) recent: RecentReports,
    pub(crate) decisions: Decisions,
    /// Whether decisions are published, or recorded.
    pub(crate) has_decisions: bool,
    /// Magnetic declination at the origin, degrees, positive to the east.
    pub(crate) declination_deg: Option<f64>,
    /// Settings of fusion, where the configuration is known.
    pub(crate) engine: Option<Arc<fusion_settings::Settings>>,
    pub(crate) history: History,
    pub(crate) reports: Reports,
    pub(crate) history_s: i64,
    history_octets: usize,
    clock: PictureClock,
    clean_up_ns: i64,
}

impl World {
    /// Creates an empty world. `history_s` is the time span of the past, in at most `history_octets` bytes.
    pub(crate) fn new(instance: &str, sources: Vec<SourceFact>, history_s: i64, history_octets: usize) -> Self {
        let observed = Deployment::new(sources.iter().map(|fact| fact.source.clone()).collect());
        Self {
            instance: instance.to_owned(),
            recording: None,
            generation: 0,
            observed,
            labels: LabelSettings::default(),
            learns_sources: false,
            stamp: 0,
            tracks: BTreeMap::new(),
            identities: FxHashMap::default(),
            sensor_tracks: BTreeMap::new(),
            passing: Passing::default(),
            statements: FxHashMap::default(),
            stations: Stations::default(),
            alarm_book: AlarmBook::default(),
            coverage: Coverage::new(sources.iter().map(|fact| (fact.site_m, fact.source.period_ns))),
            recent: RecentReports::default(),
            decisions: Decisions::default(),
            has_decisions: false,
            declination_deg: None,
            engine: None,
            // A quarter of the memory is for the sensor tracks.
            history: History::new(history_s * NS_PER_S, history_octets / 4 * 3),
            reports: Reports::new(history_s * NS_PER_S, LAYER_AGE_S * NS_PER_S, history_octets / 4),
            history_s,
            history_octets,
            clock: PictureClock::of(false),
            clean_up_ns: i64::MIN,
            sources,
        }
    }

    /// Returns the configured facts of a source.
    pub(crate) fn source_fact(&self, number: u16) -> Option<&SourceFact> {
        self.sources.iter().find(|fact| fact.source.number == number)
    }

    /// Creates an empty world of an instance without its configuration: sources are learned from health messages.
    pub(crate) fn of_instance(instance: &str, history_s: i64, history_octets: usize) -> Self {
        Self {
            observed: Deployment::default(),
            learns_sources: true,
            ..Self::new(instance, Vec::new(), history_s, history_octets)
        }
    }

    /// Adds sources that are new in health messages, and takes data time for an instance that replays recordings.
    fn learn_sources(&mut self, now: Now) {
        for state in self.observed.sources() {
            let known = self.sources.iter_mut().find(|fact| fact.source.number == state.number);
            match known {
                Some(fact) => fact.source.name = state.name,
                None => self.sources.push(SourceFact::unconfigured(state.number, state.name)),
            }
        }
        self.coverage.make_room(
            self.sources
                .iter()
                .map(|fact| (fact.source.number, fact.source.period_ns)),
        );
        let offset_ns = self.observed.data_offset_ns(now.mono_ns).unwrap_or(0);
        if offset_ns.abs() > REPLAYED_OFFSET_NS && !matches!(self.clock, PictureClock::Data(_)) {
            self.clock = PictureClock::of(true);
        }
    }

    /// Sets the clock of the picture.
    pub(crate) fn set_clock(&mut self, clock: PictureClock) {
        self.clock = clock;
    }

    /// Whether the picture has the time of the data: the deployment replays recordings.
    pub(crate) fn is_replay(&self) -> bool {
        self.recording.is_none() && matches!(self.clock, PictureClock::Data(_))
    }

    /// Whether the picture's time is known: recorded data have none before the first state.
    pub(crate) fn is_dated(&self) -> bool {
        self.recording.is_some() || self.clock.is_set()
    }

    /// Returns the offset of the data from the picture's clock, and the part of it that the sources' rhythm does not
    /// explain, nanoseconds, positive: data ahead. `None` if the picture has data time, or without recent states.
    pub(crate) fn data_offsets_ns(&self, now: Now) -> Option<[i64; 2]> {
        let is_machine = self.recording.is_none() && matches!(self.clock, PictureClock::Machine { .. });
        let observed = Some(&self.observed).filter(|_| is_machine)?;
        Some([
            observed.data_offset_ns(now.mono_ns)?,
            observed.unexplained_offset_ns(now.mono_ns)?,
        ])
    }

    /// Returns the time of the picture, UTC, nanoseconds.
    pub(crate) fn time_ns(&self, now: Now) -> i64 {
        let running_ns = || self.clock.at(now).unwrap_or(now.utc_ns);
        self.recording
            .as_ref()
            .map_or_else(running_ns, |recording| recording.at_ns)
    }

    /// Returns the reference time for received data; for a recording, the time of its making.
    pub(crate) fn now(&self, now: Now) -> Now {
        self.recording.as_ref().map_or(now, |recording| recording.now)
    }

    /// Moves the recording to another moment; `now` holds the clocks of that moment.
    pub(crate) fn pass_to(&mut self, at_ns: i64, now: Now) {
        if let Some(recording) = &mut self.recording {
            (recording.at_ns, recording.now) = (at_ns, now);
        }
    }

    /// Returns a world with nothing but the configuration of this one.
    pub(crate) fn emptied(&self) -> Self {
        let empty = Self::new(
            &self.instance,
            self.sources.clone(),
            self.history_s,
            self.history_octets,
        );
        Self {
            recording: self.recording.clone(),
            generation: self.generation + 1,
            observed: self.observed.emptied(),
            labels: self.labels.clone(),
            stamp: self.stamp,
            has_decisions: self.has_decisions,
            declination_deg: self.declination_deg,
            engine: self.engine.clone(),
            ..empty
        }
    }

    /// Returns a world with the configuration of this one, at the begin of its recording and the clocks `now`.
    pub(crate) fn at_the_begin(&self, now: Now) -> Self {
        let begin = |known: &ReplayedRecording| ReplayedRecording::begin(known.name.clone(), known.span_ns, now);
        Self {
            recording: self.recording.as_ref().map(begin),
            ..self.emptied()
        }
    }

    /// Returns start and end of the past, UTC, nanoseconds; `None` while it is empty.
    pub(crate) fn span_ns(&self) -> Option<[i64; 2]> {
        let known = || self.history.span_ns();
        self.recording
            .as_ref()
            .map_or_else(known, |recording| Some(recording.span_ns))
    }

    /// Receives a slice of system tracks.
    pub(crate) fn receive(&mut self, header: &BatchHeader, tracks: &[SystemTrack], now: Now) {
        if self.observed.take_tracks(header, tracks, now.mono_ns, now.utc_ns) {
            // The publisher of these tracks was replaced; its successor publishes the continuing tracks again.
            if !self.tracks.is_empty() {
                self.history.end_all(self.time_ns(now));
                self.tracks.clear();
            }
            self.clock.restart();
        }
        for track in tracks {
            self.coverage.take(track);
            self.clock.hear(track.reference_time_ns, now);
            self.keep(track, self.time_ns(now));
        }
    }

    /// Stores a state that arrived at picture time `at_ns`.
    pub(crate) fn keep(&mut self, track: &SystemTrack, at_ns: i64) {
        self.stamp += 1;
        let (number, measured_ns) = (track.track_number, records::measured_ns(track));
        let before = self.tracks.get(&number).map_or(0, |live| live.record.flags);
        let record = records::track(track, self.observed.frame(), before);
        self.history.keep(at_ns, record, measured_ns, track);
        let identity = records::identity(track);
        let is_room = self.identities.len() < TRACKS_MAX;
        if let Some(known) = self.identities.get_mut(&number) {
            if known.record != identity {
                (known.record, known.stamp) = (identity, self.stamp);
            }
            known.time_ns = at_ns;
        } else if is_room {
            let heard = ReceivedRecord {
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
        if TrackState::is_off(track.state) {
            self.tracks.remove(&number);
        } else if self.tracks.len() < TRACKS_MAX || self.tracks.contains_key(&number) {
            let live = LiveTrack {
                stamp: self.stamp,
                record,
                measured_ns,
                track: *track,
            };
            self.tracks.insert(number, live);
        }
    }

    /// Receives the reports of a source.
    pub(crate) fn hear_sensor_tracks(&mut self, reports: &[SensorTrack], now: Now) {
        let at_ns = self.time_ns(now);
        for report in reports {
            self.stamp += 1;
            self.recent.keep(report);
            let key = (report.source, report.track_number);
            let mut heard = ReceivedRecord {
                stamp: self.stamp,
                time_ns: report.time_of_measurement_ns,
                record: records::sensor_track(report, self.observed.frame()),
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
            // A recording serves as its own past.
            if self.recording.is_none() {
                self.reports.keep(at_ns, heard.time_ns, heard.record);
            }
        }
    }

    /// Receives a record of a layer that passes, valid at `time_ns`.
    pub(crate) fn pass<T: LayerRecord>(&mut self, time_ns: i64, record: &T) {
        self.stamp += 1;
        self.passing.add(self.stamp, time_ns, record);
    }

    /// Receives what targets, and stations that are none, state beside motion.
    pub(crate) fn hear_statements(&mut self, stated: &[TargetStatement]) {
        for statement in stated {
            if statement.is_station() {
                self.stamp += 1;
                self.stations.take(statement, self.stamp);
                continue;
            }
            let key = (statement.source, statement.track_number);
            if self.statements.len() < TRACKS_MAX || self.statements.contains_key(&key) {
                self.statements.insert(key, *statement);
            }
        }
    }

    /// Receives the decisions of fusion.
    pub(crate) fn hear_decisions(&mut self, decisions: &[Decision]) {
        self.has_decisions |= !decisions.is_empty();
        decisions.iter().for_each(|decision| self.decisions.keep(decision));
    }

    /// Receives the alarms: all that stand, and those just cleared.
    pub(crate) fn hear_alarms(&mut self, header: &BatchHeader, alarms: &[Alarm]) {
        self.observed.take_alarms(header, alarms);
        self.alarm_book.take(alarms);
    }

    /// Receives the origin of the system frame; an invalid place is ignored.
    pub(crate) fn place(&mut self, origin: &FrameOrigin) {
        if self.observed.take_origin(origin) {
            // Earlier states had no height.
            self.stamp += 1;
            for live in self.tracks.values_mut() {
                live.stamp = self.stamp;
                live.record = records::track(&live.track, self.observed.frame(), live.record.flags);
            }
        }
    }

    /// Drops outdated records from time to time.
    pub(crate) fn clean_up(&mut self, now: Now) {
        if now.mono_ns < self.clean_up_ns {
            return;
        }
        self.clean_up_ns = now.mono_ns + CLEAN_UP_NS;
        self.observed.close_interval();
        if self.learns_sources {
            self.learn_sources(now);
        }
        let oldest_ns = self.time_ns(now) - LAYER_AGE_S * NS_PER_S;
        self.sensor_tracks.retain(|_, heard| heard.time_ns >= oldest_ns);
        self.recent.forget_before(oldest_ns);
        if self.is_dated() {
            let stated_ns = self.time_ns(now) - STATEMENT_AGE_NS;
            self.statements.retain(|_, stated| stated.time_ns >= stated_ns);
            self.stations.forget_silent(self.time_ns(now));
        }
        self.coverage.forget_before(oldest_ns);
        let past_ns = self.history.span_ns().map_or(i64::MIN, |[from_ns, _]| from_ns);
        self.identities.retain(|_, heard| heard.time_ns >= past_ns);
        let tracks = &self.tracks;
        self.decisions
            .forget_before(past_ns, |number| tracks.contains_key(&number));
    }
}

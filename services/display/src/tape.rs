//! Replay of a recording: its samples enter the world as in live operation.
//!
//! A first pass over the files notes the picture's time at each chunk. To jump to another moment, the tape empties
//! the world, inserts the preceding ten minutes of the recording without pause, and then inserts slices as time passes.
//! Memory use is therefore limited to the world and one chunk, for recordings of any length. Time never goes back
//! between the first and the last slice.

use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context as _;
use deployment::Deployment;
use messages::layout::Sample;
use messages::{BatchHeader, Health, Stream, SystemTrack};
use recording::{Chunks, Item, RecordingError};
use runtime::Now;

use crate::clock::PictureClock;
use crate::layers::{DisplayedSample, ForDisplayed, TopicOf, for_displayed};
use crate::world::World;

/// Recorded time that is inserted before a moment: as long as trails are, and no less than the longest period in which
/// every track is published once.
const BEFORE_NS: i64 = 600_000_000_000;
/// Maximum number of chunks inserted before a moment; each has about a megabyte.
const BEFORE_CHUNKS: usize = 256;

/// Kind of a displayed topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TopicKind {
    Stream(Stream),
    Health,
}

/// Damaged parts of files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Damage {
    pub(crate) parts: u64,
    pub(crate) bytes: u64,
}

/// Position of a chunk in a file.
#[derive(Clone, Copy, Debug)]
struct ChunkPosition {
    file: usize,
    place: u64,
    /// Time of the picture before the chunk's first slice, and the clock from there on.
    at_ns: i64,
    clock: PictureClock,
}

/// Recorded slice.
#[derive(Debug)]
struct RecordedSlice {
    kind: TopicKind,
    header: BatchHeader,
    /// Time at which the recorder took the slice.
    taken: Now,
    /// Time of the picture at the slice's arrival, UTC, nanoseconds; `None` before the first system track.
    at_ns: Option<i64>,
    /// Samples, contiguous.
    octets: Vec<u8>,
    /// Size of a sample, bytes.
    size: usize,
}

/// Replayed recording, see the module's documentation.
pub(crate) struct Tape {
    paths: Arc<[PathBuf]>,
    files: Vec<Chunks<BufReader<File>>>,
    topics: Arc<BTreeMap<String, TopicKind>>,
    marks: Arc<[ChunkPosition]>,
    span_ns: [i64; 2],
    /// Number of the next chunk to read, and the waiting slices of earlier chunks.
    next: usize,
    waiting: VecDeque<RecordedSlice>,
    /// Latest slice in the world: its recording time, and the time of the picture.
    latest: Option<(Now, i64)>,
    /// Damaged parts, as the first pass has found them.
    damage: Damage,
}

impl Tape {
    /// Opens the recording in `files`, in their order, made by the deployment of `config`.
    ///
    /// # Errors
    /// If a file cannot be read, or no file holds a system track.
    pub(crate) fn open(config: &Deployment, files: &[PathBuf]) -> anyhow::Result<Self> {
        Self::open_with(config, PictureClock::of(config.is_recorded()), files)
    }

    fn open_with(config: &Deployment, mut clock: PictureClock, files: &[PathBuf]) -> anyhow::Result<Self> {
        let read = files
            .iter()
            .map(|path| Chunks::new(opened(path)?).with_context(|| path.display().to_string()));
        let mut marks = Vec::new();
        let mut tape = Self {
            paths: files.into(),
            files: read.collect::<anyhow::Result<_>>()?,
            topics: Arc::new(topics(config)),
            marks: Arc::default(),
            span_ns: [i64::MAX, i64::MIN],
            next: 0,
            waiting: VecDeque::new(),
            latest: None,
            damage: Damage::default(),
        };
        for (file, path) in files.iter().enumerate() {
            while tape
                .note(file, &mut clock, &mut marks)
                .with_context(|| format!("reading {}", path.display()))?
            {}
        }
        let [from_ns, to_ns] = tape.span_ns;
        anyhow::ensure!(from_ns <= to_ns, "the recording has no system track");
        tape.marks = marks.into();
        Ok(tape)
    }

    /// Opens the same recording again, for another world, without the first pass.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub(crate) fn again(&self) -> anyhow::Result<Self> {
        let files = self.files.iter().zip(self.paths.iter());
        let files = files.map(|(file, path)| Ok(file.beside(opened(path)?)));
        let files = files.collect::<anyhow::Result<_>>()?;
        Ok(Self {
            paths: Arc::clone(&self.paths),
            files,
            topics: Arc::clone(&self.topics),
            marks: Arc::clone(&self.marks),
            span_ns: self.span_ns,
            next: 0,
            waiting: VecDeque::new(),
            latest: None,
            damage: self.damage,
        })
    }

    /// Returns start and end of the recording, UTC, nanoseconds.
    pub(crate) fn span_ns(&self) -> [i64; 2] {
        self.span_ns
    }

    /// Returns the damaged parts of the files, which are skipped.
    pub(crate) fn damage(&self) -> Damage {
        self.damage
    }

    /// Notes the picture's time in the next chunk of `file`. Returns `false` at its end.
    fn note(
        &mut self,
        file: usize,
        clock: &mut PictureClock,
        marks: &mut Vec<ChunkPosition>,
    ) -> Result<bool, RecordingError> {
        let place = self.files[file].place();
        let mark = ChunkPosition {
            file,
            place,
            at_ns: self.span_ns[1],
            clock: *clock,
        };
        let slices = slices(&mut self.files[file], &self.topics, clock, &mut self.damage)?;
        for at_ns in slices.iter().flatten().filter_map(|slice| slice.at_ns) {
            self.span_ns = [self.span_ns[0].min(at_ns), self.span_ns[1].max(at_ns)];
        }
        marks.extend(slices.is_some().then_some(mark));
        Ok(slices.is_some())
    }

    /// Whether the way to the moment `at_ns` begins with an empty world.
    pub(crate) fn leaps(&self, at_ns: i64) -> bool {
        let is_back = self.latest.is_none_or(|(_, latest_ns)| at_ns < latest_ns);
        is_back || self.before(at_ns) > self.next
    }

    /// Brings `world` to the moment `at_ns`.
    ///
    /// # Errors
    /// If the recording can no longer be read.
    pub(crate) fn go_to(&mut self, world: &mut World, at_ns: i64) -> anyhow::Result<()> {
        if self.leaps(at_ns) {
            *world = world.emptied();
            self.waiting.clear();
            self.latest = None;
            self.next = self.before(at_ns);
        }
        loop {
            // Slices recorded before the first track belong to the first picture.
            let time_ns = |slice: &RecordedSlice| slice.at_ns.unwrap_or(self.span_ns[0]);
            while self.waiting.front().is_some_and(|slice| time_ns(slice) <= at_ns) {
                let Some(slice) = self.waiting.pop_front() else { break };
                let slice_ns = time_ns(&slice);
                self.latest = Some((slice.taken, slice_ns));
                world.pass_to(slice_ns, slice.taken);
                put(world, &slice);
                world.clean_up(slice.taken);
            }
            if !self.waiting.is_empty() || !self.load()? {
                break;
            }
        }
        if let Some((taken, latest_ns)) = self.latest {
            // The time of the next slice limits the passed time: slices of a recording made faster than real time
            // follow closely.
            let next_ns = self.waiting.front().map(|next| next.taken.mono_ns - taken.mono_ns);
            let passed_ns = (at_ns - latest_ns).min(next_ns.unwrap_or(i64::MAX)).max(0);
            let now = Now {
                mono_ns: taken.mono_ns + passed_ns,
                utc_ns: taken.utc_ns + passed_ns,
            };
            world.pass_to(at_ns, now);
        }
        Ok(())
    }

    /// Returns the number of the first chunk to read for the picture of `at_ns`.
    fn before(&self, at_ns: i64) -> usize {
        let begins = |ns: i64| self.marks.partition_point(|mark| mark.at_ns < ns).saturating_sub(1);
        begins(at_ns - BEFORE_NS).max(begins(at_ns).saturating_sub(BEFORE_CHUNKS))
    }

    /// Reads the next chunk. Returns `false` if there is none.
    fn load(&mut self) -> anyhow::Result<bool> {
        let Some(mark) = self.marks.get(self.next) else {
            return Ok(false);
        };
        self.next += 1;
        let file = &mut self.files[mark.file];
        file.go_to(mark.place);
        // The first pass has counted the damage.
        let mut again = Damage::default();
        let slices = slices(file, &self.topics, &mut { mark.clock }, &mut again)?;
        self.waiting.extend(slices.into_iter().flatten());
        Ok(true)
    }
}

fn opened(path: &Path) -> anyhow::Result<BufReader<File>> {
    let file = File::open(path).with_context(|| path.display().to_string())?;
    Ok(BufReader::with_capacity(1 << 18, file))
}

/// Returns the displayed slices of the next chunk of `file`; `None` at its end. Adds the damage before them.
fn slices(
    file: &mut Chunks<BufReader<File>>,
    topics: &BTreeMap<String, TopicKind>,
    clock: &mut PictureClock,
    damage: &mut Damage,
) -> Result<Option<Vec<RecordedSlice>>, RecordingError> {
    let mut slices: Vec<RecordedSlice> = Vec::new();
    // Whether the following samples belong to the last of the slices.
    let mut is_shown = false;
    let is_there = file.read::<RecordingError>(|item| {
        match item {
            Item::Slice {
                topic,
                header,
                taken_ns,
                sent_ns,
            } => {
                let kind = topics.get(topic).copied();
                is_shown = kind.is_some();
                let utc_ns = taken_ns as i64;
                slices.extend(kind.map(|kind| RecordedSlice {
                    kind,
                    header,
                    taken: Now {
                        mono_ns: header.sent_ns + (utc_ns - sent_ns as i64),
                        utc_ns,
                    },
                    at_ns: clock.at(recorded(utc_ns)),
                    octets: Vec::new(),
                    size: 0,
                }));
            }
            Item::Sample { octets, .. } if is_shown => {
                if let Some(slice) = slices.last_mut() {
                    if slice.kind == TopicKind::Stream(Stream::SystemTracks)
                        && let Some(track) = SystemTrack::of_octets(octets)
                    {
                        clock.hear(track.reference_time_ns, recorded(slice.taken.utc_ns));
                        slice.at_ns = clock.at(recorded(slice.taken.utc_ns));
                    }
                    slice.octets.extend_from_slice(octets);
                    slice.size = octets.len();
                }
            }
            Item::Damaged { bytes, .. } => {
                damage.parts += 1;
                damage.bytes += bytes.end - bytes.start;
            }
            Item::Sample { .. } | Item::Facts(_) | Item::Topic { .. } => {}
        }
        Ok(())
    })?;
    Ok(is_there.then_some(slices))
}

/// Returns the clocks at a recording time. UTC serves as the monotonic time as well, since UTC is continuous
/// through all files.
fn recorded(utc_ns: i64) -> Now {
    Now {
        mono_ns: utc_ns,
        utc_ns,
    }
}

/// Returns the displayed topics of the deployment of `config`, by name.
fn topics(config: &Deployment) -> BTreeMap<String, TopicKind> {
    let streams = config.streams().filter_map(|(id, name)| {
        let topic = for_displayed(id.stream, TopicOf(name))?;
        Some((topic.as_str().to_owned(), TopicKind::Stream(id.stream)))
    });
    let health = (messages::health().name.as_str().to_owned(), TopicKind::Health);
    streams.chain([health]).collect()
}

/// Puts a recorded slice into the world.
struct Put<'a> {
    world: &'a mut World,
    slice: &'a RecordedSlice,
}

impl ForDisplayed for Put<'_> {
    type Done = ();

    fn of<T: DisplayedSample>(self) {
        T::put(self.world, (&self.slice.header, &samples(self.slice)), self.slice.taken);
    }
}

fn samples<T: Sample>(slice: &RecordedSlice) -> Vec<T> {
    let each = slice.octets.chunks(slice.size.max(1));
    each.filter_map(T::of_octets).collect()
}

fn put(world: &mut World, slice: &RecordedSlice) {
    match slice.kind {
        TopicKind::Health => {
            let said: Vec<Health> = samples(slice);
            said.iter().for_each(|health| world.observed.take_health(health));
        }
        TopicKind::Stream(stream) => {
            let _ = for_displayed(stream, Put { world, slice });
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use configuration::{BUILT_IN_DEMO, Config};
    use messages::TrackState;
    use messages::layout::Sample as _;
    use recording::{Facts, Writer};
    use test_support::S;

    use super::*;
    use crate::world::ReplayedRecording;

    const BEGIN_NS: i64 = 1_700_000_000 * S;
    /// The data are older than their recording.
    const LATER_NS: i64 = 1_000_000 * S;

    fn state(number: u32, second: i64, state: TrackState) -> SystemTrack {
        SystemTrack {
            track_number: number,
            reference_time_ns: BEGIN_NS + second * S,
            position_m: [second as f64, 0.0, 0.0],
            state: state as u8,
            ..SystemTrack::default()
        }
    }

    /// Recording of 2,000 s, a state every ten: track 1 all the time, track 2 from 500 s to 1,500 s; a chunk each
    /// 100 s, in two files.
    fn record(folder: &std::path::Path) -> Vec<PathBuf> {
        let paths = ["a.mcap", "b.mcap"].map(|name| folder.join(name));
        for (path, from) in paths.iter().zip([0, 1_000]) {
            let mut writer = Writer::begin(File::create(path).unwrap(), &Facts::new()).unwrap();
            let topic = messages::system_tracks();
            let channel = writer.channel(topic.name.as_str(), &SystemTrack::LAYOUT).unwrap();
            for second in (from..from + 1_000).step_by(10) {
                let of_second = match second {
                    500..1_500 => Some(TrackState::Confirmed),
                    1_500 => Some(TrackState::Terminated),
                    _ => None,
                };
                let mut states = vec![state(1, second, TrackState::Confirmed)];
                states.extend(of_second.map(|of_second| state(2, second, of_second)));
                let header = BatchHeader {
                    incarnation: 1,
                    sent_ns: second * S,
                    ..BatchHeader::default()
                };
                let taken_ns = BEGIN_NS + LATER_NS + second * S;
                let octets = SystemTrack::octets(&states);
                writer.slice(channel, &header, octets, taken_ns, taken_ns).unwrap();
                if second % 100 == 90 {
                    writer.flush().unwrap();
                }
            }
            writer.finish().unwrap();
        }
        paths.into()
    }

    const NOW: Now = Now {
        mono_ns: 0,
        utc_ns: BEGIN_NS,
    };

    /// World that shows `tape`.
    pub(crate) fn world_of(tape: &Tape) -> World {
        let mut world = World::new("test", Vec::new(), 600, 1_000_000);
        world.recording = Some(ReplayedRecording::begin("test".to_owned(), tape.span_ns(), NOW));
        world
    }

    /// The recording in `folder`, with the time of its data.
    pub(crate) fn recorded_tape(folder: &std::path::Path) -> Tape {
        Tape::open_with(&demo(), PictureClock::of(true), &record(folder)).unwrap()
    }

    fn demo() -> Config {
        Config::read(std::path::Path::new(BUILT_IN_DEMO), &[]).unwrap()
    }

    #[test]
    fn what_was_live_is_shown_at_the_time_of_the_machine_that_recorded_it() {
        let folder = tempfile::tempdir().unwrap();
        let mut tape = Tape::open(&demo(), &record(folder.path())).unwrap();
        let begin_ns = BEGIN_NS + LATER_NS;
        assert_eq!(tape.span_ns(), [begin_ns, begin_ns + 1_990 * S]);
        let mut world = world_of(&tape);
        tape.go_to(&mut world, begin_ns + 600 * S).unwrap();
        assert_eq!((world.tracks.len(), world.time_ns(NOW)), (2, begin_ns + 600 * S));
    }

    #[test]
    fn fusion_is_not_silent_in_a_recording_made_in_a_hurry() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("hurried.mcap");
        let mut writer = Writer::begin(File::create(&path).unwrap(), &Facts::new()).unwrap();
        let topic = messages::system_tracks();
        let channel = writer.channel(topic.name.as_str(), &SystemTrack::LAYOUT).unwrap();
        // A cycle of 5 s in each 10 ms, without health messages; a chunk each.
        for cycle in 0..60 {
            let header = BatchHeader {
                incarnation: 1,
                sent_ns: cycle * S / 100,
                ..BatchHeader::default()
            };
            let states = [state(1, cycle * 5, TrackState::Confirmed)];
            let taken_ns = BEGIN_NS + LATER_NS + cycle * S / 100;
            let octets = SystemTrack::octets(&states);
            writer.slice(channel, &header, octets, taken_ns, taken_ns).unwrap();
            writer.flush().unwrap();
        }
        writer.finish().unwrap();
        let mut tape = Tape::open_with(&demo(), PictureClock::of(true), &[path]).unwrap();
        let mut world = world_of(&tape);
        for second in [0, 1, 4, 100, 104, 17, 290] {
            tape.go_to(&mut world, BEGIN_NS + second * S).unwrap();
            let now = world.now(NOW);
            assert!(!world.observed.is_fusion_absent(now.mono_ns), "{second} s: {now:?}");
        }
    }

    #[test]
    fn damage_is_counted_once_however_often_its_file_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let paths = record(folder.path());
        let mut octets = std::fs::read(&paths[0]).unwrap();
        let middle = octets.len() / 2;
        octets[middle] ^= 1;
        std::fs::write(&paths[0], octets).unwrap();
        let mut tape = Tape::open(&demo(), &paths).unwrap();
        let damage = tape.damage();
        assert!(damage.parts == 1 && damage.bytes > 0, "{damage:?}");
        let mut world = world_of(&tape);
        for second in [100, 1_900, 400, 1_200] {
            tape.go_to(&mut world, BEGIN_NS + LATER_NS + second * S).unwrap();
        }
        assert_eq!(tape.damage(), damage);
    }

    #[test]
    fn any_moment_has_the_states_that_were_the_latest_then() {
        let folder = tempfile::tempdir().unwrap();
        let mut tape = recorded_tape(folder.path());
        assert_eq!(tape.span_ns(), [BEGIN_NS, BEGIN_NS + 1_990 * S]);
        let mut world = world_of(&tape);
        // Ahead, back, a jump, and the ends; the generation counts how often the world was emptied.
        let moments = [
            (0, 1),
            (300, 1),
            (600, 1),
            (1_490, 2),
            (1_500, 2),
            (200, 3),
            (1_990, 4),
            (1_200, 5),
        ];
        for (second, generation) in moments {
            tape.go_to(&mut world, BEGIN_NS + second * S + S / 2).unwrap();
            let shown: Vec<_> = world
                .tracks
                .values()
                .map(|live| (live.track.track_number, live.track.position_m[0]))
                .collect();
            let mut expected = vec![(1, second as f64)];
            expected.extend((500..1_500).contains(&second).then_some((2, second as f64)));
            assert_eq!(shown, expected, "{second} s");
            assert_eq!(world.generation, generation, "{second} s");
            assert_eq!(world.time_ns(NOW), BEGIN_NS + second * S + S / 2);
            let then = world.now(NOW);
            assert_eq!(
                (then.mono_ns, then.utc_ns),
                (second * S + S / 2, BEGIN_NS + LATER_NS + second * S + S / 2)
            );
        }
    }
}

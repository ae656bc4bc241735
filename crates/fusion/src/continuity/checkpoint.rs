//! Checkpoint: state that survives the death of the fusion process.
//!
//! Users follow targets by track number. A successor of a killed fusion process must continue the same targets under
//! the same numbers, and must assign no used number to another target. The engine therefore writes the necessary
//! state into memory that outlives the process ([`Memory`]), at every change:
//!
//! | area | a record for | written |
//! |---|---|---|
//! | numbers | the numbers that are reserved | before the first of a block is used |
//! | clock | the time that has passed, the process, and the state of the clocks | by the caller, in each turn |
//! | suspects | reports in which fusion has died | at the start, and when a suspect is cleared |
//! | positions | each source: progress through the reports | after each report |
//! | systems | each system track: number, state, life, identity | at each change; every second state |
//! | members | each sensor track that belongs to a system track | at joining and leaving |
//! | remembered | each former member that has not reported since: before the start, of a suspended track | at both |
//! | sources | learned properties of each source | in turn |
//! | pairs | of each pair of sources: sums of registration, gross errors, dependence | in turn |
//! | classes | how hard each class of targets turns | in turn |
//! | cells | where on the ground each source follows targets | in turn |
//! | orders | each order in force, and orders that ended recently | at each change |
//!
//! The crate [`kept`](mod@kept) writes a record so that a kill costs at most one record. Writing needs no system
//! call, no lock and no allocation; the size is fixed at the start ([`CheckpointLayout::len`]).
//!
//! A word before the areas ([`IN_WORK`]) identifies the report in process; the word is stored before each report.
//!
//! Other state is learned again within seconds: reports and histories of sensor tracks. The first report of a former
//! member returns the sensor track to its system track.
//!
//! A [`Snapshot`] is the content found by the successor: the engine's start is a function of this content alone, so
//! that a recording with the content can be replayed from there.

use std::sync::atomic::AtomicU64;

use kept::{Get, HEAD, Kept, Put, RecordArea, RecordState, is_marked, kept, mark, mixed};
pub use kept::{Memory, MemoryRefusal};

use crate::settings::{Capacity, SourceSettings};

/// Version of the records; increase with each change of their contents.
const FORMAT: u64 = 14;
/// Word that names the report in work, as [`report_key`](super::suspects::report_key) does; 0 before the first report.
pub const IN_WORK: usize = HEAD;
/// Records that a kill can leave torn.
const TORN_MAX: usize = 1;

/// Kinds of records, in the order in which they lie in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RecordKind {
    Numbers,
    Clock,
    Suspects,
    Positions,
    Systems,
    Members,
    Remembered,
    Sources,
    Pairs,
    Classes,
    Cells,
    Orders,
}

const KINDS: [RecordKind; 12] = [
    RecordKind::Numbers,
    RecordKind::Clock,
    RecordKind::Suspects,
    RecordKind::Positions,
    RecordKind::Systems,
    RecordKind::Members,
    RecordKind::Remembered,
    RecordKind::Sources,
    RecordKind::Pairs,
    RecordKind::Classes,
    RecordKind::Cells,
    RecordKind::Orders,
];

kept! {
    /// State of the process that writes a checkpoint.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct CheckpointClock {
        /// Start-up number of the writing fusion.
        pub epoch: u64,
        /// Number of the process.
        pub process_id: u32,
        /// Monotonic time of the latest turn, nanoseconds.
        pub turn_ns: i64,
        /// UTC of the latest turn, nanoseconds since 1970.
        pub utc_ns: i64,
        /// Time up to which time had passed in the engine, nanoseconds; `i64::MIN` before the first report.
        pub passed_ns: i64,
        /// How far the engine's time was ahead of the machine's UTC, nanoseconds.
        pub ahead_ns: i64,
        /// How far the sources' time was ahead of the engine's, nanoseconds.
        pub host_offset_ns: i64,
    }
}

kept! {
    /// How far a source's reports have been worked off.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct SourcePosition {
        /// Incarnation of the source's publisher.
        pub incarnation: u64,
        /// Sequence number of the first report not yet worked off.
        pub next_sequence: u64,
    }
}

/// Where each record lies, for an engine with certain settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CheckpointLayout {
    areas: [RecordArea; KINDS.len()],
    names: u64,
}

/// Words of the records whose contents the engine's parts define.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes {
    pub(crate) suspects: usize,
    pub(crate) systems: usize,
    pub(crate) members: usize,
    pub(crate) sources: usize,
    pub(crate) pairs: usize,
    pub(crate) classes: (usize, usize),
    pub(crate) cells: (usize, usize),
    pub(crate) orders: (usize, usize),
}

impl CheckpointLayout {
    pub(crate) fn new(capacity: &Capacity, names: &[SourceSettings], sizes: Sizes) -> Self {
        let sources = names.len();
        let (systems, sensors) = (capacity.system_tracks(), capacity.sensor_tracks());
        let mut first = IN_WORK + 1;
        let areas = KINDS.map(|kind| {
            let (places, words) = match kind {
                RecordKind::Numbers => (1, u32::WORDS),
                RecordKind::Clock => (1, CheckpointClock::WORDS),
                RecordKind::Suspects => (1, sizes.suspects),
                RecordKind::Positions => (sources, SourcePosition::WORDS),
                RecordKind::Systems => (systems, sizes.systems),
                RecordKind::Members | RecordKind::Remembered => (sensors, sizes.members),
                RecordKind::Sources => (sources, sizes.sources),
                RecordKind::Pairs => (sources * sources, sizes.pairs),
                RecordKind::Classes => sizes.classes,
                RecordKind::Cells => sizes.cells,
                RecordKind::Orders => sizes.orders,
            };
            let area = RecordArea { first, places, words };
            first += area.len();
            area
        });
        let names = names.iter().flat_map(|source| source.name.bytes().chain([0]));
        Self {
            areas,
            names: names.fold(FORMAT, |hash, octet| mixed(hash ^ u64::from(octet))),
        }
    }

    fn area(&self, kind: RecordKind) -> &RecordArea {
        &self.areas[kind as usize]
    }

    /// Words of memory that a checkpoint takes.
    #[expect(clippy::len_without_is_empty, reason = "it never is")]
    pub fn len(&self) -> usize {
        IN_WORK + 1 + self.areas.iter().map(RecordArea::len).sum::<usize>()
    }

    /// Differs where records are laid out otherwise, or sources have other numbers.
    pub(crate) fn fingerprint(&self) -> u64 {
        let sizes = self.areas.iter().flat_map(|area| [area.places, area.words]);
        sizes.fold(self.names, |hash, size| mixed(hash ^ size as u64))
    }
}

/// Writes a checkpoint.
#[derive(Debug)]
pub(crate) struct CheckpointWriter {
    memory: Box<dyn Memory>,
    layout: CheckpointLayout,
    /// How often each record has been written, all areas one after another.
    times: Vec<u32>,
    /// Where each area begins there.
    begins: [usize; KINDS.len()],
    /// Next record of the round: index of the kind, and place.
    turn: (usize, usize),
    /// The record that is being written.
    words: Box<[u64]>,
}

impl CheckpointWriter {
    /// In `memory`, which is blank.
    pub(crate) fn begin(memory: Box<dyn Memory>, layout: CheckpointLayout) -> Self {
        let mut places = 0;
        let begins = layout.areas.map(|area| {
            places += area.places;
            places - area.places
        });
        mark(memory.words(), layout.fingerprint());
        let longest = layout.areas.iter().map(|area| area.words).max();
        Self {
            memory,
            layout,
            times: vec![0; places],
            begins,
            turn: (0, 0),
            words: vec![0; longest.unwrap_or_default()].into(),
        }
    }

    /// Writes the record of `kind` at `place`.
    #[inline]
    pub(crate) fn write(&mut self, kind: RecordKind, place: usize, record: &impl Kept) {
        self.write_with(kind, place, |to| record.put(to));
    }

    /// Writes the complete record of `kind` at `place` with the words from `put`.
    #[inline]
    pub(crate) fn write_with(&mut self, kind: RecordKind, place: usize, put: impl FnOnce(&mut Put<'_>)) {
        let area = self.layout.area(kind);
        let words = &mut self.words[..area.words];
        put(&mut Put::new(words));
        let times = &mut self.times[self.begins[kind as usize] + place];
        *times = times.wrapping_add(1).max(1);
        area.write(self.memory.words(), place, u64::from(*times), words);
    }

    /// The next record of these kinds, round and round.
    pub(crate) fn next_in_turn(&mut self, kinds: &[RecordKind]) -> Option<(RecordKind, usize)> {
        let (turn, place) = self.turn;
        let kind = *kinds.get(turn)?;
        let is_last = place + 1 >= self.places(kind);
        self.turn = match is_last {
            true => ((turn + 1) % kinds.len(), 0),
            false => (turn, place + 1),
        };
        (place < self.places(kind)).then_some((kind, place))
    }

    /// Number of records of `kind`.
    pub(crate) fn places(&self, kind: RecordKind) -> usize {
        self.layout.area(kind).places
    }
}

/// Start of a fusion: all that was found in a checkpoint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Snapshot {
    layout: CheckpointLayout,
    /// Fingerprint of the layout; then for each record a word with kind and place, and the contents.
    words: Vec<u64>,
}

impl Snapshot {
    /// Reads the records of a process with the same `layout` that no longer writes.
    ///
    /// # Errors
    /// If the memory is damaged in more than the record being written.
    pub fn read(memory: &[AtomicU64], layout: &CheckpointLayout) -> Result<Self, MemoryRefusal> {
        if !is_marked(memory, layout.len(), layout.fingerprint()) {
            return Err(MemoryRefusal::Foreign);
        }
        let (mut words, mut contents) = (vec![layout.fingerprint()], Vec::new());
        let (mut torn, mut damaged) = (0, 0);
        for kind in KINDS {
            let area = layout.area(kind);
            for place in 0..area.places {
                let is_there = match area.read(memory, place, &mut contents) {
                    RecordState::Nothing => false,
                    RecordState::Whole => true,
                    RecordState::Torn { has_other } => {
                        torn += 1;
                        has_other
                    }
                    RecordState::Damaged => {
                        damaged += 1;
                        false
                    }
                };
                if is_there {
                    words.push((kind as u64) << 32 | place as u64);
                    words.extend_from_slice(&contents);
                }
            }
        }
        if damaged > 0 || torn > TORN_MAX {
            return Err(MemoryRefusal::Damaged(damaged + torn));
        }
        Ok(Self {
            layout: layout.clone(),
            words,
        })
    }

    /// Returns the words for storage.
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// The snapshot that has these words.
    ///
    /// # Errors
    /// If the words have another layout.
    pub fn of_words(words: Vec<u64>, layout: &CheckpointLayout) -> Result<Self, MemoryRefusal> {
        if words.first() != Some(&layout.fingerprint()) {
            return Err(MemoryRefusal::Foreign);
        }
        let snapshot = Self {
            layout: layout.clone(),
            words,
        };
        let is_whole = snapshot.records().all(|record| record.is_some());
        is_whole.then_some(snapshot).ok_or(MemoryRefusal::Damaged(1))
    }

    /// Returns each record with kind and place; a malformed record gives `None` and ends the sequence.
    fn records(&self) -> impl Iterator<Item = Option<(RecordKind, usize, &[u64])>> {
        let mut rest = &self.words[1..];
        std::iter::from_fn(move || {
            let (tag, after) = rest.split_first()?;
            rest = &[];
            let record = KINDS.get((tag >> 32) as usize).and_then(|kind| {
                let area = self.layout.area(*kind);
                let place = (tag & u64::from(u32::MAX)) as usize;
                let (contents, following) = after.split_at_checked(area.words)?;
                rest = following;
                (place < area.places).then_some((*kind, place, contents))
            });
            Some(record)
        })
    }

    /// The records of `kind` with places, as words.
    pub(crate) fn of_kind(&self, kind: RecordKind) -> impl Iterator<Item = (usize, &[u64])> {
        let records = self.records().flatten();
        records
            .filter(move |(found, ..)| *found == kind)
            .map(|(_, place, words)| (place, words))
    }

    /// The records of `kind` with places.
    pub(crate) fn all<T: Kept>(&self, kind: RecordKind) -> impl Iterator<Item = (usize, T)> {
        self.of_kind(kind)
            .filter_map(|(place, words)| Some((place, T::get(&mut Get(words))?)))
    }

    /// Returns the clock state of the writing process; `None` if the process was killed before the first turn.
    pub fn clock(&self) -> Option<CheckpointClock> {
        self.all(RecordKind::Clock).map(|(_, clock)| clock).next()
    }

    /// The first number that is not reserved; `None` if none was reserved yet.
    pub(crate) fn reserved_numbers(&self) -> Option<u32> {
        self.all::<u32>(RecordKind::Numbers).map(|(_, number)| number).next()
    }

    /// The first number that the writing process has given to no target.
    pub fn first_free_number(&self) -> u32 {
        self.reserved_numbers().unwrap_or(1)
    }

    /// How far each source's reports had been worked off, by source number.
    pub fn positions(&self) -> impl Iterator<Item = (u16, SourcePosition)> {
        self.all(RecordKind::Positions)
            .map(|(place, position)| (place as u16, position))
    }
}

/// Returns the state of the process, possibly alive, that writes the checkpoint in `memory`; `None` before its first
/// record.
pub fn clock_of(memory: &[AtomicU64], layout: &CheckpointLayout) -> Option<CheckpointClock> {
    let mut words = Vec::new();
    let area = layout.area(RecordKind::Clock);
    (memory.len() == layout.len()).then(|| area.read(memory, 0, &mut words))?;
    CheckpointClock::get(&mut Get(&words)).filter(|clock| clock.epoch != 0)
}

/// How far `source`'s reports have been worked off by the process, possibly alive, that writes the checkpoint in
/// `memory`.
pub fn position_of(memory: &[AtomicU64], layout: &CheckpointLayout, source: u16) -> Option<SourcePosition> {
    let mut words = Vec::new();
    let area = layout.area(RecordKind::Positions);
    (memory.len() == layout.len()).then(|| area.read(memory, usize::from(source), &mut words))?;
    SourcePosition::get(&mut Get(&words))
}

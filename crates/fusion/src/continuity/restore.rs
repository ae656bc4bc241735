//! Content of the engine's checkpoint, and start from a checkpoint.
//!
//! Tracks are written at each change ([`Tracks::keep`](crate::tables::tracks::Tracks)); learned properties of sources
//! are written in turn when the caller has time ([`Engine::keep_learned`]), without other effects.

use kept::{Get, Kept, kept};
use messages::{NS_PER_S, TrackState};
use source_models::{KeptClass, KeptPair, KeptSource, Sources};

use crate::continuity::checkpoint::{
    CheckpointClock, CheckpointLayout, CheckpointWriter, Memory, RecordKind, Sizes, Snapshot, SourcePosition,
};
use crate::continuity::numbering;
use crate::continuity::suspects::Suspects;
use crate::engine::Engine;
use crate::explanation::Sink;
use crate::judge::life;
use crate::orders::order_table::{OrderRecord, PLACES};
use crate::tables::system_tracks::{KeptTrack, SystemSlot};
use crate::tables::tracks::TrackMembership;

/// Time before a kill within which the end of a track may not have been published, nanoseconds.
const TOLD_AGAIN_NS: i64 = 5 * NS_PER_S as i64;
/// Kinds written in turn.
const IN_TURN: [RecordKind; 4] = [
    RecordKind::Sources,
    RecordKind::Pairs,
    RecordKind::Classes,
    RecordKind::Cells,
];

kept! {
    /// All learned properties of a source.
    struct SourceEstimates {
        models: KeptSource,
        mean_square: Option<f64>,
    }
}

impl Engine {
    /// How a checkpoint of this engine is laid out.
    pub fn checkpoint_layout(&self) -> CheckpointLayout {
        let sizes = Sizes {
            suspects: Suspects::WORDS,
            systems: KeptTrack::WORDS,
            members: TrackMembership::WORDS,
            sources: SourceEstimates::WORDS,
            pairs: KeptPair::WORDS,
            classes: (Sources::CLASSES, KeptClass::WORDS),
            cells: self.tracks.sources.kept_cells(),
            orders: (PLACES, OrderRecord::WORDS),
        };
        CheckpointLayout::new(&self.settings.capacity, &self.settings.sources, sizes)
    }

    /// Keeps the engine's state in `memory`, which is blank, from now on.
    pub fn keep_checkpoint(&mut self, memory: Box<dyn Memory>) {
        let checkpoint = CheckpointWriter::begin(memory, self.checkpoint_layout());
        self.tracks.keep_in(checkpoint);
        self.keep_orders();
        self.keep_learned(self.learned_records());
    }

    /// Starts from the state kept by another engine. System tracks continue under the same numbers; with `ends`,
    /// because the checkpoint is too old, each is reported to `sink` as terminated. The same applies to tracks that
    /// ended shortly before, because the end may not have been published.
    pub fn resume(&mut self, snapshot: &Snapshot, ends: bool, sink: &mut impl Sink) {
        let passed_ns = snapshot.clock().map_or(i64::MIN, |clock| clock.passed_ns);
        self.host_clock.offset_ns = snapshot.clock().map_or(0, |clock| clock.host_offset_ns);
        let sink = &mut self.host_clock.outward(sink);
        self.schedule.pass(passed_ns);
        self.resume_learned(snapshot);
        let mut numbers: Vec<(u32, SystemSlot)> = Vec::new();
        let live = self.live_numbers(snapshot);
        for (_, kept) in snapshot.all::<KeptTrack>(RecordKind::Systems) {
            let Some(was) = kept.life().filter(|_| kept.is_of(self.settings.sources.len())) else {
                continue;
            };
            // The process died while a target took its former number over.
            if was == TrackState::Suspended && live.binary_search(&kept.number).is_ok() {
                continue;
            }
            let had_ended = was == TrackState::Terminated;
            if had_ended && passed_ns.saturating_sub(kept.state_ns()) > TOLD_AGAIN_NS {
                continue;
            }
            let lives_as = if had_ended { TrackState::Tentative } else { was };
            let Some(slot) = self.tracks.systems.resume(&kept, lives_as) else {
                continue;
            };
            if had_ended || ends {
                let out = &mut self.outbox.to(sink);
                let end_ns = passed_ns.max(kept.state_ns());
                life::end(&self.settings, &mut self.tracks, slot, end_ns, kept.merged_into, out);
            } else {
                numbers.push((kept.number, slot));
            }
        }
        numbers.sort_unstable();
        let slot_of = |number: u32| {
            let found = numbers.binary_search_by_key(&number, |(number, _)| *number).ok()?;
            Some(numbers[found].1)
        };
        let kinds = [RecordKind::Members, RecordKind::Remembered];
        let members: Vec<(TrackMembership, SystemSlot)> = kinds
            .into_iter()
            .flat_map(|kind| snapshot.all::<TrackMembership>(kind))
            .filter_map(|(_, member)| Some((member, slot_of(member.system_track)?)))
            .collect();
        self.tracks.remember(members);
        let least = numbers.last().map_or(1, |(number, _)| numbering::following(*number));
        self.start_numbers_at(snapshot.reserved_numbers().unwrap_or(least));
        self.resume_orders(snapshot.all::<OrderRecord>(RecordKind::Orders), sink);
    }

    /// Numbers of the kept system tracks that are neither suspended nor ended, in ascending order.
    fn live_numbers(&self, snapshot: &Snapshot) -> Vec<u32> {
        let lives = |kept: &KeptTrack| {
            !matches!(kept.life(), None | Some(TrackState::Suspended | TrackState::Terminated))
                && kept.is_of(self.settings.sources.len())
        };
        let kept = snapshot.all::<KeptTrack>(RecordKind::Systems);
        let mut numbers: Vec<u32> = kept
            .filter(|(_, kept)| lives(kept))
            .map(|(_, kept)| kept.number)
            .collect();
        numbers.sort_unstable();
        numbers
    }

    /// The next system track that starts has this number.
    pub fn start_numbers_at(&mut self, number: u32) {
        self.tracks.systems.set_next_number(number);
    }

    fn resume_learned(&mut self, snapshot: &Snapshot) {
        let sources = &mut self.tracks.sources;
        for (source, learned) in snapshot.all::<SourceEstimates>(RecordKind::Sources) {
            sources.resume_source(source, &learned.models);
            *self.publisher.accuracies.mean_square_mut(source) = learned.mean_square;
        }
        for (place, pair) in snapshot.all::<KeptPair>(RecordKind::Pairs) {
            sources.resume_pair(place, &pair);
        }
        for (place, class) in snapshot.all::<KeptClass>(RecordKind::Classes) {
            sources.resume_class(place, &class);
        }
        for (place, words) in snapshot.of_kind(RecordKind::Cells) {
            sources.resume_cell(place, &mut Get(words));
        }
    }

    /// Notes how far the reports of `source` have been worked off.
    #[inline]
    pub fn keep_position(&mut self, source: u16, position: SourcePosition) {
        if let Some(checkpoint) = &mut self.tracks.checkpoint {
            checkpoint.write(RecordKind::Positions, usize::from(source), &position);
        }
    }

    /// Stores the reports in which fusion has died.
    pub fn keep_suspects(&mut self, suspects: &Suspects) {
        if let Some(checkpoint) = &mut self.tracks.checkpoint {
            checkpoint.write(RecordKind::Suspects, 0, suspects);
        }
    }

    /// Notes that the process lives; how far time has passed, and the host offset, are filled in.
    pub fn keep_clock(&mut self, clock: CheckpointClock) {
        let (passed_ns, host_offset_ns) = (self.schedule.now_ns(), self.host_clock.offset_ns);
        if let Some(checkpoint) = &mut self.tracks.checkpoint {
            let clock = CheckpointClock {
                passed_ns,
                host_offset_ns,
                ..clock
            };
            checkpoint.write(RecordKind::Clock, 0, &clock);
        }
    }

    /// Number of the records that [`Self::keep_learned`] goes through.
    pub fn learned_records(&self) -> usize {
        let checkpoint = self.tracks.checkpoint.as_ref();
        checkpoint.map_or(0, |checkpoint| {
            IN_TURN.iter().map(|kind| checkpoint.places(*kind)).sum()
        })
    }

    /// Writes the next `count` records of learned properties of the sources.
    pub fn keep_learned(&mut self, count: usize) {
        for _ in 0..count {
            self.keep_next_learned();
        }
    }

    fn keep_next_learned(&mut self) {
        let Some(checkpoint) = &mut self.tracks.checkpoint else {
            return;
        };
        let Some((kind, place)) = checkpoint.next_in_turn(&IN_TURN) else {
            return;
        };
        let sources = &mut self.tracks.sources;
        match kind {
            RecordKind::Sources => {
                let learned = SourceEstimates {
                    models: sources.kept_source(place),
                    mean_square: *self.publisher.accuracies.mean_square_mut(place),
                };
                checkpoint.write(kind, place, &learned);
            }
            RecordKind::Pairs => checkpoint.write(kind, place, &sources.kept_pair(place)),
            RecordKind::Classes => checkpoint.write(kind, place, &sources.kept_class(place)),
            _ => {
                if let Some(cell) = sources.kept_cell(place) {
                    checkpoint.write_with(kind, place, cell);
                }
            }
        }
    }
}

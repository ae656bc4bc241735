//! Continuation after the end of another fusion process.
//!
//! The engine stores the state for a successor in memory that outlives the process and the launcher
//! ([`fusion::checkpoint`], [`bus::Outlasting`]). A starting fusion looks for this checkpoint and publishes the content
//! on the topic `system/restored`, for recordings. The new fusion then continues the same tracks under the same numbers
//! as a new epoch, with a new checkpoint that is complete before other processes can find this memory.
//!
//! A checkpoint from before the begin of the simulated world has targets of another world: only the numbers go on.
//!
//! An unusable checkpoint is put aside and reported. The given track numbers are then unknown: numbering begins at a
//! place that depends on the time of day, so that no number is repeated within a day.

use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use bus::{Outlasting, Root, Transport};
use fusion::checkpoint::{CheckpointClock, CheckpointLayout, IN_WORK, Memory as _, Snapshot};
use fusion::numbering::anew;
use fusion::suspects::{SuspectTreatment, Suspects, report_key};
use fusion::{Driver, Engine, ReportNumber, Sink};
use runtime::clock::mono_ns;
use runtime::housekeeping::SnapshotParts;
use runtime::instance::{CHECKPOINT, QUARANTINED};
use runtime::{Now, Publication};

use crate::inputs::SourceInput;
use crate::log::Log;

/// Time between two signs of life, nanoseconds.
const NOTE_NS: i64 = 1_000_000;
/// Time within which everything learned is written once, nanoseconds: half of the guaranteed time.
const ROUND_NS: i64 = 5_000_000_000;
/// Maximum number of learned records written in a turn.
const RECORDS_PER_TURN: usize = 64;

/// Way in which the lead was obtained.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct TakeOver {
    /// Whether another fusion had led before.
    pub(crate) from_another: bool,
    /// Whether the other fusion hung.
    pub(crate) stood_still: bool,
}

/// Start of a fusion.
#[derive(Debug)]
pub(crate) struct FusionStart {
    pub(crate) epoch: u64,
    root: Root,
    layout: CheckpointLayout,
    found: Predecessor,
}

#[derive(Debug)]
enum Predecessor {
    /// There was no fusion before.
    Nothing,
    /// Tracks to continue, or to report as terminated.
    Tracks {
        snapshot: Box<Snapshot>,
        ends: bool,
        /// Whether the tracks are a copy from before a fault of the machine.
        is_revived: bool,
        /// Reports in which fusion has died.
        suspects: Suspects,
    },
    /// A previous fusion followed targets of another simulated world: numbers from `first_number` on are free.
    OfAnotherWorld { first_number: u32 },
    /// A previous fusion existed, but the checkpoint is unusable.
    Refused,
}

impl FusionStart {
    /// Looks for the checkpoint of the previous fusion, which no longer writes. `world_ns` is the begin of the
    /// simulated world (UTC, nanoseconds), if any.
    pub(crate) fn look(root: &Root, max_age_ns: i64, world_ns: Option<i64>, engine: &Engine, now: Now) -> Self {
        let layout = engine.checkpoint_layout();
        let found = find(root, max_age_ns, world_ns, &layout, now);
        let last = match &found {
            Predecessor::Tracks { snapshot, .. } => snapshot.clock().map_or(0, |clock| clock.epoch),
            _ => 0,
        };
        Self {
            // Time of the lead, not of the start of the process: the previous leader may have started later than this
            // standby, and the previous epoch may be lost. UTC continues across a reboot.
            epoch: now.utc_ns.max(1).cast_unsigned().max(last.saturating_add(1)),
            root: root.clone(),
            layout,
            found,
        }
    }

    /// Lead of the engine's time over the machine's UTC, and of the sources' time over the engine's, nanoseconds.
    pub(crate) fn clocks(&self) -> (i64, i64) {
        match &self.found {
            Predecessor::Tracks { snapshot, .. } => snapshot
                .clock()
                .map_or((0, 0), |clock| (clock.ahead_ns, clock.host_offset_ns)),
            _ => (0, 0),
        }
    }

    /// Returns the reports in which fusion has died.
    fn suspects(&self) -> Suspects {
        match self.found {
            Predecessor::Tracks { suspects, .. } => suspects,
            _ => Suspects::default(),
        }
    }

    /// Whether tracks of a predecessor are known.
    pub(crate) fn goes_on(&self) -> bool {
        matches!(self.found, Predecessor::Tracks { .. })
    }

    /// Returns the snapshot for the topic `system/restored`; `None` without a predecessor.
    pub(crate) fn whole(&self, now: Now) -> Option<SnapshotParts> {
        let Predecessor::Tracks { snapshot, ends, .. } = &self.found else {
            return None;
        };
        Some(SnapshotParts {
            epoch: self.epoch,
            time_ns: now.utc_ns,
            ends: u32::from(*ends),
            octets: snapshot.words().iter().flat_map(|word| word.to_le_bytes()).collect(),
        })
    }

    /// Restores the engine, passes terminated tracks to `sink`, and writes a new checkpoint.
    ///
    /// # Errors
    /// If a source's topic fails, or the machine has no memory for the checkpoint.
    pub(crate) fn resume<S: Transport>(
        self,
        driver: &mut Driver<Log>,
        inputs: &mut [SourceInput<S>],
        sink: &mut impl Sink,
        now: Now,
    ) -> anyhow::Result<Keeping> {
        match &self.found {
            Predecessor::Nothing => {}
            Predecessor::Tracks {
                snapshot,
                ends,
                is_revived,
                ..
            } => {
                driver.resume(snapshot, *ends, sink);
                if *is_revived {
                    // The number of tracks started after the copy is unknown.
                    driver.start_numbers_at(anew(now.utc_ns));
                }
                for (source, position) in snapshot.positions() {
                    if let Some(input) = inputs.get_mut(usize::from(source)) {
                        input.follow(Some(position), i64::MIN, mono_ns)?;
                    }
                }
            }
            Predecessor::OfAnotherWorld { first_number } => driver.start_numbers_at(*first_number),
            // The given numbers are unknown.
            Predecessor::Refused => driver.start_numbers_at(anew(now.utc_ns)),
        }
        let engine = driver.engine_mut();
        let memory = Arc::new(self.root.make_outlasting(CHECKPOINT, self.layout.len())?);
        engine.keep_checkpoint(Box::new(Arc::clone(&memory)));
        let mut keeping = Keeping::new(memory, self.epoch, self.suspects(), now);
        keeping.clock.ahead_ns = self.clocks().0;
        engine.keep_suspects(&keeping.suspects);
        keeping.note(engine, now);
        keeping.publication.tend(now.mono_ns);
        Ok(keeping)
    }
}

fn find(root: &Root, max_age_ns: i64, world_ns: Option<i64>, layout: &CheckpointLayout, now: Now) -> Predecessor {
    let refused = |reason: String| {
        let aside = root.put_outlasting_aside(CHECKPOINT);
        let aside = aside.map_or_else(String::new, |path| format!(" (put aside: {})", path.display()));
        runtime::notice(format_args!("warning: the checkpoint is not used: {reason}{aside}"));
        Predecessor::Refused
    };
    match root.outlasting(CHECKPOINT) {
        Ok(None) => Predecessor::Nothing,
        Ok(Some(memory)) if memory.is_blank() => Predecessor::Refused,
        Ok(Some(memory)) => match Snapshot::read(memory.words(), layout) {
            Ok(snapshot) => {
                let written_ns = snapshot.clock().map(|clock| clock.utc_ns);
                if world_ns.is_some_and(|begin_ns| written_ns.is_none_or(|written_ns| written_ns < begin_ns)) {
                    let first_number = match memory.is_revived() {
                        true => anew(now.utc_ns),
                        false => snapshot.first_free_number(),
                    };
                    return Predecessor::OfAnotherWorld { first_number };
                }
                let age_ns = written_ns.map(|written_ns| now.utc_ns.saturating_sub(written_ns));
                let ends = age_ns.is_none_or(|age_ns| age_ns > max_age_ns);
                let suspects = Suspects::found(memory.words(), &snapshot);
                if suspects.has_quarantined() {
                    // The state before the report, to reproduce the fault.
                    root.copy_outlasting_aside(CHECKPOINT, QUARANTINED);
                }
                Predecessor::Tracks {
                    suspects,
                    snapshot: Box::new(snapshot),
                    ends,
                    is_revived: memory.is_revived(),
                }
            }
            Err(error) => refused(error.to_string()),
        },
        Err(error) => refused(error.to_string()),
    }
}

/// Checkpoint apart from reports: changes without a report, and the report in work.
#[derive(Debug)]
pub(crate) struct Keeping {
    memory: Arc<Outlasting>,
    suspects: Suspects,
    clock: CheckpointClock,
    noted_ns: i64,
    /// Publication of the complete checkpoint.
    publication: Publication,
    /// Start of the present round over learned records, and the number of records written.
    round_ns: i64,
    written: usize,
}

impl Keeping {
    fn new(memory: Arc<Outlasting>, epoch: u64, suspects: Suspects, now: Now) -> Self {
        Self {
            publication: Publication::new(Arc::clone(&memory), "the tracks of fusion".to_owned()),
            memory,
            suspects,
            clock: CheckpointClock {
                epoch,
                process_id: std::process::id(),
                ..CheckpointClock::default()
            },
            noted_ns: i64::MIN,
            round_ns: now.mono_ns,
            written: 0,
        }
    }

    /// Notes the report in work. Returns whether the report is in quarantine.
    #[inline]
    pub(crate) fn begin_report(&self, source: u16, report: ReportNumber) -> SuspectTreatment {
        let key = report_key(source, report.publisher, report.sequence);
        self.memory.words()[IN_WORK].store(key, Relaxed);
        match self.suspects.is_empty() {
            true => SuspectTreatment::Sound,
            false => self.suspects.verdict(key),
        }
    }

    /// Notes that fusion has survived a suspect report.
    #[cold]
    pub(crate) fn clear(&mut self, engine: &mut Engine, source: u16, report: ReportNumber) {
        self.suspects
            .clear(report_key(source, report.publisher, report.sequence));
        engine.keep_suspects(&self.suspects);
    }

    /// Writes the due records.
    #[inline]
    pub(crate) fn tend(&mut self, engine: &mut Engine, now: Now, ahead_ns: i64) {
        if now.mono_ns.saturating_sub(self.noted_ns) >= NOTE_NS {
            self.clock.ahead_ns = ahead_ns;
            self.note(engine, now);
            self.go_round(engine, now);
            self.publication.tend(now.mono_ns);
        }
    }

    /// Writes everything learned, at an orderly end.
    pub(crate) fn close(&mut self, engine: &mut Engine, now: Now) {
        engine.keep_learned(engine.learned_records());
        self.note(engine, now);
    }

    fn note(&mut self, engine: &mut Engine, now: Now) {
        self.noted_ns = now.mono_ns;
        (self.clock.turn_ns, self.clock.utc_ns) = (now.mono_ns, now.utc_ns);
        engine.keep_clock(self.clock);
    }

    fn go_round(&mut self, engine: &mut Engine, now: Now) {
        let all = engine.learned_records();
        let passed_ns = (now.mono_ns - self.round_ns).min(ROUND_NS);
        let due = (all as i64 * passed_ns / ROUND_NS) as usize;
        let count = due.saturating_sub(self.written).min(RECORDS_PER_TURN);
        engine.keep_learned(count);
        self.written += count;
        if self.written >= all {
            (self.round_ns, self.written) = (now.mono_ns, 0);
        }
    }
}

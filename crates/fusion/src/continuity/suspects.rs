//! Reports in which fusion has died.
//!
//! The process stores the name of each report in the checkpoint before its work ([`IN_WORK`]), and the source's
//! position after the work. A name without its position marks the report in which the process died: a *suspect*. The
//! successor works a suspect off once more, since a kill from outside can fall into any report. A report in which
//! fusion dies twice is put in quarantine: the next successor passes over the report.

use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

use kept::kept;

use crate::continuity::checkpoint::{IN_WORK, RecordKind, Snapshot};

/// Maximum number of suspects. A process dies in a single report: further places hold suspects not yet reached at the
/// death of a successor.
const SUSPECTS_MAX: usize = 4;
/// Deaths in a report that put the report in quarantine.
const DEATHS_MAX: u32 = 2;

/// Name of a report in one word: `publisher` is the epoch of the source's publisher, `sequence` the number of the
/// report among the publisher's samples. Never 0 for a publisher later than 1970.
#[inline]
pub fn report_key(source: u16, publisher: u64, sequence: u64) -> u64 {
    (publisher << u16::BITS | u64::from(source)) ^ sequence.rotate_left(u32::BITS)
}

kept! {
    /// Reports in which fusion has died, and how often; a key of 0 is a free place.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Suspects {
        keys: [u64; SUSPECTS_MAX],
        deaths: [u32; SUSPECTS_MAX],
    }
}

/// Treatment of a suspect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SuspectTreatment {
    /// Fusion has never died in the report.
    Sound,
    /// Fusion has died in the report once: the report is worked off again.
    Again,
    /// Fusion has died in the report twice: the report is passed over.
    Quarantine,
}

impl Suspects {
    /// Returns the first suspects of a dead process's successor: the suspects of `snapshot`, and the report in which
    /// the writer of `memory` died, if any.
    pub fn found(memory: &[AtomicU64], snapshot: &Snapshot) -> Self {
        let mut suspects: Self = snapshot
            .all(RecordKind::Suspects)
            .map(|(_, found)| found)
            .next()
            .unwrap_or_default();
        let in_work = memory.get(IN_WORK).map_or(0, |word| word.load(Relaxed));
        let is_done = snapshot.positions().any(|(source, position)| {
            in_work == report_key(source, position.incarnation, position.next_sequence.wrapping_sub(1))
        });
        if in_work != 0 && !is_done {
            suspects.add_death(in_work);
        }
        suspects
    }

    fn add_death(&mut self, key: u64) {
        let known = self.keys.iter().position(|known| *known == key);
        let free = || self.keys.iter().position(|known| *known == 0);
        // Without a free place the first suspect gives way: the others are younger.
        let place = known.or_else(free).unwrap_or_else(|| {
            self.remove(0);
            SUSPECTS_MAX - 1
        });
        self.keys[place] = key;
        self.deaths[place] += 1;
    }

    fn remove(&mut self, place: usize) {
        self.keys.copy_within(place + 1.., place);
        self.deaths.copy_within(place + 1.., place);
        self.keys[SUSPECTS_MAX - 1] = 0;
        self.deaths[SUSPECTS_MAX - 1] = 0;
    }

    /// Whether there is no suspect.
    pub fn is_empty(&self) -> bool {
        self.keys[0] == 0
    }

    /// Whether a report is in quarantine that has not been reached yet.
    pub fn has_quarantined(&self) -> bool {
        self.deaths.iter().any(|deaths| *deaths >= DEATHS_MAX)
    }

    /// Returns the treatment of the report with this name.
    pub fn verdict(&self, key: u64) -> SuspectTreatment {
        let place = self.keys.iter().position(|known| *known == key && key != 0);
        match place.map(|place| self.deaths[place]) {
            None => SuspectTreatment::Sound,
            Some(deaths) if deaths < DEATHS_MAX => SuspectTreatment::Again,
            Some(_) => SuspectTreatment::Quarantine,
        }
    }

    /// Forgets the report of this name: fusion is past the report, and lives.
    pub fn clear(&mut self, key: u64) {
        if let Some(place) = self.keys.iter().position(|known| *known == key) {
            self.remove(place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_death_in_a_report_puts_it_in_quarantine_and_no_other() {
        let mut suspects = Suspects::default();
        let keys: Vec<u64> = (0..3).map(|sequence| report_key(2, 1_000_000_007, sequence)).collect();
        assert_eq!(suspects.verdict(keys[0]), SuspectTreatment::Sound);
        assert_eq!(suspects.verdict(0), SuspectTreatment::Sound);
        suspects.add_death(keys[0]);
        suspects.add_death(keys[1]);
        assert_eq!(suspects.verdict(keys[0]), SuspectTreatment::Again);
        suspects.add_death(keys[0]);
        assert_eq!(suspects.verdict(keys[0]), SuspectTreatment::Quarantine);
        assert_eq!(suspects.verdict(keys[1]), SuspectTreatment::Again);
        assert_eq!(suspects.verdict(keys[2]), SuspectTreatment::Sound);
        suspects.clear(keys[0]);
        assert_eq!(suspects.verdict(keys[0]), SuspectTreatment::Sound);
        assert_eq!(suspects.verdict(keys[1]), SuspectTreatment::Again);
        suspects.clear(keys[1]);
        assert!(suspects.is_empty());
    }

    #[test]
    fn a_full_table_drops_the_oldest_suspect() {
        let mut suspects = Suspects::default();
        let keys: Vec<u64> = (0..=SUSPECTS_MAX as u64)
            .map(|sequence| report_key(0, 77, sequence))
            .collect();
        for key in &keys {
            suspects.add_death(*key);
        }
        assert_eq!(suspects.verdict(keys[0]), SuspectTreatment::Sound);
        assert!(
            keys[1..]
                .iter()
                .all(|key| suspects.verdict(*key) == SuspectTreatment::Again)
        );
    }
}

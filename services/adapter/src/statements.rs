//! What the targets of a feed have stated beside their motion, for the topic of statements.
//!
//! Transmissions state parts, again and again. The book joins the parts of a target; a target's sample goes out when
//! some part has changed, and again after [`AGAIN_NS`], so that a late subscriber has all within that time. It has the
//! time of the target's latest transmission. Targets without a transmission for [`SILENCE_NS`] are forgotten.
//!
//! Stations that are no targets are in the book like targets.

use observations::Statement;
use rustc_hash::FxHashMap;

/// Time after which a target's statement is published again, nanoseconds.
const AGAIN_NS: i64 = 60_000_000_000;
/// Silence after which a target is forgotten, nanoseconds: ships at anchor state their data every six minutes.
const SILENCE_NS: i64 = 1_200_000_000_000;
/// Time between two searches for what is due, nanoseconds.
const SEARCH_NS: i64 = 1_000_000_000;
/// Maximum number of targets.
const TARGETS_MAX: usize = 16_384;

/// Statements by track number, see the module's documentation.
#[derive(Debug, Default)]
pub(crate) struct StatementBook {
    targets: FxHashMap<u32, StatedTarget>,
    searched_ns: i64,
    /// Statements of targets for which there was no room.
    refused: u64,
}

#[derive(Debug)]
struct StatedTarget {
    statement: Statement,
    sent_ns: i64,
    heard_ns: i64,
}

impl StatementBook {
    /// Notes a transmission of a target at `now_ns` (UTC, nanoseconds).
    pub(crate) fn alive(&mut self, track_number: u32, now_ns: i64) {
        if let Some(target) = self.targets.get_mut(&track_number) {
            target.heard_ns = now_ns;
        }
    }

    /// Takes a statement; returns all that the target has stated, if some of it is new.
    pub(crate) fn take(&mut self, stated: &Statement, now_ns: i64) -> Option<Statement> {
        if self.targets.len() >= TARGETS_MAX && !self.targets.contains_key(&stated.track_number) {
            self.refused += 1;
            return None;
        }
        let target = self.targets.entry(stated.track_number).or_insert(StatedTarget {
            statement: Statement::default(),
            sent_ns: i64::MIN,
            heard_ns: now_ns,
        });
        target.heard_ns = now_ns;
        let mut updated = target.statement;
        updated.update(stated);
        if updated == target.statement {
            return None;
        }
        (target.statement, target.sent_ns) = (updated, now_ns);
        Some(updated)
    }

    /// Returns the statements that are due again at `now_ns`, each with the time of the target's latest transmission.
    pub(crate) fn due(&mut self, now_ns: i64) -> Vec<(Statement, i64)> {
        if now_ns - self.searched_ns < SEARCH_NS {
            return Vec::new();
        }
        self.searched_ns = now_ns;
        self.targets.retain(|_, target| now_ns - target.heard_ns < SILENCE_NS);
        let due = self
            .targets
            .values_mut()
            .filter(|target| now_ns - target.sent_ns >= AGAIN_NS);
        let mut due: Vec<(Statement, i64)> = due
            .map(|target| {
                target.sent_ns = now_ns;
                (target.statement, target.heard_ns)
            })
            .collect();
        due.sort_unstable_by_key(|(statement, _)| statement.track_number);
        due
    }

    /// Statements of targets for which there was no room.
    pub(crate) fn refused(&self) -> u64 {
        self.refused
    }
}

#[cfg(test)]
mod tests {
    use observations::{NavigationStatus, TargetCategory};

    use super::*;

    const S: i64 = 1_000_000_000;

    fn stated(track_number: u32, category: TargetCategory, navigation: NavigationStatus) -> Statement {
        Statement {
            track_number,
            category,
            navigation,
            ..Statement::default()
        }
    }

    #[test]
    fn what_changes_goes_out_at_once_and_the_whole_again_after_a_minute() {
        let mut book = StatementBook::default();
        let (cargo, anchored) = (TargetCategory::Cargo, NavigationStatus::Anchored);
        assert!(book.take(&stated(7, cargo, NavigationStatus::Unknown), 0).is_some());
        assert_eq!(
            book.take(&stated(7, cargo, NavigationStatus::Unknown), S),
            None,
            "nothing is new"
        );
        let whole = book.take(&stated(7, TargetCategory::Unknown, anchored), 2 * S).unwrap();
        assert_eq!((whole.category, whole.navigation), (cargo, anchored));
        assert!(book.due(30 * S).is_empty());
        assert_eq!(book.due(62 * S), [(whole, 2 * S)]);
        assert!(book.due(63 * S).is_empty());
        book.alive(7, 1_000 * S);
        assert_eq!(book.due(2_000 * S).len(), 1, "a target that transmits stays");
        assert!(book.due(2_300 * S).is_empty(), "a silent target is forgotten");
    }

    #[test]
    fn targets_are_bounded() {
        let mut book = StatementBook::default();
        for number in 0..TARGETS_MAX as u32 + 5 {
            book.take(&stated(number, TargetCategory::Cargo, NavigationStatus::Unknown), 0);
        }
        assert_eq!((book.targets.len(), book.refused()), (TARGETS_MAX, 5));
    }
}

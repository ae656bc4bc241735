//! Times at which tracks are sent.
//!
//! Fusion publishes a state for every report, several a second for each track. A display needs each track once per
//! refresh period, at evenly spread times: a burst would overflow the display's socket. A schedule therefore stores
//! the latest state of each track, and each track has its own turn: the first at once, the next after each refresh
//! period. All periods are equal, so that the turns form a queue. The end of a track is sent at once.

use std::collections::VecDeque;

use rustc_hash::FxHashMap;

/// Silence after which a track is dropped: its source has ended without a last report.
const SILENCE_MAX_NS: i64 = 120_000_000_000;

/// Time after a change of fusion within which the successor must publish each track of its predecessor.
const UNHEARD_MAX_NS: i64 = 30_000_000_000;

/// Minimum age of a state that a new track may displace, nanoseconds.
const DISPLACED_NS: i64 = 1_000_000_000;

/// Latest states of tracks, and their turns.
#[derive(Debug)]
pub(crate) struct SendSchedule<T> {
    refresh_ns: i64,
    capacity: usize,
    entries: FxHashMap<u32, ScheduleEntry<T>>,
    /// Turns in the order of time. A turn that differs from its track's entry is out of date.
    turns: VecDeque<(i64, u32)>,
    dropped: u64,
    /// Time at which the present publisher began to publish.
    began_ns: i64,
}

#[derive(Debug)]
struct ScheduleEntry<T> {
    latest: T,
    heard_ns: i64,
    turn_ns: i64,
}

impl<T: Copy> SendSchedule<T> {
    /// Creates a schedule for `capacity` tracks. With a refresh period of 0, each state is due at once.
    pub(crate) fn new(refresh_ns: i64, capacity: usize) -> Self {
        Self {
            refresh_ns,
            capacity,
            entries: FxHashMap::with_capacity_and_hasher(capacity, rustc_hash::FxBuildHasher),
            turns: VecDeque::with_capacity(2 * capacity),
            dropped: 0,
            began_ns: i64::MIN,
        }
    }

    /// Removes the track with the oldest state if the table is full and `number` is new. The table has as many places
    /// as the engine, so that the end of the removed track was lost.
    pub(crate) fn displaced_by(&mut self, number: u32, now_ns: i64) -> Option<T> {
        if self.entries.len() < self.capacity || self.entries.contains_key(&number) {
            return None;
        }
        let unheard = self
            .entries
            .iter()
            .map(|(number, entry)| (entry.heard_ns, *number))
            .min();
        let (_, stale) = unheard.filter(|(heard_ns, _)| now_ns - heard_ns > DISPLACED_NS)?;
        self.entries.remove(&stale).map(|entry| entry.latest)
    }

    /// Stores a state of track `number` that arrived at `now_ns`. Returns whether the state is to be sent at once.
    pub(crate) fn take(&mut self, number: u32, track: T, now_ns: i64) -> bool {
        if self.refresh_ns == 0 {
            return true;
        }
        if let Some(entry) = self.entries.get_mut(&number) {
            entry.latest = track;
            entry.heard_ns = now_ns;
            return false;
        }
        if self.entries.len() == self.capacity {
            self.dropped += 1;
            return false;
        }
        let turn_ns = now_ns + self.refresh_ns;
        let entry = ScheduleEntry {
            latest: track,
            heard_ns: now_ns,
            turn_ns,
        };
        self.entries.insert(number, entry);
        self.turns.push_back((turn_ns, number));
        true
    }

    /// Ends track `number`. Returns whether the track was in the table.
    pub(crate) fn end(&mut self, number: u32) -> bool {
        self.entries.remove(&number).is_some() || self.refresh_ns == 0
    }

    /// Returns the state of the next track that is due at `now_ns`.
    pub(crate) fn next_turn(&mut self, now_ns: i64) -> Option<T> {
        loop {
            let (turn_ns, number) = *self.turns.front()?;
            if turn_ns > now_ns {
                return None;
            }
            self.turns.pop_front();
            let Some(entry) = self.entries.get_mut(&number).filter(|entry| entry.turn_ns == turn_ns) else {
                continue;
            };
            if now_ns - entry.heard_ns > SILENCE_MAX_NS {
                self.entries.remove(&number);
                continue;
            }
            // The next turn counts from now, not from the due time: a delayed gateway sends no burst to catch up.
            entry.turn_ns = now_ns + self.refresh_ns;
            self.turns.push_back((entry.turn_ns, number));
            return Some(entry.latest);
        }
    }

    /// Returns the time of the next turn.
    pub(crate) fn next_turn_ns(&self) -> Option<i64> {
        self.turns.front().map(|(turn_ns, _)| *turn_ns)
    }

    /// Removes all tracks, and returns the latest state of each in the order of their numbers.
    pub(crate) fn forget_all(&mut self, mut visit: impl FnMut(T)) {
        let mut numbers: Vec<u32> = self.entries.keys().copied().collect();
        numbers.sort_unstable();
        for number in numbers {
            if let Some(entry) = self.entries.remove(&number) {
                visit(entry.latest);
            }
        }
        self.turns.clear();
    }

    /// Marks all tracks as continued by another publisher from `now_ns`.
    pub(crate) fn go_on(&mut self, now_ns: i64) {
        self.began_ns = now_ns;
    }

    /// Removes the tracks that the present publisher should have published by `now_ns` and has not, and returns their
    /// latest states in the order of their numbers.
    pub(crate) fn forget_unheard(&mut self, now_ns: i64, mut visit: impl FnMut(T)) {
        if self.began_ns == i64::MIN || now_ns < self.began_ns + UNHEARD_MAX_NS {
            return;
        }
        let began_ns = std::mem::replace(&mut self.began_ns, i64::MIN);
        let unheard = self.entries.iter().filter(|(_, entry)| entry.heard_ns < began_ns);
        let mut numbers: Vec<u32> = unheard.map(|(number, _)| *number).collect();
        numbers.sort_unstable();
        for number in numbers {
            if let Some(entry) = self.entries.remove(&number) {
                visit(entry.latest);
            }
        }
    }

    /// Number of states that found no place.
    pub(crate) fn dropped(&self) -> u64 {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use test_support::S;

    #[test]
    fn a_track_is_sent_at_once_and_then_by_its_period_with_its_latest_state() {
        let mut schedule = SendSchedule::new(4 * S, 10);
        assert!(schedule.take(7, 'a', 0));
        assert!(!schedule.take(7, 'b', S));
        assert_eq!(schedule.next_turn(3 * S), None);
        assert_eq!(schedule.next_turn_ns(), Some(4 * S));
        assert_eq!(schedule.next_turn(4 * S), Some('b'));
        assert_eq!(schedule.next_turn(4 * S), None, "once");
        assert_eq!(schedule.next_turn(20 * S), Some('b'), "held up: once, not four times");
        assert_eq!(schedule.next_turn(23 * S), None);
    }

    #[test]
    fn a_number_used_again_has_one_turn() {
        let mut schedule = SendSchedule::new(4 * S, 10);
        assert!(schedule.take(7, 'a', 0));
        assert!(schedule.end(7) && !schedule.end(7));
        assert!(schedule.take(7, 'b', S));
        assert_eq!(schedule.next_turn(4 * S), None, "the turn of the earlier track");
        assert_eq!(schedule.next_turn(5 * S), Some('b'));
        assert_eq!(schedule.next_turn(5 * S), None);
    }

    #[test]
    fn without_a_period_everything_goes_out_at_once() {
        let mut schedule = SendSchedule::new(0, 1);
        assert!((0..5).all(|number| schedule.take(number, 'a', 0)));
        assert!(schedule.end(3));
        assert_eq!(schedule.next_turn(S), None);
    }

    #[test]
    fn what_a_publisher_that_goes_on_never_speaks_of_is_forgotten() {
        let mut schedule = SendSchedule::new(4 * S, 10);
        assert!(schedule.take(1, 'a', 0) && schedule.take(2, 'b', 0));
        let unheard = |schedule: &mut SendSchedule<char>, now_s: i64| {
            let mut found = String::new();
            schedule.forget_unheard(now_s * S, |state| found.push(state));
            found
        };
        assert_eq!(unheard(&mut schedule, 100), "");
        schedule.go_on(100 * S);
        schedule.take(2, 'c', 101 * S);
        assert_eq!(unheard(&mut schedule, 129), "");
        assert_eq!(unheard(&mut schedule, 130), "a");
        assert!(schedule.end(2) && !schedule.end(1));
    }

    #[test]
    fn in_a_full_table_a_track_whose_end_was_lost_makes_room() {
        let mut schedule = SendSchedule::new(4 * S, 2);
        assert!(schedule.take(1, 'a', 0) && schedule.take(2, 'b', 0));
        schedule.take(2, 'c', 2 * S);
        assert_eq!(schedule.displaced_by(2, 3 * S), None, "it has its place");
        assert_eq!(schedule.displaced_by(3, 3 * S), Some('a'));
        assert!(schedule.take(3, 'd', 3 * S));
        assert_eq!(schedule.displaced_by(4, 3 * S), None, "both were heard of just now");
        assert_eq!(schedule.dropped(), 0);
        assert_eq!(
            [schedule.next_turn(4 * S), schedule.next_turn(4 * S)],
            [Some('c'), None]
        );
    }

    #[test]
    fn a_full_table_drops_and_the_silent_are_forgotten() {
        let mut schedule = SendSchedule::new(S, 1);
        assert!(schedule.take(1, 'a', 0));
        assert!(!schedule.take(2, 'b', 0));
        assert_eq!(schedule.dropped(), 1);
        for second in 1..=120 {
            assert_eq!(schedule.next_turn(second * S), Some('a'));
        }
        assert_eq!(schedule.next_turn(121 * S), None);
        assert!(schedule.take(2, 'b', 121 * S), "there is room again");
        let mut forgotten = Vec::new();
        schedule.forget_all(|state| forgotten.push(state));
        assert_eq!(forgotten, ['b']);
        assert_eq!(schedule.next_turn_ns(), None);
    }
}

//! Messages of targets in text: what readers of JSON and XML have in common.
//!
//! Receivers of transponders, of Remote ID and of Cursor on Target send the latest values of each target again and
//! again. A reader distinguishes new positions from repetitions, and changed statements from unchanged ones, with
//! bounded memory: a table has a value for each target, by a number of 32 bits. A full table forgets targets that have
//! been silent, and refuses further ones.

use std::fmt;

use frames::time::NS_PER_S;
use observations::{Emergency, NavigationStatus, Observation, Statement, TargetCategory};
use rustc_hash::FxHashMap;
use serde::Deserialize;

/// Characters of a refused value that are kept.
const SHOWN_MAX: usize = 100;
/// Latest time, seconds since 1970: the year 2200. A later one has another unit.
const TIME_MAX_S: f64 = 7_258_118_400.0;
/// Shortest time between two searches for silent targets in a full table, nanoseconds: a search passes all targets.
const SEARCH_EVERY_NS: i64 = NS_PER_S;

/// News of a target: at least one of the two values is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetMessage {
    /// Time of the observation, or of the statement alone: UTC, nanoseconds since 1970.
    pub time_ns: i64,
    /// A new position, with all that belongs to it.
    pub observation: Option<Observation>,
    /// All that the target has stated, if some of it is new.
    pub statement: Option<Statement>,
}

/// Reason for a refusal.
pub trait Reason: Copy {
    /// Returns the fault, and what is permitted.
    fn sentence(self) -> &'static str;
}

/// Refused part of an input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal<R> {
    /// Why it was refused.
    pub reason: R,
    /// Name of the refused value.
    pub key: &'static str,
    /// The value as written, or its beginning.
    pub value: String,
}

impl<R: Reason> Refusal<R> {
    /// The refusal of a value, shortened for display.
    pub(crate) fn new(reason: R, key: &'static str, value: impl fmt::Display) -> Self {
        let value = value.to_string().chars().take(SHOWN_MAX).collect();
        Self { reason, key, value }
    }
}

impl<R: Reason> fmt::Display for Refusal<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:?} {}", self.key, self.value, self.reason.sentence())
    }
}

/// UTC, nanoseconds, of seconds since 1970, to the microsecond: 64 bits have no more. `None` for no such time.
pub(crate) fn utc_ns(seconds: f64) -> Option<i64> {
    let is_time = (0.0..=TIME_MAX_S).contains(&seconds);
    is_time.then(|| (seconds * 1e6).round() as i64 * 1000)
}

/// The value of a JSON text that is an object; else the error in words. Lists are refused, although a structure could
/// be read from their values.
pub(crate) fn object<'a, T: Deserialize<'a>>(text: &'a [u8]) -> Result<T, String> {
    match text.trim_ascii_start().first() {
        Some(b'{') => serde_json::from_slice(text).map_err(|error| error.to_string()),
        Some(other) => Err(format!("begins with {:?} instead of {{", char::from(*other))),
        None => Err("is empty".to_owned()),
    }
}

/// A number for a name, the same everywhere and for ever: FNV-1a with 32 bits (G. Fowler, L. C. Noll, K.-P. Vo). Among
/// a thousand names, two share a number once in ten thousand cases.
pub(crate) fn number_of_name(name: &[u8]) -> u32 {
    name.iter().fold(0x811c_9dc5, |hash, octet| {
        (hash ^ u32::from(*octet)).wrapping_mul(0x0100_0193)
    })
}

/// Values of targets, by number.
#[derive(Debug)]
pub(crate) struct Memory<T> {
    targets: FxHashMap<u32, Remembered<T>>,
    most: usize,
    silence_ns: i64,
    searched_ns: Option<i64>,
}

#[derive(Debug)]
struct Remembered<T> {
    last_ns: i64,
    value: T,
}

impl<T: Default> Memory<T> {
    /// Returns an allocated table for `most` targets, each of which may be forgotten after a silence of `silence_ns`.
    pub(crate) fn new(most: usize, silence_ns: i64) -> Self {
        let mut targets = FxHashMap::default();
        targets.reserve(most);
        Self {
            targets,
            most,
            silence_ns,
            searched_ns: None,
        }
    }

    /// The value of a target that sends at `time_ns`, a new one if needed. `None` if the table has no room.
    pub(crate) fn of(&mut self, number: u32, time_ns: i64) -> Option<&mut T> {
        if self.targets.len() >= self.most && !self.targets.contains_key(&number) {
            self.forget_silent(time_ns);
            if self.targets.len() >= self.most {
                return None;
            }
        }
        let target = self.targets.entry(number).or_insert_with(|| Remembered {
            last_ns: time_ns,
            value: T::default(),
        });
        target.last_ns = target.last_ns.max(time_ns);
        Some(&mut target.value)
    }

    fn forget_silent(&mut self, time_ns: i64) {
        let every_ns = SEARCH_EVERY_NS.unsigned_abs();
        if self.searched_ns.is_none_or(|at_ns| at_ns.abs_diff(time_ns) >= every_ns) {
            self.searched_ns = Some(time_ns);
            let silence_ns = self.silence_ns.unsigned_abs();
            self.targets
                .retain(|_, target| target.last_ns.abs_diff(time_ns) <= silence_ns);
        }
    }
}

/// Latest values of a target.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct KnownTarget {
    position: Option<(i64, [f64; 2])>,
    statement: Statement,
}

impl KnownTarget {
    /// Returns whether a position is another than the latest, or at least `apart_ns` away from its time; then it is the
    /// latest.
    pub(crate) fn is_new(&mut self, time_ns: i64, position: [f64; 2], apart_ns: u64) -> bool {
        let repeats = |(then_ns, place): (i64, [f64; 2])| place == position && then_ns.abs_diff(time_ns) < apart_ns;
        let is_new = !self.position.is_some_and(repeats);
        if is_new {
            self.position = Some((time_ns, position));
        }
        is_new
    }

    /// Adds a statement; returns all that has been stated if some of it is new.
    pub(crate) fn news(&mut self, stated: Statement) -> Option<Statement> {
        let known = &self.statement;
        let all = Statement {
            track_number: stated.track_number,
            category: stated_or(stated.category, known.category, TargetCategory::Unknown),
            navigation: stated_or(stated.navigation, known.navigation, NavigationStatus::Unknown),
            emergency: stated_or(stated.emergency, known.emergency, Emergency::Unknown),
            size_m: stated.size_m.or(known.size_m),
            selected_altitude_m: stated.selected_altitude_m.or(known.selected_altitude_m),
            operator_rad: stated.operator_rad.or(known.operator_rad),
            station: stated.station.or(known.station),
        };
        let nothing = Statement {
            track_number: all.track_number,
            ..Statement::default()
        };
        let is_new = all != *known && all != nothing;
        self.statement = all;
        is_new.then_some(all)
    }
}

fn stated_or<T: PartialEq>(stated: T, known: T, unknown: T) -> T {
    if stated == unknown { known } else { stated }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_has_the_number_of_the_authors_of_the_hash() {
        assert_eq!(
            [&b""[..], b"a", b"foobar"].map(number_of_name),
            [0x811c_9dc5, 0xe40c_292c, 0xbf9c_f968]
        );
    }

    #[test]
    fn times_are_since_1970_and_in_seconds() {
        assert_eq!(utc_ns(1_717_664_319.1), Some(1_717_664_319_100_000_000));
        for seconds in [-1.0, 1_717_664_319_100.0, f64::NAN, f64::INFINITY] {
            assert_eq!(utc_ns(seconds), None, "{seconds}");
        }
    }

    #[test]
    fn a_statement_is_news_once_and_stays_where_the_next_one_is_silent() {
        let mut known = KnownTarget::default();
        let stated = |category, emergency| Statement {
            track_number: 7,
            category,
            emergency,
            ..Statement::default()
        };
        let light = stated(TargetCategory::Light, Emergency::Unknown);
        assert_eq!(known.news(stated(TargetCategory::Unknown, Emergency::Unknown)), None);
        assert_eq!(known.news(light), Some(light));
        assert_eq!(known.news(light), None);
        let both = stated(TargetCategory::Light, Emergency::General);
        let emergency = stated(TargetCategory::Unknown, Emergency::General);
        assert_eq!(known.news(emergency), Some(both));
        assert_eq!((known.news(light), known.news(both)), (None, None));
    }

    #[test]
    fn a_position_is_a_repetition_near_the_time_of_the_same() {
        let mut known = KnownTarget::default();
        assert!(known.is_new(1000, [1.0, 2.0], 100));
        assert!(!known.is_new(1099, [1.0, 2.0], 100) && !known.is_new(901, [1.0, 2.0], 100));
        assert!(known.is_new(1100, [1.0, 2.0], 100) && known.is_new(1100, [1.0, 2.5], 100));
    }

    #[test]
    fn a_full_table_refuses_until_a_target_has_been_silent() {
        let mut memory: Memory<u8> = Memory::new(2, 10 * NS_PER_S);
        for (number, second, has_room) in [
            (1, 0, true),
            (2, 5, true),
            (3, 10, false),
            (3, 11, true),
            (1, 11, false),
            (2, 11, true),
        ] {
            let found = memory.of(number, second * NS_PER_S);
            assert_eq!(found.is_some(), has_room, "{number} at {second} s");
        }
        assert_eq!(memory.targets.len(), 2);
    }

    #[test]
    fn extreme_times_do_no_harm() {
        let mut memory: Memory<KnownTarget> = Memory::new(1, 1);
        for (number, time_ns) in [(1, i64::MIN), (2, i64::MAX), (3, i64::MIN), (4, 0)] {
            let known = memory.of(number, time_ns).expect("the others are silent");
            assert!(known.is_new(time_ns, [0.0; 2], u64::MAX));
        }
    }
}

//! Messages that several receivers have received.
//!
//! Each receiver within range of a ship reports the same message, seconds apart where some of them are remote. The
//! copies carry the same bits, except for the two that a repeater sets. A ship does not send the same bits again so
//! soon: its reports state the second of the minute and the state of the radio channel.

use std::hash::BuildHasher;

use rustc_hash::{FxBuildHasher, FxHashMap};

/// Time between copies of a message, nanoseconds.
const COPY_AGE_MAX_NS: u64 = 10_000_000_000;
/// Most messages that are remembered: ten seconds of both channels in eighty harbours, each with its 75 slots a second.
const REMEMBERED_MAX: usize = 1 << 16;

/// Hashes of recent messages with their times.
#[derive(Debug)]
pub(super) struct Repeats {
    recent: FxHashMap<u64, i64>,
}

impl Repeats {
    pub(super) fn new() -> Self {
        let mut recent = FxHashMap::default();
        recent.reserve(REMEMBERED_MAX);
        Self { recent }
    }

    /// Whether the message has come within the last ten seconds before `now_ns`; remembers it if not.
    pub(super) fn is_repeat(&mut self, payload: &[u8], is_own_ship: bool, now_ns: i64) -> bool {
        // The repeat indicator: the first two bits of the second character.
        let second = payload
            .get(1)
            .map_or(0, |octet| aivdm::string::armor_char_to_sixbit(*octet) & 0xf);
        let key = (payload.first(), second, payload.get(2..), is_own_ship);
        let hash = FxBuildHasher.hash_one(key);
        let is_recent = |time_ns: i64| now_ns.abs_diff(time_ns) <= COPY_AGE_MAX_NS;
        if self.recent.get(&hash).is_some_and(|time_ns| is_recent(*time_ns)) {
            return true;
        }
        if self.recent.len() >= REMEMBERED_MAX {
            self.recent.retain(|_, time_ns| is_recent(*time_ns));
            if self.recent.len() > REMEMBERED_MAX / 2 {
                // A flood: to search the table again soon would cost more than to let some copies pass.
                self.recent.clear();
            }
        }
        self.recent.insert(hash, now_ns);
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;

    #[test]
    fn copies_are_recent_and_have_the_same_bits_but_for_the_repeater() {
        let mut repeats = Repeats::new();
        // `7` is 000111 and `G` is 010111: repeated once.
        assert!(!repeats.is_repeat(b"177KQJ5000", false, 0));
        assert!(repeats.is_repeat(b"177KQJ5000", false, 10 * S));
        assert!(repeats.is_repeat(b"1G7KQJ5000", false, -10 * S));
        assert!(!repeats.is_repeat(b"177KQJ5001", false, 0), "other bits");
        assert!(!repeats.is_repeat(b"167KQJ5000", false, 0), "another number");
        assert!(!repeats.is_repeat(b"177KQJ5000", true, 0), "own ship's");
        assert!(!repeats.is_repeat(b"177KQJ5000", false, 10 * S + 1), "later");
        assert!(!repeats.is_repeat(b"", false, 0) && repeats.is_repeat(b"", false, 0));
    }

    #[test]
    fn the_memory_is_bounded() {
        let mut repeats = Repeats::new();
        let message = |number: usize| format!("{number:012}");
        for number in 0..REMEMBERED_MAX {
            repeats.is_repeat(
                message(number).as_bytes(),
                false,
                if number < 40_000 { 0 } else { 20 * S },
            );
        }
        assert!(!repeats.is_repeat(message(REMEMBERED_MAX).as_bytes(), false, 20 * S));
        assert_eq!(
            repeats.recent.len(),
            REMEMBERED_MAX - 40_000 + 1,
            "old ones are forgotten"
        );
        assert!(repeats.is_repeat(message(40_000).as_bytes(), false, 21 * S));
        for number in 0..3 * REMEMBERED_MAX {
            repeats.is_repeat(message(number).as_bytes(), false, 30 * S);
            assert!(repeats.recent.len() <= REMEMBERED_MAX);
        }
    }
}

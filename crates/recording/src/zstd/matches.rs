//! Search for repetitions: for each place, the latest earlier place with the same eight, else the same five bytes, and
//! the places at the distances of the latest repetitions.

/// Repetition of earlier bytes, after bytes that repeat nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Match {
    /// Bytes before the repetition since the end of the one before.
    pub(super) literals: u32,
    /// Length of the repetition, bytes.
    pub(super) length: u32,
    /// Distance of the repeated bytes, bytes.
    pub(super) distance: u32,
}

/// Logarithms of the sizes of the tables.
const LONG_LOG: u32 = 16;
const SHORT_LOG: u32 = 15;
/// Shortest repetition, bytes: by the table of short places, and at the latest distances.
const SHORT_MIN: usize = 5;
const RECENT_MIN: usize = 4;
/// A repetition so long is taken without a look at the next place.
const LONG_ENOUGH: usize = 32;
/// Longest repetition, bytes.
const LENGTH_MAX: usize = 1 << 16;
/// Distance of the places within a repetition that the tables learn.
const LEARNING_STEP: usize = 4;

/// Places by hashes of the bytes there; 0: none, else the place plus 1.
#[derive(Debug)]
pub(super) struct Matcher {
    long: Vec<u32>,
    short: Vec<u32>,
}

impl Default for Matcher {
    fn default() -> Self {
        Self {
            long: vec![0; 1 << LONG_LOG],
            short: vec![0; 1 << SHORT_LOG],
        }
    }
}

fn eight(data: &[u8], at: usize) -> u64 {
    data[at..].first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes))
}

/// Multiplier of a multiplicative hash: the golden ratio, 64 bits.
const MULTIPLIER: u64 = 0x9e37_79b9_7f4a_7c15;

fn long_hash(bytes: u64) -> usize {
    (bytes.wrapping_mul(MULTIPLIER) >> (64 - LONG_LOG)) as usize
}

fn short_hash(bytes: u64) -> usize {
    ((bytes << 24).wrapping_mul(MULTIPLIER) >> (64 - SHORT_LOG)) as usize
}

/// Returns how many bytes from `from` on equal those from `at` on; `from` is before `at`.
fn equal(data: &[u8], from: usize, at: usize) -> usize {
    let mut count = 0;
    let (earlier, later) = (&data[from..], &data[at..]);
    for (earlier, later) in earlier.chunks_exact(8).zip(later.chunks_exact(8)) {
        let difference = eight(earlier, 0) ^ eight(later, 0);
        if difference != 0 {
            return count + (difference.trailing_zeros() / 8) as usize;
        }
        count += 8;
    }
    let rest = earlier[count..].iter().zip(&later[count..]);
    count + rest.take_while(|(earlier, later)| earlier == later).count()
}

impl Matcher {
    /// Forgets all places.
    pub(super) fn reset(&mut self) {
        self.long.fill(0);
        self.short.fill(0);
    }

    fn learn(&mut self, data: &[u8], at: usize) -> [usize; 2] {
        let bytes = eight(data, at);
        let (long, short) = (long_hash(bytes), short_hash(bytes));
        let place = at as u32 + 1;
        [
            std::mem::replace(&mut self.long[long], place) as usize,
            std::mem::replace(&mut self.short[short], place) as usize,
        ]
    }

    /// Passes the repetitions from `begin` on to `visit`; `data` ends where the block ends. `recent` is the latest
    /// distance, 0 if there is none. Returns the number of bytes after the last repetition.
    pub(super) fn find(&mut self, data: &[u8], begin: usize, mut recent: usize, mut visit: impl FnMut(Match)) -> usize {
        let last = data.len().saturating_sub(8);
        let (mut at, mut literal) = (begin, begin);
        while at < last {
            let [long, short] = self.learn(data, at);
            let (mut length, mut from) = (0, 0);
            let mut consider = |place: usize, least: usize| {
                let found = equal(data, place, at);
                if found >= least && found > length + usize::from(length > 0) {
                    (length, from) = (found, place);
                }
            };
            if recent > 0 && at >= recent {
                consider(at - recent, RECENT_MIN);
            }
            if long > 0 {
                consider(long - 1, SHORT_MIN);
            }
            if short > 0 && short != long {
                consider(short - 1, SHORT_MIN);
            }
            if length == 0 {
                at += 1;
                continue;
            }
            if length < LONG_ENOUGH && at + 1 < last {
                let next = self.long[long_hash(eight(data, at + 1))] as usize;
                let longer = next.checked_sub(1).map(|place| (equal(data, place, at + 1), place));
                if let Some((longer, place)) = longer.filter(|(longer, _)| *longer > length + 2) {
                    (at, length, from) = (at + 1, longer, place);
                }
            }
            while at > literal && from > 0 && data[at - 1] == data[from - 1] {
                (at, from, length) = (at - 1, from - 1, length + 1);
            }
            length = length.min(LENGTH_MAX);
            recent = at - from;
            visit(Match {
                literals: (at - literal) as u32,
                length: length as u32,
                distance: recent as u32,
            });
            let end = at + length;
            for place in (at + 2..end.min(last)).step_by(LEARNING_STEP) {
                self.learn(data, place);
            }
            (at, literal) = (end, end);
        }
        data.len() - literal
    }
}

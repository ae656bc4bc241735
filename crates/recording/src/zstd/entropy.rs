//! Finite-state entropy code (RFC 8878, 4.1): symbols by a table of states, fractions of a bit included.

use super::bits::Bits;

/// Smallest and largest logarithm of a table's size.
const LOG_MIN: u32 = 5;

/// Encoder of one alphabet.
#[derive(Debug)]
pub(super) struct StateTable {
    log: u32,
    /// Share of each symbol, of `1 << log`.
    shares: Vec<u32>,
    states: Vec<u16>,
    symbols: Vec<Transition>,
}

/// Step to the next state by a symbol.
#[derive(Clone, Copy, Debug, Default)]
struct Transition {
    /// Number of bits, in the upper half, minus the smallest state that needs them.
    bits: u32,
    /// Place of the symbol's states, minus its share.
    place: i32,
}

impl StateTable {
    /// Makes the table for symbols that occur so many times, with at most `log_max` bits; `None` for fewer than two
    /// symbols, which need no code.
    pub(super) fn of(counts: &[u32], log_max: u32) -> Option<Self> {
        let used = counts.iter().filter(|count| **count > 0).count() as u32;
        let total: u32 = counts.iter().sum();
        if used < 2 {
            return None;
        }
        let needed = (used - 1).ilog2() + 1;
        let log = total.ilog2().saturating_sub(2).max(needed).clamp(LOG_MIN, log_max);
        let end = counts.iter().rposition(|count| *count > 0)? + 1;
        let shares = shares(&counts[..end], total, 1 << log);
        Some(Self::of_shares(log, shares))
    }

    fn of_shares(log: u32, shares: Vec<u32>) -> Self {
        let size = 1usize << log;
        let mut spread = vec![0; size];
        let mut at = 0;
        for (symbol, share) in shares.iter().enumerate() {
            for _ in 0..*share {
                spread[at] = symbol;
                at = (at + (size >> 1) + (size >> 3) + 3) % size;
            }
        }
        let mut begins = Vec::with_capacity(shares.len());
        let mut symbols = vec![Transition::default(); shares.len()];
        let mut begin = 0;
        for (symbol, share) in shares.iter().enumerate() {
            begins.push(begin as usize);
            symbols[symbol] = match share {
                0 => Transition::default(),
                1 => Transition {
                    bits: (log << 16) - (1 << log),
                    place: begin - 1,
                },
                _ => {
                    let most = log - (share - 1).ilog2();
                    Transition {
                        bits: (most << 16) - (share << most),
                        place: begin - *share as i32,
                    }
                }
            };
            begin += *share as i32;
        }
        let mut states = vec![0; size];
        for (place, symbol) in spread.iter().enumerate() {
            states[begins[*symbol]] = (size + place) as u16;
            begins[*symbol] += 1;
        }
        Self {
            log,
            shares,
            states,
            symbols,
        }
    }

    /// Begins with the last symbol.
    pub(super) fn begin(&self, symbol: u8) -> State<'_> {
        let step = self.symbols[usize::from(symbol)];
        let count = (step.bits + (1 << 15)) >> 16;
        let value = (count << 16) - step.bits;
        State {
            table: self,
            value: self.next(value, count, step),
        }
    }

    fn next(&self, value: u32, count: u32, step: Transition) -> u32 {
        let place = (value >> count) as i32 + step.place;
        u32::from(self.states[place as usize])
    }

    /// Returns the description of the table.
    pub(super) fn description(&self) -> Vec<u8> {
        let mut bits = Bits::default();
        bits.add(self.log - LOG_MIN, 4);
        let (mut left, mut threshold, mut width) = ((1u32 << self.log) + 1, 1u32 << self.log, self.log + 1);
        let mut symbol = 0;
        while left > 1 {
            let share = self.shares[symbol];
            symbol += 1;
            let most = 2 * threshold - 1 - left;
            left -= share;
            let code = match share + 1 {
                low if low < threshold => low,
                high => high + most,
            };
            bits.add(code, width - u32::from(code < most));
            while left < threshold {
                width -= 1;
                threshold >>= 1;
            }
            if share == 0 {
                // The number of further symbols that do not occur, in steps of three.
                let zeros = self.shares[symbol..].iter().take_while(|share| **share == 0).count();
                symbol += zeros;
                (0..zeros / 3).for_each(|_| bits.add(3, 2));
                bits.add((zeros % 3) as u32, 2);
            }
        }
        bits.finish()
    }
}

/// State of an encoder, which goes from the last symbol to the first.
#[derive(Debug)]
pub(super) struct State<'t> {
    table: &'t StateTable,
    value: u32,
}

impl State<'_> {
    /// Adds the symbol before.
    pub(super) fn add(&mut self, symbol: u8, bits: &mut Bits) {
        let step = self.table.symbols[usize::from(symbol)];
        let count = (self.value + step.bits) >> 16;
        bits.add(self.value, count);
        self.value = self.table.next(self.value, count, step);
    }

    /// Ends with the state in which a decoder begins.
    pub(super) fn end(self, bits: &mut Bits) {
        bits.add(self.value, self.table.log);
    }
}

/// Divides `size` among symbols by their counts; every symbol that occurs gets at least 1.
fn shares(counts: &[u32], total: u32, size: u32) -> Vec<u32> {
    let share = |count: &u32| match *count {
        0 => 0,
        count => ((u64::from(count) * u64::from(size) / u64::from(total)) as u32).max(1),
    };
    let mut shares: Vec<u32> = counts.iter().map(share).collect();
    let mut given: u32 = shares.iter().sum();
    while given != size {
        let largest = shares.iter_mut().max().expect("a symbol");
        if given < size {
            *largest += size - given;
            given = size;
        } else {
            // At most one too many for each symbol; a half keeps the largest from falling far below the others.
            let taken = (given - size).min(*largest / 2);
            *largest -= taken;
            given -= taken;
        }
    }
    shares
}

//! Successive numbers of a record, bit by bit.
//!
//! Eight octets at a time are loaded into a window, whose first bits are the next ones. A number thus takes two shifts.

/// Least bits of a full window. It is never filled to its last bit, so that no shift is as long as the window.
const WINDOW_BITS_MIN: u32 = 56;

/// A position in octets that have been measured: whoever reads knows that the bits are there. Behind the end there are
/// zeros.
#[derive(Debug, Clone)]
pub(super) struct BitReader<'a> {
    octets: &'a [u8],
    /// The octets before this one are in the window, or have been read.
    loaded: usize,
    /// The next bits, the first one highest.
    window: u64,
    /// Bits of the window that have not been read.
    left: u32,
}

impl<'a> BitReader<'a> {
    pub(super) fn new(octets: &'a [u8]) -> Self {
        Self {
            octets,
            loaded: 0,
            window: 0,
            left: 0,
        }
    }

    /// The next `width` bits, 1 to 64.
    #[inline(always)]
    pub(super) fn number(&mut self, width: u32) -> u64 {
        if width > self.left {
            return self.number_beyond(width);
        }
        self.loaded_number(width)
    }

    #[inline(always)]
    fn loaded_number(&mut self, width: u32) -> u64 {
        let number = self.window >> (64 - width);
        self.window <<= width;
        self.left = self.left.saturating_sub(width);
        number
    }

    #[inline(never)]
    fn number_beyond(&mut self, width: u32) -> u64 {
        if width <= WINDOW_BITS_MIN {
            self.fill();
            return self.loaded_number(width);
        }
        let high = self.number(width - 32);
        high << 32 | self.number(32)
    }

    /// The next octet.
    #[inline(always)]
    pub(super) fn octet(&mut self) -> u8 {
        self.number(8) as u8
    }

    /// Skips so many bits.
    pub(super) fn skip(&mut self, mut bits: usize) {
        while bits > 0 {
            let some = bits.min(32);
            self.number(some as u32);
            bits -= some;
        }
    }

    /// Number of the next bit, from 0.
    pub(super) fn position(&self) -> usize {
        8 * self.loaded - self.left as usize
    }

    /// Returns true if the next bit is the first of an octet.
    #[inline(always)]
    pub(super) fn is_between_octets(&self) -> bool {
        self.left.is_multiple_of(8)
    }

    fn fill(&mut self) {
        let rest = &self.octets[self.loaded..];
        if let Some(next) = rest.first_chunk() {
            // Bits of an octet that is not whole in the window come again with it, and are the same.
            self.window |= u64::from_be_bytes(*next) >> self.left;
            let whole = (63 - self.left) / 8;
            self.loaded += whole as usize;
            self.left += 8 * whole;
            return;
        }
        self.window &= !(u64::MAX >> self.left);
        for octet in rest {
            if self.left >= WINDOW_BITS_MIN {
                break;
            }
            self.window |= u64::from(*octet) << (56 - self.left);
            self.left += 8;
            self.loaded += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::bits::bits;

    proptest! {
        #[test]
        fn numbers_are_those_at_their_places(
            octets in prop::collection::vec(any::<u8>(), 1..40),
            widths in prop::collection::vec(1_u32..65, 1..40),
        ) {
            let mut reader = BitReader::new(&octets);
            let mut at = 0;
            for width in widths {
                if at + width as usize > 8 * octets.len() {
                    break;
                }
                prop_assert_eq!(reader.number(width), bits(&octets, at, width as usize));
                at += width as usize;
                prop_assert_eq!(reader.position(), at);
                prop_assert_eq!(reader.is_between_octets(), at % 8 == 0);
            }
        }
    }
}

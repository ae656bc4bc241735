//! A line of a table, divided at its commas.

use std::io::{self, BufRead};

/// The mark that some programs write before a text in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Returns a bit for each comma, the highest of its octet; the first octet is the lowest.
fn commas(word: [u8; 8]) -> u64 {
    const COMMAS: u64 = u64::from_le_bytes([b','; 8]);
    const LOW: u64 = u64::from_le_bytes([0x7f; 8]);
    // An octet is now zero where a comma was. Adding to its lower bits carries into its highest bit unless they
    // are zero.
    let others = u64::from_le_bytes(word) ^ COMMAS;
    !(((others & LOW) + LOW) | others | LOW)
}

/// Values of a line, blanks included.
#[derive(Debug, Default)]
pub(crate) struct Row {
    /// The line without its line feed.
    octets: Vec<u8>,
    /// End of each value.
    ends: Vec<usize>,
}

impl Row {
    /// Reads the next line; `false` at the end of the input.
    pub(crate) fn read(&mut self, input: &mut impl BufRead) -> io::Result<bool> {
        self.octets.clear();
        self.ends.clear();
        if input.read_until(b'\n', &mut self.octets)? == 0 {
            return Ok(false);
        }
        if self.octets.last() == Some(&b'\n') {
            self.octets.pop();
        }
        self.find_ends();
        Ok(true)
    }

    /// Finds the commas, eight octets at once. Values are a few octets long, too short for a search from one comma to
    /// the next.
    fn find_ends(&mut self) {
        let (words, rest) = self.octets.as_chunks();
        for (place, word) in words.iter().enumerate() {
            let mut commas = commas(*word);
            while commas != 0 {
                self.ends.push(8 * place + commas.trailing_zeros() as usize / 8);
                commas &= commas - 1;
            }
        }
        let begin = self.octets.len() - rest.len();
        let commas = rest.iter().enumerate().filter(|(_, octet)| **octet == b',');
        self.ends.extend(commas.map(|(place, _)| begin + place));
        self.ends.push(self.octets.len());
    }

    /// Removes a byte order mark before the first value.
    pub(crate) fn trim_byte_order_mark(&mut self) {
        if self.octets.starts_with(BYTE_ORDER_MARK) {
            self.octets.drain(..BYTE_ORDER_MARK.len());
            self.ends.iter_mut().for_each(|end| *end -= BYTE_ORDER_MARK.len());
        }
    }

    /// Whether the line has no character.
    pub(crate) fn is_empty(&self) -> bool {
        self.octets.is_empty()
    }

    /// Whether the line has blanks only, such as the carriage return of another system's line end.
    pub(crate) fn is_blank(&self) -> bool {
        self.octets.trim_ascii().is_empty()
    }

    /// Number of values.
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    /// The value at a place from 0.
    pub(crate) fn value(&self, place: usize) -> &[u8] {
        let begin = if place == 0 { 0 } else { self.ends[place - 1] + 1 };
        &self.octets[begin..self.ends[place]]
    }

    /// The values in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[u8]> {
        (0..self.len()).map(|place| self.value(place))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn values_end_at_commas(octets in prop::collection::vec(prop::sample::select(b",,-+\xac\x2dx0".to_vec()), 0..40)) {
            let mut row = Row::default();
            prop_assert_eq!(row.read(&mut &octets[..]).unwrap(), !octets.is_empty());
            let values: Vec<_> = row.iter().map(<[u8]>::to_vec).collect();
            let expected: Vec<_> = octets.split(|octet| *octet == b',').map(<[u8]>::to_vec).collect();
            prop_assert!(octets.is_empty() || values == expected);
        }
    }
}

//! A line of a table, divided at its commas.

use std::io::{self, BufRead};

/// The mark that some programs write before a text in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

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
        let octets = self.octets.iter().enumerate();
        let commas = octets.filter_map(|(place, octet)| (*octet == b',').then_some(place));
        self.ends.extend(commas);
        self.ends.push(self.octets.len());
        Ok(true)
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

//! A line of a table, divided at its commas.
//!
//! Lines with quotation marks are divided by `csv_core`, the splitter of the crate `csv`, a line at a time: a value
//! whose quotes do not end in its line makes this line a wrong one, and hides none behind it. Most lines have no mark.
//! Their commas are found eight octets at once, in a sixth of the instructions.

use std::io::{self, BufRead};

use csv_core::ReadFieldResult;

/// The mark that some programs write before a text in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

const QUOTE: u8 = b'"';

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
    /// The line without its line feed, or its values without their quotes.
    octets: Vec<u8>,
    /// End of each value.
    ends: Vec<usize>,
    /// Made at the first line with quotation marks: its tables take as long as reading a hundred lines.
    quotes: Option<Box<Quotes>>,
}

/// Splitter of a line with quotation marks, and its input.
#[derive(Debug)]
struct Quotes {
    splitter: csv_core::Reader,
    /// The line as it is in the input.
    line: Vec<u8>,
}

impl Default for Quotes {
    fn default() -> Self {
        let feed = csv_core::Terminator::Any(b'\n');
        Self {
            splitter: csv_core::ReaderBuilder::new().terminator(feed).build(),
            line: Vec::new(),
        }
    }
}

/// Outcome of a read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RowRead {
    Whole,
    /// The quotes of a value do not end in the line.
    Unclosed,
    End,
}

impl Row {
    /// Reads the next line.
    pub(crate) fn read(&mut self, input: &mut impl BufRead) -> io::Result<RowRead> {
        self.octets.clear();
        self.ends.clear();
        if input.read_until(b'\n', &mut self.octets)? == 0 {
            return Ok(RowRead::End);
        }
        if self.octets.last() == Some(&b'\n') {
            self.octets.pop();
        }
        // Without an early end, many octets are compared at once.
        let has_quote = self.octets.iter().fold(false, |found, octet| found | (*octet == QUOTE));
        if has_quote && !self.unquote() {
            return Ok(RowRead::Unclosed);
        }
        if !has_quote {
            self.find_ends();
        }
        Ok(RowRead::Whole)
    }

    /// Divides a line with quotation marks, and takes the quotes off (RFC 4180). `false` if quotes have no end.
    #[cold]
    fn unquote(&mut self) -> bool {
        let Quotes { splitter, line } = &mut **self.quotes.get_or_insert_default();
        std::mem::swap(line, &mut self.octets);
        line.push(b'\n');
        // Each value has a comma behind it.
        self.octets.clear();
        self.octets.resize(line.len(), 0);
        splitter.reset();
        let mut rest = line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line);
        let mut end = 0;
        loop {
            let unblanked = rest.trim_ascii_start();
            if unblanked.first() == Some(&QUOTE) {
                rest = unblanked;
            }
            let (read, taken, written) = splitter.read_field(rest, &mut self.octets[end..]);
            let ReadFieldResult::Field { record_end } = read else {
                return false;
            };
            rest = &rest[taken..];
            end += written;
            self.ends.push(end);
            if record_end {
                self.octets.truncate(end);
                return true;
            }
            self.octets[end] = b',';
            end += 1;
        }
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
    #[inline]
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

    fn values(line: &str) -> Vec<String> {
        let mut row = Row::default();
        assert_eq!(row.read(&mut line.as_bytes()).unwrap(), RowRead::Whole, "{line:?}");
        row.iter()
            .map(|value| String::from_utf8(value.to_vec()).unwrap())
            .collect()
    }

    #[test]
    fn quotes_are_taken_off() {
        for (line, expected) in [
            ("\"a\",\"b c\",3\r\n", &["a", "b c", "3\r"][..]),
            ("1,\"MV \"\"X\"\", LE HAVRE\", 2", &["1", "MV \"X\", LE HAVRE", " 2"]),
            (" \"1\" ,\"\",\t\"2\"\r\n", &["1 ", "", "2\r"]),
            ("\u{feff}\"time_s\",\"x\"\n", &["time_s", "x"]),
            // A mark within a value, and quotes that end before their value does.
            ("5\" gun,1\n", &["5\" gun", "1"]),
            ("\"a\"b,c\n", &["ab", "c"]),
            ("\"\"\n", &[""]),
            ("\"a\",\n", &["a", ""]),
            ("\"a\"", &["a"]),
        ] {
            assert_eq!(values(line), expected, "{line:?}");
        }
    }

    #[test]
    fn quotes_without_an_end_hide_no_line() {
        let mut row = Row::default();
        let mut input = &b"1,\"a\n\"b\",\"2\n\"c\",3\n4,5\n"[..];
        for expected in [RowRead::Unclosed, RowRead::Unclosed, RowRead::Whole] {
            assert_eq!(row.read(&mut input).unwrap(), expected);
        }
        assert!(row.iter().eq([&b"c"[..], b"3"]));
        assert_eq!(row.read(&mut input).unwrap(), RowRead::Whole);
        assert!(row.iter().eq([&b"4"[..], b"5"]));
    }

    proptest! {
        #[test]
        fn quoted_values_are_read_back(texts in prop::collection::vec("[a-z,\" ]{0,6}", 1..6)) {
            let line: Vec<String> = texts.iter().map(|text| format!("\"{}\"", text.replace('"', "\"\""))).collect();
            prop_assert_eq!(values(&line.join(",")), texts);
        }

        #[test]
        fn values_end_at_commas(octets in prop::collection::vec(prop::sample::select(b",,-+\xac\x2dx0".to_vec()), 0..40)) {
            let mut row = Row::default();
            prop_assert_eq!(row.read(&mut &octets[..]).unwrap() == RowRead::End, octets.is_empty());
            let values: Vec<_> = row.iter().map(<[u8]>::to_vec).collect();
            let expected: Vec<_> = octets.split(|octet| *octet == b',').map(<[u8]>::to_vec).collect();
            prop_assert!(octets.is_empty() || values == expected);
        }
    }
}

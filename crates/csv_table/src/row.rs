//! A line of a table, divided at its commas.
//!
//! Few lines have a quotation mark: spreadsheets put one around texts with commas, and some programs around every
//! value. One search for a mark per line costs less than a splitter that looks for it at each octet, as those of
//! libraries do. A line with a mark is rewritten without its quotes.

use std::io::{self, BufRead};

/// The mark that some programs write before a text in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

const QUOTE: u8 = b'"';

/// Appends the value in quotation marks at the begin of `text`, without them, and returns what follows it: a comma, or
/// nothing. `None` if no such value is there.
fn quoted<'t>(text: &'t [u8], value: &mut Vec<u8>) -> Option<&'t [u8]> {
    let mut rest = text.trim_ascii_start().strip_prefix(&[QUOTE])?;
    loop {
        let end = rest.iter().position(|octet| *octet == QUOTE)?;
        value.extend_from_slice(&rest[..end]);
        rest = &rest[end + 1..];
        match rest {
            [QUOTE, behind @ ..] => {
                value.push(QUOTE);
                rest = behind;
            }
            _ => break,
        }
    }
    let rest = rest.trim_ascii_start();
    matches!(rest, [] | [b',', ..]).then_some(rest)
}

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
        // Without an early end, many octets are compared at once.
        let has_quote = self.octets.iter().fold(false, |found, octet| found | (*octet == QUOTE));
        match has_quote {
            true => self.unquote(),
            false => self.find_ends(),
        }
        Ok(true)
    }

    /// Divides a line with quotation marks, and takes the quotes off (RFC 4180). A mark that does not begin a value, or
    /// has no end in its line, is a letter as others: it must not hide the lines behind it.
    #[cold]
    fn unquote(&mut self) {
        let line = std::mem::take(&mut self.octets);
        let mut rest = line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&line);
        loop {
            let begin = self.octets.len();
            rest = quoted(rest, &mut self.octets).unwrap_or_else(|| {
                self.octets.truncate(begin);
                let end = rest.iter().position(|octet| *octet == b',').unwrap_or(rest.len());
                self.octets.extend_from_slice(&rest[..end]);
                &rest[end..]
            });
            self.ends.push(self.octets.len());
            match rest {
                [_, behind @ ..] => rest = behind,
                [] => return,
            }
            self.octets.push(b',');
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
        row.read(&mut line.as_bytes()).unwrap();
        row.iter()
            .map(|value| String::from_utf8(value.to_vec()).unwrap())
            .collect()
    }

    #[test]
    fn quotes_are_taken_off() {
        for (line, expected) in [
            ("\"a\",\"b c\",3\r\n", &["a", "b c", "3\r"][..]),
            ("1,\"MV \"\"X\"\", LE HAVRE\", 2", &["1", "MV \"X\", LE HAVRE", " 2"]),
            (" \"1\" ,\"\",\t\"2\"\r\n", &["1", "", "2"]),
            ("\u{feff}\"time_s\",\"x\"\n", &["time_s", "x"]),
            // No quotes: a mark within a value, one without an end, and one that ends before its value does.
            ("5\" gun,1\n", &["5\" gun", "1"]),
            ("\"a,b\n", &["\"a", "b"]),
            ("\"a\"b,c\n", &["\"a\"b", "c"]),
        ] {
            assert_eq!(values(line), expected, "{line:?}");
        }
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
            prop_assert_eq!(row.read(&mut &octets[..]).unwrap(), !octets.is_empty());
            let values: Vec<_> = row.iter().map(<[u8]>::to_vec).collect();
            let expected: Vec<_> = octets.split(|octet| *octet == b',').map(<[u8]>::to_vec).collect();
            prop_assert!(octets.is_empty() || values == expected);
        }
    }
}

//! Numbers of few digits, from bytes.
//!
//! A whole number up to 2^53 and a power of ten up to 10^22 are exact as `f64`, and their quotient is rounded once. It
//! is therefore the same as that of `str::parse`, which must also accept exponents, and numbers of any length.

/// Most octets after the sign: 18 digits fit into 64 bits, and a point.
const OCTETS_MAX: usize = 19;
/// Greatest whole number up to which each one is exact.
const EXACT_MAX: u64 = 1 << f64::MANTISSA_DIGITS;
/// Exact powers of ten.
const TENS: [f64; OCTETS_MAX] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
];

/// Returns the value of digits with an optional minus sign and an optional point; `None` for other texts, and for
/// numbers whose value needs more care.
#[inline]
pub(crate) fn simple(text: &[u8]) -> Option<f64> {
    // Half of a covariance.
    if text == b"0.0000" {
        return Some(0.0);
    }
    let (is_negative, text) = match text {
        [b'-', text @ ..] => (true, text),
        _ => (false, text),
    };
    let (whole, decimals) = match text.len() {
        4..=8 => short(text)?,
        _ => long(text)?,
    };
    let value = whole as f64 / TENS[decimals];
    Some(if is_negative { -value } else { value })
}

/// Digits with an optional point, of 4 to 8 octets, as a whole number and its decimals: all octets at once.
#[inline]
fn short(text: &[u8]) -> Option<(u64, usize)> {
    const POINTS: u64 = u64::from_le_bytes([b'.'; 8]);
    const LOW: u64 = u64::from_le_bytes([0x7f; 8]);
    const ZEROS: u64 = u64::from_le_bytes([b'0'; 8]);
    const UPPER: u64 = u64::from_le_bytes([0xf0; 8]);
    const SIX: u64 = u64::from_le_bytes([6; 8]);
    let (first, last) = (text.first_chunk()?, text.last_chunk()?);
    let [first, last] = [first, last].map(|octets| u64::from(u32::from_le_bytes(*octets)));
    // The last octet highest, zeros below the first: the halves overlap where there are less than eight.
    let missing = 8 * (8 - text.len());
    let mut octets = last << 32 | first << missing;
    // An octet is now zero where a point was; adding to its lower bits carries into its highest bit unless they are.
    let others = (octets ^ POINTS) | ((1 << missing) - 1);
    let points = !(((others & LOW) + LOW) | others | LOW);
    let mut decimals = 0;
    if points != 0 {
        // Octets below the point move up into its place.
        let at = points.trailing_zeros() / 8;
        let above = (u64::MAX << (8 * at)) << 8;
        octets = octets & above | (octets << 8) & !above;
        decimals = 7 - at as usize;
    }
    let empty = missing + if points == 0 { 0 } else { 8 };
    let octets = octets | (ZEROS & ((1 << empty) - 1));
    // A digit has the upper bits of zero, as it is and with 6 added; a carry comes from an octet that has others.
    let uppers = [octets, octets.wrapping_add(SIX)].map(|octets| octets & UPPER ^ ZEROS);
    if uppers != [0; 2] {
        return None;
    }
    let digits = octets - ZEROS;
    // Neighbours to numbers of two digits, of four, of eight; the first octet has the highest place.
    let pairs = (digits * 10 + (digits >> 8)) & 0x00ff_00ff_00ff_00ff;
    let fours = (pairs * 100 + (pairs >> 16)) & 0x0000_ffff_0000_ffff;
    let whole = (fours * 10_000 + (fours >> 32)) & 0xffff_ffff;
    Some((whole, decimals))
}

/// Digits with an optional point, of any length, as a whole number and its decimals.
fn long(text: &[u8]) -> Option<(u64, usize)> {
    if text.len() > OCTETS_MAX {
        return None;
    }
    let (whole, rest) = digits(0, text);
    let (whole, decimals) = match rest {
        [] => (whole, 0),
        [b'.', decimals @ ..] => match digits(whole, decimals) {
            (whole, []) => (whole, decimals.len()),
            _ => return None,
        },
        _ => return None,
    };
    let has_digits = text.len() > usize::from(!rest.is_empty());
    (has_digits && whole <= EXACT_MAX).then_some((whole, decimals))
}

/// Returns the whole number that the digits are; `None` for other texts, and for more digits than fit.
pub(crate) fn whole(text: &[u8]) -> Option<u64> {
    let is_short = (1..=OCTETS_MAX).contains(&text.len());
    match digits(0, if is_short { text } else { &[] }) {
        (number, []) if is_short => Some(number),
        _ => None,
    }
}

/// Appends the digits before anything else to a number, and gives it and what follows the digits.
#[inline]
fn digits(mut number: u64, mut text: &[u8]) -> (u64, &[u8]) {
    while let [digit @ b'0'..=b'9', rest @ ..] = text {
        number = 10 * number + u64::from(digit - b'0');
        text = rest;
    }
    (number, text)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn agrees(text: &str) -> bool {
        match simple(text.as_bytes()) {
            Some(value) => text.parse::<f64>().map(f64::to_bits) == Ok(value.to_bits()),
            None => true,
        }
    }

    #[test]
    fn common_numbers_are_read_here_and_others_left_alone() {
        let read = [
            "0",
            "-0",
            "-0.000",
            "5.",
            ".5",
            "-12.5",
            "0001.50",
            "9007199254740992",
            "0.00000000000000001",
        ];
        for text in read {
            assert!(simple(text.as_bytes()).is_some() && agrees(text), "{text}");
        }
        let left = [
            "",
            "-",
            ".",
            "-.",
            "--1",
            "+1",
            "1e3",
            "inf",
            "NaN",
            "1..2",
            "1 ",
            "9007199254740993",
            "1_0",
            "12345678901234567890",
            "1.2.3",
            "....",
            "12:4",
            "12/4567",
            "1.23-5",
            "\u{ff}1234",
            "1234\u{e9}",
        ];
        for text in left {
            assert_eq!(simple(text.as_bytes()), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn values_are_those_of_the_standard_library(text in "-?[0-9]{0,12}[.]?[0-9]{0,12}") {
            prop_assert!(agrees(&text));
        }

        #[test]
        fn short_texts_are_read_if_they_are_digits(octets in prop::collection::vec(any::<u8>(), 1..9), text in "[0-9.:/-]{1,9}") {
            for octets in [&octets[..], text.as_bytes()] {
                let unsigned = octets.strip_prefix(b"-").unwrap_or(octets);
                let points = unsigned.iter().filter(|octet| **octet == b'.').count();
                let digits = unsigned.iter().filter(|octet| octet.is_ascii_digit()).count();
                let is_number = digits > 0 && points <= 1 && digits + points == unsigned.len();
                prop_assert_eq!(simple(octets).is_some(), is_number, "{:?}", octets);
            }
        }

        #[test]
        fn whole_numbers_are_those_of_the_standard_library(text in "[+-]?[0-9]{0,22}[ .]?") {
            if let Some(number) = whole(text.as_bytes()) {
                prop_assert_eq!(text.parse::<u64>(), Ok(number));
            }
        }

        #[test]
        fn written_numbers_are_read_back(value in any::<f64>(), decimals in 0_usize..9) {
            let rounded = format!("{value:.decimals$}");
            prop_assert!(agrees(&rounded) && agrees(&value.to_string()));
        }
    }
}

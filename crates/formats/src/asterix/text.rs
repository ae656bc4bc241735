//! Characters as ASTERIX packs them.
//!
//! The six-bit alphabet of Mode S (ICAO Annex 10 volume IV, 3.1.2.9) has letters, digits and the space; 27 of its
//! 64 codes stand for nothing, and transponders do send them: all zero where no identification was set. Leaving
//! such a code out, as some decoders do, moves the characters behind it and makes another call sign; so each is
//! shown as [`UNDEFINED`], and the number of characters stays what it was. Trailing spaces stay as well: they are
//! what was sent.

use super::bits::bits;
use super::table::TextCoding;

/// Stands for a code without a character.
pub const UNDEFINED: char = char::REPLACEMENT_CHARACTER;

/// The character of a six-bit code; only the low six bits count.
pub const fn icao_character(code: u8) -> Option<u8> {
    match code & 0x3F {
        letter @ 0x01..=0x1A => Some(b'A' - 1 + letter),
        0x20 => Some(b' '),
        digit @ 0x30..=0x39 => Some(digit),
        _ => None,
    }
}

/// The six-bit code of a character.
pub const fn icao_code(character: u8) -> Option<u8> {
    match character {
        b'A'..=b'Z' => Some(character - b'A' + 1),
        b' ' | b'0'..=b'9' => Some(character),
        _ => None,
    }
}

/// The characters in `width` bits from bit `at` on.
pub(super) fn decode(coding: TextCoding, bytes: &[u8], at: usize, width: usize) -> String {
    let bits_each = match coding {
        TextCoding::Ascii => 8,
        TextCoding::Icao => 6,
        TextCoding::Octal => 3,
    };
    let character = |i: usize| {
        let code = bits(bytes, at + i * bits_each, bits_each) as u8;
        match coding {
            TextCoding::Ascii => (code == b' ' || code.is_ascii_graphic()).then_some(code),
            TextCoding::Icao => icao_character(code),
            TextCoding::Octal => Some(b'0' + code),
        }
        .map_or(UNDEFINED, char::from)
    };
    (0..width / bits_each).map(character).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_bit_codes_without_a_character_keep_their_place() {
        // I, B, undefined, 3, Z, R, space, space
        let codes = [0x09, 0x02, 0x00, 0x33, 0x1A, 0x12, 0x20, 0x20];
        let packed = codes.iter().fold(0u64, |packed, &code| packed << 6 | code) << 16;
        assert_eq!(
            decode(TextCoding::Icao, &packed.to_be_bytes(), 0, 48),
            "IB\u{FFFD}3ZR  "
        );
    }

    #[test]
    fn octal_digits_are_three_bits_each() {
        assert_eq!(decode(TextCoding::Octal, &[0x0B, 0x65], 4, 12), "5545");
    }

    #[test]
    fn ascii_shows_control_and_eight_bit_codes_as_undefined() {
        assert_eq!(decode(TextCoding::Ascii, b"A \x07\xE9", 0, 32), "A \u{FFFD}\u{FFFD}");
    }

    #[test]
    fn every_six_bit_character_has_its_code() {
        for code in 0..64 {
            if let Some(character) = icao_character(code) {
                assert_eq!(icao_code(character), Some(code));
            }
        }
        assert_eq!((0..=u8::MAX).filter_map(icao_code).count(), 64 - 27);
    }

    #[test]
    fn twenty_seven_six_bit_codes_are_undefined() {
        assert_eq!((0..64).filter(|&code| icao_character(code).is_none()).count(), 27);
    }
}

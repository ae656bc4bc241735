//! Characters as ASTERIX packs them.
//!
//! The six-bit alphabet of Mode S (ICAO Annex 10 volume IV, 3.1.2.9) has letters, digits and the space; 27 of its 64
//! codes are undefined, but transponders send them, for example all zeros without an identification. Omitting such a
//! code, as some decoders do, would shift the later characters and make another call sign. Therefore each undefined
//! code is shown as [`UNDEFINED`], and the number of characters is kept. Trailing spaces are also kept.

use super::bits::{bits, put};
use super::encode_error::EncodeFault;
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
    let bits_each = bits_each(coding);
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

/// Writes a text into `width` bits of zeros from bit `at` on, filled up with spaces where the coding has one.
pub(super) fn encode(
    coding: TextCoding,
    text: &str,
    bytes: &mut [u8],
    at: usize,
    width: usize,
) -> Result<(), EncodeFault> {
    let bits_each = bits_each(coding);
    let greatest = width / bits_each;
    let least = if coding == TextCoding::Octal { greatest } else { 0 };
    let characters = text.chars().count();
    if !(least..=greatest).contains(&characters) {
        return Err(EncodeFault::TextLength {
            text: text.to_owned(),
            characters,
            least,
            greatest,
        });
    }
    let filled = text.chars().chain(std::iter::repeat(' ')).take(greatest);
    for (i, character) in filled.enumerate() {
        let code = code(coding, character).ok_or_else(|| EncodeFault::Character {
            text: text.to_owned(),
            character,
            coding,
        })?;
        put(bytes, at + i * bits_each, bits_each, u64::from(code));
    }
    Ok(())
}

fn code(coding: TextCoding, character: char) -> Option<u8> {
    let character = u8::try_from(character).ok()?;
    match coding {
        TextCoding::Ascii => (character == b' ' || character.is_ascii_graphic()).then_some(character),
        TextCoding::Icao => icao_code(character),
        TextCoding::Octal => matches!(character, b'0'..=b'7').then(|| character - b'0'),
    }
}

pub(super) fn bits_each(coding: TextCoding) -> usize {
    match coding {
        TextCoding::Ascii => 8,
        TextCoding::Icao => 6,
        TextCoding::Octal => 3,
    }
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
    fn a_text_is_filled_up_with_spaces() {
        let mut bytes = [0; 6];
        encode(TextCoding::Icao, "IBK3ZR", &mut bytes, 0, 48).unwrap();
        assert_eq!(decode(TextCoding::Icao, &bytes, 0, 48), "IBK3ZR  ");
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

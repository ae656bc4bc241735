//! Spelling of identities in text: one writer and one reader for every file, line and page.
//!
//! Samples hold numbers. People, and the programs that serve them, write a Mode 3/A code in octal digits, an aircraft
//! address in hexadecimal digits and an MMSI in decimal digits. The same number in another base is another target's:
//! the code 2300 is the number 1216, and 1216 is a code, too. Text therefore never has the numbers of the samples, but
//! strings with all digits, under the keys `address`, `mmsi` and `mode_3a`.
//!
//! Reading accepts small letters, and fewer digits: tables lose leading zeros.

use std::fmt;

use crate::{Identity, identity_bits};

/// Spelling of one kind of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IdentityText {
    /// Key or column in text.
    pub key: &'static str,
    /// Digits of a number in text.
    pub digits: usize,
    /// Base of the digits.
    pub radix: u32,
    /// Largest number.
    pub max: u32,
    /// What the text is, for messages.
    pub form: &'static str,
    /// A text.
    pub example: &'static str,
    /// A regular expression that exactly the written texts match.
    pub pattern: &'static str,
}

/// A number as it is written, with all its digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spelled {
    number: u32,
    radix: u32,
}

impl IdentityText {
    /// 24-bit aircraft address: `4CA7B3`.
    pub const ADDRESS: Self = Self {
        key: "address",
        digits: 6,
        radix: 16,
        max: (1 << 24) - 1,
        form: "an address of up to six hexadecimal digits",
        example: "3C6589",
        pattern: "^[0-9A-F]{6}$",
    };
    /// Maritime Mobile Service Identity: `211234560`.
    pub const MMSI: Self = Self {
        key: "mmsi",
        digits: 9,
        radix: 10,
        max: 999_999_999,
        form: "an MMSI of nine digits; if zeros come first, at most two, 2 to 7 follows",
        example: "211234560",
        pattern: "^[0-9]{9}$",
    };
    /// Mode 3/A code: `7421`.
    pub const MODE_3A: Self = Self {
        key: "mode_3a",
        digits: 4,
        radix: 8,
        max: 0o7777,
        form: "a Mode 3/A code of up to four octal digits",
        example: "7000",
        pattern: "^[0-7]{4}$",
    };
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::ADDRESS, Self::MMSI, Self::MODE_3A];

    /// Returns the number of a text; `None` if the text is not of this [form](Self::form).
    pub fn read(&self, text: &str) -> Option<u32> {
        let is_plain = text.len() <= self.digits && text.chars().all(|character| character.is_digit(self.radix));
        let number = is_plain.then(|| u32::from_str_radix(text, self.radix).ok())?;
        number.filter(|number| *number <= self.max)
    }

    /// Returns the text of a number; `None` for a number that is too large.
    #[inline]
    pub fn write(&self, number: u32) -> Option<Spelled> {
        let radix = self.radix;
        (number <= self.max).then_some(Spelled { number, radix })
    }

    /// Returns whether a target of this kind can have this number. Of the nine digits of an MMSI, those of a group of
    /// ships begin with one zero, those of a coast station with two; the country follows, whose first digit is 2 to 7
    /// (ITU-R M.585). Samples of others may have any number, and are written and read back.
    pub fn is_possible(&self, number: u32) -> bool {
        match (self.radix, number) {
            (10, 0..=99_999_999) => {
                let digits = number.checked_ilog10().unwrap_or_default();
                digits >= 6 && (2..=7).contains(&(number / 10u32.pow(digits)))
            }
            _ => number <= self.max,
        }
    }

    /// Returns the value of this kind in an identity, as text.
    pub fn of(&self, identity: &Identity) -> Option<Spelled> {
        let number = match self.radix {
            16 => identity.address(),
            10 => identity.mmsi(),
            _ => identity.mode_3a().map(u32::from),
        };
        self.write(number?)
    }

    /// Sets the value of this kind in an identity; a code too large for a sample is cut.
    pub fn set(&self, identity: Identity, number: u32) -> Identity {
        match self.radix {
            16 => identity.with_address(number),
            10 => identity.with_mmsi(number),
            _ => identity.with_mode_3a(number as u16),
        }
    }
}

impl fmt::Display for Spelled {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.radix {
            16 => write!(formatter, "{:06X}", self.number),
            10 => write!(formatter, "{:09}", self.number),
            _ => write!(formatter, "{:04o}", self.number),
        }
    }
}

impl Identity {
    /// Returns the aircraft address in hexadecimal digits, if known.
    #[inline]
    pub fn address_text(&self) -> Option<Spelled> {
        IdentityText::ADDRESS.write(self.address()?)
    }

    /// Returns the MMSI in decimal digits, if known.
    #[inline]
    pub fn mmsi_text(&self) -> Option<Spelled> {
        IdentityText::MMSI.write(self.mmsi()?)
    }

    /// Returns the Mode 3/A code in octal digits, if known.
    #[inline]
    pub fn mode_3a_text(&self) -> Option<Spelled> {
        IdentityText::MODE_3A.write(self.mode_3a()?.into())
    }

    /// Returns a number that is too large for its kind, before it the name of the field and behind it the limit.
    pub(crate) fn unspelled(&self) -> Option<(&'static str, u32, &'static str)> {
        if let Some(address) = self.address().filter(|address| *address > IdentityText::ADDRESS.max) {
            return Some(("identity.address", address, "must be an address of 24 bits"));
        }
        if let Some(mmsi) = self.mmsi().filter(|mmsi| *mmsi > IdentityText::MMSI.max) {
            return Some(("identity.address", mmsi, "must be an MMSI of up to nine digits"));
        }
        let is_code = self.valid & identity_bits::MODE_3A != 0;
        (is_code && u32::from(self.mode_3a) > IdentityText::MODE_3A.max).then(|| {
            let limit = "must be a Mode 3/A code of twelve bits";
            ("identity.mode_3a", self.mode_3a.into(), limit)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of all classes: each power of two with its neighbours, the limits, and a walk with a large prime step.
    fn classes(end: u32) -> impl Iterator<Item = u32> {
        let powers = (0..32).flat_map(|bit| [(1u32 << bit).wrapping_sub(1), 1 << bit, (1 << bit) + 1]);
        let walk = (0..end).step_by(104_729);
        powers.chain(walk).chain([end - 1]).filter(move |number| *number < end)
    }

    fn goes_round(text: IdentityText, number: u32) {
        let Some(spelled) = text.write(number) else {
            assert!(number > text.max, "{number}");
            return;
        };
        let spelled = spelled.to_string();
        assert_eq!(
            (spelled.len(), text.read(&spelled)),
            (text.digits, Some(number)),
            "{spelled}"
        );
        let identity = text.set(Identity::default().with_callsign(*b"KOS1    "), number);
        assert_eq!(text.of(&identity).map(|text| text.to_string()), Some(spelled));
        let others = IdentityText::ALL.iter().filter(|other| other.radix != text.radix);
        assert!(
            others.map(|other| other.of(&identity)).all(|other| other.is_none()),
            "{number}"
        );
    }

    #[test]
    fn every_code_and_numbers_of_all_classes_are_read_as_they_are_written() {
        (0..1 << 12).for_each(|code| goes_round(IdentityText::MODE_3A, code));
        classes(1 << 24).for_each(|address| goes_round(IdentityText::ADDRESS, address));
        classes(1 << 30).for_each(|mmsi| goes_round(IdentityText::MMSI, mmsi));
    }

    #[test]
    #[ignore = "takes minutes: all 2^24 addresses and all 2^30 numbers of ships"]
    fn every_address_and_every_mmsi_is_read_as_it_is_written() {
        (0..1 << 24).for_each(|address| goes_round(IdentityText::ADDRESS, address));
        (0..1 << 30).for_each(|mmsi| goes_round(IdentityText::MMSI, mmsi));
    }

    #[test]
    fn an_mmsi_with_zeros_before_it_is_of_a_country() {
        for (number, is_possible) in [
            (2_275_400, true),
            (23_456_789, true),
            (111_232_001, true),
            (0, false),
            (999_999, false),
            (1_193_046, false),
            (8_000_000, false),
            (12_345_678, false),
            (1_000_000_000, false),
        ] {
            assert_eq!(IdentityText::MMSI.is_possible(number), is_possible, "{number}");
        }
        assert!(IdentityText::ADDRESS.is_possible(5) && !IdentityText::MODE_3A.is_possible(0o10000));
    }

    #[test]
    fn what_is_none_of_the_numbers_is_not_read() {
        for (text, wrong) in [
            (IdentityText::ADDRESS, "4CA7B3F"),
            (IdentityText::ADDRESS, "0x4CA7"),
            (IdentityText::ADDRESS, "+4CA7B"),
            (IdentityText::ADDRESS, ""),
            (IdentityText::MMSI, "1073741823"),
            (IdentityText::MMSI, "21123456A"),
            (IdentityText::MODE_3A, "7800"),
            (IdentityText::MODE_3A, "12300"),
            (IdentityText::MODE_3A, " 700"),
        ] {
            assert_eq!(text.read(wrong), None, "{wrong}");
        }
        for (text, short, number) in [
            (IdentityText::ADDRESS, "3c6589", 0x3c_6589),
            (IdentityText::MODE_3A, "21", 0o21),
            (IdentityText::MMSI, "2275400", 2_275_400),
        ] {
            assert_eq!(text.read(short), Some(number), "{short}");
        }
    }

    #[test]
    fn examples_and_patterns_are_of_their_numbers() {
        for text in IdentityText::ALL {
            let number = text.read(text.example).unwrap();
            assert_eq!(text.write(number).unwrap().to_string(), text.example);
            assert!(
                text.pattern.contains(&format!("{{{}}}", text.digits)),
                "{}",
                text.pattern
            );
        }
    }
}

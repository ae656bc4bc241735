//! Text of JSON that is written piece by piece: keys, numbers and quantities.
//!
//! The text has room behind it, so that a piece is written in place: a key is a copy of constant length, and a few
//! digits are a store. Most quantities are a small number times 2^-n: [`short`] finds their decimals in whole numbers.

use std::io::{self, Write};

use crate::key::{KEY_OCTETS, Key};

/// Most binary places of a quantity that [`short`] writes: 2^-13 is not yet written with an exponent.
const PLACES_MAX: usize = 13;
/// Most decimal digits that no other number of so many digits shares its `f64` with.
const DIGITS_MAX: u32 = 15;
/// By binary places: the power of five, and the least whole number with too many digits beside the decimals.
const POWERS: [(u64, u64); PLACES_MAX + 1] = powers();
/// Two digits each, from 00 to 99.
const PAIRS: [[u8; 2]; 100] = pairs();
/// Most octets of a [`Piece`]: a key, a number with sign, point and decimals, and a comma.
const PIECE_OCTETS: usize = 64;

/// Text, and room behind it.
#[derive(Debug, Default)]
pub(super) struct JsonText {
    octets: Vec<u8>,
    /// Octets of the text.
    length: usize,
}

impl JsonText {
    /// The text.
    pub(super) fn text(&self) -> &[u8] {
        &self.octets[..self.length]
    }

    /// Forgets the text.
    pub(super) fn clear(&mut self) {
        self.length = 0;
    }

    /// Ends an object or a list in the place of its last comma, and appends a comma.
    #[inline(always)]
    pub(super) fn end(&mut self, bracket: u8) {
        let last = self.length - 1;
        if self.octets[last] == b',' {
            self.length = last;
        }
        let mut piece = self.piece(None);
        piece.pair_of([bracket, b',']);
        piece.end();
    }

    /// Replaces the last comma by a line end.
    pub(super) fn end_line(&mut self) {
        self.octets[self.length - 1] = b'\n';
    }

    /// Begins a piece, with a key if there is one.
    #[inline(always)]
    pub(super) fn piece(&mut self, key: Option<&Key>) -> Piece<'_> {
        if self.octets[self.length..].len() < PIECE_OCTETS {
            self.grow(PIECE_OCTETS);
        }
        let Self { octets, length } = self;
        let octets: &mut [u8; PIECE_OCTETS] = octets[*length..].first_chunk_mut().expect("room");
        let at = key.map_or(0, |key| {
            octets[..KEY_OCTETS].copy_from_slice(&key.text);
            usize::from(key.length)
        });
        Piece { octets, at, length }
    }

    /// Appends an octet, with a key before it if there is one.
    #[inline(always)]
    pub(super) fn begin(&mut self, key: Option<&Key>, octet: u8) {
        let mut piece = self.piece(key);
        piece.octet(octet);
        piece.end();
    }

    #[inline(always)]
    pub(super) fn octet(&mut self, octet: u8) {
        self.begin(None, octet);
    }

    pub(super) fn append(&mut self, text: &[u8]) {
        if self.octets.len() - self.length < text.len() {
            self.grow(text.len());
        }
        self.octets[self.length..self.length + text.len()].copy_from_slice(text);
        self.length += text.len();
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self, octets: usize) {
        self.octets.resize(2 * self.octets.len() + octets + PIECE_OCTETS, 0);
    }
}

impl Write for JsonText {
    fn write(&mut self, text: &[u8]) -> io::Result<usize> {
        self.append(text);
        Ok(text.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
/// Text of limited length behind that of [`JsonText`], to which [`Piece::end`] adds it.
pub(super) struct Piece<'t> {
    octets: &'t mut [u8; PIECE_OCTETS],
    at: usize,
    length: &'t mut usize,
}

impl Piece<'_> {
    #[inline(always)]
    pub(super) fn end(self) {
        *self.length += self.at;
    }

    #[inline(always)]
    pub(super) fn octet(&mut self, octet: u8) {
        self.octets[self.at] = octet;
        self.at += 1;
    }

    #[inline(always)]
    pub(super) fn sign(&mut self, is_negative: bool) {
        if is_negative {
            self.octet(b'-');
        }
    }

    /// Writes characters of `BITS` each, the first in the highest of the `width` bits. Gives `false` if one is zero.
    #[inline(always)]
    pub(super) fn characters<const BITS: u32>(&mut self, codes: u64, width: u8, character: impl Fn(u8) -> u8) -> bool {
        let mut is_whole = true;
        let mut behind = u32::from(width);
        for octet in &mut self.octets[self.at..self.at + (u32::from(width) / BITS) as usize] {
            behind -= BITS;
            *octet = character((codes >> behind) as u8 & (u8::MAX >> (8 - BITS)));
            is_whole &= *octet != 0;
        }
        self.at += (u32::from(width) / BITS) as usize;
        is_whole
    }

    #[inline(always)]
    pub(super) fn whole(&mut self, number: u64) {
        match number {
            0..10 => self.octet(b'0' + number as u8),
            10..100 => self.pair(number),
            100..1_000 => {
                self.octet(b'0' + (number / 100) as u8);
                self.pair(number % 100);
            }
            1_000..10_000 => {
                self.pair(number / 100);
                self.pair(number % 100);
            }
            _ => self.digits(number, number.ilog10() as usize + 1),
        }
    }

    pub(super) fn append(&mut self, text: &[u8]) {
        self.octets[self.at..self.at + text.len()].copy_from_slice(text);
        self.at += text.len();
    }

    /// Writes a number below 100 as two digits.
    #[inline(always)]
    pub(super) fn pair(&mut self, number: u64) {
        self.pair_of(PAIRS[number as usize]);
    }

    #[inline(always)]
    pub(super) fn pair_of(&mut self, pair: [u8; 2]) {
        self.octets[self.at..self.at + 2].copy_from_slice(&pair);
        self.at += 2;
    }

    /// Writes so many digits, with zeros before the number.
    pub(super) fn digits(&mut self, mut number: u64, count: usize) {
        let digits = &mut self.octets[self.at..self.at + count];
        self.at += count;
        let mut pairs = digits.rchunks_exact_mut(2);
        for pair in pairs.by_ref() {
            pair.copy_from_slice(&PAIRS[(number % 100) as usize]);
            number /= 100;
        }
        if let [first] = pairs.into_remainder() {
            *first = b'0' + (number % 10) as u8;
        }
    }
}

/// Writes `magnitude` × `lsb` where that is a short binary fraction; otherwise writes nothing and gives `false`.
///
/// m / 2^n has exactly n decimals if m is odd: m × 5^n / 10^n. With at most 15 digits, no shorter decimal number has
/// the same `f64`, and so these are the digits of every writer that finds the shortest.
#[inline(always)]
pub(super) fn short(piece: &mut Piece<'_>, is_negative: bool, magnitude: u64, lsb: f64) -> bool {
    // More places than a whole number has bits: no short fraction. Of 0, more would be left than are written.
    let Some((factor, mut places)) = fraction(lsb).filter(|(_, places)| *places < u64::BITS) else {
        return false;
    };
    let Some(mut number) = magnitude.checked_mul(factor) else {
        return false;
    };
    let unneeded = number.trailing_zeros().min(places);
    number = number.checked_shr(unneeded).unwrap_or(0);
    places -= unneeded;
    let Some((five, limit)) = POWERS.get(places as usize) else {
        return false;
    };
    let whole = number >> places;
    if whole >= *limit {
        return false;
    }
    piece.sign(is_negative);
    piece.whole(whole);
    piece.octet(b'.');
    let decimals = five * (number & ((1 << places) - 1));
    match places {
        0 | 1 => piece.octet(b'0' + decimals as u8),
        2 => piece.pair(decimals),
        _ => piece.digits(decimals, places as usize),
    }
    true
}

/// Gives whole numbers m and n with `value` = m / 2^n, m odd; `None` where there are none for a positive `value`.
#[inline(always)]
fn fraction(value: f64) -> Option<(u64, u32)> {
    const FRACTION_BITS: u32 = f64::MANTISSA_DIGITS - 1;
    const BIAS: u32 = 1023;
    let mantissa = value.to_bits() & ((1 << FRACTION_BITS) - 1) | 1 << FRACTION_BITS;
    let unneeded = mantissa.trailing_zeros();
    let places = (BIAS + FRACTION_BITS).checked_sub((value.to_bits() >> FRACTION_BITS) as u32 + unneeded)?;
    Some((mantissa >> unneeded, places))
}

const fn powers() -> [(u64, u64); PLACES_MAX + 1] {
    let mut powers = [(0, 0); PLACES_MAX + 1];
    let mut places = 0;
    while places <= PLACES_MAX {
        powers[places] = (5_u64.pow(places as u32), 10_u64.pow(DIGITS_MAX - places as u32));
        places += 1;
    }
    powers
}

const fn pairs() -> [[u8; 2]; 100] {
    let mut pairs = [[b'0'; 2]; 100];
    let mut i = 0;
    while i < 100 {
        pairs[i] = [b'0' + (i / 10) as u8, b'0' + (i % 10) as u8];
        i += 1;
    }
    pairs
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn written(is_negative: bool, magnitude: u64, lsb: f64) -> Option<String> {
        let mut lines = JsonText::default();
        let mut piece = lines.piece(None);
        let is_short = short(&mut piece, is_negative, magnitude, lsb);
        piece.end();
        is_short.then(|| String::from_utf8_lossy(lines.text()).into_owned())
    }

    proptest! {
        #[test]
        fn quantities_have_the_digits_of_serde(
            magnitude in any::<u64>(),
            bits in 0_u32..65,
            is_negative in any::<bool>(),
            factor in prop::sample::select(vec![1.0, 6.25, 45.0, 25.0, 100.0, 0.1, 1e-3, 1e-5]),
            places in 0_i32..26,
        ) {
            let (magnitude, lsb) = (magnitude.checked_shr(64 - bits).unwrap_or(0), factor * 2_f64.powi(-places));
            if let Some(text) = written(is_negative, magnitude, lsb) {
                let quantity = magnitude as f64 * if is_negative { -lsb } else { lsb };
                prop_assert_eq!(text, serde_json::to_string(&quantity).unwrap());
            }
        }

        #[test]
        fn whole_numbers_have_their_digits(number in any::<u64>(), bits in 1_u32..65) {
            let mut lines = JsonText::default();
            let mut piece = lines.piece(None);
            piece.whole(number >> (64 - bits));
            piece.end();
            prop_assert_eq!(String::from_utf8_lossy(lines.text()), (number >> (64 - bits)).to_string());
        }
    }

    #[test]
    fn usual_quantities_are_written_here() {
        let usual = [
            (false, 11_059_199, 1.0 / 128.0, "86399.9921875"),
            (true, 8_388_608, 0.5, "-4194304.0"),
            (false, 3, 6.25, "18.75"),
            (false, 0, 0.25, "0.0"),
            (false, 1, 360.0 / 65_536.0, "0.0054931640625"),
        ];
        for (is_negative, magnitude, lsb, text) in usual {
            assert_eq!(written(is_negative, magnitude, lsb).as_deref(), Some(text));
        }
        assert_eq!(written(false, 12_345_678, 180.0 / 33_554_432.0), None);
        assert_eq!(
            written(false, 0, 1e-5),
            None,
            "0 has as many decimals as any other number"
        );
    }
}

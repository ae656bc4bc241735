//! Digits of numbers, by integer arithmetic.
//!
//! A row of tracks has some forty numbers with fixed decimals. `core::fmt` writes each correctly, but works with
//! numbers of any length, and its traits cost more than the digits. A finite `f64` is `m * 2^-s` with a whole `m` below
//! 2^53. Below 2^52, its decimals are therefore the rounded quotient of the fraction's bits times a power of ten, and
//! 2^s: one product of 128 bits and a shift. Halves go to the even neighbour, as `core::fmt` does. Most products of a
//! number and the power of ten are small, and far enough from a half that one rounding of an `f64` changes nothing. The
//! text grows in registers, from its end to its beginning, and leaves them at once.
//!
//! Limits: texts beyond 16 octets, and more than nine decimals, are left to `core::fmt`.

use std::io::{self, Write};

/// Most decimals that the fast path writes.
const DECIMALS_MAX: usize = 9;
/// Powers of ten.
const TENS: [u64; 18] = {
    let mut tens = [1; 18];
    let mut place = 1;
    while place < tens.len() {
        tens[place] = 10 * tens[place - 1];
        place += 1;
    }
    tens
};
/// Half of the last decimal, by number of decimals.
const HALVES: [f64; TENS.len()] = {
    let mut halves = [0.0; TENS.len()];
    let mut decimals = 0;
    while decimals < halves.len() {
        halves[decimals] = 0.5 / TENS[decimals] as f64;
        decimals += 1;
    }
    halves
};
/// The numbers 00 to 99, two digits each.
const PAIRS: [[u8; 2]; 100] = {
    let mut pairs = [[0; 2]; 100];
    let mut number = 0;
    while number < 100 {
        pairs[number] = [b'0' + (number / 10) as u8, b'0' + (number % 10) as u8];
        number += 1;
    }
    pairs
};
/// Zero with as many decimals.
const ZERO: [u8; DECIMALS_MAX + 2] = *b"0.000000000";
/// Bits of the fraction of an `f64`.
const FRACTION_BITS: u32 = f64::MANTISSA_DIGITS - 1;
/// Most octets of a text in registers.
const TEXT_MAX: usize = u128::BITS as usize / 8;
/// End of the whole parts that fit a text beside a sign, a point and so many decimals.
const WHOLES: [u64; DECIMALS_MAX + 1] = {
    let mut wholes = [0; DECIMALS_MAX + 1];
    let mut decimals = 0;
    while decimals < wholes.len() {
        wholes[decimals] = TENS[TEXT_MAX - 2 - decimals];
        decimals += 1;
    }
    wholes
};

/// Text of up to 16 octets, in registers; it grows from its end to its beginning.
#[derive(Clone, Copy)]
struct Text {
    octets: u128,
    len: usize,
}

impl Text {
    const EMPTY: Self = Self { octets: 0, len: 0 };

    #[inline(always)]
    fn octet(&mut self, octet: u8) {
        self.octets = self.octets << 8 | u128::from(octet);
        self.len += 1;
    }

    /// Two digits of a number below 100.
    #[inline(always)]
    fn pair(&mut self, number: u64) {
        self.octets = self.octets << 16 | u128::from(u16::from_le_bytes(PAIRS[number as usize]));
        self.len += 2;
    }

    #[inline(always)]
    fn whole(&mut self, mut number: u64) {
        while number >= 100 {
            self.pair(number % 100);
            number /= 100;
        }
        if number >= 10 {
            self.pair(number);
        } else {
            self.octet(b'0' + number as u8);
        }
    }

    /// The number with leading zeros, `width` digits in all, of which it has no more.
    #[inline(always)]
    fn padded(&mut self, mut number: u64, width: usize) {
        for _ in 0..width / 2 {
            self.pair(number % 100);
            number /= 100;
        }
        if width % 2 == 1 {
            self.octet(b'0' + number as u8);
        }
    }

    #[inline(always)]
    fn write(&self, out: &mut impl Write) -> io::Result<()> {
        out.write_all(&self.octets.to_le_bytes()[..self.len])
    }
}

/// Writes a whole number.
///
/// # Errors
/// If the writer fails.
pub fn write_whole(out: &mut impl Write, number: u64) -> io::Result<()> {
    if number >= TENS[TEXT_MAX] {
        return write!(out, "{number}");
    }
    let mut text = Text::EMPTY;
    text.whole(number);
    text.write(out)
}

/// Writes a number with this many decimals, as `{:.decimals$}` does.
///
/// # Errors
/// If the writer fails.
pub fn write_decimals(out: &mut impl Write, value: f64, decimals: usize) -> io::Result<()> {
    // More than half of the elements of a covariance are often 0.
    if value.to_bits() == 0 && (1..=DECIMALS_MAX).contains(&decimals) {
        return out.write_all(&ZERO[..decimals + 2]);
    }
    let number = quickly_rounded(value, decimals).or_else(|| rounded(value, decimals));
    let wholes = WHOLES.get(decimals).copied().unwrap_or_default();
    let Some((whole, parts)) = number.filter(|(whole, _)| *whole < wholes) else {
        return write!(out, "{value:.decimals$}");
    };
    let mut text = Text::EMPTY;
    if decimals > 0 {
        text.padded(parts, decimals);
        text.octet(b'.');
    }
    text.whole(whole);
    if value.is_sign_negative() {
        text.octet(b'-');
    }
    text.write(out)
}

/// Writes a number as [`write_decimals`] does, but without a minus sign before zero.
///
/// # Errors
/// If the writer fails.
pub fn write_plain(out: &mut impl Write, value: f64, decimals: usize) -> io::Result<()> {
    let half = HALVES.get(decimals).copied().unwrap_or_default();
    write_decimals(out, if value.abs() < half { 0.0 } else { value }, decimals)
}

/// Writes a time in seconds, with as few decimals as are exact.
///
/// # Errors
/// If the writer fails.
pub fn write_time(out: &mut impl Write, ns: i64) -> io::Result<()> {
    let (whole, mut rest) = (ns.unsigned_abs() / 1_000_000_000, ns.unsigned_abs() % 1_000_000_000);
    let mut width = 9;
    while rest > 0 && rest % 10 == 0 {
        rest /= 10;
        width -= 1;
    }
    let mut text = Text::EMPTY;
    if rest > 0 {
        text.padded(rest, width);
        text.octet(b'.');
    }
    // Nine decimals, a point, five digits and a sign: all times of a day.
    if whole < TENS[5] {
        text.whole(whole);
        if ns < 0 {
            text.octet(b'-');
        }
        return text.write(out);
    }
    if ns < 0 {
        out.write_all(b"-")?;
    }
    write_whole(out, whole)?;
    text.write(out)
}

/// As [`rounded`], for products with the power of ten below 2^42 that are not near a half.
#[inline]
fn quickly_rounded(value: f64, decimals: usize) -> Option<(u64, u64)> {
    /// Products below this are off by less than 2^-11.
    const PRODUCT_MAX: f64 = (1_u64 << 42) as f64;
    /// Products farther from halves than this round as the exact ones do.
    const SURE: f64 = 0.499;
    let ten = *TENS.get(decimals)?;
    let product = value.abs() * ten as f64;
    if product.is_nan() || product >= PRODUCT_MAX {
        return None;
    }
    let parts = product as u64;
    let rest = product - parts as f64;
    let up = u64::from(rest > 0.5);
    ((rest - up as f64).abs() < SURE).then(|| divided(parts + up, ten))
}

/// Quotient and remainder; by the usual powers of ten, without a division.
#[inline(always)]
fn divided(number: u64, ten: u64) -> (u64, u64) {
    match ten {
        1_000 => (number / 1_000, number % 1_000),
        10_000 => (number / 10_000, number % 10_000),
        _ => (number / ten, number % ten),
    }
}

/// Returns the whole part of the rounded value, without its sign, and the decimals as a whole number. `None` for
/// numbers from 2^52 on, others than numbers, and more decimals than 9.
fn rounded(value: f64, decimals: usize) -> Option<(u64, u64)> {
    let ten = *TENS.get(decimals)?;
    let bits = value.to_bits() & !(1 << 63);
    let exponent = (bits >> FRACTION_BITS) as u32;
    let bias = f64::MAX_EXP as u32 - 1;
    if exponent >= bias + FRACTION_BITS {
        return None;
    }
    // A subnormal number has the exponent 1 and no hidden bit. The formula below takes it for a larger one; both are
    // zero.
    let digits = bits & ((1 << FRACTION_BITS) - 1) | 1 << FRACTION_BITS;
    // 1 to 1,075: the value is digits / 2^shift.
    let shift = bias + FRACTION_BITS - exponent;
    // Less than half of the last decimal, whatever the digits: 2^53 * 10^17 < 2^110.
    if shift > 110 {
        return Some((0, 0));
    }
    let (whole, fraction) = match shift {
        0..64 => (digits >> shift, digits & ((1 << shift) - 1)),
        _ => (0, digits),
    };
    if shift < u64::BITS
        && let Some(product) = fraction.checked_mul(ten)
    {
        let rest = product & ((1 << shift) - 1);
        return Some(carried(
            whole,
            product >> shift,
            (rest, 1 << (shift - 1)),
            (ten, decimals),
        ));
    }
    let product = u128::from(fraction) * u128::from(ten);
    let rest = product & ((1 << shift) - 1);
    let parts = (product >> shift) as u64;
    Some(carried(whole, parts, (rest, 1 << (shift - 1)), (ten, decimals)))
}

/// Rounds the decimals `parts` by the `rest` behind them and half of its unit; gives the whole part and the decimals.
#[inline(always)]
fn carried<T: Ord>(whole: u64, mut parts: u64, (rest, half): (T, T), (ten, decimals): (u64, usize)) -> (u64, u64) {
    // Without decimals, the last digit is that of the whole part.
    let last = if decimals == 0 { whole } else { parts };
    parts += u64::from(rest > half || rest == half && last & 1 == 1);
    let carry = u64::from(parts == ten);
    (whole + carry, parts - carry * ten)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn decimals(value: f64, decimals: usize) -> String {
        let mut text = Vec::new();
        write_decimals(&mut text, value, decimals).unwrap();
        String::from_utf8(text).unwrap()
    }

    fn plain(value: f64, decimals: usize) -> String {
        let mut text = Vec::new();
        write_plain(&mut text, value, decimals).unwrap();
        String::from_utf8(text).unwrap()
    }

    /// Values that show their digits in any decimals: random bits, quotients of small whole numbers, halves.
    fn values() -> impl Strategy<Value = f64> {
        prop_oneof![
            any::<u64>().prop_map(f64::from_bits),
            -1e7..1e7_f64,
            -1.0..1.0_f64,
            (-100_000_000_i64..100_000_000, 0..40).prop_map(|(whole, shift)| whole as f64 / (1_u64 << shift) as f64),
            (-1_000_000_i64..1_000_000, 0..9).prop_map(|(whole, tens)| whole as f64 / 10_f64.powi(tens)),
            (-1_000_000_i64..1_000_000, 1..9).prop_map(|(whole, tens)| (whole as f64 + 0.5) / 10_f64.powi(tens)),
        ]
    }

    #[test]
    fn decimals_are_those_of_the_standard_library_at_every_border() {
        let tiny = f64::from_bits(1);
        let two53 = 9_007_199_254_740_992.0;
        let borders = [
            0.0,
            0.5,
            1.5,
            2.5,
            0.25,
            0.125,
            0.375,
            0.0625,
            0.05,
            0.005,
            0.0005,
            0.00005,
            0.95,
            0.995,
            0.9995,
            0.99995,
            9.5,
            99.99995,
            1e-4,
            5e-5,
            4.999e-5,
            1e-17,
            5e-18,
            1e-300,
            f64::MIN_POSITIVE,
            tiny,
            1e15,
            1e16,
            1e17,
            1e22,
            1e300,
            f64::MAX,
            f64::INFINITY,
            f64::NAN,
            two53,
            two53 - 1.0,
            two53 - 0.5,
            two53 / 2.0 - 0.5,
            two53 + 2.0,
        ];
        for value in borders.into_iter().flat_map(|value| [value, -value]) {
            for count in 0..=20 {
                assert_eq!(
                    decimals(value, count),
                    format!("{value:.count$}"),
                    "{value:e}, {count} decimals"
                );
            }
        }
    }

    #[test]
    fn a_plain_number_has_no_minus_sign_before_zero() {
        let shown = [-0.0, -0.000_499_9, -0.0005, -0.000_500_1, -1.0, f64::NEG_INFINITY].map(|value| plain(value, 3));
        assert_eq!(shown, ["0.000", "0.000", "-0.001", "-0.001", "-1.000", "-inf"]);
    }

    proptest! {
        #[test]
        fn decimals_are_those_of_the_standard_library(value in values(), count in 0_usize..20) {
            prop_assert_eq!(decimals(value, count), format!("{value:.count$}"));
        }

        #[test]
        fn times_are_seconds_without_zeros_at_the_end(ns in any::<i64>(), tens in 0_u32..19) {
            let ns = ns / 10_i64.pow(tens) * 10_i64.pow(tens.min(9)).min(10_i64.pow(tens));
            let all = format!("{}.{:09}", ns.unsigned_abs() / 1_000_000_000, ns.unsigned_abs() % 1_000_000_000);
            let short = all.trim_end_matches('0').trim_end_matches('.');
            let mut text = Vec::new();
            write_time(&mut text, ns).unwrap();
            prop_assert_eq!(String::from_utf8(text).unwrap(), format!("{}{short}", if ns < 0 { "-" } else { "" }));
        }

        #[test]
        fn whole_numbers_are_those_of_the_standard_library(number in any::<u64>(), shift in 0_u32..64) {
            let number = number >> shift;
            let mut text = Vec::new();
            write_whole(&mut text, number).unwrap();
            prop_assert_eq!(String::from_utf8(text).unwrap(), number.to_string());
        }

        /// Text of earlier versions.
        #[test]
        fn plain_numbers_are_those_of_the_standard_library(value in values(), count in 0_usize..10) {
            let half = 0.5 * 10_f64.powi(-(count as i32));
            let shown = if value.abs() < half { 0.0 } else { value };
            prop_assert_eq!(plain(value, count), format!("{shown:.count$}"));
        }
    }
}

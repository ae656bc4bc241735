//! Quantities as whole numbers of a least significant bit (LSB).
//!
//! A number sent is the nearest multiple of the LSB, so what is read differs by half an LSB at most. A quantity that its
//! bits can not hold has no number, and the caller leaves the item out; cutting it to the greatest number would be
//! another quantity. Only where the document says that the greatest number means "this or more" is it [`capped`].

use std::f64::consts::TAU;

/// The number of a quantity in two's complement of `bits` bits; `None` if they can not hold it.
pub(super) fn signed(value: f64, lsb: f64, bits: u32) -> Option<i64> {
    let number = (value / lsb).round();
    let limit = (1u64 << (bits - 1)) as f64;
    (-limit..limit).contains(&number).then_some(number as i64)
}

/// The number of a quantity without sign in `bits` bits; `None` if they can not hold it.
pub(super) fn unsigned(value: f64, lsb: f64, bits: u32) -> Option<u64> {
    let number = (value / lsb).round();
    let limit = (1u64 << bits) as f64;
    (0.0..limit).contains(&number).then_some(number as u64)
}

/// The number of a quantity without sign, the greatest that `bits` bits hold for more than that.
pub(super) fn capped(value: f64, lsb: f64, bits: u32) -> u64 {
    let greatest = (1u64 << bits) - 1;
    ((value / lsb).round().max(0.0) as u64).min(greatest) // `as` takes infinity to the greatest number, NaN to 0
}

/// The number of a standard deviation, as [`unsigned`], but never 0: many a sender means "not known" by that, and none is
/// perfect.
pub(super) fn deviation(sigma: f64, lsb: f64, bits: u32) -> Option<u64> {
    unsigned(sigma, lsb, bits).map(|number| number.max(1))
}

/// The number of a standard deviation where the greatest number means this or more; never 0.
pub(super) fn capped_deviation(sigma: f64, lsb: f64, bits: u32) -> u64 {
    capped(sigma, lsb, bits).max(1)
}

/// The standard deviation of a variance that says something.
pub(super) fn sigma(variance: f64) -> Option<f64> {
    (variance.is_finite() && variance > 0.0).then(|| variance.sqrt())
}

/// A direction in 2^`bits` steps of the full circle.
pub(super) fn turn(angle_rad: f64, bits: u32) -> u64 {
    let steps = (1u64 << bits) as f64;
    ((angle_rad / TAU * steps).round() as i64).rem_euclid(1 << bits) as u64
}

/// A latitude with an LSB of 180/2^`exponent` degrees.
pub(super) fn latitude(degrees: f64, exponent: u32) -> i64 {
    (degrees / 180.0 * (1u64 << exponent) as f64).round() as i64
}

/// A longitude with an LSB of 180/2^`exponent` degrees; 180° east is sent as 180° west, which documents allow alone.
pub(super) fn longitude(degrees: f64, exponent: u32) -> i64 {
    let half_turn = 1i64 << exponent;
    match latitude(degrees, exponent) {
        number if number >= half_turn => number - 2 * half_turn,
        number => number,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_the_nearest_and_within_their_bits() {
        assert_eq!(signed(-0.3, 0.5, 8), Some(-1));
        assert_eq!(signed(63.7, 0.5, 8), Some(127));
        assert_eq!(signed(63.75, 0.5, 8), None, "would be 128");
        assert_eq!(signed(-64.0, 0.5, 8), Some(-128));
        assert_eq!(unsigned(-0.2, 0.5, 8), Some(0));
        assert_eq!(unsigned(-0.3, 0.5, 8), None);
        assert_eq!(unsigned(127.74, 0.5, 8), Some(255));
        assert_eq!(unsigned(f64::NAN, 1.0, 8), None);
        assert_eq!(capped(1e12, 0.5, 8), 255);
        assert_eq!(capped(f64::INFINITY, 0.5, 8), 255);
        assert_eq!(capped(-1.0, 0.5, 8), 0);
    }

    #[test]
    fn no_deviation_is_zero() {
        assert_eq!(deviation(0.01, 0.25, 16), Some(1));
        assert_eq!(capped_deviation(1e9, 0.25, 8), 255);
        assert_eq!(sigma(0.0), None);
        assert_eq!(sigma(f64::INFINITY), None);
        assert_eq!(sigma(9.0), Some(3.0));
    }

    #[test]
    fn directions_go_round() {
        assert_eq!(turn(TAU / 4.0, 16), 0x4000);
        assert_eq!(turn(-TAU / 4.0, 16), 0xC000);
        assert_eq!(turn(TAU - 1e-9, 16), 0);
    }

    #[test]
    fn the_antimeridian_is_west() {
        assert_eq!(longitude(180.0, 31), i64::from(i32::MIN));
        assert_eq!(longitude(-180.0, 31), i64::from(i32::MIN));
        assert_eq!(longitude(179.999_999_999_99, 23), -(1 << 23));
        assert_eq!(latitude(90.0, 23), 1 << 22);
    }
}

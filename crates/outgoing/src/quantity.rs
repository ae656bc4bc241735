//! Quantities as whole numbers of a least significant bit (LSB).
//!
//! A sent number is the nearest multiple of the LSB ([`Field::nearest`]), so that the received quantity differs by
//! half an LSB at most. A quantity beyond the range of its bits has no number, and the caller omits the item; the
//! greatest number would be a different quantity. Only if the document defines the greatest number as "this or more",
//! the quantity is [`capped`].

use std::f64::consts::{PI, TAU};

use asterix::field::{Elements, Field};

/// Returns the numbers of quantities in SI units; `None` if a quantity has no number.
pub(super) fn nearest<const N: usize>(elements: &Elements<N>, quantities: [f64; N]) -> Option<[i64; N]> {
    let mut numbers = [0; N];
    for i in 0..N {
        numbers[i] = elements.fields[i].nearest(quantities[i])?;
    }
    Some(numbers)
}

/// The number of a quantity that is not negative, the greatest there is for more than that.
pub(super) fn capped(field: Field, quantity: f64) -> i64 {
    ((quantity / field.lsb).round().max(0.0) as i64).min(field.greatest()) // `as` takes infinity to the greatest, NaN to 0
}

/// The number of a standard deviation, as [`Field::nearest`], but never 0: many a sender means "not known" by that, and
/// none is perfect.
pub(super) fn deviation(field: Field, sigma: f64) -> Option<i64> {
    field.nearest(sigma).map(|number| number.max(1))
}

/// The number of a standard deviation where the greatest number means this or more; never 0.
pub(super) fn capped_deviation(field: Field, sigma: f64) -> i64 {
    capped(field, sigma).max(1)
}

/// Returns the standard deviation of a valid variance.
pub(super) fn sigma(variance: f64) -> Option<f64> {
    (variance.is_finite() && variance > 0.0).then(|| variance.sqrt())
}

/// A direction in steps of which the bits hold the full circle.
pub(super) fn turn(field: Field, angle_rad: f64) -> i64 {
    let steps = TAU / field.lsb; // exact: a power of two
    ((angle_rad / TAU * steps).round() as i64).rem_euclid(1 << field.bits)
}

/// A latitude in degrees.
pub(super) fn latitude(field: Field, degrees: f64) -> i64 {
    let half_turn = PI / field.lsb; // exact: a power of two
    (degrees / 180.0 * half_turn).round() as i64
}

/// A longitude in degrees; 180° east is sent as 180° west, which documents allow alone.
pub(super) fn longitude(field: Field, degrees: f64) -> i64 {
    let half_turn = (PI / field.lsb) as i64;
    match latitude(field, degrees) {
        number if number >= half_turn => number - 2 * half_turn,
        number => number,
    }
}

#[cfg(test)]
mod tests {
    use asterix::categories::*;
    use asterix::field::field;

    use super::*;

    /// One byte without sign, LSB 0.25 m.
    const OCTET: Field = field(CAT010, &["500", "DEVX"]);

    #[test]
    fn numbers_are_the_nearest_and_within_their_bits() {
        const SIGNED: Field = field(CAT010, &["210", "AX"]); // one octet, LSB 0.25 m/s²
        assert_eq!(SIGNED.nearest(-0.15), Some(-1));
        assert_eq!(SIGNED.nearest(31.85), Some(127));
        assert_eq!(SIGNED.nearest(31.875), None, "would be 128");
        assert_eq!(SIGNED.nearest(-32.0), Some(-128));
        assert_eq!(OCTET.nearest(-0.1), Some(0));
        assert_eq!(OCTET.nearest(-0.15), None);
        assert_eq!(OCTET.nearest(63.87), Some(255));
        assert_eq!(OCTET.nearest(f64::NAN), None);
        assert_eq!(OCTET.nearest(f64::INFINITY), None);
        assert_eq!(capped(OCTET, 1e12), 255);
        assert_eq!(capped(OCTET, f64::INFINITY), 255);
        assert_eq!(capped(OCTET, -1.0), 0);
    }

    #[test]
    fn no_deviation_is_zero() {
        assert_eq!(deviation(OCTET, 0.01), Some(1));
        assert_eq!(capped_deviation(OCTET, 1e9), 255);
        assert_eq!(sigma(0.0), None);
        assert_eq!(sigma(f64::INFINITY), None);
        assert_eq!(sigma(9.0), Some(3.0));
    }

    #[test]
    fn directions_go_round() {
        const COURSE: Field = field(CAT048, &["200", "HDG"]);
        assert_eq!(turn(COURSE, TAU / 4.0), 0x4000);
        assert_eq!(turn(COURSE, -TAU / 4.0), 0xC000);
        assert_eq!(turn(COURSE, TAU - 1e-9), 0);
    }

    #[test]
    fn the_antimeridian_is_west() {
        const FINE: Field = field(CAT010, &["041", "LON"]);
        const COARSE: Field = field(CAT021_V2, &["130", "LON"]);
        assert_eq!(longitude(FINE, 180.0), i64::from(i32::MIN));
        assert_eq!(longitude(FINE, -180.0), i64::from(i32::MIN));
        assert_eq!(longitude(COARSE, 179.999_999_999_99), -(1 << 23));
        assert_eq!(latitude(COARSE, 90.0), 1 << 22);
    }
}

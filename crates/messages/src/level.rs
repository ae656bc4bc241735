//! Level of a target: the pressure altitude reported by the transponder, in the steps of Mode C.

/// Size of a step of a level, metres: 25 feet, a quarter of a flight level, as in ASTERIX and Mode S.
pub const LEVEL_STEP_M: f64 = 7.62;

/// Returns the level of a pressure altitude (metres, against 1013.25 hPa) in steps; `None` outside the range of
/// levels.
pub fn level_of(altitude_m: f64) -> Option<i16> {
    let steps = (altitude_m / LEVEL_STEP_M).round();
    (f64::from(i16::MIN)..=f64::from(i16::MAX))
        .contains(&steps)
        .then_some(steps as i16)
}

/// Returns the pressure altitude of a level, metres.
pub fn altitude_m(level: i16) -> f64 {
    f64::from(level) * LEVEL_STEP_M
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_quarters_of_a_hundred_feet() {
        assert_eq!(level_of(36_025.0 * 0.3048), Some(1_441));
        assert_eq!((level_of(0.0), level_of(-100.0 * 0.3048)), (Some(0), Some(-4)));
        assert!((altitude_m(1_441) - 36_025.0 * 0.3048).abs() < 1e-9);
        for none in [f64::NAN, f64::INFINITY, 1e9, -1e9] {
            assert_eq!(level_of(none), None);
        }
    }
}

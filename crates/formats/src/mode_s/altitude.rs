//! Altitude and identity codes of 13 bits.
//!
//! Both have the pulses of Modes A and C in the order C1 A1 C2 A2 C4 A4 M B1 D1 B2 D2 B4 D4 (ICAO Annex 10 volume IV,
//! 3.1.2.6.5.4 and 3.1.2.6.7.1). In an altitude, the place of D1 is Q: set for steps of 25 ft, clear for the code of
//! Mode C in steps of 100 ft, named after Gillham. M marks metric units, for which the standard has reserved the other
//! bits without a coding; no altitude is read then.

/// Metres in a foot.
pub(super) const M_PER_FT: f64 = 0.3048;

/// Places of A4 A2 A1, B4 B2 B1, C4 C2 C1 and D4 D2 D1, from the last bit.
const PULSES: [u8; 12] = [7, 9, 11, 1, 3, 5, 8, 10, 12, 0, 2, 4];
/// Bit for metric units (M).
const METRIC: u16 = 1 << 6;
/// Bit for steps of 25 ft (Q).
const FINE: u16 = 1 << 4;

/// Mode 3/A code of an identity code: four octal digits.
pub(super) fn mode_3a(code: u16) -> u16 {
    PULSES.iter().fold(0, |digits, place| digits << 1 | (code >> place & 1))
}

/// Altitude of an altitude code, feet; `None` for no altitude, and for codes without a meaning.
pub(super) fn altitude_ft(code: u16) -> Option<f64> {
    if code == 0 || code & METRIC != 0 {
        return None;
    }
    if code & FINE != 0 {
        let steps = (code & 0x1f80) >> 2 | (code & 0x20) >> 1 | code & 0xf;
        return Some(f64::from(steps) * 25.0 - 1000.0);
    }
    let digits = mode_3a(code);
    let pulse = |place: u16| digits >> place & 1;
    // D2 D4 A1 A2 A4 B1 B2 B4 count steps of 500 ft, C1 C2 C4 steps of 100 ft in them, both in a Gray code.
    let [d, a, b, c] = [0, 9, 6, 3];
    let coarse = binary([d + 1, d + 2, a, a + 1, a + 2, b, b + 1, b + 2].map(pulse));
    let fine = match binary([c, c + 1, c + 2].map(pulse)) {
        steps @ 1..=4 => steps,
        7 => 5,
        _ => return None,
    };
    // Every second range of 500 ft counts down.
    let fine = if coarse % 2 == 1 { 6 - fine } else { fine };
    Some(f64::from(coarse) * 500.0 + f64::from(fine) * 100.0 - 1300.0)
}

/// The number of a Gray code, first bit first.
fn binary<const BITS: usize>(gray: [u16; BITS]) -> u16 {
    let (number, _) = gray.iter().fold((0, 0), |(number, last), bit| {
        let bit = bit ^ last;
        (number << 1 | bit, bit)
    });
    number
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The altitude code of pulses written as Mode C digits A B C D.
    fn code(digits: u16) -> u16 {
        let places = PULSES.iter().rev().enumerate();
        places.fold(0, |code, (bit, place)| code | (digits >> bit & 1) << place)
    }

    #[test]
    fn hundreds_of_feet_follow_the_table_of_mode_c() {
        // From the table in ICAO Annex 10 volume IV, appendix to chapter 3: digits A B C D.
        for (digits, altitude) in [
            (0o0040, -1200.0),
            (0o0020, -1000.0),
            (0o0620, 0.0),
            (0o0630, 100.0),
            (0o4020, 6500.0),
            (0o0042, 126_700.0),
        ] {
            assert_eq!(altitude_ft(code(digits)), Some(altitude), "{digits:04o}");
        }
    }

    #[test]
    fn every_hundred_feet_has_one_code() {
        let mut found: Vec<i64> = (0..1 << 13)
            .filter(|code| code & (METRIC | FINE) == 0)
            .filter_map(altitude_ft)
            .map(|altitude| altitude as i64)
            .collect();
        found.sort_unstable();
        let expected: Vec<i64> = (-12..=1267).map(|hundreds| hundreds * 100).collect();
        assert_eq!(found, expected);
        // One step of altitude is one pulse, which is what the code is for.
        let of = |altitude: i64| {
            let all = (0..1 << 13).filter(|code| code & (METRIC | FINE) == 0);
            all.clone()
                .find(|code| altitude_ft(*code) == Some(altitude as f64))
                .unwrap()
        };
        for pair in [-1200, -100, 0, 4900, 30_000, 62_300].map(|altitude| [of(altitude), of(altitude + 100)]) {
            assert_eq!((pair[0] ^ pair[1]).count_ones(), 1);
        }
    }

    #[test]
    fn steps_of_25_feet_and_metric_units() {
        assert_eq!(altitude_ft(0b1_1000_0001_1000), Some(37_600.0));
        assert_eq!(altitude_ft(FINE), Some(-1000.0));
        assert_eq!((altitude_ft(0), altitude_ft(METRIC | FINE | 1)), (None, None));
        assert_eq!(mode_3a(code(0o7421)), 0o7421);
    }
}

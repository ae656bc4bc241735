//! Settings of identity as evidence (TI-3, QF-2).

use messages::CONSPICUITY_CODES;

settings::settings! {
    /// Identity as evidence for one target (TI-3).
    pub struct IdentitySettings {
        /// Greatest distance at which a rare Mode 3/A code or call sign joins tracks of two sources whose bias is not
        /// learned yet. Afterwards it is the rest of the learned bias and four standard deviations.
        reach_m: f64 = 5000.0, in [0, 1e5];
        /// Least distance of a position that a target reports (ADS-B, AIS) from where sensors measure the same address,
        /// from which the position is false.
        false_m: f64 = 1000.0, in [1, 1e6];
        /// Mode 3/A codes that many targets share, in octal: a digit may be `x`, which stands for any digit. Codes of
        /// a region (as `12xx`) can be added. Other codes are rare while a source has one track with the code.
        shared_codes: Vec<CodePattern> = CodePattern::usual();
    }

    /// Exponents of the factors of association (QF-2): 1 leaves a factor as it is, 0 takes it away.
    #[derive(Copy)]
    pub struct FactorExponents {
        /// Distance of the positions.
        position: f64 = 1.0, in [0, 10];
        /// Difference of the velocities.
        velocity: f64 = 1.0, in [0, 10];
        /// Difference of the heights.
        height: f64 = 1.0, in [0, 10];
        /// The sensor's track number: the keep gate is multiplied by the exponent.
        number: f64 = 1.0, in [0.1, 10];
        /// Mode 3/A code.
        code: f64 = 1.0, in [0, 10];
        /// Call sign.
        callsign: f64 = 1.0, in [0, 10];
        /// 24-bit address or MMSI.
        address: f64 = 1.0, in [0, 10];
        /// Class of the target.
        class: f64 = 1.0, in [0, 10];
    }
}

impl IdentitySettings {
    /// Whether many targets share a Mode 3/A code.
    pub fn is_shared(&self, code: u16) -> bool {
        self.shared_codes.iter().any(|shared| shared.has(code))
    }
}

impl FactorExponents {
    /// Whether position or velocity counts other than plainly.
    pub fn weighs_motion(&self) -> bool {
        self.position != 1.0 || self.velocity != 1.0
    }
}

/// Codes that agree in some of their four octal digits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CodePattern {
    code: u16,
    /// Bits of the digits that are given.
    mask: u16,
}

impl CodePattern {
    /// Conspicuity codes of Europe and of North America, and the codes of emergencies.
    fn usual() -> Vec<Self> {
        let codes = CONSPICUITY_CODES.into_iter().chain([0o7500, 0o7600, 0o7700]);
        codes.map(|code| Self { code, mask: 0o7777 }).collect()
    }

    /// Whether a code is one of these.
    pub fn has(self, code: u16) -> bool {
        code & self.mask == self.code
    }

    fn read(text: &str) -> Option<Self> {
        let mut pattern = Self::default();
        for digit in text.chars() {
            let (value, given) = match digit {
                'x' | 'X' => (0, 0),
                _ => (digit.to_digit(8)?, 7),
            };
            pattern.code = pattern.code << 3 | value as u16;
            pattern.mask = pattern.mask << 3 | given;
        }
        (text.len() == 4).then_some(pattern)
    }

    fn written(self) -> String {
        let digit = |shift: u32| match (self.mask >> shift) & 7 {
            0 => 'x'.to_string(),
            _ => ((self.code >> shift) & 7).to_string(),
        };
        [9, 6, 3, 0].map(digit).concat()
    }
}

settings::spelt_as!(
    CodePattern,
    String,
    "Mode 3/A code",
    |text| Self::read(&text)
        .ok_or_else(|| format!("{text:?} is no Mode 3/A code of four octal digits, such as \"7000\"")),
    |pattern| pattern.written()
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_has_the_codes_of_its_digits() {
        let region = CodePattern::read("12x4").unwrap();
        assert_eq!(region.written(), "12x4");
        assert!(region.has(0o1274) && region.has(0o1204) && !region.has(0o1275) && !region.has(0o2204));
        for wrong in ["", "128", "1289", "12345", "abcd"] {
            assert_eq!(CodePattern::read(wrong), None, "{wrong}");
        }
        let has = |code: u16| CodePattern::usual().iter().any(|pattern| pattern.has(code));
        assert!(has(0o7000) && has(0o2000) && !has(0o7001));
    }
}

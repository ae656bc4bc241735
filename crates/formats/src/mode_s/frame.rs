//! Bits and checksum of a frame.
//!
//! A frame ends in 24 bits of checksum (ICAO Annex 10 volume IV, 3.1.2.3.3), which a transponder sends combined with
//! zero, with the code of the interrogator, or with the aircraft's address. [`ModeSFrame::syndrome`] is what is left
//! of the sent checksum without the computed one. Bits are never repaired: one bit in 112 repaired lets a hundred
//! times as many frames of noise pass.

/// Generator of the checksum without its highest term.
const GENERATOR: u32 = 0xff_f409;
const REMAINDERS: [u32; 256] = remainders();

/// A frame of Mode S, 7 or 14 octets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModeSFrame {
    bits: u128,
    octets: usize,
}

impl ModeSFrame {
    /// Octets of a short frame.
    pub const SHORT: usize = 7;
    /// Octets of a long frame.
    pub const LONG: usize = 14;

    /// Returns the frame of 7 or 14 octets; `None` for another number of octets.
    pub fn new(octets: &[u8]) -> Option<Self> {
        matches!(octets.len(), Self::SHORT | Self::LONG).then(|| Self {
            bits: octets.iter().fold(0, |bits, octet| bits << 8 | u128::from(*octet)),
            octets: octets.len(),
        })
    }

    /// Downlink format, 0 to 24. The formats from 24 on have a number of two bits.
    pub fn format(&self) -> u8 {
        self.field(1, 5).min(24) as u8
    }

    /// Whether the frame is as long as its format says.
    pub fn has_length_of_format(&self) -> bool {
        self.octets == if self.format() < 16 { Self::SHORT } else { Self::LONG }
    }

    /// Bits `first` to `last`, numbered from 1 as in the standard.
    ///
    /// # Panics
    /// In debug builds, if the bits are not of the frame, or more than 64.
    pub(super) fn field(&self, first: usize, last: usize) -> u64 {
        debug_assert!(0 < first && first <= last && last <= 8 * self.octets && last - first < 64);
        (self.bits >> (8 * self.octets - last)) as u64 & (u64::MAX >> (63 - (last - first)))
    }

    /// Bits `first` to `last` of the message of an extended squitter (ME), numbered from 1 as in the standard.
    pub(super) fn message(&self, first: usize, last: usize) -> u64 {
        self.field(32 + first, 32 + last)
    }

    /// The octets of the message of an extended squitter.
    pub(super) fn message_octets(&self) -> [u8; 7] {
        std::array::from_fn(|place| self.message(8 * place + 1, 8 * place + 8) as u8)
    }

    /// What the transponder has combined the checksum with, if no bit is damaged: 24 bits.
    pub fn syndrome(&self) -> u32 {
        let data = 0..self.octets - 3;
        let remainder = data.fold(0, |remainder: u32, place| {
            let octet = self.field(8 * place + 1, 8 * place + 8) as u32;
            (remainder << 8 & 0xff_ffff) ^ REMAINDERS[(remainder >> 16 ^ octet) as usize]
        });
        remainder ^ (self.bits as u32 & 0xff_ffff)
    }
}

const fn remainders() -> [u32; 256] {
    let mut table = [0; 256];
    let mut octet = 0;
    while octet < 256 {
        let mut remainder = (octet as u32) << 16;
        let mut bit = 0;
        while bit < 8 {
            remainder = remainder << 1 ^ if remainder & 0x80_0000 == 0 { 0 } else { GENERATOR };
            bit += 1;
        }
        table[octet] = remainder & 0xff_ffff;
        octet += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_are_those_of_received_frames() {
        let long = ModeSFrame::new(&0x8D48_40D6_202C_C371_C32C_E057_6098u128.to_be_bytes()[2..]).unwrap();
        assert_eq!(
            (long.format(), long.syndrome(), long.has_length_of_format()),
            (17, 0, true)
        );
        // A reply to the interrogator of surveillance identifier 6.
        let short = ModeSFrame::new(&0x005D_484F_DEA2_48F5u64.to_be_bytes()[1..]).unwrap();
        assert_eq!((short.format(), short.syndrome()), (11, 0b001_0110));
        // A reply with its address in the checksum.
        let reply = ModeSFrame::new(&0x002A_0051_6D49_2B80u64.to_be_bytes()[1..]).unwrap();
        assert_eq!((reply.format(), reply.syndrome()), (5, 0x51_0af9));
        assert_eq!(ModeSFrame::new(&[0; 8]), None);
    }
}

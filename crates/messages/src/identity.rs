//! Identity of a target.

use std::fmt;

use crate::codes;
use crate::codes::bits;
use crate::layout::sample;

bits! {
    /// Bits of [`Identity::valid`].
    identity_bits: u8 {
        /// `mode_3a` holds a Mode 3/A code.
        MODE_3A = 1;
        /// `callsign` holds a callsign.
        CALLSIGN = 1 << 1;
        /// `name` holds a name.
        NAME = 1 << 2;
    }
}

codes! {
    /// Kind of the number reported by a target's transponder.
    pub enum IdentityKind: u8, default None {
        /// No number is known.
        None = 0, "none";
        /// 24-bit aircraft address.
        Aircraft = 1, "aircraft";
        /// 30-bit Maritime Mobile Service Identity (MMSI).
        Ship = 2, "ship";
    }
}

/// Number of bits of an MMSI.
const MMSI_BITS: u32 = 30;

/// Callsign: up to eight characters, padded with blanks, as in ASTERIX and Mode S.
pub type Callsign = [u8; 8];

/// Maximum number of characters of a [name](Identity::name).
pub const NAME_MAX: usize = 20;

sample! {
    /// Known identity of a target (TI-1).
    Identity, size 40 {
        /// 24-bit aircraft address or 30-bit MMSI (see `kind`), in the low bits.
        address: u32,
        /// Mode 3/A code, its four octal digits in twelve bits.
        mode_3a: u16,
        /// Kind of `address`: an `IdentityKind` code.
        kind: u8,
        /// Fields that hold something: see `identity_bits`.
        valid: u8,
        /// Callsign in ASCII, padded with blanks.
        callsign: [u8; 8],
        /// Name in ASCII, padded with blanks: that of a ship, for example.
        name: [u8; 20],
        /// Reserved, 0.
        reserved: u32,
    }
}

sample! {
    /// Ages of the values of an [`Identity`]: time since each value was last observed. An age of 0 belongs to the
    /// state's own report.
    IdentityAges, size 12 {
        /// Age of `address`, milliseconds.
        address_ms: u32,
        /// Age of `mode_3a`, milliseconds.
        mode_3a_ms: u32,
        /// Age of `callsign`, milliseconds.
        callsign_ms: u32,
    }
}

impl Identity {
    /// Returns the 24-bit aircraft address, if known.
    pub fn address(&self) -> Option<u32> {
        (self.kind == IdentityKind::Aircraft.code()).then_some(self.address)
    }

    /// Returns the 30-bit MMSI of a ship, if known.
    pub fn mmsi(&self) -> Option<u32> {
        (self.kind == IdentityKind::Ship.code()).then_some(self.address)
    }

    /// Returns a number unique across all kinds of targets: an aircraft's address, or a ship's MMSI with bit 30
    /// set.
    #[inline]
    pub fn unique_number(&self) -> Option<u32> {
        self.address().or_else(|| self.mmsi().map(|mmsi| mmsi | 1 << MMSI_BITS))
    }

    /// Returns the Mode 3/A code, if known.
    pub fn mode_3a(&self) -> Option<u16> {
        (self.valid & identity_bits::MODE_3A != 0).then_some(self.mode_3a)
    }

    /// Returns the callsign without padding, if known.
    pub fn callsign(&self) -> Option<&str> {
        (self.valid & identity_bits::CALLSIGN != 0)
            .then(|| unpadded(&self.callsign))
            .flatten()
    }

    /// Returns the name without padding, if known.
    pub fn name(&self) -> Option<&str> {
        (self.valid & identity_bits::NAME != 0)
            .then(|| unpadded(&self.name))
            .flatten()
    }

    /// Returns this identity with an aircraft address (the low 24 bits of `address`).
    #[must_use]
    pub fn with_address(mut self, address: u32) -> Self {
        self.address = address & 0x00ff_ffff;
        self.kind = IdentityKind::Aircraft.code();
        self
    }

    /// Returns this identity with a ship's MMSI (the low 30 bits of `mmsi`).
    #[must_use]
    pub fn with_mmsi(mut self, mmsi: u32) -> Self {
        self.address = mmsi & ((1 << MMSI_BITS) - 1);
        self.kind = IdentityKind::Ship.code();
        self
    }

    /// Returns this identity with a name, cut to the first [`NAME_MAX`] bytes.
    #[must_use]
    pub fn with_name(mut self, name: &str) -> Self {
        self.name = [b' '; NAME_MAX];
        let length = name.len().min(NAME_MAX);
        self.name[..length].copy_from_slice(&name.as_bytes()[..length]);
        self.valid |= identity_bits::NAME;
        self
    }

    /// Returns this identity with a Mode 3/A code (the low twelve bits of `code`).
    #[must_use]
    pub fn with_mode_3a(mut self, code: u16) -> Self {
        self.mode_3a = code & 0o7777;
        self.valid |= identity_bits::MODE_3A;
        self
    }

    /// Returns this identity with a callsign.
    #[must_use]
    pub fn with_callsign(mut self, callsign: Callsign) -> Self {
        self.callsign = callsign;
        self.valid |= identity_bits::CALLSIGN;
        self
    }

    /// Whether both identities have a unique number, or both a Mode 3/A code, and these differ. A missing value
    /// contradicts nothing.
    pub fn contradicts(&self, other: &Self) -> bool {
        let differ = |a: Option<u32>, b: Option<u32>| matches!((a, b), (Some(a), Some(b)) if a != b);
        differ(self.unique_number(), other.unique_number())
            || differ(self.mode_3a().map(u32::from), other.mode_3a().map(u32::from))
    }

    /// Returns this identity without a unique number.
    #[must_use]
    pub fn without_unique_number(mut self) -> Self {
        self.address = 0;
        self.kind = IdentityKind::None.code();
        self
    }

    /// Returns this identity, with missing values taken from `other`.
    #[must_use]
    pub fn or(mut self, other: &Self) -> Self {
        if self.kind == IdentityKind::None.code() {
            (self.address, self.kind) = (other.address, other.kind);
        }
        if let (None, Some(code)) = (self.mode_3a(), other.mode_3a()) {
            self = self.with_mode_3a(code);
        }
        if self.valid & identity_bits::CALLSIGN == 0 && other.valid & identity_bits::CALLSIGN != 0 {
            self = self.with_callsign(other.callsign);
        }
        if self.valid & identity_bits::NAME == 0 && other.valid & identity_bits::NAME != 0 {
            self.name = other.name;
            self.valid |= identity_bits::NAME;
        }
        self
    }
}

fn unpadded(text: &[u8]) -> Option<&str> {
    std::str::from_utf8(text)
        .ok()
        .map(|text| text.trim_end_matches([' ', '\0']))
}

impl fmt::Display for Identity {
    /// Writes the known values, `-` if there are none: `4CA7B3 A7421 RYR48CP`, `211234560 HAMBURG`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let address = self.address().map(|address| format!("{address:06X}"));
        let mmsi = self.mmsi().map(|mmsi| format!("{mmsi:09}"));
        let code = self.mode_3a().map(|code| format!("A{code:04o}"));
        let texts = [self.callsign(), self.name()].map(|text| text.map(str::to_owned));
        let known: Vec<_> = [address, mmsi, code].into_iter().chain(texts).flatten().collect();
        f.write_str(if known.is_empty() { "-" } else { "" })?;
        f.write_str(&known.join(" "))
    }
}

/// Mode 3/A codes that many aircraft show at the same time (ICAO EUR Doc 023, and their equals in North America).
pub const CONSPICUITY_CODES: [u16; 5] = [0o0000, 0o1000, 0o1200, 0o2000, 0o7000];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_aircraft_and_a_ship_of_the_same_digits_are_two() {
        let aircraft = Identity::default().with_address(0x4c_a7b3).with_mode_3a(0o7421);
        let ship = Identity::default().with_mmsi(0x4c_a7b3).with_name("HAMBURG");
        assert!(aircraft.contradicts(&ship) && !aircraft.contradicts(&Identity::default()));
        assert_eq!((aircraft.mmsi(), ship.address()), (None, None));
        assert_eq!((ship.mmsi(), ship.name()), (Some(0x4c_a7b3), Some("HAMBURG")));
        assert_eq!(Identity::default().or(&ship), ship);
        assert_eq!(
            (aircraft.to_string(), ship.to_string(), Identity::default().to_string()),
            (
                "4CA7B3 A7421".to_owned(),
                "005023667 HAMBURG".to_owned(),
                "-".to_owned()
            )
        );
    }

    #[test]
    fn a_name_that_is_too_long_is_cut() {
        let long = Identity::default().with_name("TWENTY-ONE CHARACTERS");
        assert_eq!(long.name(), Some("TWENTY-ONE CHARACTER"));
    }
}

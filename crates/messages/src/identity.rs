//! Identity of a target.

use std::fmt;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

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

/// MMSI of the aircraft that take part in search and rescue: 111MIDaxx of recommendation ITU-R M.585.
const RESCUE_AIRCRAFT: std::ops::Range<u32> = 111_000_000..112_000_000;

/// Number of a target among those of all kinds: an aircraft's address, or a ship's MMSI.
///
/// The type keeps the kind with the number, so that an MMSI never becomes an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct UniqueNumber(u32);

impl UniqueNumber {
    /// Bit that marks an MMSI.
    const SHIP: u32 = 1 << MMSI_BITS;

    /// Returns the number as an integer: an aircraft's address, or a ship's MMSI with bit 30 set.
    #[inline]
    pub const fn to_bits(self) -> u32 {
        self.0
    }

    /// Returns the number of which [`to_bits`](Self::to_bits) gave these bits.
    #[inline]
    pub const fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// Returns whether the number is an MMSI.
    #[inline]
    pub const fn is_ship(self) -> bool {
        self.0 & Self::SHIP != 0
    }

    /// Returns whether two numbers show two targets. A rescue aircraft has an address and an MMSI: these two do not.
    #[inline]
    pub fn excludes(self, other: Self) -> bool {
        self != other && !(self.is_ship() != other.is_ship() && self.may_be_both(other))
    }

    /// Of an MMSI and an address, whether the MMSI is of an aircraft.
    #[cold]
    fn may_be_both(self, other: Self) -> bool {
        RESCUE_AIRCRAFT.contains(&(self.0.max(other.0) & !Self::SHIP))
    }
}

sample! {
    /// Known identity of a target (TI-1). Its numbers are integers here; text has the strings of `IdentityText`.
    Identity, size 40 {
        /// 24-bit aircraft address or 30-bit MMSI (see `kind`), an integer in the low bits.
        address: u32,
        /// Mode 3/A code, an integer of twelve bits: 2300 in octal digits is 1216.
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

    /// Returns the number that is unique across all kinds of targets, if known.
    #[inline]
    pub fn unique_number(&self) -> Option<UniqueNumber> {
        let of_ship = || self.mmsi().map(|mmsi| UniqueNumber(mmsi | UniqueNumber::SHIP));
        self.address().map(UniqueNumber).or_else(of_ship)
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

    /// Returns this identity with a number and its kind.
    #[must_use]
    #[inline]
    pub fn with_unique_number(self, number: UniqueNumber) -> Self {
        match number.is_ship() {
            true => self.with_mmsi(number.0),
            false => self.with_address(number.0),
        }
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

    /// Whether both identities have a unique number of which one excludes the other, or both a Mode 3/A code, and
    /// these differ. A missing value contradicts nothing.
    pub fn contradicts(&self, other: &Self) -> bool {
        let codes = (self.mode_3a(), other.mode_3a());
        self.has_other_number(other) || matches!(codes, (Some(mine), Some(theirs)) if mine != theirs)
    }

    /// Whether both identities have a unique number, and these [exclude](UniqueNumber::excludes) one target.
    #[inline]
    pub fn has_other_number(&self, other: &Self) -> bool {
        let numbers = (self.unique_number(), other.unique_number());
        matches!(numbers, (Some(mine), Some(theirs)) if mine.excludes(theirs))
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

pub(crate) fn unpadded(text: &[u8]) -> Option<&str> {
    std::str::from_utf8(text)
        .ok()
        .map(|text| text.trim_end_matches([' ', '\0']))
}

impl fmt::Display for Identity {
    /// Writes the known values, `-` if there are none: `4CA7B3 A7421 RYR48CP`, `211234560 HAMBURG`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let address = self.address_text().map(|address| address.to_string());
        let mmsi = self.mmsi_text().map(|mmsi| mmsi.to_string());
        let code = self.mode_3a_text().map(|code| format!("A{code}"));
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

    /// Checks what no function may do to a number: change its value or its kind.
    fn keeps(one: Identity, other: Identity) {
        let number = one.unique_number().unwrap();
        assert_eq!(UniqueNumber::from_bits(number.to_bits()), number);
        assert_eq!(number.is_ship(), one.mmsi().is_some());
        assert_eq!(
            (one.address().is_some(), one.mmsi().is_some()),
            (!number.is_ship(), number.is_ship())
        );
        // Merging never mixes the number of one with the kind of the other.
        assert_eq!(one.or(&other).unique_number(), Some(number));
        assert_eq!(Identity::default().or(&one).unique_number(), Some(number));
        let again = other.with_unique_number(number);
        assert_eq!((again.address(), again.mmsi()), (one.address(), one.mmsi()));
        assert_eq!((again.name(), again.mode_3a()), (other.name(), other.mode_3a()));
        assert_eq!(one.without_unique_number().unique_number(), None);
        // Excluding is symmetric, and nothing excludes itself.
        let theirs = other.unique_number().unwrap();
        assert!(!number.excludes(number));
        assert_eq!(number.excludes(theirs), theirs.excludes(number));
        let is_rescue_aircraft = one.mmsi().is_some_and(|mmsi| mmsi / 1_000_000 == 111);
        assert_eq!(
            number.excludes(theirs),
            number != theirs && !is_rescue_aircraft,
            "{one} {other}"
        );
    }

    fn keeps_address(address: u32) {
        let ship = Identity::default()
            .with_mmsi(address)
            .with_name("HAMBURG")
            .with_mode_3a(0o17);
        if ship.mmsi().is_some_and(|mmsi| mmsi / 1_000_000 != 111) {
            keeps(Identity::default().with_address(address), ship);
        }
    }

    fn keeps_mmsi(mmsi: u32) {
        let aircraft = Identity::default().with_address(mmsi).with_callsign(*b"RESCUE1 ");
        keeps(Identity::default().with_mmsi(mmsi), aircraft);
    }

    #[test]
    fn the_kind_of_a_number_stays_with_it_through_every_function() {
        let powers = (0..30).flat_map(|bit| [(1u32 << bit) - 1, 1 << bit, (1 << bit) + 1]);
        powers
            .clone()
            .filter(|number| *number < 1 << 24)
            .for_each(keeps_address);
        powers.for_each(keeps_mmsi);
        (0..1 << 24).step_by(499).for_each(keeps_address);
        (0..1 << 30).step_by(49_999).for_each(keeps_mmsi);
        // The report of the radar that made a ship an aircraft.
        keeps_mmsi(227_000_000);
    }

    #[test]
    #[ignore = "takes a minute: all 2^24 addresses and all 2^30 numbers of ships"]
    fn the_kind_of_every_number_stays_with_it_through_every_function() {
        (0..1 << 24).for_each(keeps_address);
        (0..1 << 30).for_each(keeps_mmsi);
    }

    #[test]
    fn only_the_two_numbers_of_a_rescue_aircraft_belong_together() {
        let numbers = |mmsi, address| {
            let [ship, aircraft] = [
                Identity::default().with_mmsi(mmsi),
                Identity::default().with_address(address),
            ];
            ship.contradicts(&aircraft)
        };
        assert!(!numbers(111_211_501, 0x3c_6589) && !numbers(111_000_000, 1) && !numbers(111_999_999, 1));
        assert!(numbers(110_999_999, 1) && numbers(112_000_000, 1) && numbers(227_000_000, 0x87_bec0));
        let [one, other] = [111_211_501, 111_211_502].map(|mmsi| Identity::default().with_mmsi(mmsi));
        assert!(one.contradicts(&other));
    }

    #[test]
    fn a_name_that_is_too_long_is_cut() {
        let long = Identity::default().with_name("TWENTY-ONE CHARACTERS");
        assert_eq!(long.name(), Some("TWENTY-ONE CHARACTER"));
    }
}

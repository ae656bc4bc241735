//! What a target says it is.

use std::fmt;

use crate::layout::sample;

/// Bits of [`Identity::valid`].
pub mod identity_bits {
    /// `address` holds a 24-bit aircraft address.
    pub const ADDRESS: u16 = 1;
    /// `mode_3a` holds a Mode 3/A code.
    pub const MODE_3A: u16 = 1 << 1;
    /// `callsign` holds a callsign.
    pub const CALLSIGN: u16 = 1 << 2;

    pub(crate) const NAMES: &[(&str, u64)] = &[
        ("ADDRESS", ADDRESS as u64),
        ("MODE_3A", MODE_3A as u64),
        ("CALLSIGN", CALLSIGN as u64),
    ];
}

/// A callsign: up to eight characters, padded with blanks, as ASTERIX and Mode S carry it.
pub type Callsign = [u8; 8];

sample! {
    /// Identity of a target, as far as it is known (TI-1).
    #[derive(Default)]
    Identity, size 16 {
        /// 24-bit aircraft address in the low bits.
        address: u32,
        /// Mode 3/A code, its four octal digits in twelve bits.
        mode_3a: u16,
        /// Which fields hold something: see `identity_bits`.
        valid: u16,
        /// Callsign in ASCII, padded with blanks.
        callsign: [u8; 8],
    }
}

impl Identity {
    /// The aircraft address, where known.
    pub fn address(&self) -> Option<u32> {
        (self.valid & identity_bits::ADDRESS != 0).then_some(self.address)
    }

    /// The Mode 3/A code, where known.
    pub fn mode_3a(&self) -> Option<u16> {
        (self.valid & identity_bits::MODE_3A != 0).then_some(self.mode_3a)
    }

    /// The callsign without its padding, where known.
    pub fn callsign(&self) -> Option<&str> {
        if self.valid & identity_bits::CALLSIGN == 0 {
            return None;
        }
        std::str::from_utf8(&self.callsign)
            .ok()
            .map(|text| text.trim_end_matches([' ', '\0']))
    }

    /// This identity with an aircraft address (the low 24 bits of `address`).
    #[must_use]
    pub fn with_address(mut self, address: u32) -> Self {
        self.address = address & 0x00ff_ffff;
        self.valid |= identity_bits::ADDRESS;
        self
    }

    /// This identity with a Mode 3/A code (the low twelve bits of `code`).
    #[must_use]
    pub fn with_mode_3a(mut self, code: u16) -> Self {
        self.mode_3a = code & 0o7777;
        self.valid |= identity_bits::MODE_3A;
        self
    }

    /// This identity with a callsign.
    #[must_use]
    pub fn with_callsign(mut self, callsign: Callsign) -> Self {
        self.callsign = callsign;
        self.valid |= identity_bits::CALLSIGN;
        self
    }

    /// Whether both know an address, or both a Mode 3/A code, and these differ. What one of them lacks contradicts nothing.
    pub fn contradicts(&self, other: &Self) -> bool {
        let differ = |a: Option<u32>, b: Option<u32>| matches!((a, b), (Some(a), Some(b)) if a != b);
        differ(self.address(), other.address()) || differ(self.mode_3a().map(u32::from), other.mode_3a().map(u32::from))
    }

    /// This identity with its address forgotten.
    #[must_use]
    pub fn without_address(mut self) -> Self {
        self.address = 0;
        self.valid &= !identity_bits::ADDRESS;
        self
    }

    /// What this identity lacks, taken from `other`.
    #[must_use]
    pub fn or(mut self, other: &Self) -> Self {
        if let (None, Some(address)) = (self.address(), other.address()) {
            self = self.with_address(address);
        }
        if let (None, Some(code)) = (self.mode_3a(), other.mode_3a()) {
            self = self.with_mode_3a(code);
        }
        if self.valid & identity_bits::CALLSIGN == 0 && other.valid & identity_bits::CALLSIGN != 0 {
            self = self.with_callsign(other.callsign);
        }
        self
    }
}

impl fmt::Display for Identity {
    /// `4CA7B3 A7421 RYR48CP`: what is known, `-` where nothing is.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        if let Some(address) = self.address() {
            write!(f, "{address:06X}")?;
            separator = " ";
        }
        if let Some(code) = self.mode_3a() {
            write!(f, "{separator}A{code:04o}")?;
            separator = " ";
        }
        if let Some(callsign) = self.callsign() {
            write!(f, "{separator}{callsign}")?;
            separator = " ";
        }
        if separator.is_empty() { f.write_str("-") } else { Ok(()) }
    }
}

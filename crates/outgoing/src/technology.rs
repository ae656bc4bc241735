//! Technologies of observation, as CAT062 distinguishes them.

settings::words! {
    /// Technology by which a source observes.
    pub enum Technology {
        /// Primary radar.
        Primary = "primary",
        /// Secondary radar without Mode S.
        Secondary = "secondary",
        /// Mode S radar.
        ModeS = "mode-s",
        /// ADS-B by 1090 MHz extended squitter.
        AdsB = "ads-b",
        /// Multilateration.
        Multilateration = "multilateration",
        /// Something else, or several of these in one.
        Other = "other",
    }
}

/// Kinds of sources distinguished by CAT062; [`Technology::Other`] is not included.
pub(super) const KINDS: usize = Technology::Other as usize;

impl Technology {
    /// Bit of the kind in a set of them; 0 for no kind.
    pub(super) fn bit(self) -> u8 {
        (1 << self as u8) & ((1 << KINDS) - 1)
    }
}

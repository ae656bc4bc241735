//! Technologies of observation, as CAT062 distinguishes them.

use deployment::Technology;

/// Kinds of sources distinguished by CAT062; [`Technology::Other`] is not included.
pub(super) const KINDS: usize = Technology::Other as usize;

/// Bit of the kind in a set of them; 0 for no kind.
pub(super) fn bit(technology: Technology) -> u8 {
    (1 << technology as u8) & ((1 << KINDS) - 1)
}

//! Formats of fuzzing inputs; the targets split inputs, the corpus joins the parts.

#![forbid(unsafe_code)]

/// Inputs of the target `codec`: a leading byte that selects the table and the mode, then the body of a data block.
pub mod codec {
    use asterix::block::HEADER_OCTETS;
    use asterix::{Category, Mode, registry};

    /// Maximum size of a body, bytes.
    pub const BODY_OCTETS_MAX: usize = u16::MAX as usize - HEADER_OCTETS;

    /// Splits an input into table, mode and body.
    pub fn split(input: &[u8]) -> Option<(&'static Category, Mode, &[u8])> {
        let (&choice, body) = input.split_first()?;
        let table = registry::REGISTRY[usize::from(choice >> 1) % registry::REGISTRY.len()];
        let mode = if choice & 1 == 1 { Mode::Strict } else { Mode::Lenient };
        Some((table, mode, &body[..body.len().min(BODY_OCTETS_MAX)]))
    }

    /// Returns the input that reads this body leniently with the registry's table of this index.
    pub fn join(index: usize, body: &[u8]) -> Vec<u8> {
        let choice = u8::try_from(index << 1).expect("at most 128 tables");
        [&[choice], body].concat()
    }
}

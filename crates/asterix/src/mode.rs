//! Reading mode: strict, to test a sender, or lenient, to accept deviations of senders.

/// Strictness with which bytes must follow the edition.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// Spare bits must be zero, and no extended item may go on after the edition's last part: to test a sender, or an
    /// encoder.
    Strict,
    /// Spare bits are ignored, and up to four single octets after an extended item's last defined part are skipped
    /// as unknown: to live with what senders do.
    #[default]
    Lenient,
}

//! Reading mode: strict, to test a sender, or lenient, to accept deviations of senders.

/// Strictness with which bytes must follow the edition.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// Spare bits must be zero, and no extended item may go on after the edition's last part: to test a sender, or an
    /// encoder.
    Strict,
    /// Ignores spare bits, and skips up to four single bytes after the last defined part of an extended item, for
    /// real senders.
    #[default]
    Lenient,
}

//! The words by which figures are called, in files and on the screen.

/// A figure's word, its unit, and what it says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Word {
    /// The key under which JSON has the figure.
    pub name: &'static str,
    /// Unit; empty for counts and shares.
    pub unit: &'static str,
    /// Meaning in a few words.
    pub meaning: &'static str,
}

impl Word {
    pub(crate) const fn new(name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        Self { name, unit, meaning }
    }
}

//! Names of the figures in files and on the screen.

/// Name of a figure, its unit, and its meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Word {
    /// Key of the figure in JSON.
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

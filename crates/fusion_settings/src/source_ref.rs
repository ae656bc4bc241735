//! References of keys to sources, by name in a file and by number in the engine.

/// Most sources.
pub const SOURCES_MAX: usize = 128;

/// A source that a key names: its number follows when all sources are known.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SourceRef {
    /// Its name in the file; empty where it was given by its number.
    pub name: String,
    /// Its number, its place among the sources.
    pub number: u16,
}

impl From<u16> for SourceRef {
    fn from(number: u16) -> Self {
        Self {
            name: String::new(),
            number,
        }
    }
}

settings::spelt_as!(
    SourceRef,
    String,
    "name of a source",
    |name| Ok(Self { name, number: 0 }),
    |source| source.name.clone()
);

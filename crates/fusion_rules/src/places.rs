//! Tables in serde's form, with free places stored as such.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A place of a table.
pub trait TablePlace: Sized {
    /// Whether the place is taken.
    fn is_taken(&self) -> bool;

    /// A free place.
    fn free() -> Self;
}

/// Writes a table.
///
/// # Errors
/// Errors of the serializer.
pub fn serialize<T: TablePlace + Serialize, S: Serializer>(places: &[T], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(places.iter().map(|place| place.is_taken().then_some(place)))
}

/// Reads a table.
///
/// # Errors
/// Errors of the deserializer.
pub fn deserialize<'de, T, D>(deserializer: D) -> Result<Vec<T>, D::Error>
where
    T: TablePlace + Deserialize<'de>,
    D: Deserializer<'de>,
{
    let places = Vec::<Option<T>>::deserialize(deserializer)?;
    Ok(places.into_iter().map(|place| place.unwrap_or_else(T::free)).collect())
}

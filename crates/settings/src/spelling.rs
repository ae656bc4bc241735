//! Types that files spell as another one.

/// Implements [`KeyValue`](crate::KeyValue) for a type written in files as a `$leaf` (a number, a text). `$of` converts
/// the leaf to the type or returns the reason for an error, `$leaf_of` is the inverse, and `$kind` is the type in
/// words.
#[macro_export]
macro_rules! spelt_as {
    ($type:ty, $leaf:ty, $kind:expr, $of:expr, $leaf_of:expr) => {
        impl $crate::KeyValue for $type {
            fn read(
                &mut self,
                node: &$crate::Node<'_>,
                range: $crate::Range,
                at: &$crate::Place<'_>,
            ) -> Result<(), $crate::SettingsError> {
                let (mut leaf, of): (_, fn($leaf) -> Result<Self, String>) = (<$leaf>::default(), $of);
                $crate::KeyValue::read(&mut leaf, node, range, at)?;
                *self = of(leaf).map_err(|what| at.error(what))?;
                Ok(())
            }

            fn check(&self, range: $crate::Range, at: &$crate::Place<'_>) -> Result<(), $crate::SettingsError> {
                let leaf_of: fn(&Self) -> $leaf = $leaf_of;
                $crate::KeyValue::check(&leaf_of(self), range, at)
            }

            fn kind(&self) -> String {
                String::from($kind)
            }

            fn text(&self) -> String {
                let leaf_of: fn(&Self) -> $leaf = $leaf_of;
                $crate::KeyValue::text(&leaf_of(self))
            }
        }
    };
}

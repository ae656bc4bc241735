//! Values that are no tables, read by `serde`.

use serde::Deserialize;
use serde::de::IntoDeserializer as _;

use crate::{KeyValue, Node, Place, Range, SettingsError};

/// Reads a value that is no table.
fn leaf<T: for<'de> Deserialize<'de>>(node: &Node<'_>, at: &Place<'_>) -> Result<T, SettingsError> {
    T::deserialize(node.clone().into_deserializer()).map_err(|error| at.error(error.message().replace('\n', " ")))
}

/// The error of a value of another type.
pub(crate) fn wrong_type(node: &Node<'_>, expected: &str, at: &Place<'_>) -> SettingsError {
    at.error(format!(
        "invalid type: {}, expected {expected}",
        node.get_ref().type_str()
    ))
}

macro_rules! leaves {
    ($( $type:ty, $kind:literal, $number:expr, $text:literal; )*) => { $(
        impl KeyValue for $type {
            fn read(&mut self, node: &Node<'_>, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
                *self = leaf(node, at)?;
                self.check(range, at)
            }

            fn check(&self, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
                let number: fn(&$type) -> Option<f64> = $number;
                number(self).map_or(Ok(()), |number| range.check(number, at))
            }

            fn kind(&self) -> String {
                $kind.to_owned()
            }

            fn text(&self) -> String {
                format!($text, self)
            }
        }
    )* };
}

leaves! {
    f64, "number", |value| Some(*value), "{:?}";
    u8, "whole number", |value| Some(f64::from(*value)), "{}";
    u32, "whole number", |value| Some(f64::from(*value)), "{}";
    i32, "whole number", |value| Some(f64::from(*value)), "{}";
    usize, "whole number", |value| Some(*value as f64), "{}";
    bool, "true or false", |_| None, "{}";
    String, "text", |_| None, "{:?}";
    (u32, f64), "[whole number, number]", |_| None, "{:?}";
}

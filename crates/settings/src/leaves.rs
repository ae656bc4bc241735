//! Values that are no tables, read by `serde`.

use serde::Deserialize;
use serde::de::IntoDeserializer as _;
use toml::de::DeValue;

use crate::{KeyValue, Node, Place, Range, SettingsError, unit_of};

/// Reads a value that is no table.
fn leaf<T: for<'de> Deserialize<'de>>(node: &Node<'_>) -> Option<T> {
    T::deserialize(node.clone().into_deserializer()).ok()
}

/// A value of the file in words: as the file spells it, if it is short.
pub(crate) fn found(node: &Node<'_>) -> String {
    match node.get_ref() {
        DeValue::String(text) => format!("\"{text}\""),
        DeValue::Integer(number) => number.to_string(),
        DeValue::Float(number) => number.to_string(),
        DeValue::Boolean(value) => value.to_string(),
        DeValue::Datetime(time) => time.to_string(),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}

/// The error of a value that is no `kind`; integers of the type have the range `limits`.
fn refused(node: &Node<'_>, kind: &str, limits: Range, range: Range, at: &Place<'_>) -> SettingsError {
    let (found, text) = (found(node), node.get_ref().as_str());
    if let (DeValue::Integer(number), true) = (node.get_ref(), limits != Range::Any) {
        let number =
            i128::from_str_radix(number.as_str(), number.radix()).map_or(f64::INFINITY, |number| number as f64);
        let outside = range.check(number, at).and_then(|()| limits.check(number, at));
        return outside
            .err()
            .unwrap_or_else(|| at.error(format!("{found} is no {kind}")));
    }
    let (unit, is_number) = (unit_of(at.name()), kind.ends_with("number"));
    at.error(match text {
        Some(text) if is_number && text.parse::<f64>().is_ok() => {
            format!("{found} is a text; write {text} without quotes")
        }
        Some(_) if is_number && !unit.is_empty() => {
            format!("{found} is no {kind}; write the number alone (the unit, {unit}, is in the name of the key)")
        }
        _ => match kind {
            "number" => format!("{found} is no number; write one like 2.5"),
            "whole number" => format!("{found} is no whole number; write one like 3"),
            "true or false" => format!("{found} is neither true nor false; write one of them, without quotes"),
            "text" => format!("{found} is no text; write a text in quotes"),
            _ => format!("{found} is no {kind}; write {kind}"),
        },
    })
}

macro_rules! leaves {
    ($( $type:ty, $kind:literal, $limits:expr, $number:expr, $text:literal; )*) => { $(
        impl KeyValue for $type {
            fn read(&mut self, node: &Node<'_>, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
                *self = leaf(node).ok_or_else(|| refused(node, $kind, $limits, range, at))?;
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
    f64, "number", Range::Any, |value| Some(*value), "{:?}";
    u8, "whole number", Range::Within(0.0, 255.0), |value| Some(f64::from(*value)), "{}";
    u32, "whole number", Range::Within(0.0, u32::MAX as f64), |value| Some(f64::from(*value)), "{}";
    i32, "whole number", Range::Within(i32::MIN as f64, i32::MAX as f64), |value| Some(f64::from(*value)), "{}";
    usize, "whole number", Range::From(0.0), |value| Some(*value as f64), "{}";
    bool, "true or false", Range::Any, |_| None, "{}";
    String, "text", Range::Any, |_| None, "{:?}";
    (u32, f64), "[whole number, number]", Range::Any, |_| None, "{:?}";
}

//! Check of everything that an order states of itself.

use crate::designated_place::DesignatedPlace;
use crate::order::{Order, Refusal};
use crate::order_kind::{OrderKind, Parameter};

/// Checks everything that an order states of itself: kind, parameters, range of the value, text.
///
/// # Errors
/// The reason for which every fusion refuses the order.
pub fn check(order: &Order) -> Result<OrderKind, Refusal> {
    let kind = OrderKind::from_code(order.kind).ok_or(Refusal::UnknownKind)?;
    let texts = [&order.name, &order.operator_name];
    if !texts.into_iter().all(is_text) || order.ends_ns <= 0 || order.token == 0 {
        return Err(Refusal::Malformed);
    }
    if kind.needs().iter().any(|parameter| !order.states(*parameter)) {
        return Err(Refusal::MissingParameter);
    }
    let is_known = |parameter: &Parameter| {
        kind.needs()
            .iter()
            .chain(kind.may())
            .any(|known| known.field() == parameter.field())
    };
    if Parameter::ALL.iter().any(|each| order.states(*each) && !is_known(each)) {
        return Err(Refusal::ForeignParameter);
    }
    let (low, high) = kind.range();
    if !order.value.is_nan() && !(low..=high).contains(&order.value) {
        return Err(Refusal::OutOfRange);
    }
    if kind.needs().contains(&Parameter::Place) && DesignatedPlace::read(order.name()).is_none() {
        return Err(Refusal::NoPlace);
    }
    Ok(kind)
}

/// Returns whether the bytes are UTF-8 without control characters, padded with zeros.
fn is_text(bytes: &[u8; 32]) -> bool {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    let (text, padding) = bytes.split_at(end);
    padding.iter().all(|byte| *byte == 0)
        && std::str::from_utf8(text).is_ok_and(|text| !text.chars().any(char::is_control))
}

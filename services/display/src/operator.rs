//! Orders that operators give on pages and by scripts.
//!
//! `POST /api/order` takes a JSON object: `kind`, the parameters of the kind ([`messages::OrderKind`]), `operator`, and
//! `for_s`, the time after which the order expires. The answer is the state of the order. The guard admits operators
//! only; the queue bounds their rate.

use std::sync::Arc;

use messages::{NS_PER_S, Order, OrderStatus};
use runtime::Now;
use serde_json::{Map, Value};
use web::axum::body::Bytes;
use web::axum::extract::State;
use web::axum::http::{HeaderMap, StatusCode, header};
use web::axum::response::{IntoResponse as _, Response};
use web::tokio::time::timeout;

use crate::orders::{PATIENCE, shown};
use crate::shared::SharedState;
use crate::world::World;

/// Path of orders.
pub(crate) const ORDER: &str = "/api/order";
/// Path at which operators show their token once.
pub(crate) const LOGIN: &str = "/api/operator";
/// Maximum size of a request, bytes.
const REQUEST_MAX: usize = 4096;

/// Answers `POST /api/order`.
pub(crate) async fn order(State(shared): State<Arc<SharedState>>, headers: HeaderMap, body: Bytes) -> Response {
    let refused = |status: StatusCode, text: &str| (status, format!("{text}\n")).into_response();
    let is_json = headers
        .get(header::CONTENT_TYPE)
        .is_some_and(|kind| kind.as_bytes().starts_with(b"application/json"));
    if !is_json || body.len() > REQUEST_MAX {
        return refused(
            StatusCode::UNSUPPORTED_MEDIA_TYPE,
            "An order is a JSON object of at most 4096 bytes.",
        );
    }
    let now = (shared.clock)();
    let order = serde_json::from_slice(&body)
        .map_err(|error| format!("The order is no JSON object: {error}."))
        .and_then(|object: Map<String, Value>| read(&object, &shared.world(), now));
    let order = match order {
        Ok(order) => order,
        Err(error) => return refused(StatusCode::BAD_REQUEST, &error),
    };
    let Some(answer) = shared.orders.enter(order, now) else {
        return refused(StatusCode::TOO_MANY_REQUESTS, "Too many orders in a short time.");
    };
    match timeout(PATIENCE, answer).await {
        Ok(Ok(state)) => {
            let status = match state.status() {
                Some(OrderStatus::Refused) => StatusCode::CONFLICT,
                _ => StatusCode::OK,
            };
            let text = shown(&state, &shared.world()).to_string();
            (status, [(header::CONTENT_TYPE, "application/json")], text).into_response()
        }
        _ => refused(StatusCode::GATEWAY_TIMEOUT, "Fusion does not answer."),
    }
}

/// Reads an order.
fn read(object: &Map<String, Value>, world: &World, now: Now) -> Result<Order, String> {
    let mut words = Vec::new();
    let (mut kind, mut operator, mut ends_ns) = (None, None, i64::MAX);
    for (name, value) in object {
        match (name.as_str(), value) {
            ("kind", Value::String(word)) => kind = Some(word.as_str()),
            ("operator", Value::String(name)) if !name.is_empty() => operator = Some(name.as_str()),
            ("for_s", Value::Number(time)) => {
                let time_s = time.as_f64().filter(|time_s| (0.0..=1e9).contains(time_s));
                let time_s = time_s.ok_or("for_s must lie between 0 and 1e9")?;
                ends_ns = now.utc_ns.saturating_add((time_s * NS_PER_S) as i64);
            }
            (name, Value::String(text)) => words.push((name, text.clone())),
            (name, Value::Number(number)) => words.push((name, number.to_string())),
            (name, _) => return Err(format!("{name} must be a text or a number")),
        }
    }
    let number = |name: &str| {
        let mut sources = world.observed.configured_sources().iter();
        let source = sources.find(|source| source.name == name)?;
        Some(source.number)
    };
    let kind = kind.ok_or("The order needs a kind")?;
    let operator = operator.ok_or("The order needs an operator: a name for the records")?;
    let words = words.iter().map(|(name, value)| (*name, value.as_str()));
    let order = Order::parse(kind, words, number)?;
    Ok(Order {
        ends_ns,
        ..order.with_operator(operator)
    })
}

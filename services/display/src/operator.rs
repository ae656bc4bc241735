//! Requests of operators, from pages and scripts: orders, acts on alarms, kept views. The guard admits operators only.
//!
//! - `POST /api/order` takes a JSON object: `kind`, the parameters of the kind ([`messages::OrderKind`]), `operator`,
//!   and `for_s`, the time after which the order expires. The answer is the state of the order. The queue bounds the
//!   rate of orders.
//! - `POST /api/alarm`: `alarm` (its `id`), `act` (`acknowledge`, `shelve`, `restore`), `operator`, and for `shelve`
//!   `for_s`.
//! - `POST /api/views`: see [`crate::views`].

use std::sync::Arc;

use messages::{NS_PER_S, Order, OrderStatus};
use runtime::Now;
use serde_json::{Map, Value};
use web::axum::body::Bytes;
use web::axum::extract::State;
use web::axum::http::{HeaderMap, StatusCode, header};
use web::axum::response::{IntoResponse as _, Response};
use web::tokio::time::timeout;

use crate::alarm_book::{AlarmAct, AlarmId, SHELVED_MAX_S};
use crate::orders::{PATIENCE, shown};
use crate::shared::SharedState;
use crate::world::World;

/// Path of orders.
pub(crate) const ORDER: &str = "/api/order";
/// Path of acts on alarms.
pub(crate) const ALARM: &str = "/api/alarm";
/// Path of named views.
pub(crate) const VIEWS: &str = "/api/views";
/// Paths of `POST` requests of operators.
pub(crate) const PATHS: &[&str] = &[ORDER, ALARM, VIEWS];
/// Path at which operators show their token once.
pub(crate) const LOGIN: &str = "/api/operator";
/// Maximum size of a request, bytes.
const REQUEST_MAX: usize = 4096;
/// Maximum length of an operator's name, bytes.
const NAME_MAX: usize = 64;

/// Answers `POST /api/order`.
pub(crate) async fn order(State(shared): State<Arc<SharedState>>, headers: HeaderMap, body: Bytes) -> Response {
    let now = (shared.clock)();
    let order = object(&headers, &body).and_then(|object| {
        let order = read(&object, &shared.world(), now);
        order.map_err(|error| refused(StatusCode::BAD_REQUEST, &format!("{error}\n")).into())
    });
    let order = match order {
        Ok(order) => order,
        Err(refusal) => return *refusal,
    };
    let Some(answer) = shared.orders.enter(order, now) else {
        return refused(StatusCode::TOO_MANY_REQUESTS, "Too many orders in a short time.\n");
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
        _ => refused(StatusCode::GATEWAY_TIMEOUT, "Fusion does not answer.\n"),
    }
}

/// Answers `POST /api/alarm`.
pub(crate) async fn alarm(State(shared): State<Arc<SharedState>>, headers: HeaderMap, body: Bytes) -> Response {
    done(object(&headers, &body), |object| {
        let now_ns = (shared.clock)().utc_ns;
        let (id, operator) = (text(object, "alarm")?, name(object)?);
        let id: AlarmId = id.parse().map_err(|()| format!("There is no alarm {id}"))?;
        let act = match text(object, "act")? {
            "acknowledge" => AlarmAct::Acknowledge,
            "restore" => AlarmAct::Restore,
            "shelve" => {
                let time_s = object.get("for_s").and_then(Value::as_f64);
                let time_s = time_s.filter(|time_s| (1.0..=SHELVED_MAX_S).contains(time_s));
                let time_s = time_s.ok_or_else(|| format!("for_s must lie between 1 and {SHELVED_MAX_S}"))?;
                AlarmAct::Shelve(now_ns.saturating_add((time_s * NS_PER_S) as i64))
            }
            _ => return Err("The act must be acknowledge, shelve or restore".to_owned()),
        };
        shared.world().alarm_book.act(&id, act, operator, now_ns)
    })
}

/// Answers `POST /api/views`.
pub(crate) async fn view(State(shared): State<Arc<SharedState>>, headers: HeaderMap, body: Bytes) -> Response {
    done(object(&headers, &body), |object| {
        let address = match object.get("address") {
            Some(Value::Null) => None,
            _ => Some(text(object, "address")?),
        };
        shared.desk.views.keep(text(object, "name")?, address, name(object)?)
    })
}

/// Answers a request whose object is used as `act` says.
fn done(
    object: Result<Map<String, Value>, Box<Response>>,
    act: impl FnOnce(&Map<String, Value>) -> Result<(), String>,
) -> Response {
    match object.map(|object| act(&object)) {
        Ok(Ok(())) => StatusCode::NO_CONTENT.into_response(),
        Ok(Err(error)) => refused(StatusCode::CONFLICT, &format!("{error}.\n")),
        Err(refusal) => *refusal,
    }
}

/// Reads the object in a request.
///
/// # Errors
/// The answer to a request without one.
fn object(headers: &HeaderMap, body: &Bytes) -> Result<Map<String, Value>, Box<Response>> {
    let kind = headers.get(header::CONTENT_TYPE);
    let is_json = kind.is_some_and(|kind| kind.as_bytes().starts_with(b"application/json"));
    if !is_json || body.len() > REQUEST_MAX {
        let text = "The request must be a JSON object of at most 4096 bytes.\n";
        return Err(refused(StatusCode::UNSUPPORTED_MEDIA_TYPE, text).into());
    }
    serde_json::from_slice(body).map_err(|error| {
        let text = format!("The request is no JSON object: {error}.\n");
        refused(StatusCode::BAD_REQUEST, &text).into()
    })
}

fn refused(status: StatusCode, text: &str) -> Response {
    (status, text.to_owned()).into_response()
}

/// Returns a text of an object.
fn text<'a>(object: &'a Map<String, Value>, name: &str) -> Result<&'a str, String> {
    let value = object.get(name).and_then(Value::as_str);
    value.ok_or_else(|| format!("{name} must be a text"))
}

/// Returns the operator's name.
fn name(object: &Map<String, Value>) -> Result<&str, String> {
    let name = text(object, "operator")?;
    let is_name = !name.trim().is_empty() && name.len() <= NAME_MAX;
    is_name
        .then_some(name)
        .ok_or_else(|| format!("operator must be a name of 1 to {NAME_MAX} bytes"))
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

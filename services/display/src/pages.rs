//! HTTP server of the display: the picture, its socket, and JSON for scripts.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use frames::SystemFrame;
use runtime::Now;
use serde_json::{Value, json};
use web::axum::Router;
use web::axum::extract::ws::{CloseFrame, Message, WebSocket, WebSocketUpgrade, close_code};
use web::axum::extract::{Path, RawQuery, State};
use web::axum::http::{StatusCode, header};
use web::axum::response::{IntoResponse, Response};
use web::axum::routing::{get, post};
use web::tokio::time::{MissedTickBehavior, interval, timeout};

use crate::assets::asset;
use crate::coverage_json;
use crate::details;
use crate::events;
use crate::foxglove;
use crate::ground;
use crate::moments::{self, Moments, Seen};
use crate::operator;
use crate::orders;
use crate::seat::{PATIENCE, Parting, Seat, WAITING_MAX};
use crate::shared::SharedState;
use crate::status;
use crate::trails;
use crate::viewer::Viewer;
use crate::wire::{LAYER_AGE_S, MESSAGE_MAX, RATE_HZ, SELECT_MAX, STATION_AGE_S, Wish};
use crate::world::World;

/// Time between two status messages, nanoseconds.
const STATUS_NS: i64 = 1_000_000_000;

/// Creates the router of all pages that look at `moments`.
pub(crate) fn router(moments: Moments) -> Router {
    let text = |of: fn(&World, Now) -> Value| {
        move |Seen(shared): Seen| async move {
            let world = shared.world();
            answer(&of(&world, world.now((shared.clock)())))
        }
    };
    Router::new()
        .route("/", get(|| async { file("index.html") }))
        .route("/{name}", get(|Path(name): Path<String>| async move { file(&name) }))
        .route("/ws", get(socket))
        .route(foxglove::FOXGLOVE, get(foxglove::foxglove))
        .route(events::EVENTS, get(events::events))
        .route("/coast", get(coast))
        .route("/api/overlays.json", get(overlays))
        .route("/api/tracks.json", get(text(details::tracks)))
        .route("/api/sources.json", get(text(status::sources)))
        .route(
            "/api/orders.json",
            get(text(
                |world, _| json!({"orders": orders::list(world), "kinds": orders::kinds()}),
            )),
        )
        .route("/api/alarms.json", get(text(status::alarms_and_past)))
        .route("/api/views.json", get(views))
        .route(operator::ORDER, post(operator::order))
        .route(operator::ALARM, post(operator::alarm))
        .route(operator::VIEWS, post(operator::view))
        .route("/api/history/{file}", get(history))
        .route("/api/track/{file}", get(track))
        .route("/api/trails", get(trails))
        .route(
            "/api/coverage.json",
            get(text(|world, _| coverage_json::coverage(world))),
        )
        .route(
            "/api/coverage.geojson",
            get(text(|world, _| coverage_json::geojson(world))),
        )
        .route("/data/aircraft.json", get(text(details::aircraft)))
        .route("/data/receiver.json", get(text(|world, _| details::receiver(world))))
        .fallback(|| async { not_found() })
        .with_state(moments)
}

fn not_found() -> Response {
    (StatusCode::NOT_FOUND, "There is nothing of this name here.\n").into_response()
}

fn file(name: &str) -> Response {
    match asset(name) {
        Some((_, media_type, octets)) => octets_of(media_type, *octets),
        None => not_found(),
    }
}

fn octets_of(media_type: &'static str, octets: impl IntoResponse) -> Response {
    // Another version of this executable has other files under the same names.
    (
        [(header::CONTENT_TYPE, media_type), (header::CACHE_CONTROL, "no-cache")],
        octets,
    )
        .into_response()
}

fn answer(value: &Value) -> Response {
    octets_of("application/json", value.to_string())
}

async fn track(Seen(shared): Seen, Path(file): Path<String>) -> Response {
    let number = file.strip_suffix(".json").and_then(|number| number.parse().ok());
    let found = number.and_then(|number| details::reasoned(&shared.world(), number));
    found.as_ref().map_or_else(not_found, answer)
}

async fn history(Seen(shared): Seen, Path(file): Path<String>) -> Response {
    let number = file.strip_suffix(".json").and_then(|number| number.parse().ok());
    let found = number.and_then(|number| details::history(&shared.world(), number, i64::MAX));
    found.as_ref().map_or_else(not_found, answer)
}

async fn views(State(shared): State<Arc<SharedState>>) -> Response {
    answer(&shared.desk.views.list())
}

async fn trails(Seen(shared): Seen, RawQuery(query): RawQuery) -> Response {
    let query = query.unwrap_or_default();
    let given = query.split('&').find_map(|pair| pair.strip_prefix("until_s="));
    let until_s: Option<f64> = given
        .and_then(|text| text.parse().ok())
        .filter(|until_s: &f64| until_s.abs() < 9e9);
    let world = shared.world();
    let until_ns = until_s.map_or_else(|| world.time_ns(world.now((shared.clock)())), frames::time::ns);
    octets_of("application/octet-stream", trails::trails(&world, until_ns))
}

async fn coast(State(shared): State<Arc<SharedState>>) -> Response {
    let frame = shared.world().observed.frame().copied();
    let made = frame.and_then(|frame| {
        let world = ground::coast(asset("coast.bin")?.2, &frame)?;
        // A file that was removed meanwhile leaves the world's coast.
        let own = shared
            .maps
            .coast
            .as_ref()
            .and_then(|path| read_coast(path, &frame).ok());
        Some(own.map_or(world.clone(), |land| ground::with_land(land, &world)))
    });
    made.map_or_else(not_found, |octets| octets_of("application/octet-stream", octets))
}

/// Reads polygons of land from the GeoJSON file `path`, in the form drawn by the page.
///
/// # Errors
/// A sentence, if the file cannot be read or has no polygons.
pub(crate) fn read_coast(path: &std::path::Path, frame: &SystemFrame) -> Result<Vec<u8>, String> {
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
    ground::land(&text, frame)
}

async fn overlays(State(shared): State<Arc<SharedState>>) -> Response {
    let frame = shared.world().observed.frame().copied();
    let made = frame.map(|frame| {
        shared
            .maps
            .overlays
            .iter()
            .map(|path| overlay(path, &frame))
            .collect::<Vec<_>>()
    });
    answer(&json!({"overlays": made.unwrap_or_default()}))
}

fn overlay(path: &std::path::Path, frame: &SystemFrame) -> Value {
    read_overlay(path, frame).unwrap_or_else(|error| json!({"name": name_of(path), "features": [], "error": error}))
}

/// Reads the overlay in the file `path`, in the form drawn by the page.
///
/// # Errors
/// A sentence, if the file cannot be read or drawn.
pub(crate) fn read_overlay(path: &std::path::Path, frame: &SystemFrame) -> Result<Value, String> {
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
    ground::overlay(&name_of(path), &text, frame)
}

fn name_of(path: &std::path::Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

async fn socket(State(moments): State<Moments>, RawQuery(query): RawQuery, upgrade: WebSocketUpgrade) -> Response {
    let shared = moments.enter(moments::window_in(query.as_deref()));
    let shares_moment = moments.is_common(&shared);
    let seat = match Seat::take(&shared) {
        Ok(seat) => seat,
        Err(refusal) => return *refusal,
    };
    upgrade
        .max_message_size(MESSAGE_MAX)
        .max_frame_size(MESSAGE_MAX)
        .read_buffer_size(MESSAGE_MAX)
        .max_write_buffer_size(WAITING_MAX)
        .on_upgrade(move |socket| async move {
            if look_on(socket, seat.shared(), shares_moment).await == Parting::Refused {
                seat.count_refused();
            }
        })
}

/// Serves one page until the connection ends.
async fn look_on(mut socket: WebSocket, shared: &SharedState, shares_moment: bool) -> Parting {
    let mut page = PageConnection::new(shared, shares_moment);
    let mut ticks = ticks(page.viewer.rate_hz());
    loop {
        let done = web::tokio::select! {
            message = socket.recv() => match message {
                Some(Ok(Message::Text(text))) => {
                    let rate_hz = page.viewer.rate_hz();
                    let heard = page.hear(text.as_str());
                    if page.viewer.rate_hz() != rate_hz {
                        ticks = self::ticks(page.viewer.rate_hz());
                    }
                    heard
                }
                Some(Ok(Message::Binary(_))) => Err("messages are text".to_owned()),
                Some(Ok(Message::Ping(_) | Message::Pong(_))) => Ok(()),
                Some(Ok(Message::Close(_))) | None => return Parting::Left,
                // Too long, or an invalid frame. A broken connection ends up here as well; the error does not
                // distinguish the two.
                Some(Err(_)) => return Parting::Refused,
            },
            _ = ticks.tick() => match page.show(&mut socket).await {
                Ok(()) => Ok(()),
                Err(parting) => return parting,
            },
        };
        if let Err(error) = done {
            let refused = json!({"type": "refused", "error": error}).to_string();
            let close = CloseFrame {
                code: close_code::POLICY,
                reason: "".into(),
            };
            for message in [Message::text(refused), Message::Close(Some(close))] {
                let _ = timeout(PATIENCE, socket.send(message)).await;
            }
            return Parting::Refused;
        }
    }
}

fn ticks(rate_hz: f64) -> web::tokio::time::Interval {
    let mut ticks = interval(Duration::from_secs_f64(1.0 / rate_hz));
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    ticks
}

/// Connection of one page.
struct PageConnection<'a> {
    shared: &'a SharedState,
    /// Whether the moment of a recording is that of further windows, too.
    shares_moment: bool,
    viewer: Viewer,
    /// Selected tracks with their history already sent.
    remembered: Vec<u32>,
    /// Generation of the world at that time.
    generation: u64,
    /// Whether the sent greeting had the frame's origin, and its number of sources; `None`: no greeting sent yet.
    greeted: Option<(bool, usize)>,
    /// Time of the next status, monotonic, nanoseconds.
    status_due_ns: i64,
    /// Deadline for the acknowledgement of the picture in transit.
    ack_until_ns: i64,
}

impl<'a> PageConnection<'a> {
    fn new(shared: &'a SharedState, shares_moment: bool) -> Self {
        Self {
            shared,
            shares_moment,
            viewer: Viewer::default(),
            remembered: Vec::new(),
            generation: 0,
            greeted: None,
            status_due_ns: i64::MIN,
            ack_until_ns: i64::MAX,
        }
    }

    fn hear(&mut self, text: &str) -> Result<(), String> {
        let mut wish = Wish::read(text)?;
        if wish.past.is_some() {
            // At another moment, the past of a track ends elsewhere.
            self.remembered.clear();
        }
        let now = (self.shared.clock)();
        if let Some(recording) = &mut self.shared.world().recording
            && let Some(past) = wish.past.take().flatten()
        {
            recording.want(past, now.mono_ns);
        }
        self.viewer.wish(wish, now);
        let selected = &self.viewer.selected;
        self.remembered.retain(|number| selected.contains(number));
        Ok(())
    }

    /// Sends the messages due.
    async fn show(&mut self, socket: &mut WebSocket) -> Result<(), Parting> {
        let messages = self.due()?;
        for message in messages {
            match timeout(PATIENCE, socket.send(message)).await {
                Ok(Ok(())) => {}
                Ok(Err(_)) => return Err(Parting::Left),
                Err(_) => return Err(Parting::Refused),
            }
        }
        Ok(())
    }

    fn due(&mut self) -> Result<Vec<Message>, Parting> {
        let (shared, now) = (self.shared, (self.shared.clock)());
        let mut messages = Vec::new();
        if self.viewer.is_behind() {
            shared.traffic.skipped.fetch_add(1, Ordering::Relaxed);
            return if now.mono_ns > self.ack_until_ns {
                Err(Parting::Refused)
            } else {
                Ok(messages)
            };
        }
        let world = shared.world();
        if world
            .recording
            .as_ref()
            .is_some_and(|recording| !recording.is_reached())
        {
            return Ok(messages);
        }
        let then = world.now(now);
        if self.generation != world.generation {
            self.generation = world.generation;
            self.remembered.clear();
        }
        let greeting = Some((world.observed.frame().is_some(), world.sources.len()));
        if self.greeted != greeting {
            self.greeted = greeting;
            messages.push(hello(&world, shared.desk.has_operators, self.shares_moment));
        }
        messages.push(Message::binary(self.viewer.picture(&world, then)));
        self.ack_until_ns = now.mono_ns + PATIENCE.as_nanos() as i64;
        shared.traffic.sent.fetch_add(1, Ordering::Relaxed);
        if !self.viewer.selected.is_empty() {
            let time_ns = self.viewer.past_ns(&world, then).unwrap_or_else(|| world.time_ns(then));
            for number in &self.viewer.selected {
                if !self.remembered.contains(number) {
                    self.remembered.push(*number);
                    let past = details::history(&world, *number, time_ns);
                    messages.extend(past.map(|past| Message::text(past.to_string())));
                }
            }
            let selected = details::selected(&world, &self.viewer, time_ns);
            messages.push(Message::text(selected.to_string()));
        }
        if now.mono_ns >= self.status_due_ns {
            self.status_due_ns = now.mono_ns + STATUS_NS;
            let status = status::status(&world, shared.audience(), then);
            messages.push(Message::text(status.to_string()));
        }
        Ok(messages)
    }
}

fn hello(world: &World, has_operators: bool, shares_moment: bool) -> Message {
    let sources = world.sources.iter().map(|fact| {
        let source = &fact.source;
        json!({"number": source.number, "name": source.name, "kind": fact.kind, "site_m": fact.site_m})
    });
    let origin = world.observed.origin().map(|origin| {
        json!({
            "latitude_deg": origin.latitude_deg,
            "longitude_deg": origin.longitude_deg,
            "height_m": origin.height_m,
        })
    });
    let recording = world.recording.as_ref().map(|recording| {
        let [from_s, to_s] = recording.span_ns.map(details::seconds);
        json!({
            "name": recording.name,
            "from_s": from_s,
            "to_s": to_s,
            "time_s": details::seconds(recording.at_ns),
            "speed": recording.wanted.speed,
            "shares_moment": shares_moment,
        })
    });
    let hello = json!({
        "type": "hello",
        "version": env!("CARGO_PKG_VERSION"),
        "instance": world.instance,
        "origin": origin,
        "sources": sources.collect::<Vec<_>>(),
        "declination_deg": world.declination_deg,
        "history_s": world.history_s,
        "layer_age_s": LAYER_AGE_S,
        "station_age_s": STATION_AGE_S,
        "recording": recording,
        "operators": has_operators,
        "labels": world.labels.message(),
        "limits": {"rate_hz": RATE_HZ, "select": SELECT_MAX},
    });
    Message::text(hello.to_string())
}

#[cfg(test)]
#[path = "pages_tests.rs"]
pub(crate) mod tests;

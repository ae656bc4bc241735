//! Samples for Foxglove and Lichtblick: a WebSocket with the subprotocols `foxglove.websocket.v1` and
//! `foxglove.sdk.v1`, which agree in all messages used here.
//!
//! The server announces each topic as a channel with its ROS 2 schema; samples are CDR, the same bytes as in a
//! recording. The client subscribes to channels. Everything else that clients may ask for is refused: the server only
//! sends.
//!
//! A client that is too slow loses the oldest slices, which are counted, and is informed by a status message.
//!
//! Source of the protocol: <https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md>.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use futures_util::SinkExt as _;
use serde::Deserialize;
use serde_json::{Value, json};
use web::axum::extract::State;
use web::axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use web::axum::http::StatusCode;
use web::axum::response::{IntoResponse, Response};
use web::tokio::time::timeout;

use crate::feed::{Fed, FeedReader, FeedSlice};
use crate::seat::{PATIENCE, Parting, Seat, WAITING_MAX};
use crate::shared::SharedState;

/// Path of the WebSocket.
pub(crate) const FOXGLOVE: &str = "/foxglove";
/// Subprotocols, the preferred first.
const SUBPROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];
/// Greatest message of a client, bytes: it may name thousands of channels.
const MESSAGE_MAX: usize = 1 << 18;
/// Opcode of a sample.
const MESSAGE_DATA: u8 = 1;
/// Levels of a status message.
const WARNING: u8 = 1;
const ERROR: u8 = 2;

/// Message of a client.
#[derive(Debug, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
enum Request {
    Subscribe {
        subscriptions: Vec<Subscription>,
    },
    #[serde(rename_all = "camelCase")]
    Unsubscribe {
        subscription_ids: Vec<u32>,
    },
    #[serde(other)]
    Unknown,
}

/// Subscription to a channel.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Subscription {
    id: u32,
    channel_id: u32,
}

/// Answers the request for a WebSocket.
pub(crate) async fn foxglove(State(shared): State<Arc<SharedState>>, upgrade: WebSocketUpgrade) -> Response {
    let upgrade = upgrade.protocols(SUBPROTOCOLS);
    if upgrade.selected_protocol().is_none() {
        shared.traffic.refused.fetch_add(1, Ordering::Relaxed);
        let text = format!("The subprotocol has to be one of {}.\n", SUBPROTOCOLS.join(", "));
        return (StatusCode::BAD_REQUEST, text).into_response();
    }
    let seat = match Seat::take(&shared) {
        Ok(seat) => seat,
        Err(refusal) => return *refusal,
    };
    upgrade
        .max_message_size(MESSAGE_MAX)
        .max_frame_size(MESSAGE_MAX)
        .max_write_buffer_size(WAITING_MAX)
        .on_upgrade(move |socket| async move {
            let mut client = FoxgloveClient {
                reader: FeedReader::new(&shared.feed),
                subscriptions: BTreeMap::new(),
                shared,
            };
            if client.serve(socket).await == Parting::Refused {
                seat.count_refused();
            }
        })
}

/// A connected client.
struct FoxgloveClient {
    shared: Arc<SharedState>,
    reader: FeedReader,
    /// Number of each subscription, by the place of its topic.
    subscriptions: BTreeMap<usize, u32>,
}

impl FoxgloveClient {
    async fn serve(&mut self, mut socket: WebSocket) -> Parting {
        let instance = self.shared.world().instance.clone();
        let info = json!({"op": "serverInfo", "name": format!("koseki {instance}"), "capabilities": []});
        let mut messages = vec![text(&info), text(&self.advertisement())];
        loop {
            if let Err(parting) = send(&mut socket, messages).await {
                return parting;
            }
            messages = web::tokio::select! {
                message = socket.recv() => match message {
                    Some(Ok(Message::Text(text))) => match serde_json::from_str(text.as_str()) {
                        Ok(request) => self.take(request),
                        Err(_) => return Parting::Refused,
                    },
                    Some(Ok(Message::Binary(_))) => vec![status(ERROR, "clients may not send data here")],
                    Some(Ok(Message::Ping(_) | Message::Pong(_))) => Vec::new(),
                    Some(Ok(Message::Close(_))) | None => return Parting::Left,
                    Some(Err(_)) => return Parting::Refused,
                },
                fed = self.reader.next() => match fed {
                    Some(Fed::Slice(slice)) => self.samples(&slice),
                    Some(Fed::Lost(slices)) => {
                        self.shared.traffic.skipped.fetch_add(slices, Ordering::Relaxed);
                        vec![status(WARNING, &format!("too slow: {slices} slices of samples are lost"))]
                    }
                    None => return Parting::Left,
                },
            };
        }
    }

    fn advertisement(&self) -> Value {
        let channels = self.reader.feed().channels().iter().enumerate();
        let channels = channels.map(|(place, channel)| {
            json!({
                "id": place,
                "topic": channel.topic,
                "encoding": "cdr",
                "schemaName": recording::schema_name(channel.layout),
                "schemaEncoding": "ros2msg",
                "schema": channel.layout.ros2_schema(),
            })
        });
        json!({"op": "advertise", "channels": channels.collect::<Vec<_>>()})
    }

    /// Takes a request. Returns the answers: there are none to valid requests.
    fn take(&mut self, request: Request) -> Vec<Message> {
        match request {
            Request::Subscribe { subscriptions } => {
                let refused = subscriptions.into_iter().filter_map(|wish| self.subscribe(&wish).err());
                refused.map(|error| status(ERROR, &error)).collect()
            }
            Request::Unsubscribe { subscription_ids } => {
                let reader = &mut self.reader;
                self.subscriptions.retain(|place, id| {
                    let is_kept = !subscription_ids.contains(id);
                    if !is_kept {
                        reader.remove(*place);
                    }
                    is_kept
                });
                Vec::new()
            }
            Request::Unknown => vec![status(
                ERROR,
                "this server only sends: subscribe and unsubscribe are possible",
            )],
        }
    }

    fn subscribe(&mut self, wish: &Subscription) -> Result<(), String> {
        let place = wish.channel_id as usize;
        if place >= self.reader.feed().channels().len() {
            return Err(format!("there is no channel {}", wish.channel_id));
        }
        if self.subscriptions.values().any(|id| *id == wish.id) {
            return Err(format!("subscription {} exists", wish.id));
        }
        if !self.reader.add(place) {
            return Err(format!("channel {} has a subscription", wish.channel_id));
        }
        self.subscriptions.insert(place, wish.id);
        Ok(())
    }

    /// Returns the messages with the samples of a slice.
    fn samples(&self, slice: &FeedSlice) -> Vec<Message> {
        let Some(id) = self.subscriptions.get(&slice.channel) else {
            return Vec::new();
        };
        let time_ns = slice.taken_ns.max(0) as u64;
        let message = |sample: &[u8]| {
            let head = [&[MESSAGE_DATA][..], &id.to_le_bytes(), &time_ns.to_le_bytes()].concat();
            Message::binary([&head[..], &recording::CDR, sample].concat())
        };
        slice.samples().map(message).collect()
    }
}

fn text(message: &Value) -> Message {
    Message::text(message.to_string())
}

fn status(level: u8, message: &str) -> Message {
    text(&json!({"op": "status", "level": level, "message": message}))
}

async fn send(socket: &mut WebSocket, messages: Vec<Message>) -> Result<(), Parting> {
    let sending = async {
        for message in messages {
            socket.feed(message).await?;
        }
        socket.flush().await
    };
    match timeout(PATIENCE, sending).await {
        Ok(Ok(())) => Ok(()),
        Ok(Err(_)) => Err(Parting::Left),
        Err(_) => Err(Parting::Refused),
    }
}

//! Samples as server-sent events: `GET /api/events?topics=tracks,alarms`.
//!
//! Each sample is an event, named by the topic as it was requested; its data are the line of `koseki tap`. A reader
//! that falls behind gets the event `lost`, and the connection ends: it may connect again. No queue grows.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use futures_util::Stream;
use futures_util::stream::unfold;
use serde_json::json;
use web::LongAnswer;
use web::axum::extract::{RawQuery, State};
use web::axum::http::{StatusCode, header};
use web::axum::response::sse::{Event, KeepAlive, Sse};
use web::axum::response::{IntoResponse, Response};

use crate::feed::{Fed, Feed, FeedReader, FeedSlice};
use crate::seat::Seat;
use crate::shared::SharedState;

/// Path of the events.
pub(crate) const EVENTS: &str = "/api/events";
/// Topics of a request without any.
const TOPICS: &str = "tracks";
/// Time after which a comment is sent if there is no sample: the server then sees whether the client still reads.
const COMMENT_EVERY: Duration = Duration::from_secs(4);

/// Reader of events.
struct EventReader {
    reader: FeedReader,
    seat: Seat,
    /// The wanted topics: place, and name as requested.
    topics: Vec<(usize, String)>,
    /// Slice that is being sent, and the number of its samples that were sent.
    slice: Option<(Arc<FeedSlice>, usize)>,
    is_over: bool,
}

impl EventReader {
    async fn next(mut self) -> Option<(Result<Event, Infallible>, Self)> {
        loop {
            if self.is_over {
                return None;
            }
            if let Some((slice, sent)) = &mut self.slice {
                if let Some(line) = slice.lines(self.reader.feed()).get(*sent) {
                    *sent += 1;
                    let place = slice.channel;
                    let topic = self.topics.iter().find(|(wanted, _)| *wanted == place);
                    let name = topic.map(|(_, name)| name.as_str()).unwrap_or_default();
                    let event = Event::default().event(name).data(line);
                    return Some((Ok(event), self));
                }
                self.slice = None;
            }
            match self.reader.next().await? {
                Fed::Slice(slice) => self.slice = Some((slice, 0)),
                Fed::Lost(slices) => {
                    self.seat.count_refused();
                    self.is_over = true;
                    let lost = json!({"slices": slices}).to_string();
                    return Some((Ok(Event::default().event("lost").data(lost)), self));
                }
            }
        }
    }
}

/// Answers with the events of the requested topics.
pub(crate) async fn events(State(shared): State<Arc<SharedState>>, RawQuery(query): RawQuery) -> Response {
    let topics = match topics(&shared.feed, query.as_deref().unwrap_or_default()) {
        Ok(topics) => topics,
        Err(text) => return (StatusCode::NOT_FOUND, text).into_response(),
    };
    let seat = match Seat::take(&shared) {
        Ok(seat) => seat,
        Err(refusal) => return *refusal,
    };
    let mut reader = FeedReader::new(&shared.feed);
    for (place, _) in &topics {
        reader.add(*place);
    }
    let events = unfold(
        EventReader {
            reader,
            seat,
            topics,
            slice: None,
            is_over: false,
        },
        EventReader::next,
    );
    answer(events)
}

fn answer(events: impl Stream<Item = Result<Event, Infallible>> + Send + 'static) -> Response {
    let events = Sse::new(events).keep_alive(KeepAlive::new().interval(COMMENT_EVERY));
    let mut answer = ([(header::CACHE_CONTROL, "no-store")], events).into_response();
    answer.extensions_mut().insert(LongAnswer);
    answer
}

/// Returns the topics of a query, `topics=tracks,alarms`: place, and name as requested.
///
/// # Errors
/// A line, if there is no such topic.
fn topics(feed: &Feed, query: &str) -> Result<Vec<(usize, String)>, String> {
    let given = query.split('&').find_map(|pair| pair.strip_prefix("topics="));
    // Names of topics contain no character that is escaped, except the slash and the comma, by some clients.
    let given = given
        .unwrap_or(TOPICS)
        .replace("%2F", "/")
        .replace("%2f", "/")
        .replace("%2C", ",");
    let known = feed.channels();
    if known.is_empty() {
        return Err("A recording has no events.\n".to_owned());
    }
    let place = |name: &str| {
        let place = feed.place_of(name).map(|place| (place, name.to_owned()));
        place.ok_or_else(|| {
            let known: Vec<&str> = known.iter().map(|channel| channel.topic.as_str()).collect();
            format!("There is no topic \"{name}\" here; the topics: {}\n", known.join(", "))
        })
    };
    given.replace("%2c", ",").split(',').map(place).collect()
}

//! Seats of the connected clients: pages, readers of events, Foxglove.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use web::axum::http::StatusCode;
use web::axum::response::{IntoResponse, Response};

use crate::shared::SharedState;

/// Maximum number of pages at a time.
pub(crate) const PAGES_MAX: u64 = 32;
/// Maximum time to send a message and to acknowledge a picture. A page in the background is slow, not dead.
pub(crate) const PATIENCE: Duration = Duration::from_secs(30);
/// Maximum size of queued messages, bytes, beside the operating system's buffers.
pub(crate) const WAITING_MAX: usize = 16 << 20;

/// Seat of a connected page; its drop frees the seat.
pub(crate) struct Seat(Arc<SharedState>);

impl Seat {
    /// Takes a seat.
    ///
    /// # Errors
    /// If all are taken: the answer to the client, whose refusal is counted.
    pub(crate) fn take(shared: &Arc<SharedState>) -> Result<Self, Box<Response>> {
        let pages = &shared.traffic.pages;
        let taken = pages.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |pages| {
            (pages < PAGES_MAX).then_some(pages + 1)
        });
        match taken {
            Ok(_) => Ok(Self(Arc::clone(shared))),
            Err(_) => {
                shared.traffic.refused.fetch_add(1, Ordering::Relaxed);
                Err(Box::new(
                    (StatusCode::SERVICE_UNAVAILABLE, "Too many pages look on.\n").into_response(),
                ))
            }
        }
    }

    /// Returns the state that the client looks at.
    pub(crate) fn shared(&self) -> &SharedState {
        &self.0
    }

    /// Counts the refusal of the page.
    pub(crate) fn count_refused(&self) {
        self.0.traffic.refused.fetch_add(1, Ordering::Relaxed);
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.0.traffic.pages.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Reason for the end of a page's connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parting {
    /// Closed by the page.
    Left,
    /// Refused: a browser was too slow, or its message could not be read.
    Refused,
}

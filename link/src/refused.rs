//! Counts connections that were turned away: by a certificate that nobody vouches for, by a wrong password.
//!
//! Zenoh tells of them in its log alone, at two places, each once for each connection. So this process listens to those
//! two, and to nothing else.

use std::fmt::Debug;
use std::sync::atomic::{AtomicU64, Ordering};

use tracing::field::{Field, Visit};
use tracing::level_filters::LevelFilter;
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Level, Metadata, Subscriber};

/// Where handshakes of links end that others have begun, and what is said of those that end well.
const HANDSHAKES: (&str, Level) = ("zenoh_transport::unicast::establishment::accept", Level::DEBUG);
const ACCEPTED: &str = "New transport link accepted";
/// One that both sides have begun at once is closed without harm.
const TWICE: &str = "max links";
/// Where handshakes of TLS fail.
const OF_TLS: (&str, Level) = ("zenoh_link_tls::unicast", Level::WARN);

static REFUSED: AtomicU64 = AtomicU64::new(0);

/// Counts from now on.
pub(crate) fn count() {
    // Somebody else who listens would count.
    let _ = tracing::subscriber::set_global_default(Listener);
}

/// Connections of others that this process has turned away.
pub(crate) fn so_far() -> u64 {
    REFUSED.load(Ordering::Relaxed)
}

struct Listener;

impl Subscriber for Listener {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        [HANDSHAKES, OF_TLS].contains(&(metadata.target(), *metadata.level()))
    }

    fn max_level_hint(&self) -> Option<LevelFilter> {
        Some(LevelFilter::DEBUG)
    }

    fn event(&self, event: &Event<'_>) {
        let mut said = Said(String::new());
        event.record(&mut said);
        if !said.0.starts_with(ACCEPTED) && !said.0.to_lowercase().contains(TWICE) {
            REFUSED.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }

    fn record(&self, _: &Id, _: &Record<'_>) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}
}

/// The message of an event.
struct Said(String);

impl Visit for Said {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        if field.name() == "message" {
            self.0 = format!("{value:?}");
        }
    }
}

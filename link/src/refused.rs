//! Failed connections with their causes: incoming connections rejected by this process, and outgoing connections
//! rejected by peers.
//!
//! Zenoh reports both in its log alone. So this process listens to the few places of that log, and puts each message
//! into one of the [`FailureCause`]s.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::{Mutex, MutexGuard, PoisonError};

use runtime::clock::mono_ns;
use tracing::field::{Field, Visit};
use tracing::level_filters::LevelFilter;
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Level, Metadata, Subscriber};

/// A part of Zenoh that reports failures at a level of its log.
type LogTarget = (&'static str, Level);
/// Handshakes of links that others have begun.
const HANDSHAKES: LogTarget = ("zenoh_transport::unicast::establishment::accept", Level::DEBUG);
const ACCEPTED: &str = "New transport link accepted";
/// A connection that both sides have begun at once is closed without harm.
const TWICE: &str = "max links";
/// Handshakes of TLS that others have begun.
const OF_TLS: LogTarget = ("zenoh_link_tls::unicast", Level::WARN);
/// Sessions of others that the access control gives nothing.
const UNNAMED: LogTarget = ("zenoh::net::routing::interceptor::access_control", Level::INFO);
/// In lower case, as messages are compared.
const NO_SUBJECT: &str = "did not match any configured acl subject";
/// Connections of this process.
const OWN: LogTarget = ("zenoh::net::runtime::orchestrator", Level::DEBUG);
const FAILED: &str = "Unable to connect to";
/// Time after which a failure of an own connection is no news, nanoseconds: longer than the pause between two tries.
const NEWS_NS: i64 = 5_000_000_000;

/// Why a connection failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum FailureCause {
    Expired,
    OtherAuthority,
    OtherName,
    NoCertificate,
    User,
    Unnamed,
    /// Bytes that are no handshake, or none within the time.
    NoHandshake,
    NobodyListens,
    Unreachable,
}

impl FailureCause {
    /// The cause of a message of the log about a connection.
    fn of(message: &str) -> Self {
        let causes: [(&[&str], Self); 8] = [
            (&["expired"], Self::Expired),
            (
                &[
                    "unknownissuer",
                    "unknownca",
                    "badsignature",
                    "decrypterror",
                    "badcertificate",
                ],
                Self::OtherAuthority,
            ),
            (&["notvalidforname"], Self::OtherName),
            (
                &["certificaterequired", "nocertificatespresented", "sent no certificates"],
                Self::NoCertificate,
            ),
            // The other side ends the handshake of a link, after that of TLS, for no other reason.
            (
                &["usrpwd", "invalid user", "invalid password", "in response to an"],
                Self::User,
            ),
            (&[NO_SUBJECT], Self::Unnamed),
            (&["connection refused"], Self::NobodyListens),
            (
                &["timed out", "timeout", "unreachable", "no route", "lookup"],
                Self::Unreachable,
            ),
        ];
        let message = message.to_lowercase();
        let found = causes
            .iter()
            .find(|(words, _)| words.iter().any(|word| message.contains(word)));
        found.map_or(Self::NoHandshake, |(_, cause)| *cause)
    }

    /// Returns the description of a fault in another host's connection.
    fn of_other(self) -> &'static str {
        match self {
            Self::Expired => "certificate has expired",
            Self::OtherAuthority => "certificate of another authority",
            Self::OtherName => "certificate of another name",
            Self::NoCertificate => "no certificate",
            Self::User => "wrong user or password",
            Self::Unnamed => "not named in [[link.peer]]",
            Self::NoHandshake | Self::NobodyListens | Self::Unreachable => "no handshake of a link",
        }
    }

    /// Why a connection of this host failed.
    fn of_own(self) -> &'static str {
        match self {
            Self::Expired => "a certificate has expired",
            Self::OtherAuthority => "certificate of another authority",
            Self::OtherName => "certificate of another name",
            Self::NoCertificate => "it wants a certificate",
            Self::User => "wrong user or password",
            Self::Unnamed => "not named there",
            Self::NoHandshake => "connection refused or lost",
            Self::NobodyListens => "nobody listens there",
            Self::Unreachable => "cannot be reached",
        }
    }
}

/// Failures so far.
#[derive(Debug)]
struct Failures {
    /// Connections of others, by cause.
    others: BTreeMap<FailureCause, u64>,
    /// The latest failure of an own connection, and when, monotonic, nanoseconds.
    own: Option<(FailureCause, i64)>,
}

static FAILURES: Mutex<Failures> = Mutex::new(Failures {
    others: BTreeMap::new(),
    own: None,
});

fn failures() -> MutexGuard<'static, Failures> {
    FAILURES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Counts from now on.
pub(crate) fn count() {
    // Another listener would count.
    let _ = tracing::subscriber::set_global_default(LogListener);
}

/// A connection of another that was silent, or one of too many, was turned away.
pub(crate) fn turn_away() {
    *failures().others.entry(FailureCause::NoHandshake).or_default() += 1;
}

/// Connections of others that this process has turned away.
pub(crate) fn so_far() -> u64 {
    failures().others.values().sum()
}

/// The same by cause, as notes.
pub(crate) fn notes() -> Vec<String> {
    let failures = failures();
    let notes = failures.others.iter();
    notes
        .map(|(cause, count)| format!("turned away {count}: {}", cause.of_other()))
        .collect()
}

/// Why the own connections fail at present; `None` if none has failed lately.
pub(crate) fn own() -> Option<&'static str> {
    let (cause, at_ns) = failures().own?;
    (mono_ns() - at_ns < NEWS_NS).then(|| cause.of_own())
}

/// Takes a message of the log.
fn take((target, level): (&str, Level), message: &str) {
    let place = |place: LogTarget| place == (target, level);
    if place(OWN) {
        // A connection begun by both sides at once exists already.
        if message.starts_with(FAILED) && !message.to_lowercase().contains(TWICE) {
            failures().own = Some((FailureCause::of(message), mono_ns()));
        }
        return;
    }
    let is_sound = (place(HANDSHAKES) && (message.starts_with(ACCEPTED) || message.to_lowercase().contains(TWICE)))
        || (place(UNNAMED) && !message.to_lowercase().contains(NO_SUBJECT));
    if !is_sound {
        *failures().others.entry(FailureCause::of(message)).or_default() += 1;
    }
}

struct LogListener;

impl Subscriber for LogListener {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        [HANDSHAKES, OF_TLS, UNNAMED, OWN].contains(&(metadata.target(), *metadata.level()))
    }

    fn max_level_hint(&self) -> Option<LevelFilter> {
        Some(LevelFilter::DEBUG)
    }

    fn event(&self, event: &Event<'_>) {
        let mut message = EventMessage(String::new());
        event.record(&mut message);
        let metadata = event.metadata();
        take((metadata.target(), *metadata.level()), &message.0);
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
struct EventMessage(String);

impl Visit for EventMessage {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        if field.name() == "message" {
            self.0 = format!("{value:?}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_message_has_its_cause() {
        let messages = [
            (
                "invalid peer certificate: certificate expired: verification time. Hint: increase",
                FailureCause::Expired,
            ),
            ("received fatal alert: CertificateExpired", FailureCause::Expired),
            ("invalid peer certificate: UnknownIssuer", FailureCause::OtherAuthority),
            ("received fatal alert: UnknownCA", FailureCause::OtherAuthority),
            ("received fatal alert: CertificateRequired", FailureCause::NoCertificate),
            ("UsrPwd extension - Accept. Invalid password.", FailureCause::User),
            (
                "Received a close message (reason INVALID) in response to an OpenSyn",
                FailureCause::User,
            ),
            (
                "abc did not match any configured ACL subject. Default",
                FailureCause::Unnamed,
            ),
            (
                "Unable to connect to tcp/h:1! Connection refused (os error 111)",
                FailureCause::NobodyListens,
            ),
            ("peer sent HTTP/1.1", FailureCause::NoHandshake),
        ];
        for (message, cause) in messages {
            assert_eq!(FailureCause::of(message), cause, "{message}");
        }
    }

    #[test]
    fn notes_of_causes_fit_a_health_message() {
        let note = |cause: &FailureCause| format!("turned away 123456: {}", cause.of_other());
        let causes = [
            FailureCause::OtherAuthority,
            FailureCause::Unnamed,
            FailureCause::OtherName,
        ];
        assert!(causes.iter().all(|cause| note(cause).len() <= 56));
    }
}

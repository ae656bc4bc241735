//! `koseki feed`: lines of JSON to the external sources of a running deployment.
//!
//! Each line is an object with named fields, in degrees or metres. A line becomes a detection or a report of a track by
//! the kind of its source, and passes the checks of every external publisher ([`messages::admission`]) before
//! publishing. The publisher comes from the client library, so that only a single program feeds a source at a time.

mod connections;
mod doors;
mod fields;
mod inlet;
mod samples;
mod tapped;
#[cfg(test)]
mod unknown_tests;

use std::fmt::Write as _;
use std::net::SocketAddr;
use std::sync::{Arc, mpsc};
use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, SharedMemory};
use koseki_client::ErrorKind;
use net::{AllowedSenders, DoorCounters, DoorRefusal, Reach};
use offline::Usage;
use runtime::Now;
use runtime::signals::Stop;
use serde_json::json;
use telemetry::table::count;

use crate::args::Feed;
use crate::config::Config;
use crate::instances;
use connections::Doorkeeper;
use doors::{Shared, lock};
use inlet::Inlets;

/// Time between two checks for the deployment's end.
const LOOK: Duration = Duration::from_millis(100);

/// Feeds until the end of standard input, of the deployment, or a stop request.
///
/// # Errors
/// If the instance does not run, a source cannot be fed, an address cannot be used, or no line of standard input was
/// accepted.
pub(crate) fn run(feed: &Feed) -> anyhow::Result<()> {
    let senders = AllowedSenders::parse(feed.senders.iter().map(String::as_str));
    let senders = senders.map_err(|error| Usage(format!("--senders: {error}")))?;
    for (option, address) in [("--tcp", feed.tcp), ("--udp", feed.udp)] {
        let reach = Reach::permitted(feed.remote, "--remote, with --senders to restrict it");
        let refused = address.map_or(Ok(()), |address| reach.check(address));
        refused.map_err(|reason| Usage(format!("{option}: {reason}")))?;
    }
    let root = instances::running_or_only(feed.instance.as_deref())?;
    let stop = Stop::on_signals()?;
    let bus = Bus::<SharedMemory>::open(&root, "feed")?;
    let mut inlets = Inlets::of(&root, &Config::of_running(root.path())?, feed.clock_limit);
    inlets.choose(feed.source.as_deref())?;
    let shared = Arc::new(Shared::new(inlets));
    let (ended, at_end) = mpsc::channel();
    open(feed, &shared, senders, ended)?;
    let mut doorkeeper = Doorkeeper::default();
    loop {
        let finished = at_end.recv_timeout(LOOK);
        doorkeeper.look(&shared, Now::read().mono_ns);
        if let Some(error) = shared.failure() {
            match error.kind() {
                ErrorKind::Ended => break,
                _ => return Err(error.into()),
            }
        }
        match finished {
            Ok(read) => {
                read.context("standard input")?;
                break;
            }
            Err(mpsc::RecvTimeoutError::Disconnected) => std::thread::sleep(LOOK),
            Err(mpsc::RecvTimeoutError::Timeout) => {}
        }
        if stop.requested() || !bus.goes_on()? {
            break;
        }
    }
    if let Some(path) = &feed.unix {
        // If removal fails, the next server at this path replaces the file.
        let _ = std::fs::remove_file(path);
    }
    let summary = FeedSummary::of(&shared);
    crate::show(feed.json.then(|| summary.json()), || summary.text())?;
    if summary.published == 0 && summary.refused() > 0 {
        anyhow::bail!("none of the lines was published");
    }
    Ok(())
}

/// Opens where the lines come from. `ended` gets the result at the end of standard input.
fn open(
    feed: &Feed,
    shared: &Arc<Shared>,
    senders: AllowedSenders,
    ended: mpsc::Sender<std::io::Result<()>>,
) -> anyhow::Result<()> {
    let at = |address: SocketAddr| runtime::notice(format_args!("koseki feed: listening at {address}"));
    if let Some(address) = feed.tcp {
        let opened = connections::open_tcp(shared, address, senders);
        at(opened.map_err(|error| Usage(format!("--tcp {address}: {error}; choose another")))?);
    } else if let Some(address) = feed.udp {
        let opened = doors::open_udp(shared, address, senders);
        at(opened.map_err(|error| Usage(format!("--udp {address}: {error}")))?);
    } else if let Some(path) = &feed.unix {
        let opened = connections::open_unix(shared, path, feed.mode, feed.group);
        opened.map_err(|error| Usage(format!("--unix {}: {error}; choose another", path.display())))?;
    } else {
        let shared = Arc::clone(shared);
        std::thread::Builder::new().name("input".to_owned()).spawn(move || {
            let read = shared.feed(std::io::stdin().lock(), &mut std::io::stdout().lock(), || true);
            // The command may have ended before.
            let _ = ended.send(read);
        })?;
    }
    Ok(())
}

/// Counts of a feed.
struct FeedSummary {
    published: u64,
    refused: Vec<(String, u64)>,
    connections: DoorCounters,
    refused_senders: u64,
    lost_datagrams: u64,
}

impl FeedSummary {
    fn of(shared: &Shared) -> Self {
        let inlets = shared.inlets();
        let datagrams = *lock(&shared.datagrams);
        let connections = shared.door().counters();
        Self {
            published: inlets.published,
            refused: inlets
                .refused_lines()
                .into_iter()
                .map(|(field, lines)| (field.to_owned(), lines))
                .collect(),
            connections,
            refused_senders: connections.refused(DoorRefusal::Sender) + datagrams.refused_senders,
            lost_datagrams: datagrams.kernel_drops,
        }
    }

    fn refused(&self) -> u64 {
        self.refused.iter().map(|(_, lines)| lines).sum()
    }

    fn json(&self) -> serde_json::Value {
        let reasons: serde_json::Map<_, _> = self
            .refused
            .iter()
            .map(|(field, lines)| (field.clone(), json!(lines)))
            .collect();
        let connections = self
            .connections
            .reasons()
            .map(|(reason, count)| (reason.word().to_owned(), json!(count)));
        let connections: serde_json::Map<_, _> = connections.collect();
        let last = self.connections.last;
        let last = last.map(|(peer, reason)| json!({"peer": peer.to_string(), "reason": reason.word()}));
        json!({
            "published": self.published,
            "refused": self.refused(),
            "refused_by_field": reasons,
            "connections": self.connections.admitted,
            "refused_connections": connections,
            "last_refused_connection": last,
            "refused_senders": self.refused_senders,
            "lost_datagrams": self.lost_datagrams,
        })
    }

    fn text(&self) -> String {
        let mut text = format!("published {} samples", count(self.published));
        // Writing to a string cannot fail.
        if self.refused() > 0 {
            let by_field: Vec<String> = self
                .refused
                .iter()
                .map(|(field, lines)| format!("{field} {}", count(*lines)))
                .collect();
            let _ = write!(
                text,
                "; refused {} lines, by field: {}",
                count(self.refused()),
                by_field.join(", ")
            );
        }
        if self.refused_senders > 0 {
            let _ = write!(text, "; {} of senders that are not listed", count(self.refused_senders));
        }
        if self.connections.all_refused() > 0 {
            let _ = write!(text, "; connections refused or ended: {}", self.connections);
        }
        if self.lost_datagrams > 0 {
            let _ = write!(
                text,
                "; {} datagrams lost in the socket's buffer",
                count(self.lost_datagrams)
            );
        }
        text + "\n"
    }
}

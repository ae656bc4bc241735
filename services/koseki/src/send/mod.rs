//! `koseki send`: sends recordings to the network with their original timing.
//!
//! Data blocks of ASTERIX are sent in their original datagrams, array snapshots in datagrams for a live direction
//! finder, lines of a transponder receiver (SBS) to all connected clients. The times of the recording, relative to the
//! first, set the times of sending; without such times, the times of day in the records. Several recordings keep their
//! relative times. A deployment of live sensors can thus be tested on any machine.

mod pieces;
mod snapshots;
mod way_out;

use std::fmt::Write as _;
use std::io::{IsTerminal as _, Write as _};
use std::iter::Peekable;
use std::path::Path;
use std::time::Duration;

use anyhow::Context as _;
use asterix::Edition;
use formats::recording::RecordingBytes;
use net::Reach;
use offline::{InputError, Usage};
use runtime::clock::mono_ns;
use runtime::signals::Stop;
use runtime::{Now, Speed};
use serde_json::json;
use telemetry::table::count;

use crate::args::{Retime, Send};
use crate::editions;
use pieces::{Mover, Pieces, Timed, begins_ns, offsets_ns};
use way_out::WayOut;

/// Longest sleep, short enough for a prompt end by a signal.
const SLEEP_MAX_NS: i64 = 100_000_000;
/// Time between two lines of progress.
const PROGRESS_NS: i64 = 1_000_000_000;
/// Nanoseconds in a second.
const S: f64 = 1e9;
/// Why a file is not sent.
const NOTHING_TO_SEND: &str = "holds neither data blocks of ASTERIX, lines of SBS-1 nor snapshots of an antenna array";

/// Sends.
///
/// # Errors
/// If the arguments are invalid, a recording cannot be read or is empty, or the network refuses.
pub(crate) fn run(send: &Send) -> anyhow::Result<()> {
    let moves_times = send.retime == Some(Retime::Now);
    if moves_times && send.speed != Speed::Factor(1.0) {
        let what = "--retime now needs --speed 1: at another speed the times would run away from the clock";
        return Err(Usage(what.to_owned()).into());
    }
    let contents = send
        .files
        .iter()
        .map(|sent| Ok(offline::read(&sent.file)?))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let mut recordings = Vec::new();
    for (sent, octets) in send.files.iter().zip(&contents) {
        let pieces = Pieces::of(octets, &send.editions).map_err(|error| InputError::new(&sent.file, error))?;
        examine(&sent.file, octets, &pieces, send)?;
        recordings.push(pieces);
    }
    let begins: Vec<Option<i64>> = recordings.iter().map(begins_ns).collect();
    let offsets = offsets_ns(&begins);
    let mut feeds = Vec::new();
    for ((sent, pieces), offset_ns) in send.files.iter().zip(&recordings).zip(&offsets) {
        let mut timed = Timed::new(pieces).peekable();
        if timed.peek().is_none() {
            return Err(InputError::new(&sent.file, NOTHING_TO_SEND).into());
        }
        let to = sent.to.or(send.to).ok_or_else(|| {
            let file = sent.file.display();
            Usage(format!(
                "{file} has no address: give it one, {file}=ADDRESS:PORT, or all of them one with --to"
            ))
        })?;
        let way_out = WayOut::open(
            to,
            send.interface.as_ref(),
            pieces.kind(),
            Reach::permitted(send.remote, "--remote"),
        );
        feeds.push(RecordingFeed {
            pieces,
            timed,
            offset_ns: *offset_ns,
            way_out: way_out.map_err(|error| Usage(error.to_string()))?,
        });
    }
    let stop = Stop::on_signals().context("catching signals")?;
    for feed in &mut feeds {
        feed.way_out.await_reader(&stop)?;
    }
    let sent = send_all(send, &mut feeds, moves_times, &begins, &stop)?;
    let failed = feeds.iter().map(|feed| feed.way_out.failed()).sum();
    for (sent, pieces) in send.files.iter().zip(&recordings) {
        let left_out = pieces.octets_left_out();
        if left_out > 0 {
            runtime::notice(format_args!(
                "koseki: {}: byte {}: no data block begins here; {} octets from here on were not sent",
                sent.file.display(),
                pieces.octets - left_out,
                count(left_out as u64)
            ));
        }
    }
    crate::show(send.json.then(|| sent.json(failed)), || sent.text(failed))
}

/// Refuses a file that is no recording: any octets are data blocks by accident for a while, and must not reach a
/// group of operational receivers. Names categories of another edition.
fn examine(file: &Path, octets: &[u8], pieces: &Pieces<'_>, send: &Send) -> anyhow::Result<()> {
    if !pieces.are_blocks() {
        return Ok(());
    }
    let survey = RecordingBytes::new(octets).with_editions(&send.editions).survey();
    if let Some(kind) = survey.foreign(octets) {
        return Err(InputError::new(file, format!("{NOTHING_TO_SEND}: {kind}")).into());
    }
    // Blocks of an unknown category or edition follow each other to the end.
    let is_known = survey.records() > 0 || survey.categories.values().any(|category| category.better().is_some());
    if !is_known && pieces.octets_left_out() > 0 {
        return Err(InputError::new(file, NOTHING_TO_SEND).into());
    }
    for (number, category) in &survey.categories {
        let choose = |edition: Edition| format!("add --edition {number}={edition}");
        let verdict = editions::verdict(*number, category, false, choose);
        match verdict.filter(|_| category.better().is_some()) {
            // The wrong octets would be changed.
            Some(verdict) if category.is_withheld() && send.retime.is_some() => {
                let what = format!("its times cannot be moved: {verdict}");
                return Err(InputError::new(file, what).into());
            }
            Some(verdict) => runtime::notice(format_args!("koseki: {}: {verdict}", file.display())),
            None => {}
        }
    }
    Ok(())
}

/// A recording being sent.
struct RecordingFeed<'p> {
    pieces: &'p Pieces<'p>,
    timed: Peekable<Timed<'p, 'p>>,
    /// Time from the begin of the earliest recording to the begin of this recording.
    offset_ns: i64,
    way_out: WayOut,
}

impl RecordingFeed<'_> {
    /// Returns the time of the next piece since the start of the earliest recording; `None` at the end.
    fn due_ns(&mut self) -> Option<i64> {
        let (since_ns, _) = self.timed.peek()?;
        Some(self.offset_ns + since_ns)
    }
}

/// Sends the pieces of all recordings when due, until the end or a stop request.
fn send_all(
    send: &Send,
    feeds: &mut [RecordingFeed<'_>],
    moves_times: bool,
    begins: &[Option<i64>],
    stop: &Stop,
) -> anyhow::Result<SendCounts> {
    let begun = Now::read();
    let earliest = feeds.iter().position(|feed| feed.offset_ns == 0);
    let earliest_ns = earliest.and_then(|index| begins[index]).filter(|_| moves_times);
    let mut mover = earliest_ns.map(|begins_ns| Mover::new(begins_ns, begun.utc_ns));
    let all: usize = feeds.iter().map(|feed| feed.pieces.octets).sum();
    let mut sent = SendCounts::default();
    loop {
        let due = |(index, feed): (usize, &mut RecordingFeed<'_>)| Some((feed.due_ns()?, index));
        let next = feeds.iter_mut().enumerate().filter_map(due).min();
        let Some((due_ns, index)) = next else { break };
        if let Speed::Factor(factor) = send.speed
            && !sleep_until(begun.mono_ns + (due_ns as f64 / factor) as i64, stop)
        {
            break;
        }
        let feed = &mut feeds[index];
        let Some((_, piece)) = feed.timed.next() else { break };
        let octets = match &mut mover {
            Some(mover) => mover.moved(&piece, feed.pieces),
            None => &piece.octets,
        };
        feed.way_out.send(octets)?;
        sent.pieces += 1;
        sent.octets += octets.len() as u64;
        sent.recorded_ns = due_ns;
        if !send.json {
            sent.progress(all);
        }
    }
    sent.times_moved = mover.map_or(0, |mover| mover.count);
    sent.took_ns = mono_ns() - begun.mono_ns;
    Ok(sent)
}

/// Waits until `due_ns` on the monotonic clock; `false` at a stop request.
fn sleep_until(due_ns: i64, stop: &Stop) -> bool {
    loop {
        if stop.requested() {
            return false;
        }
        let left_ns = due_ns - mono_ns();
        if left_ns <= 0 {
            return true;
        }
        std::thread::sleep(Duration::from_nanos(left_ns.min(SLEEP_MAX_NS) as u64));
    }
}

/// Counts of sent pieces.
#[derive(Debug, Default)]
struct SendCounts {
    pieces: u64,
    octets: u64,
    times_moved: u64,
    recorded_ns: i64,
    took_ns: i64,
    told_ns: i64,
}

impl SendCounts {
    /// Prints the progress, relative to `all` bytes, to a terminal.
    fn progress(&mut self, all: usize) {
        let now_ns = mono_ns();
        if now_ns - self.told_ns < PROGRESS_NS || !std::io::stderr().is_terminal() {
            return;
        }
        self.told_ns = now_ns;
        let percent = 100.0 * self.octets as f64 / all.max(1) as f64;
        let _ = write!(
            std::io::stderr(),
            "\r{percent:5.1} %, {:.0} s of the recording, {} sent ",
            self.recorded_ns as f64 / S,
            count(self.pieces)
        );
    }

    fn json(&self, failed: u64) -> serde_json::Value {
        json!({
            "sent": self.pieces,
            "octets": self.octets,
            "failed": failed,
            "recorded_s": self.recorded_ns as f64 / S,
            "took_s": self.took_ns as f64 / S,
            "times_moved": self.times_moved,
        })
    }

    fn text(&self, failed: u64) -> String {
        let mut text = format!(
            "sent {} datagrams or lines, {} octets, in {:.1} s: {:.1} s of the recording",
            count(self.pieces),
            count(self.octets),
            self.took_ns as f64 / S,
            self.recorded_ns as f64 / S
        );
        // Writing to a string cannot fail.
        if self.times_moved > 0 {
            let _ = write!(text, "; {} times moved to now", count(self.times_moved));
        }
        if failed > 0 {
            let _ = write!(
                text,
                "; {} not taken by the operating system or a reader",
                count(failed)
            );
        }
        text + "\n"
    }
}

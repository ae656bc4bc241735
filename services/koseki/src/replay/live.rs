//! Publishing recorded sensor tracks again, into a deployment that runs.
//!
//! Slices go out in the recorded order, paced by the stamps of sending, to the topics of the sources of the same names,
//! which that deployment calls `external`. All times of a slice are moved by the same amount to the present, so that
//! reports have the same age as at the original sending.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, Mark, Publisher, SharedMemory};
use messages::layout::Sample as _;
use messages::{BatchHeader, Outgoing as _, SensorTrack};
use recording::Item;
use runtime::signals::Stop;
use runtime::{Now, Speed};

use crate::args::ReplayArgs;
use crate::config::Config;
use crate::recording_info::note_damage;

/// Longest sleep between checks for the end of the command, nanoseconds.
const LOOK_NS: i64 = 100_000_000;

/// Publishes the recording in `files`, made by the deployment of `recorded`.
///
/// # Errors
/// If the instance does not run or has not the sources, or a file cannot be read.
pub(crate) fn run(replay: &ReplayArgs, recorded: &Config, files: &[PathBuf]) -> anyhow::Result<()> {
    let instance = replay.instance.as_deref().unwrap_or(&recorded.name);
    let root = crate::instances::named(instance)?;
    let bus = Bus::<SharedMemory>::open(&root, "replay")?;
    let now = Now::read();
    let is_wanted = |name: &String| replay.sources.is_empty() || replay.sources.contains(name);
    let names = recorded.sources.iter().map(|source| &source.name);
    let topics = names.filter(|name| is_wanted(name)).map(|name| {
        let topic = messages::sensor_tracks(name);
        let publisher = bus.publisher(&topic, now.mono_ns as u64)?;
        Ok((topic.name.as_str().to_owned(), publisher))
    });
    let mut live = LiveReplay {
        topics: topics.collect::<anyhow::Result<_>>()?,
        factor: match replay.speed {
            Some(Speed::Max) => f64::INFINITY,
            Some(Speed::Factor(factor)) => factor,
            None => 1.0,
        },
        span: (replay.from.unwrap_or(i64::MIN), replay.to.unwrap_or(i64::MAX)),
        stop: Stop::on_signals().context("catching signals")?,
        began: None,
        slice: None,
        reports: Vec::new(),
        sent: 0,
    };
    for path in files {
        let mut file = BufReader::with_capacity(1 << 18, File::open(path)?);
        let read = |item: Item<'_>| {
            note_damage(path, &item);
            live.item(item)
        };
        recording::read::<_, anyhow::Error>(&mut file, read).with_context(|| format!("reading {}", path.display()))?;
    }
    live.send()?;
    crate::print(&format!("published {} reports into instance {instance}\n", live.sent))?;
    anyhow::ensure!(live.sent > 0, "the recording has no report of these sources and times");
    Ok(())
}

struct LiveReplay {
    topics: BTreeMap<String, Publisher<SharedMemory, SensorTrack>>,
    /// Seconds of the recording per second.
    factor: f64,
    /// Times of sending that count, UTC, nanoseconds.
    span: (i64, i64),
    stop: Stop,
    /// Time of the first slice's sending, monotonic and UTC, then and now.
    began: Option<(Now, Now)>,
    /// The present slice, its topic, and the time of sending, UTC, nanoseconds.
    slice: Option<(String, BatchHeader, i64)>,
    reports: Vec<SensorTrack>,
    sent: u64,
}

impl LiveReplay {
    fn item(&mut self, item: Item<'_>) -> anyhow::Result<()> {
        match item {
            Item::Slice {
                topic, header, sent_ns, ..
            } => {
                self.send()?;
                let is_wanted = self.topics.contains_key(topic);
                self.slice = is_wanted.then(|| (topic.to_owned(), header, sent_ns as i64));
            }
            Item::Sample { octets, .. } if self.slice.is_some() => self.reports.extend(SensorTrack::of_octets(octets)),
            Item::Sample { .. } | Item::Facts(_) | Item::Topic { .. } | Item::Damaged { .. } => {}
        }
        Ok(())
    }

    /// Sends the present slice when due.
    fn send(&mut self) -> anyhow::Result<()> {
        let Some((topic, header, sent_ns)) = self.slice.take() else {
            return Ok(());
        };
        let reports = std::mem::take(&mut self.reports);
        let (from_ns, to_ns) = self.span;
        let Some(publisher) = self.topics.get_mut(&topic) else {
            return Ok(());
        };
        if !(from_ns..=to_ns).contains(&sent_ns) || self.stop.requested() {
            return Ok(());
        }
        let first = Now {
            mono_ns: header.sent_ns,
            utc_ns: sent_ns,
        };
        let (then, began) = *self.began.get_or_insert_with(|| (first, Now::read()));
        let recorded_ns = header.sent_ns.saturating_sub(then.mono_ns);
        // `as` saturates; without pacing the result is 0.
        let passed_ns = (recorded_ns as f64 / self.factor) as i64;
        loop {
            let wait_ns = began.mono_ns.saturating_add(passed_ns) - Now::read().mono_ns;
            if wait_ns <= 0 || self.stop.requested() {
                break;
            }
            thread::sleep(Duration::from_nanos(wait_ns.min(LOOK_NS) as u64));
        }
        let now = Now::read();
        let utc_ns = match self.factor.is_finite() {
            true => began.utc_ns.saturating_add(passed_ns),
            false => now.utc_ns,
        };
        let moved_ns = utc_ns.saturating_sub(then.utc_ns.saturating_add(recorded_ns));
        let mark = Mark {
            progress_ns: match header.progress_ns {
                i64::MIN => i64::MIN,
                progress_ns => progress_ns.saturating_add(moved_ns),
            },
            sent_ns: now.mono_ns,
            end: false,
        };
        publisher.send(mark, reports.len(), |index, sequence| {
            let mut report = reports[index];
            report.time_of_measurement_ns = report.time_of_measurement_ns.saturating_add(moved_ns);
            let age_ns = header.sent_ns.saturating_sub(report.stages.ingested_ns);
            report.stages.ingested_ns = now.mono_ns.saturating_sub(age_ns);
            report.leave(sequence, mark.sent_ns);
            report
        })?;
        self.sent += reports.len() as u64;
        // Kept for the next slice.
        self.reports = reports;
        self.reports.clear();
        Ok(())
    }
}

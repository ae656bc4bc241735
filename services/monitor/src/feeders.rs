//! Feeders of the sources: second publishers, refused or not, and refused lines.
//!
//! The client library refuses a second publisher of a source ([`koseki_client::refusals`]). A link or an adapter makes
//! no such check: when started after a publisher from outside, both publish. The lines of a topic's publishers show
//! this ([`bus::PublisherLine`]): two live publishers both keep sending. A killed publisher is live by its line for
//! some seconds, but sends nothing.

use std::collections::{BTreeMap, BTreeSet};

use bus::{Bus, BusError, LineReader, Payload, PublisherState, Transport};
use deployment::Deployment;
use koseki_client::refusals::{Refusal, RefusalReader, Refused};
use messages::{Outgoing, PlatformState, SensorDetection, SensorTrack, WideArea};
use runtime::Now;
use telemetry::table::count;

/// Maximum age of a refusal that a starting monitor takes for a present refusal, nanoseconds.
const RECENT_NS: i64 = 5_000_000_000;
/// Looks in a row in which two publishers have both sent: at the first look, the earlier publisher may just have ended.
const LOOKS_MIN: u32 = 2;

/// Findings about the feeding of sources, since the last round.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct FeedFindings {
    /// Sources with a second publisher, and a description of this publisher.
    pub(crate) second: BTreeMap<String, String>,
    /// Sources of refused lines (empty: of several), with all refused so far, by reason, and the latest in words.
    pub(crate) refused: BTreeMap<String, String>,
}

/// Watch over the publishers of all sources, tracker sensors, wide-area sensors and platforms.
#[derive(Debug)]
pub(crate) struct FeederWatch {
    refusals: RefusalReader,
    topics: Vec<WatchedTopic>,
    /// Lines refused so far, by source and reason.
    refused: BTreeMap<String, BTreeMap<String, u64>>,
}

impl FeederWatch {
    /// Watches the topics of `config` on `bus`.
    ///
    /// # Errors
    /// If a topic cannot be opened.
    pub(crate) fn new<S: Transport>(config: &Deployment, bus: &Bus<S>) -> Result<Self, BusError> {
        let mut topics = Vec::new();
        for source in &config.sources {
            topics.push(WatchedTopic::open::<SensorTrack, S>(bus, &source.name)?);
        }
        for sensor in &config.tracker_sensors {
            topics.push(WatchedTopic::open::<SensorDetection, S>(bus, &sensor.name)?);
        }
        for sensor in &config.wide_area_sensors {
            topics.push(WatchedTopic::open::<WideArea, S>(bus, &sensor.name)?);
        }
        for platform in &config.platforms {
            topics.push(WatchedTopic::open::<PlatformState, S>(bus, &platform.name)?);
        }
        Ok(Self {
            refusals: RefusalReader::new(bus.root()),
            topics,
            refused: BTreeMap::new(),
        })
    }

    /// Returns the findings since the last call.
    pub(crate) fn look(&mut self, now: Now) -> FeedFindings {
        let mut findings = FeedFindings::default();
        for refusal in self.refusals.take(now.mono_ns - RECENT_NS) {
            self.take(&refusal, &mut findings);
        }
        for topic in &mut self.topics {
            if topic.look() {
                let both = "two processes publish, and each report counts twice or contradicts itself".to_owned();
                findings.second.insert(topic.name.clone(), both);
            }
        }
        findings
    }

    fn take(&mut self, refusal: &Refusal, findings: &mut FeedFindings) {
        match &refusal.refused {
            Refused::Publisher { process, holder } => {
                let named = |topic: &&WatchedTopic| topic.topic == refusal.name;
                let name = self
                    .topics
                    .iter()
                    .find(named)
                    .map_or(&refusal.name, |topic| &topic.name);
                let which = format!("process {process} was refused, because {holder} publishes");
                findings.second.insert(name.clone(), which);
            }
            Refused::Lines {
                count: more,
                reason,
                latest,
            } => {
                let reasons = self.refused.entry(refusal.name.clone()).or_default();
                *reasons.entry(reason.clone()).or_default() += more;
                let all = reasons
                    .iter()
                    .map(|(reason, lines)| format!("{reason} {}", count(*lines)));
                let mut all = all.collect::<Vec<_>>().join(", ");
                if !latest.is_empty() {
                    all.push_str("; ");
                    all.push_str(latest);
                }
                findings.refused.insert(refusal.name.clone(), all);
            }
        }
    }
}

/// Topic of a source, with the publishers that sent of late.
#[derive(Debug)]
struct WatchedTopic {
    /// Name of the source, sensor or platform.
    name: String,
    topic: String,
    lines: LineReader,
    /// Incarnations and latest sends of the publishers that live.
    sent: BTreeSet<(u64, i64)>,
    /// Looks in a row in which two publishers had sent.
    looks: u32,
}

impl WatchedTopic {
    fn open<T: Outgoing + Payload, S: Transport>(bus: &Bus<S>, name: &str) -> Result<Self, BusError> {
        let topic = T::topic(name);
        Ok(Self {
            // The sensor of a source in the short form is known by the source's name.
            name: name.strip_suffix(".input").unwrap_or(name).to_owned(),
            topic: topic.name.as_str().to_owned(),
            lines: bus.line_reader(&topic)?,
            sent: BTreeSet::new(),
            looks: 0,
        })
    }

    /// Whether two publishers go on sending.
    fn look(&mut self) -> bool {
        let living = self
            .lines
            .read()
            .into_iter()
            .filter(|line| line.life == PublisherState::Lives);
        let sent: BTreeSet<_> = living.map(|line| (line.incarnation, line.heartbeat_ns)).collect();
        let is_second = two_go_on(&self.sent, &sent);
        self.sent = sent;
        self.looks = if is_second { self.looks + 1 } else { 0 };
        self.looks >= LOOKS_MIN
    }
}

/// Whether two publishers have sent between two looks.
fn two_go_on(before: &BTreeSet<(u64, i64)>, now: &BTreeSet<(u64, i64)>) -> bool {
    let was_there = |(incarnation, _): &&(u64, i64)| before.iter().any(|(earlier, _)| earlier == incarnation);
    now.difference(before).filter(was_there).count() > 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_publishers_are_found_while_both_send() {
        let goes_on = |before: &[(u64, i64)], now: &[(u64, i64)]| {
            two_go_on(&before.iter().copied().collect(), &now.iter().copied().collect())
        };
        assert!(goes_on(&[(1, 10), (2, 11)], &[(1, 20), (2, 21)]));
        assert!(
            !goes_on(&[(1, 10), (2, 11)], &[(1, 10), (2, 21)]),
            "one is dead, or silent"
        );
        assert!(!goes_on(&[(1, 10)], &[(1, 20), (2, 21)]), "a successor has just begun");
        assert!(!goes_on(&[], &[(1, 20), (2, 21)]));
    }
}

//! Mirror: a deployment of another host as a local instance, for local readers: displays, gateways, recorders,
//! programs.
//!
//! The mirror claims an instance, holds its topics, and publishes the slices sent by the deployment's link unchanged.
//! A late reader, local or another mirror, requests the present snapshot; so does a mirror after a loss. States older
//! than the known state of a track are ignored; tracks missing in the snapshot are reported as terminated.

use std::any::Any;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context as _, bail};
use bus::{Bus, Payload, SharedMemory};
use configuration::Config;
use deployment::{Deployment, Link};
use messages::{BatchHeader, Counter, ProcessKind, SystemTrack, Topic, TrackState, Visitor};
use runtime::Process;
use runtime::instance::{Instance, hold_topics};
use runtime::signals::Stop;
use runtime::{Agent, HealthEntry, Now, Options, Speed, Turn};
use zenoh::Session;

use crate::Mirror;
use crate::clocks::PeerClocks;
use crate::expiry::ExpiryWatch;
use crate::in_order::{InOrder, SlicePublisher};
use crate::inbound::{Arrival, Inbound, InboundCounts, Inlet, Question, Wanted};
use crate::picture::NewestStates;
use crate::stand_in::{PublisherNumbers, StandIn, UNNUMBERED};
use crate::wire::{Head, MessagePart, SliceCopy};
use crate::{agent, keys, session};

/// Processes for which there is room.
const PROCESSES: usize = 16;
/// Longest sleep.
const SLEEP: Duration = Duration::from_millis(100);
/// Time between two comparisons of clocks, nanoseconds.
const COMPARE_NS: i64 = 1_000_000_000;

/// Wrong use of the command line.
#[derive(Debug)]
pub(crate) struct UsageError(pub(crate) String);

impl std::fmt::Display for UsageError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for UsageError {}

/// Runs a mirror until a stop request.
///
/// # Errors
/// If the instance runs already, or an endpoint cannot be had.
pub(crate) fn run(mirror: Mirror) -> anyhow::Result<()> {
    let config = Config::read(&mirror.config, &[])?.deployment;
    let instance = mirror.instance.unwrap_or_else(|| config.name.clone());
    let is_insecure = mirror.insecure || config.links.first().is_some_and(|link| link.insecure);
    for endpoint in mirror.listen.iter().chain(&mirror.connect) {
        deployment::check_endpoint(endpoint, mirror.certificates, is_insecure).map_err(|what| {
            let what = what.replace("authority, certificate and private_key", "--certificates");
            UsageError(what.replace("set insecure = true", "give --insecure"))
        })?;
    }
    let stop = Stop::on_signals().context("catching signals")?;
    let claimed = Instance::claim(&config, &instance, PROCESSES, &stop, |text| {
        runtime::notice(format_args!("koseki-link: {text}"))
    })?;
    let link = Link {
        name: "mirror".to_owned(),
        listen: mirror.listen,
        connect: mirror.connect,
        ..Link::default()
    };
    let link = match config.links.first() {
        // With the certificate and the trust of this host.
        Some(own) if mirror.certificates => Link {
            authority: own.authority.clone(),
            certificate: own.certificate.clone(),
            private_key: own.private_key.clone(),
            user: own.user.clone(),
            password_file: own.password_file.clone(),
            ..link
        },
        _ => link,
    };
    let options = Options {
        overrides: Vec::new(),
        instance,
        data: PathBuf::new(),
        out: PathBuf::new(),
        speed: Speed::Factor(1.0),
        seed: 1,
        scenario_start_ns: Now::read().utc_ns,
        launcher: mirror.launcher,
    };
    let done = reflect(config, options, &link, &mirror.topics);
    done.and(claimed.clear())
}

fn reflect(config: Deployment, options: Options, link: &Link, topics: &[String]) -> anyhow::Result<()> {
    let process = Process::connect(config, options, ProcessKind::Link, &link.name)?;
    let _held = hold_topics(&process.config, &process.bus)?;
    let (session, _gates) = session::open(&process.config.name, link)?;
    let deployment = Arc::new(process.config.name.clone());
    let wanted = topics.iter().map(|topic| {
        let wanted = messages::visit(topic, Reflect(&deployment));
        wanted.with_context(|| format!("{topic} is no topic"))
    });
    let wanted = wanted.collect::<anyhow::Result<Vec<_>>>()?;
    if wanted.is_empty() {
        bail!("no topic is to be mirrored");
    }
    let clocks = PeerClocks::default();
    let inbound = Inbound::open(&session, process.bus.root(), wanted, &clocks)?;
    let mut agent = MirrorAgent {
        inbound,
        clocks,
        compare_ns: i64::MIN,
        deployment,
        expiry: ExpiryWatch::of(link),
        session,
    };
    println!(
        "koseki-link: instance {} mirrors {}",
        process.options.instance, agent.deployment
    );
    runtime::service::run(&process, &mut agent)
}

/// Wants a topic.
struct Reflect<'a>(&'a Arc<String>);

impl Visitor for Reflect<'_> {
    type Output = Wanted;

    fn visit<T: Payload>(self, topic: Topic<T>) -> Wanted {
        let deployment = Arc::clone(self.0);
        let name = topic.name.as_str().to_owned();
        let open = move || -> Box<dyn Inlet> {
            let any: &dyn Any = &topic;
            match any.downcast_ref::<Topic<SystemTrack>>() {
                Some(topic) => Box::new(MirroredTracks {
                    stand_in: StandIn::new(topic.clone()),
                    key: keys::picture::<SystemTrack>(&deployment),
                    picture: NewestStates::default(),
                    lacks: true,
                    reaches: 0,
                    parts: Parts::default(),
                }),
                None => {
                    let key = keys::topic_of_any_layout(&deployment, topic.name.as_str());
                    Box::new(InOrder::new(TopicCopy(StandIn::new(topic)), Some(keys::again(&key))))
                }
            }
        };
        Wanted {
            deployment: self.0.to_string(),
            topic: name,
            inlet: Box::new(open),
        }
    }
}

/// A topic that is published as it comes.
struct TopicCopy<T: Payload>(StandIn<T>);

impl<T: Payload> SlicePublisher for TopicCopy<T> {
    type Came = T;

    fn read(&mut self, arrival: &Arrival<'_>, counts: &mut InboundCounts) -> Option<(Head, Vec<SliceCopy<T>>)> {
        self.0.read(arrival, counts)
    }

    fn numbers(&self) -> &PublisherNumbers {
        &self.0.numbers
    }

    fn slice_len(&self) -> usize {
        self.0.topic.capacity.slice_len
    }

    fn publish(
        &mut self,
        bus: &Bus<SharedMemory>,
        now: Now,
        (head, (header, samples)): (&Head, &SliceCopy<T>),
        counts: &mut InboundCounts,
    ) -> anyhow::Result<()> {
        counts.published += samples.len() as u64;
        self.0.publish(bus, (header, head.origin), samples, now, |_, _| {})?;
        self.0.pass(header, samples.len());
        Ok(())
    }
}

/// The system tracks, with the picture where something was missed.
struct MirroredTracks {
    stand_in: StandIn<SystemTrack>,
    key: String,
    picture: NewestStates,
    lacks: bool,
    /// Number of the state that would come next after the last whole picture.
    reaches: u64,
    parts: Parts,
}

/// Parts of an answer that have come, in their order.
#[derive(Debug, Default)]
struct Parts {
    sent_mono_ns: i64,
    next: u32,
    slices: Vec<SliceCopy<SystemTrack>>,
}

impl Parts {
    /// Adds a part of the answer sent at that time; returns all parts with the last. The first part of an answer
    /// starts again; any other unexpected part belongs to an incomplete answer.
    fn add(
        &mut self,
        sent_mono_ns: i64,
        part: MessagePart,
        slices: Vec<SliceCopy<SystemTrack>>,
    ) -> Option<Vec<SliceCopy<SystemTrack>>> {
        if part.index == 0 {
            *self = Self {
                sent_mono_ns,
                ..Self::default()
            };
        }
        if (sent_mono_ns, part.index) != (self.sent_mono_ns, self.next) {
            return None;
        }
        self.next += 1;
        self.slices.extend(slices);
        (self.next == part.of).then(|| std::mem::take(self).slices)
    }
}

impl Inlet for MirroredTracks {
    fn take(&mut self, arrival: Arrival<'_>, counts: &mut InboundCounts) -> anyhow::Result<()> {
        let Some((head, slices)) = self.stand_in.read::<SystemTrack>(&arrival, counts) else {
            return Ok(());
        };
        if let Some(part) = head.part {
            let Some(slices) = self.parts.add(head.sent_mono_ns, part, slices) else {
                return Ok(());
            };
            return self.complete(&arrival, head.origin, &slices, counts);
        }
        for (header, states) in slices {
            counts.came += states.len() as u64;
            // The snapshot may have arrived first; then the slice has no news, and its samples are not missing.
            let missing = self.stand_in.missing(&header).unwrap_or(0);
            counts.missing += missing;
            self.lacks |= missing > 0 && header.first_sequence > self.reaches;
            let news: Vec<SystemTrack> = states
                .iter()
                .copied()
                .filter(|state| self.picture.is_news(&header, state))
                .collect();
            self.tell(&arrival, (&header, head.origin), &news, counts)?;
            self.stand_in.pass(&header, states.len());
        }
        Ok(())
    }

    fn lacks(&self) -> Option<Question> {
        self.lacks.then(|| Question {
            key: self.key.clone(),
            payload: Vec::new(),
        })
    }
}

impl MirroredTracks {
    fn tell(
        &mut self,
        arrival: &Arrival<'_>,
        (header, origin): (&BatchHeader, u32),
        states: &[SystemTrack],
        counts: &mut InboundCounts,
    ) -> anyhow::Result<()> {
        self.picture.hear(header, states);
        counts.published += states.len() as u64;
        self.stand_in
            .publish(arrival.bus, (header, origin), states, arrival.now, |_, _| {})
    }

    /// Publishes states of the complete snapshot that are not known yet, and the ends of tracks missing in the
    /// snapshot.
    fn complete(
        &mut self,
        arrival: &Arrival<'_>,
        origin: u32,
        slices: &[(BatchHeader, Vec<SystemTrack>)],
        counts: &mut InboundCounts,
    ) -> anyhow::Result<()> {
        self.lacks = false;
        // The last slice states the position of the snapshot.
        let Some((header, _)) = slices.last() else {
            return Ok(());
        };
        let states = || slices.iter().flat_map(|(_, states)| states);
        let news = states().copied().filter(|state| self.picture.is_news(header, state));
        // States sent after the snapshot was taken follow in order.
        let gone = self.picture.states().filter(|known| {
            known.sequence < header.first_sequence && !states().any(|state| state.track_number == known.track_number)
        });
        let ended = gone.map(|known| SystemTrack {
            state: TrackState::Terminated as u8,
            ..*known
        });
        let news: Vec<SystemTrack> = news.chain(ended).collect();
        let unnumbered = BatchHeader {
            first_sequence: UNNUMBERED,
            ..*header
        };
        for news in news.chunks(self.stand_in.topic.capacity.slice_len) {
            self.tell(arrival, (&unnumbered, origin), news, counts)?;
        }
        self.stand_in.begin(header);
        self.reaches = header.first_sequence;
        Ok(())
    }
}

struct MirrorAgent {
    inbound: Inbound,
    clocks: PeerClocks,
    compare_ns: i64,
    deployment: Arc<String>,
    expiry: ExpiryWatch,
    session: Session,
}

impl Agent for MirrorAgent {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        self.inbound.check()?;
        self.expiry.look(now);
        if now.mono_ns >= self.compare_ns {
            self.compare_ns = now.mono_ns + COMPARE_NS;
            self.clocks.ask(&self.session, "");
        }
        Ok(Turn::Idle(SLEEP))
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let came = self.inbound.counts();
        let mut entry = HealthEntry::default();
        entry.set(Counter::Taken, came.came);
        entry.set(Counter::Conflated, came.conflated);
        self.inbound.report(&mut entry);
        let expected = std::slice::from_ref(&*self.deployment);
        agent::peers(
            entries,
            entry,
            &self.clocks.present(Now::read()),
            expected,
            self.expiry.note(),
            &self.session,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_whole_when_all_its_parts_have_come_in_order() {
        let mut parts = Parts::default();
        let slice = || vec![(BatchHeader::default(), Vec::new())];
        let mut add = |sent_ns, index, of| {
            parts
                .add(sent_ns, MessagePart { index, of }, slice())
                .map(|all| all.len())
        };
        assert_eq!([add(5, 0, 3), add(5, 1, 3), add(5, 2, 3)], [None, None, Some(3)]);
        assert_eq!([add(6, 1, 3), add(6, 0, 3), add(6, 2, 3)], [None; 3], "one is missing");
        assert_eq!(
            [add(7, 0, 2), add(8, 0, 2), add(7, 1, 2), add(8, 1, 2)],
            [None, None, None, Some(2)],
            "of two"
        );
        assert_eq!(add(9, 0, 1), Some(1));
    }
}

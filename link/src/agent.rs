//! The duty cycle of a link.

use std::cmp::Reverse;
use std::sync::Arc;
use std::time::Duration;

use anyhow::anyhow;
use bus::{Bus, Payload, SharedMemory, WaitMode, Waiter};
use deployment::Link;
use messages::{Counter, FrameOrigin, SystemTrack, Topic, Visitor};
use runtime::Process;
use runtime::{Agent, HealthEntry, Now, Turn};
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::CongestionControl;
use zenoh::query::{Query, Queryable};
use zenoh::{Session, Wait as _};

use crate::clocks::{self, Comparison, PeerClocks};
use crate::expiry::ExpiryWatch;
use crate::feed;
use crate::gate::Gates;
use crate::history::{self, MessageHistory, ReaderPosition, SharedHistory};
use crate::inbound::Inbound;
use crate::keys;
use crate::outbound::{self, Outbound, OutgoingTracks, Sender, SharedPicture, TopicStream};
use crate::outbox::Outbox;
use crate::refused;
use crate::session;
use crate::wire::{Head, MessagePart};

/// Time between two comparisons of clocks, nanoseconds.
const COMPARE_NS: i64 = 1_000_000_000;
/// Longest sleep.
const SLEEP: Duration = Duration::from_millis(50);

/// A link as an agent.
pub(crate) struct LinkAgent {
    lanes: Vec<Box<dyn Outbound>>,
    outbox: Outbox,
    waiter: Waiter<SharedMemory>,
    inbound: Inbound,
    clocks: PeerClocks,
    own_clock: String,
    compare_ns: i64,
    /// Deployments that something is to come from.
    expected: Vec<String>,
    expiry: ExpiryWatch,
    /// Before the session.
    _answers: Vec<Queryable<()>>,
    _token: LivelinessToken,
    session: Session,
    _gates: Gates,
}

impl LinkAgent {
    /// The link `link` of `process`'s deployment.
    ///
    /// # Errors
    /// If an endpoint cannot be had, or shared memory fails.
    pub(crate) fn new(process: &Process, link: &Link) -> anyhow::Result<Self> {
        let deployment = process.config.name.as_str();
        let place = process.config.frame.to_geodetic([0.0; 3]);
        let sender = Sender {
            frame: FrameOrigin {
                latitude_deg: place.latitude_deg(),
                longitude_deg: place.longitude_deg(),
                height_m: place.height_m(),
            },
            origin: process.config.origin,
        };
        let (session, gates) = session::open(deployment, link)?;
        let refused = |what: &str, error: zenoh::Error| anyhow!("{what}: {error}");
        let mut open = TopicOpener {
            process,
            waiter: process.bus.waiter(WaitMode::Event),
            lanes: Vec::new(),
            keys: Vec::new(),
            picture: None,
            histories: Vec::new(),
            history_room: link.queue_bytes() / link.send.len().max(1),
            sender,
        };
        for topic in &link.send {
            messages::visit(topic, &mut open).ok_or_else(|| anyhow!("{topic} is no topic"))??;
        }
        let publishers = open.keys.iter().map(|key| {
            let publisher = session.declare_publisher(key.clone());
            // A slow reader loses messages, and counts the loss; other readers are not delayed.
            let publisher = publisher.congestion_control(CongestionControl::Drop);
            publisher.wait().map_err(|error| refused(key, error))
        });
        let outbox = Outbox::open(link.queue_bytes(), publishers.collect::<anyhow::Result<_>>()?)?;
        let picture = open
            .picture
            .map(|picture| tell_picture(&session, deployment, sender, picture));
        let picture = picture.transpose().map_err(|error| refused("the picture", error))?;
        let histories = open.histories.into_iter().map(|(lane, history)| {
            let key = &open.keys[lane];
            send_again(&session, key, sender, history).map_err(|error| refused(key, error))
        });
        let histories = histories.collect::<anyhow::Result<Vec<_>>>()?;
        let own_clock = keys::clock(deployment, &link.name);
        let clock = clocks::answer(&session, &own_clock).map_err(|error| refused("the clock", error))?;
        let token = session.liveliness().declare_token(own_clock.clone()).wait();
        let token = token.map_err(|error| refused("the sign of life", error))?;
        let clocks = PeerClocks::default();
        let inbound = Inbound::open(
            &session,
            process.bus.root(),
            feed::wanted(link, &process.config)?,
            &clocks,
        )?;
        let mut expected: Vec<String> = link.receive.iter().map(|topic| topic.deployment.clone()).collect();
        expected.dedup();
        Ok(Self {
            lanes: open.lanes,
            outbox,
            waiter: open.waiter,
            inbound,
            clocks,
            own_clock,
            compare_ns: i64::MIN,
            expected,
            expiry: ExpiryWatch::of(link),
            _answers: picture.into_iter().chain([clock]).chain(histories).collect(),
            _token: token,
            session,
            _gates: gates,
        })
    }
}

/// Opens the topics that go out.
struct TopicOpener<'a> {
    process: &'a Process,
    waiter: Waiter<SharedMemory>,
    lanes: Vec<Box<dyn Outbound>>,
    /// Keys of the lanes.
    keys: Vec<String>,
    picture: Option<SharedPicture>,
    /// Histories of sent messages, with the index of their stream.
    histories: Vec<(usize, SharedHistory)>,
    /// Bytes of each history.
    history_room: usize,
    sender: Sender,
}

impl Visitor for &mut TopicOpener<'_> {
    type Output = anyhow::Result<()>;

    fn visit<T: Payload>(self, topic: Topic<T>) -> Self::Output {
        let (bus, joined_ns): (&Bus<SharedMemory>, _) = (&self.process.bus, self.process.incarnation);
        let lane = (self.lanes.len(), self.sender);
        let any: &dyn std::any::Any = &topic;
        let outbound: Box<dyn Outbound> = match any.downcast_ref::<Topic<SystemTrack>>() {
            Some(topic) => {
                let picture = SharedPicture::default();
                // Late readers request the present state of the system topic.
                if topic.name.as_str() == messages::system_tracks().name.as_str() {
                    self.picture = Some(Arc::clone(&picture));
                }
                Box::new(OutgoingTracks::open(bus, topic, lane, joined_ns, picture)?)
            }
            None => {
                let history = MessageHistory::with_room(self.history_room);
                self.histories.push((self.lanes.len(), Arc::clone(&history)));
                Box::new(TopicStream::open(bus, &topic, lane, joined_ns, history)?)
            }
        };
        self.waiter.watch(bus, &topic)?;
        self.lanes.push(outbound);
        self.keys
            .push(keys::topic::<T>(&self.process.config.name, topic.name.as_str()));
        Ok(())
    }
}

/// Answers requests for the present track picture.
fn tell_picture(
    session: &Session,
    deployment: &str,
    sender: Sender,
    picture: SharedPicture,
) -> zenoh::Result<Queryable<()>> {
    let key = keys::picture::<SystemTrack>(deployment);
    let of_answers = key.clone();
    let answer = move |query: Query| {
        let now = Now::read();
        let parts = outbound::lock(&picture).tell();
        let of = parts.len() as u32;
        for (index, part) in (0..).zip(parts) {
            let head = Head {
                part: Some(MessagePart { index, of }),
                ..sender.head(now, 0)
            };
            // A failure means that the requesting reader is gone.
            let _ = query.reply(of_answers.as_str(), ZBytes::from(part.finish(head))).wait();
        }
    };
    session.declare_queryable(key).callback(answer).wait()
}

/// Sends recent messages of `key` again, to readers that missed some.
fn send_again(session: &Session, key: &str, sender: Sender, history: SharedHistory) -> zenoh::Result<Queryable<()>> {
    let key = keys::again(key);
    let of_answers = key.clone();
    let answer = move |query: Query| {
        let payload = query.payload().map(|payload| payload.to_bytes().into_owned());
        let Some(position) = payload.and_then(|payload| ReaderPosition::of_bytes(&payload)) else {
            return;
        };
        let answers = history::lock(&history).after(position, sender.head(Now::read(), 0));
        for answer in answers {
            // A failure means that the requesting reader is gone.
            let _ = query.reply(of_answers.as_str(), ZBytes::from(answer)).wait();
        }
    };
    session.declare_queryable(key).callback(answer).wait()
}

impl Agent for LinkAgent {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        self.inbound.check()?;
        if now.mono_ns >= self.compare_ns {
            self.compare_ns = now.mono_ns + COMPARE_NS;
            self.clocks.ask(&self.session, &self.own_clock);
        }
        self.expiry.look(now);
        let mut more = false;
        for lane in &mut self.lanes {
            more |= lane.turn(now, &self.outbox)?;
        }
        Ok(match more {
            true => Turn::Worked,
            false => Turn::Idle(SLEEP),
        })
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        let lanes = &self.lanes;
        self.waiter
            .wait(at_most, || lanes.iter().any(|lane| lane.has_slices()))?;
        Ok(())
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let mut entry = HealthEntry::default();
        for counts in self.lanes.iter().map(|lane| lane.counts()) {
            entry.counters.add(Counter::Taken, counts.taken);
            entry.counters.add(Counter::Lost, counts.lost);
            entry.counters.add(Counter::RejectedSchema, counts.schema_mismatch);
            entry.counters.add(Counter::RecordsSent, counts.sent);
            entry.counters.add(Counter::Unsent, counts.unsent);
            entry.counters.add(Counter::Conflated, counts.conflated);
        }
        self.inbound.report(&mut entry);
        entry.set(Counter::SendFailures, self.outbox.failures());
        peers(
            entries,
            entry,
            &self.clocks.present(Now::read()),
            &self.expected,
            self.expiry.note(),
            &self.session,
        );
    }
}

/// Writes the certificate that ends soon, the missing peers, and distance and clock offset of the present peers, to
/// `entry`, which is added to `entries`. Peers without room in a note get further entries, an entry per peer.
pub(crate) fn peers(
    entries: &mut Vec<HealthEntry>,
    mut entry: HealthEntry,
    present: &[(String, String, Comparison)],
    expected: &[String],
    expiry: Option<&str>,
    session: &Session,
) {
    // Connected, and without an answer: the access control of the other link gives nothing.
    let is_connected = || session.info().peers_zid().wait().next().is_some();
    let why_missing = refused::own().or_else(|| is_connected().then_some("it does not name this host"));
    let ms = |ns: i64| ns as f64 / 1e6;
    let is_missing = |name: &&String| !present.iter().any(|(there, ..)| there == *name);
    let missing: Vec<&String> = expected.iter().filter(is_missing).collect();
    entry.set(Counter::MissingPeers, missing.len() as u64);
    let off_ns = present
        .iter()
        .map(|(.., comparison)| comparison.certain_offset_ns())
        .max();
    entry.set(Counter::HostClockOffUs, (off_ns.unwrap_or(0) / 1_000) as u64);
    let mut there: Vec<&(String, String, Comparison)> = present.iter().collect();
    there.sort_by_key(|(.., comparison)| Reverse(comparison.certain_offset_ns()));
    let there = there.into_iter().map(|(deployment, _, comparison)| {
        let (away, offset) = (ms(comparison.round_trip_ns), ms(comparison.utc_offset_ns));
        format!(
            "{deployment} {away:.1} ms away, its UTC {offset:+.1} ± {:.1} ms",
            away / 2.0
        )
    });
    let missing = missing.into_iter().map(|name| match why_missing {
        Some(cause) => format!("{name} is not there: {cause}"),
        None => format!("{name} is not there"),
    });
    entry.set(Counter::ExpiringCertificates, expiry.iter().len() as u64);
    let expiry = expiry.into_iter().map(str::to_owned);
    let notes: Vec<String> = expiry.chain(missing).chain(there).chain(refused::notes()).collect();
    entry.note = notes.join(", ");
    entries.push(entry);
    entries.extend(notes.into_iter().zip(0..).map(|(note, source)| HealthEntry {
        source,
        note,
        ..HealthEntry::default()
    }));
}

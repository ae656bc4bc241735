//! Feed of a receiver from the network: a connection, datagrams or a document, and the feed's source.
//!
//! A server may start later, end and return; a lost connection is made again. The time of receipt of a piece is the
//! time of the read, since TCP has no time stamps; datagrams have the kernel's.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::time::Duration;

use deployment::{Feed, FeedFormat, FeedLink, FeedOrigin, Input, Source};
use formats::ais::AisSettings;
use formats::cot_events::CotSettings;
use formats::feed::{Fed, FeedReader, FeedSettings, Transmission};
use formats::mode_s::{ModeSSettings, ReceiverRange};
use formats::nmea::RadarTargetSettings;
use formats::readsb::ReadsbSettings;
use formats::remote_id::RemoteIdSettings;
use formats::sbs::SbsSettings;
use frames::PolarSigma;
use messages::{Counter, Counters};
use net::{Document, LinesSettings, ReceiverSettings, TcpLines, UdpReceiver};
use runtime::Process;
use runtime::clock::SteadyClock;
use runtime::{Agent, HealthEntry, Now, Turn};
use sources::SourceReading;

use crate::Processed;
use crate::capture::Capture;
use crate::channel::SourceChannel;
use crate::receiver::ReceiptTime;
use crate::refusals::LatestRefusals;

/// Longest wait for a piece in a turn, bounded by health messages and stop requests.
const PATIENCE: Duration = Duration::from_millis(50);

/// Distance from a receiver at which no aircraft is received, metres: 400 NM, beyond the horizon of the highest.
const RANGE_MAX_M: f64 = 740_800.0;

/// Agent of a receiver of a feed.
#[derive(Debug)]
pub(crate) struct FeedAgent {
    way_in: WayIn,
    capture: Option<Capture>,
    reader: FeedReader,
    /// Sources behind the receiver, each with the origin of its positions.
    channels: Vec<(FeedOrigin, SourceChannel)>,
    steady: SteadyClock,
    refusals: LatestRefusals,
}

/// Where the pieces come from.
#[derive(Debug)]
enum WayIn {
    Tcp(TcpLines, SocketAddr),
    Udp(Box<UdpReceiver>, FeedFormat),
    Http(Document, String),
}

impl WayIn {
    fn open(process: &Process, feed: &Feed) -> anyhow::Result<Self> {
        Ok(match &feed.link {
            FeedLink::Tcp(server) => {
                let usual = LinesSettings::new(*server);
                let settings = LinesSettings {
                    line_octets_max: usual.line_octets_max.filter(|_| feed.format.is_lines()),
                    ..usual
                };
                Self::Tcp(TcpLines::new(settings)?, *server)
            }
            FeedLink::Udp(input) => {
                let interface = input.interface.as_deref();
                let settings = ReceiverSettings::stated(input.listen, interface, &input.senders, input.buffer_bytes)?;
                Self::Udp(Box::new(UdpReceiver::open(&settings)?), feed.format)
            }
            FeedLink::Loopback { port } => {
                let settings = ReceiverSettings::new(IpAddr::V4(process.loopback), *port);
                Self::Udp(Box::new(UdpReceiver::open(&settings)?), feed.format)
            }
            FeedLink::Http { url, period_ns } => {
                let period = Duration::from_nanos(period_ns.unsigned_abs());
                Self::Http(Document::open(url, period)?, url.clone())
            }
        })
    }

    /// Address to which recorded pieces were sent; its readers are unknown here.
    fn recorded_to(&self) -> SocketAddr {
        let any = match self {
            Self::Tcp(_, SocketAddr::V6(_)) => Ipv6Addr::UNSPECIFIED.into(),
            Self::Tcp(..) | Self::Http(..) => Ipv4Addr::UNSPECIFIED.into(),
            Self::Udp(socket, _) => return socket.local_address(),
        };
        SocketAddr::new(any, 0)
    }

    /// Passes the next pieces to `visit`, each with the time of receipt, and whether no further piece continues it.
    /// Returns whether a connection has been lost: what had begun on it is not continued on the next. Waits at most
    /// [`PATIENCE`]. The capture gets what came from an address.
    fn poll(
        &mut self,
        (now, steady): (Now, SteadyClock),
        capture: &mut Option<Capture>,
        mut visit: impl FnMut(&[u8], ReceiptTime, bool),
    ) -> anyhow::Result<bool> {
        let read = |utc_ns: Option<i64>| {
            let read = Now::read();
            ReceiptTime::of(utc_ns.unwrap_or(read.utc_ns), read, steady)
        };
        match self {
            Self::Tcp(client, server) => {
                let lost =
                    |client: &TcpLines| client.counters().lost_connections + client.counters().silent_connections;
                let before = lost(client);
                client.poll(now.mono_ns, PATIENCE, |piece| {
                    let received = read(None);
                    if let Some(capture) = capture {
                        capture.take(*server, received.utc_ns, piece);
                    }
                    visit(piece, received, false);
                });
                return Ok(lost(client) > before);
            }
            Self::Udp(socket, format) => {
                socket.receive(PATIENCE, |datagram| {
                    let received = read(Some(datagram.received_utc_ns));
                    if let Some(capture) = capture {
                        capture.take(datagram.sender, received.utc_ns, datagram.bytes);
                    }
                    if format.is_lines() {
                        // A line is whole, but a message may have parts in the lines of several datagrams.
                        let lines = datagram
                            .bytes
                            .split(|octet| *octet == b'\n')
                            .map(<[u8]>::trim_ascii_end);
                        lines
                            .filter(|line| !line.is_empty())
                            .for_each(|line| visit(line, received, false));
                    } else {
                        visit(datagram.bytes, received, true);
                    }
                })?;
            }
            Self::Http(document, _) => document.poll(PATIENCE, |octets| visit(octets, read(None), true)),
        }
        Ok(false)
    }

    /// Counts of the network, and what is wrong with it, in words.
    fn count(&self, whole: &mut HealthEntry) {
        match self {
            Self::Tcp(client, server) => {
                whole.set(Counter::Connections, client.counters().connections);
                if !client.is_connected() {
                    whole.note = format!("not connected to {server}");
                }
            }
            Self::Udp(socket, _) => {
                let counted = socket.counters();
                whole.set(Counter::Datagrams, counted.datagrams);
                whole.set(Counter::DatagramsRejected, counted.refused_senders);
                whole.set(
                    Counter::DatagramsRejectedLength,
                    counted.empty + counted.oversized + counted.unstamped,
                );
                whole.set(Counter::DatagramsDropped, counted.kernel_drops);
                whole.note = socket.warning().unwrap_or_default().to_owned();
            }
            Self::Http(document, url) => {
                whole.set(Counter::Connections, document.counters().documents);
                if !document.trouble().is_empty() {
                    whole.note = format!("{url}: {}", document.trouble());
                }
            }
        }
    }

    /// Lines that a lost connection has cut so far.
    fn cut(&self) -> u64 {
        match self {
            Self::Tcp(client, _) => client.counters().cut,
            Self::Udp(..) | Self::Http(..) => 0,
        }
    }

    /// Lines that were too long so far.
    fn too_long(&self) -> u64 {
        match self {
            Self::Tcp(client, _) => client.counters().oversized,
            Self::Udp(..) | Self::Http(..) => 0,
        }
    }
}

/// Receiver of a feed, as the configuration states it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StatedReceiver {
    /// Latitude and longitude, degrees.
    pub(crate) place_deg: Option<[f64; 2]>,
    /// Accuracy of range and azimuth, of a radar.
    pub(crate) sigma: Option<PolarSigma>,
}

impl StatedReceiver {
    /// The receiver of a source.
    pub(crate) fn of(source: &Source, reading: &SourceReading) -> Self {
        Self {
            place_deg: source.stated_place_deg,
            sigma: reading.model.covariance.polar(),
        }
    }
}

/// How the pieces of a feed are read: `start_ns` is the UTC of the first frame of a recording that has ticks only.
pub(crate) fn settings(
    format: FeedFormat,
    ahead_of_utc_min: i32,
    StatedReceiver { place_deg, sigma }: StatedReceiver,
    start_ns: i64,
) -> FeedSettings {
    match format {
        FeedFormat::Sbs => FeedSettings::Sbs(SbsSettings {
            ahead_of_utc_min,
            ..SbsSettings::default()
        }),
        FeedFormat::ModeS => FeedSettings::ModeS(ModeSSettings {
            start_utc_ns: start_ns,
            receiver: place_deg.map(|place_deg| ReceiverRange {
                place_deg,
                range_m: RANGE_MAX_M,
            }),
            ..ModeSSettings::default()
        }),
        FeedFormat::Ais => FeedSettings::Ais(AisSettings::default()),
        FeedFormat::RadarTargets => FeedSettings::RadarTargets(RadarTargetSettings { place_deg, sigma }),
        FeedFormat::Readsb => FeedSettings::Readsb(ReadsbSettings::default()),
        FeedFormat::RemoteId => FeedSettings::RemoteId(RemoteIdSettings::default()),
        FeedFormat::Cot => FeedSettings::Cot(CotSettings::default()),
    }
}

/// Whether a source uses positions of this origin.
pub(crate) fn uses(wanted: FeedOrigin, origin: formats::feed::FeedOrigin) -> bool {
    use formats::feed::FeedOrigin as Origin;
    match wanted {
        FeedOrigin::Any => true,
        FeedOrigin::Own => origin == Origin::Own,
        FeedOrigin::Multilateration => origin == Origin::Multilateration,
        FeedOrigin::Traffic => origin == Origin::Traffic,
        FeedOrigin::Repeated => origin == Origin::Repeated,
    }
}

/// Counts of a feed as counters.
pub(crate) fn counted(reader: &FeedReader) -> Counters {
    let counts = reader.counts();
    let mut counters = Counters::default();
    counters[Counter::Records] = counts.records;
    counters[Counter::BlocksRejected] = counts.refused;
    counters[Counter::RejectedNoPosition] = counts.without_position;
    counters[Counter::TracksDropped] = counts.without_room;
    counters
}

impl FeedAgent {
    pub(crate) fn new(process: &Process, feed: &Feed, sources: &[Processed<'_>]) -> anyhow::Result<Self> {
        let way_in = WayIn::open(process, feed)?;
        let stated = sources
            .iter()
            .map(|processed| StatedReceiver::of(processed.source, processed.reading()));
        let stated = stated.reduce(|first, further| StatedReceiver {
            place_deg: first.place_deg.or(further.place_deg),
            sigma: first.sigma.or(further.sigma),
        });
        let channels = sources.iter().map(|processed| {
            let origin = match &processed.source.input {
                Input::Live(live) => live.origin,
                _ => FeedOrigin::Any,
            };
            Ok((origin, SourceChannel::open(process, *processed)?))
        });
        Ok(Self {
            capture: Capture::open(process, way_in.recorded_to())?,
            way_in,
            reader: FeedReader::new(settings(
                feed.format,
                feed.ahead_of_utc_min,
                stated.unwrap_or_default(),
                0,
            )),
            channels: channels.collect::<anyhow::Result<_>>()?,
            steady: SteadyClock::of(Now::read()),
            refusals: LatestRefusals::default(),
        })
    }
}

impl Agent for FeedAgent {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let (reader, channels, refusals) = (&mut self.reader, &mut self.channels, &mut self.refusals);
        let steady = self.steady;
        let mut failed = Ok(());
        let is_lost = self
            .way_in
            .poll((now, steady), &mut self.capture, |piece, received, is_whole| {
                reader.take(piece, Some(received.utc_ns), &mut |fed| match fed {
                    Fed::Target(Transmission { origin, .. }, observed) => {
                        let Some((_, channel)) = channels.iter_mut().find(|(wanted, _)| uses(*wanted, origin)) else {
                            return;
                        };
                        let taken = channel
                            .received(received)
                            .and_then(|()| channel.take(observed, received.mono_ns));
                        if let Some(place) = channel.take_refused_place() {
                            refusals.place(place, received);
                        }
                        if let Some(number) = observed.track_number {
                            channel.alive(number, received);
                        }
                        if failed.is_ok() {
                            failed = taken;
                        }
                    }
                    Fed::Statement(Transmission { origin, .. }, stated) => {
                        let found = channels.iter_mut().find(|(wanted, _)| uses(*wanted, origin));
                        if let Some((_, channel)) = found {
                            channel.state(stated, received);
                        }
                    }
                    // Refused data are counted by reason.
                    Fed::Refused(reason, words) => refusals.note((reason, ""), received, words),
                });
                if is_whole {
                    reader.end();
                }
            })?;
        failed?;
        if is_lost {
            self.reader.end();
        }
        self.refusals.too_long(self.way_in.too_long(), || {
            let read = Now::read();
            ReceiptTime::of(read.utc_ns, read, steady)
        });
        for (_, channel) in &mut self.channels {
            channel.publish()?;
        }
        if let Some(capture) = &mut self.capture {
            capture.hand_over();
        }
        Ok(Turn::Worked)
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        // The feed is read once: its counts are those of the first source.
        let mut decoded = counted(&self.reader);
        decoded[Counter::BlocksRejected] += self.way_in.too_long() + self.way_in.cut();
        let mut sources = Vec::new();
        for (place, (_, channel)) in self.channels.iter().enumerate() {
            let is_first = place == 0;
            let counted = if is_first { decoded } else { Counters::default() };
            let mut of_source = channel.health(&counted);
            if is_first {
                self.refusals.state(&mut of_source);
            }
            sources.push(of_source);
        }
        let mut whole = HealthEntry {
            progress_ns: sources
                .iter()
                .map(|source| source.progress_ns)
                .max()
                .unwrap_or(i64::MIN),
            ..HealthEntry::default()
        };
        whole.add_sources(&sources);
        self.way_in.count(&mut whole);
        if let Some(capture) = &self.capture {
            capture.count(&mut whole);
        }
        entries.push(whole);
        entries.extend(sources);
    }
}

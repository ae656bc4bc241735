//! Checking receivers, and the sources behind them.

use std::collections::BTreeSet;
use std::net::{SocketAddr, ToSocketAddrs as _};

use net::ReceiverSettings;
use reception::Method;
use scenario::{Instrument, SensorKind};

use settings::SettingsError;

use super::checked::{Checked, CheckedSource};
use super::tables::{AsterixTable, FeedTable, LiveTable, ReceiverTable, UdpTable};
use deployment::{
    Asterix, DatagramInput, Feed, FeedFormat, FeedLink, FeedOrigin, Input, Live, Receiver, ReceiverTransport,
    SampleDelivery, Technology, WideAreaSensor, check_name,
};

/// Port of the first simulated sensor on the deployment's loopback address; the others follow.
const FIRST_SIMULATED_PORT: u16 = 30_001;
/// Port of the first simulated wide-area sensor; the others follow.
const FIRST_SIMULATED_WIDE_AREA_PORT: u16 = 31_001;
/// Port of the radar of the first simulated platform; the others follow.
const FIRST_SIMULATED_RADAR_PORT: u16 = 32_101;

/// SAC and SIC of a simulated sensor: those of data that stay where they are, and its number from 1.
pub(super) fn simulated_sac_sic(number: u16) -> (u8, u8) {
    (0, (number + 1) as u8)
}

/// The receivers of a file, and those that simulated sensors bring along.
#[derive(Debug)]
pub(super) struct Network {
    receivers: Vec<Receiver>,
    /// Receivers that the file names.
    named: usize,
}

impl Network {
    pub(super) fn new(raw: &[ReceiverTable]) -> Checked<Self> {
        let mut names = BTreeSet::new();
        let mut receivers = Vec::new();
        for (index, each) in raw.iter().enumerate() {
            let key = |part: &str| format!("receiver[{index}].{part}");
            check_name(&key("name"), &each.name)?;
            if !names.insert(&each.name) {
                let what = format!(
                    "\"{}\" is the name of an earlier receiver; give each its own",
                    each.name
                );
                return Err(SettingsError::new(key("name"), what));
            }
            let transport = match each {
                ReceiverTable { udp: Some(udp), .. } => ReceiverTransport::Udp(check_udp(&key("udp"), udp)?),
                ReceiverTable { tcp: Some(tcp), .. } => ReceiverTransport::Rows {
                    server: server(&key("tcp.connect"), &tcp.connect)?,
                },
                ReceiverTable { feed: Some(feed), .. } => ReceiverTransport::Feed(check_feed(&key("feed"), feed)?),
                ReceiverTable { sbs, .. } => {
                    let sbs = sbs.clone().unwrap_or_default();
                    ReceiverTransport::Feed(Feed {
                        format: FeedFormat::Sbs,
                        link: FeedLink::Tcp(server(&key("sbs.connect"), &sbs.connect)?),
                        ahead_of_utc_min: sbs.ahead_of_utc_min,
                    })
                }
            };
            receivers.push(Receiver {
                name: each.name.clone(),
                transport,
            });
        }
        Ok(Self {
            named: receivers.len(),
            receivers,
        })
    }

    /// A source behind one of the receivers.
    pub(super) fn live(&self, index: usize, raw: &LiveTable) -> Checked<Live> {
        let key = |part: &str| format!("source[{index}].live.{part}");
        self.known(&key("receiver"), &raw.receiver)?;
        Ok(Live {
            receiver: raw.receiver.clone(),
            asterix: asterix(&key("editions"), &raw.sender.reading)?,
            origin: raw.sender.origin,
        })
    }

    fn known(&self, key: &str, name: &str) -> Checked<&Receiver> {
        let found = self.receivers[..self.named]
            .iter()
            .find(|receiver| receiver.name == name);
        found.ok_or_else(|| {
            let known: Vec<&str> = self.receivers[..self.named]
                .iter()
                .map(|receiver| receiver.name.as_str())
                .collect();
            let known = if known.is_empty() {
                "none".to_owned()
            } else {
                known.join(", ")
            };
            SettingsError::new(
                key,
                format!("there is no [[receiver]] named \"{name}\"; there are: {known}"),
            )
        })
    }

    /// Refuses, at `key`, a name that is not that of a receiver of datagrams.
    pub(super) fn datagrams(&self, key: &str, name: &str) -> Checked<()> {
        match self.known(key, name)?.transport {
            ReceiverTransport::Udp(_) => Ok(()),
            _ => {
                let what = format!("\"{name}\" takes no datagrams; name a [[receiver]] with [receiver.udp]");
                Err(SettingsError::new(key, what))
            }
        }
    }

    /// Content of the feed that the receiver called `name` reads; `None` if the receiver reads no feed.
    pub(super) fn feed(&self, name: &str) -> Option<FeedFormat> {
        let receiver = self.receivers.iter().find(|receiver| receiver.name == name)?;
        match &receiver.transport {
            ReceiverTransport::Feed(feed) => Some(feed.format),
            _ => None,
        }
    }

    /// Whether the receiver called `name` takes datagrams.
    pub(super) fn is_udp(&self, name: &str) -> bool {
        let is_it =
            |receiver: &Receiver| receiver.name == name && matches!(receiver.transport, ReceiverTransport::Udp(_));
        self.receivers.iter().any(is_it)
    }

    /// A simulated source, with a receiver of its own.
    pub(super) fn simulated(&mut self, index: usize, name: &str) -> Live {
        self.loopback(name, FIRST_SIMULATED_PORT + index as u16);
        Live {
            receiver: name.to_owned(),
            asterix: Asterix {
                is_strict: true,
                ..Asterix::default()
            },
            origin: FeedOrigin::Any,
        }
    }

    /// A simulated source of AIS, with a receiver of its own.
    pub(super) fn simulated_ais(&mut self, index: usize, name: &str) -> Live {
        self.receivers.push(Receiver {
            name: name.to_owned(),
            transport: ReceiverTransport::Feed(Feed {
                format: FeedFormat::Ais,
                link: FeedLink::Loopback {
                    port: FIRST_SIMULATED_PORT + index as u16,
                },
                ahead_of_utc_min: 0,
            }),
        });
        Live {
            receiver: name.to_owned(),
            asterix: Asterix::default(),
            origin: FeedOrigin::Any,
        }
    }

    /// The receiver of a simulated wide-area sensor.
    pub(super) fn simulated_wide_area_sensor(&mut self, index: usize, name: &str) {
        self.loopback(name, FIRST_SIMULATED_WIDE_AREA_PORT + index as u16);
    }

    /// The receiver of the radar on the simulated platform of this number.
    pub(super) fn simulated_radar(&mut self, platform: u16, name: &str) -> Live {
        self.loopback(name, FIRST_SIMULATED_RADAR_PORT + platform);
        Live {
            receiver: name.to_owned(),
            asterix: Asterix {
                is_strict: true,
                ..Asterix::default()
            },
            origin: FeedOrigin::Any,
        }
    }

    fn loopback(&mut self, name: &str, port: u16) {
        self.receivers.push(Receiver {
            name: name.to_owned(),
            transport: ReceiverTransport::Loopback { port },
        });
    }

    /// All receivers, each of which must have work, and be able to tell its sources apart.
    pub(super) fn receivers(self, sources: &[CheckedSource], sensors: &[WideAreaSensor]) -> Checked<Vec<Receiver>> {
        for (index, receiver) in self.receivers[..self.named].iter().enumerate() {
            let key = format!("receiver[{index}].name");
            let name = &receiver.name;
            let owned = |source: &&CheckedSource| matches!(&source.input, Input::Live(live) if live.receiver == *name);
            let behind: Vec<&CheckedSource> = sources.iter().filter(owned).collect();
            let counting: Vec<&WideAreaSensor> = sensors
                .iter()
                .filter(|sensor| sensor.receiver() == Some(name.as_str()))
                .collect();
            if behind.is_empty() && counting.is_empty() {
                let what = format!(
                    "no source has [source.live] with receiver = \"{name}\", and no wide-area sensor is behind it"
                );
                return Err(SettingsError::new(key, what));
            }
            if !counting.is_empty() && behind.len() + counting.len() > 1 {
                let what = format!(
                    "a wide-area sensor is alone behind its receiver, but {} have receiver = \"{name}\"",
                    behind.len() + counting.len()
                );
                return Err(SettingsError::new(key, what));
            }
            if let Some(other) = sources.iter().find(|source| source.adapter == *name && !owned(source)) {
                let what = format!(
                    "\"{name}\" is also the name of the adapter process of source \"{}\"; give the receiver another",
                    other.name
                );
                return Err(SettingsError::new(key, what));
            }
            let has_rows_only = behind.iter().all(|source| source.has_rows()) && counting.is_empty();
            if matches!(receiver.transport, ReceiverTransport::Rows { .. }) && !has_rows_only {
                let what = format!(
                    "\"{name}\" takes rows of detections only, for the sensors of trackers with live.format = \"rows\"; \
                     give the others a [[receiver]] with [receiver.udp]"
                );
                return Err(SettingsError::new(key, what));
            }
            check_plots(receiver, &behind).map_err(|what| SettingsError::new(&key, what))?;
            if matches!(receiver.transport, ReceiverTransport::Feed(_)) {
                check_origins(&behind).map_err(|what| SettingsError::new(&key, what))?;
                continue;
            }
            if behind.len() > 1 && behind.iter().any(|source| source.has_bearings()) {
                let what = format!(
                    "tables of bearings are of one source, but {} have receiver = \"{name}\"",
                    behind.len()
                );
                return Err(SettingsError::new(key, what));
            }
            for (place, source) in behind.iter().enumerate() {
                let is_same = |other: &&&CheckedSource| {
                    let (own, other) = (&source.reading.model, &other.reading.model);
                    let are_apart = own.method != other.method && ![own.method, other.method].contains(&Method::Any);
                    own.sac_sic == other.sac_sic && !are_apart
                };
                if !source.has_rows() && behind[..place].iter().any(|other| is_same(&other)) {
                    let sender = source.sac_sic.map_or_else(
                        || "no sac and sic".to_owned(),
                        |(sac, sic)| format!("sac = {sac} and sic = {sic}"),
                    );
                    let what = format!(
                        "two sources with receiver = \"{name}\" have {sender}; reports could not be told apart \
                         unless one has method = \"primary\" and the other method = \"secondary\""
                    );
                    return Err(SettingsError::new(format!("source[{}].live", source.number), what));
                }
            }
        }
        Ok(self.receivers)
    }
}

/// Checks that each position of a feed is of one source.
fn check_origins(behind: &[&CheckedSource]) -> Result<(), String> {
    let origin = |source: &CheckedSource| match &source.input {
        Input::Live(live) => live.origin,
        _ => FeedOrigin::Any,
    };
    for (place, source) in behind.iter().enumerate() {
        let own = origin(source);
        let other = behind[..place].iter().find(|other| {
            let other = origin(other);
            other == own || [own, other].contains(&FeedOrigin::Any)
        });
        if let Some(other) = other {
            return Err(format!(
                "the sources \"{}\" and \"{}\" take the same positions of one feed; give each its own origin",
                other.name, source.name
            ));
        }
    }
    Ok(())
}

/// Checks the sensors of tracker processes among the sources behind a receiver.
fn check_plots(receiver: &Receiver, behind: &[&CheckedSource]) -> Result<(), String> {
    let name = &receiver.name;
    let plots = |source: &CheckedSource| match source.delivers {
        SampleDelivery::Plots { sensor_id, .. } => Some(sensor_id),
        _ => None,
    };
    if !behind.iter().any(|source| plots(source).is_some()) {
        return Ok(());
    }
    if let ReceiverTransport::Feed(feed) = &receiver.transport {
        return Err(format!(
            "\"{name}\" takes a feed of {}, which no sensor of a tracker sends; give it [receiver.udp] or [receiver.tcp]",
            feed.format.word()
        ));
    }
    let with_rows: Vec<_> = behind.iter().filter(|source| source.has_rows()).collect();
    if !with_rows.is_empty() && with_rows.len() < behind.len() {
        return Err(format!(
            "rows and ASTERIX come to \"{name}\"; give the sensors with format = \"rows\" a receiver of their own"
        ));
    }
    let ids: Vec<Option<u32>> = with_rows.iter().filter_map(|source| plots(source)).collect();
    let is_unclear = |(place, id): (usize, &Option<u32>)| id.is_none() || ids[..place].contains(id);
    if ids.len() > 1 && ids.iter().enumerate().any(is_unclear) {
        return Err(format!(
            "the rows of {} sensors come to \"{name}\"; give each a sensor_id of its own",
            ids.len()
        ));
    }
    Ok(())
}

pub(super) fn check_udp(key: &str, raw: &UdpTable) -> Checked<DatagramInput> {
    let listen_key = format!("{key}.listen");
    let listen: SocketAddr = raw.listen.parse().map_err(|_| {
        let what = format!(
            "\"{}\" is no address and port; write the multicast group or this machine's address, as in \
             \"239.1.2.3:8600\", \"0.0.0.0:8600\" or \"[ff15::1]:8600\"",
            raw.listen
        );
        SettingsError::new(&listen_key, what)
    })?;
    if listen.port() == 0 {
        return Err(SettingsError::new(
            listen_key,
            "port 0 is no port; give one from 1 to 65535",
        ));
    }
    raw.allowed_senders().map_err(|error| error.under(key))?;
    let interface = raw.interface.as_deref();
    let settings = ReceiverSettings::stated(listen, interface, &raw.senders, raw.buffer_bytes);
    settings
        .and_then(|settings| settings.check())
        .map_err(|error| SettingsError::new(listen_key, error.to_string()))?;
    Ok(DatagramInput {
        listen,
        interface: raw.interface.clone(),
        senders: raw.senders.clone(),
        buffer_bytes: raw.buffer_bytes,
    })
}

pub(super) fn server(key: &str, text: &str) -> Checked<SocketAddr> {
    let found = text.to_socket_addrs().ok().and_then(|mut addresses| addresses.next());
    found.ok_or_else(|| {
        let what = format!("\"{text}\" is no server and port, or its name is not known; write \"127.0.0.1:30003\"");
        SettingsError::new(key, what)
    })
}

/// How ASTERIX records are read, with the editions that `key` states.
pub(super) fn asterix(key: &str, reading: &AsterixTable) -> Checked<Asterix> {
    let mut editions = Vec::new();
    for (word, edition) in &reading.editions {
        let number: u8 = word.parse().map_err(|_| {
            let what = format!("\"{word}\" is not an ASTERIX category: write \"21\" = \"0.23\"");
            SettingsError::new(key, what)
        })?;
        let table = asterix::stated(number, Some(edition)).map_err(|what| SettingsError::new(key, what))?;
        editions.push((number, [table.edition.major, table.edition.minor]));
    }
    Ok(Asterix {
        editions,
        is_strict: reading.strict,
    })
}

/// How a source observes, as what it sends tells.
pub(super) fn technology(input: &Input, instrument: Option<&Instrument>, network: &Network) -> Technology {
    if let Some(Instrument::Sensor(sensor)) = instrument {
        return match sensor.kind {
            SensorKind::Radar => Technology::Secondary,
            SensorKind::Multilateration => Technology::Multilateration,
            SensorKind::AdsB => Technology::AdsB,
        };
    }
    match input {
        Input::Live(live) | Input::Simulated(live) => network
            .feed(&live.receiver)
            .map_or_else(|| of_categories(&live.asterix), |format| of_feed(format, live.origin)),
        Input::Recorded(recorded) => recorded.format.feed().map_or_else(
            || of_categories(&recorded.asterix),
            |format| of_feed(format, recorded.origin),
        ),
        Input::External | Input::Tracker(_) => Technology::Other,
    }
}

/// Checks a feed. Without a server and a document, datagrams are expected.
fn check_feed(key: &str, raw: &FeedTable) -> Checked<Feed> {
    let link = match (&raw.connect, &raw.url, &raw.udp) {
        (Some(connect), None, None) => FeedLink::Tcp(server(&format!("{key}.connect"), connect)?),
        (None, Some(url), None) => {
            if !url.starts_with("http://") {
                let what = format!("\"{url}\" is no address that begins with http://");
                return Err(SettingsError::new(format!("{key}.url"), what));
            }
            FeedLink::Http {
                url: url.clone(),
                period_ns: raw.period_s.ns(),
            }
        }
        (None, None, Some(udp)) => FeedLink::Udp(check_udp(&format!("{key}.udp"), udp)?),
        _ => {
            let what = "needs exactly one of connect (a server), udp (datagrams) and url (a document)";
            return Err(SettingsError::new(key, what));
        }
    };
    if matches!(link, FeedLink::Http { .. }) != (raw.format == FeedFormat::Readsb) {
        let what = "a document is fetched by url for format = \"readsb\" only, and this format comes by url only";
        return Err(SettingsError::new(format!("{key}.format"), what));
    }
    Ok(Feed {
        format: raw.format,
        link,
        ahead_of_utc_min: raw.ahead_of_utc_min,
    })
}

fn of_feed(format: FeedFormat, origin: FeedOrigin) -> Technology {
    match (format, origin) {
        (FeedFormat::Ais, _) => Technology::Ais,
        (FeedFormat::RadarTargets, _) => Technology::Primary,
        (_, FeedOrigin::Multilateration) => Technology::Multilateration,
        // A ground station states what radars see.
        (_, FeedOrigin::Traffic) => Technology::Other,
        (FeedFormat::Sbs | FeedFormat::ModeS | FeedFormat::Readsb, _) => Technology::AdsB,
        (FeedFormat::RemoteId | FeedFormat::Cot, _) => Technology::Other,
    }
}

fn of_categories(asterix: &Asterix) -> Technology {
    let has = |numbers: &[u8]| asterix.editions.iter().any(|(number, _)| numbers.contains(number));
    if has(&[48]) {
        Technology::ModeS
    } else if has(&[1]) {
        Technology::Secondary
    } else if has(&[19, 20]) {
        Technology::Multilateration
    } else if has(&[21]) {
        Technology::AdsB
    } else {
        Technology::Other
    }
}

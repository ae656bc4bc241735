//! What a feed is, by its first seconds.
//!
//! The feed is read until a format is certain and a target has stated a position, which becomes the origin of the
//! frame. A feed that brings nothing in [`PATIENCE`] is named by its port where the port is a usual one.

use std::net::{SocketAddr, ToSocketAddrs as _};
use std::time::Duration;

use anyhow::Context as _;
use deployment::FeedFormat;
use formats::foreign::Foreign;
use net::{Document, LinesSettings, ReceiverSettings, TcpLines, UdpReceiver};
use offline::Usage;
use runtime::Now;
use runtime::clock::mono_ns;

use super::judge::{feed_source, feeds_of};
use super::opened::{Opened, OpenedInput};

/// Longest time until a position must have come.
const PATIENCE: Duration = Duration::from_secs(20);
/// Longest wait for octets at a time.
const STEP: Duration = Duration::from_millis(200);
/// Octets that are looked at.
const OCTETS_MAX: usize = 4 << 20;
/// Ports of receivers: number, format, what usually sends there.
const PORTS: [(u16, FeedFormat, &str); 5] = [
    (30_002, FeedFormat::ModeS, "frames of transponder receivers as text"),
    (30_003, FeedFormat::Sbs, "lines of transponder receivers (SBS-1)"),
    (30_005, FeedFormat::ModeS, "frames of transponder receivers (Beast)"),
    (10_110, FeedFormat::Ais, "AIS"),
    (4_242, FeedFormat::Cot, "Cursor on Target"),
];

/// Address of a feed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum FeedAddress {
    Tcp(SocketAddr),
    Udp(SocketAddr),
    Http(String),
}

/// Returns the address that `what` is; `None` if `what` is a file.
pub(super) fn address(what: &str) -> Option<Result<FeedAddress, Usage>> {
    let (scheme, rest) = what.split_once("://")?;
    Some(match scheme {
        "tcp" => socket(what, rest).map(FeedAddress::Tcp),
        "udp" => {
            let any = rest.strip_prefix(':').map(|port| format!("0.0.0.0:{port}"));
            socket(what, any.as_deref().unwrap_or(rest)).map(FeedAddress::Udp)
        }
        "http" => Ok(FeedAddress::Http(what.to_owned())),
        "https" => Err(Usage(format!(
            "{what}: feeds are read without encryption: use http://, or a proxy on this machine"
        ))),
        _ => Err(Usage(format!("{what}: feeds begin with tcp://, udp:// or http://"))),
    })
}

fn socket(what: &str, address: &str) -> Result<SocketAddr, Usage> {
    let found = address
        .to_socket_addrs()
        .ok()
        .and_then(|mut addresses| addresses.next());
    found.ok_or_else(|| {
        Usage(format!(
            "{what}: \"{address}\" is no address with a port, as in 192.168.1.7:30005"
        ))
    })
}

/// Source of octets.
enum Octets {
    Tcp(Box<TcpLines>, SocketAddr),
    Udp(Box<UdpReceiver>),
    Http(Box<Document>),
}

impl Octets {
    fn open(address: &FeedAddress) -> anyhow::Result<Self> {
        Ok(match address {
            FeedAddress::Tcp(server) => {
                let settings = LinesSettings {
                    line_octets_max: None,
                    ..LinesSettings::new(*server)
                };
                Self::Tcp(Box::new(TcpLines::new(settings)?), *server)
            }
            FeedAddress::Udp(listen) => {
                let settings = ReceiverSettings::new(listen.ip(), listen.port());
                Self::Udp(Box::new(UdpReceiver::open(&settings)?))
            }
            FeedAddress::Http(url) => Self::Http(Box::new(Document::open(url, Duration::from_secs(1))?)),
        })
    }

    /// Appends what comes within a step.
    ///
    /// # Errors
    /// If the server cannot be reached or has closed the connection, or a document cannot be fetched.
    fn read(&mut self, into: &mut Vec<u8>) -> anyhow::Result<()> {
        match self {
            Self::Tcp(client, server) => {
                client.poll(mono_ns(), STEP, |octets| into.extend_from_slice(octets));
                let counted = client.counters();
                anyhow::ensure!(counted.failed_attempts == 0, "{server} cannot be reached");
                anyhow::ensure!(counted.lost_connections == 0, "{server} has closed the connection");
            }
            Self::Udp(socket) => {
                socket.receive(STEP, |datagram| {
                    into.extend_from_slice(datagram.bytes);
                    // Datagrams may lack the end of their last line.
                    if !datagram.bytes.ends_with(b"\n") && datagram.bytes.is_ascii() {
                        into.push(b'\n');
                    }
                })?;
            }
            Self::Http(document) => {
                document.poll(STEP, |octets| {
                    into.extend_from_slice(octets);
                    into.push(b'\n');
                });
                anyhow::ensure!(document.trouble().is_empty(), "{}", document.trouble());
            }
        }
        Ok(())
    }
}

/// Judges a feed.
///
/// # Errors
/// If the feed cannot be reached, or what it brings is of no format that is read.
pub(super) fn open(address: &FeedAddress, place_deg: Option<[f64; 2]>) -> anyhow::Result<Opened> {
    let (what, label) = match address {
        FeedAddress::Tcp(server) => (format!("tcp://{server}"), format!("tcp-{}", server.port())),
        FeedAddress::Udp(listen) => (format!("udp://{listen}"), format!("udp-{}", listen.port())),
        FeedAddress::Http(url) => (url.clone(), "http".to_owned()),
    };
    super::decide(&format!("{what}: waiting for data, up to {} s", PATIENCE.as_secs()));
    let mut octets = Octets::open(address).with_context(|| what.clone())?;
    let (mut read, begun_ns) = (Vec::new(), mono_ns());
    let passed = || Duration::from_nanos((mono_ns() - begun_ns).unsigned_abs());
    let mut judged = None;
    while passed() < PATIENCE && read.len() < OCTETS_MAX {
        let before = read.len();
        octets.read(&mut read).with_context(|| what.clone())?;
        if read.len() == before {
            continue;
        }
        judged = judge(&read, place_deg).or(judged);
        if judged.is_some_and(|(_, _, first_deg)| first_deg.is_some() || place_deg.is_some()) {
            break;
        }
    }
    let port = match address {
        FeedAddress::Tcp(at) | FeedAddress::Udp(at) => at.port(),
        FeedAddress::Http(_) => 0,
    };
    let usual = PORTS.iter().find(|(number, ..)| *number == port);
    let (format, why, first_deg) = match (judged, usual) {
        (Some((format, records, first_deg)), _) => {
            let why = format!(
                "format \"{}\": {records} transmissions read in {:.1} s",
                format.word(),
                passed().as_secs_f64()
            );
            (format, why, first_deg)
        }
        (None, Some((_, format, usually))) if read.is_empty() => {
            let why = format!(
                "nothing came in {} s; port {port} usually has {usually}: format \"{}\"",
                PATIENCE.as_secs(),
                format.word()
            );
            (*format, why, None)
        }
        _ => {
            let found = match Foreign::of(&read) {
                _ if read.is_empty() => format!("nothing came in {} s", PATIENCE.as_secs()),
                Some(kind) => match refused(kind, &read, place_deg) {
                    Some(refused) => format!("{kind}; the latest refusal: {refused}"),
                    None => kind.to_string(),
                },
                None => format!("{} octets of no kind that is known here came", read.len()),
            };
            return Err(Usage(format!("{what}: {found}; `koseki open --help` lists what is read")).into());
        }
    };
    let keys = match address {
        FeedAddress::Tcp(server) => format!("connect = \"{server}\"\n"),
        FeedAddress::Udp(listen) => format!("udp = {{ listen = \"{listen}\" }}\n"),
        FeedAddress::Http(url) => format!("url = {url:?}\n"),
    };
    Ok(Opened {
        label,
        input: OpenedInput::Feed(format!("[receiver.feed]\nformat = \"{}\"\n{keys}", format.word())),
        sources: vec![feed_source(format, place_deg)],
        decisions: vec![why],
        first_deg,
        first_utc_ns: None,
        is_in_metres: false,
    })
}

/// Returns the format that most of the octets fit, the number of transmissions, and the first position; `None` if none.
fn judge(octets: &[u8], place_deg: Option<[f64; 2]>) -> Option<(FeedFormat, u64, Option<[f64; 2]>)> {
    let kind = Foreign::of(octets)?;
    let received_ns = Some(Now::read().utc_ns);
    let judged = feeds_of(kind).iter().map(|format| {
        let mut first_deg = None;
        let survey = adapter::survey_feed(octets, *format, (place_deg, received_ns), &mut |report| {
            first_deg = first_deg.or(report.geodetic.map(|position| position.map(f64::to_degrees)));
        });
        (*format, survey.counts.records, first_deg.or(survey.station_deg))
    });
    judged
        .max_by_key(|(_, records, _)| *records)
        .filter(|(_, records, _)| *records > 0)
}

/// Returns the latest refusal of the likeliest format with one.
fn refused(kind: Foreign, octets: &[u8], place_deg: Option<[f64; 2]>) -> Option<String> {
    let received_ns = Some(Now::read().utc_ns);
    feeds_of(kind)
        .iter()
        .find_map(|format| adapter::survey_feed(octets, *format, (place_deg, received_ns), &mut |_| ()).refused)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_of_feeds_are_no_files() {
        assert!(address("flight.beast").is_none());
        let at = |text: &str| address(text).unwrap();
        assert_eq!(
            at("tcp://127.0.0.1:30005").unwrap(),
            FeedAddress::Tcp("127.0.0.1:30005".parse().unwrap())
        );
        assert_eq!(
            at("udp://:10110").unwrap(),
            FeedAddress::Udp("0.0.0.0:10110".parse().unwrap())
        );
        for (text, reason) in [
            ("tcp://127.0.0.1", "no address with a port"),
            ("https://a/b", "http://"),
            ("ftp://a/b", "tcp://, udp:// or http://"),
        ] {
            let refused = at(text).unwrap_err().to_string();
            assert!(refused.contains(text) && refused.contains(reason), "{refused}");
        }
    }
}

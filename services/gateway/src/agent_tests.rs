//! A gateway over changes of fusion: what its user gets.

use std::net::UdpSocket;
use std::time::Duration;

use asterix::{Mode, NamedRecord, Value, blocks, registry};
use bus::{Bus, InProcess, Mark, Publisher, Root, TopicHold};
use configuration::ConfigWith;
use messages::{Counter, Health, LifeState, ProcessKind, SystemTrack, TrackState};
use runtime::{Agent as _, HealthEntry, Now};
use tempfile::TempDir;
use test_support::S;

use crate::agent::GatewayAgent;
use crate::destination::Destination;
use crate::settings::{Keys, Settings};

const LOAD: &str = include_str!("../../../config/load.toml");

/// The gateway of a deployment, its user, and who publishes.
struct Bench {
    gateway: GatewayAgent<InProcess>,
    user: UdpSocket,
    now_ns: i64,
    health: Publisher<InProcess, Health>,
    bus: Bus<InProcess>,
    _held: (TopicHold, TopicHold, TopicHold, TopicHold),
    _folder: TempDir,
}

/// The gateway, listening at a port of the system's choice if it listens.
fn any_port(gateway: &Settings) -> Settings {
    Settings {
        listen: gateway.listen.map(|_| Destination(([127, 0, 0, 1], 0).into())),
        ..gateway.clone()
    }
}

/// A record that the user has got, in words.
type Got = Vec<String>;

impl Bench {
    fn new() -> Self {
        Self::with(&[])
    }

    /// With keys that are set.
    fn with(overrides: &[&str]) -> Self {
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        let folder = tempfile::tempdir().unwrap();
        let user = UdpSocket::bind("127.0.0.1:0").unwrap();
        user.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let text = LOAD
            .replace(
                "239.255.62.2:8662\"\ninterface = \"127.0.0.1",
                &user.local_addr().unwrap().to_string(),
            )
            .replace("refresh_s = 0.0", "refresh_s = 1.0");
        let path = folder.path().join("gateway.toml");
        std::fs::write(&path, text).unwrap();
        let config = ConfigWith::<Keys>::read(&path, &overrides).unwrap();
        let root = Root::in_base(folder.path(), "test").unwrap();
        let bus: Bus<InProcess> = Bus::open(&root, "test").unwrap();
        let held = (
            bus.hold(&messages::system_tracks()).unwrap(),
            bus.hold(&messages::own_tracks()).unwrap(),
            bus.hold(&messages::health()).unwrap(),
            bus.hold(&messages::alarms()).unwrap(),
        );
        Self {
            gateway: GatewayAgent::new(&config, &any_port(&config.parts.gateways[0]), &bus, 1).unwrap(),
            user,
            now_ns: 100 * S,
            health: bus.publisher(&messages::health(), 1).unwrap(),
            bus,
            _held: held,
            _folder: folder,
        }
    }

    fn fusion(&self, epoch: u64) -> Publisher<InProcess, SystemTrack> {
        let publisher = self.bus.publisher(&messages::system_tracks(), epoch).unwrap();
        publisher.with_epoch(epoch)
    }

    fn mark(&self) -> Mark {
        Mark {
            progress_ns: i64::MIN,
            sent_ns: self.now_ns,
            end: false,
        }
    }

    fn show(&self, fusion: &mut Publisher<InProcess, SystemTrack>, tracks: &[(u32, TrackState)]) {
        let state = |index: usize, sequence| SystemTrack {
            sequence,
            track_number: tracks[index].0,
            state: tracks[index].1 as u8,
            reference_time_ns: self.now_ns,
            ..SystemTrack::default()
        };
        fusion.send(self.mark(), tracks.len(), state).unwrap();
    }

    /// Lets so many seconds pass, in which fusion says that it runs; what the user gets of it but for plain states.
    fn pass(&mut self, seconds: i64) -> Got {
        for _ in 0..seconds {
            self.now_ns += S;
            let said = Health {
                said_ns: self.now_ns,
                kind: ProcessKind::Fusion as u8,
                life: LifeState::Running as u8,
                ..Health::default()
            };
            let said = said.with_name("fusion");
            self.health.send(self.mark(), 1, |_, _| said).unwrap();
            self.turn();
        }
        self.got()
    }

    fn turn(&mut self) {
        let now = Now {
            mono_ns: self.now_ns,
            utc_ns: self.now_ns,
        };
        let _ = self.gateway.turn(now).unwrap();
    }

    /// Reads up to a datagram of its own: over loopback, datagrams arrive in their order.
    fn got(&self) -> Got {
        let mut got = Got::new();
        let mut octets = [0; 2000];
        self.user.send_to(b"end", self.user.local_addr().unwrap()).unwrap();
        loop {
            let length = self.user.recv(&mut octets).unwrap();
            if &octets[..length] == b"end" {
                return got;
            }
            for block in blocks(&octets[..length]).map(Result::unwrap) {
                let table = registry::default_edition(block.category).unwrap();
                for record in block.records(table, Mode::Strict) {
                    got.extend(words(block.category, &NamedRecord::new(&record.unwrap())));
                }
            }
        }
    }

    fn health(&self) -> HealthEntry {
        let mut entries = Vec::new();
        self.gateway.health(&mut entries);
        entries.swap_remove(0)
    }

    fn counted(&self, counter: Counter) -> u64 {
        self.health().counters[counter]
    }
}

/// What a user must do something about: beginnings and ends of tracks, events of the service, numbering anew.
fn words(category: u8, record: &NamedRecord) -> Option<String> {
    let number = |path: &[&str]| match record.get(path) {
        Some(Value::Unsigned(number)) => *number,
        _ => 0,
    };
    let track = number(&["040"]);
    match (category, number(&["080", "TSB"]), number(&["080", "TSE"])) {
        (62, 1, _) => Some(format!("{track} begins")),
        (62, _, 1) => Some(format!("{track} ends")),
        (65, ..) if number(&["050"]) > 0 => Some(format!("event {}", number(&["050"]))),
        (65, ..) if number(&["040", "STTN"]) > 0 => Some("other numbers".to_owned()),
        _ => None,
    }
}

const SHOWN: TrackState = TrackState::Confirmed;

#[test]
fn tracks_go_on_over_a_change_of_fusions_and_those_that_are_told_ended_or_never_heard_of_end() {
    let mut bench = Bench::new();
    let (mut first, mut second) = (bench.fusion(5), bench.fusion(6));
    bench.show(&mut first, &[(1, SHOWN), (2, SHOWN), (3, SHOWN)]);
    assert_eq!(bench.pass(1), ["1 begins", "2 begins", "3 begins"]);
    second.go_on();
    bench.show(&mut second, &[(1, SHOWN), (2, TrackState::Terminated)]);
    assert_eq!(bench.pass(1), ["2 ends"]);
    // The first one wakes up.
    bench.show(&mut first, &[(2, SHOWN), (4, SHOWN)]);
    assert_eq!(bench.pass(1), [""; 0]);
    assert_eq!(bench.counted(Counter::RejectedEpoch), 2);
    assert_eq!(bench.pass(40), ["3 ends"]);
}

#[test]
fn a_suspended_track_ends_for_the_receiver_and_begins_again_when_it_resumes() {
    let mut bench = Bench::new();
    let mut fusion = bench.fusion(5);
    bench.show(&mut fusion, &[(1, SHOWN), (2, SHOWN)]);
    assert_eq!(bench.pass(1), ["1 begins", "2 begins"]);
    bench.show(&mut fusion, &[(1, TrackState::Suspended), (2, TrackState::Suspended)]);
    assert_eq!(bench.pass(1), ["1 ends", "2 ends"]);
    bench.show(&mut fusion, &[(1, SHOWN), (2, TrackState::Terminated)]);
    assert_eq!(bench.pass(1), ["1 begins"]);
}

#[test]
fn another_centre_gets_what_the_sensors_here_know_and_nothing_that_it_has_told() {
    let mut bench = Bench::with(&["gateway[0].own=true", "fusion.exchange=true"]);
    let mut fused = bench.fusion(5);
    let own = bench.bus.publisher(&messages::own_tracks(), 5).unwrap();
    let mut own = own.with_epoch(5);
    bench.show(&mut fused, &[(1, SHOWN), (2, SHOWN)]);
    bench.show(&mut own, &[(2, SHOWN)]);
    assert_eq!(bench.pass(1), ["2 begins"]);
    bench.show(&mut own, &[(2, TrackState::Terminated)]);
    assert_eq!(bench.pass(1), ["2 ends"]);
}

#[test]
fn users_are_told_that_tracks_are_numbered_anew_where_nobody_knows_the_ones_before() {
    let mut bench = Bench::new();
    let (mut first, mut second) = (bench.fusion(5), bench.fusion(6));
    bench.show(&mut first, &[(1, SHOWN)]);
    assert_eq!(bench.pass(1), ["1 begins"]);
    bench.show(&mut second, &[(7, SHOWN)]);
    assert_eq!(bench.pass(1), ["1 ends", "7 begins", "event 5", "event 6"]);
    assert_eq!(bench.pass(1), ["other numbers"]);
}

/// Keys of a gateway of Cursor on Target.
const COT: [&str; 4] = [
    "gateway[0].format=\"cot\"",
    "gateway[0].edition=\"off\"",
    "gateway[0].sac=\"off\"",
    "gateway[0].sic=\"off\"",
];

/// Number and time to live, seconds, of an event of the deployment.
fn event(text: &str) -> (u32, i64) {
    let attribute = |name: &str| {
        let (_, rest) = text.split_once(&format!(" {name}=\"")).unwrap();
        rest.split_once('"').unwrap().0
    };
    let second = |name: &str| -> i64 {
        let (_, second) = attribute(name).rsplit_once(':').unwrap();
        second.trim_end_matches('Z').parse::<f64>().unwrap() as i64
    };
    let number = attribute("uid").strip_prefix("koseki.load.").unwrap();
    (
        number.parse().unwrap(),
        (second("stale") - second("start")).rem_euclid(60),
    )
}

#[test]
fn each_event_of_cursor_on_target_is_a_datagram() {
    let mut bench = Bench::with(&COT);
    let mut fusion = bench.fusion(5);
    bench.show(&mut fusion, &[(1, SHOWN), (2, SHOWN), (3, TrackState::Tentative)]);
    bench.turn();
    bench.show(&mut fusion, &[(2, TrackState::Terminated)]);
    bench.turn();
    let mut octets = [0; 2000];
    let mut got = Vec::new();
    for _ in 0..3 {
        let length = bench.user.recv(&mut octets).unwrap();
        got.push(event(std::str::from_utf8(&octets[..length]).unwrap()));
    }
    assert_eq!(got, [(1, 30), (2, 30), (2, 0)]);
    assert_eq!(bench.counted(Counter::RecordsSent), 3);
    assert_eq!(bench.counted(Counter::DatagramsSent), 3);
}

#[test]
fn clients_of_cursor_on_target_that_connect_get_each_event_as_a_line() {
    let listen = [
        "gateway[0].send_to=\"off\"",
        "gateway[0].listen=\"127.0.0.1:1\"",
        "gateway[0].stale_s=7",
    ];
    let mut bench = Bench::with(&[&COT[..], &listen[..]].concat());
    let mut fusion = bench.fusion(5);
    let client = std::net::TcpStream::connect(bench.gateway.listening_at().unwrap()).unwrap();
    client.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    bench.turn();
    bench.show(&mut fusion, &[(4, SHOWN), (9, SHOWN)]);
    bench.turn();
    let lines = std::io::BufRead::lines(std::io::BufReader::new(client));
    let got: Vec<_> = lines.take(2).map(|line| event(&line.unwrap())).collect();
    assert_eq!(got, [(4, 7), (9, 7)]);
}

#[test]
fn clients_beyond_those_of_an_address_are_refused_counted_and_named() {
    let listen = ["gateway[0].send_to=\"off\"", "gateway[0].listen=\"127.0.0.1:1\""];
    let mut bench = Bench::with(&[&COT[..], &listen[..]].concat());
    let address = bench.gateway.listening_at().unwrap();
    let most = net::DoorLimits::OF_READERS.address_max;
    let clients = (0..=most).map(|_| std::net::TcpStream::connect(address).unwrap());
    let clients: Vec<_> = clients.collect();
    bench.turn();
    assert_eq!(bench.counted(Counter::Connections), most as u64);
    assert_eq!(bench.counted(Counter::RequestsRejected), 1);
    let last = clients.last().unwrap().local_addr().unwrap();
    assert_eq!(
        bench.health().refusal,
        format!("clients: too-many-of-address 1; the last one: too-many-of-address, {last}")
    );
}

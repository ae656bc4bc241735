//! Live feeds in and ASTERIX out, as a user runs them: real sockets on the loopback interface, real processes, hostile
//! senders and killed processes.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, UdpSocket};
use std::time::{Duration, Instant};

use asterix::{Decoder, Mode, NamedRecord, Value, registry};
use frames::{Geodetic, SensorFrame};
use messages::{Covariance, Identity, SensorTrack, TrackState, sensor_track_bits as bits};
use net::{Interface, ReceiverSettings, SenderSettings, UdpReceiver, UdpSender};
use outgoing::{HeightReference, SensorReports};
use rustix::process::Signal;
use test_support::{Dice, mutated};

use crate::common::home::PATIENCE;
use crate::common::{Home, PLACE, Running, counter, free_address, kill, system, utc_ns};

/// Targets that the test's sensors see.
const TARGETS: u32 = 5;
/// Time between two scans.
const SCAN: Duration = Duration::from_millis(100);
/// Bytes of a data block before its first record.
const HEADER_BYTES: usize = 3;
const LOOPBACK: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);
/// A neighbour that is on nobody's list.
const STRANGER: [u8; 4] = [127, 9, 9, 9];

/// A deployment with two sensors behind one multicast socket, a feed of transponders, and a gateway to the test.
struct Site {
    home: Home,
    group: SocketAddr,
    feed: TcpListener,
    gateway: UdpReceiver,
}

impl Site {
    fn new(gateway: &str) -> Self {
        let home = Home::new();
        // A group that nobody else uses.
        let port = free_address().port();
        let group = SocketAddr::from(([239, 255, (port >> 8) as u8, port as u8], port));
        let feed = TcpListener::bind((LOOPBACK, 0)).unwrap();
        let receiver = UdpReceiver::open(&ReceiverSettings::new(LOOPBACK, 0)).unwrap();
        let text = format!(
            r#"name = "test"
[frame]
latitude_deg = {}
longitude_deg = {}
[[receiver]]
name = "lan"
[receiver.udp]
listen = "{group}"
interface = "127.0.0.1"
senders = ["127.0.0.1"]
[[receiver]]
name = "box"
[receiver.sbs]
connect = "{}"
[[source]]
name = "radar"
period_s = 0.1
fresh_s = 5.0
[source.live]
receiver = "lan"
sac = 1
sic = 1
strict = true
[[source]]
name = "mlat"
period_s = 0.1
fresh_s = 5.0
[source.live]
receiver = "lan"
sac = 1
sic = 2
editions = {{ "20" = "1.9" }}
[[source]]
name = "adsb"
period_s = 0.1
fresh_s = 5.0
[source.live]
receiver = "box"
[[gateway]]
name = "out"
send_to = "{}"
sac = 9
sic = 8
refresh_s = 0.2
status_s = 0.2
{gateway}
[fusion.life]
confirm_reports = 2
terminate_s = 10.0
[recorder]
enabled = false
"#,
            PLACE[0],
            PLACE[1],
            feed.local_addr().unwrap(),
            receiver.local_address(),
        );
        std::fs::write(home.path("site.toml"), text).unwrap();
        Self {
            home,
            group,
            feed,
            gateway: receiver,
        }
    }

    fn start(&self) -> Running {
        let running = self
            .home
            .start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
        running.until_said("instance test runs");
        running
    }

    /// The report that the monitor has written at the end.
    fn report(&self) -> serde_json::Value {
        serde_json::from_slice(&std::fs::read(self.home.path("out/latest/report.json")).unwrap()).unwrap()
    }
}

/// Where target `number` flies, as all sensors see it.
fn track(number: u32, time_ns: i64) -> SensorTrack {
    SensorTrack {
        time_of_measurement_ns: time_ns,
        track_number: number + 1,
        valid: bits::VELOCITY | bits::HEIGHT,
        identity: Identity::default()
            .with_address(0x40_0000 + number)
            .with_mode_3a(0o1200 + number as u16),
        position_m: [8_000.0 + 5_000.0 * f64::from(number), -12_000.0, 3_000.0],
        velocity_mps: [0.0, 0.0, 0.0],
        covariance: Covariance::diagonal([20.0; 3], [2.0; 3]),
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    }
}

/// A sensor that sends ASTERIX to the group.
struct Sensor {
    reports: SensorReports,
    sender: UdpSender,
}

impl Sensor {
    fn new(group: SocketAddr, category: u8, sic: u8) -> Self {
        let (place, system) = system();
        let frame = SensorFrame::new(&system, place, 0.0);
        let table = registry::default_edition(category).unwrap();
        let settings = SenderSettings {
            interface: Some(Interface::Address(LOOPBACK)),
            ..SenderSettings::new(group)
        };
        Self {
            reports: SensorReports::new(table, 1, sic, frame, system, 1472)
                .unwrap()
                .with_height(HeightReference::Barometric),
            sender: UdpSender::open(&settings).unwrap(),
        }
    }

    fn scan(&mut self) -> u64 {
        let sender = &mut self.sender;
        let mut send = |datagram: &[u8]| sender.send(datagram).unwrap();
        for number in 0..TARGETS {
            self.reports.report(&track(number, utc_ns()), &mut send);
        }
        self.reports.flush(&mut send);
        u64::from(TARGETS)
    }
}

/// What the gateway has sent so far.
#[derive(Default)]
struct Heard {
    /// Latest report of each address.
    tracks: BTreeMap<u64, NamedRecord>,
    /// Identifications of the sensors that it told of.
    sensors: BTreeSet<u64>,
    system_statuses: u64,
    /// Events of the service, in the order in which they came.
    events: Vec<u64>,
}

impl Heard {
    fn hear(&mut self, gateway: &mut UdpReceiver, patience: Duration) {
        let mut decoder = Decoder::new(Mode::Strict);
        gateway
            .receive(patience, |datagram| {
                for record in decoder.records(datagram.bytes) {
                    let record = record.expect("a gateway sends sound records");
                    let named = NamedRecord::new(&record);
                    let number = |path: &[&str]| named.get(path).and_then(Value::as_u64);
                    self.system_statuses += u64::from(named.category == 65);
                    match named.category {
                        65 => self.events.extend(number(&["050"])),
                        _ => self.sensors.extend(number(&["050", "SIC"])),
                    }
                    if let Some(address) = number(&["380", "ADR"]) {
                        self.tracks.insert(address, named);
                    }
                }
            })
            .unwrap();
    }
}

/// Scans until `done`, and listens to the gateway between the scans.
fn scan_until(
    what: &str,
    site: &mut Site,
    sensors: &mut [Sensor],
    heard: &mut Heard,
    mut done: impl FnMut(&Heard) -> bool,
) -> u64 {
    let (begun, mut sent) = (Instant::now(), 0);
    while !done(heard) {
        assert!(begun.elapsed() < PATIENCE, "never happened: {what}");
        sent += sensors.iter_mut().map(Sensor::scan).sum::<u64>();
        let next = Instant::now() + SCAN;
        while Instant::now() < next {
            heard.hear(&mut site.gateway, next.saturating_duration_since(Instant::now()));
        }
    }
    sent
}

fn assert_in_place(heard: &Heard) {
    for number in 0..TARGETS {
        let track = &heard.tracks[&u64::from(0x40_0000 + number)];
        let degrees = |name| track.get(&["105", name]).and_then(Value::as_f64).unwrap();
        let expected = system().1.to_geodetic(self::track(number, 0).position_m);
        let found = Geodetic::from_degrees(degrees("LAT"), degrees("LON"), expected.height_m()).unwrap();
        let found = system().1.to_local(found);
        let place = self::track(number, 0).position_m;
        let off = (found[0] - place[0]).hypot(found[1] - place[1]);
        assert!(off < 40.0, "target {number} is {off} m off");
    }
}

#[test]
fn what_sensors_send_comes_out_of_the_gateway() {
    let mut site = Site::new("");
    let running = site.start();
    let mut sensors = [Sensor::new(site.group, 48, 1), Sensor::new(site.group, 20, 2)];
    let mut heard = Heard::default();
    let all =
        |heard: &Heard| heard.tracks.len() == TARGETS as usize && heard.sensors.len() == 3 && heard.system_statuses > 0;
    scan_until("all targets and states", &mut site, &mut sensors, &mut heard, all);
    assert_in_place(&heard);

    // A feed of lines adds the one target that nobody else sees.
    let (mut feed, _) = site.feed.accept().unwrap();
    let line = || {
        let seconds = utc_ns() / 1_000_000_000 % 86_400;
        let time = format!("{:02}:{:02}:{:02}.000", seconds / 3600, seconds / 60 % 60, seconds % 60);
        format!("MSG,3,1,1,4CA2D6,1,2026/01/01,{time},2026/01/01,{time},,10000,,,41.5,2.3,,,0,0,0,0\r\nnonsense\r\n")
    };
    let has_it = |heard: &Heard| heard.tracks.contains_key(&0x4C_A2D6);
    let begun = Instant::now();
    while !has_it(&heard) {
        assert!(begun.elapsed() < PATIENCE, "the feed's target never came out");
        feed.write_all(line().as_bytes()).unwrap();
        heard.hear(&mut site.gateway, SCAN);
    }
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    site.home.assert_nothing_is_left("test");
}

#[test]
fn a_user_gets_the_area_the_levels_and_the_categories_that_are_his() {
    let second = UdpReceiver::open(&ReceiverSettings::new(LOOPBACK, 0)).unwrap();
    let users = format!(
        "status = [65]\nlevels = [90.0, 110.0]\n\
         [gateway.area]\nsouth_deg = 41.0\nnorth_deg = 41.3\nwest_deg = 2.2\neast_deg = 2.32\n\
         [[gateway]]\nname = \"above\"\nsend_to = \"{}\"\nsac = 9\nsic = 7\nstatus_s = 0.2\nlevels = [110.0, 200.0]\n",
        second.local_address()
    );
    let mut site = Site::new(&users);
    let running = site.start();
    let mut sensors = [Sensor::new(site.group, 48, 1), Sensor::new(site.group, 20, 2)];
    let (mut heard, mut above, mut second) = (Heard::default(), Heard::default(), second);
    let all = |heard: &Heard| heard.tracks.len() == 2 && heard.system_statuses > 0;
    scan_until("the targets in the area", &mut site, &mut sensors, &mut heard, all);
    // As many turns again: the others would have come.
    let statuses = heard.system_statuses;
    let later = |heard: &Heard| heard.system_statuses > statuses + 10;
    scan_until("ten more statuses", &mut site, &mut sensors, &mut heard, later);
    let inside = [0x40_0001, 0x40_0002];
    assert!(heard.tracks.keys().eq(&inside), "{:x?}", heard.tracks.keys());
    assert!(
        heard.sensors.is_empty() && heard.events.is_empty(),
        "{:?}",
        heard.events
    );
    above.hear(&mut second, SCAN);
    assert!(above.tracks.is_empty(), "nobody flies there");
    assert!(
        above.sensors.len() == 3 && above.system_statuses > 0,
        "its status has both categories"
    );
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    heard.hear(&mut site.gateway, SCAN);
    assert_eq!(heard.events, [7], "the service was ended by the operator");
    site.home.assert_nothing_is_left("test");
}

#[test]
fn hostile_datagrams_are_counted_and_change_nothing() {
    let mut site = Site::new("");
    let running = site.start();
    let mut sensors = [Sensor::new(site.group, 48, 1)];
    let mut heard = Heard::default();
    let all = |heard: &Heard| heard.tracks.len() == TARGETS as usize;
    let mut sent = scan_until("all targets", &mut site, &mut sensors, &mut heard, all);

    let stranger = UdpSocket::bind((IpAddr::from(STRANGER), 0)).unwrap();
    for _ in 0..500 {
        stranger.send_to(&[48, 0, 4, 0], site.group).unwrap();
    }
    let neighbour = UdpSocket::bind((LOOPBACK, 0)).unwrap();
    let junk = vec![0xFF; 60_000];
    let bad: [&[u8]; 7] = [
        &[],                                  // empty
        &junk,                                // as long as can be
        &[48],                                // no header
        &[48, 0, 2],                          // a length that is less than the header
        &[48, 0, 200, 0xFF],                  // a length beyond the datagram
        &[250, 0, 7, 0x80, 1, 1, 0],          // a category that nobody has, from the radar
        &[48, 0, 7, 0b1000_0000, 7, 7, 0x40], // a sensor that no source has
    ];
    for datagram in bad {
        neighbour.send_to(datagram, site.group).unwrap();
    }
    heard.tracks.clear();
    sent += scan_until("all targets again", &mut site, &mut sensors, &mut heard, all);
    assert_in_place(&heard);
    // What was sent before the last scan that has come out has been read.
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    let report = site.report();
    let network = report["network"].as_array().unwrap();
    let lan = network.iter().find(|entry| entry["process"] == "adapter lan").unwrap();
    let count = |label: &str| counter(&lan["counters"], label);
    assert_eq!(count("datagrams_rejected"), 500);
    assert_eq!(count("datagrams_rejected_length"), 1, "the empty one");
    assert_eq!(count("datagrams_dropped"), 0);
    assert_eq!(count("blocks_rejected"), 4, "{lan}");
    assert_eq!(count("rejected_source"), 1);
    let radar = &report["sources"][0];
    assert_eq!(radar["name"], "radar");
    let of_radar = |part: &str, label: &str| counter(&radar[part], label);
    assert_eq!(
        of_radar("adapter", "blocks_rejected"),
        1,
        "of the category that nobody has"
    );
    assert!(of_radar("adapter", "published") <= sent);
    assert!(
        of_radar("adapter", "published") + u64::from(TARGETS) >= sent,
        "{} of {sent} published",
        of_radar("adapter", "published")
    );
    site.home.assert_nothing_is_left("test");
}

/// Ten and a hundred times what the machine can take are sent, as fast as the sender can: what is lost is counted where
/// it is lost, and afterwards everything goes on as before.
#[test]
fn an_overload_is_counted_at_every_stage() {
    let mut site = Site::new("");
    let running = site.start();
    let mut sensors = [Sensor::new(site.group, 48, 1)];
    let mut heard = Heard::default();
    let all = |heard: &Heard| heard.tracks.len() == TARGETS as usize;
    scan_until("all targets", &mut site, &mut sensors, &mut heard, all);
    for scans in [1_000, 10_000] {
        for _ in 0..scans {
            sensors[0].scan();
        }
        heard = Heard::default();
        // States of the overload itself may still be on their way.
        let over_s = frames::time::seconds(utc_ns() % frames::time::NS_PER_DAY);
        let is_later = |track: &NamedRecord| {
            let time_s = track.get(&["070"]).and_then(Value::as_f64).unwrap();
            (time_s - over_s).rem_euclid(86_400.0) < 43_200.0
        };
        scan_until(
            "all targets after the overload",
            &mut site,
            &mut sensors,
            &mut heard,
            |heard| all(heard) && heard.tracks.values().all(is_later),
        );
    }
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    let report = site.report();
    let of = |list: &str, process: &str, label: &str| {
        let entries = report[list].as_array().unwrap();
        let entry = entries.iter().find(|entry| entry["process"] == process).unwrap();
        counter(&entry["counters"], label)
    };
    // What was sent since the last look at the gateway may be on its way when the deployment ends.
    let nearly = |what: &str, sent: u64, counted: u64, on_the_way: u64| {
        assert!(
            counted <= sent && sent <= counted + on_the_way,
            "{what}: {sent} sent, {counted} counted"
        );
    };
    let datagrams = of("network", "adapter lan", "datagrams");
    let dropped = of("network", "adapter lan", "datagrams_dropped");
    nearly("datagrams", sensors[0].sender.counters().sent, datagrams + dropped, 1);
    let radar = &report["sources"][0];
    let of_radar = |part: &str, label: &str| counter(&radar[part], label);
    assert_eq!(of_radar("adapter", "records"), datagrams * u64::from(TARGETS));
    let mut on_the_way = 0;
    for hop in report["losses"]["hops"].as_array().unwrap() {
        let number = |key: &str| hop[key].as_u64().unwrap();
        let counted = number("taken") + number("lost");
        nearly(&hop.to_string(), number("published"), counted, u64::from(TARGETS));
        on_the_way += number("unread");
    }
    let fused = report["fusion"]["published"].as_u64().unwrap();
    let sent_on = of("others", "gateway out", "taken") + of("others", "gateway out", "lost");
    nearly("states", fused, sent_on, on_the_way + 10 * u64::from(TARGETS));
    site.home.assert_nothing_is_left("test");
}

/// Damaged datagrams of every category are each in one counter, and the targets of the other sensor keep their numbers.
fn mutated_datagrams_are_counted(count: u64) {
    let mut site = Site::new("");
    let running = site.start();
    let mut honest = [Sensor::new(site.group, 20, 2)];
    let mut heard = Heard::default();
    let all = |heard: &Heard| {
        let mut addresses = (0..TARGETS).map(|number| u64::from(0x40_0000 + number));
        addresses.all(|address| heard.tracks.contains_key(&address))
    };
    let mut scans = scan_until("all targets", &mut site, &mut honest, &mut heard, all) / u64::from(TARGETS);
    let numbers = track_numbers(&heard);

    let blocks = sound_blocks();
    let others: Vec<&[u8]> = blocks.iter().map(Vec::as_slice).collect();
    let mut radar = Sensor::new(site.group, 48, 1);
    let mut dice = Dice::new(17);
    let senders = [LOOPBACK, IpAddr::from(STRANGER)].map(|from| UdpSocket::bind((from, 0)).unwrap());
    for number in 0..count {
        let datagram = match dice.below(8) {
            // A report of a target that exists.
            0 => {
                let mut sound = Vec::new();
                let mut keep = |bytes: &[u8]| sound.extend_from_slice(bytes);
                radar
                    .reports
                    .report(&track(number as u32 % TARGETS, utc_ns()), &mut keep);
                radar.reports.flush(&mut keep);
                mutated(&sound, &others, &mut dice)
            }
            1 => (0..dice.below(200)).map(|_| dice.bits() as u8).collect(),
            // Several blocks in one datagram.
            2 => (0..3)
                .flat_map(|_| mutated(dice.one_of(&others), &others, &mut dice))
                .collect(),
            _ => mutated(dice.one_of(&others), &others, &mut dice),
        };
        let sender = &senders[usize::from(number.is_multiple_of(16))];
        sender.send_to(&datagram, site.group).unwrap();
        if number.is_multiple_of(500) {
            honest[0].scan();
            scans += 1;
            heard.hear(&mut site.gateway, Duration::from_millis(1));
        }
    }
    heard.tracks.clear();
    scans += scan_until("all targets again", &mut site, &mut honest, &mut heard, all) / u64::from(TARGETS);
    assert_eq!(track_numbers(&heard), numbers, "numbers of targets before and after");
    for name in ["fusion", "lan", "box", "out", "monitor", "keeper"] {
        let row = site.home.status_row(name);
        assert_eq!((row.state.as_str(), row.restarts.as_str()), ("running", "0"), "{name}");
    }
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    let report = site.report();
    let network = report["network"].as_array().unwrap();
    let lan = network.iter().find(|entry| entry["process"] == "adapter lan").unwrap();
    let labels = [
        "datagrams",
        "datagrams_rejected",
        "datagrams_rejected_length",
        "datagrams_dropped",
    ];
    let counted: u64 = labels.iter().map(|label| counter(&lan["counters"], label)).sum();
    let records = report["sources"][0]["adapter"]["records"].as_u64().unwrap();
    println!("{count} mutated datagrams, {scans} scans, {records} records read in the name of the radar");
    assert!(records > count / 20, "damage reaches what a source reads: {records}");
    // The last scan may not have been read.
    assert!(
        (count + scans - 1..=count + scans).contains(&counted),
        "{counted} of {count} + {scans}: {lan}"
    );
    assert!(!said.contains("restarting"), "{said}");
    site.home.assert_nothing_is_left("test");
}

/// Number of the system track of each address of the test's targets.
fn track_numbers(heard: &Heard) -> BTreeMap<u64, u64> {
    let targets = heard.tracks.range(0x40_0000..u64::from(0x40_0000 + TARGETS));
    let numbers = targets.map(|(address, track)| (*address, track.get(&["040"]).and_then(Value::as_u64).unwrap()));
    numbers.collect()
}

/// Sound blocks of every category and edition: as they are, and in the name of the radar.
fn sound_blocks() -> Vec<Vec<u8>> {
    let mut blocks = Vec::new();
    for line in include_str!("golden/records.txt").lines().skip(1) {
        let bytes = line.rsplit(' ').next().unwrap();
        let byte = |at| u8::from_str_radix(&bytes[at..at + 2], 16).unwrap();
        let block: Vec<u8> = (0..bytes.len()).step_by(2).map(byte).collect();
        let fspec = &block[HEADER_BYTES..];
        if fspec[0] & 0x80 != 0 {
            let of_radar = HEADER_BYTES + fspec.iter().position(|byte| byte & 1 == 0).unwrap() + 1;
            let mut named = block.clone();
            named[of_radar..of_radar + 2].copy_from_slice(&[1, 1]);
            blocks.push(named);
        }
        blocks.push(block);
    }
    blocks
}

#[test]
fn mutated_datagrams_are_all_counted() {
    mutated_datagrams_are_counted(20_000);
}

/// As many as `KOSEKI_DATAGRAMS` says.
#[test]
#[ignore = "takes a minute: the same with 300,000"]
fn many_mutated_datagrams_are_all_counted() {
    let count = std::env::var("KOSEKI_DATAGRAMS")
        .ok()
        .and_then(|count| count.parse().ok());
    mutated_datagrams_are_counted(count.unwrap_or(300_000));
}

#[test]
fn killed_adapters_and_gateways_come_back() {
    let mut site = Site::new("block_bytes = 300");
    let running = site.start();
    let mut sensors = [Sensor::new(site.group, 48, 1), Sensor::new(site.group, 20, 2)];
    let mut heard = Heard::default();
    let all = |heard: &Heard| heard.tracks.len() == TARGETS as usize;
    scan_until("all targets", &mut site, &mut sensors, &mut heard, all);
    for name in ["lan", "out"] {
        let pid = site.home.status_row(name).pid;
        kill(pid, Signal::KILL);
        running.until_said(&format!("{name} restarted (1)"));
        heard = Heard::default();
        scan_until("all targets after a kill", &mut site, &mut sensors, &mut heard, all);
    }
    assert_in_place(&heard);
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    site.home.assert_nothing_is_left("test");
}

//! Alarms as a user meets them: real senders, real processes, and what the commands say.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::time::Instant;

use asterix::{Decoder, Edition, Mode, NamedRecord, Value, registry};
use frames::SensorFrame;
use messages::{Covariance, Identity, SensorTrack, TrackState, sensor_track_bits as bits};
use net::{ReceiverSettings, UdpReceiver};
use outgoing::SensorReports;
use rustix::process::Signal;

use crate::common::home::PATIENCE;
use crate::common::{Home, PLACE, Running, S, free_address, kill, repository, system, until, utc_ns};

/// Alarms that a machine under load raises rightly, whatever runs on it.
const OF_THE_MACHINE: [&str; 6] = [
    "samples-lost",
    "datagrams-dropped",
    "process-hung",
    "source-silent",
    "disk-low",
    "memory-low",
];

/// A radar and a transponder receiver behind one socket, and a gateway to the test.
struct Site {
    home: Home,
    to: SocketAddr,
    socket: UdpSocket,
    gateway: UdpReceiver,
}

impl Site {
    fn new(receiver: &str) -> Self {
        let (home, to) = (Home::new(), free_address());
        let gateway = UdpReceiver::open(&ReceiverSettings::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 0)).unwrap();
        let [latitude, longitude] = PLACE;
        let text = format!(
            "name = \"test\"\n[frame]\nlatitude_deg = {latitude}\nlongitude_deg = {longitude}\n\
             [[receiver]]\nname = \"lan\"\n[receiver.udp]\nlisten = \"{to}\"\n{receiver}\
             [[source]]\nname = \"radar\"\nperiod_s = 0.2\n[source.live]\nreceiver = \"lan\"\nsac = 1\nsic = 1\n\
             [[source]]\nname = \"ads-b\"\nsilent_periods = 0\n[source.live]\nreceiver = \"lan\"\nsac = 1\nsic = 2\n\
             [[gateway]]\nname = \"out\"\nsend_to = \"{}\"\nsac = 9\nsic = 8\nstatus_s = 0.1\n",
            gateway.local_address()
        );
        std::fs::write(home.path("site.toml"), text).unwrap();
        Self {
            home,
            to,
            socket: UdpSocket::bind("127.0.0.1:0").unwrap(),
            gateway,
        }
    }

    fn start(&self) -> Running {
        let running = self
            .home
            .start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
        running.until_said("instance test runs");
        running
    }

    /// Does something again and again until the deployment has said these words.
    fn until_said(&mut self, running: &Running, words: &str, mut act: impl FnMut(&mut Self)) {
        let begun = Instant::now();
        while !running.said().contains(words) {
            assert!(begun.elapsed() < PATIENCE, "not said: {words}\n{}", running.said());
            act(self);
            std::thread::sleep(std::time::Duration::from_millis(50));
        }
    }

    /// Condition and silence of the radar, as the gateway's next status reports have them.
    fn radar_status(&mut self) -> Option<(u64, u64)> {
        let (mut decoder, mut found) = (Decoder::new(Mode::Strict), None);
        let patience = std::time::Duration::from_millis(200);
        let received = self.gateway.receive(patience, |datagram| {
            for record in decoder.records(datagram.bytes).flatten() {
                let record = NamedRecord::new(&record);
                let number = |path: &[&str]| record.get(path).and_then(Value::as_u64);
                if record.category == 63 && number(&["050", "SIC"]) == Some(1) {
                    found = number(&["060", "CON"]).zip(number(&["060", "NPW"]).or(Some(0)));
                }
            }
        });
        received.unwrap();
        found
    }
}

/// One report of a sensor, in a block.
fn block(category: u8, edition: Option<Edition>, sic: u8) -> Vec<u8> {
    block_of(category, edition, sic, utc_ns())
}

/// One report that says that it was measured at `time_ns`.
fn block_of(category: u8, edition: Option<Edition>, sic: u8, time_ns: i64) -> Vec<u8> {
    let table = match edition {
        Some(edition) => registry::find(category, edition),
        None => registry::default_edition(category),
    };
    let (place, system) = system();
    let frame = SensorFrame::new(&system, place, 0.0);
    let mut reports = SensorReports::new(table.unwrap(), 1, sic, frame, system, 1472).unwrap();
    let track = SensorTrack {
        time_of_measurement_ns: time_ns,
        track_number: 1,
        valid: bits::VELOCITY | bits::HEIGHT,
        identity: Identity::default().with_address(0x40_0000),
        position_m: [8_000.0, -12_000.0, 3_000.0],
        covariance: Covariance::diagonal([20.0; 3], [2.0; 3]),
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    };
    let mut bytes = Vec::new();
    let mut keep = |block: &[u8]| bytes.extend_from_slice(block);
    reports.report(&track, &mut keep);
    reports.flush(&mut keep);
    bytes
}

#[test]
fn a_source_that_falls_silent_is_told_until_it_speaks_again() {
    let mut site = Site::new("");
    let running = site.start();
    let scan = |site: &mut Site| drop(site.socket.send_to(&block(48, None, 1), site.to));
    let speaks = |site: &mut Site| {
        scan(site);
        site.radar_status() == Some((0, 0))
    };
    let begun = Instant::now();
    while !speaks(&mut site) {
        assert!(
            begun.elapsed() < PATIENCE,
            "the gateway never said that the radar works"
        );
    }
    site.until_said(&running, "alarm, major: radar has sent nothing for ", |_| {});
    let status = site.home.status();
    assert!(
        status.contains("  alarm, major: radar has sent nothing for "),
        "{status}"
    );
    assert!(status.contains("    Check that the sensor transmits"), "{status}");
    let top = site.home.run(&["top", "--once", "--instance", "test"]);
    let top = String::from_utf8(top.stdout).unwrap();
    assert!(top.contains("source-silent  radar has sent nothing for "), "{top}");
    // A monitor that comes after another finds out anew what stands.
    kill(site.home.status_row("monitor").pid, Signal::KILL);
    running.until_said("alarm, major: monitor was restarted, 1 time so far: ");
    until("the alarm stands again", || {
        site.home
            .status()
            .contains("  alarm, major: radar has sent nothing for ")
    });
    let begun = Instant::now();
    while site.radar_status() != Some((1, 1)) {
        assert!(
            begun.elapsed() < PATIENCE,
            "the gateway never said that the radar is silent"
        );
    }
    site.until_said(&running, "alarm cleared: radar has sent nothing for ", scan);
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    let rows = std::fs::read_to_string(site.home.path("out/latest/alarms.csv")).unwrap();
    let events: Vec<&str> = rows.lines().skip(1).map(|row| row.split(',').nth(2).unwrap()).collect();
    assert!(events.starts_with(&["raised"]) && events.contains(&"cleared"), "{rows}");
    site.home.assert_nothing_is_left("test");
}

#[test]
fn what_is_not_configured_is_named() {
    let mut site = Site::new("");
    let running = site.start();
    let stranger = block(48, None, 9);
    let words = "adapter lan receives data from senders without a configured source: SAC/SIC 1/9, ";
    site.until_said(&running, words, |site| drop(site.socket.send_to(&stranger, site.to)));
    let old = block(21, Some(Edition::new(0, 23)), 2);
    let words = "of ads-b do not fit the configured edition, but fit category 021 edition 0.23.";
    site.until_said(&running, words, |site| drop(site.socket.send_to(&old, site.to)));
    let (_, said) = running.stop();
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(site.home.path("out/latest/report.json")).unwrap()).unwrap();
    let alarms: Vec<_> = report["alarms"]
        .as_array()
        .unwrap()
        .iter()
        .map(|alarm| alarm["alarm"].clone())
        .collect();
    assert!(
        ["sender-unknown", "edition-wrong"]
            .iter()
            .all(|alarm| alarms.contains(&(*alarm).into())),
        "{said}"
    );
    let verdict = report["verdict"]["sentence"].as_str().unwrap();
    assert!(verdict.contains("SAC/SIC 1/9"), "{verdict}");
}

#[test]
fn a_flood_and_a_killed_process_are_told() {
    let mut site = Site::new("buffer_bytes = 4096\n");
    let running = site.start();
    let flood = |site: &mut Site| {
        for _ in 0..5_000 {
            let _ = site.socket.send_to(&[48, 0, 4, 0], site.to);
        }
    };
    site.until_said(&running, "alarm, major: The kernel dropped ", flood);
    kill(site.home.status_row("out").pid, Signal::KILL);
    running.until_said("alarm, major: out was restarted, 1 time so far: the last process was killed by SIGKILL.");
    site.until_said(&running, "alarm cleared: The kernel dropped ", |_| {});
    running.stop();
}

#[test]
fn a_clock_that_is_off_is_told_and_a_wild_one_isolates_its_source() {
    let mut site = Site::new("");
    let running = site.start();
    let ahead = |seconds: i64| {
        move |site: &mut Site| {
            let late = block_of(48, None, 1, utc_ns() + seconds * S);
            let _ = site.socket.send_to(&late, site.to);
        }
    };
    site.until_said(&running, "alarm, major: The clock of radar is +", ahead(3));
    site.until_said(&running, "alarm, major: radar is isolated: ", ahead(30));
    running.stop();
}

/// The report of a run has no alarm but those of the machine.
pub(crate) fn assert_no_alarm(home: &Home) {
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(home.path("out/latest/report.json")).unwrap()).unwrap();
    let alarms = report["alarms"].as_array().unwrap();
    let is_of_machine = |alarm: &serde_json::Value| OF_THE_MACHINE.contains(&alarm["alarm"].as_str().unwrap());
    assert!(alarms.iter().all(is_of_machine), "{alarms:#?}");
}

/// The demonstration and two examples, side by side: they mostly wait. `live_on_board` runs the third for longer.
#[test]
fn the_demonstration_and_the_examples_raise_no_alarm() {
    let examples = ["config/coast.toml", "config/wide-area.toml"].map(repository);
    let [coast, wide_area] = examples.each_ref().map(|path| path.to_str().unwrap());
    let runs = [
        ["demo", "--for", "15"].to_vec(),
        ["up", coast, "--for", "8"].to_vec(),
        ["up", wide_area, "--for", "8"].to_vec(),
    ];
    std::thread::scope(|scope| {
        for run in runs {
            scope.spawn(move || {
                let home = Home::new();
                let options = ["--instance", "test", "--out", "out", "--set", "monitor.files=true"];
                let output = home.run(&[run, options.to_vec()].concat());
                assert_eq!(output.status.code(), Some(0), "{output:?}");
                assert_no_alarm(&home);
            });
        }
    });
}

//! A radar that sends plots, live: its adapter makes tracks of them, and the recorded detections give the same tracks
//! again.

use std::fs;
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

use asterix::registry;
use frames::SensorFrame;
use messages::Identity;
use outgoing::SensorReports;
use rustix::process::Signal;
use test_support::Random;

use crate::common::counted_pair::rows;
use crate::common::{Folder, Home, PLACE, Running, free_address, kill, system, until, utc_ns};

/// Time between two scans: so short that a test of many scans is short, too.
const PERIOD: Duration = Duration::from_millis(200);
const TARGETS: usize = 4;
const SPEED_MPS: f64 = 100.0;
const CODES: [u16; TARGETS] = [0o4213, 0o4214, 0o7000, 0o7000];
const TRACKER: &str = "detection_probability = 0.8\n[TABLE.motion]\nprocess_noise_m2ps3 = [20.0, 5.0]\n\
                       [TABLE.confirmation]\ndetections_min = 3\n[TABLE.initiation]\nspeed_sigma_mps = 150.0\n";

struct Site {
    home: Home,
    radar: Radar,
}

/// Sends plots to the deployment.
struct Radar {
    reports: SensorReports,
    socket: UdpSocket,
    to: SocketAddr,
    /// Begin of the first turn: the targets' way depends on time, not on how soon a turn follows the one before.
    first_ns: Option<i64>,
    random: Random,
    /// Whether the targets reply with their identities.
    replies: bool,
}

impl Site {
    fn new() -> Self {
        let home = Home::new();
        let to = free_address();
        let text = format!(
            "name = \"test\"\n[frame]\nlatitude_deg = {}\nlongitude_deg = {}\n[[receiver]]\nname = \"lan\"\n\
             [receiver.udp]\nlisten = \"{to}\"\n[[source]]\nname = \"radar\"\nperiod_s = 0.2\nfresh_s = 5.0\n\
             [source.live]\nreceiver = \"lan\"\n[source.covariance]\nrange_sigma_m = 50.0\nazimuth_sigma_deg = 0.05\n\
             [source.tracker]\nscans = \"turn\"\n{}[fusion.life]\nterminate_s = 10.0\n",
            PLACE[0],
            PLACE[1],
            TRACKER.replace("TABLE", "source.tracker")
        );
        fs::write(home.path("site.toml"), text).unwrap();
        Self {
            home,
            radar: Radar::new(to),
        }
    }

    fn start(&self) -> Running {
        let running = self
            .home
            .start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
        running.until_said("instance test runs");
        until("the adapter listens", || self.home.status_row("lan").state == "running");
        running
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.home.path(name)).unwrap_or_default()
    }

    /// Tracks that `koseki track` makes of detections: their rows without sensor and what only the tracker knows.
    fn tracked(&self, name: &str, detections: &[&str], config: &str) -> Vec<String> {
        let header = self
            .read("out/latest/detections_radar.csv")
            .lines()
            .next()
            .unwrap()
            .to_owned();
        fs::write(self.home.path(name), format!("{header}\n{}\n", detections.join("\n"))).unwrap();
        let arguments = ["track", "--detections", name, "--config", config, "--out", "again.csv"];
        let output = self.home.run(&arguments);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        rows(&self.read("again.csv"))
    }
}

impl Radar {
    fn new(to: SocketAddr) -> Self {
        let (place, system) = system();
        let table = registry::default_edition(48).unwrap();
        let frame = SensorFrame::new(&system, place, 0.0);
        Self {
            reports: SensorReports::new(table, 1, 1, frame, system, 1400).unwrap(),
            socket: UdpSocket::bind("127.0.0.1:0").unwrap(),
            to,
            first_ns: None,
            random: Random::new(1),
            replies: false,
        }
    }

    /// Address, code and callsign of a target; one in a hundred addresses is garbled.
    fn identity(&mut self, target: usize) -> Identity {
        if !self.replies {
            return Identity::default();
        }
        let garbled = self.random.unit() < 0.01;
        let address = 0x4c_a700 + target as u32 + if garbled { 0x1111 } else { 0 };
        let callsign = [b'K', b'O', b'S', b'1', b'0' + target as u8, b' ', b' ', b' '];
        Identity::default()
            .with_address(address)
            .with_mode_3a(CODES[target])
            .with_callsign(callsign)
    }

    /// Sends the plots of a turn that begins now, and waits for its end.
    fn turn(&mut self) {
        let (socket, to) = (self.socket.try_clone().unwrap(), self.to);
        self.plots(utc_ns(), &mut |block| drop(socket.send_to(block, to)));
        std::thread::sleep(PERIOD);
    }

    /// The plots of a turn: targets, each seen nine times out of ten, and false ones.
    fn plots(&mut self, begin_ns: i64, send: &mut dyn FnMut(&[u8])) {
        let mut plots = Vec::new();
        let since_s = (begin_ns - *self.first_ns.get_or_insert(begin_ns)) as f64 * 1e-9;
        for target in 0..TARGETS {
            let [off_east, off_north, seen] = [self.random.unit(), self.random.unit(), self.random.unit()];
            let east = 10_000.0 + 6000.0 * target as f64 + 60.0 * (off_east - 0.5);
            let north = 15_000.0 + SPEED_MPS * since_s + 60.0 * (off_north - 0.5);
            if seen < 0.9 {
                let identity = self.identity(target);
                plots.push(([east, north, 3000.0], target % 2 == 0, identity));
            }
        }
        for _ in 0..5 {
            let place = [
                80e3 * (self.random.unit() - 0.5),
                80e3 * (self.random.unit() - 0.5),
                5000.0,
            ];
            plots.push((place, false, Identity::default()));
        }
        self.reports.status(begin_ns, send);
        for (number, (place, height, identity)) in (1..).zip(plots) {
            // Several of one time, as azimuths allow.
            let time_ns = begin_ns + 8_000_000 * (number / 2);
            self.reports.replied_plot(time_ns, place, height, &identity, send);
        }
        self.reports.flush(send);
    }

    /// Turns until something holds.
    fn turn_until(&mut self, what: &str, mut holds: impl FnMut() -> bool) {
        for _ in 0..300 {
            if holds() {
                return;
            }
            self.turn();
        }
        panic!("never happened: {what}");
    }
}

#[test]
fn plots_become_tracks_and_their_recording_gives_the_same_again() {
    let mut site = Site::new();
    let running = site.start();
    let recorded = site.home.path("out/latest/sensor_tracks_radar.csv");
    let lines = || fs::read_to_string(&recorded).unwrap_or_default().lines().count();
    for _ in 0..40 {
        site.radar.turn();
    }
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    let (tracks, detections) = (
        site.read("out/latest/sensor_tracks_radar.csv"),
        site.read("out/latest/detections_radar.csv"),
    );
    let (published, detections): (Vec<String>, Vec<&str>) = (rows(&tracks), detections.lines().skip(1).collect());
    assert!(
        detections.len() > 200 && lines() > 60,
        "{} detections, {} rows",
        detections.len(),
        lines()
    );
    // The deployment itself, and its tables alone, say how.
    let tables = TRACKER.replace("TABLE.", "");
    let tables = tables.replacen("detection_probability", "[[sensor]]\nid = 1\ndetection_probability", 1);
    fs::write(site.home.path("tables.toml"), tables).unwrap();
    for config in ["site.toml", "tables.toml"] {
        let again = site.tracked("all.csv", &detections, config);
        assert_eq!(again.len(), published.len(), "{config}");
        let differs = again
            .iter()
            .zip(&published)
            .find(|(again, published)| again != published);
        assert!(differs.is_none(), "{config}: {differs:?}");
    }
    let confirmed = published.iter().map(|row| row.split(',').nth(1).unwrap().to_owned());
    let numbers: std::collections::BTreeSet<String> = confirmed.collect();
    assert!((TARGETS..TARGETS + 3).contains(&numbers.len()), "{numbers:?}");
    let report = site.read("out/latest/report.json");
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert!(report.to_string().contains("\"detections\""), "{report}");
    site.home.assert_nothing_is_left("test");
}

/// The replies of the targets reach the published sensor tracks and fusion, and `koseki track` gives the same again.
#[test]
fn tracks_of_plots_have_address_code_callsign_and_level() {
    let mut site = Site::new();
    site.radar.replies = true;
    let running = site.start();
    for _ in 0..40 {
        site.radar.turn();
    }
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    let tracks = site.read("out/latest/sensor_tracks_radar.csv");
    let values = |text: &str, names: [&str; 3]| -> Vec<[String; 3]> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let header = reader.headers().unwrap().clone();
        let place = |name: &str| header.iter().position(|of| of == name).unwrap();
        let places = names.map(place);
        let rows = reader.records().map(Result::unwrap);
        rows.map(|row| places.map(|place| row[place].to_owned())).collect()
    };
    let known: Vec<[String; 3]> = (0..TARGETS)
        .map(|target| {
            let address = format!("{:06X}", 0x4c_a700 + target);
            [address, format!("{:04o}", CODES[target]), format!("KOS1{target}")]
        })
        .collect();
    let found = values(&tracks, ["address", "mode_3a", "callsign"]);
    for known in &known {
        let rows = found.iter().filter(|row| *row == known).count();
        assert!(rows > 15, "{known:?}: {rows} of {}", found.len());
    }
    let strange: Vec<_> = found
        .iter()
        .filter(|row| !row[0].is_empty() && !known.contains(row))
        .collect();
    assert!(strange.is_empty(), "{strange:?}");
    // Every second target replies with its height, FL098 at 3000 m; the system tracks have it as level.
    let system = site.read("out/latest/system_tracks.csv");
    for [address, level, age_s] in values(&system, ["address", "level", "level_age_s"]) {
        let Some(target) = known.iter().position(|known| known[0] == address) else {
            continue;
        };
        assert_eq!(level.is_empty(), target % 2 == 1, "{address} {level}");
        if !level.is_empty() {
            let (level, age_s): (f64, f64) = (level.parse().unwrap(), age_s.parse().unwrap());
            assert!(
                (97.0..102.0).contains(&level) && age_s < 3.0,
                "{address} {level} {age_s}"
            );
        }
    }
    let detections = site.read("out/latest/detections_radar.csv");
    let detections: Vec<&str> = detections.lines().skip(1).collect();
    assert!(site.tracked("all.csv", &detections, "site.toml") == rows(&tracks));
    let again = values(&site.read("again.csv"), ["address", "level", "level_age_s"]);
    let levels = again.iter().filter(|[_, level, _]| !level.is_empty()).count();
    assert!(levels > 30 && levels < again.len(), "{levels} of {}", again.len());
    site.home.assert_nothing_is_left("test");
}

/// Numbers of the tracks at each target, in the order of rows of sensor tracks.
fn numbers(rows: &[String]) -> [Vec<u32>; TARGETS] {
    std::array::from_fn(|target| {
        let place = 10_000.0 + 6000.0 * target as f64;
        let number = |row: &String| {
            let values: Vec<&str> = row.split(',').collect();
            let east: f64 = values[2].parse().unwrap();
            (f64::abs(east - place) < 500.0).then(|| values[1].parse().unwrap())
        };
        rows.iter().filter_map(number).collect()
    })
}

#[test]
fn an_adapter_that_is_killed_goes_on_with_the_same_tracks_under_the_same_numbers() {
    let mut site = Site::new();
    let running = site.start();
    let (mut known, mut begun) = (Vec::new(), 0);
    for _ in 0..2 {
        for _ in 0..20 {
            site.radar.turn();
        }
        let recorded = rows(&site.read("out/latest/sensor_tracks_radar.csv"));
        let now = numbers(&recorded[begun..]);
        if known.is_empty() {
            known = now.iter().map(|numbers| *numbers.last().unwrap()).collect();
        }
        begun = recorded.len();
        let before = site.home.status_row("lan");
        kill(before.pid, Signal::KILL);
        let home = &site.home;
        site.radar.turn_until("it is restarted", || {
            let row = home.status_row("lan");
            row.pid != before.pid && row.state == "running"
        });
    }
    for _ in 0..20 {
        site.radar.turn();
    }
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    assert!(!said.contains("not used"), "{said}");
    let recorded = rows(&site.read("out/latest/sensor_tracks_radar.csv"));
    for (numbers, known) in numbers(&recorded[begun..]).iter().zip(&known) {
        assert!(numbers.len() > 15, "{numbers:?}");
        assert!(numbers.iter().all(|number| number == known), "{known}: {numbers:?}");
    }
    site.home.assert_nothing_is_left("test");
}

#[test]
fn a_recording_of_plots_is_tracked_at_any_speed() {
    let (mut site, mut recording) = (Site::new(), Vec::new());
    for scan in 0..60 {
        site.radar.plots(1_000_000_000 * (43_200 + 4 * scan), &mut |block| {
            recording.extend_from_slice(block)
        });
    }
    fs::write(site.home.path("plots.ast"), recording).unwrap();
    let text = site.read("site.toml");
    let recorded = "[source.recorded]\nfile = \"plots.ast\"\n";
    let text = text.replacen("[source.live]\nreceiver = \"lan\"\n", recorded, 1);
    let begin = text.find("[[receiver]]").unwrap();
    let text = text.replacen(&text[begin..text.find("[[source]]").unwrap()], "", 1);
    let time = "[time]\norder = \"time\"\ndate = \"2026-05-10\"\n";
    let text = text.replacen("period_s = 0.2", "period_s = 4.0", 1) + time;
    fs::write(site.home.path("site.toml"), text).unwrap();
    let mut earlier: Option<(String, String)> = None;
    for (speed, out) in [("max", "out"), ("200", "slow")] {
        let up = [
            "up",
            "site.toml",
            "--data",
            ".",
            "--speed",
            speed,
            "--instance",
            "test",
            "--out",
            out,
        ];
        let output = site.home.run(&up);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let files =
            ["sensor_tracks_radar.csv", "detections_radar.csv"].map(|name| site.read(&format!("{out}/latest/{name}")));
        let [tracks, detections] = files;
        assert!(
            tracks.lines().count() > 150 && detections.lines().count() > 400,
            "{}",
            tracks.lines().count()
        );
        assert!(
            earlier.is_none_or(|earlier| earlier == (tracks.clone(), detections.clone())),
            "{speed}"
        );
        earlier = Some((tracks, detections));
    }
    let (tracks, detections) = earlier.unwrap();
    let detections: Vec<&str> = detections.lines().skip(1).collect();
    assert!(site.tracked("all.csv", &detections, "site.toml") == rows(&tracks));
    site.home.assert_nothing_is_left("test");
}

/// What is said of a tracker that cannot be.
#[test]
fn a_source_with_tracks_needs_no_tracker() {
    let folder = Folder::new();
    let demo = configuration::DEMO;
    for (old, new, expected) in [
        ("plots = true\n", "", "false_plots_per_period"),
        ("plots = true\nfalse_plots_per_period = 30.0\n", "", "plots = true"),
        (
            "detection_probability = 0.95",
            "detection_probability = 1.95",
            "between 0.01 and 0.9999",
        ),
        (
            "detection_probability = 0.95",
            "[source.tracker.gate]\nprobability = 9.0",
            "source[4].tracker.gate.probability: 9",
        ),
        (
            "detection_probability = 0.95",
            "scans = \"sector\"",
            "\"sector\" is not known; there are: turn, period",
        ),
        (
            "detection_probability = 0.95",
            "wait_s = 5.0",
            "must lie between 0 and 4",
        ),
    ] {
        assert!(demo.contains(old), "{old}");
        folder.write("site.toml", demo.replacen(old, new, 1));
        let said = folder.refusal("check site.toml");
        assert!(said.contains(expected) && said.contains("site.toml:"), "{said}");
    }
}

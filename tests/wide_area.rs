//! Wide-area support in running deployments: counts come in over the network or from recordings and change what a tracker
//! believes, and what was recorded gives the same tracks again (WA).
//!
//! Nothing here waits for a time to pass except for the radar's turns: what has been sent is looked for in shared memory before the
//! radar goes on.

#[path = "common/home.rs"]
mod home;

use std::fs;
use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use bus::{Bus, SharedMemory, Subscriber};
use formats::asterix::registry;
use formats::outgoing::{SensorReports, SystemReports};
use frames::time::NS_PER_DAY;
use frames::{Geodetic, SensorFrame, SystemFrame};
use home::{Home, Running, kill, until};
use messages::{SystemTrack, TrackState, WideArea};
use runtime::clock::mono_ns;
use rustix::process::Signal;

/// Time between two turns of the radar, and how fast its targets fly.
const PERIOD: Duration = Duration::from_millis(200);
const SPEED_MPS: f64 = 100.0;
const PLACE: [f64; 2] = [41.297063, 2.078447];
const NS: f64 = 1e9;
const HEADER: &str = "time_s,arrival_s,x,y,z,vx,vy,vz,count\n";
const TRACKER: &str = "scans = \"turn\"\ndetection_probability = 0.9\nclutter_density = 1e-9\n[source.tracker.motion]\n\
                       process_noise_m2ps3 = [20.0, 5.0]\n";

struct Site {
    home: Home,
    radar: Radar,
    socket: UdpSocket,
    remote: SocketAddr,
}

/// Sees two targets side by side, mostly as one.
struct Radar {
    reports: SensorReports,
    turns: usize,
    period_s: f64,
}

fn utc_ns() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as i64
}

fn system() -> (Geodetic, SystemFrame) {
    let place = Geodetic::from_degrees(PLACE[0], PLACE[1], 0.0).unwrap();
    (place, SystemFrame::at(place))
}

/// Ports that were free a moment ago.
fn free_ports() -> [SocketAddr; 2] {
    let sockets = [(); 2].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
    sockets.map(|socket| socket.local_addr().unwrap())
}

impl Radar {
    fn new() -> Self {
        let (place, system) = system();
        let table = registry::default_edition(48).unwrap();
        let frame = SensorFrame::new(&system, place, 0.0);
        Self {
            reports: SensorReports::new(table, 1, 1, frame, system, 1400).unwrap(),
            turns: 0,
            period_s: PERIOD.as_secs_f64(),
        }
    }

    /// Middle of the two targets at the turn at hand, east and north.
    fn middle_m(&self) -> [f64; 2] {
        [-12e3 + SPEED_MPS * self.period_s * self.turns as f64, 15e3]
    }

    /// The plots of a turn that begins at `begin_ns`; both targets are in every fourth one.
    fn turn(&mut self, begin_ns: i64, send: &mut dyn FnMut(&[u8])) {
        let [east, north] = self.middle_m();
        let off = 15.0 * ((self.turns * 7) % 5) as f64 - 30.0;
        let places = match self.turns % 4 {
            3 => vec![[east + off, north + 100.0], [east - off, north - 100.0]],
            _ => vec![[east + off, north - off]],
        };
        self.reports.status(begin_ns, send);
        for (number, [east, north]) in places.into_iter().enumerate() {
            let time_ns = begin_ns + 8_000_000 * number as i64;
            self.reports.plot(time_ns, [east, north, 3000.0], true, send);
        }
        self.reports.flush(send);
        self.turns += 1;
    }
}

impl Site {
    /// A radar whose tracker listens to a wide-area sensor that is configured like this, behind receiver `link` or not.
    fn live(sensor: &str) -> Self {
        let [radar, remote] = free_ports();
        let receiver = |name: &str, listen: SocketAddr| {
            format!("[[receiver]]\nname = \"{name}\"\n[receiver.udp]\nlisten = \"{listen}\"\n")
        };
        let link = if sensor.contains("\"link\"") {
            receiver("link", remote)
        } else {
            String::new()
        };
        let source = "[source.live]\nreceiver = \"lan\"\n";
        let text = receiver("lan", radar) + &link + &deployment(sensor, source, "0.2");
        let site = Self {
            home: Home::new(),
            radar: Radar::new(),
            socket: UdpSocket::bind("127.0.0.1:0").unwrap(),
            remote,
        };
        fs::write(site.home.path("site.toml"), format!("name = \"test\"\n{text}")).unwrap();
        fs::write(site.home.path("radar.port"), radar.to_string()).unwrap();
        site
    }

    fn start(&self) -> Running {
        let running = self
            .home
            .start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
        running.until_said("instance test runs");
        until("the radar's adapter listens", || {
            self.home.status_row("lan").state == "running"
        });
        running
    }

    fn turn(&mut self) {
        let radar: SocketAddr = self.read("radar.port").parse().unwrap();
        let socket = &self.socket;
        self.radar
            .turn(utc_ns(), &mut |block| drop(socket.send_to(block, radar)));
        std::thread::sleep(PERIOD);
    }

    fn bus(&self) -> Bus<SharedMemory> {
        Bus::open(&self.home.root("test"), "watching").unwrap()
    }

    fn send(&self, datagram: &[u8]) {
        self.socket.send_to(datagram, self.remote).unwrap();
    }

    /// A row that was observed `delay_s` ago at the targets' middle.
    fn row(&self, delay_s: f64, count: u32) -> String {
        let day_s = |ns: i64| ns.rem_euclid(NS_PER_DAY) as f64 / NS;
        let now_ns = utc_ns();
        let observed_s = day_s(now_ns - (delay_s * NS) as i64);
        let [east, north] = self.radar.middle_m();
        let east = east - delay_s * SPEED_MPS;
        format!(
            "{observed_s},{},{east},{north},0,{SPEED_MPS},0,0,{count}\n",
            day_s(now_ns)
        )
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.home.path(name)).unwrap_or_default()
    }

    /// What `koseki track` makes of the recorded detections, with the recorded counts or without.
    fn tracked(&self, out: &str, with_counts: bool) -> Vec<String> {
        let (detections, counts) = (
            format!("{out}/detections_radar.csv"),
            format!("{out}/wide_area_remote.csv"),
        );
        let mut arguments = vec![
            "track",
            "--detections",
            &detections,
            "--config",
            "site.toml",
            "--out",
            "again.csv",
        ];
        if with_counts {
            arguments.extend(["--wide-area", &counts]);
        }
        let output = self.home.run(&arguments);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        rows(&self.read("again.csv"))
    }

    fn published(&self) -> Vec<String> {
        rows(&self.read("out/sensor_tracks_radar.csv"))
    }

    /// Sum of a counter over everything in the final report that has one.
    fn counted(&self, label: &str) -> u64 {
        fn sum(value: &serde_json::Value, label: &str) -> u64 {
            match value {
                serde_json::Value::Object(members) => {
                    let own = members.get(label).and_then(serde_json::Value::as_u64).unwrap_or(0);
                    own + members.values().map(|value| sum(value, label)).sum::<u64>()
                }
                serde_json::Value::Array(items) => items.iter().map(|item| sum(item, label)).sum(),
                _ => 0,
            }
        }
        let report: serde_json::Value = serde_json::from_str(&self.read("out/report.json")).unwrap();
        // What a process says of its socket is said twice.
        sum(&report["sources"], label) + sum(&report["network"], label)
    }
}

fn deployment(sensor: &str, source: &str, period_s: &str) -> String {
    let [latitude, longitude] = PLACE;
    format!(
        "[frame]\nlatitude_deg = {latitude}\nlongitude_deg = {longitude}\n[[wide_area_sensor]]\nname = \"remote\"\n{sensor}\
         [[source]]\nname = \"radar\"\nperiod_s = {period_s}\nfresh_s = 30.0\n{source}[source.covariance]\nrange_sigma_m = 50.0\n\
         azimuth_sigma_deg = 0.15\n[source.tracker]\nwide_area_sensors = [\"remote\"]\n{TRACKER}"
    )
}

/// The rows of a file of sensor tracks, without the sensor's id and what comes after the state.
fn rows(text: &str) -> Vec<String> {
    let header = text.lines().next().unwrap_or_default();
    let end = header
        .split(',')
        .position(|name| name == "velocity_valid")
        .unwrap_or_default();
    let row = |line: &str| {
        let values: Vec<&str> = line.split(',').collect();
        [&values[..1], &values[2..=end]].concat().join(",")
    };
    text.lines().skip(1).map(row).collect()
}

const ROWS: &str = "[wide_area_sensor.live]\nreceiver = \"link\"\n";

/// Takes what has been published until there are so many reports.
fn until_published(counts: &mut Subscriber<SharedMemory, WideArea>, seen: &mut Vec<WideArea>, wanted: usize) {
    until("reports are published", || {
        counts.take(64, |_, slice| seen.extend_from_slice(slice)).unwrap();
        seen.len() >= wanted
    });
}

#[test]
fn counts_change_the_tracks_and_the_recording_gives_them_again() {
    let mut site = Site::live(ROWS);
    let running = site.start();
    let bus = site.bus();
    let mut counts = bus
        .subscriber(&messages::wide_area("remote"), || mono_ns() as u64)
        .unwrap();
    let mut seen = Vec::new();
    // What cannot be used is counted, and takes nothing with it: a datagram that is no table, rows among good ones.
    site.send(b"\xff\xfe garbage");
    site.send(&[]);
    let bad = site.row(1.0, 10_000) + &site.row(-5.0, 2) + "1,2,3\n" + &site.row(1.0, 2).replace(",15000,", ",1e9,");
    for turn in 0..51 {
        if turn % 8 == 6 {
            let row = site.row(1.6, 2);
            let table = if turn == 6 {
                format!("{HEADER}{}{bad}{row}", site.row(9.0, 0))
            } else {
                format!("{HEADER}{row}")
            };
            site.send(table.as_bytes());
            let wanted = seen.len() + if turn == 6 { 2 } else { 1 };
            until_published(&mut counts, &mut seen, wanted);
        }
        site.turn();
    }
    drop((counts, bus));
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    assert_eq!(
        seen.iter().map(|report| report.targets).collect::<Vec<_>>(),
        [0, 2, 2, 2, 2, 2, 2]
    );
    for (label, expected) in [
        ("rejected_targets", 1),
        ("rejected_time", 1),
        ("rejected_position", 1),
        // A row, and a datagram's header.
        ("blocks_refused", 2),
        ("wide_area_reports", 7),
        ("wide_area_late", 0),
        ("wide_area_lost", 0),
        ("wide_area_refused", 0),
    ] {
        assert_eq!(
            site.counted(label),
            expected,
            "{label}: {}",
            site.read("out/report.json")
        );
    }
    assert!(site.counted("wide_area_used") >= 6);
    let recorded = site.read("out/wide_area_remote.csv");
    assert_eq!(recorded.lines().count(), 1 + seen.len(), "{recorded}");
    let published = site.published();
    assert!(published.len() > 40, "{}", published.len());
    assert!(site.tracked("out", true) == published, "the same tracks again");
    assert!(
        site.tracked("out", false) != published,
        "without the counts they are others"
    );
    site.home.assert_nothing_is_left("test");
}

#[test]
fn a_silent_sensor_changes_nothing_and_one_that_is_killed_comes_back() {
    let mut site = Site::live(ROWS);
    let running = site.start();
    for _ in 0..12 {
        site.turn();
    }
    let before = site.home.status_row("link");
    kill(before.pid, Signal::KILL);
    let tracks = || site.published().len();
    let at_kill = tracks();
    let mut back = false;
    for turn in 0..300 {
        site.turn();
        let row = site.home.status_row("link");
        back = row.pid != before.pid && row.state == "running";
        if back && turn >= 8 {
            break;
        }
    }
    assert!(back, "the adapter is restarted");
    let bus = site.bus();
    let mut counts = bus
        .subscriber(&messages::wide_area("remote"), || mono_ns() as u64)
        .unwrap();
    assert_eq!(
        site.read("out/wide_area_remote.csv").lines().count(),
        0,
        "nothing has been said so far"
    );
    let silent_until = utc_ns();
    site.send(format!("{HEADER}{}", site.row(1.0, 2)).as_bytes());
    until_published(&mut counts, &mut Vec::new(), 1);
    for _ in 0..6 {
        site.turn();
    }
    drop((counts, bus));
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    let published = site.published();
    assert!(published.len() > at_kill + 8, "the tracker went on");
    assert_eq!(site.counted("wide_area_reports"), 1);
    assert!(site.tracked("out", true) == published);
    // As long as the sensor was silent, the tracks are those of a tracker that hears none.
    let day_s = silent_until.rem_euclid(NS_PER_DAY) as f64 / NS;
    let early = |rows: Vec<String>| -> Vec<String> {
        let time_s = |row: &String| row.split(',').next().unwrap().parse::<f64>().unwrap();
        rows.into_iter().filter(|row| time_s(row) < day_s).collect()
    };
    let (with, without) = (early(published), early(site.tracked("out", false)));
    assert!(with == without && with.len() > 15, "{}", with.len());
    site.home.assert_nothing_is_left("test");
}

#[test]
fn another_systems_tracks_become_counts() {
    let tracks = "[wide_area_sensor.tracks]\nreceiver = \"link\"\nperiod_s = 1.0\ngroup_m = 500.0\n";
    let mut site = Site::live(tracks);
    let running = site.start();
    until("the other adapter listens", || {
        site.home.status_row("link").state == "running"
    });
    let bus = site.bus();
    let mut counts = bus
        .subscriber(&messages::wide_area("remote"), || mono_ns() as u64)
        .unwrap();
    let table = registry::default_edition(62).unwrap();
    let mut centre = SystemReports::new(table, 9, 9, system().1, &[], 1400).unwrap();
    let mut seen: Vec<WideArea> = Vec::new();
    for turn in 0..40 {
        // Two near each other where the radar's targets are, and one far away; told once a second.
        if turn % 5 == 0 {
            let ([east, north], socket, to) = (site.radar.middle_m(), &site.socket, site.remote);
            let time_ns = utc_ns();
            for (number, place) in [[east, north + 100.0], [east, north - 100.0], [40e3, -30e3]]
                .into_iter()
                .enumerate()
            {
                let track = SystemTrack {
                    reference_time_ns: time_ns,
                    time_of_measurement_ns: time_ns,
                    track_number: number as u32 + 1,
                    position_m: [place[0], place[1], 3000.0],
                    velocity_mps: [SPEED_MPS, 0.0, 0.0],
                    state: TrackState::Confirmed as u8,
                    ..SystemTrack::default()
                };
                centre.report(&track, &mut |block| drop(socket.send_to(block, to)));
            }
            centre.flush(&mut |block| drop(socket.send_to(block, to)));
        }
        site.turn();
        counts.take(64, |_, slice| seen.extend_from_slice(slice)).unwrap();
    }
    until("every picture is counted", || {
        counts.take(64, |_, slice| seen.extend_from_slice(slice)).unwrap();
        seen.iter().map(|report| report.targets).sum::<u32>() >= 24
    });
    drop((counts, bus));
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    for picture in seen.chunks(2) {
        let [pair, single] = picture else { panic!("{seen:?}") };
        assert_eq!((pair.targets, single.targets), (2, 1), "{seen:?}");
        assert!(
            (pair.position_m[1] - 15e3).abs() < 20.0 && (single.position_m[0] - 40e3).abs() < 20.0,
            "{seen:?}"
        );
        assert!((pair.velocity_mps[0] - 100.0).abs() < 1.0 && pair.arrival_ns >= pair.time_of_observation_ns);
        assert_eq!(pair.time_of_observation_ns, single.time_of_observation_ns);
    }
    assert!(site.counted("wide_area_reports") > 6);
    site.home.assert_nothing_is_left("test");
}

#[test]
fn a_recording_is_supported_alike_at_any_speed() {
    let mut site = Site::live(ROWS);
    site.radar.period_s = 4.0;
    let (mut plots, mut counts) = (Vec::new(), HEADER.to_owned());
    for turn in 0..60_i64 {
        let seconds = 43_200 + 4 * turn;
        if turn % 4 == 2 {
            let [east, north] = site.radar.middle_m();
            let (observed, east) = (seconds - 9, east - 9.0 * SPEED_MPS);
            counts += &format!("{observed},{}.5,{east},{north},0,{SPEED_MPS},0,0,2\n", seconds - 3);
        }
        site.radar
            .turn(1_000_000_000 * seconds, &mut |block| plots.extend_from_slice(block));
    }
    fs::write(site.home.path("plots.ast"), plots).unwrap();
    fs::write(site.home.path("counts.csv"), &counts).unwrap();
    let sensor = "[wide_area_sensor.recorded]\nfile = \"counts.csv\"\n";
    let source = "[source.recorded]\nfile = \"plots.ast\"\n";
    let time = "name = \"test\"\n[time]\norder = \"time\"\ndate = \"2026-05-10\"\n";
    fs::write(
        site.home.path("site.toml"),
        time.to_owned() + &deployment(sensor, source, "4.0"),
    )
    .unwrap();
    for (speed, out) in [("max", "out"), ("100", "slow")] {
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
        site.home.assert_nothing_is_left("test");
    }
    for name in [
        "sensor_tracks_radar.csv",
        "detections_radar.csv",
        "wide_area_remote.csv",
    ] {
        let (fast, slow) = (site.read(&format!("out/{name}")), site.read(&format!("slow/{name}")));
        let lines = [&fast, &slow].map(|text| text.lines().count());
        assert!(fast == slow && lines[0] > 10, "{name}: {lines:?}");
    }
    let with_route = |line: &str| format!("{line},\n");
    let expected: String = counts.lines().skip(1).map(with_route).collect();
    assert_eq!(
        site.read("out/wide_area_remote.csv").split_once('\n').unwrap().1,
        expected,
        "to the last digit"
    );
    let published = site.published();
    assert!(site.tracked("out", true) == published);
    assert!(site.tracked("out", false) != published);
    // A recording that is not there is said before anything starts.
    fs::remove_file(site.home.path("counts.csv")).unwrap();
    let output = site.home.run(&["check", "site.toml", "--data", "."]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("wide-area sensor \"remote\"") && said.contains("wide_area_sensor[0].recorded.file"),
        "{said}"
    );
}

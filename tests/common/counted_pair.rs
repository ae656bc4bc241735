//! Two targets that a radar mostly sees as one, and a deployment whose tracker listens to somebody who counts them.

use std::fs;
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

use asterix::registry;
use bus::{Bus, SharedMemory};
use frames::SensorFrame;
use frames::time::NS_PER_DAY;
use outgoing::SensorReports;

use super::home::{Home, Running, until};
use super::{PLACE, free_address, system, utc_ns};

/// Time between two turns of the radar, and how fast its targets fly.
pub(crate) const PERIOD: Duration = Duration::from_millis(200);
pub(crate) const SPEED_MPS: f64 = 100.0;
pub(crate) const NS: f64 = 1e9;
pub(crate) const HEADER: &str = "time_s,arrival_s,x,y,z,vx,vy,vz,count\n";
/// Without counts the two targets are found late: nothing else that helps a split is on.
pub(crate) const TRACKER: &str = "scans = \"turn\"\ndetection_probability = 0.9\nclutter_density = 1e-9\n\
                       splitting = { reliability_min = \"off\", departed_s = \"off\", leaving_max = \"off\" }\n\
                       [source.tracker.motion]\n\
                       process_noise_m2ps3 = [20.0, 5.0]\n";

pub(crate) struct Site {
    pub(crate) home: Home,
    pub(crate) radar: Radar,
    pub(crate) socket: UdpSocket,
    pub(crate) remote: SocketAddr,
}

/// Sees two targets side by side, mostly as one.
pub(crate) struct Radar {
    pub(crate) reports: SensorReports,
    pub(crate) turns: usize,
    pub(crate) period_s: f64,
}

impl Radar {
    pub(crate) fn new() -> Self {
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
    pub(crate) fn middle_m(&self) -> [f64; 2] {
        [-12e3 + SPEED_MPS * self.period_s * self.turns as f64, 15e3]
    }

    /// The plots of a turn that begins at `begin_ns`; both targets are in every sixth one.
    pub(crate) fn turn(&mut self, begin_ns: i64, send: &mut dyn FnMut(&[u8])) {
        let [east, north] = self.middle_m();
        let off = 15.0 * ((self.turns * 7) % 5) as f64 - 30.0;
        let places = match self.turns % 6 {
            5 => vec![[east + off, north + 100.0], [east - off, north - 100.0]],
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
    pub(crate) fn live(sensor: &str) -> Self {
        let [radar, remote] = [free_address(), free_address()];
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

    pub(crate) fn start(&self) -> Running {
        let running = self
            .home
            .start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
        running.until_said("instance test runs");
        for receiver in ["lan", "link"] {
            until("the adapters listen", || {
                self.home.status_row(receiver).state == "running"
            });
        }
        running
    }

    pub(crate) fn turn(&mut self) {
        let radar: SocketAddr = self.read("radar.port").parse().unwrap();
        let socket = &self.socket;
        self.radar
            .turn(utc_ns(), &mut |block| drop(socket.send_to(block, radar)));
        std::thread::sleep(PERIOD);
    }

    pub(crate) fn bus(&self) -> Bus<SharedMemory> {
        Bus::open(&self.home.root("test"), "watching").unwrap()
    }

    pub(crate) fn send(&self, datagram: &[u8]) {
        self.socket.send_to(datagram, self.remote).unwrap();
    }

    /// A row that was observed `delay_s` ago at the targets' middle.
    pub(crate) fn row(&self, delay_s: f64, count: u32) -> String {
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

    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.home.path(name)).unwrap_or_default()
    }

    /// What `koseki track` makes of the recorded detections, with the recorded counts or without.
    pub(crate) fn tracked(&self, out: &str, with_counts: bool) -> Vec<String> {
        let (detections, counts) = (
            format!("{out}/latest/detections_radar.csv"),
            format!("{out}/latest/wide_area_remote.csv"),
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

    /// Lines of the recorded tracks so far.
    pub(crate) fn lines(&self) -> usize {
        self.read("out/latest/sensor_tracks_radar.csv").lines().count()
    }

    pub(crate) fn published(&self) -> Vec<String> {
        rows(&self.read("out/latest/sensor_tracks_radar.csv"))
    }

    /// Sum of a counter over everything in the final report that has one.
    pub(crate) fn counted(&self, label: &str) -> u64 {
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
        let report: serde_json::Value = serde_json::from_str(&self.read("out/latest/report.json")).unwrap();
        // What a process says of its socket is said twice.
        sum(&report["sources"], label) + sum(&report["network"], label)
    }
}

pub(crate) fn deployment(sensor: &str, source: &str, period_s: &str) -> String {
    let [latitude, longitude] = PLACE;
    format!(
        "[frame]\nlatitude_deg = {latitude}\nlongitude_deg = {longitude}\n[[wide_area_sensor]]\nname = \"remote\"\n{sensor}\
         [[source]]\nname = \"radar\"\nperiod_s = {period_s}\nfresh_s = 30.0\n{source}[source.covariance]\nrange_sigma_m = 50.0\n\
         azimuth_sigma_deg = 0.15\n[source.tracker]\nwide_area_sensors = [\"remote\"]\n{TRACKER}"
    )
}

/// The rows of a file of sensor tracks, without the sensor's id and what comes after the state.
pub(crate) fn rows(text: &str) -> Vec<String> {
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

pub(crate) const ROWS: &str = "[wide_area_sensor.live]\nreceiver = \"link\"\n";

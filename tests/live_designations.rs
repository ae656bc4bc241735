//! Targets designated by order: a tracker that starts no tracks of its own follows them, and the recording gives the
//! same tracks again (HT-12).

use std::collections::BTreeSet;
use std::fs;
use std::net::{SocketAddr, UdpSocket};
use std::process::Output;
use std::time::Duration;

use frames::{Geodetic, SystemFrame};

use crate::common::{Home, PLACE, Running, free_address, until, utc_ns};
use crate::joint_tracker::{assert_equal, tracked_again};

/// Time between two scans.
const STEP: Duration = Duration::from_millis(100);
/// East and north of the targets, metres.
const TARGETS: [[f64; 2]; 2] = [[1000.0, 2000.0], [9000.0, 2000.0]];

struct Site {
    home: Home,
    socket: UdpSocket,
    to: SocketAddr,
    scans: u32,
}

impl Site {
    fn new() -> Self {
        let home = Home::new();
        let to = free_address();
        let text = format!(
            "name = \"test\"\n[frame]\nlatitude_deg = {}\nlongitude_deg = {}\n\
             [[receiver]]\nname = \"rows\"\n[receiver.udp]\nlisten = \"{to}\"\n\
             [[tracker]]\nname = \"ship\"\nperiod_s = 0.5\nfresh_s = 5.0\nwait_s = 0.2\n\
             [tracker.settings]\nstarts = \"designated\"\n\
             [tracker.settings.deletion]\nsilent_s = 600.0\nexistence_min = 0\nshown_min = 0\n\
             [tracker.settings.initiation]\nspeed_sigma_mps = 30.0\n\
             [tracker.settings.capacity]\ndetections = 256\ntracks = 1024\nopen_scans = 16\n\
             [[tracker.sensor]]\nname = \"lidar\"\n\
             [tracker.sensor.live]\nreceiver = \"rows\"\nformat = \"rows\"\nsensor_id = 1\n\
             [[tracker.sensor]]\nname = \"operator\"\ndesignates = true\n[tracker.sensor.orders]\n\
             [[source]]\nname = \"free\"\n[source.external]\n\
             [recorder]\nformat = [\"csv\", \"mcap\"]\n",
            PLACE[0], PLACE[1]
        );
        fs::write(home.path("site.toml"), text).unwrap();
        Self {
            home,
            socket: UdpSocket::bind("127.0.0.1:0").unwrap(),
            to,
            scans: 0,
        }
    }

    fn start(&self) -> Running {
        let running = self
            .home
            .start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
        running.until_said("instance test runs");
        for name in ["rows", "ship"] {
            until("it runs", || self.home.status_row(name).state == "running");
        }
        running
    }

    /// Sends a scan with both targets, measured now.
    fn step(&mut self) {
        let ns = utc_ns().rem_euclid(86_400_000_000_000);
        let time = format!("{}.{:09}", ns / 1_000_000_000, ns % 1_000_000_000);
        let scan = self.scans;
        self.scans += 1;
        let row = |(number, [east, north]): (usize, &[f64; 2])| {
            format!("{time},1,{scan},{number},position2,{east},{north},,,5,5,,,0,0,0")
        };
        let rows: Vec<String> = TARGETS.iter().enumerate().map(row).collect();
        let header = "time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz";
        let text = format!("{header}\n{}\n", rows.join("\n"));
        self.socket.send_to(text.as_bytes(), self.to).unwrap();
        std::thread::sleep(STEP);
    }

    fn steps_until(&mut self, what: &str, mut holds: impl FnMut(&Self) -> bool) {
        for step in 0..1200 {
            if step % 10 == 0 && holds(self) {
                return;
            }
            self.step();
        }
        panic!("never happened: {what}");
    }

    fn order(&self, words: &str) -> Output {
        let words: Vec<&str> = words.split_whitespace().collect();
        self.home.run(&[&["order", "--instance", "test"], &words[..]].concat())
    }

    fn refused(&self, words: &str, why: &str) {
        let output = self.order(words);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && said.contains(why), "{words}: {said}");
    }

    /// Targets near which the published tracks are, and the numbers of these.
    fn followed(&self) -> (BTreeSet<usize>, BTreeSet<String>) {
        let text = fs::read_to_string(self.home.path("out/latest/sensor_tracks_ship.csv")).unwrap_or_default();
        let mut lines = text.lines();
        let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
        let place = |name: &str| header.iter().position(|column| *column == name);
        let (Some(number), Some(east)) = (place("sensor_track_id"), place("x")) else {
            assert!(header.len() <= 1, "{header:?}");
            return Default::default();
        };
        let whole = lines.map(|line| line.split(',').collect::<Vec<_>>());
        let whole: Vec<Vec<&str>> = whole.filter(|row| row.len() == header.len()).collect();
        let nearest = |row: &Vec<&str>| {
            let east: f64 = row[east].parse().unwrap();
            usize::from(east > 5000.0)
        };
        let targets = whole.iter().map(nearest).collect();
        (targets, whole.iter().map(|row| row[number].to_owned()).collect())
    }
}

#[test]
fn targets_designated_by_order_are_followed_and_their_recording_gives_the_same_tracks() {
    let mut site = Site::new();
    let running = site.start();
    for _ in 0..30 {
        site.step();
    }
    assert_eq!(site.followed().0.len(), 0, "no track of its own");

    site.refused(
        "designate tracker=free place=0m,0m sigma=100",
        "takes designations by order",
    );
    site.refused("designate tracker=none place=0m,0m sigma=100", "no source of this name");
    site.refused("designate tracker=ship place=0m sigma=100", "EASTm,NORTHm");
    site.refused("designate tracker=ship place=0m,0m", "incomplete");

    let given = site.order("designate tracker=ship place=1100m,1900m sigma=300 --operator anna");
    assert!(given.status.success(), "{given:?}");
    site.steps_until("the first target is followed", |site| site.followed().0.contains(&0));
    // The same target again, and the other one by its place on the globe.
    let given = site.order("designate tracker=ship place=980m,2010m sigma=300");
    assert!(given.status.success(), "{given:?}");
    let frame = SystemFrame::at(Geodetic::from_degrees(PLACE[0], PLACE[1], 0.0).unwrap());
    let [east, north] = TARGETS[1];
    let place = frame.to_geodetic([east + 50.0, north, 0.0]);
    let place = format!("{:.5},{:.5}", place.latitude_deg(), place.longitude_deg());
    let given = site.order(&format!("designate tracker=ship place={place} sigma=300"));
    assert!(given.status.success(), "{given:?}");
    site.steps_until("the other target is followed", |site| site.followed().0.len() == 2);
    assert_eq!(site.followed().1.len(), 2, "one track each");

    let list: serde_json::Value = serde_json::from_slice(&site.order("--json").stdout).unwrap();
    let done = list.as_array().unwrap().iter();
    let done = done.filter(|order| order["kind"] == "designate" && order["state"] == "done");
    let done: Vec<&serde_json::Value> = done.collect();
    assert_eq!(done.len(), 3, "{list}");
    assert_eq!(
        done[0]["parameters"],
        serde_json::json!({"tracker": "ship", "place": "1100m,1900m", "sigma": 300})
    );

    let (ended, said) = running.stop();
    assert_eq!(ended.code(), Some(0), "{said}");
    let (summary, tracks) = tracked_again(&site.home, "ship");
    assert_equal(&tracks);
    assert!(tracks[0].len() > 10, "{} rows: {summary}", tracks[0].len());
    let report = fs::read_to_string(site.home.path("out/latest/report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let mut sources = report["sources"].as_array().unwrap().iter();
    let ship = sources.find(|source| source["name"] == "ship").unwrap();
    assert_eq!(ship["adapter"]["designations_followed"], 1, "{ship}");
    let orders = fs::read_to_string(site.home.path("out/latest/orders.csv")).unwrap();
    assert!(orders.contains("1100m,1900m") && orders.contains("anna"), "{orders}");
    site.home.assert_nothing_is_left("test");
}

//! Cues for a sensor controller, and pictures of a silent sensor, in a running deployment (WA-11, WA-12).

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::net::{TcpStream, UdpSocket};
use std::time::Duration;

use messages::{SensorTrack, TrackState};
use runtime::clock::mono_ns;

use crate::common::counted_pair::Site;
use crate::common::{free_address, until};

const ROWS: &str = "[wide_area_sensor.live]\nreceiver = \"link\"\n";
const COLUMNS: &str = "made_s,time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,longer_m,shorter_m,orientation_rad";
/// Longest wait for something that must come.
const PATIENCE: Duration = Duration::from_secs(60);

/// A deployment whose tracker makes cues and pictures, with these tables at the end of its file.
fn site(tables: &str) -> Site {
    let site = Site::live(ROWS);
    let keys = "scans = \"turn\"\ncues = true\noutput_period_s = 0.25\n";
    let text = site.read("site.toml").replacen("scans = \"turn\"\n", keys, 1);
    fs::write(site.home.path("site.toml"), text + tables).unwrap();
    site
}

#[test]
fn cues_leave_the_machine_as_rows_and_are_recorded() {
    let controller = UdpSocket::bind("127.0.0.1:0").unwrap();
    controller.set_read_timeout(Some(PATIENCE)).unwrap();
    let (to, at) = (controller.local_addr().unwrap(), free_address());
    let mut site = site(&format!(
        "[[cue_outlet]]\nname = \"looks\"\nsource = \"radar\"\nsend_to = \"{to}\"\n\
         [[cue_outlet]]\nname = \"lines\"\nsource = \"radar\"\nlisten = \"{at}\"\n"
    ));
    let running = site.start();
    until("the outlets run", || {
        ["looks", "lines"].map(|name| site.home.status_row(name).state) == ["running", "running"].map(str::to_owned)
    });
    let mut lines = BufReader::new(TcpStream::connect(at).unwrap());
    lines.get_ref().set_read_timeout(Some(PATIENCE)).unwrap();
    let mut line = || {
        let mut line = String::new();
        lines.read_line(&mut line).unwrap();
        line.trim_end().to_owned()
    };
    // The header shows that the outlet has taken the connection.
    assert_eq!(line(), COLUMNS);
    for _ in 0..30 {
        site.turn();
    }
    let (mut datagrams, mut octets) = (Vec::new(), [0; 2048]);
    while datagrams.len() < 10 {
        let length = controller.recv(&mut octets).unwrap();
        let text = std::str::from_utf8(&octets[..length]).unwrap();
        let (header, rows) = text.split_once('\n').unwrap();
        assert_eq!(header, COLUMNS);
        datagrams.extend(rows.lines().map(str::to_owned));
    }
    let connected: Vec<String> = (0..10).map(|_| line()).collect();
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    let recorded = site.read("out/latest/cues_radar.csv");
    let recorded: Vec<&str> = recorded.lines().skip(1).collect();
    for rows in [datagrams, connected] {
        let first = recorded.iter().position(|row| *row == rows[0]);
        let first = first.unwrap_or_else(|| panic!("{} is not recorded: {recorded:?}", rows[0]));
        assert!(recorded[first..].starts_with(&rows.iter().map(String::as_str).collect::<Vec<_>>()));
    }
    site.home.assert_nothing_is_left("test");
}

#[test]
fn pictures_go_on_while_the_sensor_is_silent() {
    let mut site = site("");
    let running = site.start();
    let bus = site.bus();
    let topic = messages::sensor_tracks("radar");
    let mut subscriber = bus.subscriber(&topic, || mono_ns() as u64).unwrap();
    let mut tracks: Vec<SensorTrack> = Vec::new();
    for _ in 0..200 {
        site.turn();
        subscriber.take(64, |_, slice| tracks.extend_from_slice(slice)).unwrap();
        if tracks.len() > 20 {
            break;
        }
    }
    // From now on the radar sends nothing.
    let seen = tracks.len();
    until("pictures go on", || {
        subscriber.take(64, |_, slice| tracks.extend_from_slice(slice)).unwrap();
        tracks.len() > seen + 20
    });
    drop((subscriber, bus));
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    assert!(
        tracks
            .iter()
            .all(|track| track.time_of_measurement_ns % 250_000_000 == 0)
    );
    assert!(tracks.is_sorted_by_key(|track| track.time_of_measurement_ns));
    let last = &tracks[seen + 10..];
    assert!(last.iter().all(|track| track.state == TrackState::Coasted as u8));
    // What was shown is recorded like every other track.
    assert!(site.published().len() >= tracks.len());
    site.home.assert_nothing_is_left("test");
}

//! Transmitters located from reports of direction finders in ASTERIX (category 205): recorded, live, and by
//! `koseki open`.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use std::net::UdpSocket;
use std::thread;
use std::time::Duration;

use asterix::{Decoder, StatedTables};
use bus::{Bus, SharedMemory};
use formats::bearings_csv::BearingWriter;
use formats::observation::{DirectionFinder, finder_report};
use frames::{Geodetic, SystemFrame};
use messages::SensorTrack;
use observations::{Bearing, EmitterMeasurement};
use runtime::clock::mono_ns;
use rustix::process::Signal;
use serde_json::{Value, json};

use crate::common::{Home, free_address, until, utc_ns};

/// Latitude and longitude of two finders, degrees.
const FINDERS_DEG: [[f64; 2]; 2] = [[54.0, 10.0], [54.0, 10.2]];
/// Where the transmitting ship begins; it goes east.
const SHIP_DEG: [f64; 2] = [54.08, 10.05];
const SHIP_MPS: f64 = 8.0;
pub(crate) const SECONDS: u32 = 240;
pub(crate) const NINE_S: f64 = 9.0 * 3_600.0;

fn geodetic([latitude, longitude]: [f64; 2]) -> Geodetic {
    Geodetic::from_degrees(latitude, longitude, 0.0).unwrap()
}

/// Latitude and longitude of the ship, degrees.
fn ship_deg(passed_s: f64) -> [f64; 2] {
    let place = SystemFrame::at(geodetic(SHIP_DEG)).to_geodetic([SHIP_MPS * passed_s, 0.0, 0.0]);
    [place.latitude_deg(), place.longitude_deg()]
}

/// Bearing of the ship from geographical north at a finder, degrees.
fn bearing_deg(finder: usize, passed_s: f64) -> f64 {
    let [east, north, _] = SystemFrame::at(geodetic(FINDERS_DEG[finder])).to_local(geodetic(ship_deg(passed_s)));
    (east.atan2(north).to_degrees().rem_euclid(360.0) * 100.0).round() / 100.0
}

/// A report of each second, by one finder after the other, as `koseki encode` reads them.
fn records() -> String {
    let record = |second: u32| {
        let (finder, passed_s) = (second as usize % 2, f64::from(second));
        let [latitude, longitude] = FINDERS_DEG[finder];
        let record = json!({
            "_c": 205,
            "010": {"SAC": 25, "SIC": 9 + finder},
            "000": 5,
            "030": NINE_S + passed_s,
            "050": {"LAT": latitude, "LON": longitude},
            "070": bearing_deg(finder, passed_s),
            "090": "156.800",
            "160": 7 + finder,
        });
        format!("{record}\n")
    };
    (0..SECONDS).map(record).collect()
}

pub(crate) fn succeed(home: &Home, arguments: &str) -> String {
    let output = home.run(&arguments.split(' ').collect::<Vec<_>>());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{arguments}: {said}");
    said
}

/// The bearings of a recording, as `koseki locate` reads them.
fn table(blocks: &[u8], origin_deg: [f64; 2], first_day_ns: i64) -> Vec<u8> {
    let (frame, sigma_rad) = (SystemFrame::at(geodetic(origin_deg)), 2f64.to_radians());
    let finder = DirectionFinder::new(&frame, geodetic(origin_deg), sigma_rad).unwrap();
    let mut decoder: Decoder = StatedTables::new(&[], false).decoder();
    let mut table = BearingWriter::begin(Vec::new(), first_day_ns).unwrap();
    for record in decoder.records(blocks) {
        let report = finder_report(&record.unwrap()).unwrap();
        let noon_ns = first_day_ns + 43_200_000_000_000;
        let EmitterMeasurement::Bearing(bearing) = report.measurement(&finder, noon_ns).unwrap() else {
            panic!("{report:?}")
        };
        // The numbers of each finder are its own; on the channel there is one transmission.
        let bearing = Bearing {
            emitter_id: Some(65_536),
            ..bearing
        };
        table.write(&bearing).unwrap();
    }
    table.into_inner()
}

pub(crate) fn rows(text: &str) -> Vec<Vec<String>> {
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    text.lines().skip(1).map(cells).collect()
}

#[test]
fn a_recording_is_opened_and_located_as_its_table_of_bearings() {
    let home = Home::new();
    home.write("finders.jsonl", records());
    succeed(&home, "encode finders.jsonl --out finders.ast");
    let said = succeed(&home, "open finders.ast --no-display --date 2024-06-06 --out out");
    let report: Value = serde_json::from_str(&home.read("out/latest/report.json")).unwrap();
    assert_eq!(report["picture"]["ever_confirmed"], 1, "{said}");
    assert!(
        said.contains("240 reports of direction finders") && said.contains("25/9, 25/10"),
        "{said}"
    );
    let config = home.read("out/open.toml");
    assert!(config.contains("[source.locator]") && config.contains("latitude_deg = 54.0\nlongitude_deg = 10.0"));

    // The same with a table of the sensor's tracks.
    home.write("site.toml", config.replace("\"mcap\"", "\"csv\""));
    succeed(&home, "up site.toml --data . --speed max --out again");
    let tracks = rows(&home.read("again/latest/sensor_tracks_finders-finders.csv"));
    let first_day_ns = 1_717_632_000_000_000_000;
    let blocks = std::fs::read(home.path("finders.ast")).unwrap();
    home.write("bearings.csv", table(&blocks, FINDERS_DEG[0], first_day_ns));
    succeed(&home, "locate --bearings bearings.csv --out fixes.csv");
    // Time, number and place; a sensor track has its sensor between the first two.
    let fixes: BTreeSet<Vec<String>> = rows(&home.read("fixes.csv"))
        .into_iter()
        .map(|row| row[..5].to_vec())
        .collect();
    assert!(
        tracks.len() > 100 && tracks.len() == fixes.len(),
        "{} of {}",
        tracks.len(),
        fixes.len()
    );
    for row in &tracks {
        let made = [&row[..1], &row[2..6]].concat();
        assert!(fixes.contains(&made), "{made:?}");
    }
    // The recording itself, to the last digit.
    let origin = "--origin 54.0,10.0";
    succeed(
        &home,
        &format!("locate --bearings bearings.csv {origin} --out placed.csv"),
    );
    succeed(&home, &format!("locate finders.ast {origin} --out recorded.csv"));
    assert_eq!(home.read("recorded.csv"), home.read("placed.csv"));
    let recorded = rows(&home.read("recorded.csv"));
    assert!(recorded.iter().all(|row| fixes.contains(&row[..5])) && recorded.len() == fixes.len());
    let last: Vec<f64> = tracks.last().unwrap()[3..5]
        .iter()
        .map(|cell| cell.parse().unwrap())
        .collect();
    let ship = SystemFrame::at(geodetic(FINDERS_DEG[0])).to_local(geodetic(ship_deg(f64::from(SECONDS))));
    let off_m = (last[0] - ship[0]).hypot(last[1] - ship[1]);
    assert!(off_m < 200.0, "{off_m:.0} m off");
}

/// What stands on standard error beside exit code 2.
pub(crate) fn refused(home: &Home, arguments: &str) -> String {
    let output = home.run(&arguments.split(' ').collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(2), "{arguments}: {output:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn what_is_missing_is_named_with_the_remedy() {
    let home = Home::new();
    let unplaced: String = records().replace("\"050\"", "\"_050\"");
    let unplaced: String = unplaced
        .lines()
        .map(|line| {
            let mut record: Value = serde_json::from_str(line).unwrap();
            record.as_object_mut().unwrap().remove("_050");
            format!("{record}\n")
        })
        .collect();
    home.write("unplaced.jsonl", unplaced);
    succeed(&home, "encode unplaced.jsonl --out unplaced.ast");
    let said = refused(&home, "open unplaced.ast --no-display --date 2024-06-06");
    assert!(
        said.contains("240 reports state no position") && said.contains("--place"),
        "{said}"
    );
    let site = "name = \"a\"\n[frame]\nlatitude_deg = 54.0\nlongitude_deg = 10.0\n[time]\ndate = \"2024-06-06\"\n\
                [[source]]\nname = \"b\"\n[source.recorded]\nfile = \"unplaced.ast\"\n";
    home.write("site.toml", site);
    let said = refused(&home, "check site.toml --data .");
    assert!(
        said.contains("(category 205)") && said.contains("add [source.locator]"),
        "{said}"
    );
    home.write("site.toml", format!("{site}[source.locator]\n"));
    succeed(&home, "check site.toml --data .");
}

/// A report of a finder at `time_ns` (UTC) with the ship's bearing after `passed_s`, byte by byte.
pub(crate) fn block(finder: usize, time_ns: i64, passed_s: f64) -> Vec<u8> {
    let coordinate = |degrees: f64| ((degrees / 180.0 * f64::from(1 << 25)).round() as i32).to_be_bytes();
    let [latitude, longitude] = FINDERS_DEG[finder].map(coordinate);
    let ticks = (time_ns.rem_euclid(86_400_000_000_000) / 7_812_500) as u32;
    let bearing = (bearing_deg(finder, passed_s) * 100.0).round() as u16;
    let body = [
        &[0xB7, 0x40, 25, 9 + finder as u8, 5][..],
        &ticks.to_be_bytes()[1..],
        b"156.800",
        &latitude,
        &longitude,
        &bearing.to_be_bytes(),
    ]
    .concat();
    [&[205, 0, body.len() as u8 + 3], &body[..]].concat()
}

#[test]
fn datagrams_of_reports_and_of_tables_are_located_live() {
    let home = Home::new();
    let address = free_address();
    let site = format!(
        "name = \"test\"\n[frame]\nlatitude_deg = 54.0\nlongitude_deg = 10.0\n[[receiver]]\nname = \"lan\"\n\
         [receiver.udp]\nlisten = \"{address}\"\n[[source]]\nname = \"finder\"\nperiod_s = 0.2\n[source.live]\n\
         receiver = \"lan\"\n[source.locator]\n[recorder]\nenabled = false\n"
    );
    home.write("site.toml", site);
    let running = home.start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
    running.until_said("instance test runs");
    let bus = Bus::<SharedMemory>::open(&home.root("test"), "reader").unwrap();
    let mut located = bus
        .subscriber(&messages::sensor_tracks("finder"), || mono_ns() as u64)
        .unwrap();
    let (socket, begun_ns) = (UdpSocket::bind("127.0.0.1:0").unwrap(), utc_ns());
    let mut tracks: BTreeMap<u32, SensorTrack> = BTreeMap::new();
    let mut sent = 0_usize;
    until("the ship is located from reports, and another from rows", || {
        let now_ns = utc_ns();
        let passed_s = (now_ns - begun_ns) as f64 / 1e9;
        socket.send_to(&block(sent % 2, now_ns, passed_s), address).unwrap();
        // Both finders hear number 77 in directions that meet at 6.5 km east, 6.5 km north of the first.
        let (x, bearing) = [(0.0, TAU / 8.0), (13_000.0, -TAU / 8.0)][sent % 2];
        let time_s = now_ns.rem_euclid(86_400_000_000_000) as f64 / 1e9;
        let rows = format!("time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz\n{time_s},77,{bearing},0.02,{x},0,0\n");
        socket.send_to(rows.as_bytes(), address).unwrap();
        // A block that was cut.
        socket.send_to(&block(0, now_ns, passed_s)[..9], address).unwrap();
        sent += 1;
        thread::sleep(Duration::from_millis(20));
        let taken = located.take(256, |_, slice| {
            tracks.extend(slice.iter().map(|track| (track.track_number, *track)));
        });
        taken.unwrap();
        tracks.len() >= 2 && sent > 100
    });
    let ship = SystemFrame::at(geodetic(FINDERS_DEG[0])).to_local(geodetic(SHIP_DEG));
    let is_near = |place: [f64; 2]| {
        let off_m = |track: &SensorTrack| (track.position_m[0] - place[0]).hypot(track.position_m[1] - place[1]);
        tracks.values().any(|track| off_m(track) < 300.0)
    };
    assert!(is_near([ship[0], ship[1]]) && is_near([6_500.0, 6_500.0]), "{tracks:?}");
    drop((located, bus));
    running.signal(Signal::TERM);
    let (status, said) = running.end();
    assert_eq!(status.code(), Some(0), "{said}");
    let report: Value = serde_json::from_str(&home.read("out/latest/report.json")).unwrap();
    assert!(report.to_string().contains("blocks_rejected"), "{report}");
    home.assert_nothing_is_left("test");
}

//! `koseki open`: files and feeds of every kind into tracks, without a configuration.

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde_json::Value;

use crate::common::{Home, free_address, until};

/// Halves of one position of an aircraft (52.2572° N, 3.9194° E): worked frames of the literature.
const HALVES: [&str; 2] = ["8D40621D58C382D690C8AC2863A7", "8D40621D58C386435CC412692AD6"];
/// Positions of a ship that goes north, ten seconds apart.
const SHIP: [&str; 6] = [
    "!AIVDM,1,1,,A,13HNvh@P1FPGkL0Hf2000001P000,0*26",
    "!AIVDM,1,1,,A,13HNvh@P1FPGkL0Hf2t0000EP000,0*16",
    "!AIVDM,1,1,,A,13HNvh@P1FPGkL0Hf3p0000aP000,0*37",
    "!AIVDM,1,1,,A,13HNvh@P1FPGkL0Hf4l0000uP000,0*38",
    "!AIVDM,1,1,,A,13HNvh@P1FPGkL0Hf5h0001AP000,0*08",
    "!AIVDM,1,1,,A,13HNvh@P1FPGkL0Hf6d0001UP000,0*13",
];
/// A base station, and a virtual aid to navigation, far from the ship.
const STATIONS: [&str; 2] = [
    "!AIVDM,1,1,,A,403OviQuMGCqWrRO9>E6fE700@GO,0*4D",
    "!AIVDM,1,1,,B,E>lt;MIas0h3V:@;4a::h0b7W005Jh4nq:3l800003v010,4*09",
];
/// A time of recordings: 2024-06-06 09:00 UTC.
const BEGUN_S: u64 = 1_717_664_400;

/// Document of readsb with an aircraft that flies north at 200 m/s.
fn aircraft(now_s: f64, passed_s: f64) -> String {
    let latitude = 50.0 + passed_s * 200.0 / 111_200.0;
    format!(
        "{{\"now\":{now_s:.1},\"aircraft\":[{{\"hex\":\"3c0001\",\"flight\":\"DLH1\",\"lat\":{latitude:.6},\"lon\":8.0,\
         \"alt_baro\":30000,\"gs\":388.8,\"track\":0,\"seen\":0,\"seen_pos\":0,\"nac_p\":9,\"category\":\"A3\",\"type\":\"adsb_icao\"}}]}}"
    )
}

/// Opens `name` in the home's folder; returns the counts of system tracks, and what was printed about decisions.
fn opened(home: &Home, name: &str, options: &[&str]) -> (Value, String) {
    let file = home.path(name).display().to_string();
    let out = home.path(&format!("out-{name}")).display().to_string();
    let fixed = ["open", &file, "--no-display", "--out", &out];
    let output = home.run(&[&fixed[..], options].concat());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{name}: {said}");
    let report: Value = serde_json::from_str(&home.read(&format!("out-{name}/latest/report.json"))).unwrap();
    (report["picture"].clone(), said)
}

/// Cells of a column of a table.
fn column<'a>(table: &'a str, name: &str) -> Vec<&'a str> {
    let mut lines = table.lines();
    let place = lines
        .next()
        .unwrap()
        .split(',')
        .position(|column| column == name)
        .unwrap();
    lines.map(|line| line.split(',').nth(place).unwrap()).collect()
}

#[test]
fn a_file_of_each_kind_becomes_a_track() {
    let home = Home::new();
    let times = || (0..40).map(|second| (BEGUN_S + second, HALVES[second as usize % 2]));
    let hex: String = times().map(|(time, frame)| format!("{time}.0 {frame}\n")).collect();
    let json: String = times()
        .map(|(time, frame)| format!("{{\"timestamp\":{time}.0,\"frame\":\"{frame}\"}}\n"))
        .collect();
    let ais: String = SHIP
        .iter()
        .zip(0..)
        .map(|(sentence, place)| format!("{} {sentence}\n", BEGUN_S + 10 * place))
        .collect();
    let readsb: String = (0..20)
        .map(|second| aircraft((BEGUN_S + second) as f64, second as f64) + "\n")
        .collect();
    let table: String = (0..20)
        .map(|second| format!("{},{:.6},8.0,3c0002\n", BEGUN_S + second, 50.0 + 0.0018 * second as f64))
        .collect();
    let table = format!("time,latitude,longitude,icao24\n{table}");
    for (name, content, format) in [
        ("timed.txt", hex, "format \"mode-s\""),
        ("frames.jsonl", json, "format \"mode-s\""),
        ("ship.ais", ais, "format \"ais\""),
        ("history.jsonl", readsb, "format \"readsb\""),
        ("table.csv", table, "a table of named columns"),
    ] {
        home.write(name, &content);
        let (picture, said) = opened(&home, name, &[]);
        assert_eq!(
            (&picture["started"], &picture["ever_confirmed"]),
            (&1.into(), &1.into()),
            "{name}: {said}"
        );
        assert!(
            said.contains(format) && said.contains("first day: 2024-06-06"),
            "{said}"
        );
        // What was decided is a configuration that goes on serving.
        let config = home.path(&format!("out-{name}/open.toml")).display().to_string();
        let checked = home.run(&["check", &config, "--data", "."]);
        assert_eq!(checked.status.code(), Some(0), "{checked:?}");
    }
    // The category is stated beside the motion, once, since it does not change within a minute.
    let paths = ["out-history.jsonl/latest", "tables"].map(|path| home.path(path).display().to_string());
    let exported = home.run(&["recording", "export", &paths[0], "--csv", &paths[1]]);
    assert_eq!(exported.status.code(), Some(0), "{exported:?}");
    let stated = home.read("tables/statements_history.csv");
    assert_eq!(column(&stated, "category"), ["large"], "{stated}");
}

#[test]
fn stations_are_stated_with_their_places_and_are_no_tracks() {
    let home = Home::new();
    let sent = SHIP
        .iter()
        .zip(0..)
        .flat_map(|(ship, place)| [*ship, STATIONS[place % 2]].map(|line| (line, place)));
    let lines: String = sent
        .map(|(line, place)| format!("{} {line}\n", BEGUN_S + 10 * place as u64))
        .collect();
    home.write("coast.ais", lines);
    let (picture, said) = opened(&home, "coast.ais", &[]);
    assert_eq!(
        (&picture["started"], &picture["ever_confirmed"]),
        (&1.into(), &1.into()),
        "{said}"
    );
    assert!(
        said.contains("2 base stations and aids to navigation: shown, not tracked"),
        "{said}"
    );
    let paths = ["out-coast.ais/latest", "tables"].map(|path| home.path(path).display().to_string());
    let exported = home.run(&["recording", "export", &paths[0], "--csv", &paths[1]]);
    assert_eq!(exported.status.code(), Some(0), "{exported:?}");
    let stated = home.read("tables/statements_coast.csv");
    let stations = |name: &str| {
        let all = column(&stated, name)
            .into_iter()
            .zip(column(&stated, "station_latitude"));
        let of_station: Vec<&str> = all
            .filter(|(_, latitude)| !latitude.is_empty())
            .map(|(cell, _)| cell)
            .collect();
        of_station
    };
    assert_eq!(stations("sensor_track_id"), ["3669702", "995036021"], "{stated}");
    assert_eq!(stations("category"), ["base-station", "aid"]);
    assert_eq!(stations("station_name"), ["", "S6A GLT VIRTU ATON"]);
    assert_eq!(
        (stations("aid")[1], stations("virtual"), stations("off_position")),
        ("special-beacon", vec!["0", "1"], vec!["0", "0"])
    );
    assert_eq!(stations("station_latitude")[1], "-23.9173850");
}

/// Appends the checksum and a line end.
fn sentence(body: &str) -> String {
    let sum = body.bytes().skip(1).fold(0, |sum, octet| sum ^ octet);
    format!("{body}*{sum:02X}\r\n")
}

/// 200 lines of a ship that goes north at 10 kt, and tracks a ship 3 NM abeam with the same course by radar.
fn radar_lines() -> String {
    let of_second = |second: u64| {
        let clock = format!("09{:02}{:02}.00", second / 60, second % 60);
        let minutes = 10.0 * second as f64 / 3600.0;
        [
            format!("$GPRMC,{clock},A,54{minutes:07.4},N,01030.0000,E,10.0,0.0,060624,,,A"),
            "$GPVTG,0.0,T,,M,10.0,N,18.5,K,A".to_owned(),
            "$HEHDT,0.0,T".to_owned(),
            format!("$RATTM,5,3.00,90.0,R,0.0,0.0,R,,,N,,T,,{clock},A"),
        ]
        .map(|body| sentence(&body))
        .concat()
    };
    (0..50).map(of_second).collect()
}

#[test]
fn targets_of_a_radar_become_tracks_beside_those_of_ais() {
    let home = Home::new();
    home.write("radar.nmea", radar_lines());
    let (picture, said) = opened(&home, "radar.nmea", &[]);
    assert_eq!(
        (&picture["started"], &picture["ever_confirmed"]),
        (&1.into(), &1.into()),
        "{said}"
    );
    assert!(
        said.contains("format \"radar-targets\": 50 of 50 transmissions") && said.contains("first day: 2024-06-06"),
        "{said}"
    );
    // A radar ashore sends no place.
    let targets: String = radar_lines()
        .lines()
        .filter(|line| line.contains("TTM"))
        .map(|line| sentence(&line.split('*').next().unwrap().replace("R,", "T,")))
        .collect();
    home.write("ashore.nmea", targets);
    let options = ["--place", "54.0,10.5", "--date", "2024-06-06"];
    let (picture, said) = opened(&home, "ashore.nmea", &options);
    assert_eq!(&picture["ever_confirmed"], &1, "{said}");
    // A logger writes the sentences of all devices.
    let ais: String = SHIP
        .iter()
        .zip(0..)
        .map(|(sentence, place)| format!("{} {sentence}\n", BEGUN_S + 10 * place))
        .collect();
    home.write("both.log", ais + &radar_lines());
    let (picture, said) = opened(&home, "both.log", &[]);
    assert_eq!(&picture["ever_confirmed"], &2, "{said}");
    let config = home.read("out-both.log/open.toml");
    assert!(
        config.contains("format = \"ais\"") && config.contains("format = \"radar-targets\""),
        "{config}"
    );
}

#[test]
fn what_cannot_be_read_is_named_with_the_remedy() {
    let home = Home::new();
    let untimed = format!("*{};\n*{};\n", HALVES[0], HALVES[1]);
    let utf16: Vec<u8> = "\u{feff}time,lat\n1,2\n"
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    home.write("frames.avr", untimed);
    home.write("empty", "");
    home.write("notes.txt", "Dear all,\nplease find attached.\n");
    home.write("utf16.csv", utf16);
    home.write(
        "radar.nmea",
        sentence("$RATTM,5,3.00,90.0,T,0.0,0.0,T,,,N,,T,,090000,A"),
    );
    home.write("both.csv", "time,lat,latitude,lon\n1,2,3,4\n");
    for (name, reason) in [
        ("frames.avr", "has no time"),
        ("empty", "the file is empty"),
        ("notes.txt", "it is text"),
        ("utf16.csv", "save it as UTF-8"),
        ("both.csv", "latitude"),
        ("radar.nmea", "state [source.place] of a radar ashore"),
        ("absent.csv", "absent.csv"),
    ] {
        let file = home.path(name).display().to_string();
        let output = home.run(&["open", &file, "--no-display"]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        assert!(said.contains(reason) && said.contains(name), "{name}: {said}");
    }
    for (what, reason) in [
        ("ftp://a/b", "tcp://, udp:// or http://"),
        ("tcp://127.0.0.1", "no address with a port"),
    ] {
        let output = home.run(&["open", what]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(reason), "{said}");
    }
}

/// Seconds since 1970.
fn now_s() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs_f64()
}

/// Serves each connection by `serve` until the test ends.
fn serving(serve: impl Fn(TcpStream) + Send + Sync + 'static) -> (String, Arc<AtomicBool>) {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = server.local_addr().unwrap().to_string();
    let (ended, serve) = (Arc::new(AtomicBool::new(false)), Arc::new(serve));
    let is_ended = Arc::clone(&ended);
    thread::spawn(move || {
        for connection in server.incoming() {
            if is_ended.load(Ordering::Relaxed) {
                return;
            }
            let serve = Arc::clone(&serve);
            thread::spawn(move || serve(connection.unwrap()));
        }
    });
    (address, ended)
}

/// Opens a feed until a track is confirmed.
fn confirmed_live(home: &Home, what: &str, name: &str) {
    let out = home.path(&format!("out-{name}")).display().to_string();
    let running = home.start(&["open", what, "--no-display", "--out", &out]);
    until("a track is confirmed", || {
        running.stdout.lock().unwrap().contains("tracks: 1 confirmed")
    });
    let (ended, said) = running.stop();
    assert_eq!(ended.code(), Some(0), "{said}");
    home.assert_nothing_is_left(name);
}

#[test]
fn frames_over_a_connection_become_a_track_live() {
    let home = Home::new();
    let (address, ended) = serving(|mut connection| {
        for place in 0.. {
            // Beast: kind, ticks, level, and the frame, in which no octet is the escape.
            let octets: Vec<u8> = (0..HALVES[0].len() / 2)
                .map(|at| u8::from_str_radix(&HALVES[place % 2][2 * at..2 * at + 2], 16).unwrap())
                .collect();
            let message = [&[0x1a, b'3'][..], &[0; 6], &[0x80], &octets].concat();
            if connection.write_all(&message).is_err() {
                return;
            }
            thread::sleep(Duration::from_millis(500));
        }
    });
    confirmed_live(&home, &format!("tcp://{address}"), "tcp");
    let what = format!("tcp://{address}");
    let first = home.start(&["open", &what, "--no-display"]);
    first.until_said("instance tcp");
    let second = home.start(&["open", &what, "--no-display"]);
    second.until_said("instance tcp-2");
    for running in [second, first] {
        assert_eq!(running.stop().0.code(), Some(0));
    }
    ended.store(true, Ordering::Relaxed);
}

#[test]
fn targets_of_a_radar_over_a_connection_become_a_track_live() {
    let home = Home::new();
    let (address, ended) = serving(|mut connection| {
        loop {
            let now = now_s() as u64;
            let clock = format!("{:02}{:02}{:02}", now / 3600 % 24, now / 60 % 60, now % 60);
            let lines = [
                format!("$GPGGA,{clock},5400.0000,N,01030.0000,E,1,08,1.0,20.0,M,,M,,"),
                "$HEHDT,0.0,T".to_owned(),
                "$RATTM,5,3.00,90.0,R,,,,,,N,,T,,,A".to_owned(),
            ];
            let lines = lines.map(|body| sentence(&body)).concat();
            if connection.write_all(lines.as_bytes()).is_err() {
                return;
            }
            thread::sleep(Duration::from_millis(500));
        }
    });
    confirmed_live(&home, &format!("tcp://{address}"), "radar");
    let config = home.read("out-radar/open.toml");
    assert!(
        config.contains("format = \"radar-targets\"") && config.contains("from = \"report\""),
        "{config}"
    );
    ended.store(true, Ordering::Relaxed);
}

#[test]
fn a_document_over_http_becomes_a_track_live() {
    let home = Home::new();
    let begun_s = now_s();
    let (address, ended) = serving(move |mut connection| {
        let mut asked = [0; 4096];
        let answers = |octets: usize| octets > 0;
        while connection.read(&mut asked).is_ok_and(answers) {
            let document = aircraft(now_s(), now_s() - begun_s);
            let answer = format!(
                "HTTP/1.1 200 OK\r\ncontent-length: {}\r\n\r\n{document}",
                document.len()
            );
            if connection.write_all(answer.as_bytes()).is_err() {
                return;
            }
        }
    });
    confirmed_live(&home, &format!("http://{address}/data/aircraft.json"), "http");
    // The category is stated beside the motion.
    let stated = home.read("out-http/latest/statements_http.csv");
    assert!(stated.lines().count() > 1 && stated.contains(",large,"), "{stated}");
    ended.store(true, Ordering::Relaxed);
}

#[test]
fn a_feed_that_is_absent_is_named() {
    let home = Home::new();
    let address = free_address();
    let output = home.run(&["open", &format!("tcp://{address}"), "--no-display"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        !output.status.success() && said.contains(&address.to_string()),
        "{said}"
    );
}

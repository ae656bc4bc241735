//! Lines of JSON, in degrees, to fused tracks: `koseki feed`.

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead as _, BufReader, Write as _};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::process::Stdio;
use std::sync::Arc;
use std::time::Duration;

use bus::{Bus, Mark, SharedMemory, Subscriber};
use messages::{SensorDetection, SystemTrack, TrackState};
use runtime::clock::mono_ns;
use rustix::process::Signal;

use crate::common::{Home, PLACE, Running, free_address, kill, until, utc_ns};

/// Time between two scans, and most scans of a test.
const STEP: Duration = Duration::from_millis(200);
const STEPS_MAX: usize = 1500;
const TARGETS: usize = 3;

/// A deployment with a source of detections, and one of tracks.
fn site(home: &Home) -> Running {
    let [latitude, longitude] = PLACE;
    let text = format!(
        "name = \"t\"\n[frame]\nlatitude_deg = {latitude}\nlongitude_deg = {longitude}\n[[source]]\nname = \"own\"\n\
         period_s = 0.2\n[source.external]\ninput = \"detections\"\n[[source]]\nname = \"tracks\"\n[source.external]\n\
         [recorder]\nenabled = false\n[display]\nlisten = \"off\"\n"
    );
    fs::write(home.path("site.toml"), text).unwrap();
    let running = home.start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
    running.until_said("instance test runs");
    until("the tracker runs", || home.status_row("own").state == "running");
    running
}

/// The lines of a scan: targets 3 km apart that fly east.
fn scan(step: usize) -> String {
    let time_ns = utc_ns();
    let line = |target: usize| {
        let latitude = PLACE[0] + 0.1 + 0.027 * target as f64;
        let longitude = PLACE[1] + 0.0002 * step as f64;
        // Errors of some metres that have no mean.
        let error = 3e-5 * (((step * 7 + target * 3) % 5) as f64 - 2.0);
        let latitude = latitude + error;
        format!("{{\"time_ns\": {time_ns}, \"latitude\": {latitude}, \"longitude\": {longitude}, \"sigma_m\": 10}}\n")
    };
    (0..TARGETS).map(line).collect()
}

/// The system tracks that are confirmed.
struct Picture {
    tracks: Subscriber<SharedMemory, SystemTrack>,
    confirmed: BTreeSet<u32>,
    _bus: Bus<SharedMemory>,
}

impl Picture {
    fn of(home: &Home) -> Self {
        let bus = Bus::<SharedMemory>::open(&home.root("test"), "picture").unwrap();
        Self {
            tracks: bus.subscriber(&messages::system_tracks(), || mono_ns() as u64).unwrap(),
            confirmed: BTreeSet::new(),
            _bus: bus,
        }
    }

    fn look(&mut self) {
        let confirmed = &mut self.confirmed;
        let is_confirmed = |track: &&SystemTrack| track.state == TrackState::Confirmed as u8;
        self.tracks
            .take(usize::MAX, |_, tracks| {
                confirmed.extend(tracks.iter().filter(is_confirmed).map(|track| track.track_number));
            })
            .unwrap();
    }
}

/// Sends scans until there are confirmed tracks of all targets; returns how many steps there were.
fn feed_until_confirmed(home: &Home, begin: usize, mut send: impl FnMut(&str)) -> usize {
    let mut picture = Picture::of(home);
    for step in begin..begin + STEPS_MAX {
        send(&scan(step));
        std::thread::sleep(STEP);
        picture.look();
        if picture.confirmed.len() >= TARGETS {
            assert_eq!(picture.confirmed.len(), TARGETS, "{:?}", picture.confirmed);
            return step + 1;
        }
    }
    panic!("no tracks: {:?}", picture.confirmed);
}

fn connect(to: SocketAddr) -> TcpStream {
    let mut connected = None;
    until("it listens", || {
        connected = TcpStream::connect(to).ok();
        connected.is_some()
    });
    connected.unwrap()
}

#[test]
fn detections_in_degrees_become_tracks_through_a_killed_feed_and_a_second_feed_is_refused() {
    let home = Home::new();
    let running = site(&home);
    let address = free_address();
    let text = address.to_string();
    let arguments = [
        "feed",
        "--instance",
        "test",
        "--source",
        "own",
        "--tcp",
        &text,
        "--json",
    ];
    let first = home.start(&arguments);
    let mut stream = connect(address);
    let mut answers = BufReader::new(stream.try_clone().unwrap());
    let steps = feed_until_confirmed(&home, 0, |lines| stream.write_all(lines.as_bytes()).unwrap());
    stream
        .write_all(b"{\"latitude\": 91, \"longitude\": 2, \"sigma_m\": 10}\n")
        .unwrap();
    let mut answer = String::new();
    answers.read_line(&mut answer).unwrap();
    let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
    assert_eq!(
        (answer["line"].as_u64(), answer["field"].as_str()),
        (Some((steps * TARGETS) as u64 + 1), Some("latitude"))
    );
    assert!(answer["remedy"].as_str().unwrap().contains("exchanged"), "{answer}");
    // A source has one publisher.
    let other = free_address().to_string();
    let second = home.run(&["feed", "--instance", "test", "--source", "own", "--tcp", &other]);
    let said = String::from_utf8(second.stderr).unwrap();
    assert_eq!(second.status.code(), Some(1), "{said}");
    assert!(
        said.contains("has a publisher already") && said.contains(&first.pid().to_string()),
        "{said}"
    );
    running.until_said("own has a second publisher");
    // The successor of a killed one is accepted at once: without a pause and a second attempt.
    kill(first.pid(), Signal::KILL);
    first.end();
    drop((stream, answers));
    let other = free_address();
    let third = home.start(&[
        "feed",
        "--instance",
        "test",
        "--source",
        "own",
        "--tcp",
        &other.to_string(),
        "--json",
    ]);
    let mut stream = connect(other);
    feed_until_confirmed(&home, steps, |lines| stream.write_all(lines.as_bytes()).unwrap());
    drop(stream);
    let (status, said) = third.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    running.stop();
    home.assert_nothing_is_left("test");
}

#[test]
fn datagrams_and_standard_input_feed_too_and_refusals_are_counted_by_field() {
    let home = Home::new();
    let running = site(&home);
    let address = free_address().to_string();
    let feed = home.start(&["feed", "--instance", "test", "--udp", &address, "--json"]);
    feed.until_said("listening at");
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let lines = |lines: &str| {
        let named: Vec<String> = lines
            .lines()
            .map(|line| line.replacen('{', "{\"source\": \"own\", ", 1))
            .collect();
        named.join("\n")
    };
    feed_until_confirmed(&home, 0, |text| {
        socket.send_to(lines(text).as_bytes(), &address).unwrap();
    });
    // By standard input, to another source beside it; a line is answered there.
    let mut command = home.command(&["feed", "--instance", "test", "--source", "tracks", "--json"]);
    let mut child = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let good = "{\"track\": 1, \"latitude\": 41.5, \"longitude\": 2.1, \"sigma_m\": 30}";
    let in_seconds = format!(
        "{{\"track\": 1, \"latitude\": 41.5, \"longitude\": 2.1, \"sigma_m\": 30, \"time_ns\": {}}}",
        utc_ns() / 1_000_000_000
    );
    write!(input, "{good}\n{in_seconds}\n\n{good}\nnonsense\n").unwrap();
    drop(input);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    let said: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(
        (said[0]["line"].as_u64(), said[0]["field"].as_str()),
        (Some(2), Some("time_of_measurement_ns"))
    );
    assert!(
        said[0]["remedy"]
            .as_str()
            .unwrap()
            .contains("in seconds; multiply it by 1000000000"),
        "{text}"
    );
    assert_eq!(
        (said[1]["line"].as_u64(), said[1]["field"].as_str()),
        (Some(5), Some("line"))
    );
    assert_eq!(
        (said[2]["published"].as_u64(), said[2]["refused"].as_u64()),
        (Some(2), Some(2))
    );
    for wrong in ["{\"source\": \"own\"}", "{\"source\": \"nobody\"}"] {
        socket.send_to(wrong.as_bytes(), &address).unwrap();
    }
    socket.send_to(lines(&scan(0)).as_bytes(), &address).unwrap();
    running.until_said("refuses lines or connections for own: latitude 1; latitude is missing");
    let (status, said) = feed.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    running.stop();
    home.assert_nothing_is_left("test");
}

/// Most connections of an address.
const ADDRESS_MAX: usize = net::DoorLimits::OF_SENDERS.address_max;

/// The answer to a wrong line in a new connection, or to the connection.
fn answer_to_nonsense(address: SocketAddr) -> (TcpStream, String) {
    let mut stream = connect(address);
    stream.write_all(b"nonsense\n").unwrap();
    let mut answer = String::new();
    BufReader::new(&stream).read_line(&mut answer).unwrap();
    (stream, answer)
}

#[test]
fn a_connection_too_many_is_answered_before_it_is_closed_and_accepted_once_there_is_a_place() {
    let home = Home::new();
    let running = site(&home);
    let address = free_address();
    let text = address.to_string();
    let feed = home.start(&["feed", "--instance", "test", "--source", "own", "--tcp", &text]);
    let mut served = Vec::new();
    for _ in 0..ADDRESS_MAX {
        let (stream, answer) = answer_to_nonsense(address);
        assert!(answer.contains("must be JSON"), "{answer}");
        served.push(stream);
    }
    // With lines under way, which would lose the answer in a connection that is closed at once.
    let mut one_more = TcpStream::connect(address).unwrap();
    one_more.write_all(scan(0).repeat(100).as_bytes()).unwrap();
    let answers: Vec<String> = BufReader::new(one_more).lines().map(Result::unwrap).collect();
    let [answer] = &answers[..] else { panic!("{answers:?}") };
    let answer: serde_json::Value = serde_json::from_str(answer).unwrap();
    assert_eq!(
        answer["limit"], "must be at most 64 connections at a time, 32 of them from one address",
        "{answer}"
    );
    assert!(answer["remedy"].as_str().unwrap().contains("end another"), "{answer}");
    drop(served.pop());
    until("a place is free", || {
        answer_to_nonsense(address).1.contains("must be JSON")
    });
    feed.stop();
    running.stop();
    home.assert_nothing_is_left("test");
}

#[test]
fn silent_connections_keep_nobody_out_end_in_time_and_are_counted_with_the_last_peer() {
    let home = Home::new();
    let running = site(&home);
    let address = free_address();
    let text = address.to_string();
    let arguments = [
        "feed",
        "--instance",
        "test",
        "--source",
        "own",
        "--tcp",
        &text,
        "--json",
    ];
    let feed = home.start(&arguments);
    let mut silent = vec![connect(address)];
    // The end of a line is part of it.
    silent[0].write_all(b"{\"latitude\": 41").unwrap();
    silent.extend((1..300).map(|_| connect(address)));
    let (_speaks, answer) = answer_to_nonsense(address);
    assert!(answer.contains("must be JSON"), "{answer}");
    // The first ones gave way at once, the last ones have the time for a first line.
    for (place, expected) in [(0, "before others need the place"), (299, "a first line within 10 s")] {
        let answers: Vec<String> = BufReader::new(&silent[place]).lines().map(Result::unwrap).collect();
        assert!(
            answers.len() == 1 && answers[0].contains(expected),
            "{place}: {answers:?}"
        );
    }
    let last = silent[299].local_addr().unwrap().to_string();
    running.until_said("connection gave-way ");
    running.until_said("connection silent ");
    feed.until_said("connections refused or ended: gave-way ");
    let summary = Arc::clone(&feed.stdout);
    let (status, said) = feed.stop();
    assert_eq!(status.code(), Some(1), "no line was accepted: {said}");
    let summary: serde_json::Value = serde_json::from_str(&summary.lock().unwrap()).unwrap();
    let refused = &summary["refused_connections"];
    let gave_way = 301 - ADDRESS_MAX as u64;
    assert_eq!(
        (refused["gave-way"].as_u64(), refused["silent"].as_u64()),
        (Some(gave_way), Some(300 - gave_way)),
        "{summary}"
    );
    assert_eq!(
        summary["last_refused_connection"]["peer"].as_str(),
        Some(&*last),
        "{summary}"
    );
    running.stop();
    home.assert_nothing_is_left("test");
}

#[test]
fn a_publisher_that_comes_beside_another_unasked_raises_an_alarm() {
    let home = Home::new();
    let running = site(&home);
    let address = free_address();
    let text = address.to_string();
    let feed = home.start(&["feed", "--instance", "test", "--source", "own", "--tcp", &text]);
    let mut stream = connect(address);
    // As a link does, which asks nobody.
    let bus = Bus::<SharedMemory>::open(&home.root("test"), "link").unwrap();
    let topic = messages::sensor_detections("own.input");
    let mut beside = bus.publisher(&topic, mono_ns() as u64).unwrap();
    until("the alarm is raised", || {
        stream.write_all(scan(0).as_bytes()).unwrap();
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: mono_ns(),
            end: false,
        };
        beside.send(mark, 0, |_, _| SensorDetection::default()).unwrap();
        std::thread::sleep(STEP);
        running
            .said()
            .contains("own has a second publisher: two processes publish")
    });
    drop((beside, bus, stream));
    feed.stop();
    running.stop();
    home.assert_nothing_is_left("test");
}

#[test]
fn what_cannot_be_fed_is_refused_with_what_can() {
    let home = Home::new();
    let running = site(&home);
    for (arguments, expected) in [
        (&["--source", "nobody"][..], "own, tracks"),
        (&["--tcp", "0.0.0.0:0"], "--remote"),
        (&["--tcp", "0", "--senders", "nobody"], "--senders"),
    ] {
        let refused = home.run(&[&["feed", "--instance", "test"], arguments].concat());
        let said = String::from_utf8(refused.stderr).unwrap();
        assert_eq!(refused.status.code(), Some(2), "{said}");
        assert!(said.contains(expected) || said.contains("tracks, own"), "{said}");
    }
    running.stop();
    home.assert_nothing_is_left("test");
}

/// Feeds a line to a source of tracks until a reader has it; returns what `koseki tap` writes of it.
fn fed_and_tapped(home: &Home, source: &str, line: &str) -> String {
    let topic = format!("sensor/{source}/tracks");
    let mut tap = home.command(&["tap", &topic, "--instance", "test", "--count", "1"]);
    let mut tap = tap.stdout(Stdio::piped()).spawn().unwrap();
    let mut feed = home.command(&["feed", "--instance", "test", "--source", source]);
    let mut feed = feed.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut input = feed.stdin.take().unwrap();
    until("the line is tapped", || {
        writeln!(input, "{line}").unwrap();
        tap.try_wait().unwrap().is_some()
    });
    drop(input);
    let fed = feed.wait_with_output().unwrap();
    assert_eq!(fed.status.code(), Some(0), "{fed:?}");
    let output = tap.wait_with_output().unwrap();
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn a_tapped_line_is_fed_again_with_every_field() {
    let home = Home::new();
    let [latitude, longitude] = PLACE;
    let text = format!(
        "name = \"t\"\n[frame]\nlatitude_deg = {latitude}\nlongitude_deg = {longitude}\n[[source]]\nname = \"one\"\n\
         [source.external]\n[[source]]\nname = \"two\"\n[source.external]\n[recorder]\nenabled = false\n[display]\n\
         listen = \"off\"\n"
    );
    fs::write(home.path("site.toml"), text).unwrap();
    let running = home.start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
    running.until_said("instance test runs");
    for (identity, expected) in [
        (
            r#""mmsi": 2275400, "name": "QUEEN, MARY 2""#,
            [("address", None), ("mmsi", Some("002275400")), ("mode_3a", None)],
        ),
        (
            r#""address": "873f5f", "mode_3a": "2300", "callsign": "KOS 1""#,
            [("address", Some("873F5F")), ("mmsi", None), ("mode_3a", Some("2300"))],
        ),
    ] {
        let line = format!(
            "{{\"track\": 7, \"latitude\": {latitude}, \"longitude\": {longitude}, \"height_m\": 900, \"sigma_m\": 30, \
             \"speed_mps\": 70, \"course_deg\": 30, \"climb_mps\": 1.5, \"velocity_sigma_mps\": 3, {identity}}}"
        );
        let first = fed_and_tapped(&home, "one", &line);
        let second = fed_and_tapped(&home, "two", first.trim_end());
        let [mut first, mut second] =
            [first, second].map(|line| serde_json::from_str::<serde_json::Value>(&line).unwrap());
        for (key, value) in expected {
            assert_eq!(first["identity"][key].as_str(), value, "{first}");
        }
        assert_eq!([&first["source"], &second["source"]], ["one", "two"]);
        // What its publisher fills in.
        for state in [&mut first, &mut second] {
            let fields = state.as_object_mut().unwrap();
            for name in ["source", "sequence", "stages"] {
                fields.remove(name).unwrap();
            }
        }
        assert_eq!(first, second);
    }
    running.stop();
    home.assert_nothing_is_left("test");
}

/// Speed of a track that is fed without a velocity, m/s.
const SPEED_MPS: f64 = 60.0;

/// Feeds positions of a target that flies east until fusion has published some states of four reports and more; each
/// must be right within three stated standard deviations.
fn feed_positions(home: &Home, track: u32, mut send: impl FnMut(&str)) {
    let bus = Bus::<SharedMemory>::open(&home.root("test"), "picture").unwrap();
    let mut tracks: Subscriber<SharedMemory, SystemTrack> =
        bus.subscriber(&messages::system_tracks(), || mono_ns() as u64).unwrap();
    let (begin_ns, north_m) = (utc_ns(), 20e3 * f64::from(track));
    let place_m = |time_ns: i64| SPEED_MPS * (time_ns - begin_ns) as f64 / 1e9;
    let mut judged = 0;
    for _ in 0..STEPS_MAX {
        let time_ns = utc_ns();
        send(&format!(
            "{{\"source\": \"tracks\", \"track\": {track}, \"time_ns\": {time_ns}, \"east_m\": {}, \"north_m\": {north_m}, \
             \"sigma_m\": 15}}\n",
            place_m(time_ns)
        ));
        std::thread::sleep(STEP);
        tracks
            .take(usize::MAX, |_, states| {
                let of_target =
                    |state: &&SystemTrack| (state.position_m[1] - north_m).abs() < 5e3 && state.updates >= 4;
                for state in states.iter().filter(of_target) {
                    let error_m = state.position_m[0] - place_m(state.reference_time_ns);
                    let sigma_m = state.covariance.get(0, 0).sqrt();
                    assert!(error_m.abs() <= 3.0 * sigma_m, "{error_m} m at {sigma_m} m: {state:?}");
                    assert_eq!(state.height_valid, 0);
                    judged += 1;
                }
            })
            .unwrap();
        if judged >= 12 {
            return;
        }
    }
    panic!("{judged} states");
}

#[test]
fn positions_without_a_velocity_are_fused_as_of_a_target_that_moves() {
    let home = Home::new();
    let running = site(&home);
    let address = free_address();
    let text = address.to_string();
    let feed = home.start(&["feed", "--instance", "test", "--source", "tracks", "--tcp", &text]);
    let mut stream = connect(address);
    feed_positions(&home, 1, |line| stream.write_all(line.as_bytes()).unwrap());
    drop(stream);
    feed.stop();
    let address = free_address();
    let text = address.to_string();
    let feed = home.start(&["feed", "--instance", "test", "--source", "tracks", "--udp", &text]);
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    // What comes before it listens is lost.
    feed_positions(&home, 2, |line| _ = socket.send_to(line.as_bytes(), address).unwrap());
    feed.stop();
    running.stop();
    home.assert_nothing_is_left("test");
}

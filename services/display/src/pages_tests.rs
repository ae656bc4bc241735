//! Tests of the display's server over real sockets.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::AtomicI64;
use std::time::Duration;

use messages::layout::Sample as _;
use messages::picture::{PictureHeader, PictureIdentity, PictureSensorTrack, PictureTrack, picture_bits};
use messages::{
    BatchHeader, Contribution, FrameOrigin, Identity, SensorTrack, SystemTrack, TrackState, contribution_bits,
};
use serde_json::{Value, json};
use web::{Guard, Server};

use super::*;
use crate::moments::Moments;
use crate::seat::PAGES_MAX;
use crate::settings::MapFiles;
use crate::world::SourceFact;

/// Time limit of a test for an expected event.
pub(crate) const LONG: Duration = Duration::from_secs(30);

pub(crate) fn now() -> Now {
    Now {
        mono_ns: 5_000_000_000,
        utc_ns: 1_700_000_000_000_000_000,
    }
}

/// World of two tracks, and its server.
fn served() -> (Arc<SharedState>, Server) {
    served_at(now)
}

/// World of two tracks and its server, at the time of `clock`.
fn served_at(clock: fn() -> Now) -> (Arc<SharedState>, Server) {
    let sources = vec![SourceFact {
        source: deployment::SourceFacts {
            number: 0,
            name: "radar".to_owned(),
            adapter: "radar".to_owned(),
            sensor_of: None,
            is_external: false,
            silent_after_ns: None,
            period_ns: 1_000_000_000,
            north_offset_rad: None,
        },
        kind: "radar",
        site_m: Some([100.0, 200.0]),
    }];
    let mut world = World::new("test", sources, 600, 1_000_000);
    world.place(&FrameOrigin {
        latitude_deg: 41.0,
        longitude_deg: 2.0,
        height_m: 0.0,
    });
    world.receive(&header(1), &[track(7, 1_000.0), track(9, -1_000.0)], now());
    let shared = SharedState::new(world, MapFiles::default(), clock);
    let router = router(Moments::of_deployment(Arc::clone(&shared)));
    let server = Server::start("pages", "127.0.0.1:0".parse().unwrap(), Guard::default(), router).unwrap();
    (shared, server)
}

pub(crate) fn header(incarnation: u64) -> BatchHeader {
    BatchHeader {
        incarnation,
        ..BatchHeader::default()
    }
}

pub(crate) fn track(number: u32, east_m: f64) -> SystemTrack {
    let mut track = SystemTrack {
        track_number: number,
        reference_time_ns: now().utc_ns,
        state: TrackState::Confirmed as u8,
        position_m: [east_m, 2_000.0, 300.0],
        velocity_mps: [100.0, 0.0, 0.0],
        height_valid: 1,
        velocity_valid: 1,
        contribution_count: 1,
        source_count: 1,
        selected_source: 0,
        identity: Identity::default().with_address(0x4c_a7b3).with_callsign(*b"KOSEKI1 "),
        ..SystemTrack::default()
    };
    track.contributions[0] = Contribution {
        weight: 1.0,
        accuracy: 0.1 + 0.2,
        track_number: 3,
        origin: 7,
        flags: contribution_bits::CENTRE | contribution_bits::FRESH,
        time_of_measurement_ns: now().utc_ns - 250_000_000,
        ..Contribution::default()
    };
    track
}

/// The clocks of `now`, this number of seconds later.
pub(crate) fn later(seconds: i64) -> Now {
    Now {
        mono_ns: now().mono_ns + seconds * 1_000_000_000,
        utc_ns: now().utc_ns + seconds * 1_000_000_000,
    }
}

#[test]
fn in_the_past_every_layer_shows_one_moment() {
    let mut world = World::new("test", Vec::new(), 600, 1_000_000);
    for second in [0, 40, 80] {
        let (then, east_m) = (later(second), 100.0 * second as f64);
        let report = SensorTrack {
            time_of_measurement_ns: then.utc_ns,
            track_number: 3,
            position_m: [east_m, 0.0, 0.0],
            ..SensorTrack::default()
        };
        let state = SystemTrack {
            reference_time_ns: then.utc_ns,
            ..track(7, east_m + 10.0)
        };
        world.hear_sensor_tracks(&[report], then);
        world.receive(&header(1), &[state], then);
        world.clean_up(then);
    }
    let mut viewer = Viewer::default();
    let mut shown = |wish: &str| {
        viewer.wish(Wish::read(wish).unwrap(), later(90));
        let octets = viewer.picture(&world, later(90));
        let (head, rest) = octets.split_at(size_of::<PictureHeader>());
        let head = PictureHeader::of_octets(head).unwrap();
        let (tracks, rest) = rest.split_at(size_of::<PictureTrack>() * head.tracks as usize);
        let identities = size_of::<PictureIdentity>() * head.identities as usize;
        let (reports, rest) =
            rest[identities..].split_at(size_of::<PictureSensorTrack>() * head.sensor_tracks as usize);
        assert!(
            rest.is_empty() && head.flags & picture_bits::FULL != 0,
            "a leap leaves nothing: {head:?}"
        );
        let told = details::selected(&world, &viewer, head.time_ns);
        let part = &told["tracks"][0]["contributions"][0];
        (
            PictureTrack::of_octets(tracks).map(|track| track.east_m),
            PictureSensorTrack::of_octets(reports).map(|report| report.east_m),
            part["position_m"][0].as_f64(),
        )
    };
    let past = |seconds: i64| {
        let time_s = details::seconds(later(seconds).utc_ns);
        format!(r#"{{"layers": ["sensor_tracks"], "select": [7], "past": {{"time_s": {time_s}, "speed": 0}}}}"#)
    };
    assert_eq!(shown(&past(41)), (Some(4_010.0), Some(4_000.0), Some(4_000.0)));
    assert_eq!(shown(&past(1)), (Some(10.0), Some(0.0), Some(0.0)), "back");
    assert_eq!(shown(&past(81)), (Some(8_010.0), Some(8_000.0), Some(8_000.0)), "ahead");
    assert_eq!(
        shown(&past(79)),
        (Some(4_010.0), None, None),
        "its report is older than the layer shows"
    );
    assert_eq!(
        shown(r#"{"past": null}"#),
        (Some(8_010.0), Some(8_000.0), Some(8_000.0)),
        "now"
    );
}

/// States and reports that are older than the configured time are dropped.
#[test]
fn the_past_reaches_back_for_the_configured_time() {
    let past = |history_s: i64| {
        let mut world = World::new("test", Vec::new(), history_s, 1_000_000);
        for second in (0..=120).step_by(10) {
            let then = later(second);
            let state = SystemTrack {
                reference_time_ns: then.utc_ns,
                ..track(7, 0.0)
            };
            world.receive(&header(1), &[state], then);
            world.clean_up(then);
        }
        let span_ns = world.span_ns().unwrap();
        span_ns.map(|at_ns| (at_ns - now().utc_ns) / 1_000_000_000)
    };
    assert_eq!(past(600), [0, 120]);
    assert_eq!(past(50), [70, 120]);
}

#[test]
fn the_clock_is_the_machines_and_an_offset_of_the_data_is_told() {
    let mut world = World::new("test", Vec::new(), 600, 1_000_000);
    let ahead = SystemTrack {
        reference_time_ns: later(7).utc_ns,
        ..track(7, 0.0)
    };
    world.receive(&header(1), &[ahead], now());
    assert_eq!(world.time_ns(later(1)), later(1).utc_ns);
    let told = status::status(&world, status::Audience::default(), later(1));
    assert_eq!(told["data_offset_s"], json!(7.0));
    world.receive(&header(1), &[track(9, 0.0)], later(20));
    let told = status::status(&world, status::Audience::default(), later(20));
    assert_eq!(told["data_offset_s"], json!(-20.0), "and when it is gone, it is gone");
    assert_eq!(told["replay"], json!(false));
    // With recorded inputs, the picture has data time.
    world.set_clock(crate::clock::PictureClock::of(true));
    world.receive(&header(1), &[ahead], later(20));
    assert_eq!(world.time_ns(later(21)), later(8).utc_ns);
    let told = status::status(&world, status::Audience::default(), later(21));
    assert_eq!((&told["data_offset_s"], &told["replay"]), (&json!(null), &json!(true)));
}

fn ask(server: &Server, request: &str) -> (String, Vec<u8>) {
    let mut stream = TcpStream::connect(server.address()).unwrap();
    stream.set_read_timeout(Some(LONG)).unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let end = answer.windows(4).position(|octets| octets == b"\r\n\r\n").unwrap() + 4;
    let text = String::from_utf8_lossy(&answer[..end]).to_lowercase();
    (text, answer.split_off(end))
}

fn get_json(server: &Server, path: &str) -> Value {
    let (head, body) = ask(server, &format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n"));
    assert!(head.starts_with("http/1.1 200"), "{path}: {head}");
    serde_json::from_slice(&body).unwrap()
}

/// Page that implements WebSocket by hand.
pub(crate) struct Socket(TcpStream);

impl Socket {
    fn open(server: &Server) -> Result<Self, String> {
        Self::open_at(server, "/ws", "")
    }

    /// Opens the WebSocket at `path`, with further lines of the request's head.
    pub(crate) fn open_at(server: &Server, path: &str, lines: &str) -> Result<Self, String> {
        let mut stream = TcpStream::connect(server.address()).unwrap();
        stream.set_read_timeout(Some(LONG)).unwrap();
        let request = format!(
            "GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n{lines}\r\n"
        );
        stream.write_all(request.as_bytes()).unwrap();
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            let mut octet = [0];
            stream.read_exact(&mut octet).unwrap();
            head.push(octet[0]);
        }
        let head = String::from_utf8_lossy(&head).into_owned();
        if head.starts_with("HTTP/1.1 101") {
            Ok(Self(stream))
        } else {
            Err(head)
        }
    }

    /// Returns the next message: its kind and content. `None` at the end.
    pub(crate) fn receive(&mut self) -> Option<(u8, Vec<u8>)> {
        let mut head = [0; 2];
        self.0.read_exact(&mut head).ok()?;
        let length = match head[1] {
            126 => self.number::<2>()?,
            127 => self.number::<8>()?,
            short => u64::from(short),
        };
        let mut octets = vec![0; length as usize];
        self.0.read_exact(&mut octets).ok()?;
        Some((head[0] & 15, octets))
    }

    fn number<const OCTETS: usize>(&mut self) -> Option<u64> {
        let mut octets = [0; OCTETS];
        self.0.read_exact(&mut octets).ok()?;
        Some(octets.iter().fold(0, |number, octet| number << 8 | u64::from(*octet)))
    }

    /// Returns the next text of this type; pictures before it are skipped.
    fn until(&mut self, kind: &str) -> Value {
        loop {
            let (code, octets) = self.receive().expect("the server is there");
            if code == 1 {
                let value: Value = serde_json::from_slice(&octets).unwrap();
                if value["type"] == kind {
                    return value;
                }
            }
        }
    }

    fn picture(&mut self) -> (PictureHeader, Vec<u8>) {
        loop {
            let (code, mut octets) = self.receive().expect("the server is there");
            if code == 2 {
                let rest = octets.split_off(PictureHeader::LAYOUT.size);
                return (PictureHeader::of_octets(&octets).unwrap(), rest);
            }
        }
    }

    fn send(&mut self, code: u8, octets: &[u8]) {
        let mut frame = vec![0x80 | code];
        match octets.len() {
            short @ ..126 => frame.push(0x80 | short as u8),
            long => {
                frame.push(0x80 | 126);
                frame.extend((long as u16).to_be_bytes());
            }
        }
        // The mask is 0.
        frame.extend([0; 4]);
        frame.extend(octets);
        // The server may have closed already.
        let _ = self.0.write_all(&frame);
    }

    pub(crate) fn wish(&mut self, wish: &Value) {
        self.send(1, wish.to_string().as_bytes());
    }
}

pub(crate) fn until(what: &str, condition: impl Fn() -> bool) {
    for _ in 0..3_000 {
        if condition() {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("{what}");
}

#[test]
fn a_page_gets_all_tracks_then_what_has_changed_once_it_has_acknowledged() {
    let (shared, server) = served();
    let mut page = Socket::open(&server).unwrap();
    let hello = page.until("hello");
    assert_eq!(
        (&hello["instance"], &hello["origin"]["latitude_deg"]),
        (&json!("test"), &json!(41.0))
    );
    assert_eq!(hello["labels"]["lines"][1], json!(["level", "speed"]));
    let (header, records) = page.picture();
    assert_eq!(
        (header.flags & picture_bits::FULL, header.tracks, header.identities),
        (1, 2, 2)
    );
    let first = PictureTrack::of_octets(&records[..64]).unwrap();
    assert_eq!((first.number, first.east_m, first.measured_age_ms), (7, 1_000.0, 250));
    shared.world().receive(&self::header(1), &[track(7, 1_100.0)], now());
    page.wish(&json!({"ack": header.sequence, "rate_hz": 10, "select": [7]}));
    let (header, records) = page.picture();
    assert_eq!(
        (header.flags & picture_bits::FULL, header.tracks, header.identities),
        (0, 1, 0)
    );
    assert_eq!(PictureTrack::of_octets(&records[..64]).unwrap().east_m, 1_100.0);
    let history = page.until("history");
    assert_eq!(history["rows"].as_array().unwrap().len(), 2);
    let selected = page.until("selected");
    let part = &selected["tracks"][0]["contributions"][0];
    assert_eq!(
        (&part["weight"], &part["accuracy"], &part["name"]),
        (&json!(1.0), &json!(0.1 + 0.2), &json!("radar"))
    );
    assert_eq!(
        (&part["centre"], &part["origin"], &part["fresh"]),
        (&json!(true), &json!(7), &json!(true))
    );
    let ended = SystemTrack {
        state: TrackState::Terminated as u8,
        ..track(9, 0.0)
    };
    shared.world().receive(&self::header(1), &[ended], now());
    page.wish(&json!({"ack": header.sequence, "view": [0, 0, 5000, 5000]}));
    let (header, records) = page.picture();
    assert_eq!((header.removed, header.tracks), (1, 0));
    assert_eq!(records[..4], 9_u32.to_le_bytes());
    page.wish(&json!({"ack": header.sequence, "filter": {"text": "nobody"}}));
    let (header, records) = page.picture();
    assert_eq!((header.removed, &records[..4]), (1, &7_u32.to_le_bytes()[..]));
    page.wish(&json!({"ack": header.sequence, "filter": null, "past": {"time_s": 1_700_000_000, "speed": 0}}));
    let (header, _) = page.picture();
    let flags = picture_bits::FULL | picture_bits::PAST | picture_bits::PAUSED;
    assert_eq!(
        (header.flags & flags, header.tracks),
        (flags, 1),
        "the past, in what is in view"
    );
}

#[test]
fn a_page_that_does_not_acknowledge_is_sent_nothing_and_disturbs_nobody() {
    let (shared, server) = served();
    let deaf = Socket::open(&server).unwrap();
    let mut page = Socket::open(&server).unwrap();
    for _ in 0..5 {
        let (header, _) = page.picture();
        page.wish(&json!({"ack": header.sequence, "rate_hz": 10}));
    }
    until("skipped pictures are counted", || {
        shared.traffic.skipped.load(Ordering::Relaxed) > 0
    });
    drop((deaf, page));
    until("seats are free again", || {
        shared.traffic.pages.load(Ordering::Relaxed) == 0
    });
}

#[test]
fn a_page_that_acknowledges_nothing_for_long_is_left_and_counted() {
    static PASSED_NS: AtomicI64 = AtomicI64::new(0);
    fn later() -> Now {
        Now {
            mono_ns: now().mono_ns + PASSED_NS.load(Ordering::Relaxed),
            ..now()
        }
    }
    let (shared, server) = served_at(later);
    let mut deaf = Socket::open(&server).unwrap();
    deaf.picture();
    PASSED_NS.store(PATIENCE.as_nanos() as i64 - 1_000_000_000, Ordering::Relaxed);
    let mut page = Socket::open(&server).unwrap();
    let (header, _) = page.picture();
    page.wish(&json!({"ack": header.sequence}));
    page.picture();
    assert_eq!(shared.traffic.pages.load(Ordering::Relaxed), 2, "it is waited for");
    PASSED_NS.fetch_add(2_000_000_000, Ordering::Relaxed);
    while deaf.receive().is_some() {}
    until("it is counted", || shared.traffic.refused.load(Ordering::Relaxed) == 1);
    until("only the other is left", || {
        shared.traffic.pages.load(Ordering::Relaxed) == 1
    });
}

#[test]
fn what_no_page_would_say_is_refused_and_counted() {
    let (shared, server) = served();
    let messages: [(u8, Vec<u8>); 5] = [
        (1, b"{\"rate\": 1}".to_vec()),
        (1, vec![b' '; MESSAGE_MAX + 1]),
        (1, vec![0xff, 0xfe]),
        (2, b"{}".to_vec()),
        (7, Vec::new()),
    ];
    for (count, (code, octets)) in (1..).zip(messages) {
        let mut page = Socket::open(&server).unwrap();
        page.send(code, &octets);
        while page.receive().is_some() {}
        until("it is counted", || {
            shared.traffic.refused.load(Ordering::Relaxed) == count
        });
    }
}

#[test]
fn there_are_only_so_many_seats() {
    let (shared, server) = served();
    let pages: Vec<Socket> = (0..PAGES_MAX).map(|_| Socket::open(&server).unwrap()).collect();
    let refused = Socket::open(&server).err().unwrap();
    assert!(refused.starts_with("HTTP/1.1 503"), "{refused}");
    assert_eq!(shared.traffic.refused.load(Ordering::Relaxed), 1);
    drop(pages);
    until("seats are free again", || {
        shared.traffic.pages.load(Ordering::Relaxed) == 0
    });
    assert!(Socket::open(&server).is_ok());
}

#[test]
fn scripts_get_json_and_nothing_but_what_is_there() {
    let (shared, server) = served();
    let tracks = get_json(&server, "/api/tracks.json");
    // A level flight 185 km east and outbound: the plane rises above the target.
    let mut far = SystemTrack {
        level: 1_441,
        level_valid: 1,
        level_age_ms: 1_500,
        ..track(11, 185_000.0)
    };
    let frame = *shared.world().observed.frame().unwrap();
    let vertical = frames::Vertical {
        height_m: 11_000.0,
        climb_mps: 0.0,
    };
    [far.position_m[2], far.velocity_mps[2]] = frame.above([185_000.0, 2_000.0], [100.0, 0.0], vertical);
    assert!(far.position_m[2] < 8_500.0 && far.velocity_mps[2] < -2.0);
    shared.world().receive(&header(1), &[far], now());
    let listed = get_json(&server, "/data/aircraft.json");
    let listed = listed["aircraft"]
        .as_array()
        .unwrap()
        .iter()
        .find(|one| one["alt_baro"] == 36_025.0);
    let listed = listed.expect("by its level");
    assert_eq!(
        (&listed["alt_geom"], listed["geom_rate"].as_f64()),
        (&json!(36_089.0), Some(0.0))
    );
    let told = get_json(&server, "/api/tracks.json");
    let told = &told["tracks"][2];
    assert_eq!((&told["level"], &told["level_age_s"]), (&json!(360.25), &json!(1.5)));
    assert!(
        (told["height_m"].as_f64().unwrap() - 360.25 * 30.48).abs() < 0.01,
        "{told}"
    );
    assert_eq!(tracks["tracks"].as_array().unwrap().len(), 2);
    assert_eq!(get_json(&server, "/api/sources.json")["sources"][0]["name"], "radar");
    assert_eq!(get_json(&server, "/api/history/7.json")["number"], 7);
    let reasoned = get_json(&server, "/api/track/7.json");
    assert_eq!(
        reasoned["contributions"][0]["reason"],
        "The only source with a fresh report."
    );
    assert!(reasoned["decisions_missing"].as_str().unwrap().contains("[display]"));
    assert!(reasoned["rules_missing"].as_str().unwrap().contains("--config"));
    let coverage = get_json(&server, "/api/coverage.json");
    assert_eq!(
        (&coverage["sectors"], &coverage["sources"][0]["site_m"]),
        (&json!(72), &json!([100.0, 200.0]))
    );
    assert_eq!(get_json(&server, "/api/coverage.geojson")["type"], "FeatureCollection");
    let (head, octets) = ask(&server, "GET /api/trails HTTP/1.1\r\nHost: localhost\r\n\r\n");
    // Two tracks with a point each.
    assert!(head.starts_with("http/1.1 200"), "{head}");
    assert!(octets.len() >= 8 + 2 * (8 + 12), "{}", octets.len());
    let path = "/api/trails?until_s=1.0";
    let (_, octets) = ask(&server, &format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n"));
    assert_eq!(octets.len(), 8, "nothing was there");
    let aircraft = get_json(&server, "/data/aircraft.json");
    let one = &aircraft["aircraft"][0];
    assert_eq!((&one["hex"], &one["flight"]), (&json!("4ca7b3"), &json!("KOSEKI1 ")));
    assert!((one["track"].as_f64().unwrap() - 90.0).abs() < 1e-9 && one["lat"].as_f64().unwrap() > 41.0);
    assert_eq!(get_json(&server, "/data/receiver.json")["lat"], 41.0);
    assert_eq!(one["alt_baro"], Value::Null, "no transponder has stated it");
    for path in [
        "/../Cargo.toml",
        "/..%2f..%2fCargo.toml",
        "/%2e%2e/src/lib.rs",
        "//etc/passwd",
        "/api/history/0.json",
        "/api/track/0.json",
        "/api/history/..%2f7.json",
        "/nothing",
    ] {
        let (head, _) = ask(&server, &format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n"));
        assert!(head.starts_with("http/1.1 404"), "{path}: {head}");
    }
    let (head, octets) = ask(&server, "GET /wire.js HTTP/1.1\r\nHost: localhost\r\n\r\n");
    assert!(
        head.contains("content-type: text/javascript") && octets.len() > 1_000,
        "{head}"
    );
}

#[test]
fn rates_and_probable_models_of_a_selected_track_are_in_its_details() {
    let told = |state: SystemTrack| {
        let mut world = World::new("test", Vec::new(), 60, 1_000);
        world.receive(&header(1), &[state], now());
        let mut viewer = Viewer::default();
        viewer.wish(Wish::read(r#"{"select": [7]}"#).unwrap(), now());
        details::selected(&world, &viewer, now().utc_ns)["tracks"][0].clone()
    };
    let known = told(SystemTrack {
        climb_rate_mps: -7.5,
        climb_rate_variance: 0.25,
        turn_rate_radps: -0.052_359_88,
        turn_rate_sigma_radps: 0.008_726_646,
        mode_probabilities: [0.1, 0.0, 0.75, 0.1, 0.05, 0.25, 0.5, 0.25],
        ..track(7, 0.0)
    });
    let number = |key: &str| known[key].as_f64().unwrap();
    assert!((number("turn_rate_dps") + 3.0).abs() < 1e-4 && (number("turn_sigma_dps") - 0.5).abs() < 1e-5);
    assert_eq!(number("climb_sigma_mps"), 0.5);
    assert!(
        known["climb_rate_mps"].is_null(),
        "the height above the ellipsoid needs the frame"
    );
    let modes = json!([{"mode": "left_turn", "probability": 0.75}, {"mode": "climb", "probability": 0.5}]);
    assert_eq!(known["modes"], modes);
    let unknown = told(track(7, 0.0));
    for key in ["climb_rate_mps", "climb_sigma_mps", "turn_rate_dps", "turn_sigma_dps"] {
        assert!(unknown[key].is_null(), "{key}");
    }
    assert_eq!(unknown["modes"], json!([]));
}

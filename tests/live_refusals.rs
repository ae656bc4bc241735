//! Data that an inlet refuses: line or item, value, limit and remedy stand in `koseki status`, and the alarm of the
//! source differs from that of a silent one.

use std::fs;
use std::io::Write as _;
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};

use serde_json::Value;

use crate::common::{Home, PLACE, Running, free_address, until, utc_ns};

/// A way into the deployment, with the name that refusals state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Inlet {
    RowsUdp,
    RowsTcp,
    Bearings,
    Counts,
    Nmea,
    Sbs,
    Asterix,
    FeedUdp,
    FeedTcp,
}

const INLETS: [Inlet; 9] = [
    Inlet::RowsUdp,
    Inlet::RowsTcp,
    Inlet::Bearings,
    Inlet::Counts,
    Inlet::Nmea,
    Inlet::Sbs,
    Inlet::Asterix,
    Inlet::FeedUdp,
    Inlet::FeedTcp,
];

const ROWS: &str = "time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz\n";
const BEARINGS: &str = "time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz\n";
const COUNTS: &str = "time_s,arrival_s,x,y,z,vx,vy,vz,count\n";

/// Planted errors: inlet, what is sent (with `NOW` for the seconds of the day), and words of the refusal.
const PLANTED: [(Inlet, &str, &[&str]); 47] = [
    (
        Inlet::RowsUdp,
        "NOW,1,1,1,range_bearing,1000,0.5,,,15,0.006,,,,,\n",
        &["line 2, column px", "is empty", "write a number"],
    ),
    (
        Inlet::RowsUdp,
        "NOW,1,1,1,range_bearing,x,0.5,,,15,0.006,,,0,0,15\n",
        &["line 2, column m0", "\"x\"", "is no number"],
    ),
    (
        Inlet::RowsUdp,
        "NOW,1,1,1,range_bearing,1000,0.5,,,15,0.006,,,0,0\n",
        &["line 2: 15 values", "16 columns"],
    ),
    (
        Inlet::RowsUdp,
        "NOW,1,1,1,sonar,1000,0.5,,,15,0.006,,,0,0,15\n",
        &["column kind", "\"sonar\""],
    ),
    (
        Inlet::RowsUdp,
        "NOW,1,one,1,range_bearing,1000,0.5,,,15,0.006,,,0,0,15\n",
        &["column scan", "\"one\""],
    ),
    (
        Inlet::RowsUdp,
        "noon,1,1,1,range_bearing,1000,0.5,,,15,0.006,,,0,0,15\n",
        &["column time_s", "\"noon\""],
    ),
    (
        Inlet::RowsTcp,
        "NOW,1,1,1,range_bearing,1000,0.5,,,15,0.006,,,,,\n",
        &["column px", "is empty"],
    ),
    (
        Inlet::RowsTcp,
        "NOW,1,1,1,range_bearing,1000,nan,,,15,0.006,,,0,0,15\n",
        &["column m1", "\"nan\""],
    ),
    (
        Inlet::RowsTcp,
        "NOW;1;1;1;polar;1000;0.5;0;0;15\n",
        &["1 values", "16 columns"],
    ),
    (
        Inlet::RowsTcp,
        "NOW,1,1,1,\u{202e}range_bearing,1000,0.5,,,15,0.006,,,0,0,15\n",
        &["column kind", "\\u{202e}range_bearing"],
    ),
    (
        Inlet::Bearings,
        "NOW,1,east,0.01,0,0,0\n",
        &["column bearing_rad", "\"east\""],
    ),
    (
        Inlet::Bearings,
        "NOW,1,0.5,-0.01,0,0,0\n",
        &["column sigma_rad", "\"-0.01\""],
    ),
    (Inlet::Bearings, "NOW,1,0.5\n", &["3 values", "7 columns"]),
    (
        Inlet::Counts,
        "NOW,NOW,1,2,3,4,5,6,many\n",
        &["column count", "\"many\""],
    ),
    (Inlet::Counts, "NOW,NOW,1,,3,4,5,6,1\n", &["column y", "is empty"]),
    (
        Inlet::Nmea,
        "$GPGGA,120000,4x18.5,N,00206.0,E,1,08,1,10,M,50,M,,*SUM\r\n",
        &["field 2 \"4x18.5\"", "range"],
    ),
    (Inlet::Nmea, "$HEHDT,361.0,T*SUM\r\n", &["field 1 \"361.0\"", "range"]),
    (Inlet::Nmea, "$HEHDT,10.0,T*00\r\n", &["$HEHDT,10.0,T*00", "checksum"]),
    (Inlet::Nmea, "$HEHDT,10.0,T\r\n", &["$HEHDT,10.0,T", "no checksum"]),
    (Inlet::Nmea, "$XXHDT,10.0,T*SUM\r\n", &["$XXHDT", "unknown talker"]),
    (
        Inlet::Nmea,
        "!AIVDM,1,1,,A,13aEOK?P00PD2wVMdLDRhgvL289?,0*26\r\n",
        &["!AIVDM", "begins with $"],
    ),
    (
        Inlet::Nmea,
        "$GPGGA,120000,4118.5,N,00206.0,E,0,08,1,10,M,50,M,,*SUM\r\n",
        &["no valid fix", "antenna"],
    ),
    (
        Inlet::Sbs,
        "MSG,9,1,1,500001,1,,,,,,1000,,,41.4,2.1,,,,,,0\r\n",
        &["value 2 \"9\"", "1 to 8"],
    ),
    (
        Inlet::Sbs,
        "MSG,3,1,1,XYZ,1,,,,,,1000,,,41.4,2.1,,,,,,0\r\n",
        &["value 5 \"XYZ\"", "hexadecimal"],
    ),
    (
        Inlet::Sbs,
        "MSG,3,1,1,500001,1,,,,,,1000,,,91.4,2.1,,,,,,0\r\n",
        &["value 15 \"91.4\"", "-90 to 90"],
    ),
    (
        Inlet::Sbs,
        "MSG,3,1,1,500001,1,2026/13/45,,,,,1000,,,41.4,2.1,,,,,,0\r\n",
        &["value 7", "2026/03/04"],
    ),
    (
        Inlet::Nmea,
        "$GPGGA,120000,0000.0,N,00000.0,E,1,08,1,10,M,50,M,,*SUM\r\n",
        &[
            "the place is 4",
            "km from the frame's origin",
            "range_m of the platform, 1000 km",
        ],
    ),
    (
        Inlet::Sbs,
        "MSG,3,1,1,500001,1,,,,,,1000,,,0.0,0.0,,,,,,0\r\n",
        &[
            "latitude 0.0000, longitude 0.0000 is 4",
            "km from the sensor",
            "limits.range_m, 400 km",
            "raise it",
        ],
    ),
    // The other side of the earth.
    (
        Inlet::Sbs,
        "MSG,3,1,1,500001,1,,,,,,1000,,,-41.3,-177.9,,,,,,0\r\n",
        &["latitude -41.3000, longitude -177.9000 is 127"],
    ),
    (
        Inlet::FeedUdp,
        "{\"source\": \"own\", \"latitude\": 0, \"longitude\": 0, \"sigma_m\": 10}\n",
        &[
            "latitude is 0: with longitude 0 it is 4",
            "at most 2000 km",
            "leave out places that are not known",
        ],
    ),
    (
        Inlet::FeedTcp,
        "{\"source\": \"other\", \"latitude\": 0, \"longitude\": 0, \"sigma_m\": 10}\n",
        &["latitude is 0: with longitude 0 it is 4", "at most 2000 km"],
    ),
    (
        Inlet::FeedUdp,
        "{\"source\": \"own\", \"east_m\": 4e6, \"north_m\": -5e5, \"sigma_m\": 10}\n",
        &["east_m is 4000000: with north_m -500000 it is 4031 km"],
    ),
    (Inlet::Sbs, "hello\r\n", &["line \"hello\"", "MSG, SEL"]),
    (Inlet::Sbs, "MSG,3,1\r\n", &["fewer than the 10 values"]),
    (Inlet::Asterix, "30000a00000000000000", &["FSPEC|record|block|I048"]),
    (Inlet::Asterix, "300002", &["length as 2 octets"]),
    (Inlet::Asterix, "3000ff0102", &["length as 255 octets", "5 left"]),
    (Inlet::Asterix, "f00008010101ffff", &["no table", "240"]),
    (Inlet::Asterix, "300006800101", &["record|item|I048"]),
    // A track of CAT062 at latitude 0, longitude 0.
    (
        Inlet::Asterix,
        "3e00149908000100320000000000000000000007",
        &[
            "latitude 0.0000, longitude 0.0000 is 4",
            "km from the sensor",
            "limits.range_m, 400 km",
        ],
    ),
    (
        Inlet::FeedUdp,
        "{\"source\": \"own\", \"latitude\": 95, \"longitude\": 2.1, \"sigma_m\": 10}\n",
        &["latitude is 95"],
    ),
    (
        Inlet::FeedUdp,
        "{\"source\": \"own\", \"latitude\": \"41\", \"longitude\": 2.1, \"sigma_m\": 10}\n",
        &["latitude is \"41\"", "number"],
    ),
    (
        Inlet::FeedUdp,
        "{\"source\": \"own\", \"time_s\": 5, \"latitude\": 41, \"longitude\": 2.1, \"sigma_m\": 10}\n",
        &["time_of_measurement_ns is 5000000000", "within 600 s"],
    ),
    (
        Inlet::FeedUdp,
        "latitude 41\n",
        &["line is latitude 41", "must be JSON"],
    ),
    (
        Inlet::FeedTcp,
        "{\"source\": \"other\", \"longitude\": 2.1, \"sigma_m\": 10}\n",
        &["latitude"],
    ),
    (
        Inlet::FeedTcp,
        "{\"source\": \"nobody\", \"latitude\": 41, \"longitude\": 2.1, \"sigma_m\": 10}\n",
        &["source is nobody"],
    ),
    (
        Inlet::FeedTcp,
        "{\"source\": \"other\", \"latitude\": 41, \"longitude\": 2.1, \"sigma_m\": 10, \"colour\": 1}\n",
        &["unknown field", "colour is 1"],
    ),
];

/// A deployment with every inlet, and what feeds them.
pub(crate) struct Site {
    pub(crate) running: Running,
    pub(crate) feeds: [Running; 2],
    socket: UdpSocket,
    /// Addresses of the inlets for datagrams, in the order of [`INLETS`].
    ports: Vec<SocketAddr>,
    rows: TcpStream,
    sbs: TcpStream,
    feed: TcpStream,
    /// Dropped after what runs in it.
    pub(crate) home: Home,
}

impl Site {
    pub(crate) fn start() -> Self {
        let home = Home::new();
        let ports: Vec<SocketAddr> = INLETS.iter().map(|_| free_address()).collect();
        let of = |inlet: Inlet| ports[INLETS.iter().position(|other| *other == inlet).unwrap()];
        let (rows, sbs) = (
            TcpListener::bind("127.0.0.1:0").unwrap(),
            TcpListener::bind("127.0.0.1:0").unwrap(),
        );
        let [latitude, longitude] = PLACE;
        let text = format!(
            r#"name = "test"
frame = {{ latitude_deg = {latitude}, longitude_deg = {longitude} }}
recorder = {{ enabled = false }}
display = {{ listen = "off" }}
receiver = [
  {{ name = "lan", udp = {{ listen = "{}" }} }},
  {{ name = "plots", udp = {{ listen = "{}" }} }},
  {{ name = "bearings", udp = {{ listen = "{}" }} }},
  {{ name = "spotter", udp = {{ listen = "{}" }} }},
  {{ name = "lines", tcp = {{ connect = "{}" }} }},
  {{ name = "box", sbs = {{ connect = "{}" }} }},
]
[[source]]
name = "radar"
period_s = 1.0
live = {{ receiver = "lan" }}
[[source]]
name = "base"
period_s = 1.0
live = {{ receiver = "box" }}
covariance = {{ position_sigma_m = 30.0 }}
[[source]]
name = "finder"
period_s = 1.0
live = {{ receiver = "bearings" }}
locator = {{}}
[[source]]
name = "own"
period_s = 1.0
external = {{ input = "detections" }}
[[source]]
name = "other"
period_s = 1.0
external = {{ input = "detections" }}
[[tracker]]
name = "ship"
sensor = [
  {{ name = "lidar", live = {{ receiver = "plots", format = "rows" }} }},
  {{ name = "infrared", live = {{ receiver = "lines", format = "rows" }} }},
]
[[platform]]
name = "boat"
live = {{ udp = {{ listen = "{}" }} }}
[[wide_area_sensor]]
name = "counts"
live = {{ receiver = "spotter" }}
"#,
            of(Inlet::Asterix),
            of(Inlet::RowsUdp),
            of(Inlet::Bearings),
            of(Inlet::Counts),
            rows.local_addr().unwrap(),
            sbs.local_addr().unwrap(),
            of(Inlet::Nmea),
        );
        fs::write(home.path("site.toml"), text).unwrap();
        let running = home.start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
        running.until_said("instance test runs");
        let feed = |how: &str, inlet: Inlet, source: &str| {
            let to = of(inlet).to_string();
            let started = home.start(&["feed", "--instance", "test", "--source", source, how, &to]);
            started.until_said("listening at");
            started
        };
        let feeds = [
            feed("--udp", Inlet::FeedUdp, "own"),
            feed("--tcp", Inlet::FeedTcp, "other"),
        ];
        let (mut rows, sbs) = (rows.accept().unwrap().0, sbs.accept().unwrap().0);
        rows.write_all(ROWS.as_bytes()).unwrap();
        for name in ["lan", "plots", "bearings", "boat", "spotter"] {
            until("the adapters listen", || home.status_row(name).state == "running");
        }
        Self {
            feed: TcpStream::connect(of(Inlet::FeedTcp)).unwrap(),
            home,
            running,
            feeds,
            socket: UdpSocket::bind("127.0.0.1:0").unwrap(),
            ports,
            rows,
            sbs,
        }
    }

    pub(crate) fn send(&mut self, inlet: Inlet, planted: &str) {
        let of_day_s = utc_ns() as f64 * 1e-9 % 86_400.0;
        let text = planted.replace("NOW", &format!("{of_day_s:.3}"));
        let octets = match inlet {
            Inlet::RowsUdp => format!("{ROWS}{text}").into_bytes(),
            Inlet::Bearings => format!("{BEARINGS}{text}").into_bytes(),
            Inlet::Counts => format!("{COUNTS}{text}").into_bytes(),
            Inlet::Asterix => octets_of(&text),
            _ => with_checksum(&text).into_bytes(),
        };
        match inlet {
            Inlet::RowsTcp => self.rows.write_all(&octets).unwrap(),
            Inlet::Sbs => self.sbs.write_all(&octets).unwrap(),
            Inlet::FeedTcp => self.feed.write_all(&octets).unwrap(),
            _ => {
                let to = self.ports[INLETS.iter().position(|other| *other == inlet).unwrap()];
                self.socket.send_to(&octets, to).unwrap();
            }
        }
    }

    fn status(&self) -> Value {
        let output = self.home.run(&["status", "--instance", "test", "--json"]);
        let all: Value = serde_json::from_slice(&output.stdout).unwrap();
        all[0].clone()
    }
}

fn octets_of(digits: &str) -> Vec<u8> {
    let pairs = digits.as_bytes().chunks(2);
    pairs
        .map(|pair| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap())
        .collect()
}

/// A sentence with its checksum in the place of `SUM`.
fn with_checksum(text: &str) -> String {
    let body = text.trim_start_matches('$').split('*').next().unwrap();
    let sum = body.bytes().fold(0, |sum, octet| sum ^ octet);
    text.replace("SUM", &format!("{sum:02X}"))
}

/// The refusals of a status, and its alarms: name or subject, and words.
fn stated(status: &Value) -> String {
    let refused = status["refused"].as_array().unwrap().iter();
    let refused = refused.map(|refused| format!("{}: {}", refused["of"], refused["text"].as_str().unwrap()));
    let alarms = status["alarms"].as_array().unwrap().iter();
    let alarms = alarms.map(|alarm| format!("{} {}", alarm["alarm"], alarm["text"].as_str().unwrap()));
    refused.chain(alarms).collect::<Vec<_>>().join("\n")
}

/// Each of `words` stands there; one of several between bars is enough.
fn has_all(stated: &str, words: &[&str]) -> bool {
    words
        .iter()
        .all(|words| words.split('|').any(|word| stated.contains(word)))
}

#[test]
fn each_planted_error_is_named_with_its_value_and_remedy() {
    let mut site = Site::start();
    let mut left: Vec<_> = PLANTED.to_vec();
    while !left.is_empty() {
        // One for each inlet at a time: each has a place of its own.
        let mut round = Vec::new();
        for inlet in INLETS {
            if let Some(place) = left.iter().position(|(of, ..)| *of == inlet) {
                round.push(left.remove(place));
            }
        }
        let mut seen = String::new();
        let mut missing = round.clone();
        until(&format!("{round:?}"), || {
            for (inlet, planted, _) in &missing {
                site.send(*inlet, planted);
            }
            seen = stated(&site.status());
            missing.retain(|(.., words)| !has_all(&seen, words));
            missing.is_empty()
        });
    }
    // Data arrive at these, and none are silent.
    let status = site.status();
    let alarms = status["alarms"].as_array().unwrap();
    let is_of = |name: &str, alarm: &Value| alarm["text"].as_str().unwrap().contains(name);
    for name in ["lidar", "infrared", "finder"] {
        let of_source: Vec<&Value> = alarms.iter().filter(|alarm| is_of(name, alarm)).collect();
        assert!(
            of_source.iter().all(|alarm| alarm["alarm"] != "source-silent"),
            "{alarms:?}"
        );
    }
    for feed in site.feeds {
        let (ended, said) = feed.stop();
        assert_eq!(ended.code(), Some(1), "nothing was published: {said}");
    }
    let (ended, _) = site.running.stop();
    assert!(ended.success());
    site.home.assert_nothing_is_left("test");
    let report = fs::read_to_string(site.home.path("out/latest/report.json")).unwrap();
    let report: Value = serde_json::from_str(&report).unwrap();
    let of = |name: &str| {
        report["refused"]
            .as_array()
            .unwrap()
            .iter()
            .any(|refused| refused["of"] == name)
    };
    assert!(of("ship.lidar") && of("base") && of("radar"), "{}", report["refused"]);
}

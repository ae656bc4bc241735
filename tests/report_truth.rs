//! Sentences of reports and alarms agree with the counters, for each kind of source and each shipped configuration.
//!
//! The rules stand in `common::report`; every deployment that a test of this program ends is checked by them
//! (`Running::end`). Here are the deployments that have each kind of source and configuration, and reports with planted
//! errors.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;

use asterix::registry;
use frames::SensorFrame;
use messages::{Counter, Covariance, SensorTrack, TrackState, sensor_track_bits as bits};
use net::{Interface, SenderSettings, UdpSender};
use outgoing::{HeightReference, SensorReports};
use serde_json::{Value, json};
use test_support::recordings;

use crate::common::report::findings;
use crate::common::{Home, Running, counter, free_address, repository, system, until, utc_ns};
use crate::live_refusals::{self, Inlet};

/// Sources of a report: recordings, simulated and live sensors.
type Sources = [u64; 3];

/// Ends a deployment, whose report is checked, and returns the report.
fn ended(home: &Home, running: Running) -> Value {
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    report(home)
}

fn report(home: &Home) -> Value {
    serde_json::from_str(&home.read("out/latest/report.json")).unwrap()
}

fn assert_sources(report: &Value, expected: Sources, row: &str) {
    let settings = &report["settings"];
    let named = ["recorded_sources", "simulated_sources", "live_sources"].map(|name| settings[name].as_u64());
    assert_eq!(named, expected.map(Some), "{row}");
}

fn assert_no_alarm(report: &Value, row: &str) {
    assert_eq!(report["alarms"], json!([]), "{row}");
}

fn up(home: &Home, config: &str, arguments: &[&str]) -> Running {
    let config = repository("config").join(config);
    let fixed = ["up", config.to_str().unwrap(), "--instance", "test", "--out", "out"];
    let quiet = ["--set", "display.listen=\"off\"", "--set", "monitor.files=true"];
    home.start(&[&fixed[..], &quiet, arguments].concat())
}

/// Sends until fusion has taken reports of each of these sources.
fn until_taken(home: &Home, sources: &[&str], mut send: impl FnMut()) {
    until(&format!("fusion takes reports of {sources:?}"), || {
        send();
        let top = home.run(&["top", "--instance", "test", "--once", "--json", "--interval", "0.5"]);
        let seen: Value = serde_json::from_slice(&top.stdout).unwrap_or_default();
        let all = seen["sources"].as_array().into_iter().flatten();
        let is_taken = |source: &&Value| source["taken"].as_u64() > Some(0);
        let taken: Vec<&Value> = all.filter(is_taken).map(|source| &source["name"]).collect();
        sources.iter().all(|name| taken.iter().any(|taken| *taken == name))
    });
}

#[test]
fn reports_of_simulated_configurations_are_true() {
    let rows: [(&str, &[&str], Sources); 4] = [
        (
            "demo.toml",
            &["radar-west", "radar-east", "multilateration", "ads-b", "radar-south"],
            [0, 5, 0],
        ),
        ("coast.toml", &["coast-radar", "patrol", "ais"], [0, 3, 0]),
        ("on-board.toml", &["sea"], [0, 1, 0]),
        ("wide-area.toml", &["radar-bow", "radar-stern"], [0, 2, 0]),
    ];
    for (config, taken, sources) in rows {
        let home = Home::new();
        let running = up(&home, config, &[]);
        running.until_said("instance test runs");
        until_taken(&home, taken, || ());
        let report = ended(&home, running);
        assert_sources(&report, sources, config);
        home.assert_nothing_is_left("test");
    }
}

#[test]
fn reports_of_recorded_configurations_are_true() {
    let rows: [(&str, &str, Sources); 2] = [
        ("barcelona.toml", "lebl2016", [3, 0, 0]),
        ("ferry.toml", "autoferry", [4, 0, 0]),
    ];
    for (config, part, sources) in rows {
        let Some(data) = recordings(part) else { continue };
        let home = Home::new();
        let running = up(&home, config, &["--data", data.to_str().unwrap(), "--speed", "max"]);
        let (status, said) = running.end();
        assert_eq!(status.code(), Some(0), "{said}");
        let report = report(&home);
        assert_sources(&report, sources, config);
        assert_no_alarm(&report, config);
        assert!(
            report["picture"]["live_max"].as_u64().is_some_and(|most| most > 0),
            "{config}"
        );
        for source in report["sources"].as_array().unwrap() {
            let of = |label: &str| counter(&source["adapter"], label);
            let rejected: u64 = Counter::of(messages::CounterClass::Rejection)
                .map(|counter| of(counter.label()))
                .sum();
            // Each record is a report, of the sensor itself, or rejected; a tracker makes its own reports.
            let made = of("published") + of("service_messages") + rejected;
            assert!(
                of("detections") > 0 || made == of("records"),
                "{config}: {}",
                source["adapter"]
            );
        }
        home.assert_nothing_is_left("test");
    }
}

/// Reports a target by ASTERIX, as a sensor of this category, SAC and SIC does.
struct Sensor(SensorReports);

impl Sensor {
    fn new(category: u8, [sac, sic]: [u8; 2]) -> Self {
        let (place, system) = system();
        let table = registry::default_edition(category).unwrap();
        let frame = SensorFrame::new(&system, place, 0.0);
        let reports = SensorReports::new(table, sac, sic, frame, system, 1400).unwrap();
        Self(reports.with_height(HeightReference::Barometric))
    }

    fn blocks(&mut self) -> Vec<Vec<u8>> {
        let track = SensorTrack {
            time_of_measurement_ns: utc_ns(),
            track_number: 1,
            valid: bits::VELOCITY | bits::HEIGHT,
            position_m: [8_000.0, -12_000.0, 3_000.0],
            covariance: Covariance::diagonal([20.0; 3], [2.0; 3]),
            state: TrackState::Confirmed as u8,
            ..SensorTrack::default()
        };
        let mut blocks = Vec::new();
        let mut keep = |block: &[u8]| blocks.push(block.to_vec());
        self.0.report(&track, &mut keep);
        self.0.flush(&mut keep);
        blocks
    }
}

/// A multicast group that nobody else uses.
fn group() -> SocketAddr {
    let port = free_address().port();
    SocketAddr::from(([239, 255, (port >> 8) as u8, port as u8], port))
}

/// A configuration with receivers of ASTERIX: its sensors, each with category, SAC and SIC, and place of its receiver;
/// and the sources of fusion.
struct LiveRow {
    config: &'static str,
    sensors: &'static [(u8, [u8; 2], usize)],
    has_lines: bool,
    taken: &'static [&'static str],
    sources: Sources,
}

#[test]
fn reports_of_live_configurations_are_true() {
    let rows = [
        LiveRow {
            config: "live.toml",
            sensors: &[(48, [0, 1], 0), (48, [0, 2], 0), (20, [0, 3], 1)],
            has_lines: true,
            taken: &["radar-north", "radar-south", "multilateration", "ads-b"],
            sources: [0, 0, 4],
        },
        LiveRow {
            config: "load.toml",
            sensors: &[(48, [25, 1], 0), (20, [25, 2], 1)],
            has_lines: false,
            taken: &["radar", "multilateration"],
            sources: [0, 0, 2],
        },
    ];
    for row in rows {
        let home = Home::new();
        let receivers = [group(), group()];
        let mut settings = vec![format!("gateway[0].send_to=\"{}\"", group())];
        settings.extend((0..2).map(|place| format!("receiver[{place}].udp.listen=\"{}\"", receivers[place])));
        let feed = row.has_lines.then(|| {
            let lines = free_address();
            settings.push(format!("receiver[2].sbs.connect=\"{lines}\""));
            let line = |second: usize| {
                let stamp = format!("2026/11/29,12:00:{second:02}.000");
                format!("MSG,3,1,1,4CA2D6,1,{stamp},{stamp},,10000,,,41.5,2.3,,,0,0,0,0\r\n")
            };
            home.write("aircraft.sbs", (0..60).map(line).collect::<String>());
            home.start(&["send", "aircraft.sbs", "--to", &lines.to_string(), "--retime", "now"])
        });
        let sets: Vec<&str> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
        let running = up(&home, row.config, &sets);
        running.until_said("instance test runs");
        let sender = |to| {
            let interface = Some(Interface::Address(Ipv4Addr::LOCALHOST.into()));
            UdpSender::open(&SenderSettings {
                interface,
                ..SenderSettings::new(to)
            })
        };
        let mut senders = receivers.map(|to| sender(to).unwrap());
        let sensors = row.sensors.iter();
        let mut sensors: Vec<_> = sensors
            .map(|(category, codes, to)| (Sensor::new(*category, *codes), *to))
            .collect();
        until_taken(&home, row.taken, || {
            for (sensor, to) in &mut sensors {
                for block in sensor.blocks() {
                    senders[*to].send(&block).unwrap();
                }
            }
        });
        let report = ended(&home, running);
        if let Some(feed) = feed {
            feed.stop();
        }
        assert_sources(&report, row.sources, row.config);
        home.assert_nothing_is_left("test");
    }
}

/// One deployment with each kind of source: the inlet, what is good there (`TURN` counts, `NOW` is the second of the
/// day), and the counter that shows that it came, of a source, or of a process with no source.
const KINDS: [(Inlet, &str, &str, &str); 9] = [
    (Inlet::Asterix, "", "radar", "published"),
    (
        Inlet::Sbs,
        "MSG,3,1,1,4CA2D6,1,DATE,DATE,,10000,,,41.5,2.3,,,0,0,0,0\r\n",
        "base",
        "published",
    ),
    (
        Inlet::RowsUdp,
        "NOW,1,TURN,1,range_bearing,1000,0.5,,,15,0.006,,,0,0,15\n",
        "ship.lidar",
        "published",
    ),
    (
        Inlet::RowsTcp,
        "NOW,2,TURN,1,range_bearing,1000,0.5,,,15,0.006,,,0,0,15\n",
        "ship.infrared",
        "published",
    ),
    (Inlet::Bearings, "NOW,1,0.5,0.01,TURN,0,0\n", "finder", "records"),
    (
        Inlet::Counts,
        "NOW,NOW,1000,15000,0,100,0,0,2\n",
        "adapter spotter",
        "datagrams",
    ),
    (Inlet::Nmea, "$HEHDT,10.0,T*SUM\r\n", "adapter boat", "datagrams"),
    (
        Inlet::FeedUdp,
        "{\"source\": \"own\", \"latitude\": 41.4, \"longitude\": 2.1, \"sigma_m\": 10}\n",
        "own",
        "detections",
    ),
    (
        Inlet::FeedTcp,
        "{\"source\": \"other\", \"latitude\": 41.4, \"longitude\": 2.1, \"sigma_m\": 10}\n",
        "other",
        "detections",
    ),
];

#[test]
fn reports_of_each_kind_of_source_are_true() {
    let mut site = live_refusals::Site::start();
    let mut radar = Sensor::new(48, [1, 1]);
    let hexadecimal = |block: &Vec<u8>| block.iter().map(|octet| format!("{octet:02x}")).collect::<String>();
    let mut turn = 0;
    // Sending takes all of the site but its home.
    let home = std::mem::replace(&mut site.home, Home::new());
    until_taken(&home, &["radar", "base", "own", "other", "ship"], || {
        turn += 1;
        for (inlet, good, ..) in KINDS {
            let good = match inlet {
                Inlet::Asterix => radar.blocks().iter().map(hexadecimal).collect(),
                _ => good.replace("TURN", &turn.to_string()).replace("DATE", &stamp()),
            };
            site.send(inlet, &good);
        }
    });
    for feed in site.feeds {
        let (status, said) = feed.stop();
        assert_eq!(status.code(), Some(0), "{said}");
    }
    let report = ended(&home, site.running);
    // The tracker stands for its two sensors.
    assert_sources(&report, [0, 0, 7], "each kind");
    for (inlet, _, of, label) in KINDS {
        let sources = report["sources"].as_array().unwrap().iter();
        let sources = sources
            .filter(|source| source["name"] == of)
            .map(|source| &source["adapter"]);
        let processes = report["others"].as_array().unwrap().iter();
        let processes = processes
            .filter(|process| process["process"] == of)
            .map(|process| &process["counters"]);
        let counted: u64 = sources.chain(processes).map(|counters| counter(counters, label)).sum();
        assert!(counted > 0, "{inlet:?}: {label} of {of}");
    }
    home.assert_nothing_is_left("test");
}

/// Date and time of day, twice as lines of SBS have them.
fn stamp() -> String {
    let of_day_ms = utc_ns() / 1_000_000 % 86_400_000;
    let [hours, minutes, ms] = [of_day_ms / 3_600_000, of_day_ms / 60_000 % 60, of_day_ms % 60_000];
    format!("2026/01/01,{hours:02}:{minutes:02}:{:02}.{:03}", ms / 1000, ms % 1000)
}

/// Two recordings of one simulated world.
const RECORDED: &str = r#"name = "test"
frame = { latitude_deg = 41.297063, longitude_deg = 2.078447 }
time = { order = "time", date = "2026-01-01" }
display = { listen = "off" }
[[source]]
name = "radar"
period_s = 4.0
place = { latitude_deg = 41.599574, longitude_deg = 2.049661, height_m = 389.2 }
recorded = { file = "radar-north.ast" }
covariance = { range_sigma_m = 50.0, azimuth_sigma_deg = 0.07 }
[[source]]
name = "mlat"
period_s = 1.0
recorded = { file = "multilateration.ast" }
covariance = { from = "report", position_sigma_m = 5.0 }
"#;

/// What a report has that is not so: a change of its text, or of its counters, and a word of the finding.
enum Lie {
    Words(&'static str, &'static str, &'static str),
    Counter(&'static str, u64, &'static str),
    Alarm(&'static str, &'static str, &'static str),
}

#[test]
fn a_false_sentence_or_counter_is_found() {
    let home = Home::new();
    home.write("site.toml", RECORDED);
    let data = repository("examples/data");
    let fixed = [
        "up",
        "site.toml",
        "--instance",
        "test",
        "--out",
        "out",
        "--speed",
        "max",
        "--data",
    ];
    let running = home.start(&[&fixed[..], &[data.to_str().unwrap()]].concat());
    let printed = Arc::clone(&running.stdout);
    let (status, said) = running.end();
    assert_eq!(status.code(), Some(0), "{said}");
    let text = printed.lock().unwrap().clone();
    let text = &text[text.rfind("KOSEKI REPORT").unwrap()..];
    let report = report(&home);
    assert_eq!(findings(text, &report), [""; 0]);
    let lies = [
        Lie::Words("ALARMS: none was raised", "", "ALARMS"),
        Lie::Words(
            "Nothing to worry about",
            "Worth a look: radar delivered nothing. Nothing",
            "radar",
        ),
        Lie::Words("0 reports lost", "1 report lost", "lost between"),
        Lie::Words("REJECTED OR NOT USED", "REJECTED OR USED", "REJECTED OR NOT USED"),
        Lie::Words("ARRIVAL of", "All is well.\nARRIVAL of", "All is well"),
        Lie::Words("2 recordings", "2 live sources", "sources 2 recordings"),
        Lie::Counter("/sources/0/fusion/taken", 0, "radar delivered nothing"),
        Lie::Counter("/sources/0/adapter/rejected_speed", 3, "radar 758 3 698"),
        Lie::Counter(
            "/sources/0/adapter/service_messages",
            7,
            "radar adapter 7 Records about the sensor itself",
        ),
        Lie::Counter("/losses/reports_lost", 5, "5 reports did not reach fusion"),
        Lie::Counter("/losses/hops/0/taken", 1, "radar: published"),
        Lie::Counter("/picture/live_max", 0, "at most"),
        Lie::Counter(
            "/sources/1/sensor_of",
            0,
            "a sensor of a tracker, and a source of fusion",
        ),
        Lie::Alarm(
            "reports-late",
            "radar sends late: 3.0 % of its reports of the last minute (3 of 100 reports) arrived after later reports and \
             are not used.",
            "reports-late, which the counters do not bear",
        ),
        Lie::Alarm(
            "source-silent",
            "sonar has sent nothing for 9 s, 9 of its periods.",
            "source-silent",
        ),
        Lie::Alarm("clock-off", "The clock of radar is wrong.", "not its sentence"),
    ];
    for lie in lies {
        let (mut text, mut report) = (text.to_owned(), report.clone());
        let (what, expected) = match lie {
            Lie::Words(is, planted, expected) => {
                assert!(text.contains(is), "{is}: {text}");
                text = text.replacen(is, planted, 1);
                (planted, expected)
            }
            Lie::Counter(path, planted, expected) => {
                let (object, member) = path.rsplit_once('/').unwrap();
                report.pointer_mut(object).unwrap()[member] = json!(planted);
                (path, expected)
            }
            Lie::Alarm(kind, words, expected) => {
                let source = words.split(' ').next().unwrap();
                report["alarms"] = json!([{"alarm": kind, "source": source, "text": words, "times": 1}]);
                (kind, expected)
            }
        };
        let found = findings(&text, &report).join("\n");
        assert!(found.contains(expected), "{what}: {expected} is not in: {found}");
    }
    home.assert_nothing_is_left("test");
}

//! Feeds whose connection is lost: what had begun on it is counted, and joined with nothing of the next connection.

use std::io::Write as _;
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use rustix::process::Signal;
use serde_json::Value;

use crate::common::{Home, counter, until};

/// Whole frames of Mode S: worked examples of the literature.
const FRAMES: [&str; 3] = [
    "8D40621D58C382D690C8AC2863A7",
    "8D4840D6202CC371C32CE0576098",
    "8D40621D58C386435CC412692AD6",
];
/// Position of a ship.
const SHIP: &str = "!AIVDM,1,1,,A,13HNvh@P1FPGkL0Hf2000001P000,0*26";
/// Static data of a ship in two parts.
const PARTS: [&str; 2] = [
    "!AIVDM,2,1,1,A,55?MbV02;H;s<HtKR20EHE:0@T4@Dn2222222216L961O5Gf0NSQEp6ClRp8,0*1C",
    "!AIVDM,2,2,1,A,88888888880,2*25",
];

/// Serves one text per connection, and closes it; returns the address, and the number of connections so far.
fn serving(texts: [String; 2]) -> (String, Arc<AtomicUsize>) {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = server.local_addr().unwrap().to_string();
    let connections = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&connections);
    thread::spawn(move || {
        for (place, connection) in server.incoming().enumerate() {
            counted.store(place + 1, Ordering::Relaxed);
            let Some(text) = texts.get(place) else { return };
            connection.unwrap().write_all(text.as_bytes()).unwrap();
        }
    });
    (address, connections)
}

#[test]
fn what_a_lost_connection_has_cut_is_joined_with_nothing() {
    let home = Home::new();
    let (begin, rest) = FRAMES[1].split_at(12);
    let (frames, of_frames) = serving([
        format!("*{};\n*{begin}", FRAMES[0]),
        format!("{rest};\n*{};\n", FRAMES[2]),
    ]);
    let (ships, of_ships) = serving([
        format!("{SHIP}\r\n{}\r\n!AIVDM,1,1", PARTS[0]),
        format!("{}\r\n", PARTS[1]),
    ]);
    let receiver = |name: &str, format: &str, address: &str| {
        format!(
            "[[receiver]]\nname = \"{name}-in\"\n[receiver.feed]\nformat = \"{format}\"\nconnect = \"{address}\"\n\
             [[source]]\nname = \"{name}\"\n[source.live]\nreceiver = \"{name}-in\"\n"
        )
    };
    let site = [
        "name = \"test\"\n[frame]\nlatitude_deg = 52.0\nlongitude_deg = 4.0\n[recorder]\nenabled = false\n".to_owned(),
        receiver("frames", "mode-s", &frames),
        receiver("ships", "ais", &ships),
    ];
    home.write("site.toml", site.concat());
    let running = home.start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
    // With the third connection, the end of the second has been read.
    until("both servers are connected to for the third time", || {
        [&of_frames, &of_ships].iter().all(|of| of.load(Ordering::Relaxed) == 3)
    });
    running.signal(Signal::TERM);
    let (status, said) = running.end();
    assert_eq!(status.code(), Some(0), "{said}");
    let report: Value = serde_json::from_str(&home.read("out/latest/report.json")).unwrap();
    let sources = report["sources"].as_array().unwrap();
    let counted = |name: &str| {
        let source = sources.iter().find(|source| source["name"] == name);
        let counters = &source.unwrap_or_else(|| panic!("no {name}: {report}"))["adapter"];
        [counter(counters, "records"), counter(counters, "blocks_rejected")]
    };
    // Of the frames, the cut one and its rest are refused; of the ships, the first part, a line without its end, and
    // the second part.
    assert_eq!((counted("frames"), counted("ships")), ([2, 2], [1, 3]), "{report}");
}

//! Recordings that are sent again, as their sensors sent them.

use std::io::{BufRead as _, BufReader, Write as _};
use std::net::{TcpStream, UdpSocket};

use asterix::registry;
use asterix::times::{TICKS_PER_DAY, TICKS_PER_S, first_time_of_day};
use runtime::Now;

use crate::common::home::{Home, PATIENCE};
use crate::common::repository;

/// A receiver, and where it is.
fn receiver() -> (UdpSocket, String) {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(PATIENCE)).unwrap();
    let address = socket.local_addr().unwrap().to_string();
    (socket, address)
}

fn received(socket: &UdpSocket) -> Vec<u8> {
    let mut datagram = [0; 2048];
    let length = socket.recv(&mut datagram).unwrap();
    datagram[..length].to_vec()
}

#[test]
fn every_block_is_sent_as_it_is() {
    let home = Home::new();
    let (socket, address) = receiver();
    let file = repository("examples/data/radar-north.ast");
    let sending = home.start(&["send", file.to_str().unwrap(), "--to", &address, "--speed", "max"]);
    let content = std::fs::read(&file).unwrap();
    let mut sent = Vec::new();
    while sent.len() < content.len() {
        sent.extend(received(&socket));
    }
    let (status, said) = sending.end();
    assert!(
        status.success() && said.contains("sent 226 datagrams or lines, 22,758 octets"),
        "{said}"
    );
    assert_eq!(sent, content);
}

#[test]
fn times_are_moved_to_now_and_nothing_else_changes() {
    let home = Home::new();
    let (socket, address) = receiver();
    let file = repository("examples/data/multilateration.ast");
    let arguments = ["send", file.to_str().unwrap(), "--to", &address, "--retime", "now"];
    let sending = home.start(&arguments);
    let ticks = |ns: i64| ns / (1_000_000_000 / i64::from(TICKS_PER_S));
    let now_ticks = |now: Now| (ticks(now.utc_ns) % i64::from(TICKS_PER_DAY)) as u32;
    let first = received(&socket);
    let now = now_ticks(Now::read());
    let stated = first_time_of_day(&first, registry::default_edition).unwrap();
    let age = (now + TICKS_PER_DAY - stated) % TICKS_PER_DAY;
    assert!(age < 60 * TICKS_PER_S, "{age} ticks of 1/128 s");
    let content = std::fs::read(&file).unwrap();
    let differing = first.iter().zip(&content).filter(|(sent, recorded)| sent != recorded);
    assert!((1..=3 * 60).contains(&differing.count()));
    let (status, said) = sending.stop();
    assert!(status.success() && said.contains("times moved to now"), "{said}");
}

#[test]
fn lines_are_served_to_whoever_connects() {
    let home = Home::new();
    let mut file = std::fs::File::create(home.path("aircraft.sbs")).unwrap();
    for second in 0..5 {
        let stamp = format!("2016/12/31,23:59:5{second}.000");
        writeln!(file, "MSG,3,1,1,4CA2D6,1,{stamp},{stamp},,37000,,,51.5,-0.5,,,0,0,0,0").unwrap();
    }
    drop(file);
    let port = {
        let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        free.local_addr().unwrap().to_string()
    };
    let arguments = ["send", "aircraft.sbs", "--to", &port, "--speed", "max"];
    let public = ["send", "aircraft.sbs", "--to", "0.0.0.0:0"];
    let refused = home.command(&public).current_dir(home.path("")).output().unwrap();
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(
        said.contains("can be reached from other machines") && said.contains("--remote"),
        "{said}"
    );
    let sending = home.start_command(home.command(&arguments).current_dir(home.path("")));
    sending.until_said("for a reader");
    let reader = TcpStream::connect(&port).unwrap();
    reader.set_read_timeout(Some(PATIENCE)).unwrap();
    let lines: Vec<String> = BufReader::new(reader).lines().map(Result::unwrap).collect();
    assert_eq!(lines.len(), 5);
    assert!(lines[4].contains("2016/12/31,23:59:54.000"), "{lines:?}");
    assert!(sending.end().0.success());
}

#[test]
fn what_is_no_recording_and_what_cannot_be_meant_is_said() {
    let home = Home::new();
    std::fs::write(home.path("notes.txt"), "nothing of the kind\n").unwrap();
    // Letters are lengths of data blocks.
    std::fs::write(
        home.path("long.json"),
        "{\"hex\": \"abcd01\", \"lat\": 50.0}\n".repeat(10_000),
    )
    .unwrap();
    let mut octets: Vec<u8> = (0..100_000_u32)
        .map(|place| (place.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    octets[..3].copy_from_slice(&[200, 0x10, 0]);
    std::fs::write(home.path("octets.bin"), octets).unwrap();
    let radar = repository("examples/data/radar-north.ast");
    let radar = radar.to_str().unwrap();
    for (arguments, expected) in [
        (
            vec!["notes.txt", "--to", "127.0.0.1:9"],
            "holds neither data blocks of ASTERIX, lines of SBS-1 nor snapshots of an antenna array",
        ),
        (vec!["long.json", "--to", "127.0.0.1:9"], "it is JSON"),
        (vec!["octets.bin", "--to", "127.0.0.1:9"], "holds neither data blocks"),
        (vec!["missing.ast", "--to", "127.0.0.1:9"], "cannot be read"),
        (vec!["notes.txt", "--to", "127.0.0.1"], "invalid value"),
        (vec!["notes.txt=here"], "here is no ADDRESS:PORT"),
        (vec![radar], "radar-north.ast has no address: give it one"),
        (
            vec!["notes.txt", "--to", "127.0.0.1:9", "--retime", "now", "--speed", "2"],
            "needs --speed 1",
        ),
    ] {
        let output = home.run(&[&["send"], &arguments[..]].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn what_is_behind_the_last_block_is_counted() {
    let home = Home::new();
    let (_socket, address) = receiver();
    let mut content = std::fs::read(repository("examples/data/radar-north.ast")).unwrap();
    content.extend([48, 0, 1, 7, 7]);
    std::fs::write(home.path("damaged.ast"), &content).unwrap();
    let output = home.run(&["send", "damaged.ast", "--to", &address, "--speed", "max"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let expected = "damaged.ast: byte 22758: no data block begins here; 5 octets from here on were not sent";
    assert!(said.contains(expected), "{said}");
}

#[test]
fn the_recordings_are_what_the_simulation_of_their_world_sends() {
    let home = Home::new();
    let scenario = repository("examples/data/airport.toml");
    let out = home.path("simulated");
    let arguments = [
        "simulate",
        "--scenario",
        scenario.to_str().unwrap(),
        "--asterix",
        "--for",
        "60",
        "--out",
    ];
    let output = home.run(&[&arguments[..], &[out.to_str().unwrap()]].concat());
    assert!(output.status.success(), "{output:?}");
    for (number, name) in [(1, "radar-north"), (2, "radar-south"), (3, "multilateration")] {
        let made = std::fs::read(out.join(format!("asterix_{number}.ast"))).unwrap();
        let kept = std::fs::read(repository(&format!("examples/data/{name}.ast"))).unwrap();
        // On a processor of another family the last bit of a position may be another.
        let differing = made.iter().zip(&kept).filter(|(one, other)| one != other).count();
        assert!(
            made.len() == kept.len() && differing < 100,
            "{name}: {differing} octets"
        );
    }
}

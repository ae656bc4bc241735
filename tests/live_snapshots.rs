//! A live direction finder: snapshots of an antenna array in datagrams become bearings, and these a located
//! transmitter, in real processes (EL-1, EL-11). A killed adapter continues with the same fix.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;
use std::net::{SocketAddr, UdpSocket};

use bus::{Bus, SharedMemory};
use locating::music::{AntennaArray, SimulatedArray, SimulatedWaves};
use messages::{Counter, Counters, SensorTrack};
use runtime::clock::mono_ns;
use rustix::process::Signal;

use crate::common::{Home, PLACE, Running, free_address, kill, until};

const FREQUENCY_HZ: f64 = 1e9;
const ANTENNAS: usize = 8;
const SPACING_M: f64 = 0.15;
/// Transmitter, east and north, metres.
const EMITTER_M: [f64; 2] = [3_000.0, 6_000.0];
/// Number of the source in the configuration.
const SOURCE: u16 = 0;

/// A deployment whose only source is an array of antennas along the fuselage, which looks to the left.
fn site(to: SocketAddr) -> String {
    let mut text = format!(
        "name = \"test\"\n[frame]\nlatitude_deg = {}\nlongitude_deg = {}\n[[receiver]]\nname = \"lan\"\n[receiver.udp]\n\
         listen = \"{to}\"\n[[source]]\nname = \"array\"\nperiod_s = 0.1\nfresh_s = 3.0\n[source.live]\nreceiver = \"lan\"\n\
         [source.locator]\n[source.array]\nfrequency_max_hz = 1.1e9\nforward_deg = -90\nsector_deg = [-90, 90]\n",
        PLACE[0], PLACE[1]
    );
    for antenna in 0..ANTENNAS {
        let right_m = SPACING_M * antenna as f64;
        writeln!(text, "[[source.array.antenna]]\nright_m = {right_m}\nforward_m = 0").unwrap();
    }
    text
}

/// Rows of a flight to the east at 250 m/s, with a measurement of 100 snapshots each tenth of a second.
fn flight(measurements: u64) -> String {
    let names: Vec<String> = (1..=ANTENNAS)
        .map(|antenna| format!(",re_{antenna},im_{antenna}"))
        .collect();
    let mut text = format!("time_s,px,py,pz,heading_rad,frequency_hz{}\n", names.concat());
    let array = AntennaArray::line(ANTENNAS, SPACING_M).unwrap();
    let mut samples = Vec::new();
    for number in 0..measurements {
        let (time_s, east) = (43_200.0 + 0.1 * number as f64, 25.0 * number as f64);
        let off_left = f64::atan2(EMITTER_M[0] - east, EMITTER_M[1]);
        let waves = SimulatedWaves::independent(&[off_left], 10.0, FREQUENCY_HZ, 100);
        SimulatedArray::new(&array, waves, 7).unwrap().run(number, &mut samples);
        for snapshot in samples.chunks(ANTENNAS) {
            write!(text, "{time_s:.1},{east},0,3000,{FRAC_PI_2},{FREQUENCY_HZ}").unwrap();
            for sample in snapshot {
                write!(text, ",{:.5},{:.5}", sample.re, sample.im).unwrap();
            }
            text.push('\n');
        }
    }
    text
}

fn started(home: &Home, to: SocketAddr) -> (Running, Bus<SharedMemory>) {
    std::fs::write(home.path("site.toml"), site(to)).unwrap();
    let running = home.start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
    running.until_said("instance test runs");
    until("the adapter listens", || home.status_row("lan").state == "running");
    (running, Bus::open(&home.root("test"), "reader").unwrap())
}

fn stopped(home: &Home, running: Running) {
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("test");
}

fn off_m(track: &SensorTrack) -> f64 {
    (track.position_m[0] - EMITTER_M[0]).hypot(track.position_m[1] - EMITTER_M[1])
}

fn variance_m2(track: &SensorTrack) -> f64 {
    track.covariance.get(0, 0) + track.covariance.get(1, 1)
}

#[test]
fn snapshots_become_a_located_transmitter_that_outlasts_a_kill() {
    let (home, to) = (Home::new(), free_address());
    std::fs::write(home.path("flight.csv"), flight(400)).unwrap();
    let (running, bus) = started(&home, to);
    let open = || mono_ns() as u64;
    let mut located = bus.subscriber(&messages::sensor_tracks("array"), open).unwrap();
    let sending = home.start(&["send", "flight.csv", "--to", &to.to_string(), "--retime", "now"]);

    let (mut tracks, mut latest) = (Vec::<SensorTrack>::new(), None);
    let mut take = |tracks: &mut Vec<SensorTrack>| {
        located
            .take(256, |header, slice| {
                tracks.extend_from_slice(slice);
                latest = slice.last().map(|track| (header.incarnation, *track)).or(latest);
            })
            .unwrap();
        latest
    };
    until("the transmitter is located", || {
        take(&mut tracks).is_some_and(|(_, track)| off_m(&track) < 300.0 && tracks.len() > 80)
    });

    // Nobody has received a spectrum so far, so none was published; a subscriber changes that.
    let topic = messages::sensor_spectrum("array");
    let published = || {
        bus.publisher_lines(&topic)
            .unwrap()
            .iter()
            .map(|line| line.next_sequence)
            .sum::<u64>()
    };
    assert_eq!(published(), 0);
    let mut spectra = bus.subscriber(&topic, open).unwrap();
    let mut spectrum = None;
    until("a spectrum comes", || {
        spectra.take(16, |_, slice| spectrum = slice.last().copied()).unwrap();
        take(&mut tracks);
        spectrum.is_some()
    });
    drop(spectra);
    let spectrum = spectrum.unwrap();
    let ahead = spectrum.spectrum_db[..90].iter().chain(&spectrum.spectrum_db[270..]);
    let peak = ahead.copied().fold(f32::MIN, f32::max);
    let strongest = spectrum.spectrum_db.iter().position(|value| *value == peak).unwrap();
    let (_, at) = take(&mut tracks).unwrap();
    let expected = f64::atan2(EMITTER_M[0] - 0.0, EMITTER_M[1]).to_degrees();
    let strongest_deg = (strongest as f64 + 180.0).rem_euclid(360.0) - 180.0;
    assert!(
        peak > 20.0 && strongest_deg < expected + 1.0,
        "{peak} dB at {strongest_deg} of {expected}, {at:?}"
    );

    // The successor of a killed adapter continues with the fix, and not with a new search.
    let (dead, before) = take(&mut tracks).unwrap();
    kill(home.status_row("lan").pid, Signal::KILL);
    let mut after = None;
    until("the successor publishes", || {
        let found = take(&mut tracks).filter(|(incarnation, _)| *incarnation != dead);
        after = after.or(found);
        after.is_some()
    });
    let (_, after) = after.unwrap();
    assert_eq!(after.track_number, before.track_number);
    assert!(
        off_m(&after) < 350.0 && variance_m2(&after) < 1.5 * variance_m2(&before),
        "{} m off with a variance of {} m² before {}",
        off_m(&after),
        variance_m2(&before),
        variance_m2(&after)
    );
    let mut delays: Vec<i64> = tracks
        .iter()
        .map(|track| track.stages.published_ns - track.stages.ingested_ns)
        .collect();
    delays.sort_unstable();
    let at = |share: f64| delays[(share * (delays.len() - 1) as f64) as usize] as f64 / 1e6;
    println!(
        "{} fixes; from the last snapshot's receipt to the published fix {:.2} ms in the median, 99 %: {:.2} ms",
        delays.len(),
        at(0.5),
        at(0.99)
    );
    drop(sending);
    drop((located, bus));
    stopped(&home, running);
}

/// Counters of the source and of its adapter.
fn counters(bus: &Bus<SharedMemory>) -> impl FnMut() -> Counters + use<'_> {
    let mut health = bus.subscriber(&messages::health(), || mono_ns() as u64).unwrap();
    let mut latest = Counters::default();
    move || {
        health
            .take(64, |_, slice| {
                let own = slice
                    .iter()
                    .find(|entry| entry.source == SOURCE && entry.counters[Counter::Records] > 0);
                latest = own.map_or(latest, |entry| entry.counters);
            })
            .unwrap();
        latest
    }
}

#[test]
fn datagrams_that_cannot_be_used_are_counted_by_reason() {
    let (home, to) = (Home::new(), free_address());
    let (running, bus) = started(&home, to);
    std::fs::write(home.path("flight.csv"), flight(1)).unwrap();
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let forward = UdpSocket::bind("127.0.0.1:0").unwrap();
    forward.set_read_timeout(Some(crate::common::home::PATIENCE)).unwrap();
    // Datagrams as the command makes them, caught on the way.
    let address = forward.local_addr().unwrap().to_string();
    let sending = home.start(&["send", "flight.csv", "--to", &address, "--retime", "now"]);
    let mut sound = Vec::new();
    for _ in 0..5 {
        let mut octets = [0; 2048];
        let length = forward.recv(&mut octets).unwrap();
        sound.push(octets[..length].to_vec());
    }
    assert!(sending.end().0.success());
    let with = |at: usize, bytes: &[u8]| {
        let mut octets = sound[0].clone();
        octets[at..at + bytes.len()].copy_from_slice(bytes);
        octets
    };
    let mut few = with(6, &[4, 0]);
    few[20] = 42;
    let wrong = [
        b"time_s,bearing_rad\n1,2\n".to_vec(),
        with(4, &[9]),
        sound[0][..100].to_vec(),
        with(72, &f32::NAN.to_le_bytes()),
        few,
        with(24, &1_000_i64.to_le_bytes()),
    ];
    for octets in wrong.iter().chain(&sound).chain(&sound[1..3]) {
        socket.send_to(octets, to).unwrap();
    }
    let mut counted = counters(&bus);
    let expected = [
        (Counter::SnapshotsForeign, 2),
        (Counter::SnapshotsLength, 1),
        (Counter::SnapshotsValue, 1),
        (Counter::SnapshotsAntennas, 1),
        (Counter::RejectedTime, 1),
        (Counter::SnapshotsRepeated, 2),
        (Counter::Detections, 1),
        (Counter::DetectionsWithoutFix, 1),
        (Counter::BearingsOutsideSector, 1),
    ];
    let mut found = Vec::new();
    until("all are counted", || {
        let counters = counted();
        found = expected.map(|(counter, _)| (counter, counters[counter])).to_vec();
        found == expected
    });
    drop(counted);
    drop(bus);
    stopped(&home, running);
}

//! The whole chain of a simulated antenna array: ships that transmit, snapshots of an array on an aircraft, MUSIC,
//! bearings and fixes; live in datagrams, and from files (EL-1, EL-11).

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;

use bus::{Bus, SharedMemory};
use messages::SensorTrack;
use runtime::clock::mono_ns;

use crate::common::{Home, until};

/// A circle of seven antennas, less than half a wave apart at 9.5 GHz.
fn array() -> String {
    let mut text = "frequency_max_hz = 9.5e9\ntransmitters = 1\n".to_owned();
    for antenna in 0..7 {
        let (sine, cosine) = (TAU * f64::from(antenna) / 7.0).sin_cos();
        write!(
            text,
            "[[PREFIXantenna]]\nright_m = {}\nforward_m = {}\n",
            0.017 * sine,
            0.017 * cosine
        )
        .unwrap();
    }
    text
}

/// Ships that hardly move; each has a frequency of its own, by which its bearings find it.
fn site() -> String {
    let array = array().replace("PREFIX", "source.array.");
    format!(
        "name = \"test\"\n[frame]\nlatitude_deg = 34.75\nlongitude_deg = 139.35\n[scenario]\ntargets = 3\n\
         half_width_m = 40000.0\nterminal_share = 0.0\nholding_share = 0.0\nsurface_share = 0.0\nship_share = 1.0\n\
         ship_speed_max_mps = 0.5\n[[source]]\nname = \"finder\"\nperiod_s = 1.0\nfresh_s = 3.5\n\
         [source.simulated_direction_finder]\nposition_m = [0.0, -3000.0, 2000.0]\ncourse_rad = 1.2\n\
         speed_mps = 300.0\nperiod_s = 0.1\ndetection_probability = 1.0\nfrequency_sigma_hz = 1000.0\nsnr_db = 30.0\n\
         [source.locator]\n[source.array]\n{array}"
    )
}

fn run(home: &Home, arguments: &str) {
    let output = home.run(&arguments.split(' ').collect::<Vec<_>>());
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments}: {said}");
}

/// Places by number, from the last row of each.
fn last_places(home: &Home, name: &str) -> BTreeMap<String, [f64; 2]> {
    let text = fs::read_to_string(home.path(name)).unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        (
            cells[1].to_owned(),
            [cells[2], cells[3]].map(|cell| cell.parse().unwrap()),
        )
    };
    text.lines().skip(1).map(row).collect()
}

/// Distance from each ship to the nearest place, the greatest of them.
fn farthest_m<'a>(ships: &BTreeMap<String, [f64; 2]>, places: impl Iterator<Item = &'a [f64; 2]> + Clone) -> f64 {
    let apart_m = |[east, north]: [f64; 2], place: &[f64; 2]| (east - place[0]).hypot(north - place[1]);
    let nearest_m = |ship: &[f64; 2]| {
        places
            .clone()
            .map(|place| apart_m(*ship, place))
            .fold(f64::INFINITY, f64::min)
    };
    ships.values().map(nearest_m).fold(0.0, f64::max)
}

#[test]
fn snapshots_of_a_simulated_array_locate_ships_live_and_from_files() {
    let home = Home::new();
    fs::write(home.path("site.toml"), site()).unwrap();
    fs::write(home.path("array.toml"), array().replace("PREFIX", "")).unwrap();
    run(&home, "simulate --scenario site.toml --seed 5 --for 30 --out simulated");
    run(
        &home,
        "bearings --snapshots simulated/snapshots_1.csv --array array.toml --out bearings.csv",
    );
    run(&home, "locate --bearings bearings.csv --out fixes.csv");
    let (ships, found) = (
        last_places(&home, "simulated/truth.csv"),
        last_places(&home, "fixes.csv"),
    );
    assert_eq!((ships.len(), found.len()), (3, 3), "{found:?}");
    let off_m = farthest_m(&ships, found.values());
    assert!(off_m < 200.0, "{off_m} m off: {ships:?} {found:?}");

    let running = home.start(&["up", "site.toml", "--instance", "test", "--seed", "5", "--out", "out"]);
    running.until_said("instance test runs");
    let bus: Bus<SharedMemory> = Bus::open(&home.root("test"), "reader").unwrap();
    let open = || mono_ns() as u64;
    let mut located = bus.subscriber(&messages::sensor_tracks("finder"), open).unwrap();
    let mut tracks: BTreeMap<u32, SensorTrack> = BTreeMap::new();
    until("every ship is located", || {
        located
            .take(256, |_, slice| {
                tracks.extend(slice.iter().map(|track| (track.track_number, *track)))
            })
            .unwrap();
        let places: Vec<[f64; 2]> = tracks
            .values()
            .map(|track| [track.position_m[0], track.position_m[1]])
            .collect();
        farthest_m(&ships, places.iter()) < 500.0
    });
    assert_eq!(tracks.len(), 3, "one track for each transmitter: {tracks:?}");
    drop((located, bus));
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("test");
}

//! Transmitters located from bearings in a running deployment: real processes, from the direction finder's datagrams to
//! system tracks that join what is heard with what a radar sees (EL-11).

use std::collections::{BTreeMap, BTreeSet};

use bus::{Bus, SharedMemory};
use messages::{SensorTrack, SystemTrack, TrackState};
use runtime::clock::mono_ns;
use rustix::process::Signal;

use crate::common::{Home, until};

/// Numbers of the sources in the configuration.
const RADAR: u16 = 0;
const FINDER: u16 = 1;
/// Ships that drift, and bearings so many and so good that positions come within seconds.
const SITE: &str = r#"name = "test"
[frame]
latitude_deg = 34.75
longitude_deg = 139.35
[scenario]
targets = 4
half_width_m = 40000.0
terminal_share = 0.0
holding_share = 0.0
surface_share = 0.0
ship_share = 1.0
ship_speed_max_mps = 1.0
[[source]]
name = "radar"
period_s = 1.0
fresh_s = 3.5
[source.simulated]
kind = "radar"
period_s = 1.0
height_min_m = -100.0
identity = "none"
height_sigma_m = 10.0
[source.covariance]
range_sigma_m = 50.0
azimuth_sigma_deg = 0.069
velocity_sigma_mps = 10.0
[[source]]
name = "finder"
period_s = 1.0
fresh_s = 3.5
[source.simulated_direction_finder]
position_m = [0.0, -3000.0, 2000.0]
course_rad = 1.2
speed_mps = 250.0
period_s = 0.1
bearing_sigma_rad = 0.0005
[source.locator]
[fusion.registration]
enabled = false
"#;

/// The same without processes: bearings simulated into a file, and located from it.
#[test]
fn simulated_bearings_are_located_from_a_file() {
    let home = Home::new();
    std::fs::write(home.path("site.toml"), SITE).unwrap();
    let succeed = |arguments: &str| {
        let output = home.run(&arguments.split(' ').collect::<Vec<_>>());
        assert_eq!(
            output.status.code(),
            Some(0),
            "{arguments}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    };
    succeed("simulate --scenario site.toml --seed 5 --for 60 --out simulated");
    succeed("locate --bearings simulated/bearings_2.csv --out fixes.csv");
    let rows = |name: &str| -> Vec<Vec<f64>> {
        let text = std::fs::read_to_string(home.path(name)).unwrap();
        let numbers = |line: &str| line.split(',').map(|field| field.parse().unwrap_or(f64::NAN)).collect();
        text.lines().skip(1).map(numbers).collect()
    };
    let (truth, fixes) = (rows("simulated/truth.csv"), rows("fixes.csv"));
    for ship in 0..4 {
        let last = |table: &[Vec<f64>]| {
            table
                .iter()
                .rfind(|row| row[1] == f64::from(ship))
                .cloned()
                .expect("is there")
        };
        let (there, found) = (last(&truth), last(&fixes));
        let apart_m = (there[2] - found[2]).hypot(there[3] - found[3]);
        assert!(apart_m < 500.0, "ship {ship}: {apart_m:.0} m apart");
    }
}

/// A transmitter on a simulated ship is located by bearings, and is one system track with what the radar sees of it,
/// where the ship is.
#[test]
fn what_is_heard_and_what_is_seen_become_one_track() {
    let home = Home::new();
    std::fs::write(home.path("site.toml"), SITE).unwrap();
    let running = home.start(&["up", "site.toml", "--instance", "test", "--seed", "5", "--out", "out"]);
    running.until_said("instance test runs");
    let bus = Bus::<SharedMemory>::open(&home.root("test"), "reader").unwrap();
    let open = || mono_ns() as u64;
    let mut located = bus.subscriber(&messages::sensor_tracks("finder"), open).unwrap();
    let mut fused = bus.subscriber(&messages::system_tracks(), open).unwrap();
    let mut bearings = bus.subscriber(&messages::sensor_bearings("finder"), open).unwrap();
    let mut platform = bus.subscriber(&messages::platform_states("finder"), open).unwrap();

    let (mut heard, mut states) = (0, 0);
    let mut tracks: BTreeMap<u32, SensorTrack> = BTreeMap::new();
    let mut joined: BTreeMap<u32, SystemTrack> = BTreeMap::new();
    until("every ship's transmitter is in the track of the ship", || {
        bearings.take(256, |_, slice| heard += slice.len()).unwrap();
        platform.take(64, |_, slice| states += slice.len()).unwrap();
        located
            .take(256, |_, slice| {
                tracks.extend(slice.iter().map(|track| (track.track_number, *track)))
            })
            .unwrap();
        let of_both = |track: &&SystemTrack| {
            let has = |source| track.contributions().iter().any(|part| part.source == source);
            track.state == TrackState::Confirmed as u8 && has(RADAR) && has(FINDER)
        };
        fused
            .take(256, |_, slice| {
                joined.extend(slice.iter().filter(of_both).map(|track| (track.track_number, *track)))
            })
            .unwrap();
        joined.len() >= 4 && heard > 100 && states > 30
    });
    assert_eq!(tracks.len(), 4, "one track per transmitter: {tracks:?}");
    drop((located, fused, bearings, platform, bus));
    running.signal(Signal::TERM);
    let (status, said) = running.end();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("test");
    the_record_is_located_again(&home, heard, states);
}

/// `koseki locate` makes the tracks again, to the last digit, of the bearings that the recorder has written.
fn the_record_is_located_again(home: &Home, heard: usize, states: usize) {
    let rows = |name: &str| -> Vec<Vec<String>> {
        let text = std::fs::read_to_string(home.path(name)).unwrap();
        let cells = |line: &str| line.split(',').map(str::to_owned).collect();
        text.lines().skip(1).map(cells).collect()
    };
    let (bearings, platform) = (
        rows("out/latest/bearings_finder.csv"),
        rows("out/latest/platform_states_finder.csv"),
    );
    assert!(
        bearings.len() >= heard && platform.len() >= states,
        "less than a reader has heard"
    );
    assert_eq!(
        platform[0][2..5],
        bearings[0][4..7],
        "where the first bearing was measured from"
    );
    let output = home.run(&[
        "locate",
        "--bearings",
        "out/latest/bearings_finder.csv",
        "--out",
        "again.csv",
    ]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    // Time, number and place; a sensor track has its sensor between the first two.
    let again: BTreeSet<Vec<String>> = rows("again.csv").into_iter().map(|row| row[..5].to_vec()).collect();
    let published = rows("out/latest/sensor_tracks_finder.csv");
    assert!(published.len() > 30, "{} tracks", published.len());
    for row in published {
        let made = [&row[..1], &row[2..6]].concat();
        assert!(again.contains(&made), "{made:?} is not among {} fixes", again.len());
    }
}

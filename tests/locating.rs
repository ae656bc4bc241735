//! Transmitters located from bearings in a running deployment: real processes, from the direction finder's datagrams to
//! system tracks that join what is heard with what a radar sees (EL-11).

#[path = "common/home.rs"]
mod home;

use std::collections::BTreeMap;

use bus::{Bus, SharedMemory};
use home::{Home, until};
use messages::{SensorTrack, SystemTrack, TrackState};
use runtime::clock::mono_ns;
use rustix::process::Signal;

/// Numbers of the sources in the configuration.
const RADAR: u16 = 0;
const FINDER: u16 = 1;
/// Ships, so that nothing manoeuvres; bearings so many and so good that positions come within seconds.
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
[[source]]
name = "radar"
period_s = 1.0
fresh_s = 3.5
assumed_height_m = 20.0
[source.simulated]
kind = "radar"
period_s = 1.0
height_min_m = -100.0
identity = "none"
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
[recorder]
enabled = false
"#;

/// A transmitter on a simulated ship is located by bearings, and is one system track with what the radar sees of it, where
/// the ship is.
#[test]
fn what_is_heard_and_what_is_seen_become_one_track() {
    let home = Home::new();
    std::fs::write(home.path("site.toml"), SITE).unwrap();
    let running = home.start(&["up", "site.toml", "--instance", "test", "--seed", "5"]);
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
        joined.len() >= 4
    });
    assert!(heard > 100 && states > 30, "{heard} bearings, {states} platform states");
    assert_eq!(tracks.len(), 4, "one track per transmitter: {tracks:?}");
    drop((located, fused, bearings, platform, bus));
    running.signal(Signal::TERM);
    let (status, said) = running.end();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("test");
}

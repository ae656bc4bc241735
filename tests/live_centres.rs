//! Two centres that tell each other of their tracks by CAT062, as centres do that know nothing else of each other.

use std::collections::BTreeMap;
use std::net::SocketAddr;

use bus::{Bus, SharedMemory, Subscriber};
use messages::{SystemTrack, TrackState, contribution_bits};
use runtime::clock::mono_ns;

use crate::common::{Home, PLACE, free_address, until};

const NAMES: [&str; 2] = ["west", "east"];
const TARGETS: usize = 12;

/// Configuration of centre `number`, which has a radar, is told of tracks at `at`, and tells of its own at `to`.
fn centre(number: usize, at: SocketAddr, to: SocketAddr) -> String {
    let (name, other, east_m) = (NAMES[number], NAMES[1 - number], [-20e3, 20e3][number]);
    format!(
        r#"name = "{name}"
[frame]
latitude_deg = {}
longitude_deg = {}
[scenario]
targets = {TARGETS}
terminal_share = 0.0
surface_share = 0.0
[[source]]
name = "radar"
period_s = 0.5
[source.simulated]
kind = "radar"
position_m = [{east_m}, 0.0, 0.0]
period_s = 0.5
[source.covariance]
range_sigma_m = 50.0
azimuth_sigma_deg = 0.07
[[receiver]]
name = "neighbour"
[receiver.udp]
listen = "{at}"
[[source]]
name = "{other}"
period_s = 0.5
shares = "unknown"
[source.live]
receiver = "neighbour"
sac = 25
sic = {}
[source.covariance]
from = "report"
[[gateway]]
name = "to-{other}"
own = true
send_to = "{to}"
sac = 25
sic = {number}
refresh_s = 0.5
[fusion]
exchange = true
refresh_s = 0.5
"#,
        PLACE[0],
        PLACE[1],
        1 - number,
    )
}

/// Newest states of one centre's tracks.
struct Picture {
    subscriber: Subscriber<SharedMemory, SystemTrack>,
    tracks: BTreeMap<u32, SystemTrack>,
}

impl Picture {
    fn of(home: &Home, name: &str) -> Self {
        let bus: Bus<SharedMemory> = Bus::open(&home.root(name), "test").unwrap();
        Self {
            subscriber: bus.subscriber(&messages::system_tracks(), || mono_ns() as u64).unwrap(),
            tracks: BTreeMap::new(),
        }
    }

    /// Tracks that are shown, and how many of them have a contribution of the radar and one of the other centre.
    fn look(&mut self) -> (usize, usize) {
        let tracks = &mut self.tracks;
        let take = |_: &_, slice: &[SystemTrack]| tracks.extend(slice.iter().map(|track| (track.track_number, *track)));
        self.subscriber.take(64, take).unwrap();
        let shown = |track: &&SystemTrack| track.state == TrackState::Confirmed as u8;
        let fresh = |track: &SystemTrack, centre: u16| {
            let wanted = contribution_bits::FRESH | centre;
            let flags = track
                .contributions()
                .iter()
                .map(|part| part.flags & !contribution_bits::SCORED);
            flags.filter(|flags| *flags == wanted).count()
        };
        let has_both = |track: &&SystemTrack| (fresh(track, 0), fresh(track, contribution_bits::CENTRE)) == (1, 1);
        let shown = self.tracks.values().filter(shown);
        (shown.clone().count(), shown.filter(has_both).count())
    }
}

#[test]
fn each_centre_has_every_target_once_with_what_both_say() {
    let home = Home::new();
    let at = [free_address(), free_address()];
    let running = [0, 1].map(|number: usize| {
        let (name, file) = (NAMES[number], format!("{}.toml", NAMES[number]));
        home.write(&file, centre(number, at[number], at[1 - number]));
        home.start(&["up", &file, "--instance", name])
    });
    for (running, name) in running.iter().zip(NAMES) {
        running.until_said(&format!("instance {name} runs"));
    }
    let mut pictures = NAMES.map(|name| Picture::of(&home, name));
    until("each has every target once, with what both say", || {
        pictures.iter_mut().all(|picture| picture.look() == (TARGETS, TARGETS))
    });
    drop(pictures);
    for running in running {
        let (status, said) = running.stop();
        assert_eq!(status.code(), Some(0), "{said}");
    }
    NAMES.iter().for_each(|name| home.assert_nothing_is_left(name));
}

//! A host that is rebooted: its monotonic clock begins again, and its neighbours follow it all the same.

use std::time::{SystemTime, UNIX_EPOCH};

use crate::host::until;
use crate::mirror::{Reader, mirror, tower};
use crate::network::Network;

/// Tracks by which a picture counts as there.
const TRACKS: usize = 20;

/// A centre that sees what the tower tells, and nothing of its own.
fn centre(endpoint: &str) -> String {
    format!(
        "name = \"centre\"\norigin = 2\n\
         [frame]\nlatitude_deg = 41.3\nlongitude_deg = 2.1\n\
         [fusion]\nexchange = true\n\
         [recorder]\nenabled = false\n\
         [[source]]\nname = \"tower\"\nperiod_s = 1.0\nshares = \"unknown\"\n[source.external]\n\
         [[link]]\nname = \"in\"\nconnect = [\"{endpoint}\"]\nsend = []\ninsecure = true\n\
         [[link.receive]]\ndeployment = \"tower\"\ntopic = \"system/own-tracks\"\ninto = \"sensor/tower/tracks\"\n"
    )
}

fn utc_ns() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as i64
}

#[test]
fn a_rebooted_host_is_followed_by_mirrors_and_centres_though_its_clock_is_behind() {
    let Some(mut network) = Network::new() else { return };
    let endpoint = network.endpoint.clone();
    let config = tower(&endpoint, "insecure = true\n")
        .replace(
            "name = \"tower\"\n",
            "name = \"tower\"\norigin = 1\n[fusion]\nexchange = true\n",
        )
        .replace("\"system/tracks\",", "\"system/tracks\", \"system/own-tracks\",");
    let mut there = network.hosts[0].up("tower", &config, &[]);
    there.until_up();
    let mut near = network.hosts[1].up("centre", &centre(&endpoint), &[]);
    near.until_up();
    let _mirror = mirror(&network.hosts[1], &config, &endpoint, &[]);
    let mut reflection = Reader::until_there(&network.hosts[1], "tower");
    let mut fused = Reader::of(&network.hosts[1], "centre");
    let mut is_seen = |since_ns: i64, network: &Network| {
        let count = |reader: &Reader| {
            let states = reader.tracks.values();
            states.filter(|state| state.reference_time_ns > since_ns).count()
        };
        until(
            || {
                reflection.read();
                fused.read();
                count(&reflection) >= TRACKS && count(&fused) >= TRACKS
            },
            || {
                format!(
                    "{}{}",
                    network.hosts[1].status("tower"),
                    network.hosts[1].status("centre")
                )
            },
        );
    };
    is_seen(i64::MIN, &network);
    drop(there);
    if !network.reboot() {
        println!("skipped: no namespaces, so no clock can begin again");
        return;
    }
    let rebooted_ns = utc_ns();
    let mut there = network.hosts[0].up("tower", &config, &[]);
    there.until_up();
    is_seen(rebooted_ns, &network);
}

//! A deployment of another host as an instance here.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use koseki_client::messages::{SystemTrack, TrackState, system_tracks};
use koseki_client::{Root, Subscription};

use crate::host::{Host, free_port, until};
use crate::relay::{Delays, Relay};

/// A reader's picture: the newest state of each track.
struct Reader {
    subscription: Subscription<SystemTrack>,
    tracks: BTreeMap<u32, SystemTrack>,
}

impl Reader {
    fn of(host: &Host, instance: &str) -> Self {
        let root = Root::in_base(host.shared(), instance).unwrap();
        Self {
            subscription: Subscription::at(&root, &system_tracks()).unwrap(),
            tracks: BTreeMap::new(),
        }
    }

    fn read(&mut self) {
        while let Some(slice) = self.subscription.next(Duration::ZERO).unwrap() {
            for state in slice.iter() {
                match TrackState::from_code(state.state) {
                    Some(TrackState::Terminated) => drop(self.tracks.remove(&state.track_number)),
                    _ => drop(self.tracks.insert(state.track_number, *state)),
                }
            }
        }
    }

    fn numbers(&self) -> Vec<u32> {
        self.tracks.keys().copied().collect()
    }
}

/// A mirror, ended with the test.
struct Mirror(Child);

impl Drop for Mirror {
    fn drop(&mut self) {
        let _ = Command::new("kill").args(["-TERM", &self.0.id().to_string()]).status();
        let _ = self.0.wait();
    }
}

fn mirror(host: &Host, config: &str, port: u16) -> Mirror {
    let path = host.path("tower.toml");
    std::fs::write(&path, config).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_koseki-link"));
    command.arg("mirror").arg("--config").arg(path);
    command.arg("--connect").arg(format!("tcp/127.0.0.1:{port}"));
    command
        .env("KOSEKI_ROOT", host.shared())
        .stdin(Stdio::null())
        .stdout(Stdio::null());
    Mirror(command.spawn().unwrap())
}

/// A world whose targets come and go.
fn tower(port: u16) -> String {
    format!(
        "name = \"tower\"\n\
         [frame]\nlatitude_deg = 41.3\nlongitude_deg = 2.1\n\
         [scenario]\ntargets = 30\n\
         [[source]]\nname = \"multilateration\"\nperiod_s = 1.0\n\
         [source.simulated]\nkind = \"multilateration\"\ndropouts_per_hour = 100.0\nfalse_tracks_per_period = 1.0\n\
         [source.covariance]\nfrom = \"report\"\nposition_sigma_m = 5.0\n\
         [recorder]\nenabled = false\n\
         [[link]]\nname = \"out\"\nlisten = [\"tcp/127.0.0.1:{port}\"]\n\
         send = [\"system/tracks\", \"health\"]\n"
    )
}

#[test]
fn a_mirror_that_joins_late_and_is_cut_off_shows_the_picture_as_it_is() {
    let (Some(there), Some(here)) = (Host::new(), Host::new()) else {
        return;
    };
    let port = free_port();
    let mut deployment = there.up("tower", &tower(port), &[]);
    deployment.until_up();
    let mut original = Reader::of(&there, "tower");
    until(
        || {
            original.read();
            original.tracks.len() >= 30
        },
        String::new,
    );
    let relay = Relay::to(port, Delays::NONE);
    let _mirror = mirror(&here, &tower(port), relay.port());
    until(|| here.status("tower").contains("tower"), String::new);
    let mut reflection = None;
    until(
        || {
            let root = Root::in_base(here.shared(), "tower").unwrap();
            let found = Subscription::at(&root, &system_tracks());
            reflection = found.ok().map(|subscription| Reader {
                subscription,
                tracks: BTreeMap::new(),
            });
            reflection.is_some()
        },
        || here.status("tower"),
    );
    let mut reflection = reflection.unwrap();
    let agree = |original: &mut Reader, reflection: &mut Reader| {
        let numbers = RefCell::new((Vec::new(), Vec::new()));
        until(
            || {
                original.read();
                reflection.read();
                let (there, here) = (original.numbers(), reflection.numbers());
                let agree = !there.is_empty() && there == here;
                numbers.replace((there, here));
                agree
            },
            || format!("{:?}\n{}", numbers.borrow(), here.status("tower")),
        );
    };
    agree(&mut original, &mut reflection);
    // What ends while nothing passes is told ended when the mirror is back.
    let before = original.numbers();
    relay.cut();
    until(
        || {
            original.read();
            before.iter().any(|number| !original.tracks.contains_key(number))
        },
        String::new,
    );
    relay.mend();
    agree(&mut original, &mut reflection);
    let sequences = |reader: &Reader| -> Vec<u64> { reader.tracks.values().map(|track| track.sequence).collect() };
    until(
        || {
            original.read();
            reflection.read();
            sequences(&original) == sequences(&reflection)
        },
        || here.status("tower"),
    );
}

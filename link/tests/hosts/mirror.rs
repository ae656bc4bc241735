//! A deployment of another host as an instance here.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use koseki_client::messages::{SystemTrack, TrackState, system_tracks};
use koseki_client::{Root, Subscription};

use crate::host::{Host, free_port, until};
use crate::relay::{Delays, Relay};

/// A reader's picture: the newest state of each track.
pub(crate) struct Reader {
    subscription: Subscription<SystemTrack>,
    pub(crate) tracks: BTreeMap<u32, SystemTrack>,
}

impl Reader {
    /// A reader of an instance whose topics are there.
    pub(crate) fn of(host: &Host, instance: &str) -> Self {
        Self::find(host, instance).unwrap()
    }

    /// A reader of an instance as soon as its topics are there.
    pub(crate) fn until_there(host: &Host, instance: &str) -> Self {
        let mut reader = None;
        until(
            || {
                reader = Self::find(host, instance);
                reader.is_some()
            },
            || host.status(instance),
        );
        reader.unwrap()
    }

    fn find(host: &Host, instance: &str) -> Option<Self> {
        let root = Root::in_base(host.shared(), instance).ok()?;
        let subscription = Subscription::at(&root, &system_tracks()).ok()?;
        let tracks = BTreeMap::new();
        Some(Self { subscription, tracks })
    }

    /// Takes what has come; whether there was something.
    pub(crate) fn read(&mut self) -> bool {
        let mut came = false;
        while let Some(slice) = self.subscription.next(Duration::ZERO).unwrap() {
            came = true;
            for state in slice.iter() {
                match TrackState::from_code(state.state) {
                    Some(TrackState::Terminated) => drop(self.tracks.remove(&state.track_number)),
                    _ => drop(self.tracks.insert(state.track_number, *state)),
                }
            }
        }
        came
    }

    pub(crate) fn numbers(&self) -> Vec<u32> {
        self.tracks.keys().copied().collect()
    }

    fn sequences(&self) -> Vec<u64> {
        self.tracks.values().map(|track| track.sequence).collect()
    }

    /// Waits until it has the tracks that `original` has, each in its newest state.
    pub(crate) fn agrees_with(&mut self, original: &mut Self, here: &Host) {
        let numbers = RefCell::new((Vec::new(), Vec::new()));
        until(
            || {
                original.read();
                self.read();
                numbers.replace((original.numbers(), self.numbers()));
                !original.tracks.is_empty() && original.sequences() == self.sequences()
            },
            || format!("{:?}\n{}", numbers.borrow(), here.status("tower")),
        );
    }
}

/// A mirror, ended with the test.
pub(crate) struct Mirror(Child);

impl Drop for Mirror {
    fn drop(&mut self) {
        let _ = Command::new("kill").args(["-TERM", &self.0.id().to_string()]).status();
        let _ = self.0.wait();
    }
}

/// A mirror on `host` of the deployment that `config` describes and whose link is at `endpoint`.
pub(crate) fn mirror(host: &Host, config: &str, endpoint: &str, options: &[&str]) -> Mirror {
    let path = host.path("tower.toml");
    std::fs::write(&path, config).unwrap();
    let mut command = host.command(Path::new(env!("CARGO_BIN_EXE_koseki-link")));
    command.arg("mirror").arg("--config").arg(path);
    command.args(["--connect", endpoint]).args(options);
    command.stdin(Stdio::null()).stdout(Stdio::null());
    Mirror(command.spawn().unwrap())
}

/// A world whose targets come and go, and a link at `endpoint` with what else is to be said of it.
pub(crate) fn tower(endpoint: &str, link: &str) -> String {
    format!(
        "name = \"tower\"\n\
         [frame]\nlatitude_deg = 41.3\nlongitude_deg = 2.1\n\
         [scenario]\ntargets = 30\n\
         [[source]]\nname = \"multilateration\"\nperiod_s = 1.0\n\
         [source.simulated]\nkind = \"multilateration\"\ndropouts_per_hour = 100.0\nfalse_tracks_per_period = 1.0\n\
         [source.covariance]\nfrom = \"report\"\nposition_sigma_m = 5.0\n\
         [recorder]\nenabled = false\n\
         [[link]]\nname = \"out\"\nlisten = [\"{endpoint}\"]\n\
         send = [\"system/tracks\", \"health\"]\n{link}"
    )
}

#[test]
fn a_mirror_that_joins_late_and_is_cut_off_shows_the_picture_as_it_is() {
    let (Some(there), Some(here)) = (Host::new(), Host::new()) else {
        return;
    };
    let port = free_port();
    let config = tower(&format!("tcp/127.0.0.1:{port}"), "");
    let mut deployment = there.up("tower", &config, &[]);
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
    let _mirror = mirror(&here, &config, &format!("tcp/127.0.0.1:{}", relay.port()), &[]);
    let mut reflection = Reader::until_there(&here, "tower");
    reflection.agrees_with(&mut original, &here);
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
    reflection.agrees_with(&mut original, &here);
}

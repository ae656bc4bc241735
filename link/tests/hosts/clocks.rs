//! Hosts whose monotonic clocks count from starts of their own.

use std::time::Duration;

use bus::Payload;
use koseki_client::messages::{Health, SensorTrack, SystemTrack, Topic, health, sensor_tracks, system_tracks};
use koseki_client::{Root, Subscription};

use crate::host::{Host, until};
use crate::mirror::{Reader, mirror};
use crate::network::Network;

/// Age of what has just come: some time on the way, by two clocks that were compared over the same way.
const AGE_S: std::ops::Range<f64> = -0.5..30.0;
/// Samples of each kind that are looked at.
const SAMPLES: usize = 50;

fn west(endpoint: &str) -> String {
    format!(
        "name = \"west\"\n[frame]\nlatitude_deg = 41.3\nlongitude_deg = 2.1\n[scenario]\ntargets = 30\n\
         [recorder]\nenabled = false\n\
         [[source]]\nname = \"multilateration\"\nperiod_s = 1.0\n[source.simulated]\nkind = \"multilateration\"\n\
         [source.covariance]\nfrom = \"report\"\nposition_sigma_m = 5.0\n\
         [[link]]\nname = \"out\"\nlisten = [\"{endpoint}\"]\ninsecure = true\n\
         send = [\"sensor/multilateration/tracks\", \"system/tracks\", \"health\"]\n"
    )
}

fn east(endpoint: &str) -> String {
    format!(
        "name = \"east\"\n[frame]\nlatitude_deg = 41.9\nlongitude_deg = 3.1\n[recorder]\nenabled = false\n\
         [[source]]\nname = \"multilateration\"\nperiod_s = 1.0\n[source.external]\n\
         [[link]]\nname = \"in\"\nconnect = [\"{endpoint}\"]\ninsecure = true\nsend = []\n\
         [[link.receive]]\ndeployment = \"west\"\ntopic = \"sensor/multilateration/tracks\"\n"
    )
}

/// Ages of samples as they were published on a host: time from a stamp to the publication, both by the host's clock.
struct Ages<T: Payload> {
    subscription: Subscription<T>,
    /// The stamp; `None` where it has not been reached.
    stamp_ns: fn(&T) -> Option<i64>,
    known: usize,
}

impl<T: Payload> Ages<T> {
    fn of(host: &Host, instance: &str, topic: &Topic<T>, stamp_ns: fn(&T) -> Option<i64>) -> Self {
        let root = Root::in_base(host.shared(), instance).unwrap();
        Self {
            subscription: Subscription::at(&root, topic).unwrap(),
            stamp_ns,
            known: 0,
        }
    }

    /// Looks at what has come; whether that is enough.
    fn look(&mut self) -> bool {
        while let Some(slice) = self.subscription.next(Duration::ZERO).unwrap() {
            for stamp_ns in slice.iter().filter_map(self.stamp_ns) {
                let age_s = (slice.header().sent_ns - stamp_ns) as f64 * 1e-9;
                assert!(AGE_S.contains(&age_s), "{age_s} s old");
                self.known += 1;
            }
        }
        self.known >= SAMPLES
    }
}

fn reached(stamp_ns: i64) -> Option<i64> {
    (stamp_ns != 0).then_some(stamp_ns)
}

#[test]
fn a_sensor_and_the_picture_of_a_host_with_another_clock_are_as_old_as_they_are() {
    let Some(network) = Network::new() else { return };
    let [there, here] = &network.hosts;
    let config = west(&network.endpoint);
    let mut west_up = there.up("west", &config, &[]);
    let mut east_up = here.up("east", &east(&network.endpoint), &[]);
    west_up.until_up();
    east_up.until_up();
    let _mirror = mirror(here, &config, &network.endpoint, &["--topics", "system/tracks,health"]);
    let mut shown = Reader::until_there(here, "west");
    network.until_said("east", "west ");
    let mut sensor = Ages::<SensorTrack>::of(here, "east", &sensor_tracks("multilateration"), |track| {
        reached(track.stages.ingested_ns)
    });
    let mut fused = Ages::<SystemTrack>::of(here, "east", &system_tracks(), |track| {
        reached(track.stages.ingested_ns)
    });
    let mut mirrored = Ages::<SystemTrack>::of(here, "west", &system_tracks(), |track| reached(track.stages.fused_ns));
    let mut said = Ages::<Health>::of(here, "west", &health(), |said| reached(said.said_ns));
    let mut all_are_young = || {
        until(
            || {
                let looks = [sensor.look(), fused.look(), mirrored.look(), said.look()];
                looks.iter().all(|enough| *enough)
            },
            || here.status("east"),
        );
        (sensor.known, fused.known, mirrored.known, said.known) = (0, 0, 0, 0);
    };
    all_are_young();
    if network.wire("down") {
        network.until_said("east", "west is not there");
        assert!(network.wire("up"));
        all_are_young();
    }
    let mut original = Reader::of(there, "west");
    shown.agrees_with(&mut original, here);
}

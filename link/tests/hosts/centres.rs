//! Two centres that exchange what their own sensors say.

use std::collections::BTreeMap;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use koseki_client::messages::{Covariance, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use koseki_client::{Publisher, Root};

use crate::host::{Deployment, Host, PATIENCE, free_port};
use crate::mirror::Reader;

pub(crate) const TARGETS: u32 = 20;
/// Time between two reports of a target.
const PERIOD: Duration = Duration::from_millis(200);
/// Speed of the targets, metres per second.
const SPEED_MPS: f64 = 100.0;
/// Number of the tracks of target 0 at each centre's sensor.
const FIRST: [u32; 2] = [100, 700];

/// Names of the two.
pub(crate) const NAMES: [&str; 2] = ["west", "east"];

/// A centre called `name` with the number `origin` that has a sensor of its own and is joined with `other`.
fn centre(name: &str, origin: u32, other: &str, endpoint: &str) -> String {
    format!(
        r#"
name = "{name}"
origin = {origin}
[frame]
latitude_deg = 41.3
longitude_deg = 2.1
[fusion]
exchange = true
[[source]]
name = "sensor-of-{name}"
period_s = 0.5
[source.external]
[[source]]
name = "{other}"
period_s = 1.0
shares = "unknown"
[source.external]
[[link]]
name = "centres"
{endpoint}
send = ["system/own-tracks"]
[[link.receive]]
deployment = "{other}"
topic = "system/own-tracks"
into = "sensor/{other}/tracks"
"#
    )
}

/// What a sensor says of all targets now, which stand still and fly east from `begun` on. Sensors are off by some
/// metres, each by others.
pub(crate) fn reports(sensor: usize, begun: SystemTime) -> Vec<SensorTrack> {
    let now = SystemTime::now();
    let flown = now.duration_since(begun).ok();
    let flown_s = flown.map_or(0.0, |flown| flown.as_secs_f64());
    let speed_mps = if flown.is_some() { SPEED_MPS } else { 0.0 };
    let now_ns = now.duration_since(UNIX_EPOCH).unwrap().as_nanos() as i64;
    let report = |target: u32| SensorTrack {
        time_of_measurement_ns: now_ns,
        track_number: FIRST[sensor] + target,
        valid: sensor_track_bits::HEIGHT | sensor_track_bits::VELOCITY | sensor_track_bits::OWN_COVARIANCE,
        position_m: [SPEED_MPS * flown_s + 5.0 * sensor as f64, 4e3 * f64::from(target), 5e3],
        velocity_mps: [speed_mps, 0.0, 0.0],
        covariance: Covariance::diagonal([30.0; 3], [3.0; 3]),
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    };
    (0..TARGETS).map(report).collect()
}

/// Whether a reader of the centre with the number `origin` sees every target once, with its own sensor and the other
/// centre as contributors, or by the other centre alone.
fn sees_all(reader: &mut Reader, origin: u32, by_both: bool) -> bool {
    reader.read();
    let wanted = |track: &&SystemTrack| {
        let of = |wanted: u32| move |other: u32| other == wanted;
        let has = |is: &dyn Fn(u32) -> bool| track.contributions().iter().any(|each| is(each.origin));
        track.origin == origin && has(&of(0)) == by_both && has(&of(3 - origin))
    };
    reader.tracks.len() == TARGETS as usize && reader.tracks.values().filter(wanted).count() == TARGETS as usize
}

/// Two centres that are joined, each with a sensor that says what the test wants.
pub(crate) struct Centres {
    pub(crate) hosts: [Host; 2],
    sensors: [Publisher<SensorTrack>; 2],
    pub(crate) readers: [Reader; 2],
    begun: SystemTime,
    // Before the hosts' folders go.
    _up: [Deployment; 2],
}

impl Centres {
    /// Starts both. `None` where Koseki has not been built.
    pub(crate) fn up() -> Option<Self> {
        Self::up_with("")
    }

    /// Starts both, with `more` in the configuration of each.
    fn up_with(more: &str) -> Option<Self> {
        let hosts = [Host::new()?, Host::new()?];
        let endpoint = format!("[\"tcp/127.0.0.1:{}\"]", free_port());
        let start = |number: usize, joins: &str| {
            let (name, other) = (NAMES[number], NAMES[1 - number]);
            let config = centre(name, number as u32 + 1, other, &format!("{joins} = {endpoint}")) + more;
            hosts[number].up(name, &config, &[])
        };
        let mut up = [start(0, "listen"), start(1, "connect")];
        up.iter_mut().for_each(Deployment::until_up);
        let sensor = |number: usize| {
            let name = NAMES[number];
            let root = Root::in_base(hosts[number].shared(), name).unwrap();
            Publisher::<SensorTrack>::at(&root, &format!("sensor-of-{name}")).unwrap()
        };
        Some(Self {
            sensors: [sensor(0), sensor(1)],
            readers: [Reader::of(&hosts[0], NAMES[0]), Reader::of(&hosts[1], NAMES[1])],
            begun: SystemTime::now(),
            _up: up,
            hosts,
        })
    }

    /// The first of the sensors, so many, say what they see now.
    pub(crate) fn report(&mut self, reporting: usize) {
        for (number, sensor) in self.sensors.iter_mut().enumerate().take(reporting) {
            sensor.publish(&reports(number, self.begun)).unwrap();
        }
    }

    /// The sensors report until all targets are seen: by both centres, or in the east by the west alone.
    pub(crate) fn report_until_seen(&mut self, reporting: usize) {
        let begun = Instant::now();
        loop {
            self.report(reporting);
            std::thread::sleep(PERIOD);
            let [of_west, of_east] = &mut self.readers;
            let is_in_west = reporting == 1 || sees_all(of_west, 1, true);
            if sees_all(of_east, 2, reporting == 2) && is_in_west {
                return;
            }
            assert!(begun.elapsed() < PATIENCE, "{}", self.status());
        }
    }

    /// The sensors report until both centres say that the one with the number `owner` here owns every target: at the
    /// other one, each track says its number there.
    fn report_until_owned(&mut self, owner: usize) {
        let begun = Instant::now();
        loop {
            self.report(2);
            std::thread::sleep(PERIOD);
            for reader in &mut self.readers {
                reader.read();
            }
            let [there, here] = [owner, 1 - owner].map(|number| &self.readers[number].tracks);
            let is_own = |track: &SystemTrack| track.owner_track_number == 0;
            let says_number = |track: &SystemTrack| {
                let mut parts = track.contributions().iter();
                let part = parts.find(|part| part.track_number == track.owner_track_number);
                let origin = owner as u32 + 1;
                part.is_some_and(|part| part.origin == origin) && there.contains_key(&track.owner_track_number)
            };
            let all = |tracks: &BTreeMap<u32, SystemTrack>| tracks.len() == TARGETS as usize;
            let is_whole = all(there) && all(here);
            if is_whole && there.values().all(is_own) && here.values().all(says_number) {
                return;
            }
            // The first of the two waits for the picture, too.
            assert!(is_whole || owner == 0, "a target has no track, or two");
            assert!(begun.elapsed() < PATIENCE, "{}", self.status());
        }
    }

    pub(crate) fn status(&self) -> String {
        let of = |number: usize| self.hosts[number].status(NAMES[number]);
        format!("{}\n{}", of(0), of(1))
    }
}

#[test]
fn each_centre_has_every_target_once_with_what_both_say_and_keeps_it_by_the_other_alone() {
    let Some(mut centres) = Centres::up() else { return };
    centres.report_until_seen(2);
    let numbers = centres.readers[1].numbers();
    centres.report_until_seen(1);
    assert_eq!(centres.readers[1].numbers(), numbers, "no number has changed");
    // Neither a list with anything in it, nor a note.
    let status = centres.status().replace("\"refused\": []", "");
    assert!(!status.contains("refused"), "{status}");
}

/// The border runs 300 m east of where the targets begin.
const REGIONS: &str = "
[[region]]
name = \"west\"
origin = 1
corners_deg = [[40.0, 0.0], [43.0, 0.0], [43.0, 2.1036], [40.0, 2.1036]]
[[region]]
name = \"east\"
origin = 2
corners_deg = [[40.0, 2.1036], [43.0, 2.1036], [43.0, 4.0], [40.0, 4.0]]
[fusion.border]
strip_m = 20000
hand_over_m = 50
hand_over_s = 1
";

#[test]
fn targets_that_fly_over_the_border_change_hands_and_both_centres_know_the_owners_number() {
    let Some(mut centres) = Centres::up_with(REGIONS) else {
        return;
    };
    // They wait in the west.
    centres.begun = SystemTime::now() + 2 * PATIENCE;
    centres.report_until_owned(0);
    let numbers = [0, 1].map(|number: usize| centres.readers[number].numbers());
    centres.begun = SystemTime::now();
    centres.report_until_owned(1);
    assert_eq!([0, 1].map(|number: usize| centres.readers[number].numbers()), numbers);
}

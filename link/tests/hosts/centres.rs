//! Two centres that exchange what their own sensors say.

use std::cell::RefCell;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use koseki_client::messages::{Covariance, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use koseki_client::{Publisher, Root};

use crate::host::{Host, free_port, until};
use crate::mirror::Reader;

const TARGETS: u32 = 20;
/// Time between two reports of a target.
const PERIOD: Duration = Duration::from_millis(200);
/// Number of the tracks of target 0 at each centre's sensor.
const FIRST: [u32; 2] = [100, 700];

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

/// What a sensor says of all targets now. Sensors are off by some metres, each by others.
fn reports(sensor: usize, begun: SystemTime) -> Vec<SensorTrack> {
    let now = SystemTime::now();
    let flown_s = now.duration_since(begun).unwrap().as_secs_f64();
    let now_ns = now.duration_since(UNIX_EPOCH).unwrap().as_nanos() as i64;
    let report = |target: u32| SensorTrack {
        time_of_measurement_ns: now_ns,
        track_number: FIRST[sensor] + target,
        valid: sensor_track_bits::HEIGHT | sensor_track_bits::VELOCITY | sensor_track_bits::OWN_COVARIANCE,
        position_m: [100.0 * flown_s + 5.0 * sensor as f64, 4e3 * f64::from(target), 5e3],
        velocity_mps: [100.0, 0.0, 0.0],
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

#[test]
fn each_centre_has_every_target_once_with_what_both_say_and_keeps_it_by_the_other_alone() {
    let (Some(west), Some(east)) = (Host::new(), Host::new()) else {
        return;
    };
    let endpoint = format!("[\"tcp/127.0.0.1:{}\"]", free_port());
    let config = centre("west", 1, "east", &format!("listen = {endpoint}"));
    let mut west_up = west.up("west", &config, &[]);
    let config = centre("east", 2, "west", &format!("connect = {endpoint}"));
    let mut east_up = east.up("east", &config, &[]);
    west_up.until_up();
    east_up.until_up();
    let begun = SystemTime::now();
    let sensor = |host: &Host, name: &str| {
        let root = Root::in_base(host.shared(), name).unwrap();
        Publisher::<SensorTrack>::at(&root, &format!("sensor-of-{name}")).unwrap()
    };
    let sensors = RefCell::new([sensor(&west, "west"), sensor(&east, "east")]);
    let readers = RefCell::new([Reader::of(&west, "west"), Reader::of(&east, "east")]);
    // The sensors that report, until all targets are seen: by both centres, or in the east by the west alone.
    let report_until = |reporting: usize| {
        until(
            || {
                for (number, sensor) in sensors.borrow_mut().iter_mut().enumerate().take(reporting) {
                    sensor.publish(&reports(number, begun)).unwrap();
                }
                std::thread::sleep(PERIOD);
                let [of_west, of_east] = &mut *readers.borrow_mut();
                let is_in_west = reporting == 1 || sees_all(of_west, 1, true);
                sees_all(of_east, 2, reporting == 2) && is_in_west
            },
            || format!("{}\n{}", west.status("west"), east.status("east")),
        );
    };
    report_until(2);
    let numbers = readers.borrow()[1].numbers();
    report_until(1);
    assert_eq!(readers.borrow()[1].numbers(), numbers, "no number has changed");
    drop((west_up, east_up));
}

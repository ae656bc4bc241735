//! A sensor on another host whose reports are fused in the order of their arrival.
//!
//! The host of the sensor fuses it too. Every report comes; each gives the state there that it gave here, later by the
//! time on the way.

use std::collections::BTreeMap;
use std::time::{Duration, SystemTime};

use koseki_client::messages::{SensorTrack, SystemTrack, sensor_tracks, system_tracks};
use koseki_client::{Publisher, Root, Subscription};

use crate::centres::{TARGETS, reports};
use crate::host::{Host, free_port, until};
use crate::relay::{Delays, Relay};

/// Number of a track that is not looked at.
const OTHER: u32 = 1;
const SENSOR: &str = "radar";
const COMMON: &str = "[frame]\nlatitude_deg = 41.3\nlongitude_deg = 2.1\n[recorder]\nenabled = false\n\
     [[source]]\nname = \"radar\"\nperiod_s = 0.5\n[source.external]\n";
const DELAYS: Delays = Delays {
    mean: Duration::from_millis(20),
    jitter: Duration::from_millis(5),
};
/// Difference of positions that is none, metres: the host that the sensor is on has heard more before they met.
const SAME_M: f64 = 1e-3;
/// Times that the sensor reports all targets, and the time between two of them.
const SCANS: usize = 30;
const PERIOD: Duration = Duration::from_millis(100);

/// What a host has of each report, by the number of the sensor's track and the time of the measurement.
struct Seen {
    reports: Subscription<SensorTrack>,
    states: Subscription<SystemTrack>,
    /// When it was published.
    published_ns: BTreeMap<(u32, i64), i64>,
    /// Where the first state is that it gave.
    positions: BTreeMap<(u32, i64), [f64; 3]>,
    have_met: bool,
}

impl Seen {
    fn on(host: &Host, instance: &str) -> Self {
        let root = Root::in_base(host.shared(), instance).unwrap();
        Self {
            reports: Subscription::at(&root, &sensor_tracks(SENSOR)).unwrap(),
            states: Subscription::at(&root, &system_tracks()).unwrap(),
            published_ns: BTreeMap::new(),
            positions: BTreeMap::new(),
            have_met: false,
        }
    }

    fn look(&mut self) {
        while let Some(slice) = self.reports.next(Duration::ZERO).unwrap() {
            for report in slice.iter() {
                let key = (report.track_number, report.time_of_measurement_ns);
                match report.track_number {
                    OTHER => self.have_met = true,
                    _ => drop(self.published_ns.insert(key, report.stages.published_ns)),
                }
            }
        }
        while let Some(slice) = self.states.next(Duration::ZERO).unwrap() {
            for state in slice.iter() {
                let number = state.contributions().first().map_or(OTHER, |first| first.track_number);
                if number != OTHER {
                    let position_m = self.positions.entry((number, state.time_of_measurement_ns));
                    position_m.or_insert(state.position_m);
                }
            }
        }
    }
}

#[test]
fn in_order_of_arrival_each_report_gives_the_state_that_it_gave_at_home_only_later() {
    let (Some(west), Some(east)) = (Host::new(), Host::new()) else {
        return;
    };
    let port = free_port();
    let relay = Relay::to(port, DELAYS);
    let home = format!(
        "name = \"west\"\n{COMMON}[[link]]\nname = \"out\"\nlisten = [\"tcp/127.0.0.1:{port}\"]\n\
         send = [\"sensor/{SENSOR}/tracks\"]\n"
    );
    let away = format!(
        "name = \"east\"\n{COMMON}[[link]]\nname = \"in\"\nconnect = [\"tcp/127.0.0.1:{}\"]\nsend = []\n\
         [[link.receive]]\ndeployment = \"west\"\ntopic = \"sensor/{SENSOR}/tracks\"\n",
        relay.port()
    );
    let mut west_up = west.up("west", &home, &[]);
    let mut east_up = east.up("east", &away, &[]);
    west_up.until_up();
    east_up.until_up();
    let mut here = Seen::on(&west, "west");
    let mut there = Seen::on(&east, "east");
    let root = Root::in_base(west.shared(), "west").unwrap();
    let mut sensor = Publisher::<SensorTrack>::at(&root, SENSOR).unwrap();
    let status = || format!("{}\n{}", west.status("west"), east.status("east"));
    let begun = SystemTime::now();
    // Until the hosts have met, of something else.
    until(
        || {
            let far = SensorTrack {
                track_number: OTHER,
                position_m: [-80e3; 3],
                ..reports(0, begun)[0]
            };
            sensor.publish(&[far]).unwrap();
            there.look();
            there.have_met
        },
        status,
    );
    let sent_before = sensor.sent();
    for _ in 0..SCANS {
        sensor.publish(&reports(1, begun)).unwrap();
        std::thread::sleep(PERIOD);
    }
    let sent = (sensor.sent() - sent_before) as usize;
    until(
        || {
            [&mut here, &mut there].into_iter().for_each(Seen::look);
            let all = there.published_ns.len() == sent && here.published_ns.len() == sent;
            let newest = here.published_ns.keys().map(|(_, at_ns)| *at_ns).max();
            let is_last = |(_, at_ns): &&(u32, i64)| Some(*at_ns) == newest;
            let last = |seen: &Seen| seen.positions.keys().filter(is_last).count();
            all && [&here, &there].iter().all(|seen| last(seen) == TARGETS as usize)
        },
        status,
    );
    let pairs = here.positions.iter().zip(&there.positions);
    let differ = pairs.filter(|((key, [x, y, z]), (other_key, other))| {
        let off_m = (x - other[0]).abs() + (y - other[1]).abs() + (z - other[2]).abs();
        key != other_key || off_m > SAME_M
    });
    assert_eq!(
        (here.positions.len(), differ.count()),
        (there.positions.len(), 0),
        "each gave the same state"
    );
    let late_ns = there
        .published_ns
        .iter()
        .map(|(key, at_ns)| at_ns - here.published_ns[key]);
    let mut late_ms: Vec<f64> = late_ns.map(|late_ns| late_ns as f64 * 1e-6).collect();
    late_ms.sort_by(f64::total_cmp);
    println!(
        "{sent} reports came {:.1} ms late in the median, {:.1} to {:.1} ms, and gave {} states, all the same",
        late_ms[sent / 2],
        late_ms[0],
        late_ms[sent - 1],
        there.positions.len()
    );
    assert!(
        late_ms[0] >= (DELAYS.mean - DELAYS.jitter).as_secs_f64() * 1e3,
        "{late_ms:?}"
    );
}

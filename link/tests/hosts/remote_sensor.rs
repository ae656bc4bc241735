//! A sensor on another host.

use std::cell::Cell;
use std::time::{Duration, Instant};

use koseki_client::messages::{SensorTrack, sensor_tracks};
use koseki_client::{Root, Subscription};

use crate::host::{Host, free_port, until};
use crate::relay::{Delays, Relay};

const COMMON: &str = r#"
[frame]
latitude_deg = 41.297063
longitude_deg = 2.078447
[time]
order = "time"
date = "2026-11-01"
"#;
const NORTH: &str = r#"
[[source]]
name = "radar-north"
period_s = 4.0
[source.place]
latitude_deg = 41.599574
longitude_deg = 2.049661
height_m = 389.2
[source.recorded]
file = "radar-north.ast"
sac = 0
sic = 1
[source.covariance]
range_sigma_m = 50.0
azimuth_sigma_deg = 0.07
"#;
const SOUTH: &str = r#"
[[source]]
name = "radar-south"
period_s = 4.0
[source.place]
latitude_deg = 41.279731
longitude_deg = 1.850486
height_m = 598.8
[source.recorded]
file = "radar-south.ast"
sac = 0
sic = 2
[source.covariance]
range_sigma_m = 50.0
azimuth_sigma_deg = 0.07
"#;
const SOUTH_ELSEWHERE: &str = r#"
[[source]]
name = "radar-south"
period_s = 4.0
[source.external]
"#;
const MULTILATERATION: &str = r#"
[[source]]
name = "multilateration"
period_s = 1.0
[source.recorded]
file = "multilateration.ast"
sac = 0
sic = 3
[source.covariance]
from = "report"
position_sigma_m = 5.0
"#;
/// A minute of recordings in six seconds.
const FAST: [&str; 2] = ["--speed", "10"];
/// Length of the recordings, seconds.
const RECORDED_S: f64 = 60.0;
/// Time of a run with a cut beyond the cut, seconds: what is sent before and after it.
const BESIDE_CUT_S: f64 = 25.0;
/// Pause between two looks.
const PAUSE: Duration = Duration::from_millis(10);
/// Reports that have come before the cut.
const BEFORE_CUT: usize = 100;
/// Cuts of the connection: shorter than a round trip's timeout, and longer than the lease of a session, so that both
/// sides have noticed.
const CUTS: [Duration; 2] = [Duration::from_millis(100), Duration::from_secs(3)];
/// Time within which the relay's last bytes have reached the subscriber.
const PASSED: Duration = Duration::from_millis(1500);

#[test]
fn fusion_in_order_of_time_makes_the_same_of_a_sensor_behind_a_slow_line() {
    is_the_same_as_on_one_host(&FAST, |_, _| {});
}

#[test]
fn a_cut_loses_no_report_and_fusion_in_order_of_time_makes_the_same() {
    for cut in CUTS {
        loses_nothing_by_a_cut_of(cut);
    }
}

/// Cuts of `KOSEKI_CUTS`, seconds between commas: up to a minute, beyond the time that the test above may take.
#[test]
#[ignore = "takes longer than its cuts"]
fn cuts_of_any_length_lose_no_report() {
    let cuts = std::env::var("KOSEKI_CUTS").unwrap_or_else(|_| "0.3,1,10,30,60".to_owned());
    for cut in cuts.split(',') {
        loses_nothing_by_a_cut_of(Duration::from_secs_f64(cut.trim().parse().unwrap()));
        println!("a cut of {cut} s: no report lost, the same system tracks");
    }
}

fn loses_nothing_by_a_cut_of(length: Duration) {
    let speed = RECORDED_S / (length.as_secs_f64() + BESIDE_CUT_S);
    is_the_same_as_on_one_host(&["--speed", &format!("{speed:.2}")], |relay, east| {
        let root = Root::in_base(east.shared(), "east").unwrap();
        let mut reports: Subscription<SensorTrack> = Subscription::at(&root, &sensor_tracks("radar-south")).unwrap();
        let come = Cell::new(0);
        let mut read = || {
            let mut more = 0;
            while let Some(slice) = reports.next(Duration::ZERO).unwrap() {
                more += slice.len();
            }
            come.set(come.get() + more);
            more
        };
        until(
            || {
                read();
                come.get() >= BEFORE_CUT
            },
            || east.status("east"),
        );
        relay.cut();
        let cut = Instant::now();
        while cut.elapsed() < length {
            let more = read();
            let has_passed = cut.elapsed() > PASSED;
            assert!(!has_passed || more == 0, "the relay still lets reports pass");
            std::thread::sleep(PAUSE);
        }
        relay.mend();
        until(|| read() > 0, || east.status("east"));
        let status = east.status("east");
        assert!(!status.contains("lost on the way"), "{status}");
    });
}

/// Runs a deployment on one host, and on two of which one has a sensor, whose line `meanwhile` may disturb.
fn is_the_same_as_on_one_host(speed: &[&str], meanwhile: impl FnOnce(&Relay, &Host)) {
    let Some(host) = Host::new() else { return };
    let local = format!("name = \"local\"{COMMON}{NORTH}{SOUTH}{MULTILATERATION}");
    host.up("local", &local, &["--speed", "max"]).until_ended();

    let port = free_port();
    let delays = Delays {
        mean: Duration::from_millis(20),
        jitter: Duration::from_millis(5),
    };
    let relay = Relay::to(port, delays);
    let near = relay.port();
    let (west, east) = (Host::new().unwrap(), Host::new().unwrap());
    let link = format!(
        "[[link]]\nname = \"in\"\nconnect = [\"tcp/127.0.0.1:{near}\"]\nsend = []\n\
         [[link.receive]]\ndeployment = \"west\"\ntopic = \"sensor/radar-south/tracks\"\n"
    );
    let config = format!("name = \"east\"{COMMON}{NORTH}{SOUTH_ELSEWHERE}{MULTILATERATION}{link}");
    let mut fused = east.up("east", &config, speed);
    fused.until_up();
    let link = format!(
        "[[link]]\nname = \"out\"\nlisten = [\"tcp/127.0.0.1:{port}\"]\nsend = [\"sensor/radar-south/tracks\"]\n"
    );
    let sensor = west.up("west", &format!("name = \"west\"{COMMON}{SOUTH}{link}"), speed);
    meanwhile(&relay, &east);
    sensor.until_ended();
    let said = fused.until_ended();
    assert!(east.system_tracks("east") == host.system_tracks("local"), "{said}");
    assert!(host.system_tracks("local").lines().count() > 4_000);
}

//! A sensor on another host.

use std::time::Duration;

use crate::host::{Host, free_port};
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

#[test]
fn fusion_in_order_of_time_makes_the_same_of_a_sensor_behind_a_slow_line() {
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
    let mut fused = east.up("east", &config, &FAST);
    fused.until_up();
    let link = format!(
        "[[link]]\nname = \"out\"\nlisten = [\"tcp/127.0.0.1:{port}\"]\nsend = [\"sensor/radar-south/tracks\"]\n"
    );
    let sensor = west.up("west", &format!("name = \"west\"{COMMON}{SOUTH}{link}"), &FAST);
    sensor.until_ended();
    let said = fused.until_ended();
    assert!(east.system_tracks("east") == host.system_tracks("local"), "{said}");
    assert!(host.system_tracks("local").lines().count() > 4_000);
}

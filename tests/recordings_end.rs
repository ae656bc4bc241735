//! A deployment of recordings ends with them, in either order of reports.

use serde_json::Value;

use crate::common::Home;

/// Positions of two ships that go north, ten seconds apart: table of named columns.
fn ships() -> [String; 2] {
    [211_000_001_u32, 211_000_002].map(|mmsi| {
        let row = |step: u32| {
            let (time, latitude) = (1_717_664_400 + 10 * step, 54.0 + 5e-4 * f64::from(step));
            format!("{time},{latitude:.5},{},{mmsi}\n", 8.0 + f64::from(mmsi % 10) / 10.0)
        };
        let rows: String = (0..12).map(row).collect();
        format!("time,latitude,longitude,mmsi\n{rows}")
    })
}

/// Runs the recordings in an order until they end; returns the report.
fn ended(home: &Home, order: &str, speed: &str) -> Value {
    let source = |name: &str| {
        format!(
            "[[source]]\nname = \"{name}\"\nperiod_s = 10.0\n[source.recorded]\nfile = \"{name}.csv\"\n\
             format = \"sensor-tracks\"\n[source.limits]\nrange_m = 2000000.0\n"
        )
    };
    let site = format!(
        "name = \"test\"\n[frame]\nlatitude_deg = 54.0\nlongitude_deg = 8.0\n[time]\ndate = \"2024-06-06\"\n\
         order = \"{order}\"\n{}{}",
        source("first"),
        source("second")
    );
    let (name, out) = (format!("{order}.toml"), format!("out-{order}-{speed}"));
    home.write(&name, site);
    let running = home.start(&["up", &name, "--data", ".", "--speed", speed, "--out", &out]);
    let (status, said) = running.end();
    assert_eq!(status.code(), Some(0), "order {order}, speed {speed}: {said}");
    serde_json::from_str(&home.read(&format!("{out}/latest/report.json"))).unwrap()
}

#[test]
fn a_deployment_of_recordings_ends_in_order_of_time_and_of_arrival() {
    let home = Home::new();
    let [first, second] = ships();
    home.write("first.csv", first);
    home.write("second.csv", second);
    for (order, speed) in [("time", "max"), ("arrival", "max"), ("arrival", "50")] {
        let report = ended(&home, order, speed);
        assert_eq!(report["picture"]["ever_confirmed"], 2, "{order} {speed}: {report}");
        home.assert_nothing_is_left(order);
    }
}

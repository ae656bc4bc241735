//! Levels of transponders, from what a sensor sends to what the recorder has, far from the system's origin.

use std::collections::BTreeMap;

use asterix::{Decoder, Mode, NamedRecord, Value};

use crate::common::Home;

/// A world of 400 km and more to each side, and one source that hears all of it.
const WORLD: &str = r#"name = "wide"
[frame]
latitude_deg = 41.3
longitude_deg = 2.1
[scenario]
targets = 60
half_width_m = 400000.0
[[source]]
name = "ads-b"
period_s = 1.0
[source.simulated]
kind = "ads-b"
range_max_m = 390000.0
"#;

/// The deployment that replays what that source sends.
const SITE: &str = r#"name = "wide"
[frame]
latitude_deg = 41.3
longitude_deg = 2.1
[time]
order = "time"
date = "1970-01-01"
[[source]]
name = "ads-b"
period_s = 1.0
[source.recorded]
file = "made/asterix_1.ast"
[source.limits]
range_m = 450000.0
[monitor]
files = false
"#;
/// 160 nautical miles, metres.
const FAR_M: f64 = 160.0 * 1_852.0;
/// Highest that simulated targets fly, hundreds of feet.
const HIGHEST: f64 = 430.0;

#[test]
fn the_level_of_every_state_is_the_transponders_out_to_160_miles() {
    let home = Home::new();
    home.write("world.toml", WORLD);
    home.write("site.toml", SITE);
    for arguments in [
        "simulate --scenario world.toml --asterix --for 40 --out made",
        "up site.toml --data . --speed max --out out",
    ] {
        let output = home.run(&arguments.split(' ').collect::<Vec<_>>());
        assert!(output.status.success(), "{arguments}: {output:?}");
    }
    // Levels that each target's transponder stated, by the time of measurement.
    let mut stated: BTreeMap<String, Vec<(f64, f64)>> = BTreeMap::new();
    let bytes = std::fs::read(home.path("made/asterix_1.ast")).unwrap();
    for record in Decoder::new(Mode::Strict).records(&bytes) {
        let record = NamedRecord::new(&record.unwrap());
        let number = |path: &[&str]| record.get(path).and_then(Value::as_f64);
        if let (Some(address), Some(time_s), Some(level)) = (number(&["080"]), number(&["071"]), number(&["145"])) {
            assert!(level < HIGHEST, "a height above the plane: {level}");
            let address = format!("{:06X}", address as u32);
            stated.entry(address).or_default().push((time_s, level));
        }
    }
    let text = home.read("out/latest/system_tracks.csv");
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let columns = lines.next().unwrap();
    let place = |name: &str| columns.iter().position(|column| *column == name).unwrap();
    let places = ["time_s", "x", "y", "flight_level", "level"].map(place);
    let (of_address, of_state) = (place("address"), place("state"));
    let (mut states, mut far) = (0, 0);
    for row in lines {
        let value = |place: usize| row[place].parse::<f64>().ok();
        let [Some(time_s), Some(x), Some(y), geometric, shown] = places.map(value) else {
            panic!("{row:?}");
        };
        if ["terminated", "suspended", "coasted"].contains(&row[of_state]) {
            continue;
        }
        let told = stated[row[of_address]].iter().rev();
        let newest = told.clone().find(|(stated_s, _)| *stated_s <= time_s + 1e-6).unwrap();
        assert_eq!(shown, Some(newest.1), "{row:?}");
        // The fused height is above the ellipsoid, too: it errs as the measured ones do, not by the earth's curvature.
        assert!((geometric.unwrap() - newest.1).abs() < 5.0, "{row:?}");
        states += 1;
        far += usize::from(x.hypot(y) > FAR_M);
    }
    assert!(states > 1_000 && far > 30, "{states} states, {far} far away");
}

use std::path::Path;

use deployment::{Input, SampleDelivery};
use tracking::cutting::Boundaries;

use crate::Config;

const SITE: &str = r#"name = "t"
[frame]
latitude_deg = 41.0
longitude_deg = 2.0
[[source]]
name = "own"
period_s = 0.5
[source.external]
input = "detections"
sigmas = [5.0, 5.0]
[[source]]
name = "radar"
[source.external]
[[tracker]]
name = "ship"
[[tracker.sensor]]
name = "lidar"
[tracker.sensor.external]
"#;

fn parse(text: &str) -> Result<Config, String> {
    Config::parse(Path::new("t.toml"), text, &[]).map_err(|error| error.to_string())
}

#[test]
fn a_source_of_detections_keeps_its_number_and_is_a_tracker_with_one_external_sensor() {
    let config = parse(SITE).unwrap();
    let names: Vec<&str> = config.sources.iter().map(|source| source.name.as_str()).collect();
    assert_eq!(names, ["own", "radar", "ship"]);
    assert_eq!(config.adapters(), ["own", "ship"]);
    let own = &config.sources[0];
    assert!(own.has_tracks() && matches!(own.delivers, SampleDelivery::Detections { cues: false }));
    let sensors = config.sensors_of(own);
    assert_eq!(
        (sensors[0].name.as_str(), sensors[0].number, sensors.len()),
        ("own.input", 4, 1)
    );
    assert!(matches!(sensors[0].input, Input::External) && sensors[0].has_rows());
    assert_eq!(config.sensors_of(&config.sources[2])[0].number, 3);
    let tracker = config.tracker(0).unwrap();
    let cutter = &tracker.joining.cutters[0];
    assert_eq!(
        (cutter.boundaries, cutter.period_ns),
        (Boundaries::Stated, Some(500_000_000))
    );
    assert_eq!(tracker.settings.sensors[0].sigmas, Some(vec![5.0, 5.0]));
    assert!(config.tracker(1).is_none());
}

#[test]
fn the_short_form_makes_the_same_tracker_as_the_long_form() {
    let short = parse(SITE).unwrap();
    let long = SITE.replace(
        "[[source]]\nname = \"own\"\nperiod_s = 0.5\n[source.external]\ninput = \"detections\"\nsigmas = [5.0, 5.0]\n",
        "",
    ) + "[[tracker]]\nname = \"own\"\nperiod_s = 0.5\n[[tracker.sensor]]\nname = \"input\"\nperiod_s = 0.5\n\
           sigmas = [5.0, 5.0]\n[tracker.sensor.external]\n";
    let long = parse(&long).unwrap();
    let settings = |config: &Config, name: &str| {
        let number = config.source(name).unwrap().number;
        let mut settings = config.tracker(number).unwrap().clone();
        // The numbers of the sensors follow their order in the file.
        settings.settings.sensors[0].sensor_id = 0;
        format!("{settings:?}")
    };
    assert_eq!(settings(&short, "own"), settings(&long, "own"));
}

#[test]
fn the_settings_of_its_tracker_apply() {
    let tracker = "[source.tracker]\nscans = \"period\"\ncues = true\nwait_s = 0.1\ndetection_probability = 0.5\n";
    let text = SITE.replacen(
        "[[source]]\nname = \"radar\"",
        &format!("{tracker}[[source]]\nname = \"radar\""),
        1,
    );
    let config = parse(&text).unwrap();
    let tracker = config.tracker(0).unwrap();
    assert_eq!(tracker.joining.cutters[0].boundaries, Boundaries::Period);
    assert_eq!(tracker.joining.cutters[0].wait_ns, Some(100_000_000));
    assert!(tracker.outputs.cues && config.sources[0].has_cues());
}

#[test]
fn mistakes_are_named_by_the_keys_of_the_source() {
    for (from, to, expected) in [
        ("input = \"detections\"", "input = \"plots\"", "external.input"),
        (
            "name = \"own\"",
            "name = \"a-name-of-twenty-nine-letters\"",
            "longer than 31 characters",
        ),
        ("input = \"detections\"\n", "", "sigmas"),
        ("period_s = 0.5", "uid = 0", "uid"),
    ] {
        let error = parse(&SITE.replacen(from, to, 1)).unwrap_err();
        assert!(error.contains(expected) && error.contains("source"), "{error}");
    }
}

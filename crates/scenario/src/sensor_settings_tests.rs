//! Valid and invalid settings of sensors.

use super::*;

fn read(text: &str) -> Result<SensorSettings, String> {
    let document = settings::Document::parse(text, &[]).expect("well-formed");
    document.read().map_err(|error| error.to_string())
}

#[test]
fn usual_values_are_usable() {
    for kind in SensorKind::ALL {
        read(&format!("kind = \"{}\"", kind.word())).expect("usable");
    }
    for (name, settings) in SensorSettings::demonstration() {
        settings.checked().expect(name);
    }
}

#[test]
fn messages_name_key_value_and_limit() {
    for (text, expected) in [
        (
            "kind = \"radar\"\ndetection_probability = 1.5",
            "detection_probability: 1.5 is out of range; it must lie between 0.001 and 1",
        ),
        (
            "kind = \"radar\"\nperiod_s = 4\nphase_s = 5",
            "phase_s: 5 is out of range; it must lie between 0 and 4",
        ),
        (
            "kind = \"ads-b\"\nrange_sigma_m = 5",
            "range_sigma_m: 5: leave it out; only a radar has it",
        ),
        (
            "kind = \"radar\"\ndropouts_per_hour = 100\ndropout_duration_s = 40",
            "dropout_duration_s: 40 is out of range; it must lie between 0 and 36, the time from one dropout to the next",
        ),
        (
            "kind = \"radar\"\nrange_resolution_m = 100",
            "range_resolution_m: 100: leave it out; only a sensor with plots = true has it",
        ),
        (
            "kind = \"radar\"\nplots = true\nresolved_probability = 0.1",
            "resolved_probability: 0.1 needs range_resolution_m or azimuth_resolution_rad beside it",
        ),
        (
            "kind = \"radar\"\nplots = true\nazimuth_resolution_rad = 2",
            "azimuth_resolution_rad: 2 is out of range; it must lie between 0.0000001 and 0.5",
        ),
        ("kind = \"radar\"\nperiod = 4", "period: unknown key; there are: kind, "),
        ("period_s = 4", "kind: missing"),
    ] {
        let error = read(text).unwrap_err();
        assert!(error.starts_with(expected), "{error}");
    }
}

#[test]
fn primary_radar_has_no_height() {
    let settings = read("kind = \"radar\"\nidentity = \"none\"").unwrap();
    assert_eq!(settings.checked().expect("usable").errors.height_sigma_m, None);
}

//! Settings of sensors, usable and refused.

use super::*;

fn refused(settings: &str) -> String {
    toml::from_str::<SensorSettings>(settings)
        .expect("well-formed")
        .validate()
        .expect_err("not usable")
        .to_string()
}

#[test]
fn usual_values_are_usable() {
    for kind in ["radar", "multilateration", "ads-b"] {
        let settings: SensorSettings = toml::from_str(&format!("kind = \"{kind}\"")).expect("well-formed");
        settings.validate().expect("usable");
    }
    for (name, settings) in SensorSettings::demonstration() {
        settings.validate().expect(name);
    }
}

#[test]
fn messages_name_key_value_and_limit() {
    assert_eq!(
        refused("kind = \"radar\"\ndetection_probability = 1.5"),
        "detection_probability = 1.5: must be between 0.001 and 1"
    );
    assert_eq!(
        refused("kind = \"radar\"\nperiod_s = 4\nphase_s = 5"),
        "phase_s = 5: must be between 0 and 4"
    );
    assert_eq!(
        refused("kind = \"ads-b\"\nrange_sigma_m = 5"),
        "range_sigma_m = 5: must be left out: only a radar has it"
    );
    assert_eq!(
        refused("kind = \"radar\"\ndropouts_per_hour = 100\ndropout_duration_s = 40"),
        "dropout_duration_s = 40: must be between 0 and 36, the time from one dropout to the next"
    );
    assert_eq!(
        refused("kind = \"radar\"\nrange_resolution_m = 100"),
        "range_resolution_m = 100: must be left out: only a sensor with plots = true has it"
    );
    assert_eq!(
        refused("kind = \"radar\"\nplots = true\nresolved_probability = 0.1"),
        "resolved_probability = 0.1: must be left out: needs range_resolution_m or azimuth_resolution_rad beside it"
    );
    assert_eq!(
        refused("kind = \"radar\"\nplots = true\nazimuth_resolution_rad = 2"),
        "azimuth_resolution_rad = 2: must be between 0.0000001 and 0.5"
    );
    let unknown = toml::from_str::<SensorSettings>("kind = \"radar\"\nperiod = 4");
    assert!(unknown.expect_err("unknown key").to_string().contains("period"));
}

#[test]
fn primary_radar_has_no_height() {
    let settings: SensorSettings = toml::from_str("kind = \"radar\"\nidentity = \"none\"").expect("well-formed");
    assert_eq!(settings.checked().expect("usable").errors.height_sigma_m, None);
}

//! The configuration of tracking, heard and refused.

use settings::Degrees;
use tracking::settings::{Limit, TrackerCapacity};

use super::*;

fn settings(text: &str) -> Result<Settings, String> {
    let seen = SeenDetections {
        sensor_ids: [1, 7].into(),
        scan_max: 20_000,
    };
    let parsed = Tracking::parse(Path::new("track.toml"), text);
    parsed
        .map(|config| config.settings(&seen))
        .map_err(|error| error.to_string())
}

#[test]
fn nothing_has_to_be_configured() {
    let found = settings("").unwrap();
    let usual = Settings::default();
    let capacity = TrackerCapacity {
        tracks: Some(120_000),
        detections: Some(20_000),
        open_scans: 0,
    };
    let ids: Vec<u32> = found.sensors.iter().map(|sensor| sensor.sensor_id).collect();
    assert_eq!((ids, found.capacity), (vec![1, 7], capacity));
    assert_eq!(found.sensors[0].model.detection_probability, None);
    assert_eq!(found.sensors[0].model.clutter_density, None);
    let same = Settings {
        sensors: Vec::new(),
        capacity: usual.capacity,
        ..found
    };
    assert_eq!(same, usual);
}

#[test]
fn every_key_is_heard() {
    let found = settings(
        "[[sensor]]\nid = 7\ndetection_probability = 0.8\nclutter_density = 1e-8\nsigmas = [5, 0.01]\n\
         range_rate_sigma_mps = 2\nresolution_m = 5\nfield_of_view = { range_m = [1, 90], sector_deg = [-30, 30] }\n[gate]\nprobability = 0.95\n[motion]\nprocess_noise_m2ps3 = [2.0, 3.0]\n\
         [motion.manoeuvres]\nenabled = false\n[initiation]\nnew_target_share = 0.1\nspeed_sigma_mps = 9\nslow_sigma_mps = \"off\"\n\
         climb_sigma_mps = 8\nheight_sigma_m = 7\n[confirmation]\nreliability_min = 1\ndetections_min = 4\n\
         log_likelihood_ratio_min = 5\n[deletion]\nexistence_min = 1e-6\nmean_life_s = 300\nexit_s = 7\nshown_min = 0.2\nsilent_s = 1.5\ncoherence_s = 2\n[reduction]\nmerge_scans = 3\n\
         reliability_min = 0.01\nhypotheses_max = 12\n[splitting]\nstart_in_confirmed_gates = true\n\
         new_target_share = \"off\"\nparents_motion = \"off\"\nnew_tracks_max = \"computed\"\ntentative_tracks = 3\n\
         company_min = 0.5\n[capacity]\ntracks = 100\ndetections = 50\nopen_scans = 4\n",
    )
    .unwrap();
    let sensor = &found.sensors[1];
    assert_eq!((sensor.sensor_id, sensor.model.detection_probability), (7, Some(0.8)));
    assert_eq!(sensor.model.clutter_density, Some(1e-8));
    assert_eq!(sensor.sigmas.as_deref(), Some(&[5.0, 0.01][..]));
    assert_eq!(sensor.range_rate_sigma_mps, Some(2.0));
    let view = sensor.model.field_of_view.unwrap();
    assert_eq!(
        (sensor.model.resolution_m, view.range_m, view.position_m),
        (Some(5.0), [1.0, 90.0], None)
    );
    assert_eq!(view.sector_deg, Some([-30.0, 30.0].map(Degrees::of)));
    assert_eq!((found.gate.probability, found.initiation.slow_sigma_mps), (0.95, None));
    assert_eq!(found.motion.process_noise_m2ps3, [2.0, 3.0]);
    assert!(!found.motion.manoeuvres.enabled);
    assert_eq!(
        (found.initiation.new_target_share, found.initiation.height_sigma_m),
        (0.1, 7.0)
    );
    assert_eq!(found.confirmation.log_likelihood_ratio_min, Some(5.0));
    assert_eq!(
        (
            found.deletion.limits.existence_min,
            found.deletion.limits.silent_s.ns(),
            found.deletion.coherence_s
        ),
        (1e-6, 1_500_000_000, 2.0)
    );
    assert_eq!(
        (
            found.deletion.mean_life_s,
            found.deletion.exit_s,
            found.deletion.shown_min
        ),
        (Some(300.0), 7.0, 0.2)
    );
    assert_eq!((found.reduction.merge_scans, found.reduction.hypotheses_max), (3, 12));
    let splitting = &found.splitting;
    assert_eq!((splitting.new_target_share, splitting.parents_motion), (None, None));
    assert_eq!(splitting.new_tracks_max, Limit::Computed);
    assert_eq!(splitting.tentative_tracks, Limit::Fixed(3));
    assert_eq!(splitting.company_min, Some(0.5));
    assert_eq!((found.capacity.tracks(), found.capacity.open_scans), (100, 4));
}

#[test]
fn mistakes_are_named_with_line_value_and_remedy() {
    for (text, line, expected) in [
        (
            "[gate]\nprobabilty = 0.9",
            2,
            "gate.probabilty: unknown key; there are: probability",
        ),
        ("\n[gate]\nprobability = 1.0", 3, "must lie between 0.5 and 0.999999"),
        (
            "[[sensor]]\nid = 1\n[[sensor]]\nid = 1",
            4,
            "the id of an earlier sensor",
        ),
        ("[[sensor]]\nid = 1\nsigmas = []", 3, "1 to 3, in their order"),
        ("[[sensor]]\nid = 1\nsigmas = [0.0]", 3, "0 is out of range"),
        ("[[sensor]]\nid = 1\nrange_rate_sigma_mps = 1", 3, "needs sigmas"),
        (
            "[[sensor]]\nid = 1\ndetection_probability = 1",
            3,
            "between 0.01 and 0.9999",
        ),
        (
            "[[sensor]]\nid = 1\nfield_of_view = { range_m = [9, 3] }",
            3,
            "the nearest and the farthest range",
        ),
        (
            "[splitting]\nnew_tracks_max = \"many\"",
            2,
            "there are: off, computed, a whole number",
        ),
        (
            "[splitting]\nparents_motion = -1",
            2,
            "-1 is out of range; it must lie between 1 and 256",
        ),
        (
            "[motion]\nprocess_noise_m2ps3 = [1.0]",
            2,
            "1 values; write 2, like [5.0, 1.0]",
        ),
        ("[motion.manoeuvres]\ndurations_s = [1.0, nan]", 2, "must lie between"),
        ("[reduction]\nhypotheses_max = 65", 2, "between 1 and 64"),
        ("[capacity]\ntracks = 0", 2, "between 1 and"),
        (
            "[fusion]\n",
            1,
            "fusion: unknown key; there are: platform, sensor, starts, gate",
        ),
    ] {
        let message = settings(text).unwrap_err();
        assert!(message.starts_with(&format!("track.toml:{line}: ")), "{message}");
        assert!(message.contains(expected) && message.lines().count() == 1, "{message}");
    }
}

//! Settings and inputs for tests.

use source_models::Sources;

use crate::settings::{Accuracy, AssociationSettings, Capacity, RuleName, Settings, SourceSettings};

/// Settings for `sources` like sources, in small tables.
pub(crate) fn test_settings(sources: usize) -> Settings {
    let source = |index: usize| SourceSettings {
        priority: index as u32,
        ..SourceSettings::of(&format!("source{index}"), 1.0, Accuracy::constant(10.0))
    };
    let mut settings = Settings {
        capacity: Capacity {
            system_tracks: Some(50),
            sensor_tracks: Some(200),
            stored_reports: 3,
            ..Capacity::default()
        },
        association: AssociationSettings {
            target_extent_m: 40.0,
            scan_wait: 0.0,
            ..AssociationSettings::default()
        },
        ..Settings::of((0..sources).map(source).collect())
    };
    settings.rule.name = RuleName(messages::FusionRule::BestSource);
    settings
}

/// Models of a source, where turns have a process noise of so much, m²/s³.
pub(crate) fn models(process_noise_m2ps3: f64) -> Sources {
    Sources::new(&Settings {
        process_noise_m2ps3,
        ..test_settings(1)
    })
}

//! Settings and inputs for tests.

use crate::filter::{Fit, Innovation};
use crate::settings::{
    Accuracy, AccuracyBase, AssociationSettings, BorderSettings, Capacity, ExistenceSettings, LifeSettings,
    RegistrationSettings, ReportLimits, RuleName, RuleSettings, Settings, SourceSettings,
};

/// Settings for `sources` like sources, in small tables.
pub(crate) fn test_settings(sources: usize) -> Settings {
    let source = |index: usize| SourceSettings {
        name: format!("source{index}"),
        sensor_uid: 0,
        period_ns: 1_000_000_000,
        learns_period: false,
        fresh_ns: 2_500_000_000,
        accuracy: Accuracy {
            base: AccuracyBase::Constant { sigma_m: 10.0 },
            per_speed_s: 0.0,
            conditions: Vec::new(),
        },
        adjustment: 1.0,
        priority: index as u32,
        shares: Vec::new(),
        is_centre: false,
        independent_of: Vec::new(),
        ceiling_m: f64::INFINITY,
        coverage: None,
        place_m: None,
        limits: ReportLimits::default(),
    };
    Settings {
        sources: (0..sources).map(source).collect(),
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
        life: LifeSettings::default(),
        existence: ExistenceSettings::default(),
        rule: RuleSettings {
            name: RuleName(messages::FusionRule::BestSource),
            ..RuleSettings::default()
        },
        registration: RegistrationSettings::default(),
        consistency: true,
        process_noise_m2ps3: 1.0,
        refresh_s: None,
        exchange: false,
        border: BorderSettings::default(),
        refresh_delay_s: settings::Seconds::default(),
    }
}

/// An innovation of 0, that fits so.
pub(crate) fn innovation(fit: Fit) -> Innovation {
    Innovation {
        residual_m: [0.0; 2],
        covariance_m2: [1.0, 0.0, 1.0],
        gain: 0.5,
        fit,
        straight_s: 0.0,
        begins_turn: false,
    }
}

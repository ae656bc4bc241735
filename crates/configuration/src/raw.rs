//! The tables of fusion as they are written.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::IntoDeserializer as _;
use settings::{Node, Place, Range, SettingsError, Value};

macro_rules! read_by_serde {
    ($($type:ty),*) => { $(
        impl Value for $type {
            fn read(&mut self, node: &Node<'_>, _: Range, at: &Place<'_>) -> Result<(), SettingsError> {
                *self = Self::deserialize(node.clone().into_deserializer())
                    .map_err(|error: toml::de::Error| at.error(error.message().replace('\n', " ")))?;
                Ok(())
            }

            fn check(&self, _: Range, _: &Place<'_>) -> Result<(), SettingsError> {
                Ok(())
            }

            fn kind(&self) -> String {
                "table".to_owned()
            }

            fn text(&self) -> String {
                String::new()
            }
        }
    )* };
}
read_by_serde!(RawFusion, RawAccuracy, RawCoverage);

impl Default for RawCoverage {
    fn default() -> Self {
        Self {
            range_m: None,
            sector_deg: None,
            polygon_m: Vec::new(),
            probability: nine_tenths(),
        }
    }
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawAccuracy {
    pub(crate) model: AccuracyModel,
    pub(crate) sigma_m: f64,
    pub(crate) range_sigma_m: f64,
    pub(crate) azimuth_sigma_deg: f64,
    pub(crate) initial_m: f64,
    pub(crate) memory: f64,
    pub(crate) per_speed_s: f64,
    pub(crate) adjustment: f64,
    pub(crate) conditions: BTreeMap<String, f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Default, Deserialize, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum AccuracyModel {
    #[default]
    Constant,
    Polar,
    Reported,
    Estimated,
}

impl Default for RawAccuracy {
    fn default() -> Self {
        Self {
            model: AccuracyModel::Constant,
            sigma_m: 20.0,
            range_sigma_m: 20.0,
            azimuth_sigma_deg: 0.1,
            initial_m: 20.0,
            memory: 200.0,
            per_speed_s: 0.0,
            adjustment: 1.0,
            conditions: BTreeMap::new(),
        }
    }
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawFusion {
    pub(crate) wait: String,
    pub(crate) hybrid_spin_us: f64,
    pub(crate) core: Option<usize>,
    pub(crate) realtime_priority: Option<i32>,
    pub(crate) lock_memory: bool,
    pub(crate) required: bool,
    pub(crate) rests: bool,
    pub(crate) deadline_us: f64,
    pub(crate) process_noise_m2ps3: f64,
    pub(crate) consistency: bool,
    pub(crate) refresh_s: Option<f64>,
    pub(crate) refresh_delay_s: f64,
    pub(crate) capacity: RawCapacity,
    pub(crate) association: RawAssociation,
    pub(crate) life: RawLife,
    pub(crate) registration: RawRegistration,
    pub(crate) rule: RawRule,
}

impl Default for RawFusion {
    fn default() -> Self {
        Self {
            wait: "event".to_owned(),
            hybrid_spin_us: 20.0,
            core: None,
            realtime_priority: None,
            lock_memory: false,
            required: false,
            rests: true,
            deadline_us: 1000.0,
            process_noise_m2ps3: 1.0,
            consistency: true,
            refresh_s: None,
            refresh_delay_s: 0.0,
            capacity: RawCapacity::default(),
            association: RawAssociation::default(),
            life: RawLife::default(),
            registration: RawRegistration::default(),
            rule: RawRule::default(),
        }
    }
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawCapacity {
    pub(crate) system_tracks: Option<usize>,
    pub(crate) sensor_tracks: Option<usize>,
    pub(crate) stored_reports: usize,
    pub(crate) queue: usize,
}

impl Default for RawCapacity {
    fn default() -> Self {
        Self {
            system_tracks: None,
            sensor_tracks: None,
            stored_reports: fusion::settings::Capacity::default().stored_reports,
            queue: 4096,
        }
    }
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawAssociation {
    pub(crate) use_identity: bool,
    pub(crate) join_probability: f64,
    pub(crate) keep_gate: f64,
    pub(crate) velocity_probability: f64,
    pub(crate) extent_sigma_m: f64,
    pub(crate) target_extent_m: f64,
    pub(crate) height_gate_m: f64,
    pub(crate) split_reports: u32,
    pub(crate) merge_reports: u32,
    pub(crate) cell_m: f64,
    pub(crate) error_correlation: f64,
    pub(crate) scan_wait: f64,
}

impl Default for RawAssociation {
    fn default() -> Self {
        let engine = fusion::settings::AssociationSettings::default();
        Self {
            use_identity: engine.use_identity,
            join_probability: 0.999,
            keep_gate: engine.keep_gate,
            velocity_probability: 0.999,
            extent_sigma_m: engine.extent_sigma_m,
            target_extent_m: engine.target_extent_m,
            height_gate_m: engine.height_gate_m,
            split_reports: engine.split_reports,
            merge_reports: engine.merge_reports,
            cell_m: engine.cell_m,
            error_correlation: engine.error_correlation,
            scan_wait: engine.scan_wait,
        }
    }
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawLife {
    pub(crate) confirm_reports: u32,
    pub(crate) terminate_s: Option<f64>,
    pub(crate) tentative_s: Option<f64>,
}

impl Default for RawLife {
    fn default() -> Self {
        Self {
            confirm_reports: fusion::settings::LifeSettings::default().confirm_reports,
            terminate_s: None,
            tentative_s: None,
        }
    }
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawRegistration {
    pub(crate) enabled: bool,
    pub(crate) reference_source: Option<String>,
    pub(crate) memory_s: f64,
}

impl Default for RawRegistration {
    fn default() -> Self {
        let engine = fusion::settings::RegistrationSettings::default();
        Self {
            enabled: engine.enabled,
            reference_source: None,
            memory_s: engine.memory_s,
        }
    }
}

/// Where a source sees; what is left out does not limit it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawCoverage {
    pub(crate) range_m: Option<f64>,
    /// First and last azimuth, clockwise from north.
    pub(crate) sector_deg: Option<[f64; 2]>,
    /// Corners, east and north in the system frame.
    #[serde(default)]
    pub(crate) polygon_m: Vec<[f64; 2]>,
    #[serde(default = "nine_tenths")]
    pub(crate) probability: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawRule {
    pub(crate) name: String,
    pub(crate) residual: RawResidual,
    pub(crate) recency: f64,
    pub(crate) reference_source: Option<String>,
    pub(crate) tie: RawTie,
    pub(crate) overdue_periods: f64,
    pub(crate) quality_scans: u32,
    pub(crate) hysteresis: f64,
    pub(crate) hold_refreshes: u32,
    pub(crate) intersection: RawIntersection,
    pub(crate) common_noise_m2ps3: Option<f64>,
    pub(crate) hand_over: RawHandOver,
    pub(crate) mosaic: RawMosaic,
}

impl Default for RawRule {
    fn default() -> Self {
        let engine = fusion::settings::RuleSettings::default();
        Self {
            name: engine.rule.word().to_owned(),
            residual: RawResidual::Position,
            recency: 1.0,
            reference_source: None,
            tie: RawTie::LastThenPriority,
            overdue_periods: engine.overdue_periods,
            quality_scans: engine.quality_scans,
            hysteresis: engine.hysteresis,
            hold_refreshes: engine.hold_refreshes,
            intersection: RawIntersection::Determinant,
            common_noise_m2ps3: engine.common_noise_m2ps3,
            hand_over: RawHandOver::default(),
            mosaic: RawMosaic::default(),
        }
    }
}

/// TI-13 … TI-16.
#[derive(Clone, Debug, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawHandOver {
    /// eta_0 at the first refresh and those that follow; empty: at once.
    pub(crate) ramp: Vec<f64>,
    pub(crate) by_traces: bool,
    pub(crate) drop_out: RawDropOut,
    #[serde(rename = "pair")]
    pub(crate) pairs: Vec<RawPair>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawPair {
    pub(crate) from: String,
    pub(crate) to: String,
    pub(crate) ramp: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawDropOut {
    #[default]
    Switch,
    Blend,
}

/// QF-9.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawMosaic {
    pub(crate) cell_m: f64,
    /// Sources where no cell says otherwise, the most wanted first; empty: by their priorities.
    pub(crate) default: Vec<String>,
    #[serde(rename = "cell")]
    pub(crate) cells: Vec<RawCell>,
}

impl Default for RawMosaic {
    fn default() -> Self {
        Self {
            cell_m: fusion::settings::MosaicSettings::default().cell_m,
            default: Vec::new(),
            cells: Vec::new(),
        }
    }
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawCell {
    /// Counted in cells from the system origin.
    pub(crate) east: i32,
    pub(crate) north: i32,
    pub(crate) sources: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawIntersection {
    Determinant,
    Trace,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawResidual {
    Position,
    Velocity,
    PerAxis,
    Innovation,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawTie {
    LastThenPriority,
    Priority,
}

fn nine_tenths() -> f64 {
    0.9
}

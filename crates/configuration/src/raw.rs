//! The configuration file as it is written: names, units and defaults of every key.
//!
//! Nothing here is checked beyond its type; `super` turns it into checked values. Unknown keys are refused, because a
//! misspelt key that is silently ignored is a setting that silently does not hold.

use std::collections::BTreeMap;

use reception::{CovarianceFrom, PoorQuality};
use serde::Deserialize;

use super::locating::RawLocating;
use super::tracker::RawSourceTracker;
use super::wide_area_sensor::RawWideAreaSensor;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawConfig {
    pub(crate) name: String,
    /// Number of the deployment among those that exchange tracks, 1 to 4294967295; 0: it exchanges none.
    #[serde(default)]
    pub(crate) origin: u32,
    pub(crate) frame: RawPlace,
    #[serde(default)]
    pub(crate) time: RawTime,
    #[serde(default, rename = "receiver")]
    pub(crate) receivers: Vec<RawReceiver>,
    #[serde(default, rename = "source")]
    pub(crate) sources: Vec<RawSource>,
    #[serde(default, rename = "wide_area_sensor")]
    pub(crate) wide_area_sensors: Vec<RawWideAreaSensor>,
    #[serde(default, rename = "gateway")]
    pub(crate) gateways: Vec<RawGateway>,
    pub(crate) scenario: Option<scenario::ScenarioSettings>,
    #[serde(default)]
    pub(crate) fusion: RawFusion,
    #[serde(default)]
    pub(crate) monitor: RawMonitor,
    #[serde(default)]
    pub(crate) recorder: RawRecorder,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawPlace {
    pub(crate) latitude_deg: f64,
    pub(crate) longitude_deg: f64,
    #[serde(default)]
    pub(crate) height_m: f64,
    #[serde(default)]
    pub(crate) north_offset_deg: f64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawTime {
    #[serde(default)]
    pub(crate) order: super::Order,
    pub(crate) date: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawSource {
    pub(crate) name: String,
    /// Identity of the sensor, the same in every deployment that hears it, 1 to 4294967295; left out: derived from the name.
    pub(crate) uid: Option<u32>,
    #[serde(default = "one")]
    pub(crate) period_s: f64,
    pub(crate) fresh_s: Option<f64>,
    #[serde(default)]
    pub(crate) priority: Option<u32>,
    pub(crate) ceiling_m: Option<f64>,
    pub(crate) technology: Option<RawTechnology>,
    /// For slant ranges of targets without height.
    #[serde(default = "five_kilometres")]
    pub(crate) assumed_height_m: f64,
    /// For pressure altitudes.
    #[serde(default = "standard_pressure")]
    pub(crate) qnh_hpa: f64,
    pub(crate) place: Option<RawPlace>,
    pub(crate) recorded: Option<RawRecorded>,
    pub(crate) live: Option<RawLive>,
    pub(crate) simulated: Option<scenario::SensorSettings>,
    pub(crate) simulated_direction_finder: Option<scenario::DirectionFinderSettings>,
    pub(crate) external: Option<RawExternal>,
    pub(crate) tracker: Option<RawSourceTracker>,
    pub(crate) locator: Option<RawLocating>,
    #[serde(default)]
    pub(crate) limits: RawLimits,
    #[serde(default)]
    pub(crate) covariance: RawCovariance,
    #[serde(default)]
    pub(crate) accuracy: RawAccuracy,
    pub(crate) coverage: Option<RawCoverage>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawReceiver {
    pub(crate) name: String,
    pub(crate) udp: Option<RawUdp>,
    pub(crate) sbs: Option<RawSbs>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawUdp {
    pub(crate) listen: String,
    pub(crate) interface: Option<String>,
    #[serde(default)]
    pub(crate) senders: Vec<String>,
    #[serde(default = "four_mebibytes")]
    pub(crate) buffer_bytes: usize,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawSbs {
    pub(crate) connect: String,
    #[serde(default)]
    pub(crate) ahead_of_utc_min: i32,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawGateway {
    pub(crate) name: String,
    pub(crate) send_to: String,
    pub(crate) interface: Option<String>,
    pub(crate) ttl: Option<u8>,
    /// Absent: the fused picture; otherwise the sensor tracks of this source.
    pub(crate) source: Option<String>,
    pub(crate) category: Option<u8>,
    pub(crate) edition: Option<String>,
    pub(crate) sac: u8,
    pub(crate) sic: u8,
    #[serde(default = "one")]
    pub(crate) refresh_s: f64,
    #[serde(default = "one")]
    pub(crate) status_s: f64,
    #[serde(default = "one_ethernet_frame")]
    pub(crate) block_bytes: usize,
    #[serde(default)]
    pub(crate) heights: RawHeights,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawHeights {
    #[default]
    Barometric,
    Geometric,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawTechnology {
    Primary,
    Secondary,
    ModeS,
    AdsB,
    Multilateration,
    Other,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawLive {
    pub(crate) receiver: String,
    #[serde(default)]
    pub(crate) editions: BTreeMap<String, String>,
    #[serde(default)]
    pub(crate) strict: bool,
    pub(crate) sac: Option<u8>,
    pub(crate) sic: Option<u8>,
    #[serde(default)]
    pub(crate) positions: reception::PositionForm,
}

/// Nothing has to be said of a process that publishes the source by itself.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawExternal {}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawRecorded {
    pub(crate) file: String,
    #[serde(default)]
    pub(crate) format: super::RecordedFormat,
    #[serde(default)]
    pub(crate) strict: bool,
    #[serde(default)]
    pub(crate) editions: BTreeMap<String, String>,
    pub(crate) sac: Option<u8>,
    pub(crate) sic: Option<u8>,
    #[serde(default)]
    pub(crate) positions: reception::PositionForm,
    #[serde(default = "half")]
    pub(crate) reorder_s: f64,
    #[serde(default)]
    pub(crate) truncated: super::Truncated,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawLimits {
    pub(crate) range_m: f64,
    pub(crate) height_min_m: f64,
    pub(crate) height_max_m: f64,
    pub(crate) speed_mps: f64,
    pub(crate) jump_m: f64,
    pub(crate) time_step_s: f64,
    pub(crate) tracks: usize,
}

impl Default for RawLimits {
    fn default() -> Self {
        Self {
            range_m: 400e3,
            height_min_m: -500.0,
            height_max_m: 25e3,
            speed_mps: 700.0,
            jump_m: 100.0,
            time_step_s: 60.0,
            tracks: 4096,
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawCovariance {
    pub(crate) from: CovarianceFrom,
    pub(crate) position_sigma_m: f64,
    pub(crate) velocity_sigma_mps: f64,
    pub(crate) height_sigma_m: f64,
    pub(crate) range_sigma_m: Option<f64>,
    pub(crate) azimuth_sigma_deg: Option<f64>,
    pub(crate) poor_quality: PoorQuality,
}

impl Default for RawCovariance {
    fn default() -> Self {
        Self {
            from: CovarianceFrom::Configuration,
            position_sigma_m: 20.0,
            velocity_sigma_mps: 3.0,
            height_sigma_m: 30.0,
            range_sigma_m: None,
            azimuth_sigma_deg: None,
            poor_quality: PoorQuality::Use,
        }
    }
}

#[derive(Debug, Deserialize)]
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

#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
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

#[derive(Debug, Deserialize)]
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

#[derive(Debug, Deserialize)]
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

#[derive(Debug, Deserialize)]
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

#[derive(Debug, Deserialize)]
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

#[derive(Debug, Deserialize)]
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
#[derive(Debug, Deserialize)]
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

#[derive(Debug, Deserialize)]
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
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawHandOver {
    /// eta_0 at the first refresh and those that follow; empty: at once.
    pub(crate) ramp: Vec<f64>,
    pub(crate) by_traces: bool,
    pub(crate) drop_out: RawDropOut,
    #[serde(rename = "pair")]
    pub(crate) pairs: Vec<RawPair>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawPair {
    pub(crate) from: String,
    pub(crate) to: String,
    pub(crate) ramp: Vec<f64>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawDropOut {
    #[default]
    Switch,
    Blend,
}

/// QF-9.
#[derive(Debug, Deserialize)]
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

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawCell {
    /// Counted in cells from the system origin.
    pub(crate) east: i32,
    pub(crate) north: i32,
    pub(crate) sources: Vec<String>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawIntersection {
    Determinant,
    Trace,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawResidual {
    Position,
    Velocity,
    PerAxis,
    Innovation,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawTie {
    LastThenPriority,
    Priority,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawMonitor {
    pub(crate) interval_s: f64,
    pub(crate) files: bool,
    /// Absent: what disturbs fusion least, see `check_monitor`.
    pub(crate) wait: Option<RawMonitorWait>,
    pub(crate) poll_ms: f64,
    pub(crate) deadline_us: RawDeadlines,
    /// Address and port; absent: no metrics.
    pub(crate) prometheus: Option<String>,
    pub(crate) prometheus_public: bool,
}

impl Default for RawMonitor {
    fn default() -> Self {
        Self {
            interval_s: 1.0,
            files: true,
            wait: None,
            poll_ms: 5.0,
            deadline_us: RawDeadlines::default(),
            prometheus: None,
            prometheus_public: false,
        }
    }
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawMonitorWait {
    Event,
    Poll,
}

/// Keys as in the monitor's report; absent: that of fusion for its own stage, none for the others.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawDeadlines {
    pub(crate) ingest_to_publish: Option<f64>,
    pub(crate) publish_to_taken: Option<f64>,
    pub(crate) taken_to_fused: Option<f64>,
    pub(crate) fused_to_received: Option<f64>,
    pub(crate) end_to_end: Option<f64>,
    pub(crate) age: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawRecorder {
    pub(crate) enabled: bool,
}

impl Default for RawRecorder {
    fn default() -> Self {
        Self { enabled: true }
    }
}

fn one() -> f64 {
    1.0
}

fn four_mebibytes() -> usize {
    4 << 20
}

/// What fits into one frame of Ethernet beside the headers of IPv4 and UDP.
fn one_ethernet_frame() -> usize {
    1472
}

fn nine_tenths() -> f64 {
    0.9
}

fn half() -> f64 {
    0.5
}

/// Between the low fliers without transponder and the high ones; see `reception`.
fn five_kilometres() -> f64 {
    5000.0
}

fn standard_pressure() -> f64 {
    reception::STANDARD_PRESSURE_HPA
}

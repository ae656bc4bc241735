//! The configuration of tracking: what is known of the sensors, and what may be chosen of the tracker.
//!
//! Offline it is a file of its own, and everything in it may be left out; live the same tables stand in
//! `[source.tracker]`, where the one sensor is the source:
//!
//! ```toml
//! [[sensor]]
//! id = 1                        # the sensor_id of the files
//! detection_probability = 0.9
//! clutter_density = 2e-8        # false detections per scan and m² (directions alone: per rad); else learned
//! sigmas = [50.0, 0.002]        # of detections that state none, in the order of their quantities
//! [motion]
//! process_noise_m2ps3 = [5.0, 1.0]
//! [confirmation]
//! detections_min = 3
//! [deletion]
//! silent_s = 30.0
//! ```
//!
//! Support by a wide-area sensor and the selection of detections are in [`super::wide_area`].

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use tracking::cutting::{Boundaries, CutterSettings, PERIOD_MIN_NS};
use tracking::settings as tracker;

use super::ConfigError;
use super::check::{Checked, nanoseconds, problem, within};
use super::locate::line_at;
use super::wide_area::{RawSelection, RawWideArea};

/// Probability of detection of sensors of which nobody says more.
const DETECTION_PROBABILITY: f64 = 0.9;
/// Room in tables, where nobody says more: what is usual, so many times the detections of the largest scan, and no more.
const TRACKS_PER_DETECTION: usize = 6;
const ROOM_MAX: usize = 1 << 20;
/// How long a scan waits for late detections, where nobody says more: periods.
const WAIT_PERIODS: f64 = 0.1;
/// Room for detections that wait for their scan to be complete: so many times that of a scan.
const WAITING_SCANS: usize = 2;

/// A configuration of `koseki track` as read; an empty one says nothing.
#[derive(Debug, Default)]
pub struct Tracking {
    path: PathBuf,
    text: String,
    raw: RawTracking,
}

/// What files of detections tell.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SeenDetections {
    /// Every `sensor_id`.
    pub sensor_ids: BTreeSet<u32>,
    /// Detections of the largest scan.
    pub scan_max: usize,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTracking {
    #[serde(default, rename = "sensor")]
    sensors: Vec<RawTrackedSensor>,
    #[serde(default)]
    gate: RawGate,
    #[serde(default)]
    motion: RawMotion,
    #[serde(default)]
    initiation: RawInitiation,
    #[serde(default)]
    confirmation: RawConfirmation,
    #[serde(default)]
    deletion: RawDeletion,
    #[serde(default)]
    reduction: RawReduction,
    #[serde(default)]
    splitting: RawSplitting,
    #[serde(default)]
    selection: RawSelection,
    #[serde(default)]
    wide_area: RawWideArea,
    #[serde(default)]
    capacity: RawTrackingCapacity,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTrackedSensor {
    id: u32,
    #[serde(default = "detection_probability")]
    detection_probability: f64,
    clutter_density: Option<f64>,
    sigmas: Option<Vec<f64>>,
    range_rate_sigma_mps: Option<f64>,
    resolution_m: Option<f64>,
    field_of_view: Option<RawFieldOfView>,
    priority: Option<u32>,
}

/// Where a sensor sees.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFieldOfView {
    range_m: [f64; 2],
    sector_deg: Option<[f64; 2]>,
    position_m: Option<[f64; 2]>,
}

fn detection_probability() -> f64 {
    DETECTION_PROBABILITY
}

/// HT-2.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawGate {
    probability: f64,
}

/// HT-13.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawMotion {
    process_noise_m2ps3: [f64; 2],
    manoeuvres: RawManoeuvres,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawManoeuvres {
    enabled: bool,
    process_noise_m2ps3: [f64; 2],
    durations_s: [f64; 2],
    turn: Option<RawTurn>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTurn {
    rate_sigma_radps: f64,
    rate_noise_rad2ps3: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawInitiation {
    new_target_share: f64,
    speed_sigma_mps: f64,
    slow_sigma_mps: RawAmount,
    climb_sigma_mps: f64,
    height_sigma_m: f64,
}

/// HT-10.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawConfirmation {
    reliability_min: f64,
    detections_min: u32,
    log_likelihood_ratio_min: Option<f64>,
}

/// HT-10.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawDeletion {
    missed_probability: f64,
    silent_s: f64,
    coherence_s: f64,
}

/// HT-9.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawReduction {
    merge_scans: usize,
    reliability_min: f64,
    hypotheses_max: usize,
}

/// SP-1 … SP-7.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawSplitting {
    start_in_confirmed_gates: bool,
    new_target_share: RawAmount,
    parents_motion: RawCount,
    new_tracks_max: RawLimit,
    tentative_tracks: RawLimit,
    company_min: RawAmount,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawTrackingCapacity {
    tracks: Option<usize>,
    detections: Option<usize>,
    open_scans: usize,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Off {
    Off,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum LimitWord {
    Off,
    Computed,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "write a number, or \"off\"")]
enum RawAmount {
    Value(f64),
    Off(Off),
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "write a whole number, or \"off\"")]
enum RawCount {
    Value(usize),
    Off(Off),
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "write a whole number, \"computed\" or \"off\"")]
enum RawLimit {
    Fixed(usize),
    Word(LimitWord),
}

impl RawAmount {
    fn of(value: Option<f64>) -> Self {
        value.map_or(Self::Off(Off::Off), Self::Value)
    }

    fn value(self) -> Option<f64> {
        match self {
            Self::Value(value) => Some(value),
            Self::Off(Off::Off) => None,
        }
    }
}

impl RawLimit {
    fn of(limit: tracker::Limit) -> Self {
        match limit {
            tracker::Limit::Off => Self::Word(LimitWord::Off),
            tracker::Limit::Computed => Self::Word(LimitWord::Computed),
            tracker::Limit::Fixed(number) => Self::Fixed(number),
        }
    }

    fn limit(self) -> tracker::Limit {
        match self {
            Self::Fixed(number) => tracker::Limit::Fixed(number),
            Self::Word(LimitWord::Off) => tracker::Limit::Off,
            Self::Word(LimitWord::Computed) => tracker::Limit::Computed,
        }
    }
}

impl Default for RawGate {
    fn default() -> Self {
        Self {
            probability: tracker::Settings::default().gate_probability,
        }
    }
}

impl Default for RawMotion {
    fn default() -> Self {
        Self {
            process_noise_m2ps3: tracker::Settings::default().motion.process_noise_m2ps3,
            manoeuvres: RawManoeuvres::default(),
        }
    }
}

impl Default for RawManoeuvres {
    fn default() -> Self {
        let usual = tracker::Settings::default().motion.manoeuvres;
        Self {
            enabled: usual.is_some(),
            process_noise_m2ps3: usual.map_or([100.0, 10.0], |usual| usual.process_noise_m2ps3),
            durations_s: usual.map_or([60.0, 10.0], |usual| usual.durations_s),
            turn: None,
        }
    }
}

impl Default for RawInitiation {
    fn default() -> Self {
        let usual = tracker::Settings::default();
        Self {
            new_target_share: usual.new_target_share,
            speed_sigma_mps: usual.first_guess.speed_sigma_mps,
            slow_sigma_mps: RawAmount::of(usual.first_guess.slow_sigma_mps),
            climb_sigma_mps: usual.first_guess.climb_sigma_mps,
            height_sigma_m: usual.first_guess.height_sigma_m,
        }
    }
}

impl Default for RawConfirmation {
    fn default() -> Self {
        let usual = tracker::Settings::default().confirmation;
        Self {
            reliability_min: usual.reliability_min,
            detections_min: usual.detections_min,
            log_likelihood_ratio_min: usual.log_likelihood_ratio_min,
        }
    }
}

impl Default for RawDeletion {
    fn default() -> Self {
        let usual = tracker::Settings::default();
        Self {
            missed_probability: usual.deletion.missed_probability,
            silent_s: frames::time::seconds(usual.deletion.silent_ns),
            coherence_s: usual.coherence_s,
        }
    }
}

impl Default for RawReduction {
    fn default() -> Self {
        let usual = tracker::Settings::default().reduction;
        Self {
            merge_scans: usual.merge_scans,
            reliability_min: usual.reliability_min,
            hypotheses_max: usual.hypotheses_max,
        }
    }
}

impl Default for RawSplitting {
    fn default() -> Self {
        let usual = tracker::Settings::default().splitting;
        Self {
            start_in_confirmed_gates: usual.start_in_confirmed_gates,
            new_target_share: RawAmount::of(usual.new_target_share),
            parents_motion: usual.parents_motion.map_or(RawCount::Off(Off::Off), RawCount::Value),
            new_tracks_max: RawLimit::of(usual.new_tracks_max),
            tentative_tracks: RawLimit::of(usual.tentative_tracks),
            company_min: RawAmount::of(usual.company_min),
        }
    }
}

/// `[source.tracker]`: tracks are made of the source's detections.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawSourceTracker {
    /// Names of the wide-area sensors that the tracker listens to.
    #[serde(default)]
    pub(crate) wide_area_sensors: Vec<String>,
    /// Names of the direction finders whose emissions it hears.
    #[serde(default)]
    pub(crate) emissions: Vec<String>,
    #[serde(default)]
    pub(crate) cues: bool,
    pub(crate) output_period_s: Option<f64>,
    #[serde(default)]
    scans: RawBoundaries,
    wait_s: Option<f64>,
    #[serde(default = "detection_probability")]
    detection_probability: f64,
    clutter_density: Option<f64>,
    resolution_m: Option<f64>,
    field_of_view: Option<RawFieldOfView>,
    #[serde(default)]
    gate: RawGate,
    #[serde(default)]
    motion: RawMotion,
    #[serde(default)]
    initiation: RawInitiation,
    #[serde(default)]
    confirmation: RawConfirmation,
    #[serde(default)]
    deletion: RawDeletion,
    #[serde(default)]
    reduction: RawReduction,
    #[serde(default)]
    splitting: RawSplitting,
    #[serde(default)]
    selection: RawSelection,
    #[serde(default)]
    wide_area: RawWideArea,
    #[serde(default)]
    capacity: RawTrackingCapacity,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RawBoundaries {
    #[default]
    Turn,
    Period,
}

/// How the tracks of a source are made of its detections.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceTracker {
    /// The tracker's settings; its only sensor is the source, under the number that its files have.
    pub settings: tracker::Settings,
    /// How detections are cut into scans; their numbers count from 1970 here.
    pub cutter: CutterSettings,
    /// Numbers of the wide-area sensors that the tracker listens to, in their order.
    pub wide_area_sensors: Vec<u16>,
    /// Numbers of the sources, direction finders, whose emissions it hears, in their order.
    pub emissions: Vec<u16>,
    /// Whether it says after each scan where the sensor should look next.
    pub cues: bool,
    /// Time between two outputs of its tracks, nanoseconds; `None`: they come after each scan.
    pub output_period_ns: Option<i64>,
}

impl RawSourceTracker {
    /// Of the source numbered `number`, which looks around once in `period_s`.
    pub(crate) fn checked(&self, number: u16, period_s: f64) -> Checked<SourceTracker> {
        let prefix = format!("source[{number}].tracker.");
        let key = |part: &str| format!("{prefix}{part}");
        let chosen = Chosen {
            gate: &self.gate,
            motion: &self.motion,
            initiation: &self.initiation,
            confirmation: &self.confirmation,
            deletion: &self.deletion,
            reduction: &self.reduction,
            splitting: &self.splitting,
            wide_area: &self.wide_area,
            capacity: &self.capacity,
        };
        let mut settings = chosen.settings(&prefix)?;
        settings.selection = self.selection.settings(&prefix, Vec::new())?;
        let sensor_id = observations::sensor_id(number);
        let (probability, density) = (self.detection_probability, self.clutter_density);
        settings.sensors.push(tracker::SensorSettings {
            field_of_view: field_of_view(&key("field_of_view"), self.field_of_view)?,
            resolution_m: resolution_m(&key("resolution_m"), self.resolution_m)?,
            ..sensor(key, sensor_id, probability, density, None)?
        });
        if let Some(fault) = settings.fault() {
            return Err(problem(prefix.trim_end_matches('.'), fault));
        }
        let period_ns = nanoseconds(period_s);
        if period_ns < PERIOD_MIN_NS {
            let what = format!("{period_s} is too short for a tracker, whose scans take 0.0625 s at least");
            return Err(problem(format!("source[{number}].period_s"), what));
        }
        let wait_s = self.wait_s.unwrap_or(WAIT_PERIODS * period_s);
        Ok(SourceTracker {
            cutter: CutterSettings {
                boundaries: match self.scans {
                    RawBoundaries::Turn => Boundaries::Turn,
                    RawBoundaries::Period => Boundaries::Period,
                },
                period_ns,
                wait_ns: nanoseconds(within(&key("wait_s"), wait_s, 0.0, period_s)?),
                waiting_max: WAITING_SCANS * settings.capacity.detections,
                epoch_ns: 0,
            },
            settings,
            // Its links are found when all sources and sensors are known.
            wide_area_sensors: Vec::new(),
            emissions: Vec::new(),
            cues: false,
            output_period_ns: None,
        })
    }
}

/// The tables that say how to track, wherever they stand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chosen<'a> {
    pub(crate) gate: &'a RawGate,
    pub(crate) motion: &'a RawMotion,
    pub(crate) initiation: &'a RawInitiation,
    pub(crate) confirmation: &'a RawConfirmation,
    pub(crate) deletion: &'a RawDeletion,
    pub(crate) reduction: &'a RawReduction,
    pub(crate) splitting: &'a RawSplitting,
    pub(crate) wide_area: &'a RawWideArea,
    pub(crate) capacity: &'a RawTrackingCapacity,
}

impl Chosen<'_> {
    /// Checks every value; keys begin with `prefix`. Without sensors.
    pub(crate) fn settings(&self, prefix: &str) -> Checked<tracker::Settings> {
        let key = |part: &str| format!("{prefix}{part}");
        let splitting = self.splitting;
        let share = |part: &str, value: f64| within(&key(part), value, 1e-6, 1e3);
        Ok(tracker::Settings {
            sensors: Vec::new(),
            gate_probability: within(&key("gate.probability"), self.gate.probability, 0.5, 0.999_999)?,
            coherence_s: within(&key("deletion.coherence_s"), self.deletion.coherence_s, 1e-3, 1e4)?,
            motion: self.motion(&key("motion"))?,
            new_target_share: share("initiation.new_target_share", self.initiation.new_target_share)?,
            first_guess: tracking::FirstGuess {
                speed_sigma_mps: within(
                    &key("initiation.speed_sigma_mps"),
                    self.initiation.speed_sigma_mps,
                    1e-3,
                    1e4,
                )?,
                slow_sigma_mps: match self.initiation.slow_sigma_mps.value() {
                    Some(value) => Some(within(&key("initiation.slow_sigma_mps"), value, 1e-3, 1e4)?),
                    None => None,
                },
                climb_sigma_mps: within(
                    &key("initiation.climb_sigma_mps"),
                    self.initiation.climb_sigma_mps,
                    1e-3,
                    1e4,
                )?,
                height_sigma_m: within(
                    &key("initiation.height_sigma_m"),
                    self.initiation.height_sigma_m,
                    1e-3,
                    1e5,
                )?,
            },
            reduction: self.reduction(&key("reduction"))?,
            confirmation: self.confirmation(&key("confirmation"))?,
            deletion: tracker::Deletion {
                missed_probability: within(
                    &key("deletion.missed_probability"),
                    self.deletion.missed_probability,
                    1e-300,
                    0.99,
                )?,
                silent_ns: nanoseconds(within(
                    &key("deletion.silent_s"),
                    self.deletion.silent_s,
                    1e-3,
                    86_400.0,
                )?),
            },
            splitting: tracker::Splitting {
                start_in_confirmed_gates: splitting.start_in_confirmed_gates,
                new_target_share: match splitting.new_target_share.value() {
                    Some(value) => Some(share("splitting.new_target_share", value)?),
                    None => None,
                },
                parents_motion: match splitting.parents_motion {
                    RawCount::Value(branches) => Some(count(
                        &key("splitting.parents_motion"),
                        branches,
                        1,
                        tracking::CLUSTER_TRACKS_MAX,
                    )?),
                    RawCount::Off(Off::Off) => None,
                },
                new_tracks_max: splitting.new_tracks_max.limit(),
                tentative_tracks: splitting.tentative_tracks.limit(),
                company_min: match splitting.company_min.value() {
                    Some(value) => Some(within(&key("splitting.company_min"), value, 0.0, 1.0)?),
                    None => None,
                },
            },
            wide_area: self.wide_area.settings(prefix)?,
            capacity: self.capacity(&key("capacity"))?,
            ..tracker::Settings::default()
        })
    }

    fn motion(&self, key: &str) -> Checked<tracker::MotionSettings> {
        let pair = |part: &str, values: [f64; 2], low: f64, high: f64| -> Checked<[f64; 2]> {
            let key = format!("{key}.{part}");
            Ok([within(&key, values[0], low, high)?, within(&key, values[1], low, high)?])
        };
        let (motion, manoeuvres) = (self.motion, &self.motion.manoeuvres);
        let turning = tracker::Manoeuvres {
            process_noise_m2ps3: pair(
                "manoeuvres.process_noise_m2ps3",
                manoeuvres.process_noise_m2ps3,
                1e-9,
                1e6,
            )?,
            durations_s: pair("manoeuvres.durations_s", manoeuvres.durations_s, 1e-3, 1e6)?,
            turn: match manoeuvres.turn {
                Some(turn) => Some(tracker::Turn {
                    rate_sigma_radps: within(
                        &format!("{key}.manoeuvres.turn.rate_sigma_radps"),
                        turn.rate_sigma_radps,
                        1e-6,
                        10.0,
                    )?,
                    rate_noise_rad2ps3: within(
                        &format!("{key}.manoeuvres.turn.rate_noise_rad2ps3"),
                        turn.rate_noise_rad2ps3,
                        1e-15,
                        10.0,
                    )?,
                }),
                None => None,
            },
        };
        Ok(tracker::MotionSettings {
            process_noise_m2ps3: pair("process_noise_m2ps3", motion.process_noise_m2ps3, 1e-9, 1e6)?,
            manoeuvres: manoeuvres.enabled.then_some(turning),
        })
    }

    fn reduction(&self, key: &str) -> Checked<tracker::Reduction> {
        let raw = self.reduction;
        Ok(tracker::Reduction {
            merge_scans: count(&format!("{key}.merge_scans"), raw.merge_scans, 0, tracking::HISTORY_MAX)?,
            reliability_min: within(&format!("{key}.reliability_min"), raw.reliability_min, 0.0, 0.49)?,
            hypotheses_max: count(
                &format!("{key}.hypotheses_max"),
                raw.hypotheses_max,
                1,
                tracking::HYPOTHESES_MAX,
            )?,
        })
    }

    fn confirmation(&self, key: &str) -> Checked<tracker::Confirmation> {
        let raw = self.confirmation;
        Ok(tracker::Confirmation {
            reliability_min: within(&format!("{key}.reliability_min"), raw.reliability_min, 0.501, 1.0)?,
            detections_min: count(&format!("{key}.detections_min"), raw.detections_min as usize, 1, 1000)? as u32,
            log_likelihood_ratio_min: match raw.log_likelihood_ratio_min {
                Some(value) => Some(within(&format!("{key}.log_likelihood_ratio_min"), value, -1e3, 1e3)?),
                None => None,
            },
        })
    }

    fn capacity(&self, key: &str) -> Checked<tracker::Capacity> {
        let usual = tracker::Settings::default().capacity;
        let (raw, room) = (self.capacity, |part: &str, value| {
            count(&format!("{key}.{part}"), value, 1, ROOM_MAX)
        });
        Ok(tracker::Capacity {
            tracks: room("tracks", raw.tracks.unwrap_or(usual.tracks))?,
            detections: room("detections", raw.detections.unwrap_or(usual.detections))?,
            open_scans: count(&format!("{key}.open_scans"), raw.open_scans, 0, 64)?,
        })
    }
}

pub(super) fn count(key: &str, value: usize, low: usize, high: usize) -> Checked<usize> {
    if (low..=high).contains(&value) {
        return Ok(value);
    }
    Err(problem(
        key,
        format!("{value} is out of range; it must lie between {low} and {high}"),
    ))
}

/// What an operator knows of a sensor; `None` of a clutter density means that it is learned.
pub(crate) fn sensor(
    key: impl Fn(&str) -> String,
    sensor_id: u32,
    detection_probability: f64,
    clutter_density: Option<f64>,
    sigmas: Option<[f64; 4]>,
) -> Checked<tracker::SensorSettings> {
    Ok(tracker::SensorSettings {
        sensor_id,
        detection_probability: within(&key("detection_probability"), detection_probability, 0.01, 0.9999)?,
        clutter: match clutter_density {
            Some(density) => tracker::Clutter::Density(within(&key("clutter_density"), density, 1e-30, 1e6)?),
            None => tracker::Clutter::Learned,
        },
        sigmas,
        ..tracker::SensorSettings::default()
    })
}

fn resolution_m(key: &str, metres: Option<f64>) -> Checked<Option<f64>> {
    metres.map(|metres| within(key, metres, 1e-3, 1e5)).transpose()
}

fn field_of_view(key: &str, raw: Option<RawFieldOfView>) -> Checked<Option<tracking::FieldOfView>> {
    let Some(raw) = raw else { return Ok(None) };
    let [near, far] = raw.range_m;
    if !(near >= 0.0 && far > near) {
        let what = format!("[{near}, {far}]: write the nearest and the farthest range, from 0 on");
        return Err(problem(format!("{key}.range_m"), what));
    }
    let pair = |part: &str, pair: [f64; 2], limit: f64| -> Checked<[f64; 2]> {
        let key = format!("{key}.{part}");
        Ok([
            within(&key, pair[0], -limit, limit)?,
            within(&key, pair[1], -limit, limit)?,
        ])
    };
    let sector = raw
        .sector_deg
        .map(|sector| pair("sector_deg", sector, 360.0))
        .transpose()?;
    Ok(Some(tracking::FieldOfView {
        range_m: raw.range_m,
        sector_rad: sector.map(|sector| sector.map(f64::to_radians)),
        position_m: raw
            .position_m
            .map(|position| pair("position_m", position, 1e7))
            .transpose()?,
    }))
}

impl Tracking {
    /// Reads the text of `path`.
    ///
    /// # Errors
    /// [`ConfigError`] with file, line, key, value and remedy.
    pub fn parse(path: &Path, text: &str) -> Result<Self, ConfigError> {
        let raw: RawTracking = toml::from_str(text).map_err(|error: toml::de::Error| ConfigError {
            file: path.to_owned(),
            line: error.span().map(|span| line_at(text, span.start)),
            what: error.message().replace('\n', " "),
        })?;
        let config = Self {
            path: path.to_owned(),
            text: text.to_owned(),
            raw,
        };
        // What is wrong is said before the detections are read.
        config.settings(&SeenDetections::default())?;
        Ok(config)
    }

    /// The tracker's settings for what the files hold; sensors that are not configured have a probability of detection of
    /// 0.9, and what else is not configured is learned or has its usual value.
    ///
    /// # Errors
    /// [`ConfigError`] with file, line, key, value and remedy.
    pub fn settings(&self, seen: &SeenDetections) -> Result<tracker::Settings, ConfigError> {
        self.build(seen)
            .map_err(|problem| problem.in_file(&self.path, &self.text))
    }

    fn build(&self, seen: &SeenDetections) -> Checked<tracker::Settings> {
        let raw = &self.raw;
        let chosen = Chosen {
            gate: &raw.gate,
            motion: &raw.motion,
            initiation: &raw.initiation,
            confirmation: &raw.confirmation,
            deletion: &raw.deletion,
            reduction: &raw.reduction,
            splitting: &raw.splitting,
            wide_area: &raw.wide_area,
            capacity: &raw.capacity,
        };
        let mut settings = chosen.settings("")?;
        let ranked = raw
            .sensors
            .iter()
            .filter_map(|sensor| Some((sensor.id, sensor.priority?)));
        settings.selection = raw.selection.settings("", ranked.collect())?;
        let room = &mut settings.capacity;
        let more = |given: Option<usize>, usual: usize, seen: usize| match given {
            Some(given) => given,
            None => usual.max(seen.min(ROOM_MAX)),
        };
        room.detections = more(raw.capacity.detections, room.detections, seen.scan_max);
        room.tracks = more(raw.capacity.tracks, room.tracks, TRACKS_PER_DETECTION * seen.scan_max);
        let mut known = BTreeSet::new();
        for (index, given) in raw.sensors.iter().enumerate() {
            let key = |part: &str| format!("sensor[{index}].{part}");
            if !known.insert(given.id) {
                let what = format!(
                    "{} is the id of an earlier sensor; say everything of it there",
                    given.id
                );
                return Err(problem(key("id"), what));
            }
            let (probability, density) = (given.detection_probability, given.clutter_density);
            settings.sensors.push(tracker::SensorSettings {
                field_of_view: field_of_view(&key("field_of_view"), given.field_of_view)?,
                resolution_m: resolution_m(&key("resolution_m"), given.resolution_m)?,
                ..sensor(key, given.id, probability, density, given.sigmas(&key)?)?
            });
        }
        for sensor_id in seen.sensor_ids.difference(&known) {
            settings.sensors.push(sensor(
                |part| part.to_owned(),
                *sensor_id,
                DETECTION_PROBABILITY,
                None,
                None,
            )?);
        }
        settings.sensors.sort_unstable_by_key(|sensor| sensor.sensor_id);
        match settings.fault() {
            Some(fault) => Err(problem("", fault)),
            None => Ok(settings),
        }
    }
}

impl RawTrackedSensor {
    /// In the tracker's order: up to three quantities, then the range rate; 1 where there is none to be measured.
    fn sigmas(&self, key: &impl Fn(&str) -> String) -> Checked<Option<[f64; 4]>> {
        let Some(given) = &self.sigmas else {
            return match self.range_rate_sigma_mps {
                None => Ok(None),
                Some(_) => Err(problem(key("range_rate_sigma_mps"), "needs sigmas beside it")),
            };
        };
        if !(1..=3).contains(&given.len()) {
            let what = format!(
                "{} values; give one for each quantity that the sensor measures, 1 to 3, in their order",
                given.len()
            );
            return Err(problem(key("sigmas"), what));
        }
        // A quantity without a standard deviation makes its detection unusable, as it should.
        let mut sigmas = [f64::NAN; 4];
        for (place, sigma) in given.iter().enumerate() {
            sigmas[place] = within(&key("sigmas"), *sigma, 1e-9, 1e6)?;
        }
        if let Some(sigma) = self.range_rate_sigma_mps {
            sigmas[3] = within(&key("range_rate_sigma_mps"), sigma, 1e-9, 1e6)?;
        }
        Ok(Some(sigmas))
    }
}

#[cfg(test)]
#[path = "tracker_tests.rs"]
mod tests;

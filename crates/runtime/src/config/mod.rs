//! One TOML file per deployment (PL-14): read, checked, and turned into the values the processes work with.
//!
//! Reading is strict. An unknown key, a value out of range, two sources of one name, a core the machine does not have:
//! each is refused with file, line, key, value and what would be right, before anything is started.

mod locate;
mod raw;

use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};

use bus::WaitMode;
use formats::asterix::{Category, Edition, registry};
use formats::reports::{CovarianceModel, Limits, SourceModel};
use frames::{Geodetic, PolarSigma, SensorFrame, SystemFrame};
use fusion::settings as engine;
use messages::NS_PER_S;
use serde::Deserialize;

use crate::cores::{self, Placement};
use raw::{AccuracyModel, RawAccuracy, RawConfig, RawPlace, RawRecorded, RawResidual, RawSource, RawTie};

/// Stands for the configuration of the demonstration, which is part of the executable.
pub const BUILT_IN_DEMO: &str = "built-in:demo";

/// The configuration of the demonstration, as text.
pub const DEMO: &str = include_str!("../../../../config/demo.toml");

/// A checked deployment.
#[derive(Clone, Debug)]
pub struct Config {
    /// Name of the deployment.
    pub name: String,
    /// File it was read from.
    pub path: PathBuf,
    /// The system frame.
    pub frame: SystemFrame,
    /// Order in which fusion works (PL-12).
    pub order: Order,
    /// Midnight of the recordings' first day, UTC, nanoseconds; `None` without recordings.
    pub first_day_ns: Option<i64>,
    /// The sources, in the order of their numbers.
    pub sources: Vec<Source>,
    /// The simulated world, if there are simulated sources.
    pub scenario: Option<scenario::ScenarioSettings>,
    /// The fusion process.
    pub fusion: Fusion,
    /// The monitor process.
    pub monitor: Monitor,
    /// Whether a recorder runs.
    pub recorder: bool,
}

/// Order in which fusion takes reports.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// As they arrive: lowest latency.
    #[default]
    Arrival,
    /// By time of measurement, merged with each source's progress: the result does not depend on scheduling.
    Time,
}

/// One source.
#[derive(Clone, Debug)]
pub struct Source {
    /// Its number: its place in the file, from 0.
    pub number: u16,
    /// Its name, which is also part of its topic's name.
    pub name: String,
    /// Where its data come from.
    pub input: Input,
    /// Where it stands, what its reports may contain, and how accurate they are.
    pub model: SourceModel,
}

/// Where a source's data come from.
#[derive(Clone, Debug)]
pub enum Input {
    /// A recording.
    Recorded(Recorded),
    /// A simulated sensor.
    Simulated(Box<scenario::SensorSettings>),
}

/// A recorded input.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// File, relative to the data folder unless absolute.
    pub file: PathBuf,
    /// Tables of the ASTERIX categories whose edition the file states.
    pub tables: Vec<&'static Category>,
    /// How far reports may come out of order, nanoseconds.
    pub reorder_ns: i64,
    /// Whether the file may end in the middle of a data block.
    pub truncated: Truncated,
}

/// What to do with a recording that ends in the middle of a data block: its recorder was killed, or its copy cut short.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Truncated {
    /// Refuse it before anything starts: more than one block may be missing.
    #[default]
    Refuse,
    /// Use it without its last block.
    Accept,
}

/// The fusion process.
#[derive(Clone, Debug)]
pub struct Fusion {
    /// The engine's settings.
    pub settings: engine::Settings,
    /// How it waits for work.
    pub wait: WaitMode,
    /// What it asks of the machine.
    pub placement: Placement,
    /// Whether a refusal of that is an error.
    pub required: bool,
    /// Reports that wait per source in order `time`.
    pub queue: usize,
    /// A report that takes longer through fusion has missed its deadline, nanoseconds.
    pub deadline_ns: i64,
}

/// The monitor process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monitor {
    /// Time between two tables, nanoseconds.
    pub interval_ns: i64,
    /// Whether it writes its files (histogram log, percentiles, JSON).
    pub files: bool,
}

/// A configuration that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfigError {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1, where it is known.
    pub line: Option<usize>,
    /// What is wrong, with key and value, and what would be right.
    pub what: String,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(f, ": {}", self.what)
    }
}

impl std::error::Error for ConfigError {}

/// What is wrong with the value at a key.
struct Problem {
    key: String,
    what: String,
}

type Checked<T> = Result<T, Problem>;

impl Config {
    /// Reads and checks `path`; each of `overrides` (`key.path=value`, the value in TOML) replaces a value of the file.
    ///
    /// # Errors
    /// [`ConfigError`] with file, line, key, value and remedy.
    pub fn read(path: &Path, overrides: &[String]) -> Result<Self, ConfigError> {
        let failed = |line, what: String| ConfigError {
            file: path.to_owned(),
            line,
            what,
        };
        if path == Path::new(BUILT_IN_DEMO) {
            return Self::parse(path, DEMO, overrides);
        }
        let text = std::fs::read_to_string(path).map_err(|error| failed(None, format!("cannot be read: {error}")))?;
        Self::parse(path, &text, overrides)
    }

    /// As [`Config::read`], from the file's text.
    ///
    /// # Errors
    /// As [`Config::read`].
    pub fn parse(path: &Path, text: &str, overrides: &[String]) -> Result<Self, ConfigError> {
        let failed = |line, what: String| ConfigError {
            file: path.to_owned(),
            line,
            what,
        };
        let from_toml = |error: toml::de::Error| {
            let line = error.span().map(|span| locate::line_at(text, span.start));
            failed(line, error.message().replace('\n', " "))
        };
        let raw: RawConfig = if overrides.is_empty() {
            toml::from_str(text).map_err(from_toml)?
        } else {
            // The file alone must be sound first: then its errors still have their lines.
            toml::from_str::<RawConfig>(text).map_err(from_toml)?;
            let mut table: toml::Table = toml::from_str(text).map_err(from_toml)?;
            for each in overrides {
                set(&mut table, each).map_err(|what| failed(None, format!("--set {each}: {what}")))?;
            }
            table
                .try_into()
                .map_err(|error: toml::de::Error| failed(None, format!("--set: {}", error.message())))?
        };
        check(path, raw).map_err(|problem| {
            let line = locate::line_of(text, &problem.key);
            failed(
                line,
                if problem.key.is_empty() {
                    problem.what
                } else {
                    format!("{}: {}", problem.key, problem.what)
                },
            )
        })
    }

    /// The source called `name`.
    pub fn source(&self, name: &str) -> Option<&Source> {
        self.sources.iter().find(|source| source.name == name)
    }

    /// Whether all sources are recordings: then producers wait for consumers, so that nothing is lost.
    pub fn is_recorded(&self) -> bool {
        self.sources
            .iter()
            .all(|source| matches!(source.input, Input::Recorded(_)))
    }
}

/// Applies `key.path=value` or `source[0].key=value` to a table.
fn set(table: &mut toml::Table, assignment: &str) -> Result<(), String> {
    let (path, value) = assignment.split_once('=').ok_or("write it as key.path=value")?;
    let value: toml::Value = format!("value = {}", value.trim())
        .parse::<toml::Table>()
        .ok()
        .and_then(|mut parsed| parsed.remove("value"))
        .unwrap_or_else(|| toml::Value::String(value.trim().to_owned()));
    let mut parts: Vec<&str> = path.trim().split('.').collect();
    let last = parts.pop().filter(|last| !last.is_empty()).ok_or("the key is empty")?;
    let mut at = table;
    for part in parts {
        let (key, index) = match part.split_once('[') {
            Some((key, rest)) => (
                key,
                Some(rest.trim_end_matches(']').parse::<usize>().map_err(|_| "bad index")?),
            ),
            None => (part, None),
        };
        let entry = at.entry(key).or_insert_with(|| toml::Value::Table(toml::Table::new()));
        let entry = match index {
            Some(index) => entry.get_mut(index).ok_or_else(|| format!("there is no {part}"))?,
            None => entry,
        };
        at = entry.as_table_mut().ok_or_else(|| format!("{part} is not a table"))?;
    }
    at.insert(last.to_owned(), value);
    Ok(())
}

fn problem(key: impl Into<String>, what: impl Into<String>) -> Problem {
    Problem {
        key: key.into(),
        what: what.into(),
    }
}

fn simulated_problem(key: &str, error: &scenario::SettingsError) -> Problem {
    problem(
        format!("{key}.{}", error.key),
        format!("{}: must be {}", error.value, error.limit),
    )
}

fn within(key: &str, value: f64, low: f64, high: f64) -> Checked<f64> {
    // Written so that NaN is refused.
    if (low..=high).contains(&value) {
        return Ok(value);
    }
    Err(problem(
        key,
        format!("{value} is out of range; it must lie between {low} and {high}"),
    ))
}

fn nanoseconds(seconds: f64) -> i64 {
    (seconds * NS_PER_S).round() as i64
}

fn check_name(key: &str, name: &str) -> Checked<()> {
    let fits = (1..=31).contains(&name.len())
        && name
            .bytes()
            .all(|byte| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_');
    if fits {
        return Ok(());
    }
    Err(problem(
        key,
        format!("\"{name}\" cannot be a name: use 1 to 31 letters, digits, - and _"),
    ))
}

fn check(path: &Path, raw: RawConfig) -> Checked<Config> {
    check_name("name", &raw.name)?;
    let frame = SystemFrame::at(place("frame", &raw.frame)?);
    if raw.sources.is_empty() {
        return Err(problem("", "there is no [[source]]: a deployment needs at least one"));
    }
    let mut names = BTreeSet::new();
    for (index, source) in raw.sources.iter().enumerate() {
        let key = format!("source[{index}].name");
        check_name(&key, &source.name)?;
        if !names.insert(source.name.clone()) {
            return Err(problem(
                key,
                format!(
                    "\"{}\" is the name of an earlier source; give each its own",
                    source.name
                ),
            ));
        }
    }
    let mut sources = Vec::new();
    let mut weighing = Vec::new();
    for (index, source) in raw.sources.iter().enumerate() {
        let (source, weighed) = check_source(index, source, &frame, &raw.frame)?;
        sources.push(source);
        weighing.push(weighed);
    }
    let first_day_ns = first_day(&raw, &sources)?;
    let scenario = check_scenario(&raw, &sources)?;
    if sources.iter().any(|source| matches!(source.input, Input::Simulated(_))) && raw.time.order == Order::Time {
        return Err(problem(
            "time.order",
            "\"time\" is for recorded inputs; simulated sensors are live: use \"arrival\"",
        ));
    }
    Ok(Config {
        fusion: check_fusion(&raw, weighing)?,
        monitor: Monitor {
            interval_ns: nanoseconds(within("monitor.interval_s", raw.monitor.interval_s, 0.1, 3600.0)?),
            files: raw.monitor.files,
        },
        name: raw.name,
        path: path.to_owned(),
        frame,
        order: raw.time.order,
        first_day_ns,
        sources,
        scenario,
        recorder: raw.recorder.enabled,
    })
}

fn place(key: &str, raw: &RawPlace) -> Checked<Geodetic> {
    Geodetic::from_degrees(raw.latitude_deg, raw.longitude_deg, raw.height_m).map_err(|error| {
        let part = match error {
            frames::GeodeticError::Latitude(_) => "latitude_deg",
            frames::GeodeticError::Longitude(_) => "longitude_deg",
            frames::GeodeticError::Height(_) => "height_m",
        };
        problem(format!("{key}.{part}"), error.to_string())
    })
}

fn check_source(
    index: usize,
    raw: &RawSource,
    system: &SystemFrame,
    origin: &RawPlace,
) -> Checked<(Source, engine::SourceSettings)> {
    let key = |part: &str| format!("source[{index}].{part}");
    let sensor_place = raw.place.as_ref().unwrap_or(origin);
    let turned = within(
        &key("place.north_offset_deg"),
        sensor_place.north_offset_deg,
        -360.0,
        360.0,
    )?;
    let origin = place(&key("place"), sensor_place)?;
    let input = match (&raw.recorded, &raw.simulated) {
        (Some(recorded), None) => Input::Recorded(check_recorded(index, recorded)?),
        (None, Some(simulated)) => {
            simulated
                .validate()
                .map_err(|error| simulated_problem(&key("simulated"), &error))?;
            Input::Simulated(Box::new(simulated.clone()))
        }
        _ => {
            let what = format!(
                "\"{}\" needs exactly one of [source.recorded] and [source.simulated]",
                raw.name
            );
            return Err(problem(key("name"), what));
        }
    };
    let limits = &raw.limits;
    let limits = Limits {
        range_m: within(&key("limits.range_m"), limits.range_m, 1.0, 2e6)?,
        height_min_m: within(&key("limits.height_min_m"), limits.height_min_m, -1e4, 1e5)?,
        height_max_m: within(
            &key("limits.height_max_m"),
            limits.height_max_m,
            limits.height_min_m,
            1e5,
        )?,
        speed_mps: within(&key("limits.speed_mps"), limits.speed_mps, 0.1, 2e4)?,
        jump_m: within(&key("limits.jump_m"), limits.jump_m, 0.0, 1e6)?,
        time_step_ns: nanoseconds(within(&key("limits.time_step_s"), limits.time_step_s, 0.01, 40e3)?),
        tracks: within(&key("limits.tracks"), limits.tracks as f64, 1.0, 1e6)? as usize,
    };
    let period_s = within(&key("period_s"), raw.period_s, 1e-3, 3600.0)?;
    let source = Source {
        number: index as u16,
        name: raw.name.clone(),
        input,
        model: SourceModel {
            number: index as u16,
            sac_sic: check_sac_sic(index, raw)?,
            positions: raw
                .recorded
                .as_ref()
                .map(|recorded| recorded.positions)
                .unwrap_or_default(),
            frame: SensorFrame::new(system, origin, turned.to_radians()),
            system: *system,
            height_m: sensor_place.height_m,
            limits,
            covariance: check_covariance(index, raw)?,
        },
    };
    let weighed = engine::SourceSettings {
        name: raw.name.clone(),
        period_ns: nanoseconds(period_s),
        fresh_ns: nanoseconds(within(
            &key("fresh_s"),
            raw.fresh_s.unwrap_or(2.5 * period_s),
            period_s,
            1e5,
        )?),
        accuracy: accuracy(&raw.accuracy, &source.model.frame),
        adjustment: raw.accuracy.adjustment,
        priority: raw.priority.unwrap_or(index as u32),
        ceiling_m: raw.ceiling_m.unwrap_or(f64::INFINITY),
    };
    Ok((source, weighed))
}

fn check_covariance(index: usize, raw: &RawSource) -> Checked<CovarianceModel> {
    let key = |part: &str| format!("source[{index}].covariance.{part}");
    let raw = &raw.covariance;
    let polar = match (raw.range_sigma_m, raw.azimuth_sigma_deg) {
        (None, None) => None,
        (Some(range_m), Some(azimuth_deg)) => Some(PolarSigma {
            range_m: within(&key("range_sigma_m"), range_m, 1e-3, 1e5)?,
            azimuth_rad: within(&key("azimuth_sigma_deg"), azimuth_deg, 1e-6, 45.0)?.to_radians(),
        }),
        (None, Some(_)) => return Err(problem(key("azimuth_sigma_deg"), "needs range_sigma_m beside it")),
        (Some(_), None) => return Err(problem(key("range_sigma_m"), "needs azimuth_sigma_deg beside it")),
    };
    Ok(CovarianceModel {
        from: raw.from,
        position_sigma_m: within(&key("position_sigma_m"), raw.position_sigma_m, 1e-3, 1e5)?,
        velocity_sigma_mps: within(&key("velocity_sigma_mps"), raw.velocity_sigma_mps, 1e-3, 1e4)?,
        height_sigma_m: within(&key("height_sigma_m"), raw.height_sigma_m, 1e-3, 1e5)?,
        polar,
        poor_quality: raw.poor_quality,
    })
}

fn check_recorded(index: usize, raw: &RawRecorded) -> Checked<Recorded> {
    let key = |part: &str| format!("source[{index}].recorded.{part}");
    let mut tables = Vec::new();
    for (category, edition) in &raw.editions {
        let number: u8 = category.parse().map_err(|_| {
            problem(
                key("editions"),
                format!("\"{category}\" is not an ASTERIX category: write \"21\" = \"0.23\""),
            )
        })?;
        let table = edition
            .parse::<Edition>()
            .ok()
            .and_then(|edition| registry::find(number, edition));
        tables.push(table.ok_or_else(|| {
            let known: Vec<String> = registry::REGISTRY.iter().map(|table| table.to_string()).collect();
            problem(
                key("editions"),
                format!(
                    "category {number} edition \"{edition}\" is not known; there are: {}",
                    known.join(", ")
                ),
            )
        })?);
    }
    Ok(Recorded {
        file: PathBuf::from(&raw.file),
        tables,
        reorder_ns: nanoseconds(within(&key("reorder_s"), raw.reorder_s, 0.0, 60.0)?),
        truncated: raw.truncated,
    })
}

fn check_sac_sic(index: usize, raw: &RawSource) -> Checked<Option<(u8, u8)>> {
    match raw.recorded.as_ref().map(|recorded| (recorded.sac, recorded.sic)) {
        None | Some((None, None)) => Ok(None),
        Some((Some(sac), Some(sic))) => Ok(Some((sac, sic))),
        Some(_) => Err(problem(
            format!("source[{index}].recorded"),
            "sac and sic go together: give both or neither",
        )),
    }
}

fn accuracy(raw: &RawAccuracy, frame: &SensorFrame) -> engine::Accuracy {
    engine::Accuracy {
        base: match raw.model {
            AccuracyModel::Constant => engine::AccuracyBase::Constant { sigma_m: raw.sigma_m },
            AccuracyModel::Polar => engine::AccuracyBase::Polar {
                place_m: frame.place(),
                range_sigma_m: raw.range_sigma_m,
                azimuth_sigma_rad: raw.azimuth_sigma_deg.to_radians(),
            },
            AccuracyModel::Estimated => engine::AccuracyBase::Estimated {
                initial_m: raw.initial_m,
                memory: raw.memory,
            },
        },
        per_speed_s: raw.per_speed_s,
        conditions: raw
            .conditions
            .iter()
            .map(|(name, factor)| (name.clone(), *factor))
            .collect(),
    }
}

fn first_day(raw: &RawConfig, sources: &[Source]) -> Checked<Option<i64>> {
    let recorded = sources.iter().any(|source| matches!(source.input, Input::Recorded(_)));
    match &raw.time.date {
        Some(date) => {
            let day: jiff::civil::Date = date.parse().map_err(|_| {
                problem(
                    "time.date",
                    format!("\"{date}\" is not a date: write year-month-day, as in \"2016-05-10\""),
                )
            })?;
            let midnight = day
                .to_zoned(jiff::tz::TimeZone::UTC)
                .map_err(|error| problem("time.date", error.to_string()))?;
            Ok(Some(midnight.timestamp().as_nanosecond() as i64))
        }
        None if recorded => Err(problem(
            "time.date",
            "missing: recordings carry the time of day only, so give their first day (UTC)",
        )),
        None => Ok(None),
    }
}

fn check_scenario(raw: &RawConfig, sources: &[Source]) -> Checked<Option<scenario::ScenarioSettings>> {
    let simulated = sources
        .iter()
        .find(|source| matches!(source.input, Input::Simulated(_)));
    match (&raw.scenario, simulated) {
        (Some(settings), _) => {
            settings
                .validate()
                .map_err(|error| simulated_problem("scenario", &error))?;
            Ok(Some(settings.clone()))
        }
        (None, Some(source)) => {
            let what = "is simulated, but there is no [scenario] to observe";
            Err(problem(format!("source[{}].name", source.number), what))
        }
        (None, None) => Ok(None),
    }
}

fn check_fusion(raw: &RawConfig, sources: Vec<engine::SourceSettings>) -> Checked<Fusion> {
    let fusion = &raw.fusion;
    let wait = match fusion.wait.as_str() {
        "spin" => WaitMode::Spin,
        "event" => WaitMode::Event,
        "hybrid" => {
            let spin_us = within("fusion.hybrid_spin_us", fusion.hybrid_spin_us, 0.1, 1e6)?;
            WaitMode::Hybrid {
                spin_ns: (spin_us * 1e3) as u64,
            }
        }
        other => {
            let what = format!("\"{other}\" is no wait mode; there are \"spin\", \"event\" and \"hybrid\"");
            return Err(problem("fusion.wait", what));
        }
    };
    if let Some(core) = fusion.core
        && !cores::available().contains(&core)
    {
        let what = format!(
            "{core} does not exist or may not be used; this machine offers cores {:?}",
            cores::available()
        );
        return Err(problem("fusion.core", what));
    }
    if let Some(priority) = fusion.realtime_priority {
        within("fusion.realtime_priority", f64::from(priority), 1.0, 99.0)?;
    }
    let settings = engine::Settings {
        rule: check_rule(raw, &sources)?,
        sources,
        capacity: engine::Capacity {
            system_tracks: fusion.capacity.system_tracks,
            sensor_tracks: fusion.capacity.sensor_tracks,
            stored_reports: fusion.capacity.stored_reports,
        },
        association: check_association(raw)?,
        life: engine::LifeSettings {
            confirm_reports: fusion.life.confirm_reports,
            terminate_ns: nanoseconds(fusion.life.terminate_s),
            tentative_ns: nanoseconds(fusion.life.tentative_s),
        },
        process_noise_m2ps3: fusion.process_noise_m2ps3,
    };
    settings
        .check()
        .map_err(|error| problem(&error.key, format!("{}: {}", error.value, error.reason)))?;
    // A source must be able to hand over a whole slice at any time.
    let queue = within("fusion.capacity.queue", fusion.capacity.queue as f64, 128.0, 1e7)? as usize;
    Ok(Fusion {
        settings,
        wait,
        placement: Placement {
            core: fusion.core,
            realtime_priority: fusion.realtime_priority,
            lock_memory: fusion.lock_memory,
        },
        required: fusion.required,
        queue,
        deadline_ns: (within("fusion.deadline_us", fusion.deadline_us, 0.1, 1e9)? * 1e3) as i64,
    })
}

fn check_association(raw: &RawConfig) -> Checked<engine::AssociationSettings> {
    let raw = &raw.fusion.association;
    let gate = |key: &str, probability: f64| -> Checked<f64> {
        let probability = within(&format!("fusion.association.{key}"), probability, 0.5, 1.0 - 1e-12)?;
        Ok(-2.0 * (1.0 - probability).ln())
    };
    Ok(engine::AssociationSettings {
        use_identity: raw.use_identity,
        join_gate: gate("join_probability", raw.join_probability)?,
        keep_gate: raw.keep_gate,
        velocity_gate: gate("velocity_probability", raw.velocity_probability)?,
        extent_sigma_m: raw.extent_sigma_m,
        target_extent_m: raw.target_extent_m,
        height_gate_m: raw.height_gate_m,
        split_reports: raw.split_reports,
        merge_reports: raw.merge_reports,
        cell_m: raw.cell_m,
    })
}

fn check_rule(raw: &RawConfig, sources: &[engine::SourceSettings]) -> Checked<engine::RuleSettings> {
    let raw = &raw.fusion.rule;
    let rule = fusion::rules::find(&raw.name).ok_or_else(|| {
        let known: Vec<&str> = fusion::rules::REGISTRY.iter().map(|entry| entry.name).collect();
        problem(
            "fusion.rule.name",
            format!("\"{}\" is no fusion rule; there are: {}", raw.name, known.join(", ")),
        )
    })?;
    let reference_source = match &raw.reference_source {
        None => None,
        Some(name) => {
            let number = sources.iter().position(|source| source.name == *name);
            let number = number.ok_or_else(|| {
                problem(
                    "fusion.rule.reference_source",
                    format!("there is no source named \"{name}\""),
                )
            })?;
            Some(number as u16)
        }
    };
    Ok(engine::RuleSettings {
        rule,
        residual: match raw.residual {
            RawResidual::Position => engine::Residual::Position,
            RawResidual::Velocity => engine::Residual::Velocity,
            RawResidual::PerAxis => engine::Residual::PerAxis,
            RawResidual::Innovation => engine::Residual::Innovation,
        },
        recency: raw.recency,
        reference_source,
        tie: match raw.tie {
            RawTie::LastThenPriority => engine::Tie::LastThenPriority,
            RawTie::Priority => engine::Tie::Priority,
        },
    })
}

#[cfg(test)]
mod tests;

//! Checking what the file says, and turning it into what the processes work with.
//!
//! Each check names its key as the file spells it, so that the error can name the line.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use bus::WaitMode;
use frames::{Geodetic, PolarSigma, SensorFrame, SystemFrame};
use fusion::settings as engine;
use messages::NS_PER_S;
use reception::{CovarianceModel, Limits, SourceModel};

use super::check_monitor::check_monitor;
use super::check_network::{Network, asterix, check_gateways, simulated_sac_sic, technology};
use super::check_rule::check_rule;
use super::locate::line_of;
use super::locating::{RawLocating, check_locating};
use super::raw::{
    AccuracyModel, RawAccuracy, RawAssociation, RawConfig, RawCoverage, RawFusion, RawLimits, RawPlace, RawRecorded,
    RawSource,
};
use super::tracker_links::check_links;
use super::wide_area_sensor::{WideAreaSensor, check_company, check_wide_area_sensors};
use super::{Config, ConfigError, Fusion, Input, Instrument, Order, Recorded, RecordedFormat, Source, SourceTracker};
use runtime::cores::{self, Placement};

/// What is wrong with the value at a key.
pub(super) struct Problem {
    pub(super) key: String,
    pub(super) what: String,
}

impl Problem {
    /// As an error that names the line of `text`, read from `path`.
    pub(super) fn in_file(self, path: &Path, text: &str) -> ConfigError {
        ConfigError {
            file: path.to_owned(),
            line: line_of(text, &self.key),
            what: match self.key.as_str() {
                "" => self.what,
                key => format!("{key}: {}", self.what),
            },
        }
    }
}

pub(super) type Checked<T> = Result<T, Problem>;

pub(super) fn problem(key: impl Into<String>, what: impl Into<String>) -> Problem {
    Problem {
        key: key.into(),
        what: what.into(),
    }
}

pub(super) fn simulated_problem(key: &str, error: &scenario::SettingsError) -> Problem {
    problem(
        format!("{key}.{}", error.key),
        format!("{}: must be {}", error.value, error.limit),
    )
}

pub(super) fn within(key: &str, value: f64, low: f64, high: f64) -> Checked<f64> {
    // Written so that NaN is refused.
    if (low..=high).contains(&value) {
        return Ok(value);
    }
    Err(problem(
        key,
        format!("{value} is out of range; it must lie between {low} and {high}"),
    ))
}

pub(super) fn nanoseconds(seconds: f64) -> i64 {
    (seconds * NS_PER_S).round() as i64
}

pub(super) fn check_name(key: &str, name: &str) -> Checked<()> {
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

/// The checked deployment that `raw`, read from `path`, describes.
pub(super) fn check(path: &Path, raw: RawConfig) -> Checked<Config> {
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
    let mut network = Network::new(&raw.receivers)?;
    let mut sources = Vec::new();
    let mut weighing = Vec::new();
    for (index, source) in raw.sources.iter().enumerate() {
        let (source, weighed) = check_source(index, source, &frame, &raw.frame, &mut network)?;
        sources.push(source);
        weighing.push(weighed);
    }
    let wide_area_sensors = check_wide_area_sensors(&raw, &frame, &mut network)?;
    check_links(&mut sources, &raw.sources, &raw.wide_area_sensors)?;
    check_company(&sources, &wide_area_sensors)?;
    let receivers = network.receivers(&sources, &wide_area_sensors)?;
    let gateways = check_gateways(&raw.gateways, &sources, &wide_area_sensors)?;
    let first_day_ns = first_day(&raw, &sources)?;
    let scenario = check_scenario(&raw, &sources, &wide_area_sensors)?;
    let external = sources.iter().any(|source| matches!(source.input, Input::External));
    if (external || !receivers.is_empty()) && raw.time.order == Order::Time {
        return Err(problem(
            "time.order",
            "\"time\" is for recorded inputs; simulated, external and received sources are live: use \"arrival\"",
        ));
    }
    let fusion = check_fusion(&raw.fusion, weighing)?;
    Ok(Config {
        monitor: check_monitor(&raw.monitor, &fusion)?,
        fusion,
        name: raw.name,
        origin: raw.origin,
        path: path.to_owned(),
        frame,
        order: raw.time.order,
        first_day_ns,
        sources,
        wide_area_sensors,
        receivers,
        gateways,
        scenario,
        recorder: raw.recorder.enabled,
    })
}

pub(super) fn place(key: &str, raw: &RawPlace) -> Checked<Geodetic> {
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
    network: &mut Network,
) -> Checked<(Source, engine::SourceSettings)> {
    let key = |part: &str| format!("source[{index}].{part}");
    let sensor_place = raw.place.as_ref().unwrap_or(origin);
    let turned = within(
        &key("place.north_offset_deg"),
        sensor_place.north_offset_deg,
        -360.0,
        360.0,
    )?;
    let mut origin = place(&key("place"), sensor_place)?;
    let (input, adapter) = match (
        &raw.recorded,
        &raw.live,
        &raw.simulated,
        &raw.simulated_direction_finder,
        &raw.external,
    ) {
        (Some(recorded), None, None, None, None) => {
            (Input::Recorded(check_recorded(index, recorded)?), raw.name.clone())
        }
        (None, Some(live), None, None, None) => (Input::Live(network.live(index, live)?), live.receiver.clone()),
        (None, None, None, None, Some(_)) => (Input::External, raw.name.clone()),
        (None, None, Some(simulated), None, None) => {
            simulated
                .validate()
                .map_err(|error| simulated_problem(&key("simulated"), &error))?;
            if raw.place.is_some() {
                let what = "a simulated sensor stands where its position_m says; leave [source.place] out";
                return Err(problem(key("place"), what));
            }
            origin = system.to_geodetic(simulated.position_m.unwrap_or_default());
            let instrument = Instrument::Sensor(Box::new(simulated.clone()));
            let simulated = network.simulated(index, &raw.name, instrument);
            (Input::Simulated(simulated), raw.name.clone())
        }
        (None, None, None, Some(finder), None) => {
            finder
                .validate()
                .map_err(|error| simulated_problem(&key("simulated_direction_finder"), &error))?;
            let instrument = Instrument::DirectionFinder(Box::new(finder.clone()));
            let simulated = network.simulated(index, &raw.name, instrument);
            (Input::Simulated(simulated), raw.name.clone())
        }
        _ => {
            let what = format!(
                "\"{}\" needs exactly one of [source.recorded], [source.live], [source.simulated], \
                 [source.simulated_direction_finder] and [source.external]",
                raw.name
            );
            return Err(problem(key("name"), what));
        }
    };
    let limits = check_limits(&key("limits"), &raw.limits)?;
    let period_s = within(&key("period_s"), raw.period_s, 1e-3, 3600.0)?;
    let tracker = check_tracker(index, raw, &input, network, period_s)?;
    let locator = check_locator(index, raw, &input, network)?;
    let source = Source {
        number: index as u16,
        uid: match raw.uid {
            Some(0) => {
                return Err(problem(
                    key("uid"),
                    "0 stands for an unknown sensor; choose a number from 1 to 4294967295",
                ));
            }
            Some(uid) => uid,
            None => messages::sensor_uid(&raw.name),
        },
        name: raw.name.clone(),
        technology: technology(raw.technology, &input, network),
        tracker,
        locator,
        input,
        adapter,
        model: SourceModel {
            number: index as u16,
            sac_sic: check_sac_sic(index, raw)?,
            positions: match (&raw.recorded, &raw.live) {
                (Some(recorded), _) => recorded.positions,
                (None, Some(live)) => live.positions,
                (None, None) => Default::default(),
            },
            frame: SensorFrame::new(system, origin, turned.to_radians()),
            system: *system,
            height_m: origin.height_m(),
            assumed_height_m: within(&key("assumed_height_m"), raw.assumed_height_m, -500.0, 20e3)?,
            // The lowest and the highest that were ever measured at sea level are 870 and 1084 hPa.
            qnh_hpa: within(&key("qnh_hpa"), raw.qnh_hpa, 850.0, 1100.0)?,
            limits,
            covariance: check_covariance(index, raw)?,
        },
    };
    let weighed = engine::SourceSettings {
        name: raw.name.clone(),
        sensor_uid: source.uid,
        period_ns: nanoseconds(period_s),
        fresh_ns: nanoseconds(within(
            &key("fresh_s"),
            raw.fresh_s.unwrap_or(2.5 * period_s),
            period_s,
            1e5,
        )?),
        accuracy: accuracy(&raw.accuracy, source.model.frame.place()),
        adjustment: raw.accuracy.adjustment,
        priority: raw.priority.unwrap_or(index as u32),
        ceiling_m: raw.ceiling_m.unwrap_or(f64::INFINITY),
        coverage: match &raw.coverage {
            Some(area) => Some(coverage(&key("coverage"), area, source.model.frame.place())?),
            None => source.locator.is_some().then(silence_says_nothing),
        },
    };
    Ok((source, weighed))
}

pub(super) fn check_limits(key: &str, raw: &RawLimits) -> Checked<Limits> {
    let part = |part: &str| format!("{key}.{part}");
    Ok(Limits {
        range_m: within(&part("range_m"), raw.range_m, 1.0, 2e6)?,
        height_min_m: within(&part("height_min_m"), raw.height_min_m, -1e4, 1e5)?,
        height_max_m: within(&part("height_max_m"), raw.height_max_m, raw.height_min_m, 1e5)?,
        speed_mps: within(&part("speed_mps"), raw.speed_mps, 0.1, 2e4)?,
        jump_m: within(&part("jump_m"), raw.jump_m, 0.0, 1e6)?,
        time_step_ns: nanoseconds(within(&part("time_step_s"), raw.time_step_s, 0.01, 40e3)?),
        tracks: within(&part("tracks"), raw.tracks as f64, 1.0, 1e6)? as usize,
    })
}

fn check_tracker(
    index: usize,
    raw: &RawSource,
    input: &Input,
    network: &Network,
    period_s: f64,
) -> Checked<Option<SourceTracker>> {
    let Some(tracker) = &raw.tracker else { return Ok(None) };
    let key = || format!("source[{index}].tracker");
    let has_detections = match input {
        Input::Recorded(recorded) => recorded.format == RecordedFormat::Asterix,
        Input::Live(live) => !network.is_sbs(&live.receiver),
        Input::Simulated(simulated) => match &simulated.instrument {
            Instrument::Sensor(sensor) => sensor.plots,
            Instrument::DirectionFinder(_) => false,
        },
        Input::External => false,
    };
    if !has_detections {
        let what = "takes plots in ASTERIX; leave it out where a source has tracks already, and give a simulated sensor \
                    plots = true";
        return Err(problem(key(), what));
    }
    tracker.checked(index as u16, period_s).map(Some)
}

/// A direction finder has bearings and nothing else, whether it is simulated or said to be one by its `[source.locator]`.
fn check_locator(
    index: usize,
    raw: &RawSource,
    input: &Input,
    network: &Network,
) -> Checked<Option<locating::Settings>> {
    let key = format!("source[{index}].locator");
    let may_have_bearings = match input {
        Input::Live(live) => network.is_udp(&live.receiver),
        Input::Simulated(simulated) => matches!(simulated.instrument, Instrument::DirectionFinder(_)),
        Input::Recorded(_) | Input::External => false,
    };
    match (&raw.locator, input) {
        (Some(_), _) if raw.tracker.is_some() => Err(problem(
            key,
            "bearings are located, detections are tracked: leave one of locator and tracker out",
        )),
        (Some(locator), _) if may_have_bearings => check_locating(locator, &key).map(Some),
        (Some(_), _) => {
            let what =
                "takes bearings: of a [[receiver]] with [receiver.udp], or of a [source.simulated_direction_finder]";
            Err(problem(key, what))
        }
        (None, Input::Simulated(_)) if may_have_bearings => check_locating(&RawLocating::default(), &key).map(Some),
        (None, _) => Ok(None),
    }
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
    if raw.format != RecordedFormat::Asterix && (!raw.editions.is_empty() || raw.strict) {
        return Err(problem(
            key("format"),
            "editions and strict are of ASTERIX files only; leave them out",
        ));
    }
    Ok(Recorded {
        file: PathBuf::from(&raw.file),
        format: raw.format,
        asterix: asterix(&key("editions"), &raw.editions, raw.strict)?,
        reorder_ns: nanoseconds(within(&key("reorder_s"), raw.reorder_s, 0.0, 60.0)?),
        truncated: raw.truncated,
    })
}

fn check_sac_sic(index: usize, raw: &RawSource) -> Checked<Option<(u8, u8)>> {
    let (part, sac, sic) = match (&raw.recorded, &raw.live) {
        (Some(recorded), _) => ("recorded", recorded.sac, recorded.sic),
        (None, Some(live)) => ("live", live.sac, live.sic),
        (None, None) if raw.external.is_some() => return Ok(None),
        (None, None) => return Ok(Some(simulated_sac_sic(index as u16))),
    };
    match (sac, sic) {
        (None, None) => Ok(None),
        (Some(sac), Some(sic)) => Ok(Some((sac, sic))),
        _ => Err(problem(
            format!("source[{index}].{part}"),
            "sac and sic go together: give both or neither",
        )),
    }
}

pub(super) fn accuracy(raw: &RawAccuracy, place_m: [f64; 2]) -> engine::Accuracy {
    engine::Accuracy {
        base: match raw.model {
            AccuracyModel::Constant => engine::AccuracyBase::Constant { sigma_m: raw.sigma_m },
            AccuracyModel::Polar => engine::AccuracyBase::Polar {
                place_m,
                range_sigma_m: raw.range_sigma_m,
                azimuth_sigma_rad: raw.azimuth_sigma_deg.to_radians(),
            },
            AccuracyModel::Reported => engine::AccuracyBase::Reported,
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

/// Who only hears what transmits does not deny what is silent.
fn silence_says_nothing() -> engine::CoverageArea {
    engine::CoverageArea {
        place_m: [0.0; 2],
        range_m: f64::INFINITY,
        sector_rad: None,
        polygon_m: Vec::new(),
        probability: 0.0,
    }
}

/// Where the source at `place_m` sees.
pub(super) fn coverage(key: &str, raw: &RawCoverage, place_m: [f64; 2]) -> Checked<engine::CoverageArea> {
    let part = |part: &str| format!("{key}.{part}");
    let range_m = match raw.range_m {
        Some(range_m) => within(&part("range_m"), range_m, 1.0, 2e6)?,
        None => f64::INFINITY,
    };
    for azimuth_deg in raw.sector_deg.into_iter().flatten() {
        within(&part("sector_deg"), azimuth_deg, -360.0, 360.0)?;
    }
    for coordinate_m in raw.polygon_m.iter().flatten() {
        within(&part("polygon_m"), *coordinate_m, -2e6, 2e6)?;
    }
    if (1..3).contains(&raw.polygon_m.len()) {
        let what = "a polygon has three corners or more, each [east, north]; leave it out for no further limit";
        return Err(problem(part("polygon_m"), what));
    }
    Ok(engine::CoverageArea {
        place_m,
        range_m,
        sector_rad: raw.sector_deg.map(|sector_deg| sector_deg.map(f64::to_radians)),
        polygon_m: raw.polygon_m.clone(),
        probability: within(&part("probability"), raw.probability, 0.01, 1.0)?,
    })
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

fn check_scenario(
    raw: &RawConfig,
    sources: &[Source],
    sensors: &[WideAreaSensor],
) -> Checked<Option<scenario::ScenarioSettings>> {
    let source = sources
        .iter()
        .find(|source| matches!(source.input, Input::Simulated(_)))
        .map(|source| format!("source[{}].name", source.number));
    let sensor = sensors
        .iter()
        .find(|sensor| sensor.simulated.is_some())
        .map(|sensor| format!("wide_area_sensor[{}].name", sensor.number));
    match (&raw.scenario, source.or(sensor)) {
        (Some(settings), _) => {
            settings
                .validate()
                .map_err(|error| simulated_problem("scenario", &error))?;
            Ok(Some(settings.clone()))
        }
        (None, Some(key)) => {
            let what = "is simulated, but there is no [scenario] to observe";
            Err(problem(key, what))
        }
        (None, None) => Ok(None),
    }
}

pub(super) fn check_fusion(fusion: &RawFusion, sources: Vec<engine::SourceSettings>) -> Checked<Fusion> {
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
    let usual = engine::Capacity::default();
    let usual_life = engine::LifeSettings::default();
    let settings = engine::Settings {
        rule: check_rule(&fusion.rule, &sources)?,
        registration: engine::RegistrationSettings {
            enabled: fusion.registration.enabled,
            reference_source: fusion
                .registration
                .reference_source
                .as_deref()
                .map(|name| source_called("fusion.registration.reference_source", name, &sources))
                .transpose()?,
            memory_s: within("fusion.registration.memory_s", fusion.registration.memory_s, 1.0, 1e6)?,
        },
        consistency: fusion.consistency,
        sources,
        capacity: engine::Capacity {
            system_tracks: fusion.capacity.system_tracks.unwrap_or(usual.system_tracks),
            sensor_tracks: fusion.capacity.sensor_tracks.unwrap_or(usual.sensor_tracks),
            stored_reports: fusion.capacity.stored_reports,
        },
        association: check_association(&fusion.association)?,
        life: engine::LifeSettings {
            confirm_reports: fusion.life.confirm_reports,
            terminate_ns: fusion.life.terminate_s.map_or(usual_life.terminate_ns, nanoseconds),
            tentative_ns: fusion.life.tentative_s.map_or(usual_life.tentative_ns, nanoseconds),
        },
        process_noise_m2ps3: fusion.process_noise_m2ps3,
        refresh_ns: fusion.refresh_s.map(nanoseconds),
        refresh_delay_ns: nanoseconds(fusion.refresh_delay_s),
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
        rests: fusion.rests,
        queue,
        deadline_ns: (within("fusion.deadline_us", fusion.deadline_us, 0.1, 1e9)? * 1e3) as i64,
    })
}

fn check_association(raw: &RawAssociation) -> Checked<engine::AssociationSettings> {
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
        error_correlation: raw.error_correlation,
        scan_wait: raw.scan_wait,
    })
}

/// Number of the source called `name`, which stands at `key`.
pub(super) fn source_called(key: &str, name: &str, sources: &[engine::SourceSettings]) -> Checked<u16> {
    let number = sources.iter().position(|source| source.name == name);
    number.map(|number| number as u16).ok_or_else(|| {
        let known: Vec<&str> = sources.iter().map(|source| source.name.as_str()).collect();
        let what = format!("there is no source named \"{name}\"; there are: {}", known.join(", "));
        problem(key, what)
    })
}

//! Checking what the file says, and turning it into what the processes work with.
//!
//! Each check names its key as the file spells it, so that the error can name the line.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use bus::WaitMode;
use frames::{Geodetic, SensorFrame, SystemFrame};
use fusion::settings as engine;
use messages::NS_PER_S;
use reception::SourceModel;
use settings::SettingsError;

use super::check_monitor::check_monitor;
use super::check_network::{Network, asterix, check_gateways, simulated_sac_sic, technology};
use super::check_rule::check_rule;
use super::raw::{AccuracyModel, RawAccuracy, RawAssociation, RawCoverage, RawFusion};
use super::tables::{DeploymentTable, PlaceTable, RecordedTable, SourceTable};
use super::tracker::source_tracker;
use super::tracker_links::check_links;
use super::wide_area_sensor::{WideAreaSensor, check_company, check_wide_area_sensors};
use super::{Config, Fusion, Input, Instrument, Links, Order, Recorded, RecordedFormat, Source};
use runtime::cores::{self, Placement};
use sources::{Processing, TrackerSettings};

pub(super) type Checked<T> = Result<T, SettingsError>;

pub(super) fn problem(key: impl Into<String>, what: impl Into<String>) -> SettingsError {
    SettingsError::new(key, what)
}

pub(super) fn within(key: &str, value: f64, low: f64, high: f64) -> Checked<f64> {
    settings::within(key, value, low, high).map(|()| value)
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
pub(super) fn check(path: &Path, raw: DeploymentTable) -> Checked<Config> {
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

pub(super) fn place(key: &str, raw: &PlaceTable) -> Checked<Geodetic> {
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
    raw: &SourceTable,
    system: &SystemFrame,
    origin: &PlaceTable,
    network: &mut Network,
) -> Checked<(Source, engine::SourceSettings)> {
    let key = |part: &str| format!("source[{index}].{part}");
    let sensor_place = raw.place.as_ref().unwrap_or(origin);
    let mut origin = place(&key("place"), sensor_place)?;
    let (input, adapter) = match (
        &raw.recorded,
        &raw.live,
        &raw.simulated,
        &raw.simulated_direction_finder,
    ) {
        (Some(recorded), ..) => (Input::Recorded(check_recorded(index, recorded)?), raw.name.clone()),
        (_, Some(live), ..) => (Input::Live(network.live(index, live)?), live.receiver.clone()),
        (_, _, Some(simulated), _) => {
            origin = system.to_geodetic(simulated.position_m.unwrap_or_default());
            let instrument = Instrument::Sensor(Box::new(simulated.clone()));
            let simulated = network.simulated(index, &raw.name, instrument);
            (Input::Simulated(simulated), raw.name.clone())
        }
        (_, _, _, Some(finder)) => {
            let instrument = Instrument::DirectionFinder(Box::new(finder.clone()));
            let simulated = network.simulated(index, &raw.name, instrument);
            (Input::Simulated(simulated), raw.name.clone())
        }
        _ => (Input::External, raw.name.clone()),
    };
    let sender = raw.recorded.as_ref().map(|recorded| &recorded.sender);
    let sender = sender.or(raw.live.as_ref().map(|live| &live.sender));
    let tracker =
        check_tracker(index, raw, &input, network)?.map(|settings| Processing::Detections(Box::new(settings)));
    let locator = check_locator(index, raw, &input, network)?.map(|settings| Processing::Bearings(Box::new(settings)));
    let source = Source {
        number: index as u16,
        uid: raw.uid.unwrap_or_else(|| messages::sensor_uid(&raw.name)),
        name: raw.name.clone(),
        technology: raw.technology.unwrap_or_else(|| technology(&input, network)),
        processing: tracker.or(locator).unwrap_or(Processing::Tracks),
        links: Links::default(),
        model: SourceModel {
            number: index as u16,
            sac_sic: match (&input, sender) {
                (Input::Simulated(_), _) => Some(simulated_sac_sic(index as u16)),
                (_, sender) => sender.and_then(|sender| sender.identity.sac_sic()),
            },
            positions: sender.map(|sender| sender.positions).unwrap_or_default(),
            frame: SensorFrame::new(system, origin, sensor_place.north_offset_deg.rad()),
            system: *system,
            height_m: origin.height_m(),
            assumed_height_m: raw.assumed_height_m,
            qnh_hpa: raw.qnh_hpa,
            limits: raw.limits,
            covariance: raw.covariance,
        },
        input,
        adapter,
    };
    let weighed = engine::SourceSettings {
        name: raw.name.clone(),
        sensor_uid: source.uid,
        period_ns: nanoseconds(raw.period_s),
        fresh_ns: nanoseconds(raw.fresh_s()),
        accuracy: accuracy(&raw.accuracy, source.model.frame.place()),
        adjustment: raw.accuracy.adjustment,
        priority: raw.priority.unwrap_or(index as u32),
        ceiling_m: raw.ceiling_m.unwrap_or(f64::INFINITY),
        coverage: match &raw.coverage {
            Some(area) => Some(coverage(&key("coverage"), area, source.model.frame.place())?),
            None => source.locator().is_some().then(silence_says_nothing),
        },
    };
    Ok((source, weighed))
}

fn check_tracker(
    index: usize,
    raw: &SourceTable,
    input: &Input,
    network: &Network,
) -> Checked<Option<TrackerSettings>> {
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
    source_tracker(tracker, index as u16, raw.period_s).map(Some)
}

/// A direction finder has bearings and nothing else, whether it is simulated or said to be one by its
/// `[source.locator]`.
fn check_locator(
    index: usize,
    raw: &SourceTable,
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
        (Some(locator), _) if may_have_bearings => Ok(Some(*locator)),
        (Some(_), _) => {
            let what =
                "takes bearings: of a [[receiver]] with [receiver.udp], or of a [source.simulated_direction_finder]";
            Err(problem(key, what))
        }
        (None, Input::Simulated(_)) if may_have_bearings => Ok(Some(locating::Settings::default())),
        (None, _) => Ok(None),
    }
}

fn check_recorded(index: usize, raw: &RecordedTable) -> Checked<Recorded> {
    Ok(Recorded {
        file: PathBuf::from(&raw.file),
        format: raw.format,
        asterix: asterix(&format!("source[{index}].recorded.editions"), &raw.sender.reading)?,
        reorder_ns: raw.reorder_s.ns(),
        truncated: raw.truncated,
    })
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

fn first_day(raw: &DeploymentTable, sources: &[Source]) -> Checked<Option<i64>> {
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
    raw: &DeploymentTable,
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
        (None, Some(key)) => {
            let what = "is simulated, but there is no [scenario] to observe";
            Err(problem(key, what))
        }
        (scenario, _) => Ok(scenario.clone()),
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

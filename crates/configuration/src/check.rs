//! Checking what the file says, and turning it into what the processes work with.
//!
//! Each check names its key as the file spells it, so that the error can name the line.

use std::collections::BTreeSet;
use std::path::Path;

use alerts::AlertRules;
use frames::SystemFrame;
use fusion_settings::Settings as Engine;
use settings::SettingsError;

use super::check_network::Network;
use super::check_qnh::check_qnh;
use super::check_region::check_regions;
use super::check_source::{check_source, instrument};
use super::checked::{Checked, CheckedSource, place};
use super::finder_on_board::mount_finders;
use super::platform::{check_platform_names, check_platforms, find_radars};
use super::tables::{DeploymentTable, FusionTable};
use super::tracker_links::check_links;
use super::tracker_process::check_trackers;
use super::wide_area_sensor::{check_company, check_wide_area_sensors};
use deployment::{Deployment, Input, Link, ReportOrder, Services, Source, SystemTracks, WideAreaSensor, check_name};
use scenario::{WideAreaSettings, World};
use sources::Readings;

/// A deployment without its services.
pub(super) struct CheckedDeployment {
    pub(super) deployment: Deployment,
    pub(super) engine: Engine,
    pub(super) readings: Readings,
    pub(super) world: World,
    pub(super) alerts: AlertRules,
}

/// The checked deployment that `raw`, read from `path`, describes, with the settings of its algorithms.
pub(super) fn check(path: &Path, mut raw: DeploymentTable) -> Checked<CheckedDeployment> {
    check_name("name", &raw.name)?;
    let frame = SystemFrame::at(place("frame", &raw.frame)?);
    if raw.sources.is_empty() && raw.trackers.is_empty() {
        return Err(SettingsError::new(
            "",
            "there is no [[source]] and no [[tracker]]: a deployment needs at least one",
        ));
    }
    let mut names = BTreeSet::new();
    for (index, source) in raw.sources.iter().enumerate() {
        let key = format!("source[{index}].name");
        check_name(&key, &source.name)?;
        if !names.insert(source.name.clone()) {
            return Err(SettingsError::new(
                key,
                format!(
                    "\"{}\" is the name of an earlier source; give each its own",
                    source.name
                ),
            ));
        }
    }
    let mut network = Network::new(&raw.receivers)?;
    let (mut sources, mut weighing) = (Vec::new(), Vec::new());
    for (index, source) in raw.sources.iter().enumerate() {
        let (source, weighed) = check_source(index, source, &frame, &raw.frame, &mut network)?;
        sources.push(source);
        weighing.push(weighed);
    }
    let wide_area_sensors = check_wide_area_sensors(&raw, &frame, &mut network)?;
    let (wide_area_sensors, counted): (Vec<WideAreaSensor>, _) = wide_area_sensors.into_iter().unzip();
    check_links(&mut sources, &raw.sources, &raw.wide_area_sensors)?;
    mount_finders(&raw, &mut sources)?;
    let mut trackers = check_trackers(&raw, names, &frame, &mut network)?;
    for (mut source, weighed) in trackers.sources.drain(..) {
        let place = usize::from(source.number);
        if place < sources.len() {
            // A source in the short form of a tracker keeps its place.
            source.technology = sources[place].technology;
            (sources[place], weighing[place]) = (source, weighed);
            continue;
        }
        sources.push(source);
        weighing.push(weighed);
    }
    let located = |error| trackers.located(error);
    check_company(&sources, &wide_area_sensors).map_err(located)?;
    let (mut platforms, of_platforms) = check_platforms(&raw.platforms)?;
    find_radars(&mut platforms, &raw, &trackers.sensors).map_err(|error| trackers.located(error))?;
    let behind: Vec<CheckedSource> = sources.iter().chain(&trackers.sensors).cloned().collect();
    let receivers = network.receivers(&behind, &wide_area_sensors).map_err(located)?;
    let (all, of_sources): (Vec<Source>, _) = behind
        .into_iter()
        .map(|checked| (checked.source, checked.reading))
        .unzip();
    let (sources, tracker_sensors) = all.split_at(sources.len());
    let (sources, tracker_sensors) = (sources.to_vec(), tracker_sensors.to_vec());
    deployment::check_links(&raw.links, &sources, &wide_area_sensors)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    raw.links.iter_mut().for_each(|link| link.take_files_from(folder));
    let first_day_ns = first_day(&raw, &sources)?;
    let world = check_world(&raw, &sources)?;
    // What a link brings has its source's progress with it.
    let is_linked = |source: &Source| {
        let topic = messages::sensor_tracks(&source.name).name;
        raw.links
            .iter()
            .flat_map(|link| &link.receive)
            .any(|remote| remote.into() == topic.as_str())
    };
    let is_live = |source: &Source| matches!(source.input, Input::External) && !is_linked(source);
    let is_tracker_live = |source: &Source| matches!(source.input, Input::Tracker(_)) && !source.input.is_recorded();
    let external = sources.iter().any(|source| is_live(source) || is_tracker_live(source));
    if (external || !receivers.is_empty()) && raw.time.order == ReportOrder::Time {
        return Err(SettingsError::new(
            "time.order",
            "\"time\" is for recorded inputs; simulated, external and received sources are live: use \"arrival\"",
        ));
    }
    let FusionTable {
        engine,
        process: fusion,
    } = raw.fusion;
    if fusion.standby && !raw.checkpoint.enabled {
        let what = "needs the checkpoint, from which it goes on: leave [checkpoint] enabled";
        return Err(SettingsError::new("fusion.standby", what));
    }
    let engine = engine.with_sources(weighing);
    let mut engine = engine.map_err(|error| error.under("fusion"))?;
    match raw.time.order {
        ReportOrder::Arrival => engine.expect_late_reports(),
        // No report is late; files may have late ones, unless that is excluded.
        ReportOrder::Time => engine.late_window_s = engine.late_window_s.filter(|window| window.ns() == 0),
    }
    let alerts = AlertRules {
        rules: raw.alerts,
        areas: raw.areas,
    };
    alerts.check()?;
    engine.qnh = check_qnh(&raw.qnh, &frame)?;
    engine.border.regions = check_regions(&raw.regions, (raw.origin, engine.exchange), &frame)?;
    let own = messages::own_tracks().name;
    let sends_own = |link: &Link| link.send.iter().any(|topic| topic == own.as_str());
    if let Some(index) = raw.links.iter().position(sends_own)
        && !(engine.exchange && raw.origin != 0)
    {
        let what = format!(
            "\"{}\" needs fusion.exchange = true, and an origin other than 0",
            own.as_str()
        );
        return Err(SettingsError::new(format!("link[{index}].send"), what));
    }
    let deployment = Deployment {
        fusion,
        name: raw.name,
        origin: raw.origin,
        path: path.to_owned(),
        text: String::new(),
        frame,
        order: raw.time.order,
        first_day_ns,
        sources,
        tracker_sensors,
        wide_area_sensors,
        platforms,
        receivers,
        links: raw.links,
        checkpoint: raw.checkpoint,
        machine: raw.machine,
        system_tracks: SystemTracks {
            max: engine.capacity.system_tracks(),
            exchange: engine.exchange,
            smooths: engine.smoothing_lag_s.is_some(),
            rule: engine.rule.name.0,
            queue: engine.capacity.queue,
        },
        services: Services {
            alerts: !alerts.rules.is_empty(),
            ..Services::default()
        },
    };
    check_platform_names(&deployment)?;
    Ok(CheckedDeployment {
        deployment,
        engine,
        readings: Readings {
            sources: of_sources,
            platforms: of_platforms,
            counted,
        },
        world,
        alerts,
    })
}

fn first_day(raw: &DeploymentTable, sources: &[Source]) -> Checked<Option<i64>> {
    let recorded = sources.iter().any(|source| source.input.is_recorded());
    match &raw.time.date {
        Some(date) => day_ns(date)
            .map(Some)
            .map_err(|what| SettingsError::new("time.date", what)),
        None if recorded => Err(SettingsError::new(
            "time.date",
            "missing: recordings carry the time of day only, so give their first day (UTC)",
        )),
        None => Ok(None),
    }
}

/// Reads a date; UTC of its midnight, nanoseconds since 1970.
///
/// # Errors
/// If `date` is none, or too far from 1970; the message has the remedy.
pub fn day_ns(date: &str) -> Result<i64, String> {
    let day: jiff::civil::Date = date
        .parse()
        .map_err(|_| format!("\"{date}\" is not a date: write year-month-day, as in \"2016-05-10\""))?;
    let midnight = day
        .to_zoned(jiff::tz::TimeZone::UTC)
        .map_err(|error| error.to_string())?;
    i64::try_from(midnight.timestamp().as_nanosecond())
        .map_err(|_| format!("\"{date}\" is beyond the times that are computed: 1678 to 2261"))
}

/// The simulated world, and what observes it.
fn check_world(raw: &DeploymentTable, sources: &[Source]) -> Checked<World> {
    let is_simulated = |source: &&Source| matches!(source.input, Input::Simulated(_));
    let source = sources.iter().find(is_simulated);
    let source = source.map(|source| format!("source[{}].name", source.number));
    let counting = (0..).zip(raw.wide_area_sensors.iter());
    let counting = counting.filter_map(|(number, sensor)| Some((number, sensor.simulated.clone()?)));
    let counting: Vec<(u16, WideAreaSettings)> = counting.collect();
    let sensor = counting
        .first()
        .map(|(number, _)| format!("wide_area_sensor[{number}].name"));
    if let (None, Some(key)) = (&raw.scenario, source.or(sensor)) {
        let what = "is simulated, but there is no [scenario] to observe";
        return Err(SettingsError::new(key, what));
    }
    let simulated = (0..)
        .zip(&raw.sources)
        .zip(sources)
        .filter(|(_, source)| is_simulated(source));
    let ships = (0..).zip(&raw.platforms);
    Ok(World {
        targets: raw.scenario.clone(),
        instruments: simulated
            .filter_map(|((number, table), _)| Some((number, instrument(table)?)))
            .collect(),
        counting,
        ships: ships
            .filter_map(|(number, platform)| Some((number, platform.simulated?)))
            .collect(),
    })
}

//! Checking what the file says, and turning it into what the processes work with.
//!
//! Each check names its key as the file spells it, so that the error can name the line.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use ::fusion::Settings as Engine;
use ::fusion::settings::{AccuracyTable, CoverageArea, SourceSettings};
use frames::{SensorFrame, SystemFrame};
use reception::ConversionModel;
use scenario::{SensorKind, SensorSettings};
use settings::SettingsError;

use super::check_network::{Network, asterix, simulated_sac_sic, technology};
use super::check_qnh::check_qnh;
use super::check_region::check_regions;
use super::checked::{Checked, limits, place};
use super::platform::{check_platform_names, check_platforms};
use super::tables::{DeploymentTable, FusionTable, PlaceTable, RecordedTable, SourceTable};
use super::tracker::source_tracker;
use super::tracker_links::check_links;
use super::wide_area_sensor::{check_company, check_wide_area_sensors};
use deployment::{
    Deployment, Input, Instrument, Link, Links, Recorded, RecordedFormat, ReportOrder, SampleDelivery, Services,
    Source, SystemTracks, WideAreaSensor, check_name,
};
use sources::{Processing, TrackerSettings};

/// Shortest silence that is told, seconds: processes speak five times a second.
const SILENT_MIN_S: f64 = 1.0;

/// The checked deployment that `raw`, read from `path`, describes, with the settings of its algorithms.
pub(super) fn check(path: &Path, raw: DeploymentTable) -> Checked<(Deployment, Engine, Vec<Processing>)> {
    check_name("name", &raw.name)?;
    let frame = SystemFrame::at(place("frame", &raw.frame)?);
    if raw.sources.is_empty() {
        return Err(SettingsError::new(
            "",
            "there is no [[source]]: a deployment needs at least one",
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
    let (mut sources, mut processing, mut weighing) = (Vec::new(), Vec::new(), Vec::new());
    for (index, source) in raw.sources.iter().enumerate() {
        let (source, processed, weighed) = check_source(index, source, &frame, &raw.frame, &mut network)?;
        sources.push(source);
        processing.push(processed);
        weighing.push(weighed);
    }
    let wide_area_sensors = check_wide_area_sensors(&raw, &frame, &mut network)?;
    check_links(&mut sources, &raw.sources, &raw.wide_area_sensors)?;
    check_company(&sources, &wide_area_sensors)?;
    let platforms = check_platforms(&raw.platforms)?;
    let receivers = network.receivers(&sources, &wide_area_sensors)?;
    deployment::check_links(&raw.links, &sources, &wide_area_sensors)?;
    let first_day_ns = first_day(&raw, &sources)?;
    let scenario = check_scenario(&raw, &sources, &wide_area_sensors)?;
    // What a link brings has its source's progress with it.
    let is_linked = |source: &Source| {
        let topic = messages::sensor_tracks(&source.name).name;
        raw.links
            .iter()
            .flat_map(|link| &link.receive)
            .any(|remote| remote.into() == topic.as_str())
    };
    let is_live = |source: &Source| matches!(source.input, Input::External) && !is_linked(source);
    let external = sources.iter().any(is_live);
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
        wide_area_sensors,
        platforms,
        receivers,
        links: raw.links,
        checkpoint: raw.checkpoint,
        system_tracks: SystemTracks {
            max: engine.capacity.system_tracks(),
            exchange: engine.exchange,
            smooths: engine.smoothing_lag_s.is_some(),
            rule: engine.rule.name.0,
            queue: engine.capacity.queue,
        },
        scenario,
        services: Services::default(),
    };
    check_platform_names(&deployment)?;
    Ok((deployment, engine, processing))
}

fn check_source(
    index: usize,
    raw: &SourceTable,
    system: &SystemFrame,
    origin: &PlaceTable,
    network: &mut Network,
) -> Checked<(Source, Processing, SourceSettings)> {
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
    let processing = tracker.or(locator).unwrap_or(Processing::Tracks);
    let source = Source {
        number: index as u16,
        uid: raw.uid.unwrap_or_else(|| messages::sensor_uid(&raw.name)),
        name: raw.name.clone(),
        technology: raw.technology.unwrap_or_else(|| technology(&input, network)),
        delivers: delivery(&processing),
        links: Links::default(),
        silent_after_ns: silent_after_ns(raw, &input),
        period_ns: settings::Seconds::of(raw.period_s()).ns(),
        required: raw.required,
        model: ConversionModel {
            number: index as u16,
            sac_sic: match (&input, sender) {
                (Input::Simulated(_), _) => Some(simulated_sac_sic(index as u16)),
                (_, sender) => sender.and_then(|sender| sender.identity.sac_sic()),
            },
            method: sender.map(|sender| sender.method).unwrap_or_default(),
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
    let place_m = source.model.frame.place();
    let usual = (raw.period_s(), u32::from(source.number));
    let weighed = SourceSettings::new(&raw.name, &raw.weighing, usual, place_m, &AccuracyTable::default());
    let mut weighed = weighed.map_err(|error| error.under(&format!("source[{index}]")))?;
    weighed.sensor_uid = source.uid;
    let is_self_reported = source.technology == outgoing::Technology::AdsB;
    weighed.is_self_reported = raw.weighing.self_reported.unwrap_or(is_self_reported);
    let is_radar = |simulated: &SensorSettings| simulated.kind == SensorKind::Radar;
    if raw.place.is_some() || raw.simulated.as_ref().is_some_and(is_radar) {
        weighed.place_m = Some(place_m);
    }
    if source.is_taken_as_it_is() {
        // What comes through an adapter has been looked at there.
        weighed.limits = limits(&source.model.limits, place_m);
    }
    if source.has_bearings() {
        // A direction finder hears what transmits: its silence is no evidence of absence.
        weighed.coverage.get_or_insert_with(CoverageArea::none);
    }
    Ok((source, processing, weighed))
}

fn delivery(processing: &Processing) -> SampleDelivery {
    match processing {
        Processing::Tracks => SampleDelivery::Tracks,
        Processing::Detections(tracker) => SampleDelivery::Detections {
            cues: tracker.outputs.cues,
        },
        Processing::Bearings(_) => SampleDelivery::Bearings,
    }
}

/// Silence that is an alarm.
fn silent_after_ns(raw: &SourceTable, input: &Input) -> Option<i64> {
    let is_expected = !matches!(input, Input::Recorded(_)) && raw.silent_periods > 0.0;
    is_expected.then(|| ((raw.silent_periods * raw.period_s()).max(SILENT_MIN_S) * messages::NS_PER_S) as i64)
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
        return Err(SettingsError::new(key(), what));
    }
    source_tracker(tracker, index as u16, raw.weighing.period_s).map(Some)
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
            Err(SettingsError::new(key, what))
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

fn first_day(raw: &DeploymentTable, sources: &[Source]) -> Checked<Option<i64>> {
    let recorded = sources.iter().any(|source| matches!(source.input, Input::Recorded(_)));
    match &raw.time.date {
        Some(date) => {
            let day: jiff::civil::Date = date.parse().map_err(|_| {
                SettingsError::new(
                    "time.date",
                    format!("\"{date}\" is not a date: write year-month-day, as in \"2016-05-10\""),
                )
            })?;
            let midnight = day
                .to_zoned(jiff::tz::TimeZone::UTC)
                .map_err(|error| SettingsError::new("time.date", error.to_string()))?;
            Ok(Some(midnight.timestamp().as_nanosecond() as i64))
        }
        None if recorded => Err(SettingsError::new(
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
            Err(SettingsError::new(key, what))
        }
        (scenario, _) => Ok(scenario.clone()),
    }
}

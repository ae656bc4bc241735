//! Tracker processes: several sensors whose detections one tracker joins (HT-12).
//!
//! The tracks of a tracker are those of one source, which follows the sources of the file; numbers in the file do not
//! change. The sensors follow behind all sources. They are read as sources are, so that a radar of a tracker has the
//! keys of any radar, but fusion does not know them.
//!
//! ```toml
//! [[tracker]]
//! name = "ship"                    # its tracks are at sensor/ship/tracks
//! wait_s = 0.3
//!
//! [[tracker.sensor]]
//! name = "radar"                   # its detections are at sensor/ship.radar/detections
//! [tracker.sensor.live]
//! receiver = "lan"
//!
//! [[tracker.sensor]]
//! name = "camera"
//! sigmas = [0.01]
//! [tracker.sensor.external]
//! ```

use std::collections::BTreeSet;

use deployment::{
    Input, OnBoard, PlotFormat, RecordedFormat, SampleDelivery, Source, TrackerInput, Truncated, check_name,
};
use frames::SystemFrame;
use fusion_settings::SourceSettings;
use platform::{Bearings, Mount};
use settings::{Seconds, SettingsError};
use sources::joining::JoiningSettings;
use sources::{Outputs, PlatformAxes, Processing, TrackerSettings};
use tracking::cutting::{Boundaries, CutterSettings};
use tracking::settings::SensorFacts;

use super::check_network::Network;
use super::check_source::check_source;
use super::checked::{Checked, CheckedSource};
use super::external_detections::tracker_of;
use super::tables::{
    DeploymentTable, LiveTable, PlaceTable, RecordedTable, SourceExternalTable, SourceTable, TrackerSensorTable,
    TrackerTable,
};
use super::tracker::WAITING_SCANS;
use super::tracker_links::numbers_of;

/// Most sensors of a tracker.
const SENSORS_MAX: usize = 32;

/// Additions of the tracker processes to a deployment.
#[derive(Debug, Default)]
pub(super) struct TrackerProcesses {
    pub(super) sources: Vec<(CheckedSource, SourceSettings)>,
    pub(super) sensors: Vec<CheckedSource>,
    /// Keys of the sources and then of the sensors, in the order of their numbers.
    keys: Vec<String>,
    first: usize,
}

/// The tracker processes of a file, with names other than `names`.
pub(super) fn check_trackers(
    raw: &DeploymentTable,
    mut names: BTreeSet<String>,
    frame: &SystemFrame,
    network: &mut Network,
) -> Checked<TrackerProcesses> {
    let first = raw.sources.len();
    let mut all = TrackerProcesses {
        first,
        ..TrackerProcesses::default()
    };
    let of_trackers = |(place, tracker): (usize, &TrackerTable)| {
        let sensor = move |sensor| format!("tracker[{place}].sensor[{sensor}]");
        (0..tracker.sensors.len()).map(sensor)
    };
    all.keys = (0..raw.trackers.len())
        .map(|place| format!("tracker[{place}]"))
        .collect();
    all.keys.extend(raw.trackers.iter().enumerate().flat_map(of_trackers));
    // Sources in the short form keep their numbers; their sensors follow those of the trackers.
    let short: Vec<(usize, TrackerTable)> = (0..)
        .zip(&raw.sources)
        .filter_map(|(number, source)| Some((number, tracker_of(source)?)))
        .collect();
    all.keys
        .extend(short.iter().map(|(number, _)| format!("source[{number}]")));
    for (place, tracker) in raw.trackers.iter().enumerate() {
        let key = format!("tracker[{place}]");
        check_name(&format!("{key}.name"), &tracker.name)?;
        if !names.insert(tracker.name.clone()) || raw.receivers.iter().any(|other| other.name == tracker.name) {
            let what = format!(
                "\"{}\" is also the name of a source or receiver; give each its own",
                tracker.name
            );
            return Err(SettingsError::new(format!("{key}.name"), what));
        }
        if tracker.sensors.len() > SENSORS_MAX {
            let what = format!(
                "{} sensors are more than {SENSORS_MAX}; split them among trackers",
                tracker.sensors.len()
            );
            return Err(SettingsError::new(format!("{key}.sensor"), what));
        }
        all.add(&key, first + place, tracker, (raw, frame), network)?;
    }
    for (number, tracker) in &short {
        all.add(
            &format!("source[{number}].tracker"),
            *number,
            tracker,
            (raw, frame),
            network,
        )?;
    }
    Ok(all)
}

impl TrackerProcesses {
    /// Adds the tracker of the source `number`, whose keys begin with `key`.
    fn add(
        &mut self,
        key: &str,
        number: usize,
        tracker: &TrackerTable,
        (raw, frame): (&DeploymentTable, &SystemFrame),
        network: &mut Network,
    ) -> Checked<()> {
        let begin = self.sensors.len();
        for sensor in &tracker.sensors {
            let number = self.first + raw.trackers.len() + self.sensors.len();
            let checked = check_sensor(number, tracker, sensor, (frame, &raw.frame), network);
            let checked = checked.and_then(|checked| carried(number, checked, sensor, raw));
            let checked = checked.and_then(|checked| simulated(number, checked, sensor, raw, network));
            let sensor = checked.map_err(|error| self.located(error))?;
            self.sensors.push(sensor);
        }
        let source = check_tracker(
            number,
            tracker,
            &self.sensors[begin..],
            begin,
            (frame, &raw.frame),
            network,
        );
        let (mut source, weighed) = source.map_err(|error| self.located(error))?;
        check_links(key, tracker, &mut source, raw)?;
        self.sources.push((source, weighed));
        Ok(())
    }

    /// The error with the key in the file: checks name sources and sensors by their numbers.
    pub(super) fn located(&self, mut error: SettingsError) -> SettingsError {
        let Some((number, part)) = error.key.strip_prefix("source[").and_then(|rest| rest.split_once(']')) else {
            return error;
        };
        let place = number
            .parse::<usize>()
            .ok()
            .and_then(|number| number.checked_sub(self.first));
        if let Some(key) = place.and_then(|place| self.keys.get(place)) {
            error.key = format!("{key}{part}");
        }
        error
    }
}

fn check_sensor(
    number: usize,
    tracker: &TrackerTable,
    raw: &TrackerSensorTable,
    (system, origin): (&SystemFrame, &PlaceTable),
    network: &mut Network,
) -> Checked<CheckedSource> {
    let key = |part: &str| format!("source[{number}].{part}");
    check_name(&key("name"), &raw.name)?;
    let name = format!("{}.{}", tracker.name, raw.name);
    if name.len() > 31 {
        let what = format!("\"{name}\" is longer than 31 characters; shorten the name of the tracker or of the sensor");
        return Err(SettingsError::new(key("name"), what));
    }
    if tracker.sensors.iter().filter(|other| other.name == raw.name).count() > 1 {
        let what = format!("\"{}\" is the name of two sensors; give each its own", raw.name);
        return Err(SettingsError::new(key("name"), what));
    }
    let sensor_id = raw.live.as_ref().and_then(|live| live.sensor_id);
    let sensor_id = sensor_id.or(raw.recorded.as_ref().and_then(|recorded| recorded.sensor_id));
    let format = raw.format().unwrap_or(PlotFormat::Rows);
    if sensor_id.is_some() && format == PlotFormat::Asterix {
        let part = if raw.live.is_some() {
            "live.sensor_id"
        } else {
            "recorded.sensor_id"
        };
        let what = "is a number in rows; name a sensor of ASTERIX by sac and sic";
        return Err(SettingsError::new(key(part), what));
    }
    let mut table = SourceTable {
        name,
        place: raw.place.clone(),
        assumed_height_m: raw.assumed_height_m,
        limits: raw.limits,
        covariance: raw.covariance,
        silent_periods: raw.silent_periods,
        live: raw.live.as_ref().map(|live| LiveTable {
            receiver: live.receiver.clone(),
            sender: live.sender.clone(),
        }),
        recorded: raw.recorded.as_ref().map(|recorded| RecordedTable {
            file: recorded.file.clone(),
            format: RecordedFormat::Asterix,
            reorder_s: Seconds::of(0.0),
            truncated: Truncated::Accept,
            sender: recorded.sender.clone(),
        }),
        external: raw
            .external
            .as_ref()
            .or(raw.orders.as_ref())
            .or(raw.simulated.as_ref())
            .map(|_| SourceExternalTable::default()),
        ..SourceTable::default()
    };
    table.weighing.period_s = raw.period_s;
    let (mut source, ..) = check_source(number, &table, system, origin, network)?;
    source.reading.processing = Processing::Plots;
    source.delivers = SampleDelivery::Plots { format, sensor_id };
    source.takes_orders = raw.orders.is_some();
    if !matches!(source.input, Input::Live(_)) {
        // The tracker process reads the file or the topic itself.
        source.adapter.clone_from(&tracker.name);
    }
    Ok(source)
}

/// The sensor behind a receiver of its own, if it is a simulated radar.
fn simulated(
    number: usize,
    mut source: CheckedSource,
    raw: &TrackerSensorTable,
    file: &DeploymentTable,
    network: &mut Network,
) -> Checked<CheckedSource> {
    if raw.simulated.is_none() {
        return Ok(source);
    }
    let platform = source.on_board.and_then(|on_board| on_board.platform);
    let Some(platform) = platform.filter(|place| file.platforms[usize::from(*place)].simulated.is_some()) else {
        let what = "is the radar of a simulated platform; name one by on_board.platform".to_owned();
        return Err(SettingsError::new(format!("source[{number}].simulated"), what));
    };
    source.input = Input::Live(network.simulated_radar(platform, &source.name));
    source.adapter = source.name.clone();
    Ok(source)
}

/// The sensor with its mounting on a platform, if it has one.
fn carried(
    number: usize,
    mut source: CheckedSource,
    raw: &TrackerSensorTable,
    file: &DeploymentTable,
) -> Checked<CheckedSource> {
    let Some(on_board) = &raw.on_board else {
        return Ok(source);
    };
    let refused = |part: &str, what: String| Err(SettingsError::new(format!("source[{number}].{part}"), what));
    let is_asterix = raw.format() == Some(PlotFormat::Asterix);
    let Some(name) = &on_board.platform else {
        if is_asterix {
            return refused(
                "on_board.platform",
                "is missing: plots state no platform; name one".to_owned(),
            );
        }
        source.on_board = Some(OnBoard { platform: None });
        source.reading.mount = Some(on_board.mount);
        return Ok(source);
    };
    let Some(place) = file.platforms.iter().position(|platform| platform.name == *name) else {
        let names: Vec<&str> = file.platforms.iter().map(|platform| platform.name.as_str()).collect();
        let what = match names.is_empty() {
            true => format!("\"{name}\": there is no [[platform]]"),
            false => format!("\"{name}\" is no [[platform]]; there are: {}", names.join(", ")),
        };
        return refused("on_board.platform", what);
    };
    if file.platforms[place].recorded.is_some() != raw.recorded.is_some() {
        let what = format!("\"{name}\": a recorded platform carries recorded sensors, and a live one live sensors");
        return refused("on_board.platform", what);
    }
    if raw.place.is_some() {
        return refused("place", "the platform's states give the place: leave it out".to_owned());
    }
    if is_asterix && source.reading.model.covariance.polar().is_none() {
        let what = "needs range_sigma_m and azimuth_sigma_deg for a radar on board".to_owned();
        return refused("covariance", what);
    }
    source.reading.model.is_on_board = true;
    source.reading.mount = Some(on_board.mount);
    source.on_board = Some(OnBoard {
        platform: Some(place as u16),
    });
    Ok(source)
}

fn check_tracker(
    number: usize,
    raw: &TrackerTable,
    sensors: &[CheckedSource],
    begin: usize,
    (system, origin): (&SystemFrame, &PlaceTable),
    network: &mut Network,
) -> Checked<(CheckedSource, SourceSettings)> {
    let key = |part: &str| format!("source[{number}].{part}");
    let recorded = sensors.iter().filter(|sensor| sensor.input.is_recorded()).count();
    if recorded > 0 && recorded < sensors.len() {
        let what = "some sensors are recordings and some are not: their times are of different days; make all sensors recordings, or none";
        return Err(SettingsError::new(key("name"), what));
    }
    let orders = sensors.iter().filter(|sensor| sensor.takes_orders).count();
    if orders > 1 {
        let what = "two sensors take orders; an order names the tracker alone: leave one";
        return Err(SettingsError::new(key("name"), what));
    }
    if recorded > 0 && raw.cues {
        let what = "the sensors of a recording look nowhere: leave it out";
        return Err(SettingsError::new(key("cues"), what));
    }
    let mut table = SourceTable {
        name: raw.name.clone(),
        uid: raw.uid,
        required: raw.required,
        silent_periods: raw.silent_periods,
        external: Some(SourceExternalTable::default()),
        ..SourceTable::default()
    };
    table.weighing.clone_from(&raw.weighing);
    let (mut source, mut weighed) = check_source(number, &table, system, origin, network)?;
    let is_recorded = recorded > 0;
    source.input = Input::Tracker(TrackerInput {
        sensors: begin..begin + sensors.len(),
        is_recorded,
    });
    source.delivers = SampleDelivery::Detections { cues: raw.cues };
    if is_recorded {
        source.silent_after_ns = None;
    }
    weighed.designates_round = (orders > 0).then(|| system.to_geodetic([0.0; 3]));
    // A tracker's tracks are looked at before they are published, as an adapter's are.
    weighed.limits = Default::default();
    let mut settings = raw.settings.clone();
    let facts = |(sensor, source): (&TrackerSensorTable, &CheckedSource)| SensorFacts {
        sensor_id: observations::sensor_id(source.number),
        model: sensor.model,
        sigmas: sensor.sigmas.clone(),
        range_rate_sigma_mps: sensor.range_rate_sigma_mps,
        priority: sensor.priority,
    };
    settings.sensors = raw.sensors.iter().zip(sensors).map(facts).collect();
    settings::check(&settings).map_err(|error| error.under(&format!("source[{number}]")))?;
    let waiting_max = WAITING_SCANS * settings.capacity.detections();
    let cutter = |sensor: &TrackerSensorTable| CutterSettings {
        boundaries: sensor.scans.unwrap_or(match sensor.format() {
            Some(PlotFormat::Asterix) => Boundaries::Turn,
            _ => Boundaries::Stated,
        }),
        period_ns: sensor.period_s.map(|period_s| Seconds::of(period_s).ns()),
        wait_ns: sensor.wait_s.map(|wait_s| Seconds::of(wait_s).ns()),
        waiting_max,
        epoch_ns: 0,
    };
    let tracker = TrackerSettings {
        joining: JoiningSettings {
            cutters: raw.sensors.iter().map(cutter).collect(),
            wait_ns: raw.wait_s.ns(),
        },
        settings,
        outputs: Outputs {
            period_ns: raw.output_period_s.map(Seconds::ns),
            cues: raw.cues,
        },
        events: true,
        platform: axes(sensors),
    };
    source.reading.processing = Processing::Detections(Box::new(tracker));
    Ok((source, weighed))
}

/// Axes of the platform that carries all of these sensors, if one does.
fn axes(sensors: &[CheckedSource]) -> Option<PlatformAxes> {
    let mounted: Option<Vec<(OnBoard, Mount)>> = sensors
        .iter()
        .map(|sensor| Some((sensor.on_board?, sensor.reading.mount?)))
        .collect();
    let mounted = mounted?;
    let (first, _) = mounted.first()?;
    let is_fixed = mounted.iter().any(|(_, mount)| mount.bearings == Bearings::Nose);
    let is_one = mounted.iter().all(|(on_board, _)| on_board == first);
    is_one.then_some(if is_fixed {
        PlatformAxes::Hull
    } else {
        PlatformAxes::North
    })
}

/// Finds the wide-area sensors and direction finders that the tracker names.
fn check_links(key: &str, raw: &TrackerTable, source: &mut Source, file: &DeploymentTable) -> Checked<()> {
    let is_finder = |other: &SourceTable| other.locator.is_some() || other.simulated_direction_finder.is_some();
    let finders = (0..).zip(&file.sources).filter(|(_, other)| is_finder(other));
    let finders: Vec<(&str, u16)> = finders.map(|(number, other)| (other.name.as_str(), number)).collect();
    let sensors = (0..).zip(&file.wide_area_sensors);
    let sensors: Vec<(&str, u16)> = sensors.map(|(number, sensor)| (sensor.name.as_str(), number)).collect();
    let part = |part: &str| format!("{key}.{part}");
    let named = &raw.wide_area_sensors;
    source.links.wide_area_sensors = numbers_of(&part("wide_area_sensors"), named, "[[wide_area_sensor]]", &sensors)?;
    let kind = "direction finder among the sources";
    source.links.emissions = numbers_of(&part("emissions"), &raw.emissions, kind, &finders)?;
    if source.input.is_recorded() && !source.links.emissions.is_empty() {
        let what = "direction finders are live, but the sensors are recordings: leave it out";
        return Err(SettingsError::new(part("emissions"), what));
    }
    Ok(())
}

#[cfg(test)]
#[path = "tracker_process_tests.rs"]
mod tests;

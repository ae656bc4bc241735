//! Wide-area sensors: who knows how many targets there are (WA), and which trackers listen to them.
//!
//! A wide-area sensor is no source: it has no tracks that fusion could weigh, and no number among the sources. Its
//! reports are counts, and go to the trackers of sources that name it. What it delivers is one of three: rows of counts
//! (FM-6) as datagrams or as a recording, the tracks of another system (ASTERIX CAT062), which are counted by place, or
//! what a process of the integrator's own publishes. A simulated one sends rows of counts as datagrams.
//!
//! ```toml
//! [[wide_area_sensor]]
//! name = "remote"                  # its reports are at wide-area/remote/reports
//! [wide_area_sensor.live]          # rows of counts in datagrams
//! receiver = "link"
//!
//! [[wide_area_sensor]]
//! name = "centre"
//! [wide_area_sensor.tracks]        # another system's tracks, counted
//! receiver = "lan"                 # or file = "centre.ast"
//! period_s = 4.0                   # how often it says where each of its tracks is
//! group_m = 500.0                  # tracks no farther from each other are counted together
//!
//! [[wide_area_sensor]]
//! name = "simulated"
//! [wide_area_sensor.simulated]     # observes the [scenario]
//! position_sigma_m = 1000.0
//!
//! [[source]]
//! name = "radar"
//! [source.tracker]
//! wide_area_sensors = ["remote", "centre"]
//! ```

use std::collections::BTreeSet;
use std::path::PathBuf;

use frames::{SensorFrame, SystemFrame};
use reception::{ConversionModel, CovarianceModel};
use settings::SettingsError;

use super::check_network::{Network, asterix};
use super::checked::{Checked, CheckedSource, place};
use super::tables::{CountedTracksTable, DeploymentTable, PlaceTable, WideAreaSensorTable};
use deployment::{CountedTracks, TrackFeed, WideAreaInput, WideAreaSensor, check_name};

/// Most wide-area sensors of a deployment.
const SENSORS_MAX: usize = 16;

/// The wide-area sensors of a file, with the models of the tracks that they count.
pub(super) fn check_wide_area_sensors(
    raw: &DeploymentTable,
    system: &SystemFrame,
    network: &mut Network,
) -> Checked<Vec<(WideAreaSensor, Option<ConversionModel>)>> {
    if raw.wide_area_sensors.len() > SENSORS_MAX {
        let what = format!(
            "there are {}; at most {SENSORS_MAX} can be",
            raw.wide_area_sensors.len()
        );
        return Err(SettingsError::new("wide_area_sensor", what));
    }
    let mut names = BTreeSet::new();
    let mut sensors = Vec::new();
    for (index, each) in raw.wide_area_sensors.iter().enumerate() {
        let key = format!("wide_area_sensor[{index}].name");
        check_name(&key, &each.name)?;
        if !names.insert(&each.name) {
            let what = format!(
                "\"{}\" is the name of an earlier wide-area sensor; give each its own",
                each.name
            );
            return Err(SettingsError::new(key, what));
        }
        let sensor = check_sensor(index, each, (system, &raw.frame), network)?;
        check_process_name(&sensor.0, raw)?;
        sensors.push(sensor);
    }
    Ok(sensors)
}

fn check_sensor(
    index: usize,
    raw: &WideAreaSensorTable,
    frame: (&SystemFrame, &PlaceTable),
    network: &mut Network,
) -> Checked<(WideAreaSensor, Option<ConversionModel>)> {
    let key = |part: &str| format!("wide_area_sensor[{index}].{part}");
    let mut model = None;
    let input = match (&raw.live, &raw.recorded, &raw.tracks, &raw.simulated) {
        (Some(live), ..) => {
            network.datagrams(&key("live.receiver"), &live.receiver)?;
            WideAreaInput::Live(live.receiver.clone())
        }
        (_, Some(recorded), ..) => WideAreaInput::Recorded(PathBuf::from(&recorded.file)),
        (_, _, Some(tracks), _) => {
            let (counted, of_tracks) = check_tracks(&key("tracks"), tracks, frame, network)?;
            model = Some(of_tracks);
            WideAreaInput::Tracks(Box::new(counted))
        }
        (_, _, _, Some(_)) => {
            network.simulated_wide_area_sensor(index, &raw.name);
            WideAreaInput::Live(raw.name.clone())
        }
        _ => WideAreaInput::External,
    };
    let mut sensor = WideAreaSensor {
        number: index as u16,
        name: raw.name.clone(),
        input,
        adapter: raw.name.clone(),
        is_simulated: raw.simulated.is_some(),
    };
    if let Some(receiver) = sensor.receiver() {
        sensor.adapter = receiver.to_owned();
    }
    Ok((sensor, model))
}

fn check_tracks(
    key: &str,
    raw: &CountedTracksTable,
    (system, origin): (&SystemFrame, &PlaceTable),
    network: &Network,
) -> Checked<(CountedTracks, ConversionModel)> {
    let part = |part: &str| format!("{key}.{part}");
    let feed = match &raw.receiver {
        Some(receiver) => {
            network.datagrams(&part("receiver"), receiver)?;
            TrackFeed::Receiver(receiver.clone())
        }
        None => TrackFeed::File(PathBuf::from(raw.file.as_deref().unwrap_or_default())),
    };
    let place_table = raw.place.as_ref().unwrap_or(origin);
    let stands = place(&part("place"), place_table)?;
    let model = ConversionModel {
        number: 0,
        sac_sic: raw.identity.sac_sic(),
        method: Default::default(),
        positions: Default::default(),
        frame: SensorFrame::new(system, stands, place_table.north_offset_deg.rad()),
        system: *system,
        height_m: stands.height_m(),
        // Tracks have places; nothing is assumed of their heights.
        assumed_height_m: 0.0,
        qnh_hpa: messages::STANDARD_PRESSURE_HPA,
        limits: raw.limits,
        covariance: CovarianceModel::default(),
        is_on_board: false,
    };
    let counted = CountedTracks {
        feed,
        asterix: asterix(&part("editions"), &raw.reading)?,
        period_ns: raw.period_s.ns(),
        group_m: raw.group_m,
    };
    Ok((counted, model))
}

/// Recordings go with recordings: their times are of another day than those of what comes live.
pub(super) fn check_company(sources: &[CheckedSource], sensors: &[WideAreaSensor]) -> Checked<()> {
    let is_recorded = |source: &CheckedSource| source.input.is_recorded();
    let differ = |recorded: bool, source: &CheckedSource| -> Option<SettingsError> {
        let of_other_kind = |number: &&u16| sensors[usize::from(**number)].recording().is_some() != recorded;
        let sensor = &sensors[usize::from(*source.links.wide_area_sensors.iter().find(of_other_kind)?)];
        let [own, other] = if recorded {
            ["a recording", "none"]
        } else {
            ["none", "a recording"]
        };
        let what = format!(
            "\"{}\" is {other}, but the source is {own}: their times are of different days",
            sensor.name
        );
        let key = format!("source[{}].tracker.wide_area_sensors", source.number);
        Some(SettingsError::new(key, what))
    };
    if let Some(problem) = sources.iter().find_map(|source| differ(is_recorded(source), source)) {
        return Err(problem);
    }
    let live = sensors.iter().find(|sensor| sensor.recording().is_none());
    if let Some(sensor) = live.filter(|_| sources.iter().all(is_recorded)) {
        let what = format!(
            "\"{}\" is live, but all sources are recordings: give it one, too ([wide_area_sensor.recorded])",
            sensor.name
        );
        return Err(SettingsError::new(
            format!("wide_area_sensor[{}].name", sensor.number),
            what,
        ));
    }
    let recording = sensors.iter().find(|sensor| sensor.recording().is_some());
    if let Some(sensor) = recording.filter(|_| !sources.iter().any(is_recorded)) {
        let what = format!(
            "\"{}\" is a recording, but no source is a recording: its times are of another day",
            sensor.name
        );
        return Err(SettingsError::new(
            format!("wide_area_sensor[{}].name", sensor.number),
            what,
        ));
    }
    Ok(())
}

/// No two adapter processes have one name; those behind receivers have the receivers'.
fn check_process_name(sensor: &WideAreaSensor, raw: &DeploymentTable) -> Checked<()> {
    let of_sources = raw.sources.iter().map(|source| &source.name);
    let of_receivers = raw.receivers.iter().map(|receiver| &receiver.name);
    let mut names = of_sources
        .chain(of_receivers)
        .chain(raw.trackers.iter().map(|tracker| &tracker.name));
    let is_named_so = sensor.receiver().is_none() || sensor.is_simulated;
    if is_named_so && names.any(|name| *name == sensor.name) {
        let what = format!(
            "\"{}\" is also the name of an adapter process, that of a source, tracker or receiver; give the sensor another",
            sensor.name
        );
        return Err(SettingsError::new(
            format!("wide_area_sensor[{}].name", sensor.number),
            what,
        ));
    }
    Ok(())
}

#[cfg(test)]
#[path = "wide_area_sensor_tests.rs"]
mod tests;

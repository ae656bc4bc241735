//! Sources whose detections a separate process publishes (`[source.external] input = "detections"`).
//!
//! Such a source is a tracker process with a single external sensor, written in a short form: the source keeps its name
//! and number, and the sensor is called [`SENSOR`]. The rest is the code of tracker processes.

use tracking::cutting::Boundaries;

use super::tables::{ExternalTable, SourceExternalTable, SourceTable, TrackerSensorTable, TrackerTable};
use super::words::ExternalInput;

/// Name of the sensor: its detections are at `sensor/<source>.input/detections`.
const SENSOR: &str = "input";

/// Whether a separate process publishes the source's detections.
pub(super) fn takes_detections(raw: &SourceTable) -> bool {
    let input = raw.external.as_ref().map(|external| external.input);
    input == Some(ExternalInput::Detections)
}

/// The tracker process that the source is; `None` for other sources.
pub(super) fn tracker_of(raw: &SourceTable) -> Option<TrackerTable> {
    let SourceExternalTable {
        sigmas,
        range_rate_sigma_mps,
        ..
    } = raw.external.as_ref().filter(|_| takes_detections(raw))?;
    let tracker = raw.tracker.clone().unwrap_or_default();
    let sensor = TrackerSensorTable {
        name: SENSOR.to_owned(),
        external: Some(ExternalTable {}),
        // Without statements of its turns, a program can only number its scans.
        scans: match tracker.scans {
            Boundaries::Period => Some(Boundaries::Period),
            Boundaries::Turn | Boundaries::Stated => Some(Boundaries::Stated),
        },
        period_s: raw.weighing.period_s,
        wait_s: tracker.wait_s,
        sigmas: sigmas.clone(),
        range_rate_sigma_mps: *range_rate_sigma_mps,
        place: raw.place.clone(),
        limits: raw.limits,
        model: tracker.model,
        ..TrackerSensorTable::default()
    };
    Some(TrackerTable {
        name: raw.name.clone(),
        uid: raw.uid,
        required: raw.required,
        sensors: vec![sensor],
        settings: tracker.tracker,
        wide_area_sensors: tracker.wide_area_sensors,
        emissions: tracker.emissions,
        cues: tracker.cues,
        output_period_s: tracker.output_period_s,
        silent_periods: raw.silent_periods,
        weighing: raw.weighing.clone(),
        ..TrackerTable::default()
    })
}

#[cfg(test)]
#[path = "external_detections_tests.rs"]
mod tests;

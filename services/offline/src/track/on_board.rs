//! Detections of sensors on a moving platform (`--platform`), carried into the system's terms before they are tracked.
//!
//! The steps are those of live trackers: history, mounting, waiting room (crate `platform`). All states are known
//! before the first detection, so no detection waits.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use observations::Detection;
use platform::{History, WaitingCounts, WaitingRoom};
use serde_json::{Value, json};

use crate::files::InputError;
use crate::host::Host;
use crate::reading::{SkippedRows, platform_states};

use super::TrackConfiguration;
use super::input::DetectionInput;

/// Outcome of the platform's states and of the detections that need them.
#[derive(Debug, Default)]
pub(super) struct OnBoard {
    states: u64,
    refusals: SkippedRows,
    counts: WaitingCounts,
}

impl OnBoard {
    /// Reads the platform's states, and carries the detections of the sensors on board; refused detections are counted.
    ///
    /// # Errors
    /// If the file cannot be read, has no usable state, or no detection can be used.
    pub(super) fn carry(
        host: &dyn Host,
        path: &Path,
        config: &TrackConfiguration,
        input: &mut DetectionInput,
    ) -> Result<Self, InputError> {
        let mut on_board = Self::default();
        let settings = config.platform();
        let states = platform_states(host, path, &mut on_board.refusals)?;
        on_board.states = states.len() as u64;
        let mut history = History::new(settings.assumed, states.len());
        for state in &states {
            history.add(state);
        }
        let mut rooms = BTreeMap::new();
        let mut all = WaitingCounts::default();
        let mut carried = |detection: &Detection| -> Option<Detection> {
            let sensor_id = detection.sensor_id;
            let Some(mount) = settings.mount(sensor_id) else {
                return Some(*detection);
            };
            let room = rooms
                .entry(sensor_id)
                .or_insert_with(|| WaitingRoom::new(mount, config.sigmas(sensor_id), settings.wait_s.ns(), 1));
            room.take(*detection, ());
            // No further state will come.
            room.end();
            Some(room.next(&history, None)?.outcome.ok()?.detection)
        };
        let detections = input.detections.iter().filter_map(&mut carried).collect();
        input.detections = detections;
        for room in rooms.values() {
            all += room.counts();
        }
        on_board.counts = all;
        if input.detections.is_empty() {
            let what = format!(
                "no detection can be used: {}; check that the times of both files count from the same midnight",
                on_board.reasons()
            );
            return Err(InputError::new(path, what));
        }
        Ok(on_board)
    }

    /// Carries the detections that state the attitude of their platform themselves, of sensors that
    /// `[[platform.sensor]]` names; `None` if there are none.
    ///
    /// # Errors
    /// If no detection can be used.
    pub(super) fn carry_own(
        path: &Path,
        config: &TrackConfiguration,
        input: &mut DetectionInput,
    ) -> Result<Option<Self>, InputError> {
        let settings = config.platform();
        let mut own = Self::default();
        let counts = &mut own.counts;
        let carried = |detection: &Detection| {
            let named = settings.sensors.iter().find(|sensor| sensor.id == detection.sensor_id);
            let (Some(sensor), Some(_)) = (named.filter(|sensor| sensor.on_board), detection.platform.attitude_rad)
            else {
                return Some(*detection);
            };
            let sigmas = config.sigmas(detection.sensor_id);
            match sensor.mount.carry_own(detection, &settings.assumed, sigmas, None) {
                Ok(carried) => {
                    counts.carried += 1;
                    Some(carried.detection)
                }
                Err(refusal) => {
                    counts.count(refusal);
                    None
                }
            }
        };
        let detections = input.detections.iter().filter_map(carried).collect();
        input.detections = detections;
        if input.detections.is_empty() {
            return Err(InputError::new(
                path,
                format!("no detection can be used: {}", own.reasons()),
            ));
        }
        Ok((own.counts != WaitingCounts::default()).then_some(own))
    }

    pub(super) fn as_json(&self) -> Value {
        json!({
            "states": self.states,
            "rows_refused": self.refusals.rows(),
            "carried": self.counts.carried,
            "refused": {
                "no_state": self.counts.no_state,
                "gap": self.counts.gap,
                "too_old": self.counts.too_old,
                "unusable": self.counts.unusable,
            },
        })
    }

    pub(super) fn write_text(&self, text: &mut String) -> std::fmt::Result {
        text.push_str(&self.refusals.as_text());
        writeln!(
            text,
            "platform: {} states; {} detections carried{}",
            self.states,
            self.counts.carried,
            match self.counts.refused() {
                0 => String::new(),
                _ => format!("; {}", self.reasons()),
            }
        )
    }

    /// Refused detections by reason.
    fn reasons(&self) -> String {
        let reasons = [
            (self.counts.too_old, "before the first state"),
            (self.counts.gap, "in a gap of the states longer than platform.max_gap_s"),
            (self.counts.no_state, "after the last state, or of a heading"),
            (self.counts.unusable, "without standard deviations or direction"),
        ];
        let refused = reasons.iter().filter(|(count, _)| *count > 0);
        let words: Vec<_> = refused.map(|(count, reason)| format!("{count} {reason}")).collect();
        format!("refused: {}", words.join(", "))
    }
}

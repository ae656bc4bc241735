//! Detections of sensors on a moving platform (`--platform`), carried into the system's terms before tracking.
//!
//! The code is that of tracker processes ([`sources::carrying`]). All states are known before the first detection, so
//! no detection waits.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use observations::SensorEvent;
use platform::WaitingCounts;
use serde_json::{Value, json};
use sources::carrying::{CarriedSensor, Carrier, Carrying};

use crate::files::InputError;
use crate::host::Host;
use crate::reading::{SkippedRows, platform_states};

use super::TrackConfiguration;
use super::input::DetectionInput;

/// Outcome of the platform's states and of the detections that need the states.
#[derive(Debug, Default)]
pub(super) struct OnBoard {
    states: u64,
    refusals: SkippedRows,
    counts: WaitingCounts,
}

/// The way of a file's detections through [`Carrying`].
struct Passage {
    places: BTreeMap<u32, usize>,
    carrying: Carrying<()>,
}

impl Passage {
    fn new(
        config: &TrackConfiguration,
        carrier: Option<Carrier>,
        input: &DetectionInput,
        sensor: impl Fn(u32) -> Option<CarriedSensor>,
    ) -> Self {
        let ids: BTreeSet<u32> = input.detections.iter().map(|detection| detection.sensor_id).collect();
        let sensors: Vec<Option<CarriedSensor>> = ids.iter().map(|id| sensor(*id)).collect();
        Self {
            places: ids.into_iter().zip(0..).collect(),
            carrying: Carrying::new(carrier.as_slice(), &sensors, config.carrier().assumed, config.frame()),
        }
    }

    /// Replaces the detections by detections in the system frame, without the refused detections.
    fn pass(mut self, input: &mut DetectionInput) -> WaitingCounts {
        let measured = std::mem::take(&mut input.detections);
        let passed = &mut input.detections;
        for detection in measured {
            let place = self.places[&detection.sensor_id];
            let mut out = |_, event, ()| {
                if let SensorEvent::Detection(detection) = event {
                    passed.push(detection);
                }
            };
            self.carrying
                .take(place, SensorEvent::Detection(detection), (), &mut out);
        }
        self.carrying.counts()
    }
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
        if let Some(deployment) = config.of_several_platforms() {
            let what = "several platforms carry its sensors, and --platform has the states of one: track the recording";
            return Err(InputError::new(deployment, what));
        }
        let mut on_board = Self::default();
        let states = platform_states(host, path, (&mut on_board.refusals, &mut input.bases))?;
        on_board.states = states.len() as u64;
        let carrier = Carrier {
            states_max: states.len(),
            ..config.carrier()
        };
        let sensor = |sensor_id: u32| {
            Some(CarriedSensor {
                carrier: Some(0),
                mount: config.mount(sensor_id)?,
                default_sigmas: config.sigmas(sensor_id),
                looks_ns: None,
            })
        };
        let mut carrying = Passage::new(config, Some(carrier), input, sensor);
        for state in &states {
            carrying.carrying.state(0, state);
        }
        carrying.carrying.states_end();
        on_board.counts = carrying.pass(input);
        if input.detections.is_empty() {
            let what = format!(
                "no detection can be used: {}; check that the times of both files count from the same midnight",
                on_board.reasons()
            );
            return Err(InputError::new(path, what));
        }
        Ok(on_board)
    }

    /// Carries the detections that state the attitude of the platform themselves, of sensors named in
    /// `[[platform.sensor]]`; `None` if there are none.
    ///
    /// # Errors
    /// If no detection can be used.
    pub(super) fn carry_own(
        path: &Path,
        config: &TrackConfiguration,
        input: &mut DetectionInput,
    ) -> Result<Option<Self>, InputError> {
        let mut own = Self::default();
        let sensor = |sensor_id: u32| {
            Some(CarriedSensor {
                carrier: None,
                mount: config.own_mount(sensor_id)?,
                default_sigmas: config.sigmas(sensor_id),
                looks_ns: None,
            })
        };
        own.counts = Passage::new(config, None, input, sensor).pass(input);
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

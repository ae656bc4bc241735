//! Smoothed trajectories: the states of recorded system tracks from all measurements, later ones included.
//!
//! The engine fuses a recording once more and passes on the inputs of each filter ([`FilterInput`]). [`Trajectories`]
//! collects the inputs, and the times of the published states. After the end of the recording, [`Trajectories::smooth`]
//! gives the state of each track at each of these times:
//!
//! 1. The errors of the sources are removed as shown by the reports around each time (module `errors_over_time`), not
//!    as known at the time. The sizes of covariances and the manoeuvres of targets are the final estimates.
//! 2. The measurements are sorted by time. Late measurements thus count like measurements in time. If a late report
//!    changes the measurement of the next report, that measurement is replaced.
//! 3. The noise and the mean duration of straight flight are set to the values with the likeliest measurements (module
//!    `likeliest`).
//! 4. A smoother per mode of motion ([`estimation::Smoother`]) runs over the plane, another over the vertical, with the
//!    models of the filters. There are two runs: speed and course, as parameters of the models, come from the first
//!    run.
//!
//! Measurements behind the reports of sources' own trackers are recovered as for the filter, so the errors are
//! independent. A report without recoverable measurement repeats earlier information; as in the filter, the report
//! counts as a measurement of three times its covariance.
//!
//! [`LagSmoother`] does the same while fusion runs, some seconds behind it.
//!
//! Limits: the association of the engine is kept, not repeated. A restart of a track by the engine begins a new
//! trajectory. States of other centres have no measurements and stay unchanged.

mod errors_over_time;
mod knowledge;
mod lag;
mod likeliest;
mod plane;
mod stretch;
mod trajectory;
mod vertical;

use std::collections::BTreeMap;

use messages::{
    AXES, Covariance, HorizontalMovement, LongitudinalMovement, Movement, SystemTrack, TrackState, movement_bits,
};

pub use lag::LagSmoother;

use crate::Engine;
use crate::update::filter::vertical_movement;
use crate::update::filter_input::{FilterInput, UnseenErrors};
use errors_over_time::ErrorsOverTime;
use knowledge::Afterwards;
use likeliest::likeliest;
use trajectory::{SmoothedState, Trajectory};

/// Probabilities for sure straight flight, and for a turn.
const SURE: f32 = 0.9;
const PROBABLE: f32 = 0.5;

/// Inputs of the filters of all system tracks, and the times of their states.
#[derive(Debug, Default)]
pub struct Trajectories {
    tracks: BTreeMap<u32, Trajectory>,
    inputs: u64,
    errors: ErrorsOverTime,
}

/// Smoothed states of all system tracks.
#[derive(Debug, Default)]
pub struct SmoothedTracks {
    /// By the track's number, in the order of time.
    tracks: BTreeMap<u32, Vec<SmoothedState>>,
    /// Errors without evidence in measurements.
    unseen: UnseenErrors,
}

impl Trajectories {
    /// Takes the next input of a filter.
    pub fn input(&mut self, input: &FilterInput) {
        self.inputs += 1;
        self.tracks.entry(input.system_track).or_default().take(input);
    }

    /// Takes the next state of a system track: a smoothed state shall have the same time.
    pub fn state(&mut self, state: &SystemTrack) {
        let times = &mut self.tracks.entry(state.track_number).or_default().times_ns;
        if times.last() != Some(&state.reference_time_ns) {
            times.push(state.reference_time_ns);
        }
    }

    /// Reads the engine's estimates of the sources' errors; to be called after each report.
    pub fn look(&mut self, engine: &Engine) {
        self.errors.look(engine);
    }

    /// Number of inputs taken.
    pub fn inputs(&self) -> u64 {
        self.inputs
    }

    /// Smooths all trajectories with the knowledge of `engine` at the end of the recording. `progress` receives the
    /// number of inputs done, and ends the work by an error.
    ///
    /// # Errors
    /// The error of `progress`.
    pub fn smooth<E>(
        mut self,
        engine: &Engine,
        mut progress: impl FnMut(u64) -> Result<(), E>,
    ) -> Result<SmoothedTracks, E> {
        let mut smoothed = SmoothedTracks {
            tracks: BTreeMap::new(),
            unseen: engine.publisher.unseen(),
        };
        let mut done = 0;
        self.errors.settle(engine.settings.registration.memory_s);
        let errors = &self.errors;
        let with = |factors| Afterwards {
            engine,
            errors,
            factors,
        };
        let known = with(likeliest(self.tracks.values(), with));
        while let Some((number, track)) = self.tracks.pop_first() {
            done += track.inputs.len() as u64;
            smoothed.tracks.insert(number, track.smooth(&known));
            progress(done)?;
        }
        Ok(smoothed)
    }
}

impl SmoothedTracks {
    /// The state of the same track and time with the smoothed kinematics; `None` where there is no measurement.
    pub fn of(&self, state: &SystemTrack) -> Option<SystemTrack> {
        let states = self.tracks.get(&state.track_number)?;
        let place = states
            .binary_search_by_key(&state.reference_time_ns, |smoothed| smoothed.time_ns)
            .ok()?;
        Some(with_kinematics(state, &states[place], self.unseen))
    }
}

/// A state with smoothed kinematics and these errors without evidence in measurements.
fn with_kinematics(state: &SystemTrack, smoothed: &SmoothedState, unseen: UnseenErrors) -> SystemTrack {
    let mut message = *state;
    let [x, y, vx, vy] = smoothed.plane.mean;
    for (axis, (position, velocity)) in [(x, vx), (y, vy)].into_iter().enumerate() {
        message.position_m[axis] = position;
        message.velocity_mps[axis] = velocity;
    }
    message.covariance = Covariance::default();
    const PLANE: [usize; 4] = [0, 1, AXES, AXES + 1];
    let mut elements = smoothed.plane.covariance.into_iter();
    for (place, row) in PLANE.into_iter().enumerate() {
        for (column, value) in PLANE[place..].iter().zip(&mut elements) {
            message.covariance.set(row, *column, value);
        }
    }
    for axis in 0..2 {
        let variance = &mut message.covariance.upper[Covariance::index(axis, axis)];
        *variance += unseen.per_axis_m2;
    }
    message.covariance.upper[Covariance::index(2, 2)] += unseen.height_m2;
    message.velocity_valid = u8::from(message.covariance.knows_velocity());
    [message.turn_rate_radps, message.turn_rate_sigma_radps] = smoothed.turn_rate.map(|value| value as f32);
    message.mode_probabilities[..5].copy_from_slice(&smoothed.plane_modes);
    // The live values belong to the live velocity.
    (message.steady_velocity_covariance, message.steady_climb_variance) = ([0.0; 3], 0.0);
    set_vertical(&mut message, state, smoothed);
    if unseen.course_s2 != 0.0 {
        message
            .covariance
            .widen_along_course(message.velocity_mps, unseen.course_s2);
    }
    let is_followed = [TrackState::Tentative as u8, TrackState::Confirmed as u8].contains(&state.state);
    message.movement = if is_followed {
        movement(&message)
    } else {
        Movement::default()
    };
    message
}

fn set_vertical(message: &mut SystemTrack, live: &SystemTrack, smoothed: &SmoothedState) {
    let (z, vz) = (AXES - 1, 2 * AXES - 1);
    let Some((vertical, modes)) = smoothed.vertical.filter(|_| live.height_valid != 0) else {
        for (row, column) in [(z, z), (z, vz), (vz, vz)] {
            message.covariance.set(row, column, live.covariance.get(row, column));
        }
        return;
    };
    let [height, rate] = vertical.mean;
    message.position_m[z] = height;
    message.velocity_mps[z] = rate;
    let [zz, cross, rr] = vertical.covariance;
    for (row, column, value) in [(z, z, zz), (z, vz, cross), (vz, vz, rr)] {
        message.covariance.set(row, column, value);
    }
    let climb = message.covariance.knows_climb().then_some([rate, rr]);
    [message.climb_rate_mps, message.climb_rate_variance] =
        climb.map_or([0.0; 2], |rate| rate.map(|value| value as f32));
    message.mode_probabilities[5..].copy_from_slice(&modes);
}

/// Sure modes of movement.
fn movement(message: &SystemTrack) -> Movement {
    let [steady, _, left, right, ..] = message.mode_probabilities;
    let [vx, vy, climb_mps] = message.velocity_mps;
    let mut movement = Movement::default();
    if steady > SURE {
        movement.horizontal = HorizontalMovement::Straight as u8;
        movement.longitudinal = LongitudinalMovement::Constant as u8;
        movement.valid = movement_bits::ACCELERATION;
    } else if left.max(right) > PROBABLE {
        let turns = [HorizontalMovement::TurnRight, HorizontalMovement::TurnLeft];
        movement.horizontal = turns[usize::from(left > right)] as u8;
        // The rate is clockwise: (vy, −vx) points to the right.
        let rate = f64::from(message.turn_rate_radps);
        movement.acceleration_mps2 = [(rate * vy) as f32, (-rate * vx) as f32, 0.0];
        movement.valid = movement_bits::ACCELERATION;
    }
    if message.height_valid != 0 {
        let variance_m2ps2 = f64::from(message.climb_rate_variance);
        movement.vertical = vertical_movement(climb_mps, variance_m2ps2) as u8;
    }
    movement
}

#[cfg(test)]
mod errors_tests;
#[cfg(test)]
mod lag_tests;
#[cfg(test)]
mod tests;

//! Trajectories of an instrument or a smoother as the reference of a comparison.
//!
//! A truth has a row at each whole second. Reports of an instrument and smoothed tracks have times of their own, so
//! their states are interpolated at the whole seconds between. The position follows the cubic polynomial through both
//! positions with both velocities (Hermite), the velocity is the linear mean: the derivative of the polynomial would
//! turn errors of the positions into errors of the velocity. A reference does not reach into gaps, and rows without a
//! velocity (`velocity_valid` is 0) are left out.

use std::collections::BTreeMap;
use std::io::Read;

use csv_table::CsvError;

use crate::basis::FileBasis;
use crate::picture::Timeline;
use crate::states::KinematicState;

/// Longest time between two rows with interpolated states, seconds.
const GAP_MAX_S: f64 = 5.0;

impl Timeline {
    /// Reads trajectories: columns as in a truth file, or as those of tracks, at any times.
    ///
    /// # Errors
    /// As [`Timeline::truth`].
    pub fn reference(input: impl Read) -> Result<Self, CsvError> {
        Self::reference_on(FileBasis::default(), input)
    }

    /// Reads trajectories on the basis of other tracks ([`Timeline::basis`]).
    ///
    /// # Errors
    /// As [`Timeline::truth_on`].
    pub fn reference_on(basis: FileBasis, input: impl Read) -> Result<Self, CsvError> {
        let mut by_target: BTreeMap<i64, Vec<KinematicState<3>>> = BTreeMap::new();
        let basis = Self::each_state(basis, input, |state| {
            if state.has_velocity {
                by_target.entry(state.id).or_default().push(state);
            }
        })?;
        let mut timeline = Self::of_truth().with_basis(basis);
        for states in by_target.values_mut() {
            states.sort_by(|one, other| one.time_s.total_cmp(&other.time_s));
            for state in at_whole_seconds(states) {
                timeline.keep(state);
            }
        }
        Ok(timeline)
    }
}

/// Returns the states of one target at whole seconds.
fn at_whole_seconds(states: &[KinematicState<3>]) -> impl Iterator<Item = KinematicState<3>> {
    let between = states.windows(2).flat_map(|pair| {
        let (before, behind) = (pair[0], pair[1]);
        let is_near = behind.time_s - before.time_s <= GAP_MAX_S;
        let seconds = before.time_s.ceil() as i64..behind.time_s.ceil() as i64;
        seconds
            .map(|second| second as f64)
            .filter(move |second| is_near || *second == before.time_s)
            .map(move |second| interpolated(&before, &behind, second))
    });
    let last = states.last().copied();
    between.chain(last.filter(|last| last.time_s.fract() == 0.0))
}

fn interpolated(before: &KinematicState<3>, behind: &KinematicState<3>, time_s: f64) -> KinematicState<3> {
    let span_s = behind.time_s - before.time_s;
    let share = (time_s - before.time_s) / span_s;
    let (square, cube) = (share * share, share * share * share);
    let position = |axis: usize| {
        (2.0 * cube - 3.0 * square + 1.0) * before.position_m[axis]
            + (cube - 2.0 * square + share) * span_s * before.velocity_mps[axis]
            + (3.0 * square - 2.0 * cube) * behind.position_m[axis]
            + (cube - square) * span_s * behind.velocity_mps[axis]
    };
    let velocity = |axis: usize| (1.0 - share) * before.velocity_mps[axis] + share * behind.velocity_mps[axis];
    KinematicState {
        time_s,
        position_m: std::array::from_fn(position),
        velocity_mps: std::array::from_fn(velocity),
        covariance: None,
        address: before.address.or(behind.address),
        has_height: before.has_height && behind.has_height,
        ..*before
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::TimelinePass;

    fn read(rows: &str) -> Vec<(i64, i64, [f64; 3], [f64; 3])> {
        let header = "time_s,system_track_id,x,y,z,vx,vy,vz,state,address\n";
        let timeline = Timeline::reference(format!("{header}{rows}").as_bytes()).unwrap();
        let (Some(first), Some(last)) = (timeline.first_second(), timeline.last_second()) else {
            return Vec::new();
        };
        let mut pass = TimelinePass::new(&timeline);
        let states = (first..=last).flat_map(|second| {
            pass.at(second)
                .into_iter()
                .map(move |state| (second, state.id, state.position_m, state.velocity_mps))
        });
        states.collect()
    }

    #[test]
    fn a_constant_acceleration_is_met_exactly() {
        // x = t², vx = 2 t.
        let row = |time_s: f64| {
            format!(
                "{time_s},7,{},5,0,{},0,0,confirmed,3444CF\n",
                time_s * time_s,
                2.0 * time_s
            )
        };
        let found = read(&[row(4.5), row(0.5), row(2.25)].concat());
        let expected = [1.0, 2.0, 3.0, 4.0].map(|time_s| (time_s * time_s, 2.0 * time_s));
        assert_eq!(found.len(), 4);
        for ((_, _, position_m, velocity_mps), (x, vx)) in found.iter().zip(expected) {
            assert!(
                (position_m[0] - x).abs() < 1e-12 && (velocity_mps[0] - vx).abs() < 1e-12,
                "{found:?}"
            );
            assert_eq!(position_m[1], 5.0);
        }
    }

    #[test]
    fn gaps_stay_empty_and_rows_at_whole_seconds_stay_as_they_are() {
        let row = |time_s: &str, x: f64| format!("{time_s},7,{x},0,0,0,0,0,confirmed,\n");
        let found = read(&[row("3", 30.0), row("4", 41.0), row("9.5", 90.0), row("10", 100.0)].concat());
        let places: Vec<(i64, f64)> = found
            .iter()
            .map(|(second, _, position_m, _)| (*second, position_m[0]))
            .collect();
        assert_eq!(places, [(3, 30.0), (4, 41.0), (10, 100.0)]);
        assert_eq!(
            read("3,7,0,0,0,0,0,0,tentative,\n3,7,0,0,0,0,0,0,suspended,\n4,7,0,0,0,0,0,0,terminated,\n"),
            []
        );
        assert_eq!(read("3.5,7,0,0,0,0,0,0,confirmed,\n"), []);
    }
}

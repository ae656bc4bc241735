//! Sources whose systematic errors change, and measurements of reports that others have overtaken.

use estimation::Gaussian;
use messages::AXES;

use crate::measurement::{Measurement, as_stated, recovered_measurement};
use crate::sources::Sources;
use crate::tracker_gain::{Change, GainEvidence};

impl Sources {
    /// Starts the estimates of the sources anew that the others contradict since the last call: their errors have
    /// changed by more than the filters accept.
    pub(super) fn begin_anew_where_set_aside(&mut self, restarted: &mut impl FnMut(u16)) {
        let set_aside = self.credibility.all_set_aside();
        let changed = set_aside & !std::mem::replace(&mut self.was_set_aside, set_aside);
        for source in 0..self.models.len() as u16 {
            if changed & (1 << source) != 0 && self.registration.begin_anew_if_settled(source) {
                restarted(source);
            }
        }
    }

    /// Ends the contradictions of the sources whose changed errors have been found: they were due to those errors.
    /// `before` are the sources of which an error was removed before, as bits.
    pub(super) fn trust_found(&mut self, before: u64) {
        let found = self.registration.removing() & !before;
        for source in 0..self.models.len() as u16 {
            let is_found = found & (1 << source) != 0 && self.registration.is_young(source);
            if is_found || self.registration.is_first_solution(source) {
                self.credibility.reset(source);
            }
        }
    }

    /// The measurement that led from a state of a sensor track of `source`, so many seconds before, to another one;
    /// `None` if none can have. `evidence` is what the track has shown of its tracker. Learns nothing.
    pub(crate) fn measurement_between(
        &self,
        (source, evidence): (u16, &GainEvidence),
        (before, seconds): (&Gaussian, f64),
        (after, has_height): (&Gaussian, bool),
    ) -> Option<Measurement> {
        match self.models[usize::from(source)].process_noise() {
            Some(noise) => recovered_measurement(&noise.predicted(before, seconds), after, has_height),
            None => match self.models[usize::from(source)].undone_between(
                evidence,
                &change_between((before, seconds), (after, has_height)),
                &after.covariance,
            ) {
                Some(undone) => {
                    let (moved_m, covariance_m2) = undone.measurement?;
                    let foretold = foretold_m(before, seconds);
                    Some(Measurement {
                        position_m: std::array::from_fn(|axis| foretold[axis] + moved_m[axis]),
                        covariance_m2,
                        ..as_stated(after.position_m(), &after.covariance, has_height)
                    })
                }
                None => Some(as_stated(after.position_m(), &after.covariance, has_height)),
            },
        }
    }
}

/// Returns the change between a state, so many seconds before, and a later one.
fn change_between((before, seconds): (&Gaussian, f64), (after, has_height): (&Gaussian, bool)) -> Change {
    let (foretold, place) = (foretold_m(before, seconds), after.position_m());
    let (former, velocity) = (before.velocity_mps(), after.velocity_mps());
    Change {
        position_m: std::array::from_fn(|axis| place[axis] - foretold[axis]),
        velocity_mps: std::array::from_fn(|axis| velocity[axis] - former[axis]),
        seconds,
        has_height,
    }
}

/// Returns the position that a state foretells for `seconds` later, metres.
fn foretold_m(state: &Gaussian, seconds: f64) -> [f64; AXES] {
    let (place, velocity) = (state.position_m(), state.velocity_mps());
    std::array::from_fn(|axis| place[axis] + velocity[axis] * seconds)
}

#[cfg(test)]
mod tests {
    use messages::Covariance;

    use super::*;

    #[test]
    fn a_change_is_what_a_state_did_not_foretell() {
        let state = |mean: [f64; 6]| Gaussian {
            mean,
            covariance: Covariance::diagonal([40.0; AXES], [15.0; AXES]),
        };
        let before = state([100.0, 200.0, 300.0, 10.0, -20.0, 1.0]);
        let after = state([125.0, 155.0, 305.0, 11.0, -21.0, 1.5]);
        let change = change_between((&before, 2.0), (&after, true));
        assert_eq!(change.position_m, [5.0, -5.0, 3.0]);
        assert_eq!(change.velocity_mps, [1.0, -1.0, 0.5]);
        assert!(change.has_height && change.seconds == 2.0);
    }
}

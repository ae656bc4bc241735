//! Directions without ranges, from cameras and passive receivers: improvement of tracks that positions have begun.
//!
//! A bearing is a ray, and a ray crosses the gates of many tracks. If bearings were treated like positions, each camera
//! frame would join half of all clusters and give every hypothesis a dozen children. Ten frames a second would push the
//! radar detections of a second ago out of the memory of eight scans: a choice between two such detections would be
//! forced before the next turn. Besides, the rule of at most one target per detection does not hold: a boat behind
//! another boat has no bearing of its own.
//!
//! Directions therefore do not branch. Each track uses all directions in its gate, each by the probability of belonging
//! to the track: the result is the mean of the updates with each direction and with none (probabilistic data
//! association). The evidence of a scan of directions for the track's presence,
//!
//! ```text
//! evidence = 1 − P + Σ p·N(ν)/λ        (P: detected and in the gate, p: detected, λ: density of false ones)
//! ```
//!
//! compensates misses, or adds to the misses, by the weight of the scan ([`crate::sensor`]). The evidence does not
//! weigh hypotheses: of two explanations on the same ray, every frame would make both certain. Directions therefore
//! show the position and presence of a target, not the existence: no track begins or becomes likelier, and clusters,
//! histories and numbers of detections stay unchanged.
//!
//! Two tracks with a single direction between both share the direction. A direction that may belong to a confirmed
//! track counts as false for any other track: the likelihood adds to λ, over the probability that the confirmed track
//! was not seen (exact joint probabilities for two tracks and one direction). Of several competing tracks the likeliest
//! counts.
//!
//! Limits: the tangent of a direction is good where the direction is known; a track that is not known better than
//! [`KNOWN_RAD`] takes none.
//!
//! Source: Y. Bar-Shalom, F. Daum, J. Huang, *The probabilistic data association filter*, IEEE Control Systems Magazine
//! 29 (2009).

use association::distance;
use messages::NS_PER_S;

use crate::existence::{self, Survival};
use crate::limits::COMPARISONS_MAX;
use crate::motion::TargetMotion;
use crate::plot::Plot;
use crate::scan_context::ScanContext;
use crate::sensor::Sensor;
use crate::track::{TENTATIVE, Track};

/// Largest standard deviation of a track's direction, seen from the sensor, radians.
const KNOWN_RAD: f64 = 0.2;
/// Least probability of an own direction for a track to count as seen.
const SEEN_MIN: f64 = 0.5;

/// A scan of directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Directions<'a> {
    pub(crate) time_ns: i64,
    pub(crate) plots: &'a [Plot],
    /// By direction: logarithm of the density of false directions.
    pub(crate) log_clutter: &'a [f64],
    pub(crate) sensor: &'a Sensor,
}

/// The two confirmed tracks of which a direction is likeliest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Claims {
    /// Number of the track and likelihood, relative to false, of the likeliest and of the next likeliest track.
    two: [(u32, f64); 2],
}

impl Claims {
    pub(crate) const NONE: Self = Self {
        two: [(TENTATIVE, 0.0); 2],
    };

    /// Whether the direction lies in a confirmed track's gate.
    pub(crate) fn are_made(&self) -> bool {
        self.two[0].0 != TENTATIVE
    }

    fn add(&mut self, number: u32, likelihood: f64) {
        let [first, second] = self.two;
        self.two = if number == first.0 {
            [(number, first.1.max(likelihood)), second]
        } else if likelihood > first.1 {
            [(number, likelihood), first]
        } else if likelihood > second.1 {
            [first, (number, likelihood)]
        } else {
            return;
        };
    }

    /// The largest likelihood of other tracks.
    pub(crate) fn of_others(&self, number: u32) -> f64 {
        let [first, second] = self.two;
        if first.0 == number { second.1 } else { first.1 }
    }
}

/// A direction in a track's gate.
struct DirectionCandidate {
    place: usize,
    at_its_time: TargetMotion,
    /// Relative to a false direction.
    likelihood: f64,
}

impl<'a> Directions<'a> {
    pub(crate) fn of(scan: &ScanContext<'a>) -> Self {
        Self {
            time_ns: scan.time_ns,
            plots: scan.plots,
            log_clutter: scan.log_clutter,
            sensor: scan.sensor,
        }
    }

    /// Adds the claims of a confirmed track.
    pub(crate) fn claim(&self, track: &Track, claims: &mut [Claims]) {
        let Some((_, seen)) = self.predicted(track) else { return };
        let miss = self.sensor.miss(seen);
        for candidate in self.candidates(track, seen) {
            claims[candidate.place].add(track.number, candidate.likelihood / miss);
        }
    }

    /// Updates a track by the directions in the gate. A track seen only once is left out: the velocity is not known
    /// yet.
    pub(crate) fn take_in(&self, track: &mut Track, claims: &[Claims], survival: &Survival<'_>) {
        track.absence = survival.absence(track.absence, track.motion.widest());
        let Some((predicted, seen)) = self.predicted(track) else {
            return;
        };
        let sensor = self.sensor;
        let mut sum = sensor.miss(seen);
        let of_none = sum;
        let mut mean = predicted;
        for candidate in self.candidates(track, seen) {
            let plot = &self.plots[candidate.place];
            let mut updated = candidate.at_its_time;
            if updated.update(&plot.measurement.weighted(sensor.scan_weight)).is_none() {
                continue;
            }
            if plot.time_ns != self.time_ns {
                let later_s = self.time_ns.saturating_sub(plot.time_ns) as f64 / NS_PER_S;
                updated = updated.moved(later_s, &sensor.motion);
            }
            let likelihood = candidate.likelihood / (1.0 + claims[candidate.place].of_others(track.number));
            sum += likelihood;
            mean = TargetMotion::mixture(&mean, &updated, likelihood / sum);
        }
        let evidence = sensor.scan_weight * sum.ln();
        if !evidence.is_finite() {
            return;
        }
        track.motion = mean;
        track.time_ns = self.time_ns;
        track.absence = existence::weighed(track.absence, evidence.exp());
        if sum - of_none > SEEN_MIN * sum {
            track.missed = 0;
            track.seen_ns = self.time_ns;
        } else if seen > SEEN_MIN {
            track.missed += 1;
        }
    }

    /// Returns a track at the time of the scan, and the probability that the track is in the field of view; `None`
    /// if directions cannot improve the track.
    fn predicted(&self, track: &Track) -> Option<(TargetMotion, f64)> {
        if track.detections < 2 {
            return None;
        }
        let predicted = track.motion_at(self.time_ns, &self.sensor.motion);
        let seen = self.sensor.probability_in_view(predicted.widest());
        self.are_good_for(&predicted).then_some((predicted, seen))
    }

    fn candidates(&self, track: &Track, seen: f64) -> impl Iterator<Item = DirectionCandidate> {
        let sensor = self.sensor;
        let compared = self.plots.iter().zip(self.log_clutter).take(COMPARISONS_MAX);
        compared.enumerate().filter_map(move |(place, (plot, log_clutter))| {
            let at_its_time = track.motion_at(plot.time_ns, &sensor.motion);
            let innovation = at_its_time.innovation(&plot.measurement)?;
            let inside = innovation.squared_distance <= sensor.gates[innovation.dimension - 1];
            let gain = sensor.log_detection + innovation.log_likelihood - log_clutter;
            inside.then(|| DirectionCandidate {
                place,
                at_its_time,
                likelihood: seen * gain.exp(),
            })
        })
    }

    fn are_good_for(&self, predicted: &TargetMotion) -> bool {
        let Some(first) = self.plots.first() else { return true };
        let state = predicted.widest();
        let [xx, xy, _, yy, ..] = state.position_covariance();
        let line = [0, 1].map(|axis| state.mean[axis] - first.measurement.platform_m[axis]);
        // Written so that NaN yields false.
        distance::largest_sigma2([xx, xy, yy]) <= KNOWN_RAD * line[0].hypot(line[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_several_claims_the_likeliest_of_another_track_counts() {
        let mut claims = Claims::NONE;
        assert!(!claims.are_made());
        assert_eq!(claims.of_others(1), 0.0);
        for (number, likelihood) in [(1, 3.0), (2, 8.0), (1, 5.0), (3, 0.5), (2, 7.0)] {
            claims.add(number, likelihood);
        }
        assert!(claims.are_made());
        assert_eq!([1, 2, 3].map(|number| claims.of_others(number)), [8.0, 5.0, 8.0]);
        // A track's branches do not stand in each other's way.
        let mut alone = Claims::NONE;
        for likelihood in [2.0, 9.0, 4.0] {
            alone.add(7, likelihood);
        }
        assert_eq!((alone.of_others(7), alone.of_others(8)), (0.0, 9.0));
    }
}

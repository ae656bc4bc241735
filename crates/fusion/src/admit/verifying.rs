//! Comparison of self-reported positions with reports of measuring sensors (module `verification`).

use association::distance::largest_sigma2;
use messages::{Counter, DecisionKind, NS_PER_S};
use source_models::{Fact, PairFact};

use crate::admit::verification::Verification;
use crate::engine::Engine;
use crate::explanation::Sink;
use crate::judge::life;
use crate::tables::sensor_tracks::{NO_SYSTEM, SensorSlot};

/// Number of reports of an unsuspected address per comparison.
const EVERY: u32 = 2;
/// Standard deviations beyond which a position is contradicted.
const SIGMAS: f64 = 4.0;
/// Unpredictable acceleration between two reports, metres per second squared.
const ACCELERATION_MPS2: f64 = 10.0;
/// Result of one comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Comparison {
    /// No measuring sensor has the address.
    Unchecked,
    Agrees,
    /// Distance and greatest possible distance, metres.
    Contradicted(f64, f64),
}

impl Engine {
    /// Compares the stored report of a sensor track with reports of measuring sensors; true for a rejection, with the
    /// address isolated.
    fn is_false(&mut self, sensor: SensorSlot, sink: &mut impl Sink) -> bool {
        let entry = self.tracks.sensors.get(sensor);
        if entry.verification == Verification::default() && !entry.reports.is_multiple_of(EVERY) {
            return false;
        }
        let comparison = self.comparison(sensor);
        let entry = self.tracks.sensors.get_mut(sensor);
        let (source, before) = (entry.source, entry.verification.is_isolated);
        if comparison == Comparison::Unchecked {
            return before;
        }
        let is_contradicted = comparison != Comparison::Agrees;
        self.tracks.sources.learn(
            &self.settings,
            Fact::Pair(PairFact::Verified {
                source,
                is_contradicted,
            }),
        );
        let may_isolate = !self.tracks.sources.is_biased(source);
        let verification = &mut self.tracks.sensors.get_mut(sensor).verification;
        verification.learn(is_contradicted, may_isolate);
        let is_isolated = verification.is_isolated;
        if is_isolated && !before {
            self.isolate(sensor, comparison, sink);
        }
        is_isolated
    }

    fn comparison(&self, sensor: SensorSlot) -> Comparison {
        let entry = self.tracks.sensors.get(sensor);
        let Some(address) = entry.names.address() else {
            return Comparison::Unchecked;
        };
        let mut contradicted = None;
        let carriers = self.tracks.sensors.names.carriers(address).unwrap_or_default();
        for other in carriers {
            let theirs = self.tracks.sensors.get(*other);
            let settings = &self.settings.sources[usize::from(theirs.source)];
            let is_fresh = self.tracks.is_fresh(theirs, entry.time_ns);
            if settings.is_self_reported || settings.is_centre || !is_fresh {
                continue;
            }
            let (metres, most_m) = self.distance_of(sensor, *other);
            if metres <= most_m {
                return Comparison::Agrees;
            }
            contradicted = Some(Comparison::Contradicted(metres, most_m));
        }
        contradicted.unwrap_or(Comparison::Unchecked)
    }

    /// Distance of a sensor track from another track of the same address, and the greatest possible distance, metres.
    fn distance_of(&self, sensor: SensorSlot, other: SensorSlot) -> (f64, f64) {
        let [own, other] = [sensor, other].map(|slot| &self.tracks.sensors.get(slot).latest);
        let seconds = (own.time_of_measurement_ns - other.time_of_measurement_ns) as f64 / NS_PER_S;
        let apart = |axis: usize| own.position_m[axis] - other.position_m[axis] - other.velocity_mps[axis] * seconds;
        let variance_m2 = |report: &messages::SensorTrack, seconds: f64| {
            let of = |row, column| report.covariance.get(row, column);
            let carried = seconds * seconds * (of(3, 3) + of(4, 4));
            largest_sigma2([of(0, 0), of(0, 1), of(1, 1)]).powi(2) + carried
        };
        let sigma_m = (variance_m2(own, 0.0) + variance_m2(other, seconds)).sqrt();
        let identity = &self.settings.identity;
        let bias_m = self.tracks.sources.bias_reach_m(&self.settings, own, other);
        let unforeseen_m = 0.5 * ACCELERATION_MPS2 * seconds * seconds;
        let most_m = (bias_m + unforeseen_m + SIGMAS * sigma_m).max(identity.false_m);
        (apart(0).hypot(apart(1)), most_m)
    }

    /// Removes a sensor track with a false position from its system track.
    #[cold]
    fn isolate(&mut self, sensor: SensorSlot, comparison: Comparison, sink: &mut impl Sink) {
        let entry = self.tracks.sensors.get(sensor);
        let (system, now_ns) = (entry.system, entry.time_ns);
        let (metres, most_m) = match comparison {
            Comparison::Contradicted(metres, most_m) => (metres, most_m),
            _ => (f64::NAN, f64::NAN),
        };
        let kind = DecisionKind::IdentityConflict;
        sink.decision(&self.tracks.decision(sensor, kind, metres, most_m));
        if system == NO_SYSTEM {
            return;
        }
        self.tracks.unlink(sensor);
        let rest = self.tracks.contributing_here(system, now_ns).next();
        if let Some(member) = rest {
            self.restart(member, sink);
        } else {
            let out = &mut self.outbox.to(sink);
            life::end(&self.settings, &mut self.tracks, system, now_ns, 0, out);
        }
    }

    /// Whether to reject the latest report of a sensor track: a self-reported position contradicted by measuring
    /// sensors. Counts the rejection.
    #[inline]
    pub(crate) fn rejects_position(&mut self, sensor: SensorSlot, source: u16, sink: &mut impl Sink) -> bool {
        let is_checked =
            self.settings.sources[usize::from(source)].is_self_reported && self.settings.association.use_identity;
        let is_rejected = is_checked && self.is_false(sensor, sink);
        if is_rejected {
            self.outbox.counts.add(source, Counter::RejectedFalsePosition);
        }
        is_rejected
    }
}

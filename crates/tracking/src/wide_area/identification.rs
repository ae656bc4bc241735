//! Identification of a target (WA-9) by emissions and origin.
//!
//! Neither is sufficient alone. An on-board receiver measures frequency, pulse interval and bearing of an emission;
//! several types have similar emissions, and a bearing has no range. The wide-area sensor observed the origin of the
//! targets; several types start there. Bayes' rule combines both: the prior knowledge of the origin gives each type a
//! probability, and each emission multiplies the probabilities of the matching types.
//!
//! An emission belongs to the track in that direction; with two tracks in that direction, to none, since both would be
//! identified. The origin is taken from the route that the wide-area sensor reports; without a route, the origin is the
//! first position of the track's targets at that sensor. The result is the likeliest type with the probability, or none
//! while the alternative is likelier.
//!
//! Identifications are part of the population after a scan, like the tracks: after a late scan, report or emission all
//! are derived again.
//!
//! Limits: emissions of one target are assumed independent, which is not exact; so at most [`EMISSIONS_MAX`] count
//! per track.

use std::f64::consts::{PI, TAU};

use messages::{NS_PER_S, TargetType};
use observations::WideAreaReport;

use super::emission::Emission;
use super::prior::{EmissionBand, Knowledge};
use crate::track::Track;

/// Most emissions of a track that count.
const EMISSIONS_MAX: u32 = 3;
/// Probability that an emission of a type lies in a band of that type: receivers err, and lists are incomplete.
const MATCH: f64 = 0.9;
/// The same for a type without known emissions.
const UNKNOWN: f64 = 0.5;
/// Statistical distance within which an emission comes from a track's direction.
const GATE: f64 = 3.0;

/// Knowledge of the confirmed tracks of a population, by number.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Identities {
    tracks: Vec<TrackIdentification>,
    /// By track, then by type, then of any other type: logarithm of the product of the emissions' likelihoods.
    log_likelihoods: Vec<f64>,
    /// Number of likelihoods per track.
    width: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct TrackIdentification {
    number: u32,
    origin: Option<Origin>,
    emissions: u32,
}

/// Origin of targets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Origin {
    /// East and north, metres.
    pub(crate) place_m: [f64; 2],
    /// Set if a route reports the origin; otherwise the origin is the first observed position.
    pub(crate) is_reported: bool,
}

impl Origin {
    pub(crate) fn of(report: &WideAreaReport) -> Self {
        let [east, north, _] = report.position_m;
        Self {
            place_m: report.origin_m.unwrap_or([east, north]),
            is_reported: report.origin_m.is_some(),
        }
    }

    /// Origin from a route, east and north, metres; `None` without a route.
    pub(crate) fn reported_m(&self) -> Option<[f64; 2]> {
        self.is_reported.then_some(self.place_m)
    }
}

/// Position of a track at the time of an emission.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Whereabouts {
    /// East and north, metres.
    pub(crate) place_m: [f64; 2],
    /// Variances of both, and the covariance, m².
    pub(crate) variances_m2: [f64; 3],
}

impl EmissionBand {
    /// Whether an emission is of this kind.
    pub fn contains(&self, emission: &Emission) -> bool {
        let within = |value: f64, [low, high]: [f64; 2]| (low..=high).contains(&value);
        let interval = self.pulse_interval_s.zip(emission.pulse_interval_s);
        within(emission.frequency_hz, self.frequency_hz)
            && interval.is_none_or(|(band, interval_s)| within(interval_s, band))
    }

    /// Probability of an emission by a type with these bands.
    fn likelihood(bands: &[Self], emission: &Emission) -> f64 {
        match bands {
            [] => UNKNOWN,
            bands if bands.iter().any(|band| band.contains(emission)) => MATCH,
            _ => 1.0 - MATCH,
        }
    }
}

impl Identities {
    /// With room for `tracks_max` tracks, or for none where there are no types.
    pub(crate) fn new(tracks_max: usize, types: usize) -> Self {
        let (tracks_max, width) = if types == 0 { (0, 0) } else { (tracks_max, types + 1) };
        Self {
            tracks: Vec::with_capacity(tracks_max),
            log_likelihoods: Vec::with_capacity(tracks_max * width),
            width,
        }
    }

    /// Takes over the identifications of the tracks with these numbers, in rising order; all others are removed.
    pub(crate) fn follow(&mut self, before: &Self, numbers: impl Iterator<Item = u32>) {
        self.tracks.clear();
        self.log_likelihoods.clear();
        let mut place = 0;
        for number in numbers {
            let earlier = before.tracks[place..].iter();
            place += earlier.take_while(|known| known.number < number).count();
            let known = before.tracks.get(place).filter(|known| known.number == number);
            self.tracks.push(known.copied().unwrap_or(TrackIdentification {
                number,
                origin: None,
                emissions: 0,
            }));
            match known {
                Some(_) => self.log_likelihoods.extend_from_slice(before.likelihoods(place)),
                None => self.log_likelihoods.resize(self.tracks.len() * self.width, 0.0),
            }
        }
    }

    #[cfg(test)]
    pub(crate) fn len(&self) -> usize {
        self.tracks.len()
    }

    /// Learns where the targets of the track at `place` came from.
    pub(crate) fn came_from(&mut self, place: usize, origin: Origin) {
        let known = &mut self.tracks[place].origin;
        if known.is_none() || origin.is_reported {
            *known = Some(origin);
        }
    }

    /// Applies an emission. `tracks` are in the order of numbers. Returns the index of the emitting track, if
    /// unambiguous.
    pub(crate) fn emitted(
        &mut self,
        emission: &Emission,
        tracks: impl Iterator<Item = Whereabouts>,
        knowledge: &Knowledge,
    ) -> Option<usize> {
        let distances = tracks.map(|track| track.distance(emission)).enumerate();
        let mut near = distances.filter(|(_, distance)| *distance < GATE);
        let place = near.next().filter(|_| near.next().is_none())?.0;
        let known = &mut self.tracks[place];
        if known.emissions < EMISSIONS_MAX {
            known.emissions += 1;
            let types = knowledge.types.iter().map(|target| &target.emissions[..]);
            // Any other type has no known bands.
            let bands = types.chain(std::iter::once(&[][..]));
            let sums = &mut self.log_likelihoods[place * self.width..][..self.width];
            for (sum, bands) in sums.iter_mut().zip(bands) {
                *sum += EmissionBand::likelihood(bands, emission).ln();
            }
        }
        Some(place)
    }

    /// Type of the track at `place`, if likelier than all other types together, including undescribed types.
    pub(crate) fn target_type(&self, place: usize, knowledge: &Knowledge) -> TargetType {
        let best = self.best(place, knowledge);
        let named = best.and_then(|(target, confidence)| TargetType::new(&knowledge.types[target].name, confidence));
        named.unwrap_or_default()
    }

    /// The likeliest type, with the probability.
    fn best(&self, place: usize, knowledge: &Knowledge) -> Option<(usize, f64)> {
        let known = self.tracks.get(place)?;
        let prior = known.origin.and_then(|origin| knowledge.at(origin.place_m));
        let (types, log_likelihoods) = (knowledge.types.len(), self.likelihoods(place));
        let stated = |target: usize| {
            let name = &knowledge.types.get(target)?.name;
            prior?.types.get(name).copied()
        };
        let sum: f64 = (0..types).filter_map(stated).sum();
        let unstated = (0..types).filter(|target| stated(*target).is_none()).count() + 1;
        let rest = (1.0 - sum).max(0.0) / unstated as f64;
        let likelihood = |target: usize| stated(target).unwrap_or(rest) * log_likelihoods[target].exp();
        let all: f64 = (0..=types).map(likelihood).sum();
        let best =
            (0..=types).max_by(|one, other| likelihood(*one).total_cmp(&likelihood(*other)).then(other.cmp(one)))?;
        let confidence = likelihood(best) / all;
        (best < types && confidence > 0.5).then_some((best, confidence))
    }

    fn likelihoods(&self, place: usize) -> &[f64] {
        &self.log_likelihoods[place * self.width..][..self.width]
    }
}

impl Whereabouts {
    /// Position of a track at `time_ns`, along the velocity; with the covariance of the last observation.
    pub(crate) fn of(track: &Track, time_ns: i64) -> Self {
        let estimate = track.motion.estimate();
        let (position_m, velocity_mps) = (estimate.position_m(), estimate.velocity_mps());
        let seconds = time_ns.saturating_sub(track.time_ns) as f64 / NS_PER_S;
        let [xx, xy, _, yy, ..] = estimate.position_covariance();
        Self {
            place_m: [0, 1].map(|axis| position_m[axis] + velocity_mps[axis] * seconds),
            variances_m2: [xx, yy, xy],
        }
    }

    /// Angle between an emission and the direction to here, in standard deviations.
    fn distance(&self, emission: &Emission) -> f64 {
        let line = [0, 1].map(|axis| self.place_m[axis] - emission.platform_m[axis]);
        let range_m = line[0].hypot(line[1]).max(1.0);
        let [east, north] = line.map(|part| part / range_m);
        let [east_m2, north_m2, both_m2] = self.variances_m2;
        let across_m2 = north * north * east_m2 + east * east * north_m2 - 2.0 * east * north * both_m2;
        let turn_rad = (emission.bearing_rad - line[0].atan2(line[1]) + PI).rem_euclid(TAU) - PI;
        let sigma_rad = emission.sigma_rad.hypot(across_m2.max(0.0).sqrt() / range_m);
        turn_rad.abs() / sigma_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wide_area::prior::{self, Circle, Prior};

    const NINE_GHZ: Emission = Emission {
        time_ns: 0,
        bearing_rad: 0.0,
        sigma_rad: 0.01,
        platform_m: [0.0; 2],
        frequency_hz: 9.4e9,
        pulse_interval_s: Some(1e-3),
    };

    fn knowledge() -> Knowledge {
        let target = |name: &str, ghz: [f64; 2]| prior::TargetType {
            name: name.to_owned(),
            emissions: vec![EmissionBand {
                frequency_hz: ghz.map(|value| value * 1e9),
                pulse_interval_s: Some([5e-4, 2e-3]),
            }],
        };
        let from = |centre_m, types: &[(&str, f64)]| Prior {
            circle: Some(Circle {
                centre_m,
                radius_m: 10e3,
            }),
            types: types.iter().map(|(name, share)| (name.to_string(), *share)).collect(),
            ..Prior::default()
        };
        Knowledge {
            types: vec![
                target("A", [9.0, 10.0]),
                target("B", [9.2, 9.6]),
                target("C", [2.0, 3.0]),
            ],
            priors: vec![
                from([0.0, 90e3], &[("A", 0.8), ("C", 0.1)]),
                from([90e3, 0.0], &[("B", 0.6), ("C", 0.3)]),
            ],
        }
    }

    /// Identities of tracks 7 and 8.
    fn identities() -> (Identities, Knowledge) {
        let mut all = Identities::new(4, 3);
        all.follow(&Identities::new(4, 3), [7, 8].into_iter());
        (all, knowledge())
    }

    fn at(places_m: &[[f64; 2]]) -> impl Iterator<Item = Whereabouts> {
        places_m.iter().map(|place_m| Whereabouts {
            place_m: *place_m,
            variances_m2: [1e4, 1e4, 0.0],
        })
    }

    fn route(place_m: [f64; 2]) -> Origin {
        Origin {
            place_m,
            is_reported: true,
        }
    }

    #[test]
    fn emission_and_origin_decide_together() {
        let (mut all, knowledge) = identities();
        let apart = [[0.0, 40e3], [20e3, 40e3]];
        assert_eq!(all.emitted(&NINE_GHZ, at(&apart), &knowledge), Some(0));
        assert_eq!(all.best(0, &knowledge), None, "A and B emit the like");
        all.came_from(0, route([0.0, 95e3]));
        let (target, confidence) = all.best(0, &knowledge).unwrap();
        assert!(target == 0 && confidence > 0.85, "{confidence}");
        assert_eq!(all.target_type(0, &knowledge).name(), Some("A"));
        all.came_from(0, route([95e3, 0.0]));
        assert_eq!(
            all.target_type(0, &knowledge).name(),
            Some("B"),
            "the same emission from elsewhere"
        );
        assert_eq!(all.target_type(1, &knowledge), TargetType::default());
        // Origin alone.
        all.came_from(1, route([0.0, 90e3]));
        assert!((all.best(1, &knowledge).unwrap().1 - 0.8).abs() < 1e-12);
    }

    #[test]
    fn where_targets_were_seen_first_is_where_they_came_from_until_a_route_says_more() {
        let (mut all, knowledge) = identities();
        let seen = |place_m| Origin {
            place_m,
            is_reported: false,
        };
        all.came_from(0, seen([0.0, 90e3]));
        all.came_from(0, seen([50e3, 50e3]));
        assert_eq!(all.target_type(0, &knowledge).name(), Some("A"));
        all.came_from(0, route([90e3, 0.0]));
        all.came_from(0, seen([0.0, 90e3]));
        assert_eq!(all.target_type(0, &knowledge).name(), Some("B"));
    }

    #[test]
    fn what_is_not_clear_teaches_nobody() {
        let (mut all, knowledge) = identities();
        let before = all.clone();
        for tracks in [[[0.0, 40e3], [100.0, 50e3]], [[0.0, -40e3], [9e3, -40e3]]] {
            assert_eq!(all.emitted(&NINE_GHZ, at(&tracks), &knowledge), None);
        }
        assert_eq!(all, before);
    }

    #[test]
    fn uncertainty_along_the_line_of_sight_does_not_widen_the_direction() {
        let heard = |variances_m2| {
            let place_m = [300.0, 4e3];
            Whereabouts { place_m, variances_m2 }.distance(&NINE_GHZ) < GATE
        };
        assert!(heard([1e4, 1.0, 0.0]) && !heard([1.0, 1e4, 0.0]));
    }

    #[test]
    fn repetition_does_not_make_sure_and_ended_tracks_are_forgotten() {
        let (mut all, knowledge) = identities();
        for _ in 0..1000 {
            assert_eq!(
                all.emitted(&NINE_GHZ, at(&[[0.0, 40e3], [20e3, 4e3]]), &knowledge),
                Some(0)
            );
        }
        all.came_from(0, route([0.0, 90e3]));
        let (_, confidence) = all.best(0, &knowledge).unwrap();
        assert!(confidence < 0.99, "{confidence}");
        let mut later = Identities::new(4, 3);
        later.follow(&all, [3, 7, 9].into_iter());
        assert_eq!(later.best(1, &knowledge), all.best(0, &knowledge));
        assert_eq!((later.best(0, &knowledge), later.best(2, &knowledge)), (None, None));
        let mut without = Identities::new(4, 3);
        without.follow(&later, [3].into_iter());
        later.follow(&without, [3, 7].into_iter());
        assert_eq!(later.best(1, &knowledge), None);
    }
}

//! Who a target is (WA-9): what it emits, and where it came from.
//!
//! Neither tells enough alone. An on-board receiver measures frequency, pulse interval and bearing of an emission; several
//! types emit the like, and a bearing has no range. The wide-area sensor knows where the targets came from; several types
//! start there. Together they decide, by Bayes' rule: the prior knowledge of the origin gives each type its probability, and
//! each emission multiplies that of the types that emit the like.
//!
//! An emission belongs to the track in whose direction it comes from; where two are in that direction, to none: it would
//! teach both. The answer is the likeliest type with its probability, or none while anything else is likelier.
//!
//! Limits: emissions of one target are taken to be independent, which they are not; so each kind (matching or not) counts
//! at most [`EMISSIONS_MAX`] times per track.

use std::f64::consts::{PI, TAU};

use super::prior::{EmissionBand, Knowledge};

/// Most emissions of a track that count.
pub const EMISSIONS_MAX: u32 = 3;
/// Probability that an emission of a type lies in one of its bands: receivers err, and lists are incomplete.
const MATCH: f64 = 0.9;
/// The same for a type whose emissions are not known.
const UNKNOWN: f64 = 0.5;
/// Statistical distance within which an emission comes from a track's direction.
const GATE: f64 = 3.0;

/// One emission, as received.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Bearing clockwise from north, radians.
    pub bearing_rad: f64,
    /// Its standard deviation, radians.
    pub sigma_rad: f64,
    /// Where the receiver was, east and north, metres.
    pub platform_m: [f64; 2],
    /// Hertz.
    pub frequency_hz: f64,
    /// Seconds between pulses, if there are any.
    pub pulse_interval_s: Option<f64>,
}

/// A type with its probability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Identification {
    /// Place in the list of types.
    pub target_type: usize,
    /// In (0, 1].
    pub confidence: f64,
}

/// What is known of each track, by its number.
#[derive(Clone, Debug)]
pub struct Identifier {
    knowledge: Knowledge,
    tracks: Vec<Known>,
}

#[derive(Clone, Debug)]
struct Known {
    number: u32,
    origin_m: Option<[f64; 2]>,
    /// By type, then of any other type: logarithm of the product of the emissions' likelihoods.
    log_likelihoods: Vec<f64>,
    emissions: u32,
}

impl EmissionBand {
    /// Whether an emission is of this kind.
    pub fn contains(&self, emission: &Emission) -> bool {
        let within = |value: f64, [low, high]: [f64; 2]| (low..=high).contains(&value);
        let interval = self.pulse_interval_s.zip(emission.pulse_interval_s);
        within(emission.frequency_hz, self.frequency_hz)
            && interval.is_none_or(|(band, interval_s)| within(interval_s, band))
    }
}

impl Identifier {
    /// With room for `tracks_max` tracks.
    ///
    /// # Errors
    /// What is wrong with the knowledge.
    pub fn new(knowledge: Knowledge, tracks_max: usize) -> Result<Self, String> {
        if let Some(fault) = knowledge.fault() {
            return Err(fault);
        }
        Ok(Self {
            knowledge,
            tracks: Vec::with_capacity(tracks_max),
        })
    }

    /// Learns where a track's targets came from, east and north in metres. `false` if there is no room.
    pub fn came_from(&mut self, number: u32, origin_m: [f64; 2]) -> bool {
        let known = self.known(number);
        known.map(|known| known.origin_m = Some(origin_m)).is_some()
    }

    /// Learns of an emission. `tracks` are (number, east, north in metres, standard deviation across in metres). Returns the
    /// track that it is of, if that is clear.
    pub fn emitted(&mut self, emission: &Emission, tracks: impl Iterator<Item = (u32, [f64; 2], f64)>) -> Option<u32> {
        let away = |(number, place_m, sigma_m): (u32, [f64; 2], f64)| {
            let line = [place_m[0] - emission.platform_m[0], place_m[1] - emission.platform_m[1]];
            let range_m = line[0].hypot(line[1]).max(1.0);
            let turn = (emission.bearing_rad - line[0].atan2(line[1]) + PI).rem_euclid(TAU) - PI;
            let sigma_rad = emission.sigma_rad.hypot(sigma_m / range_m);
            (number, turn.abs() / sigma_rad)
        };
        let mut near = tracks.map(away).filter(|(_, distance)| *distance < GATE);
        let number = near.next().filter(|_| near.next().is_none())?.0;
        let types = &self.knowledge.types;
        let likelihood = |bands: &[EmissionBand]| match bands {
            [] => UNKNOWN,
            bands if bands.iter().any(|band| band.contains(emission)) => MATCH,
            _ => 1.0 - MATCH,
        };
        let logs: Vec<f64> = types.iter().map(|target| likelihood(&target.emissions).ln()).collect();
        let known = self.known(number)?;
        if known.emissions < EMISSIONS_MAX {
            known.emissions += 1;
            let of_others = std::iter::once(UNKNOWN.ln());
            for (sum, log) in known.log_likelihoods.iter_mut().zip(logs.into_iter().chain(of_others)) {
                *sum += log;
            }
        }
        Some(number)
    }

    /// Who a track is, if some type is likelier than all others together with those that nobody described.
    pub fn identification(&self, number: u32) -> Option<Identification> {
        let known = self.tracks.iter().find(|known| known.number == number)?;
        let prior = known.origin_m.and_then(|origin_m| self.knowledge.at(origin_m));
        let types = self.knowledge.types.len();
        let stated = |target: usize| {
            let types = prior.map_or(&[][..], |prior| &prior.types);
            types
                .iter()
                .find(|(number, _)| *number == target)
                .map(|(_, probability)| *probability)
        };
        let sum: f64 = (0..types).filter_map(stated).sum();
        let unstated = (0..types).filter(|target| stated(*target).is_none()).count() + 1;
        let rest = (1.0 - sum).max(0.0) / unstated as f64;
        let likelihood = |target: usize| {
            let probability = if target < types {
                stated(target).unwrap_or(rest)
            } else {
                rest
            };
            probability * known.log_likelihoods[target].exp()
        };
        let all: f64 = (0..=types).map(likelihood).sum();
        let best =
            (0..=types).max_by(|one, other| likelihood(*one).total_cmp(&likelihood(*other)).then(other.cmp(one)))?;
        let confidence = likelihood(best) / all;
        (best < types && confidence > 0.5).then_some(Identification {
            target_type: best,
            confidence,
        })
    }

    /// Forgets tracks that are no more.
    pub fn keep(&mut self, mut is_alive: impl FnMut(u32) -> bool) {
        self.tracks.retain(|known| is_alive(known.number));
    }

    fn known(&mut self, number: u32) -> Option<&mut Known> {
        let place = self.tracks.iter().position(|known| known.number == number);
        if place.is_none() && self.tracks.len() == self.tracks.capacity() {
            return None;
        }
        let place = place.unwrap_or_else(|| {
            self.tracks.push(Known {
                number,
                origin_m: None,
                log_likelihoods: vec![0.0; self.knowledge.types.len() + 1],
                emissions: 0,
            });
            self.tracks.len() - 1
        });
        self.tracks.get_mut(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wide_area::prior::{Place, Prior, TargetType};

    const NINE_GHZ: Emission = Emission {
        bearing_rad: 0.0,
        sigma_rad: 0.01,
        platform_m: [0.0; 2],
        frequency_hz: 9.4e9,
        pulse_interval_s: Some(1e-3),
    };

    fn identifier() -> Identifier {
        let target = |name: &str, ghz: [f64; 2]| TargetType {
            name: name.to_owned(),
            emissions: vec![EmissionBand {
                frequency_hz: ghz.map(|value| value * 1e9),
                pulse_interval_s: Some([5e-4, 2e-3]),
            }],
        };
        let from = |centre_m, types: &[(usize, f64)]| Prior {
            place: Place::Circle {
                centre_m,
                radius_m: 10e3,
            },
            types: types.to_vec(),
            formations: Vec::new(),
            formation_probability_min: 0.5,
        };
        let knowledge = Knowledge {
            types: vec![
                target("A", [9.0, 10.0]),
                target("B", [9.2, 9.6]),
                target("C", [2.0, 3.0]),
            ],
            priors: vec![
                from([0.0, 90e3], &[(0, 0.8), (2, 0.1)]),
                from([90e3, 0.0], &[(1, 0.6), (2, 0.3)]),
            ],
        };
        Identifier::new(knowledge, 2).unwrap()
    }

    #[test]
    fn emission_and_origin_decide_together() {
        let mut all = identifier();
        let tracks = [(7, [0.0, 40e3], 100.0), (8, [20e3, 40e3], 100.0)];
        assert_eq!(all.emitted(&NINE_GHZ, tracks.into_iter()), Some(7));
        assert_eq!(all.identification(7), None, "A and B emit the like");
        assert!(all.came_from(7, [0.0, 95e3]));
        let from_north = all.identification(7).unwrap();
        assert!(
            from_north.target_type == 0 && from_north.confidence > 0.85,
            "{from_north:?}"
        );
        assert!(all.came_from(7, [95e3, 0.0]));
        assert_eq!(
            all.identification(7).unwrap().target_type,
            1,
            "the same emission from elsewhere"
        );
        assert_eq!(all.identification(8), None);
        // Origin alone.
        assert!(all.came_from(8, [0.0, 90e3]));
        assert!((all.identification(8).unwrap().confidence - 0.8).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_clear_teaches_nobody() {
        let mut all = identifier();
        let together = [(7, [0.0, 40e3], 100.0), (8, [100.0, 50e3], 100.0)];
        assert_eq!(all.emitted(&NINE_GHZ, together.into_iter()), None);
        let behind = [(7, [0.0, -40e3], 100.0)];
        assert_eq!(all.emitted(&NINE_GHZ, behind.into_iter()), None);
        assert!(all.identification(7).is_none());
    }

    #[test]
    fn repetition_does_not_make_sure_and_room_is_bounded() {
        let mut all = identifier();
        let alone = [(7, [0.0, 40e3], 100.0)];
        for _ in 0..1000 {
            assert_eq!(all.emitted(&NINE_GHZ, alone.into_iter()), Some(7));
        }
        assert!(all.came_from(7, [0.0, 90e3]));
        let confidence = all.identification(7).unwrap().confidence;
        assert!(confidence < 0.99, "{confidence}");
        assert!(all.came_from(8, [0.0; 2]) && !all.came_from(9, [0.0; 2]));
        all.keep(|number| number == 7);
        assert!(all.came_from(9, [0.0; 2]));
    }
}

//! Pairs of tracks by name.
//!
//! The votes of the search find a bias among all pairs of tracks. Where tracks bear rare names, the pairs are known:
//! the same address, Mode 3/A code or call sign, once in the collection of each source. A known pair shows biases too
//! small to keep tracks apart, as half a degree of azimuth near the sensor. Such biases are reported only from a size
//! that registration should not have to remove.

use estimation::length;
use messages::{BiasKind, Identity, UniqueNumber};
use serde::{Deserialize, Serialize};

use crate::alignment::findings::GATE;
use crate::alignment::findings::bin;
use crate::gross::TrackMotion;
use crate::settings::IdentitySettings;

/// Distance up to which two tracks of the same name are a pair, metres.
const NAMED_REACH_M: f64 = 30e3;
/// Number of pairs for which a single collection suffices.
pub(super) const NAMED_SURE: usize = 8;
/// Least reduction of chi-square by a bias: in total, and per pair.
const GAIN_MIN: f64 = 30.0;
const GAIN_MIN_EACH: f64 = 0.5;
/// Bound of the difference of a pair, and least sum of all differences relative to chance that starts the search, in
/// standard deviations.
const SIGMAS_MAX: f64 = 5.0;
const SUSPICIOUS_SIGMAS: f64 = 3.0;
/// Least size of a bias, in bins.
const SIZE_MIN: f64 = 2.0;

/// Names of a track, 0 if unknown or shared by many.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct TrackNames {
    address: u32,
    code: u16,
    callsign: u64,
}

impl TrackNames {
    pub(super) fn of(identity: &Identity, settings: &IdentitySettings) -> Self {
        let code = identity.mode_3a().filter(|code| !settings.is_shared(*code));
        Self {
            address: identity.unique_number().map_or(0, UniqueNumber::to_bits),
            code: code.unwrap_or_default(),
            callsign: identity.callsign().map_or(0, crate::callsign_key),
        }
    }

    /// Whether both tracks have the same name of some kind.
    pub(super) fn name(&self, other: &Self) -> bool {
        (self.address != 0 && self.address == other.address)
            || (self.code != 0 && self.code == other.code)
            || (self.callsign != 0 && self.callsign == other.callsign)
    }
}

/// Whether two tracks of the same name are near enough to be of the same target.
pub(super) fn are_near(one: &TrackMotion, other: &TrackMotion) -> bool {
    let apart = |axis: usize| one.position_m[axis] - other.position_m[axis];
    length([apart(0), apart(1)]) <= NAMED_REACH_M
}

/// Sums of the differences of named pairs, in standard deviations, along the directions in which biases move targets.
///
/// The difference of a pair without a bias has any direction. The sum of many such differences is small against the sum
/// with a bias, and few sources have a bias: the search is worth the work where a sum is large.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct DirectedSums {
    sums: [f64; 7],
    pairs: f64,
}

impl DirectedSums {
    /// Adds a pair with this standard deviation of the distance per axis.
    pub(super) fn add(&mut self, own: &TrackMotion, other: &TrackMotion, sigma_m: f64) {
        let part = |axis: usize| {
            let apart = (own.position_m[axis] - other.position_m[axis]) / sigma_m;
            apart.clamp(-SIGMAS_MAX, SIGMAS_MAX)
        };
        let (east, north) = (part(0), part(1));
        let along = |[x, y]: [f64; 2]| {
            let way = length([x, y]).max(1.0);
            [(east * x + north * y) / way, (east * y - north * x) / way]
        };
        let seen_from = |place: Option<[f64; 2]>| {
            place.map_or([0.0; 2], |[x, y]| along([own.position_m[0] - x, own.position_m[1] - y]))
        };
        let ([range, azimuth], [other_range, other_azimuth]) = (seen_from(own.place_m), seen_from(other.place_m));
        let [time, _] = along(own.velocity_mps);
        let parts = [east, north, range, azimuth, other_range, other_azimuth, time];
        self.sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
        self.pairs += 1.0;
    }

    /// Whether the sums are hardly possible by chance.
    pub(super) fn are_suspicious(&self) -> bool {
        let limit = SUSPICIOUS_SIGMAS * self.pairs.sqrt();
        self.sums.iter().any(|sum| sum.abs() > limit)
    }
}

/// Least improvement of the score of so many named pairs by a bias.
pub(super) fn least_gain(pairs: f64) -> f64 {
    (GAIN_MIN + GAIN_MIN_EACH * pairs) / GATE
}

/// Whether a bias that improves the score of so many named pairs by `gain` is worth a report.
pub(super) fn is_named_bias(kind: BiasKind, value: [f64; 2], gain: f64, pairs: f64) -> bool {
    length(value) >= SIZE_MIN * bin(kind) && gain >= least_gain(pairs)
}

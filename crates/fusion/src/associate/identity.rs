//! Identity as evidence: the weight of the names of two sensor tracks for a common target (TI-3, QF-2).
//!
//! Problem: two radars with a bias of a kilometre between them agree on no target by place. Both name each target all
//! the same: by Mode 3/A code, call sign or address. An address is nearly unique. A code is not: there are 4096, many
//! aircraft bear the same conspicuity code, and a code can be received wrongly.
//!
//! Method: a name is evidence for a pair by its *rarity*. A name is rare if at most a single fresh track of each
//! source around the place bears it, and no list of shared codes contains it. Two targets that no source ever sees
//! together seldom have the same rare name. The parts of the log-likelihood ratio of "same target" are added, each
//! with its configured exponent (QF-2): rare names for, other names and other classes against. Place, velocity and
//! height then have to fit within the bias that is possible between the two sources (`Search::namesake`):
//! `identity.reach_m` without learned biases, afterwards the rest of the learned biases.
//!
//! A code that differs from the previous codes of its sensor track is believed when the next report repeats it. A
//! garbled code thus names no other target, and a change of code is followed by its track. The same holds for an
//! address, if the report can be of the same target by its place.
//!
//! Limit: two targets with the same code, each seen by a single source, look like a single target until the bias is
//! learned.

use std::collections::HashMap;

use messages::{Identity, TargetType, UniqueNumber, identity_bits};
use serde::{Deserialize, Serialize};
use source_models::callsign_key;

use crate::settings::FactorExponents;
use crate::tables::number_hasher::{NumberHasher, table};

/// Number of reports with a code after which another code is taken for garbled.
const SETTLED: u8 = 2;
/// Log-likelihood ratio of an equal rare name: one chance pair in a thousand.
const RARE: f64 = 7.0;
/// Log-likelihood ratio of different names of a kind: changes reported earlier by a single source, garbled codes.
const OTHER: f64 = -4.0;
/// Log-likelihood ratio from which names decide that two tracks can be of the same target.
pub(crate) const DECIDES: f64 = 5.0;
/// Number of classes among which a class is uncertain.
const CLASSES: f64 = 10.0;
/// Most sensor tracks listed for a name. A name with more is not rare.
const CARRIERS_MAX: usize = 12;
/// Kinds of names: code and call sign.
const KINDS: usize = 2;
/// All names in the index: the above, and the address.
const INDEXED: usize = KINDS + 1;
/// Bit that keeps addresses apart from codes. The first character of a call sign lies above.
const ADDRESS: Name = 1 << 40;

/// A name as a key: a code, or the characters of a call sign. Both never have the same key.
pub(crate) type Name = u64;

/// Names in the reports of a sensor track.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct KnownNames {
    callsign: Name,
    /// Bits of the latest reported [`UniqueNumber`], believed or not; 0 if unknown.
    address: u32,
    /// Bits of the believed number; 0 if unknown.
    believed: u32,
    /// Reports with the believed number, up to [`SETTLED`].
    address_hits: u8,
    code: Option<u16>,
    /// Another code, in the latest report.
    candidate: Option<u16>,
    /// Reports with `code`, up to [`SETTLED`].
    hits: u8,
    /// Content of the latest report: fields, code, characters of the call sign.
    given: (u8, u16, [u8; 8]),
}

impl KnownNames {
    /// Takes the names of the next report; returns its identity, without a code that may be garbled.
    pub(crate) fn believe(&mut self, mut identity: Identity) -> Identity {
        if let Some(callsign) = identity.callsign() {
            self.callsign = callsign_key(callsign);
        }
        let Some(code) = identity.mode_3a() else {
            return identity;
        };
        if self.code == Some(code) {
            self.hits = (self.hits + 1).min(SETTLED);
            self.candidate = None;
        } else if self.hits < SETTLED || self.candidate == Some(code) {
            self.hits = if self.candidate == Some(code) { SETTLED } else { 1 };
            (self.code, self.candidate) = (Some(code), None);
        } else {
            self.candidate = Some(code);
            identity.mode_3a = 0;
            identity.valid &= !identity_bits::MODE_3A;
        }
        identity
    }

    /// Whether a report, as given by its source, adds nothing to the known names. Nearly always true.
    #[inline]
    pub(crate) fn knows(&self, reported: &Identity) -> bool {
        let has_settled = self.hits == SETTLED || reported.valid & identity_bits::MODE_3A == 0;
        let bears = |address: u32| address == self.believed && address == self.address && self.address_hits == SETTLED;
        self.given == (reported.valid, reported.mode_3a, reported.callsign)
            && has_settled
            && self.candidate.is_none()
            && reported.unique_number().is_none_or(|number| bears(number.to_bits()))
    }

    /// Takes the address in the next report, before all other names: whether the address is believed. A report that
    /// may be of the same target does not change a settled address until the next report repeats the change.
    pub(crate) fn believe_address(&mut self, reported: UniqueNumber, may_be_same: bool) -> bool {
        let bits = reported.to_bits();
        if bits == self.believed {
            self.address_hits = (self.address_hits + 1).min(SETTLED);
            return true;
        }
        let is_other = self.believed != 0 && UniqueNumber::from_bits(self.believed).excludes(reported);
        if is_other && may_be_same && self.address_hits == SETTLED && bits != self.address {
            return false;
        }
        (self.believed, self.address_hits) = (bits, 1);
        true
    }

    /// Takes the names in the next report, believed or not.
    pub(crate) fn hear(&mut self, reported: &Identity) {
        self.given = (reported.valid, reported.mode_3a, reported.callsign);
        self.address = reported.unique_number().map_or(self.address, UniqueNumber::to_bits);
    }

    /// Whether both have a code or call sign in common, and no address.
    pub(crate) fn meet(&self, other: &Self) -> bool {
        let has_address = self.address != 0 && self.address == other.address;
        let mut pairs = self.keys().into_iter().zip(other.keys());
        !has_address && pairs.any(|(mine, theirs)| mine != 0 && mine == theirs)
    }

    /// The address as a name.
    pub(crate) fn address(&self) -> Option<Name> {
        (self.address != 0).then_some(ADDRESS | Name::from(self.address))
    }

    /// The names in the index; 0 if unknown.
    pub(crate) fn indexed(&self) -> [Name; INDEXED] {
        let [code, callsign] = self.keys();
        [code, callsign, self.address().unwrap_or_default()]
    }

    /// The names by kind; 0 if unknown.
    pub(crate) fn keys(&self) -> [Name; KINDS] {
        [self.code.map_or(0, Name::from), self.callsign]
    }

    /// Log-likelihood ratio of same target to two targets for two sensor tracks with an equal and rare name of this
    /// `kind`.
    pub(crate) fn log_ratio(&self, other: &Self, kind: usize, exponents: &FactorExponents) -> f64 {
        let exponents = [exponents.code, exponents.callsign];
        let ratios = (0..KINDS).map(|of| match (self.keys()[of], other.keys()[of]) {
            _ if of == kind => RARE,
            (mine, theirs) if mine == 0 || theirs == 0 || mine == theirs => 0.0,
            _ => OTHER,
        });
        ratios.zip(exponents).map(|(ratio, exponent)| exponent * ratio).sum()
    }
}

/// Whether two identities exclude a common target; an exponent of 0 takes away a factor's veto.
pub(crate) fn contradict(one: &Identity, other: &Identity, exponents: &FactorExponents) -> bool {
    let codes = (one.mode_3a(), other.mode_3a());
    (exponents.address > 0.0 && one.has_other_number(other))
        || (exponents.code > 0.0 && matches!(codes, (Some(mine), Some(theirs)) if mine != theirs))
}

/// Log-likelihood ratio of same target to two targets by the stated classes of two reports.
pub(crate) fn class_ratio(one: &TargetType, other: &TargetType) -> f64 {
    if !one.is_known() || !other.is_known() {
        return 0.0;
    }
    let (Some(mine), Some(theirs)) = (one.name(), other.name()) else {
        return 0.0;
    };
    let [p, q] = [one.confidence, other.confidence].map(f64::from);
    // Both name the true class, or both the same wrong one; the other cases are different names.
    let equal = p * q + (1.0 - p) * (1.0 - q) / (CLASSES - 1.0);
    match mine == theirs {
        true => (equal * CLASSES).ln(),
        false => ((1.0 - equal).max(1e-3) * CLASSES / (CLASSES - 1.0)).ln(),
    }
}

/// Sensor tracks that bear a name.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Carriers {
    count: u32,
    /// The listed carriers; the other places are free.
    slots: [u32; CARRIERS_MAX],
}

impl Carriers {
    fn known(&self) -> usize {
        (self.count as usize).min(CARRIERS_MAX)
    }

    fn add(&mut self, sensor: u32) {
        if let Some(free) = self.slots.get_mut(self.count as usize) {
            *free = sensor;
        }
        self.count += 1;
    }

    /// Removes a sensor track. If there are more carriers than places, an unlisted carrier cannot take the free place:
    /// the name counts as common until all carriers are gone.
    fn remove(&mut self, sensor: u32) {
        let known = self.known();
        let place = self.slots[..known].iter().position(|slot| *slot == sensor);
        if let Some(place) = place {
            self.slots.copy_within(place + 1.., place);
            self.slots[CARRIERS_MAX - 1] = u32::MAX;
        }
        self.count = self.count.saturating_sub(1);
    }
}

/// Live sensor tracks by name.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct NameIndex {
    #[serde(with = "table")]
    carriers: HashMap<Name, Carriers, NumberHasher>,
}

impl NameIndex {
    /// Room for `sensor_tracks` sensor tracks. With room for twice the names, the map clears its tombstones in place
    /// and never grows.
    pub(crate) fn new(sensor_tracks: usize) -> Self {
        let capacity = 2 * INDEXED * sensor_tracks;
        Self {
            carriers: HashMap::with_capacity_and_hasher(capacity, NumberHasher::new(capacity)),
        }
    }

    /// Replaces the names of a sensor track.
    pub(crate) fn replace(&mut self, sensor: u32, before: [Name; INDEXED], after: [Name; INDEXED]) {
        for (before, after) in before.into_iter().zip(after) {
            if before == after {
                continue;
            }
            if let Some(carriers) = self.carriers.get_mut(&before) {
                carriers.remove(sensor);
                if carriers.count == 0 {
                    self.carriers.remove(&before);
                }
            }
            if after != 0 {
                self.carriers.entry(after).or_default().add(sensor);
            }
        }
    }

    /// The sensor tracks with a name; `None` if there are more than the list holds.
    pub(crate) fn carriers(&self, name: Name) -> Option<&[u32]> {
        match self.carriers.get(&name) {
            None => Some(&[]),
            Some(carriers) if carriers.count as usize > CARRIERS_MAX => None,
            Some(carriers) => {
                let known = &carriers.slots[..carriers.known()];
                (!known.contains(&u32::MAX)).then_some(known)
            }
        }
    }
}

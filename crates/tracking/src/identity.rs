//! Identity of targets as evidence: a transponder's reply for and against a track (HT-14).
//!
//! Motion alone confuses crossing targets and loses sharply turning targets. Most radars also receive the target's
//! address, Mode 3/A code, callsign or level. The obvious tracker uses the address as a key: one track per address. A
//! single wrong decode then starts a ghost or takes a detection away, two aircraft of the same address become a single
//! track, and a changed code ends a track. This tracker computes a likelihood ratio of the reply for each pair: from
//! the target of the track, against from any other origin (another target, a new target, a false reply). The logarithm
//! of this ratio is added to that of the motion, and the hypotheses decide as usual ([`crate::interpretations`]).
//!
//! # Model
//!
//! A target has a value v of each kind. A look decodes v with the probability 1 − g, else (*garbled*) any value. Codes
//! and callsigns change between two detections with the probability c; addresses do not. With the share f(x) of other
//! targets that show x, and the probability p(x), by the detections of the track, that x is the target's value, the
//! ratio is
//!
//! | kind | ratio of the value x | f(x) |
//! | --- | --- | --- |
//! | address, MMSI | p(x)·(1 − g)/d + g + (1 − p) | d: the probability of a duplicate |
//! | code | p(x)·(1 − g)/f(x) + g/(4096·f(x)) + c + (1 − p) | share of the scan's other codes, at least 1/4096 |
//! | callsign | as an address, + c; only if the address decides nothing | d |
//! | level | (1 − g)·N(Δ)/N(0, σₕ) + g, only of measurements without height | – |
//!
//! where 1 − p is what a single detection leaves open. A code that many targets show (2000, 7000, the code of a
//! formation) is thereby weak evidence without a list of such codes; a list covers the first detections
//! ([`is_common`]). An unexpected value is remembered as a *rival*. A rival repeated by the next detection is the
//! target's new code with the probability c/(c + g), and becomes the value.
//!
//! An address is more: a gate. A detection with another address is not of this target. By likelihood alone, such a
//! detection updates the track in each scan that misses the target, and the track then has the place and the code of a
//! neighbour. A garbled address costs the track one detection, and starts a tentative track without a second detection
//! of the garbled address. A confirmed track that a single detection has named may have a garbled name: there, a
//! detection with another address counts by likelihood, and the track takes nothing else of the reply. Where replies
//! are not used, each contradiction takes a detection off the count of an address.
//!
//! Replies are garbled as a whole, too: interleaved replies of two aircraft exchange all values. With a probability s
//! all values are of another target. So the ratio of a whole reply is (1 − s)·Π + s: contradictions have a price, and
//! the price of a whole reply without an address is limited. A bad decode does not break a track.
//!
//! A detection with the address of a track, in the track's gate, is of this target, or an echo of this target. A new
//! target there, or the target of another track, has this address with the probability d alone.
//!
//! Addresses 000000 and FFFFFF, and the MMSI 0, belong to no transponder and are no evidence. Values that a look does
//! not state are no evidence. The address and the MMSI of a rescue aircraft do not contradict each other: the track
//! keeps the value that came first.
//!
//! Names of ships are no evidence, since an MMSI goes with them. A track passes on the latest name.
//!
//! # Far detections
//!
//! A detection outside the gate may still be of a target that the reply names: the target has turned more sharply than
//! any model. Detections with the track's address, or with the track's code if unique in the scan, are compared within
//! [`FAR`] times the gate's size. The density is that of a target with so much larger deviations, times the probability
//! of a detection outside the gate; the state is widened likewise before the update.
//!
//! Sources: S. S. Blackman, R. Popoli, *Design and Analysis of Modern Tracking Systems* (Artech House, 1999), chapter
//! 9, for attributes in the likelihood of an association; ICAO Annex 10 volume IV (codes, addresses, the steps of
//! levels); EUROCONTROL standard SUR.ET1.ST01.1000-STD-01-01 for the probabilities of false codes that a radar may
//! have.

use messages::{
    CONSPICUITY_CODES, Identity, IdentityAges, LEVEL_STEP_M, NAME_MAX, NS_PER_S, UniqueNumber, identity_bits,
};
use observations::TransponderReply;

/// How much larger a gate is for a detection that names the target.
pub(crate) const FAR: f64 = 5.0;
/// Least logarithm of a ratio that names a target: 10 to 1.
pub(crate) const LOG_NAMED: f64 = std::f64::consts::LN_10;
/// Most agreeing detections that are counted.
const COUNT_MAX: u16 = 5;
/// Number of Mode 3/A codes.
const CODES: usize = 4096;
/// How many codes of other targets the list of common codes is worth.
const PRIOR_CODES: f64 = 10.0;
/// Share of the targets that show a common code, before any are counted.
const COMMON_SHARE: f64 = 0.1;
/// Greatest rate of climb between two levels, metres per second: one standard deviation.
const CLIMB_SIGMA_MPS: f64 = 10.0;
/// Standard deviation of a level: that of the rounding to 100 feet, the coarser of the two steps.
const LEVEL_SIGMA_M: f64 = 4.0 * LEVEL_STEP_M * 0.288_675_134_594_813;
const NS_PER_MS: i64 = 1_000_000;
const NONE: u64 = u64::MAX;
const NO_NAME: NameWords = [0; NAME_MAX.div_ceil(8)];
/// Bits of the numbers of no transponder: two addresses, and the MMSI 0.
const MEANINGLESS: [u32; 3] = [0, 0x00ff_ffff, 1 << 30];

settings::settings! {
    /// What transponders' replies say about the track of a detection (HT-14).
    #[derive(Copy)]
    pub struct IdentitySettings {
        /// Whether tracks use replies. Tracks carry the values either way.
        used: bool = true;
        /// Probability that a value is decoded wrongly.
        garbled_probability: f64 = 0.01, in [1e-6, 0.5];
        /// Probability that all values of a reply are those of another target.
        swapped_probability: f64 = 0.002, in [1e-9, 0.5];
        /// Probability that a code or callsign has changed since the previous detection.
        changed_probability: f64 = 0.001, in [1e-9, 0.5];
        /// Probability that another target has the same address.
        duplicated_probability: f64 = 1e-4, in [1e-9, 0.5];
        /// Threshold of misses for tracks with a known address or uncommon code, if it is below
        /// `deletion.existence_min`: such a target finds its track again.
        existence_min: f64 = 1e-5, in [0, 0.99];
    }
}

/// The values of a reply, as far as used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlotIdentity {
    /// Unique number, code, callsign; [`NONE`] if not stated.
    values: [u64; KINDS],
    /// Times of the statements, nanoseconds.
    stated_ns: [i64; KINDS],
    level: Option<(i16, i64)>,
    /// Name; zeros if not stated.
    name: NameWords,
    /// Whether the measurement has the height already.
    has_height: bool,
}

/// Kinds of values.
const KINDS: usize = 3;
const ADDRESS: usize = 0;
const CODE: usize = 1;
const CALLSIGN: usize = 2;

kept::kept! {
    /// A value of a track.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub(crate) struct Believed {
        value: u64,
        /// The value of the latest detection, if different.
        rival: u64,
        /// When the value was stated last, nanoseconds.
        stated_ns: i64,
        /// Detections that agree, at most [`COUNT_MAX`].
        count: u16,
    }
}

kept::kept! {
    /// Identity of a track's target.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub(crate) struct TrackIdentity {
        believed: [Believed; KINDS],
        level: i32,
        level_ns: i64,
        /// Latest name; zeros if none was stated.
        name: NameWords,
    }
}

/// Identity of a target by the detections of the track, with the times of the statements, nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReportedIdentity {
    /// The values.
    pub identity: Identity,
    /// When address, code and callsign were stated last.
    pub stated_ns: [i64; KINDS],
    /// Level in steps of 25 feet, and the time of the statement.
    pub level: Option<(i16, i64)>,
}

impl PlotIdentity {
    pub(crate) const NONE: Self = Self {
        values: [NONE; KINDS],
        stated_ns: [0; KINDS],
        level: None,
        name: NO_NAME,
        has_height: false,
    };

    /// The reply in a detection at `time_ns`; `has_height` if the detection measures the height.
    pub(crate) fn of(reply: &TransponderReply, time_ns: i64, has_height: bool) -> Self {
        // Most detections of most sensors.
        if reply.identity.kind == 0 && reply.identity.valid == 0 && reply.level.is_none() {
            return Self::NONE;
        }
        let TransponderReply { identity, ages, .. } = reply;
        let number = identity.unique_number().map(UniqueNumber::to_bits);
        let number = number.filter(|number| !MEANINGLESS.contains(number));
        let callsign = identity.callsign().map(|_| u64::from_be_bytes(identity.callsign));
        let stated_ns = |age_ms: u32| time_ns - i64::from(age_ms) * NS_PER_MS;
        Self {
            values: [
                number.map_or(NONE, u64::from),
                identity.mode_3a().map_or(NONE, u64::from),
                callsign.unwrap_or(NONE),
            ],
            stated_ns: [ages.address_ms, ages.mode_3a_ms, ages.callsign_ms].map(stated_ns),
            level: reply.level.map(|level| (level, stated_ns(reply.level_age_ms))),
            name: identity.name().map_or(NO_NAME, |_| words_of(&identity.name)),
            has_height,
        }
    }

    pub(crate) fn is_none(&self) -> bool {
        self.level.is_none() && self.values == [NONE; KINDS] && self.name == NO_NAME
    }

    /// Unites the replies of two detections of the same target; a contradictory value is left out.
    pub(crate) fn unite(&mut self, other: &Self) {
        for kind in 0..KINDS {
            let (one, another) = (self.values[kind], other.values[kind]);
            if one == NONE {
                (self.values[kind], self.stated_ns[kind]) = (another, other.stated_ns[kind]);
            } else if another != NONE && another != one {
                self.values[kind] = NONE;
            }
        }
        if self.name == NO_NAME {
            self.name = other.name;
        }
        self.level = self.level.or(other.level);
    }
}

impl Believed {
    const NONE: Self = Self {
        value: NONE,
        rival: NONE,
        stated_ns: 0,
        count: 0,
    };

    /// Probability that the target's value is `value`, and the open remainder.
    fn probability(&self, value: u64, changed: f64, garbled: f64) -> (f64, f64) {
        let of_rival = match (self.rival, self.count) {
            (NONE, _) => 0.0,
            (_, 1) => 0.5,
            _ => changed / (changed + garbled),
        };
        let open = if self.rival == NONE && self.count == 1 {
            garbled
        } else {
            0.0
        };
        let probability = if value == self.value {
            1.0 - of_rival - open
        } else if value == self.rival {
            of_rival
        } else {
            0.0
        };
        (probability, open)
    }

    /// Takes a value that a detection states at `time_ns`.
    fn take(&mut self, value: u64, time_ns: i64, may_change: bool) {
        if self.value == NONE || value == self.value {
            *self = Self {
                value,
                rival: NONE,
                stated_ns: time_ns,
                count: (self.count + 1).min(COUNT_MAX),
            };
            return;
        }
        if value != self.rival {
            self.rival = value;
            return;
        }
        if !may_change && self.count > 1 {
            self.count -= 1;
            return;
        }
        *self = Self {
            value,
            rival: NONE,
            stated_ns: time_ns,
            count: 2,
        };
    }

    /// The value; `None` if a single detection stated the value and another detection contradicted.
    fn reported(&self) -> Option<u64> {
        (self.value != NONE && (self.count > 1 || self.rival == NONE)).then_some(self.value)
    }
}

impl TrackIdentity {
    pub(crate) const NONE: Self = Self {
        believed: [Believed::NONE; KINDS],
        level: 0,
        level_ns: i64::MIN,
        name: NO_NAME,
    };

    /// Takes the reply of a detection of the track.
    pub(crate) fn take(&mut self, reply: &PlotIdentity) {
        if reply.is_none() {
            return;
        }
        let (address, known) = (reply.values[ADDRESS], self.believed[ADDRESS].value);
        let is_of_another =
            address != NONE && known != NONE && address != known && !are_of_one_aircraft(ADDRESS, address, known);
        for kind in 0..KINDS {
            let (stated, believed) = (reply.values[kind], self.believed[kind].value);
            let is_taken = kind == ADDRESS || !is_of_another;
            if stated != NONE && is_taken && !are_of_one_aircraft(kind, stated, believed) {
                self.believed[kind].take(reply.values[kind], reply.stated_ns[kind], kind != ADDRESS);
            }
        }
        if is_of_another {
            return;
        }
        if let Some((level, stated_ns)) = reply.level {
            (self.level, self.level_ns) = (level.into(), stated_ns);
        }
        if reply.name != NO_NAME {
            self.name = reply.name;
        }
    }

    /// Whether a value of the track distinguishes the target from others.
    pub(crate) fn names(&self) -> bool {
        let known = |kind: usize| {
            let believed = &self.believed[kind];
            believed.value != NONE && believed.count > 1
        };
        known(ADDRESS) || (known(CODE) && !is_common(self.believed[CODE].value))
    }

    /// Whether a reply has the address that several detections of the track stated.
    pub(crate) fn has_address_of(&self, reply: &PlotIdentity) -> bool {
        let address = &self.believed[ADDRESS];
        address.value != NONE && address.count > 1 && reply.values[ADDRESS] == address.value
    }

    /// Whether the track has another address than a reply: by several detections, if the track is confirmed.
    fn has_another_address_than(&self, reply: &PlotIdentity, is_confirmed: bool) -> bool {
        let (address, stated) = (&self.believed[ADDRESS], reply.values[ADDRESS]);
        let is_known = address.value != NONE && (address.count > 1 || !is_confirmed);
        is_known && stated != NONE && stated != address.value && !are_of_one_aircraft(ADDRESS, stated, address.value)
    }

    /// Published identity.
    pub(crate) fn reported(&self) -> ReportedIdentity {
        let has_value = self.believed.iter().any(|believed| believed.value != NONE);
        if self.level_ns == i64::MIN && !has_value && self.name == NO_NAME {
            return ReportedIdentity::default();
        }
        let [address, code, callsign] = self.believed.map(|believed| believed.reported());
        let mut identity = Identity::default();
        if let Some(number) = address {
            identity = identity.with_unique_number(UniqueNumber::from_bits(number as u32));
        }
        if let Some(code) = code {
            identity = identity.with_mode_3a(code as u16);
        }
        if let Some(callsign) = callsign {
            identity = identity.with_callsign(callsign.to_be_bytes());
        }
        if self.name != NO_NAME {
            identity.name = name_of(self.name);
            identity.valid |= identity_bits::NAME;
        }
        ReportedIdentity {
            identity,
            stated_ns: self.believed.map(|believed| believed.stated_ns),
            level: (self.level_ns > i64::MIN).then_some((self.level as i16, self.level_ns)),
        }
    }
}

/// Characters of a name, in the form of a record.
type NameWords = [u64; NAME_MAX.div_ceil(8)];

fn words_of(name: &[u8; NAME_MAX]) -> NameWords {
    let mut words = NO_NAME;
    for (word, octets) in words.iter_mut().zip(name.chunks(8)) {
        *word = octets.iter().rev().fold(0, |word, octet| word << 8 | u64::from(*octet));
    }
    words
}

fn name_of(words: NameWords) -> [u8; NAME_MAX] {
    let octets = words.map(u64::to_le_bytes);
    std::array::from_fn(|place| octets[place / 8][place % 8])
}

/// Whether two values of a kind are different numbers of the same target: a rescue aircraft has an address and an MMSI.
fn are_of_one_aircraft(kind: usize, one: u64, other: u64) -> bool {
    let number = |value: u64| UniqueNumber::from_bits(value as u32);
    kind == ADDRESS && one != other && other != NONE && !number(one).excludes(number(other))
}

impl ReportedIdentity {
    /// Ages of the values at `time_ns`; 0 for values that are not known.
    pub fn ages(&self, time_ns: i64) -> IdentityAges {
        let known = [
            self.identity.unique_number().is_some(),
            self.identity.mode_3a().is_some(),
            self.identity.callsign().is_some(),
        ];
        let age = |kind: usize| {
            if known[kind] {
                age_ms(time_ns, self.stated_ns[kind])
            } else {
                0
            }
        };
        IdentityAges {
            address_ms: age(ADDRESS),
            mode_3a_ms: age(CODE),
            callsign_ms: age(CALLSIGN),
        }
    }

    /// Level, and the age of the level at `time_ns`, milliseconds.
    pub fn level_at(&self, time_ns: i64) -> Option<(i16, u32)> {
        self.level.map(|(level, stated_ns)| (level, age_ms(time_ns, stated_ns)))
    }
}

fn age_ms(time_ns: i64, stated_ns: i64) -> u32 {
    (time_ns.saturating_sub(stated_ns) / NS_PER_MS).clamp(0, u32::MAX.into()) as u32
}

/// Whether many aircraft show a code at the same time.
fn is_common(code: u64) -> bool {
    CONSPICUITY_CODES.iter().any(|common| u64::from(*common) == code)
}

/// The replies of a scan: rare values and where each occurs.
#[derive(Clone, Debug)]
pub(crate) struct ScanReplies {
    /// By code: number of detections, and the last detection.
    codes: Vec<(u32, u32)>,
    /// Number of detections with a code.
    coded: u32,
    /// (unique number, detection), sorted.
    numbers: Vec<(u64, u32)>,
    any: bool,
    settings: IdentitySettings,
    /// Spread of heights that are not known.
    height_sigma_m: f64,
}

impl ScanReplies {
    pub(crate) fn new(plots_max: usize, settings: IdentitySettings, height_sigma_m: f64) -> Self {
        Self {
            settings,
            height_sigma_m,
            codes: vec![(0, 0); CODES],
            coded: 0,
            numbers: Vec::with_capacity(plots_max),
            any: false,
        }
    }

    /// Reads the replies of a scan.
    pub(crate) fn read<'a>(&mut self, replies: impl Iterator<Item = &'a PlotIdentity>) {
        if self.coded > 0 {
            self.codes.fill((0, 0));
        }
        (self.coded, self.any) = (0, false);
        self.numbers.clear();
        if !self.settings.used {
            return;
        }
        for (place, reply) in (0..).zip(replies).filter(|(_, reply)| !reply.is_none()) {
            let [number, code, _] = reply.values;
            self.any = true;
            if number != NONE {
                self.numbers.push((number, place));
            }
            if code != NONE {
                self.codes[code as usize % CODES].0 += 1;
                self.codes[code as usize % CODES].1 = place;
                self.coded += 1;
            }
        }
        self.numbers.sort_unstable();
    }

    /// Whether any detection of the scan has a reply.
    pub(crate) fn are_any(&self) -> bool {
        self.any
    }

    /// Whether a detection is not of the target of a track: both have addresses, but different addresses.
    pub(crate) fn are_strangers(&self, track: &TrackIdentity, is_confirmed: bool, reply: &PlotIdentity) -> bool {
        self.any && track.has_another_address_than(reply, is_confirmed)
    }

    /// Detections that name the target of a track by address, or by a code that the scan has once.
    pub(crate) fn naming(&self, track: &TrackIdentity) -> impl Iterator<Item = u32> + '_ {
        let [address, code, _] = track.believed.map(|believed| believed.value);
        let first = self.numbers.partition_point(|(number, _)| *number < address);
        let by_address = self.numbers[first..]
            .iter()
            .take_while(move |(number, _)| *number == address);
        let alone = self
            .codes
            .get(code as usize)
            .filter(|(count, _)| *count == 1 && !is_common(code));
        let by_code = alone.map(|(_, place)| *place);
        by_address.map(|(_, place)| *place).chain(by_code)
    }

    /// Share of other targets with the code of a detection of the scan.
    fn share(&self, code: u64) -> f64 {
        let (count, _) = self.codes[code as usize % CODES];
        let prior = if is_common(code) {
            COMMON_SHARE
        } else {
            1.0 / CODES as f64
        };
        let [others, of_all] = [count, self.coded].map(|count| f64::from(count.saturating_sub(1)));
        ((PRIOR_CODES * prior + others) / (PRIOR_CODES + of_all)).max(1.0 / CODES as f64)
    }

    /// Logarithm of the ratio of the likelihoods of a detection's reply: from the target of a track, and from
    /// elsewhere.
    pub(crate) fn log_ratio(&self, track: &TrackIdentity, reply: &PlotIdentity) -> f64 {
        if !self.any || reply.is_none() {
            return 0.0;
        }
        let IdentitySettings {
            garbled_probability: g,
            swapped_probability: s,
            changed_probability: c,
            duplicated_probability: d,
            ..
        } = self.settings;
        let compared = |kind: usize| {
            let (value, believed) = (reply.values[kind], &track.believed[kind]);
            let are_compared = value != NONE && believed.value != NONE;
            (are_compared && !are_of_one_aircraft(kind, value, believed.value)).then_some((value, believed))
        };
        let mut ratio = None;
        let mut add = |of: f64| ratio = Some(ratio.unwrap_or(1.0) * of);
        let by_number = compared(ADDRESS);
        if let Some((value, believed)) = by_number {
            let (p, open) = believed.probability(value, 0.0, g);
            add(p * (1.0 - g) / d + g + open);
        }
        if let Some((value, believed)) = compared(CODE) {
            let (p, open) = believed.probability(value, c, g);
            let share = self.share(value);
            add(p * (1.0 - g) / share + g / (CODES as f64 * share) + c + open);
        }
        if let Some((value, believed)) = compared(CALLSIGN).filter(|_| by_number.is_none()) {
            let (p, open) = believed.probability(value, c, g);
            add(p * (1.0 - g) / d + g + c + open);
        }
        let of_level = reply.level.filter(|_| !reply.has_height);
        if let Some((level, stated_ns)) = of_level.filter(|_| track.level_ns > i64::MIN) {
            let seconds = stated_ns.saturating_sub(track.level_ns) as f64 / NS_PER_S;
            let sigma_m = (2.0f64.sqrt() * LEVEL_SIGMA_M).hypot(CLIMB_SIGMA_MPS * seconds);
            let apart_m = LEVEL_STEP_M * f64::from(i32::from(level) - track.level);
            let density = (-0.5 * (apart_m / sigma_m).powi(2)).exp() * self.height_sigma_m / sigma_m;
            add((1.0 - g) * density + g);
        }
        ratio.map_or(0.0, |ratio| ((1.0 - s) * ratio + s).ln())
    }
}

#[cfg(test)]
#[path = "identity_tests.rs"]
mod tests;

//! Items common to several categories, and their conversion.

use asterix::categories::CAT021_V2;
use asterix::field::{Elements, Field, elements, field};
use asterix::table::Category;
use asterix::text::icao_character;
use asterix::{Frn, Record};
use messages::{Callsign, Identity, TrackState, alert_bits};

use observations::{Alerts, Quality, ServiceMessage};

use super::Reading;

// Places in bytes are constants of the callers: inlined, they become part of the instructions.

/// An element that stands behind V (not validated) and G (garbled, or corrected) in its item.
pub(super) struct Reply(Elements<3>);

impl Reply {
    pub(super) const fn of(editions: &[&Category], item: &str, element: &str) -> Self {
        Self(elements(editions, item, ["V", "G", element]))
    }

    pub(super) const fn at(editions: &[&Category], frn: Frn, item: &str, element: &str) -> Self {
        Self(asterix::field::elements_at(editions, frn, item, ["V", "G", element]))
    }

    /// A Mode 3/A code that was received well.
    #[inline(always)]
    pub(super) fn code(&self, record: &Record<'_>) -> Option<u16> {
        let [not_validated, garbled, code] = self.0.numbers(record)?;
        (not_validated == 0 && garbled == 0).then_some(code as u16)
    }

    /// A level that was received well, in SI units.
    #[inline(always)]
    pub(super) fn level(&self, record: &Record<'_>) -> Option<f64> {
        let [not_validated, garbled, level] = self.0.quantities(record)?;
        (not_validated == 0.0 && garbled == 0.0).then_some(level)
    }
}

/// A time of day in nanoseconds, of an item in ticks of 1/128 s.
#[inline(always)]
pub(super) fn time_of_day_ns(record: &Record<'_>, time: &Elements<1>) -> Option<i64> {
    Some(nanoseconds(time.number(record)?))
}

/// Ticks of 1/128 s in nanoseconds.
pub(super) fn nanoseconds(ticks: u64) -> i64 {
    frames::time::time_of_day_ns(ticks as u32)
}

/// A message of the sensor about itself, with its time of day.
pub(super) fn service(record: &Record<'_>, time: &Elements<1>, turn_begins: bool, turn_ns: Option<i64>) -> Reading {
    Reading::Service(ServiceMessage {
        sac_sic: record.sender(),
        time_of_day_ns: time_of_day_ns(record, time),
        turn_begins,
        turn_ns,
    })
}

/// Returns an identity from a code, an address and eight packed characters, each if present.
pub(super) fn identity(code: Option<u16>, address: Option<u64>, characters: Option<u64>) -> Identity {
    let mut identity = Identity::default();
    if let Some(code) = code {
        identity = identity.with_mode_3a(code);
    }
    if let Some(address) = address {
        identity = identity.with_address(address as u32);
    }
    if let Some(callsign) = characters.and_then(callsign) {
        identity = identity.with_callsign(callsign);
    }
    identity
}

/// Eight characters of six bits. A code outside the alphabet becomes a `?`, which the alphabet does not have. `None`
/// if none of them is a letter or digit: the sender has no identification.
pub(crate) fn callsign(packed: u64) -> Option<Callsign> {
    let characters: Callsign = std::array::from_fn(|i| icao_character((packed >> (42 - 6 * i)) as u8).unwrap_or(b'?'));
    characters.iter().any(u8::is_ascii_alphanumeric).then_some(characters)
}

/// East and north components of a speed and a direction clockwise from north.
pub(crate) fn components([speed, track]: [f64; 2]) -> [f64; 2] {
    let (sine, cosine) = track.sin_cos();
    [speed * sine, speed * cosine]
}

/// Covariance from standard deviations and correlation, if neither deviation is zero: senders mean "not given" by that.
pub(super) fn covariance(sigma: [f64; 2], cross: f64) -> Quality {
    let [x, y] = sigma;
    if x > 0.0 && y > 0.0 {
        // Limited to the range permitted by the deviations.
        let most = 0.99 * x * y;
        Quality::Covariance([x * x, cross.clamp(-most, most), y * y])
    } else {
        Quality::Unstated
    }
}

/// Returns the state of a track: terminated, tentative, coasted, or confirmed.
pub(super) fn state(ended: bool, tentative: bool, extrapolated: bool) -> TrackState {
    if ended {
        TrackState::Terminated
    } else if tentative {
        TrackState::Tentative
    } else if extrapolated {
        TrackState::Coasted
    } else {
        TrackState::Confirmed
    }
}

/// Statement about emergencies, by the numbers of ADS-B; nothing is stated where there is no number.
pub(crate) fn alerts_of_emergency(number: Option<u8>) -> Alerts {
    const ALL: u8 = alert_bits::EMERGENCY
        | alert_bits::MEDICAL
        | alert_bits::MINIMUM_FUEL
        | alert_bits::COMMUNICATION_FAILURE
        | alert_bits::UNLAWFUL_INTERFERENCE;
    let raised = |number| match number {
        1 | 6 => alert_bits::EMERGENCY, // of no stated kind, or the aircraft is down
        2 => alert_bits::MEDICAL,
        3 => alert_bits::MINIMUM_FUEL,
        4 => alert_bits::COMMUNICATION_FAILURE,
        5 => alert_bits::UNLAWFUL_INTERFERENCE,
        _ => 0,
    };
    number.map_or(Alerts::default(), |number| Alerts::of(ALL, raised(number)))
}

/// Statement about code and identification, by the surveillance status of a position (SS).
pub(crate) fn alerts_of_surveillance_status(status: u8) -> Alerts {
    let raised = match status {
        1 | 2 => alert_bits::TRANSPONDER_ALERT, // permanent, or temporary
        3 => alert_bits::SPECIAL_IDENTIFICATION,
        _ => 0,
    };
    Alerts::of(
        alert_bits::TRANSPONDER_ALERT | alert_bits::SPECIAL_IDENTIFICATION,
        raised,
    )
}

/// Alerts, and whether the aircraft is on the ground, by the flight status that a Mode S transponder states (STAT).
pub(crate) fn flight_status(status: Option<u8>) -> (Alerts, bool) {
    const BOTH: u8 = alert_bits::TRANSPONDER_ALERT | alert_bits::SPECIAL_IDENTIFICATION;
    let (raised, on_ground) = match status {
        Some(0) => (0, false),
        Some(1) => (0, true),
        Some(2) => (alert_bits::TRANSPONDER_ALERT, false),
        Some(3) => (alert_bits::TRANSPONDER_ALERT, true),
        Some(4) => (BOTH, false),
        Some(5) => (alert_bits::SPECIAL_IDENTIFICATION, false),
        _ => return (Alerts::default(), false),
    };
    (Alerts::of(BOTH, raised), on_ground)
}

/// Statement about a resolution advisory of a collision avoidance system; nothing is stated by an empty register.
/// Several categories contain BDS register 3,0 of ICAO Annex 10 volume IV, 4.3.8.4.2.2, as bytes; CAT021 has its
/// fields as separate elements.
pub(crate) fn alerts_of_advisory(register: &[u8]) -> Alerts {
    const ADVISORIES: Field = field(CAT021_V2, &["260", "ARA"]);
    const TERMINATED: Field = field(CAT021_V2, &["260", "RAT"]);
    const MULTIPLE_THREATS: Field = field(CAT021_V2, &["260", "MTE"]);
    let Some(advisories) = ADVISORIES.number(register) else {
        return Alerts::default();
    };
    let is_advised = advisories >> (ADVISORIES.bits - 1) == 1;
    let is_active = !TERMINATED.is_set(register) && (is_advised || MULTIPLE_THREATS.is_set(register));
    Alerts::advisory(is_active)
}

/// Whether a radar's report contains a transponder's reply, by the kind of detection: 0 none, 1 primary, other kinds
/// include a reply.
pub(super) fn secondary(detection: Option<u8>) -> Option<bool> {
    detection
        .filter(|detection| *detection != 0)
        .map(|detection| detection != 1)
}

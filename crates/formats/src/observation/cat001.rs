//! CAT001: radar, before CAT048.
//!
//! Plots and tracks have the same items in different places. The time is modulo 512 s, and messages of CAT002
//! complete it; a block may state its sender in the first record only. The document does not define the plane of a
//! track's x and y. The radar's own, uncorrected plane is assumed: a radar with slant range correction could state
//! the correction, and sends CAT048. Plots have neither number nor address. Items in a random field sequence are
//! ignored.

use asterix::categories::{CAT001, CAT001_V1_4};
use asterix::field::{elements_at, whole_at};
use asterix::table::Uap;
use frames::time::NS_PER_S;

use super::*;

/// Items that plots and tracks have in different places.
struct Items {
    position: Elements<2>,
    mode_3a: Reply,
    flight_level: Reply,
    time: Elements<1>,
}

impl Items {
    const fn of(profile: &Uap) -> Self {
        Self {
            position: elements_at(CAT001, profile.frn("040"), "040", ["RHO", "THETA"]),
            mode_3a: Reply::at(CAT001, profile.frn("070"), "070", "MODE3A"),
            flight_level: Reply::at(CAT001, profile.frn("090"), "090", "HGT"),
            time: whole_at(CAT001, profile.frn("141"), "141"),
        }
    }
}

const PLOT: Items = Items::of(CAT001_V1_4.uap_of(0));
const TRACK_PROFILE: &Uap = CAT001_V1_4.uap_of(1);
const TRACK: Items = Items::of(TRACK_PROFILE);
const TRACK_NUMBER: Elements<1> = whole_at(CAT001, TRACK_PROFILE.frn("161"), "161");
const POSITION: Elements<2> = elements_at(CAT001, TRACK_PROFILE.frn("042"), "042", ["X", "Y"]);
const VELOCITY: Elements<2> = elements_at(CAT001, TRACK_PROFILE.frn("200"), "200", ["GSP", "HDG"]);

const DESCRIPTOR: Frn = item(CAT001, "020");
const TYP: Field = field(CAT001, &["020", "TYP"]);
const SIM: Field = field(CAT001, &["020", "SIM"]);
const SSRPSR: Field = field(CAT001, &["020", "SSRPSR"]);
const SPI: Field = field(CAT001, &["020", "SPI"]);
const RAB: Field = field(CAT001, &["020", "RAB"]);
const TST: Field = field(CAT001, &["020", "TST"]);
const DS1DS2: Field = field(CAT001, &["020", "DS1DS2"]);
const ME: Field = field(CAT001, &["020", "ME"]);

const STATUS: Frn = TRACK_PROFILE.frn("170");
const CON: Field = field(CAT001, &["170", "CON"]);
const TRE: Field = field(CAT001, &["170", "TRE"]);

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    record
        .table()
        .is_one_of(CAT001)
        .then(|| Reading::Target(observation(record)))
}

fn observation(record: &Record<'_>) -> Observation {
    let descriptor = record.octets(DESCRIPTOR);
    let is_track = TYP.is_set(descriptor);
    let items = if is_track { &TRACK } else { &PLOT };
    let track = is_track.then_some(record);
    let status = track.map_or(&[][..], |track| track.octets(STATUS));
    Observation {
        sac_sic: record.sender(),
        truncated_time_ns: items.time.number(record).map(|ticks| ticks as i64 * NS_PER_S / 128),
        secondary: secondary(SSRPSR.code(descriptor)),
        field_monitor: RAB.is_set(descriptor),
        test: SIM.is_set(descriptor) || TST.is_set(descriptor),
        track_number: track
            .and_then(|track| TRACK_NUMBER.number(track))
            .map(|number| number as u32),
        plot: !is_track,
        identity: identity(items.mode_3a.code(record), None, None),
        cartesian: track.and_then(|track| POSITION.quantities(track)),
        plane: Plane::Slant,
        slant_polar: items.position.quantities(record),
        velocity: track.and_then(|track| VELOCITY.quantities(track)).map(components),
        pressure_altitude_m: items.flight_level.level(record),
        alerts: Alerts::flag(alert_bits::SPECIAL_IDENTIFICATION, SPI.is_set(descriptor))
            | Alerts::flag(alert_bits::EMERGENCY, ME.is_set(descriptor))
            | alerts_of_codes(DS1DS2.code(descriptor)),
        state: state(
            TRE.is_set(status),
            CON.is_set(status),
            SSRPSR.code(descriptor) == Some(0),
        ),
        ..Observation::default()
    }
}

/// DS1/DS2: whether the Mode 3/A code is 7500, 7600 or 7700.
fn alerts_of_codes(number: Option<u8>) -> Alerts {
    const ALL: u8 = alert_bits::UNLAWFUL_INTERFERENCE | alert_bits::COMMUNICATION_FAILURE | alert_bits::EMERGENCY;
    let raised = match number {
        Some(1) => alert_bits::UNLAWFUL_INTERFERENCE,
        Some(2) => alert_bits::COMMUNICATION_FAILURE,
        Some(3) => alert_bits::EMERGENCY,
        _ => 0,
    };
    Alerts::of(if number.is_some() { ALL } else { 0 }, raised)
}

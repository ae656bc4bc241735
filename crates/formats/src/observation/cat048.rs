//! CAT048: radar.
//!
//! A record has up to two positions: the plot, range and azimuth as measured in this turn, and the track, x and y as
//! calculated by the radar's tracker. A plot without a track number is numbered by its address, if present; the plots
//! of an aircraft then form a track.

use asterix::categories::CAT048;

use super::*;

const TIME: Elements<1> = whole(CAT048, "140");
const PLOT: Elements<2> = elements(CAT048, "040", ["RHO", "THETA"]);
const TRACK: Elements<2> = elements(CAT048, "042", ["X", "Y"]);
const VELOCITY: Elements<2> = elements(CAT048, "200", ["GSP", "HDG"]);
const SIGMA: Elements<4> = elements(CAT048, "210", ["SIGX", "SIGY", "SIGV", "SIGH"]);
const TRACK_NUMBER: Elements<1> = elements(CAT048, "161", ["TRN"]);
const MODE_3A: Reply = Reply::of(CAT048, "070", "MODE3A");
const FLIGHT_LEVEL: Reply = Reply::of(CAT048, "090", "FL");
/// Height above mean sea level, of a radar that measures elevation.
const MEASURED_HEIGHT: Elements<1> = elements(CAT048, "110", ["3DH"]);
const ADDRESS: Elements<1> = whole(CAT048, "220");
const CALLSIGN: Elements<1> = whole(CAT048, "240");
const FLIGHT_STATUS: Elements<1> = elements(CAT048, "230", ["STAT"]);
const DOPPLER: Frn = item(CAT048, "120");
const DOUBTFUL: Field = field(CAT048, &["120", "CAL", "D"]);
const CALCULATED_SPEED: Field = field(CAT048, &["120", "CAL", "CAL"]);
const ADVISORY: Frn = item(CAT048, "260");

const DESCRIPTOR: Frn = item(CAT048, "020");
const TYP: Field = field(CAT048, &["020", "TYP"]);
const SIM: Field = field(CAT048, &["020", "SIM"]);
const SPI: Field = field(CAT048, &["020", "SPI"]);
const RAB: Field = field(CAT048, &["020", "RAB"]);
const TST: Field = field(CAT048, &["020", "TST"]);
const ERR: Field = field(CAT048, &["020", "ERR"]);
const ME: Field = field(CAT048, &["020", "ME"]);

const STATUS: Frn = item(CAT048, "170");
const CNF: Field = field(CAT048, &["170", "CNF"]);
const TRE: Field = field(CAT048, &["170", "TRE"]);
const TCC: Field = field(CAT048, &["170", "TCC"]);

const WARNINGS: Frn = item(CAT048, "030");
const WARNING: Field = field(CAT048, &["030"]);
/// The height code differs too much from the track's.
const ABNORMAL_HEIGHT: u8 = 12;
/// The height code has no meaning.
const UNDECODABLE_HEIGHT: u8 = 18;

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    record
        .table()
        .is_one_of(CAT048)
        .then(|| Reading::Target(observation(record)))
}

fn observation(record: &Record<'_>) -> Observation {
    let (descriptor, status) = (record.octets(DESCRIPTOR), record.octets(STATUS));
    let (address, track_number) = (ADDRESS.number(record), TRACK_NUMBER.number(record));
    let (velocity, sigma) = (VELOCITY.quantities(record), SIGMA.quantities(record));
    let (flight_alerts, on_ground) = flight_status(FLIGHT_STATUS.number(record).map(|status| status as u8));
    let cartesian = TRACK.quantities(record);
    Observation {
        sac_sic: record.sender(),
        time_of_day_ns: time_of_day_ns(record, &TIME),
        secondary: secondary(TYP.code(descriptor)),
        field_monitor: RAB.is_set(descriptor),
        test: SIM.is_set(descriptor) || TST.is_set(descriptor),
        track_number: track_number.or(address).map(|number| number as u32),
        plot: track_number.is_none(),
        identity: identity(MODE_3A.code(record), address, CALLSIGN.number(record)),
        cartesian,
        plane: if TCC.is_set(status) {
            Plane::Stereographic
        } else {
            Plane::Slant
        },
        // Beyond the range that the item can hold, it holds the largest.
        slant_polar: PLOT.quantities(record).filter(|_| !ERR.is_set(descriptor)),
        doppler_mps: doppler(record.octets(DOPPLER)),
        velocity: velocity.map(components),
        axes: Axes::Target,
        velocity_covariance: velocity.zip(sigma).and_then(velocity_covariance),
        pressure_altitude_m: FLIGHT_LEVEL.level(record).filter(|_| !height_doubted(record)),
        geometric_height_m: MEASURED_HEIGHT.quantity(record),
        on_ground,
        alerts: Alerts::flag(alert_bits::SPECIAL_IDENTIFICATION, SPI.is_set(descriptor))
            | Alerts::flag(alert_bits::EMERGENCY, ME.is_set(descriptor))
            | flight_alerts
            | alerts_of_advisory(record.octets(ADVISORY)),
        state: state(TRE.is_set(status), CNF.is_set(status), TYP.code(descriptor) == Some(0)),
        quality: match sigma {
            Some([x, y, ..]) if cartesian.is_some() => covariance([x, y], 0.0),
            _ => Quality::Unstated,
        },
        ..Observation::default()
    }
}

/// Calculated Doppler speed, metres per second: the first element of a compound item. `None` if it is absent or
/// doubtful; a raw speed is ambiguous.
fn doppler(item: &[u8]) -> Option<f64> {
    const CALCULATED: u8 = 0x80;
    let (present, element) = item.split_first()?;
    let is_stated = present & CALCULATED != 0 && !DOUBTFUL.is_set(element);
    CALCULATED_SPEED.quantity(element).filter(|_| is_stated)
}

fn height_doubted(record: &Record<'_>) -> bool {
    let mut warnings = record
        .octets(WARNINGS)
        .chunks_exact(1)
        .filter_map(|octet| WARNING.code(octet));
    warnings.any(|warning| warning == ABNORMAL_HEIGHT || warning == UNDECODABLE_HEIGHT)
}

/// Returns the covariance of a velocity from the deviations of along-track speed and of heading; `None` if a
/// deviation is zero, the code for "not given".
fn velocity_covariance(([speed, track], [_, _, sigma_speed, sigma_track]): ([f64; 2], [f64; 4])) -> Option<[f64; 3]> {
    let along = sigma_speed.powi(2);
    let across = (speed * sigma_track).powi(2);
    let (sine, cosine) = track.sin_cos();
    (along > 0.0 && across > 0.0).then_some([
        along * sine * sine + across * cosine * cosine,
        (along - across) * sine * cosine,
        along * cosine * cosine + across * sine * sine,
    ])
}

#[cfg(test)]
mod tests {
    use super::doppler;

    #[test]
    fn a_calculated_doppler_speed_is_read_with_its_sign() {
        for (item, expected) in [
            (&[0x80, 0x00, 0x19][..], Some(25.0)),
            (&[0x80, 0x03, 0xe7], Some(-25.0)),
            (&[0x80, 0x80, 0x19], None),
            (&[0x80, 0x01, 0xff], Some(511.0)),
            (&[0x80, 0x02, 0x00], Some(-512.0)),
            (&[0x40, 0x01, 0x00, 0x10, 0x00, 0x20, 0x00, 0x30], None),
            (&[], None),
        ] {
            assert_eq!(doppler(item), expected, "{item:x?}");
        }
    }
}

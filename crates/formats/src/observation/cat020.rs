//! CAT020: multilateration.

use asterix::categories::CAT020;
use asterix::field::subitem;

use super::*;

const TIME: Elements<1> = whole(CAT020, "140");
const GEODETIC: Elements<2> = elements(CAT020, "041", ["LAT", "LON"]);
const CARTESIAN: Elements<2> = elements(CAT020, "042", ["X", "Y"]);
const VELOCITY: Elements<2> = elements(CAT020, "202", ["VX", "VY"]);
const TRACK_NUMBER: Elements<1> = elements(CAT020, "161", ["TRN"]);
const MODE_3A: Reply = Reply::of(CAT020, "070", "MODE3A");
const ADDRESS: Elements<1> = whole(CAT020, "220");
const CALLSIGN: Elements<1> = elements(CAT020, "245", ["CHR"]);
const FLIGHT_LEVEL: Reply = Reply::of(CAT020, "090", "FL");
/// Above the system's reference point.
const MEASURED_HEIGHT: Elements<1> = whole(CAT020, "110");
/// Above the ellipsoid.
const GEOMETRIC_HEIGHT: Elements<1> = whole(CAT020, "105");
const FLIGHT_STATUS: Elements<1> = elements(CAT020, "230", ["STAT"]);
const ADVISORY: Frn = item(CAT020, "260");

const DESCRIPTOR: Frn = item(CAT020, "020");
const RAB: Field = field(CAT020, &["020", "RAB"]);
const SPI: Field = field(CAT020, &["020", "SPI"]);
const GBS: Field = field(CAT020, &["020", "GBS"]);
const SIM: Field = field(CAT020, &["020", "SIM"]);
const TST: Field = field(CAT020, &["020", "TST"]);

const STATUS: Frn = item(CAT020, "170");
const CNF: Field = field(CAT020, &["170", "CNF"]);
const TRE: Field = field(CAT020, &["170", "TRE"]);
const CST: Field = field(CAT020, &["170", "CST"]);

const ACCURACY: Frn = item(CAT020, "500");
/// Dilution of precision.
const DOP: usize = subitem(CAT020, "500", "DOP");
const DOP_XY: Field = field(CAT020, &["500", "DOP", "XY"]);
/// Standard deviations of the position, and their correlation.
const SDP: usize = subitem(CAT020, "500", "SDP");
const SDP_X: Field = field(CAT020, &["500", "SDP", "X"]);
const SDP_Y: Field = field(CAT020, &["500", "SDP", "Y"]);
const SDP_XY: Field = field(CAT020, &["500", "SDP", "XY"]);

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    record
        .table()
        .is_one_of(CAT020)
        .then(|| Reading::Target(observation(record)))
}

fn observation(record: &Record<'_>) -> Observation {
    let (descriptor, status) = (record.octets(DESCRIPTOR), record.octets(STATUS));
    let (address, track_number) = (ADDRESS.number(record), TRACK_NUMBER.number(record));
    let (flight_alerts, on_ground) = flight_status(FLIGHT_STATUS.number(record).map(|status| status as u8));
    Observation {
        sac_sic: record.sender(),
        time_of_day_ns: time_of_day_ns(record, &TIME),
        field_monitor: RAB.is_set(descriptor),
        test: SIM.is_set(descriptor) || TST.is_set(descriptor),
        track_number: track_number.or(address).map(|number| number as u32),
        plot: track_number.is_none(),
        identity: identity(MODE_3A.code(record), address, CALLSIGN.number(record)),
        cartesian: CARTESIAN.quantities(record),
        geodetic: GEODETIC.quantities(record),
        velocity: VELOCITY.quantities(record),
        // Systems without a flight level send 0, so a level of exactly 0 is treated as missing.
        pressure_altitude_m: FLIGHT_LEVEL.level(record).filter(|altitude| *altitude != 0.0),
        geometric_height_m: MEASURED_HEIGHT
            .quantity(record)
            .or_else(|| GEOMETRIC_HEIGHT.quantity(record)),
        ellipsoid_height_m: GEOMETRIC_HEIGHT.quantity(record),
        on_ground: GBS.is_set(descriptor) || on_ground,
        alerts: Alerts::flag(alert_bits::SPECIAL_IDENTIFICATION, SPI.is_set(descriptor))
            | flight_alerts
            | alerts_of_advisory(record.octets(ADVISORY)),
        state: state(TRE.is_set(status), CNF.is_set(status), CST.is_set(status)),
        quality: quality(record),
        ..Observation::default()
    }
}

/// Returns SDP, if given, else the dilution of precision; systems send zeros for "not given".
fn quality(record: &Record<'_>) -> Quality {
    let mut quality = Quality::Unstated;
    for (position, octets) in record.subitems(ACCURACY) {
        let stated = match position {
            DOP => match DOP_XY.quantity(octets) {
                Some(dilution) if dilution > 0.0 => Quality::Dilution(dilution),
                _ => Quality::Unstated,
            },
            SDP => {
                let sigma = [SDP_X, SDP_Y].map(|field| field.quantity(octets).unwrap_or(0.0));
                let correlation = SDP_XY.quantity(octets).unwrap_or(0.0);
                covariance(sigma, correlation * sigma[0] * sigma[1])
            }
            _ => Quality::Unstated,
        };
        if stated != Quality::Unstated {
            quality = stated;
        }
    }
    quality
}

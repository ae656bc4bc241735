//! CAT010: surface movement radar and multilateration of an airport.

use asterix::categories::CAT010;

use super::*;

const MESSAGE_TYPE: Elements<1> = whole(CAT010, "000");
const TIME: Elements<1> = whole(CAT010, "140");
const POLAR: Elements<2> = elements(CAT010, "040", ["RHO", "TH"]);
const GEODETIC: Elements<2> = elements(CAT010, "041", ["LAT", "LON"]);
const CARTESIAN: Elements<2> = elements(CAT010, "042", ["X", "Y"]);
const POLAR_VELOCITY: Elements<2> = elements(CAT010, "200", ["GSP", "TRA"]);
const CARTESIAN_VELOCITY: Elements<2> = elements(CAT010, "202", ["VX", "VY"]);
const TRACK_NUMBER: Elements<1> = elements(CAT010, "161", ["TRK"]);
const MODE_3A: Reply = Reply::of(CAT010, "060", "MODE3A");
const ADDRESS: Elements<1> = whole(CAT010, "220");
const CALLSIGN: Elements<1> = elements(CAT010, "245", ["CHR"]);
const FLIGHT_LEVEL: Reply = Reply::of(CAT010, "090", "FL");
/// Above the local plane.
const MEASURED_HEIGHT: Elements<1> = whole(CAT010, "091");
const DEVIATION: Elements<3> = elements(CAT010, "500", ["DEVX", "DEVY", "COVXY"]);

const DESCRIPTOR: Frn = item(CAT010, "020");
const GBS: Field = field(CAT010, &["020", "GBS"]);
const SIM: Field = field(CAT010, &["020", "SIM"]);
const TST: Field = field(CAT010, &["020", "TST"]);
const RAB: Field = field(CAT010, &["020", "RAB"]);
const SPI: Field = field(CAT010, &["020", "SPI"]);

const STATUS: Frn = item(CAT010, "170");
const CNF: Field = field(CAT010, &["170", "CNF"]);
const TRE: Field = field(CAT010, &["170", "TRE"]);
const CST: Field = field(CAT010, &["170", "CST"]);

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    record.table().is_one_of(CAT010).then_some(())?;
    match MESSAGE_TYPE.number(record)? {
        1 => Some(Reading::Target(observation(record))),
        2 => Some(service(record, &TIME, true, None)), // a new update cycle begins
        3 | 4 => Some(service(record, &TIME, false, None)),
        _ => None,
    }
}

fn observation(record: &Record<'_>) -> Observation {
    let (descriptor, status) = (record.octets(DESCRIPTOR), record.octets(STATUS));
    let (address, track_number) = (ADDRESS.number(record), TRACK_NUMBER.number(record));
    Observation {
        sac_sic: record.sender(),
        time_of_day_ns: time_of_day_ns(record, &TIME),
        field_monitor: RAB.is_set(descriptor),
        test: SIM.is_set(descriptor) || TST.is_set(descriptor),
        track_number: track_number.or(address).map(|number| number as u32),
        plot: track_number.is_none(),
        identity: identity(MODE_3A.code(record), address, CALLSIGN.number(record)),
        cartesian: CARTESIAN.quantities(record),
        // At an airport the range along the ground is that to the target.
        polar: POLAR.quantities(record),
        geodetic: GEODETIC.quantities(record),
        velocity: CARTESIAN_VELOCITY
            .quantities(record)
            .or_else(|| POLAR_VELOCITY.quantities(record).map(components)),
        pressure_altitude_m: FLIGHT_LEVEL.level(record),
        geometric_height_m: MEASURED_HEIGHT.quantity(record),
        on_ground: GBS.is_set(descriptor),
        alerts: Alerts::flag(alert_bits::SPECIAL_IDENTIFICATION, SPI.is_set(descriptor)),
        state: state(TRE.is_set(status), CNF.is_set(status), CST.is_set(status)),
        quality: DEVIATION
            .quantities(record)
            .map_or(Quality::Unstated, |[x, y, xy]| covariance([x, y], xy)),
        ..Observation::default()
    }
}

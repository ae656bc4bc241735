//! CAT015: independent non-cooperative surveillance: radars that see targets without transponders, also those that use
//! the transmitters of others, and optics.
//!
//! The position is the system's own in WGS-84 (I015/600); a sensor of one place may send range and azimuth instead.
//! The range of a system of several places is the detour by way of the target and is no position: such a report has
//! none here. A reference target (a permanent echo, a signal generator) monitors the system. x and y are east and north
//! at the target.
//!
//! Of the items about accuracy, standard deviations and their correlations are used, resolutions are not: a resolution
//! states which targets are seen as one. Standard deviations of range and azimuth are not used either; for a report
//! without I015/600 the configured accuracy of the source counts.

use asterix::categories::CAT015;
use asterix::field::subitem;

use super::*;

const TIME: Elements<1> = whole(CAT015, "145");
const NUMBER: Elements<1> = whole(CAT015, "161");

const KIND: Frn = item(CAT015, "000");
const MT: Field = field(CAT015, &["000", "MT"]);
const MEASUREMENT_PLOT: u8 = 1;
const SENSOR_PLOT: u8 = 3;
const TRACK_END: u8 = 5;

const DESCRIPTOR: Frn = item(CAT015, "020");
const MOMU: Field = field(CAT015, &["020", "MOMU"]);
const TTAX: Field = field(CAT015, &["020", "TTAX"]);
const ONE_PLACE: u8 = 0;
const REFERENCE: u8 = 1;
const SYNTHETIC: u8 = 2;
const SIMULATED: u8 = 3;

const STATUS: Frn = item(CAT015, "170");
const TUR: Field = field(CAT015, &["170", "TUR"]);
const CSTP: Field = field(CAT015, &["170", "CSTP"]);
const CNF: Field = field(CAT015, &["170", "CNF"]);

const POSITION: Frn = item(CAT015, "600");
const P84: usize = subitem(CAT015, "600", "P84");
const LATITUDE: Field = field(CAT015, &["600", "P84", "LATITUDE"]);
const LONGITUDE: Field = field(CAT015, &["600", "P84", "LONGITUDE"]);
/// Standard deviations of the position, and their correlation.
const HPP: usize = subitem(CAT015, "600", "HPP");
const SDHPX: Field = field(CAT015, &["600", "HPP", "SDHPX"]);
const SDHPY: Field = field(CAT015, &["600", "HPP", "SDHPY"]);
const COSDHPXY: Field = field(CAT015, &["600", "HPP", "COSDHPXY"]);

const HEIGHT: Frn = item(CAT015, "601");
const GH: usize = subitem(CAT015, "601", "GH");
const ELLIPSOID_HEIGHT: Field = field(CAT015, &["601", "GH"]);

const VELOCITY: Frn = item(CAT015, "602");
const HV: usize = subitem(CAT015, "602", "HV");
const VX: Field = field(CAT015, &["602", "HV", "X"]);
const VY: Field = field(CAT015, &["602", "HV", "Y"]);
/// Standard deviations of the velocity, and their correlation.
const SDHV: usize = subitem(CAT015, "602", "SDHV");
const SIGMA_VX: Field = field(CAT015, &["602", "SDHV", "X"]);
const SIGMA_VY: Field = field(CAT015, &["602", "SDHV", "Y"]);
const COHVXY: Field = field(CAT015, &["602", "SDHV", "COHVXY"]);

const VERTICAL: Frn = item(CAT015, "604");
const VV: usize = subitem(CAT015, "604", "VV");
const CLIMB: Field = field(CAT015, &["604", "VV"]);

const RANGE: Frn = item(CAT015, "625");
const R: usize = subitem(CAT015, "625", "R");
const DISTANCE: Field = field(CAT015, &["625", "R"]);

const DOPPLER: Frn = item(CAT015, "626");
const DV: usize = subitem(CAT015, "626", "DV");
const RADIAL_SPEED: Field = field(CAT015, &["626", "DV"]);

const AZIMUTH: Frn = item(CAT015, "627");
const AZ: usize = subitem(CAT015, "627", "AZ");
const DIRECTION: Field = field(CAT015, &["627", "AZ"]);

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    record
        .table()
        .is_one_of(CAT015)
        .then(|| Reading::Target(observation(record)))
}

fn observation(record: &Record<'_>) -> Observation {
    let (descriptor, status) = (record.octets(DESCRIPTOR), record.octets(STATUS));
    let kind = MT.code(record.octets(KIND));
    let target = TTAX.code(descriptor);
    // A report without the descriptor does not state what its range is.
    let is_of_one_place = MOMU.code(descriptor) == Some(ONE_PLACE);
    let (position, velocity) = (Estimate::position(record), Estimate::velocity(record));
    let height_m = part(record, HEIGHT, GH, ELLIPSOID_HEIGHT);
    Observation {
        sac_sic: record.sender(),
        time_of_day_ns: time_of_day_ns(record, &TIME),
        secondary: Some(false),
        field_monitor: target == Some(REFERENCE),
        test: matches!(target, Some(SYNTHETIC | SIMULATED)),
        track_number: NUMBER.number(record).map(|number| number as u32),
        plot: matches!(kind, Some(MEASUREMENT_PLOT | SENSOR_PLOT)),
        geodetic: position.value,
        slant_polar: polar(record).filter(|_| is_of_one_place),
        doppler_mps: part(record, DOPPLER, DV, RADIAL_SPEED).filter(|_| is_of_one_place),
        velocity: velocity.value,
        axes: Axes::Target,
        velocity_covariance: match velocity.quality {
            Quality::Covariance(covariance) => Some(covariance),
            _ => None,
        },
        geometric_height_m: height_m,
        ellipsoid_height_m: height_m,
        vertical_rate_mps: part(record, VERTICAL, VV, CLIMB),
        state: state(
            kind == Some(TRACK_END) || TUR.is_set(status),
            CNF.is_set(status),
            CSTP.is_set(status),
        ),
        quality: position.quality,
        ..Observation::default()
    }
}

/// An element that is all of a subitem, in SI units.
fn part(record: &Record<'_>, item: Frn, subitem: usize, element: Field) -> Option<f64> {
    let mut subitems = record.subitems(item);
    let octets = subitems.find_map(|(position, octets)| (position == subitem).then_some(octets))?;
    element.quantity(octets)
}

/// Straight distance and azimuth. A negative distance is that of a system of several places.
fn polar(record: &Record<'_>) -> Option<[f64; 2]> {
    let distance_m = part(record, RANGE, R, DISTANCE).filter(|distance| *distance >= 0.0)?;
    Some([distance_m, part(record, AZIMUTH, AZ, DIRECTION)?])
}

/// Two values of a compound item and their accuracy.
#[derive(Default)]
struct Estimate {
    value: Option<[f64; 2]>,
    quality: Quality,
}

impl Estimate {
    /// Latitude and longitude, radians; covariance of east and north, m².
    fn position(record: &Record<'_>) -> Self {
        Self::of(
            record,
            POSITION,
            (P84, [LATITUDE, LONGITUDE]),
            (HPP, [SDHPX, SDHPY, COSDHPXY]),
        )
    }

    /// East and north, m/s, and their covariance, m²/s².
    fn velocity(record: &Record<'_>) -> Self {
        Self::of(record, VELOCITY, (HV, [VX, VY]), (SDHV, [SIGMA_VX, SIGMA_VY, COHVXY]))
    }

    fn of(record: &Record<'_>, item: Frn, values: (usize, [Field; 2]), errors: (usize, [Field; 3])) -> Self {
        let mut found = Self::default();
        for (position, octets) in record.subitems(item) {
            if position == values.0 {
                let [x, y] = values.1.map(|field| field.quantity(octets));
                found.value = x.zip(y).map(|(x, y)| [x, y]);
            } else if position == errors.0 {
                let [x, y, correlation] = errors.1.map(|field| field.quantity(octets).unwrap_or(0.0));
                found.quality = covariance([x, y], correlation * x * y);
            }
        }
        found
    }
}

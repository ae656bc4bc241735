//! Measurements that the locator rejects, and why.

use observations::{Arrival, ArrivalTime, Bearing};

use crate::arrivals::CLOCKS_MAX;

/// A direction with a greater standard deviation is none, radians.
const SIGMA_MAX_RAD: f64 = 1.0;
/// Greatest coordinate of a platform, metres; beyond, millimetres are lost in differences.
const COORDINATE_MAX_M: f64 = 1e9;

/// Reason why a bearing was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BearingRejection {
    /// A value is no number or cannot be.
    Unusable(&'static str),
    /// The bearing is older than the emitter's last bearing.
    OutOfOrder,
    /// The bearing is of a new emitter, and there is no place.
    TableFull,
    /// Another receiver, and there is no place for the receiver's clock.
    ReceiversFull,
    /// A transmission at a single receiver.
    Alone,
    /// A transmission at receivers with clocks not known yet.
    ClockUnknown,
    /// A difference of distances greater than the distance between the receivers.
    Impossible,
}

impl BearingRejection {
    /// Whether a rejected arrival is itself of no use. Otherwise the transmission that ends with the arrival, or before
    /// it, was rejected: the arrival may belong to a transmission.
    pub fn is_of_arrival(&self) -> bool {
        matches!(self, Self::Unusable(_) | Self::ReceiversFull)
    }
}

impl std::fmt::Display for BearingRejection {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unusable(what) => write!(formatter, "{what}"),
            Self::OutOfOrder => write!(
                formatter,
                "is older than the emitter's last bearing; sort the bearings by time"
            ),
            Self::TableFull => write!(
                formatter,
                "is of a new emitter, and all places are taken; configure a greater emitters_max"
            ),
            Self::ReceiversFull => write!(
                formatter,
                "is of another receiver, and {CLOCKS_MAX} have a clock already"
            ),
            Self::Alone => write!(
                formatter,
                "is the only one of its transmission; give the arrivals of a transmission the same time_s"
            ),
            Self::ClockUnknown => write!(
                formatter,
                "is of receivers whose clocks no reference emitter has shown yet; add rows with reference_x"
            ),
            Self::Impossible => write!(
                formatter,
                "is farther off than the receivers are apart; check the clocks, the units and the order of receivers"
            ),
        }
    }
}

impl std::error::Error for BearingRejection {}

/// Returns whether all coordinates are numbers within [`COORDINATE_MAX_M`].
pub(crate) fn is_place(position_m: &[f64; 3]) -> bool {
    position_m.iter().all(|value| value.abs() < COORDINATE_MAX_M)
}

/// Fault of a bearing; `None` if there is none.
pub(crate) fn fault(bearing: &Bearing) -> Option<&'static str> {
    let angles = bearing.bearing_rad.is_finite() && bearing.heading_rad.is_none_or(f64::is_finite);
    if !angles {
        Some("an angle is no number")
    } else if !(bearing.sigma_rad > 0.0 && bearing.sigma_rad <= SIGMA_MAX_RAD) {
        Some("the standard deviation is not between 0 and 1 rad")
    } else if !is_place(&bearing.platform_m) {
        Some("the platform's position is no number, or farther away than 1e9 m")
    } else if bearing
        .frequency_hz
        .is_some_and(|frequency| !(frequency > 0.0 && frequency.is_finite()))
    {
        Some("the frequency is not greater than 0")
    } else {
        None
    }
}

/// Fault of an arrival; `None` if there is none.
pub(crate) fn arrival_fault(arrival: &Arrival) -> Option<&'static str> {
    let (receivers, time_s) = match &arrival.time {
        ArrivalTime::At { receiver, t_s } => ([receiver; 2], t_s),
        ArrivalTime::Between { receivers, tdoa_s } => ([&receivers[0], &receivers[1]], tdoa_s),
    };
    if !time_s.is_finite() {
        Some("the time is no number")
    } else if !(arrival.sigma_s > 0.0 && arrival.sigma_s.is_finite()) {
        Some("the standard deviation is not greater than 0")
    } else if !receivers.iter().all(|receiver| is_place(&receiver.position_m)) {
        Some("a receiver's position is no number, or farther away than 1e9 m")
    } else if arrival.reference_m.is_some_and(|place| !is_place(&place)) {
        Some("the reference emitter's position is no number, or farther away than 1e9 m")
    } else if matches!(&arrival.time, ArrivalTime::Between { receivers: [one, other], .. } if one.name == other.name) {
        Some("both receivers are the same")
    } else {
        None
    }
}

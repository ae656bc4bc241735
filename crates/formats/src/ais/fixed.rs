//! Stations that are no targets: base stations, aids to navigation.

use aivdm::Timestamp;
use aivdm::message::{AidToNavigationReport, BaseStationReport};
use frames::time::NS_PER_DAY;
use messages::Identity;
use observations::TargetCategory;

use super::report::{measured_ns, position_deg};
use super::static_data::named;

/// A base station, or an aid to navigation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedStation {
    /// MMSI, and the name of an aid to navigation.
    pub identity: Identity,
    /// Base station or aid.
    pub category: TargetCategory,
    /// Kind of the aid, 0 to 31, as numbered by the recommendation; 0 of a base station.
    pub aid_type: u8,
    /// The aid is not there: a station ashore sends for it.
    pub is_virtual: bool,
    /// The aid, which floats, is off its position.
    pub is_off_position: bool,
    /// Latitude and longitude, radians.
    pub position_rad: [f64; 2],
    /// Time of the report, nanoseconds since midnight UTC.
    pub time_of_day_ns: i64,
}

impl FixedStation {
    /// The station of a message received at `received_ns`; `None` without a position.
    pub(super) fn base(station: &BaseStationReport, received_ns: i64) -> Option<Self> {
        let position_deg = position_deg([station.latitude.raw(), station.longitude.raw()], 600_000)?;
        Some(Self {
            identity: Identity::default().with_mmsi(station.mmsi.raw()),
            category: TargetCategory::BaseStation,
            aid_type: 0,
            is_virtual: false,
            is_off_position: false,
            position_rad: position_deg.map(f64::to_radians),
            time_of_day_ns: received_ns.rem_euclid(NS_PER_DAY),
        })
    }

    /// The aid of a message received at `received_ns`; `None` without a position.
    pub(super) fn aid(aid: &AidToNavigationReport, received_ns: i64) -> Option<Self> {
        let position_deg = position_deg([aid.latitude.raw(), aid.longitude.raw()], 600_000)?;
        Some(Self {
            identity: named(Identity::default().with_mmsi(aid.mmsi.raw()), aid.name.as_str(), ""),
            category: TargetCategory::Aid,
            aid_type: aid.aid_type,
            is_virtual: aid.virtual_aid,
            // The flag counts only where the second of a measured position is stated.
            is_off_position: aid.off_position && matches!(aid.timestamp, Timestamp::Second(_)),
            position_rad: position_deg.map(f64::to_radians),
            time_of_day_ns: measured_ns(aid.timestamp, received_ns).rem_euclid(NS_PER_DAY),
        })
    }
}

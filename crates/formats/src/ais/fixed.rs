//! Stations that are no targets: base stations, aids to navigation.
//!
//! A base station sends its place every 10 s, an aid every three minutes. They are never followed: what they send are
//! statements, without observations. A name has up to 34 characters with its extension, of which the first
//! [`NAME_MAX`] are kept.

use aivdm::Timestamp;
use aivdm::message::{AidToNavigationReport, BaseStationReport};
use messages::{AidKind, NAME_MAX};
use observations::{FixedStation, Statement, TargetCategory};

use super::report::position_deg;
use super::static_data::{Hull, unpadded};

/// The statement of a base station's message; `None` without a position.
pub(super) fn base(station: &BaseStationReport) -> Option<Statement> {
    let position_deg = position_deg([station.latitude.raw(), station.longitude.raw()], 600_000)?;
    Some(Statement {
        track_number: station.mmsi.raw(),
        category: TargetCategory::BaseStation,
        station: Some(FixedStation {
            place_rad: position_deg.map(f64::to_radians),
            name: [b' '; NAME_MAX],
            aid: AidKind::Unknown,
            is_virtual: false,
            is_off_position: false,
        }),
        ..Statement::default()
    })
}

/// The statement of an aid's message; `None` without a position.
pub(super) fn aid(aid: &AidToNavigationReport) -> Option<Statement> {
    let position_deg = position_deg([aid.latitude.raw(), aid.longitude.raw()], 600_000)?;
    let distances = [
        aid.dimension_to_bow,
        aid.dimension_to_stern,
        aid.dimension_to_port.into(),
        aid.dimension_to_starboard.into(),
    ];
    let mut name = [b' '; NAME_MAX];
    name.iter_mut()
        .zip(unpadded(aid.name.as_str()).bytes())
        .for_each(|(place, octet)| *place = octet);
    Some(Statement {
        track_number: aid.mmsi.raw(),
        category: TargetCategory::Aid,
        size_m: Hull::of(distances).map(|hull| hull.size_m),
        station: Some(FixedStation {
            place_rad: position_deg.map(f64::to_radians),
            name,
            aid: AidKind::from_code(aid.aid_type).unwrap_or_default(),
            is_virtual: aid.virtual_aid,
            // The flag counts only where the second of a measured position is stated.
            is_off_position: aid.off_position && matches!(aid.timestamp, Timestamp::Second(_)),
        }),
        ..Statement::default()
    })
}

//! Statements of targets and of fixed stations beside motion, as CSV rows.

use messages::{AidKind, Emergency, NavigationStatus, TargetCategory, TargetStatement, target_statement_bits as bits};

use crate::cells::{Plain, SensorId, Time};
use crate::columns::columns;
use crate::parts::words;

columns! {
    TargetStatement: |row|
    "time_s" => Time(row.time_ns),
    "sensor_id" => SensorId(row.source),
    "sensor_track_id" => row.track_number,
    "category" => TargetCategory::from_code(row.category).map(TargetCategory::word),
    "navigation" => NavigationStatus::from_code(row.navigation).map(NavigationStatus::word),
    "emergency" => Emergency::from_code(row.emergency).map(Emergency::word),
    ["length_m", "width_m"] => [row.length_m, row.width_m].map(|size| known(row, bits::SIZE, size, 1)),
    "selected_altitude_m" => known(row, bits::SELECTED_ALTITUDE, row.selected_altitude_m, 1),
    ["operator_latitude", "operator_longitude"] =>
        row.place_deg.map(|degrees| (row.valid & bits::OPERATOR != 0).then_some(Plain(degrees, 7))),
    ["station_latitude", "station_longitude"] =>
        row.place_deg.map(|degrees| row.is_station().then_some(Plain(degrees, 7))),
    "station_name" => row.station_name().map(words),
    "aid" => AidKind::from_code(row.aid).map(AidKind::word).filter(|_| row.is_station()),
    ["virtual", "off_position"] =>
        [bits::VIRTUAL, bits::OFF_POSITION].map(|bit| row.is_station().then_some(u8::from(row.valid & bit != 0))),
}

/// A value if the row holds it.
fn known(row: &TargetStatement, bit: u8, value: f32, decimals: usize) -> Option<Plain> {
    (row.valid & bit != 0).then_some(Plain(f64::from(value), decimals))
}

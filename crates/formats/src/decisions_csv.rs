//! Decisions of fusion as CSV rows (BF-4), in the order in which they were made.
//!
//! Times are rounded to milliseconds, for human readers. Unused columns of a decision are empty. `value` and `limit`
//! are the compared values; their meaning depends on the kind ([`messages::DecisionKind`]).

use messages::{Decision, DecisionKind};

use crate::cells::{Rounded, RoundedTime, SensorId};
use crate::columns::columns;

/// Writes decisions.
pub type DecisionWriter<W> = crate::rows::RowWriter<Decision, W>;

columns! {
    Decision: |row|
    "time_s" => RoundedTime(row.time_ns),
    "decision" => row.kind().map(DecisionKind::word),
    "system_track_id" => numbered(row.system_track),
    "other_system_track_id" => numbered(row.other_system_track),
    "sensor_id" => SensorId::known(row.source),
    "other_sensor_id" => SensorId::known(row.other_source),
    "sensor_track_id" => numbered(row.sensor_track),
    "value" => Rounded::known(row.value, 4),
    "limit" => Rounded::known(row.limit, 4),
}

fn numbered(track: u32) -> Option<u32> {
    Some(track).filter(|track| *track != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_leaves_empty_what_a_decision_does_not_speak_of() {
        let joined = Decision {
            time_ns: 90_500_000_000,
            kind: DecisionKind::Joined.code(),
            system_track: 7,
            source: 0,
            sensor_track: 12,
            value: 3.25,
            limit: 16.0,
            ..Decision::default()
        };
        let ended = Decision {
            kind: DecisionKind::Ended.code(),
            system_track: 7,
            ..Decision::default()
        };
        let mut writer = DecisionWriter::begin(Vec::new(), 0).unwrap();
        writer.write(&joined).unwrap();
        writer.write(&ended).unwrap();
        let text = String::from_utf8(writer.into_inner()).unwrap();
        let rows: Vec<&str> = text.lines().skip(1).collect();
        assert_eq!(rows, ["90.500,joined,7,,1,,12,3.2500,16.0000", "0.000,ended,7,,,,,,"]);
    }
}

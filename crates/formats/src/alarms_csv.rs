//! Alarms as CSV rows: a row when an alarm is raised, and a row when it is cleared.
//!
//! `time_s` is the time of the event, `raised_s` that at which the alarm was raised; `sensor_id` and `partner_id` are
//! the sources concerned and `process` the process, empty where there is none. `utc` is `time_s` as date and time of
//! day (ISO 8601, milliseconds); it is the last column, since readers knew the others before.

use messages::{Alarm, AlarmEvent, AlarmSeverity};

use crate::cells::{Quoted, SensorId, Time};
use crate::columns::columns;
use crate::rows::Milliseconds;

/// Event of an alarm.
#[derive(Clone, Copy, Debug)]
pub struct AlarmRow {
    /// Word for the kind of the alarm.
    pub word: &'static str,
    /// Event of the row.
    pub event: AlarmEvent,
    /// The alarm.
    pub alarm: Alarm,
}

columns! {
    AlarmRow: |row|
    "time_s" => Time(row.alarm.time_ns),
    "raised_s" => Time(row.alarm.raised_ns),
    "event" => row.event.word(),
    "alarm" => row.word,
    "severity" => row.alarm.severity().map(AlarmSeverity::word),
    "sensor_id" => SensorId::known(row.alarm.source),
    "partner_id" => SensorId::known(row.alarm.partner),
    "process" => row.alarm.process(),
    // Sentences have commas.
    "text" => Quoted(row.alarm.text()),
    "utc" => Milliseconds(row.alarm.time_ns),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::RowWriter;

    #[test]
    fn a_row_tells_what_happened_when_to_whom() {
        let alarm = Alarm {
            time_ns: 90_500_000_000,
            raised_ns: 60_000_000_000,
            severity: AlarmSeverity::Major.code(),
            source: 2,
            ..Alarm::default()
        };
        let row = AlarmRow {
            word: "source-silent",
            event: AlarmEvent::Cleared,
            alarm: alarm.with_text("\"a\" has sent nothing for 24 s, 6 of its periods."),
        };
        let mut writer = RowWriter::begin(Vec::new(), 0).unwrap();
        writer.write(&row).unwrap();
        let text = String::from_utf8(writer.into_inner()).unwrap();
        assert_eq!(
            text.lines().nth(1).unwrap(),
            "90.5,60,cleared,source-silent,major,3,,,\"\"\"a\"\" has sent nothing for 24 s, 6 of its periods.\",\
             1970-01-01T00:01:30.500Z"
        );
    }
}

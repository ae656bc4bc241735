//! Alarms as CSV rows: one when an alarm is raised, one when it is cleared.
//!
//! `time_s` is the time of the event, `raised_s` that at which the alarm was raised; `sensor_id` and `partner_id` are
//! the sources concerned and `process` the process, empty where there is none.

use std::io::{self, Write};

use messages::{Alarm, AlarmEvent, AlarmSeverity, NO_SOURCE};

use crate::rows::{Reference, Row};

/// Event of an alarm.
#[derive(Clone, Copy, Debug)]
pub struct AlarmRow {
    /// Word for the kind of the alarm.
    pub word: &'static str,
    /// Event that the row tells.
    pub event: AlarmEvent,
    /// The alarm.
    pub alarm: Alarm,
}

impl Row for AlarmRow {
    fn columns() -> String {
        "time_s,raised_s,event,alarm,severity,sensor_id,partner_id,process,text".to_owned()
    }

    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        let Self { word, event, alarm } = self;
        reference.write_time(out, alarm.time_ns)?;
        write!(out, ",")?;
        reference.write_time(out, alarm.raised_ns)?;
        let severity = alarm.severity().map_or("", AlarmSeverity::word);
        write!(out, ",{},{word},{severity}", event.word())?;
        for source in [alarm.source, alarm.partner] {
            write!(out, ",")?;
            if source != NO_SOURCE {
                write!(out, "{}", reference.sensor_id(source))?;
            }
        }
        // Sentences have commas.
        write!(out, ",{},\"{}\"", alarm.process(), alarm.text().replace('"', "\"\""))
    }
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
            "90.5,60,cleared,source-silent,major,3,,,\"\"\"a\"\" has sent nothing for 24 s, 6 of its periods.\""
        );
    }
}

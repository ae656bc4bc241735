//! Alerts on targets as CSV rows: a row when an alert is raised, and a row when it is cleared.
//!
//! `time_s` is the reference time of the state that raised or cleared the alert, `raised_s` that which raised it.
//! `alert` is its number, `rule` and `kind` are those of the configuration. The second target, the area, and distances
//! are empty where there are none; `time_to_s` is empty once the event has happened.

use messages::{AlarmEvent, AlarmSeverity, Alert, AlertKind, alert_value_bits};

use crate::cells::{Quoted, Rounded, Time};
use crate::columns::columns;
use crate::rows::Milliseconds;

/// Change of an alert.
#[derive(Clone, Copy, Debug)]
pub struct AlertRow(pub Alert);

impl AlertRow {
    /// The row of a change; `None` of an alert that stands as before.
    pub fn of(alert: &Alert) -> Option<Self> {
        let event = alert.event().filter(|event| *event != AlarmEvent::Standing);
        event.map(|_| Self(*alert))
    }

    fn known(&self, bit: u16, value: f32) -> Option<Rounded> {
        self.0.has(bit).then(|| Rounded(f64::from(value), 3))
    }
}

columns! {
    AlertRow: |row|
    "time_s" => Time(row.0.time_ns),
    "raised_s" => Time(row.0.raised_ns),
    "event" => row.0.event().map(AlarmEvent::word),
    "alert" => row.0.number,
    "rule" => Quoted(row.0.rule()),
    "kind" => row.0.kind().map(AlertKind::word),
    "severity" => row.0.severity().map(AlarmSeverity::word),
    "system_track_id" => row.0.tracks[0],
    "other_system_track_id" => (row.0.tracks[1] != 0).then_some(row.0.tracks[1]),
    "area" => (!row.0.area().is_empty()).then(|| Quoted(row.0.area())),
    "probability" => Rounded(f64::from(row.0.probability), 4),
    "time_to_s" => row.known(alert_value_bits::PREDICTED, row.0.time_to_s),
    "distance_m" => row.known(alert_value_bits::DISTANCE, row.0.distance_m),
    "least_distance_m" => row.known(alert_value_bits::DISTANCE, row.0.least_distance_m),
    "vertical_m" => row.known(alert_value_bits::VERTICAL, row.0.vertical_m),
    "least_vertical_m" => row.known(alert_value_bits::VERTICAL, row.0.least_vertical_m),
    // Sentences have commas.
    "text" => Quoted(row.0.text()),
    "utc" => Milliseconds(row.0.time_ns),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::RowWriter;

    #[test]
    fn a_row_states_the_pair_and_what_is_ahead() {
        let alert = Alert {
            time_ns: 90_500_000_000,
            raised_ns: 90_500_000_000,
            number: 3,
            tracks: [7, 12],
            probability: 0.75,
            time_to_s: 61.25,
            distance_m: 30_000.0,
            least_distance_m: 4_000.0,
            valid: alert_value_bits::PREDICTED | alert_value_bits::DISTANCE,
            kind: AlertKind::Approach.code(),
            event: AlarmEvent::Raised.code(),
            severity: AlarmSeverity::Critical.code(),
            ..Alert::default()
        };
        let mut writer = RowWriter::begin(Vec::new(), 0).unwrap();
        let row = AlertRow::of(&alert.with_texts("near", "", "A and B, too close")).unwrap();
        writer.write(&row).unwrap();
        let text = String::from_utf8(writer.into_inner()).unwrap();
        assert_eq!(
            text.lines().nth(1).unwrap(),
            "90.5,90.5,raised,3,\"near\",approach,critical,7,12,,0.7500,61.250,30000.000,4000.000,,,\"A and B, too close\",\
             1970-01-01T00:01:30.500Z"
        );
        let standing = Alert {
            event: AlarmEvent::Standing.code(),
            ..alert
        };
        assert!(AlertRow::of(&standing).is_none());
    }
}

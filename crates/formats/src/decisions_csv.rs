//! Decisions of fusion as CSV rows (BF-4), in the order in which they were made.
//!
//! Times are rounded to milliseconds: people read this table. What a decision does not speak of is empty. `value` and
//! `limit` are what was compared; what they are is said with each kind ([`messages::DecisionKind`]).

use std::io::{self, Write};

use messages::{Decision, DecisionKind, NO_SOURCE};

use crate::rows::{Reference, Row};

/// Writes decisions.
pub type DecisionWriter<W> = crate::rows::RowWriter<Decision, W>;

impl Row for Decision {
    fn columns() -> String {
        "time_s,decision,system_track_id,other_system_track_id,sensor_id,other_sensor_id,sensor_track_id,value,limit"
            .to_owned()
    }

    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        let time_s = frames::time::seconds(reference.since_first_day_ns(self.time_ns));
        write!(out, "{time_s:.3},{}", self.kind().map_or("", DecisionKind::word))?;
        let write_number = |out: &mut dyn Write, number: Option<u32>| match number {
            Some(number) => write!(out, ",{number}"),
            None => write!(out, ","),
        };
        let numbered = |number: u32| Some(number).filter(|number| *number != 0);
        let sensor = |source: u16| (source != NO_SOURCE).then(|| reference.sensor_id(source));
        for number in [
            numbered(self.system_track),
            numbered(self.other_system_track),
            sensor(self.source),
            sensor(self.other_source),
            numbered(self.sensor_track),
        ] {
            write_number(out, number)?;
        }
        for figure in [self.value, self.limit] {
            match figure.is_nan() {
                true => write!(out, ",")?,
                false => write!(out, ",{figure:.4}")?,
            }
        }
        Ok(())
    }
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

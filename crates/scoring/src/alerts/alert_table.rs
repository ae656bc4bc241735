//! Tables of alerts: a row for each raising, clearing or prediction.

use std::collections::BTreeMap;
use std::io::Read;

use csv_table::{Cells, Column, CsvError, Table};

use super::{ALERT_KINDS, ENTER};
use crate::basis::FileBasis;

/// What an alert or a prediction is about.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stated {
    pub(super) kind: &'static str,
    pub(super) track: i64,
    pub(super) other: Option<i64>,
    pub(super) area: Option<String>,
    pub(super) time_s: f64,
}

/// An alert.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RaisedAlert {
    pub(super) number: u64,
    pub(super) stated: Stated,
    /// `None`: it was in force to the end.
    pub(super) cleared_s: Option<f64>,
}

/// Probability of a violation within a horizon.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Prediction {
    pub(super) stated: Stated,
    pub(super) probability: f64,
    /// Seconds; `None`: the look-ahead.
    pub(super) horizon_s: Option<f64>,
}

/// Alerts of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AlertTable {
    /// In the order of raising.
    pub(super) alerts: Vec<RaisedAlert>,
    pub(super) predictions: Vec<Prediction>,
    pub(super) cleared_without_raised: u64,
}

struct AlertColumns {
    time: Column,
    event: Column,
    number: Option<Column>,
    kind: Column,
    track: Column,
    other: Option<Column>,
    area: Option<Column>,
    probability: Option<Column>,
    horizon: Option<Column>,
}

impl AlertTable {
    /// Reads `time_s,event,alert,kind,system_track_id[,other_system_track_id,area,probability,horizon_s]` by name, in
    /// the order of time; other columns are ignored. `time_s` counts as the times of the tracks do
    /// ([`crate::Timeline::basis`]).
    ///
    /// `event` is `raised`, `cleared` or `predicted`. A row `predicted` has the `probability` (0 to 1) of a violation
    /// within `horizon_s` seconds, and needs no number of an alert.
    ///
    /// # Errors
    /// If a column is missing, a value is invalid for its column, an alert is raised while it is in force, or the input
    /// fails.
    pub fn read(mut basis: FileBasis, input: impl Read) -> Result<Self, CsvError> {
        let mut table = Table::new(input)?;
        let columns = AlertColumns {
            time: table.required("time_s")?,
            event: table.required("event")?,
            number: table.spelled("alert")?,
            kind: table.required("kind")?,
            track: table.required("system_track_id")?,
            other: table.spelled("other_system_track_id")?,
            area: table.spelled("area")?,
            probability: table.spelled("probability")?,
            horizon: table.spelled("horizon_s")?,
        };
        let number = columns.number.ok_or_else(|| table.missing("alert"))?;
        let mut read = Self::default();
        // Places of the alerts in force.
        let mut in_force: BTreeMap<u64, usize> = BTreeMap::new();
        while let Some(row) = table.next_row() {
            let row = row?;
            let time_s = basis.time_s(row, columns.time)?;
            match row.text(columns.event)?.unwrap_or_default() {
                "raised" => {
                    let alert = RaisedAlert {
                        number: row.whole(number)?,
                        stated: columns.stated(row, time_s)?,
                        cleared_s: None,
                    };
                    if in_force.insert(alert.number, read.alerts.len()).is_some() {
                        return Err(row.error(number, "is raised while it is in force; write its row `cleared` before"));
                    }
                    read.alerts.push(alert);
                }
                "cleared" => match in_force.remove(&row.whole(number)?) {
                    Some(place) => read.alerts[place].cleared_s = Some(time_s),
                    None => read.cleared_without_raised += 1,
                },
                "predicted" => {
                    let (probability, horizon_s) = columns.prediction(row)?;
                    read.predictions.push(Prediction {
                        stated: columns.stated(row, time_s)?,
                        probability,
                        horizon_s,
                    });
                }
                _ => return Err(row.error(columns.event, "is no event; write raised, cleared or predicted")),
            }
        }
        Ok(read)
    }

    /// Names of areas in the table that are none of `known`.
    pub fn unknown_areas(&self, known: &[areas::Area]) -> Vec<&str> {
        let alerts = self.alerts.iter().map(|alert| &alert.stated);
        let all = alerts.chain(self.predictions.iter().map(|prediction| &prediction.stated));
        let named = all
            .filter(|stated| stated.kind == ENTER)
            .filter_map(|stated| stated.area.as_deref());
        let mut unknown: Vec<&str> = named
            .filter(|name| known.iter().all(|area| area.name != *name))
            .collect();
        unknown.sort_unstable();
        unknown.dedup();
        unknown
    }
}

impl AlertColumns {
    fn stated(&self, row: Cells<'_>, time_s: f64) -> Result<Stated, CsvError> {
        let word = row.text(self.kind)?.unwrap_or_default();
        let kind = ALERT_KINDS.into_iter().find(|kind| *kind == word);
        let other = match row.text(self.other)? {
            Some(_) => self.other.map(|column| row.whole(column)).transpose()?,
            None => None,
        };
        Ok(Stated {
            kind: kind.ok_or_else(|| row.error(self.kind, format!("is no kind; write {}", ALERT_KINDS.join(", "))))?,
            track: row.whole(self.track)?,
            other,
            area: row.text(self.area)?.map(str::to_owned),
            time_s,
        })
    }

    fn prediction(&self, row: Cells<'_>) -> Result<(f64, Option<f64>), CsvError> {
        let probability = match self.probability {
            Some(column) => (column, row.number(column)?),
            None => return Err(row.error(self.event, "needs the column probability")),
        };
        if !(0.0..=1.0).contains(&probability.1) {
            return Err(row.error(probability.0, "is no probability; write one from 0 to 1"));
        }
        let horizon_s = row.number_or_empty(self.horizon)?;
        if let (Some(column), Some(..0.0)) = (self.horizon, horizon_s) {
            return Err(row.error(column, "is negative; write the seconds of the prediction"));
        }
        Ok((probability.1, horizon_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(rows: &str) -> Result<AlertTable, String> {
        let text = format!(
            "time_s,event,alert,rule,kind,system_track_id,other_system_track_id,area,probability,time_to_s,horizon_s\n{rows}"
        );
        AlertTable::read(FileBasis::default(), text.as_bytes()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_number_may_come_again_after_its_clearing() {
        let rows = "1,raised,7,a,conflict,3,4,,0.5,90,\n2,cleared,7,a,conflict,3,4,,,,\n2,cleared,8,a,conflict,3,4,,,,\n\
                    3,raised,7,a,enter,3,,Zone,,,\n3,predicted,,a,conflict,3,4,,0.25,,60\n";
        let table = read(rows).unwrap();
        assert_eq!((table.alerts.len(), table.cleared_without_raised), (2, 1));
        assert_eq!([0, 1].map(|place| table.alerts[place].cleared_s), [Some(2.0), None]);
        assert_eq!(table.alerts[0].stated.other, Some(4));
        assert_eq!(table.alerts[1].stated.area.as_deref(), Some("Zone"));
        assert_eq!(table.unknown_areas(&[]), ["Zone"]);
        assert_eq!(
            (table.predictions[0].probability, table.predictions[0].horizon_s),
            (0.25, Some(60.0))
        );
    }

    #[test]
    fn what_is_no_alert_is_refused_with_line_value_and_remedy() {
        for (rows, expected) in [
            ("1,raised,7,a,conflct,3,4,,,,\n", "is no kind; write enter, leave"),
            (
                "1,begun,7,a,conflict,3,4,,,,\n",
                "is no event; write raised, cleared or predicted",
            ),
            (
                "1,raised,7,a,enter,3,,,,,\n2,raised,7,a,enter,3,,,,,\n",
                "is raised while it is in force",
            ),
            (
                "1,predicted,,a,conflict,3,4,,1.5,,60\n",
                "is no probability; write one from 0 to 1",
            ),
            ("1,predicted,,a,conflict,3,4,,0.5,,-1\n", "is negative"),
            ("1,raised,,a,conflict,3,4,,,,\n", "is no whole number"),
        ] {
            let fault = read(rows).unwrap_err();
            assert!(fault.contains(expected) && fault.contains("line"), "{fault}");
        }
    }
}

//! Velocity of a designated target, as columns of a detection: `vx`, `vy` (east and north, m/s) and `v_sigma` (standard
//! deviation of each, m/s).
//!
//! A table has all three columns or none, and a row all three values or none. Only designations make use of them, so
//! tables of detections are written without these columns.

use std::io::Read;

use csv_table::{Cells, Column, CsvError, Table};
use observations::StatedVelocity;

use crate::columns::ColumnPlace as _;
use crate::platform_states_csv::together;

/// Places of the columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VelocityPlaces(Option<[Column; 3]>);

impl VelocityPlaces {
    /// Finds the columns in the header of a table.
    ///
    /// # Errors
    /// If one is there without the others.
    pub(crate) fn find<R: Read>(table: &Table<R>) -> Result<Self, CsvError> {
        Option::find(table, ["vx", "vy", "v_sigma"]).map(Self)
    }

    /// The velocity in a row.
    ///
    /// # Errors
    /// Some of the values without the others, or a standard deviation that is none.
    pub(crate) fn read(&self, row: Cells<'_>) -> Result<Option<StatedVelocity>, CsvError> {
        let (Some([.., column]), Some([east, north, sigma_mps])) = (self.0, together(row, self.0)?) else {
            return Ok(None);
        };
        if sigma_mps <= 0.0 {
            return Err(row.error(column, "must be greater than 0; a standard deviation is"));
        }
        Ok(Some(StatedVelocity {
            velocity_mps: [east as f32, north as f32],
            sigma_mps,
        }))
    }
}

#[cfg(test)]
mod tests {
    use observations::StatedVelocity;

    use crate::detections_csv::DetectionReader;

    fn velocity(values: &str) -> Result<Option<StatedVelocity>, String> {
        let header = "time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz,vx,vy,v_sigma";
        let text = format!("{header}\n1,1,1,1,position2,5,6,,,9,9,,,0,0,0,{values}\n");
        let mut reader = DetectionReader::new(text.as_bytes(), 0).unwrap();
        let row = reader.next().unwrap();
        row.map(|found| found.velocity).map_err(|error| error.to_string())
    }

    #[test]
    fn a_row_states_the_whole_velocity_or_none() {
        let stated = StatedVelocity {
            velocity_mps: [-3.5, 8.0],
            sigma_mps: 2.0,
        };
        assert_eq!(velocity("-3.5,8,2"), Ok(Some(stated)));
        assert_eq!(velocity(",,"), Ok(None));
        assert!(velocity("1,2,").unwrap_err().contains("give all or none"));
        assert!(velocity("1,2,0").unwrap_err().contains("greater than 0"));
    }
}

//! Motion and attitude of a moving platform, as columns behind those of a detection (FM-6).
//!
//! | column | value |
//! | --- | --- |
//! | `pvx`, `pvy`, `pvz` | velocity of the platform east, north, up, m/s |
//! | `p_heading_rad`, `p_pitch_rad`, `p_roll_rad` | attitude: clockwise from north, nose up, right side down |
//! | `p_sigma_m` | standard deviation of each coordinate of the position |
//! | `p_heading_sigma_rad`, `p_pitch_sigma_rad`, `p_roll_sigma_rad` | standard deviations of the attitude |
//!
//! Every column may be absent and every value empty; of velocity and attitude, all three values are given or none.

use csv_table::{Cells, Column, CsvError};
use observations::DetectionPlatform;

use crate::columns::columns;
use crate::platform_states_csv::{positive, together};

/// A platform's values, written as a part of a row.
pub(crate) struct OnBoardRow<'a>(pub(crate) &'a DetectionPlatform);

columns! {
    /// Places of the columns of a platform's values.
    OnBoardPlaces of OnBoardRow<'_>: |row|
    velocity: Option<[Column; 3]> = ["pvx", "pvy", "pvz"] => each(row.0.velocity_mps),
    attitude: Option<[Column; 3]> = ["p_heading_rad", "p_pitch_rad", "p_roll_rad"] => each(row.0.attitude_rad),
    sigma: Option<Column> = "p_sigma_m" => row.0.sigma_m,
    attitude_sigmas: Option<[Column; 3]> = ["p_heading_sigma_rad", "p_pitch_sigma_rad", "p_roll_sigma_rad"] =>
        row.0.attitude_sigmas_rad.map(|sigma| (sigma > 0.0).then_some(sigma)),
}

fn each(values: Option<[f32; 3]>) -> [Option<f32>; 3] {
    std::array::from_fn(|place| values.map(|values| values[place]))
}

impl OnBoardPlaces {
    /// The platform's values of a row.
    ///
    /// # Errors
    /// A value that no platform has, or some of three values without the others.
    pub(crate) fn read(&self, row: Cells<'_>) -> Result<DetectionPlatform, CsvError> {
        let mut attitude_sigmas_rad = [0.0; 3];
        if let Some(columns) = self.attitude_sigmas {
            for (sigma, column) in attitude_sigmas_rad.iter_mut().zip(columns) {
                *sigma = positive(row, column)?.unwrap_or_default() as f32;
            }
        }
        let three = |columns| -> Result<Option<[f32; 3]>, CsvError> {
            Ok(together(row, columns)?.map(|values| values.map(|value| value as f32)))
        };
        let sigma_m = self.sigma.map_or(Ok(None), |column| positive(row, column))?;
        Ok(DetectionPlatform {
            velocity_mps: three(self.velocity)?,
            attitude_rad: three(self.attitude)?,
            sigma_m: sigma_m.map(|sigma| sigma as f32),
            attitude_sigmas_rad,
        })
    }
}

#[cfg(test)]
mod tests {
    use observations::Detection;

    use super::*;
    use crate::detections_csv::{DetectionReader, OnBoardDetection, OnBoardDetectionWriter};

    const HEADER: &str = "time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz";
    const ROW: &str = "1,1,1,1,bearing,0.5,,,,0.01,,,,0,0,0";

    fn read(text: &str) -> Result<Detection, String> {
        let mut reader = DetectionReader::new(text.as_bytes(), 0).map_err(|error| error.to_string())?;
        reader.next().unwrap().map_err(|error| error.to_string())
    }

    #[test]
    fn a_row_without_the_columns_has_no_platform() {
        let found = read(&format!("{HEADER}\n{ROW}\n")).unwrap();
        assert_eq!(found.platform, DetectionPlatform::default());
    }

    #[test]
    fn what_is_written_is_read_again_exactly() {
        let plain = read(&format!("{HEADER}\n{ROW}\n")).unwrap();
        let platforms = [
            DetectionPlatform::default(),
            DetectionPlatform {
                velocity_mps: Some([0.1, -7.25, 0.0]),
                attitude_rad: Some([6.2, -0.05, 0.17]),
                sigma_m: Some(2.5),
                attitude_sigmas_rad: [0.005, 0.005, 0.0],
            },
        ];
        for platform in platforms {
            let detection = Detection { platform, ..plain };
            let mut writer = OnBoardDetectionWriter::begin(Vec::new(), 0).unwrap();
            writer.write(&OnBoardDetection(detection)).unwrap();
            let text = String::from_utf8(writer.into_inner()).unwrap();
            assert_eq!(read(&text).unwrap(), detection);
        }
    }

    #[test]
    fn half_of_an_attitude_is_refused_with_its_place() {
        let columns = "p_heading_rad,p_pitch_rad,p_roll_rad,p_sigma_m";
        let error = read(&format!("{HEADER},{columns}\n{ROW},1,,0.1,\n")).unwrap_err();
        assert!(
            error.contains("line 2, column p_pitch_rad: \"\" is empty where others"),
            "{error}"
        );
        let error = read(&format!("{HEADER},{columns}\n{ROW},,,,0\n")).unwrap_err();
        assert!(
            error.contains("column p_sigma_m: \"0\" must be greater than 0"),
            "{error}"
        );
    }
}

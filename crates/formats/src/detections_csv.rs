//! Detections as CSV rows (FM-6).
//!
//! The measured values are in `m0`, `m1`, `m2` in the order of their kind, the range rate is in `m3`, and their
//! standard deviations are in the `s` columns with the same numbers. Values not measured by a kind must be empty: a
//! value there indicates mixed-up columns. A row states all of its standard deviations or none. The values that the
//! target's transponder stated follow in optional columns (`replies`), and so do those of a moving platform
//! (`on_board`), and the velocity of a designated target (`designated_velocity`).

use std::io::{self, Read, Write};

use csv_table::{Cells, Column, CsvError, Table};
use observations::{Detection, DetectionKind, DetectionTruth, QUANTITIES_MAX};

use crate::cells::{Cell, Time};
use crate::columns::columns;
use crate::designated_velocity::VelocityPlaces;
use crate::on_board::{OnBoardPlaces, OnBoardRow};
use crate::replies::{ReplyPlaces, ReplyRow};
use crate::rows::{Columns, Reference, Row, RowReader, RowWriter};
use crate::time_base::TimeBase;

/// Place of the range rate among the columns of measured values.
const RANGE_RATE: usize = QUANTITIES_MAX;

/// Reads detections.
pub type DetectionReader<R> = RowReader<R, DetectionColumns>;
/// Writer of detections without the values of transponders. Values read back are equal to the last bit.
pub type DetectionWriter<W> = RowWriter<Detection, W>;
/// Writer of detections with the values of transponders.
pub type RepliedDetectionWriter<W> = RowWriter<RepliedDetection, W>;

/// Writer of detections with the motion and attitude of their platform.
pub type OnBoardDetectionWriter<W> = RowWriter<OnBoardDetection, W>;

/// Detection with the motion and attitude of its platform in columns behind the others.
#[derive(Clone, Copy, Debug)]
pub struct OnBoardDetection(pub Detection);

impl Row for OnBoardDetection {
    fn columns() -> String {
        [Detection::columns(), OnBoardRow::columns()].join(",")
    }

    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        self.0.write(out, reference)?;
        out.write_all(b",")?;
        OnBoardRow(&self.0.platform).write(out, reference)
    }
}

/// Detection with the values of the target's transponder in columns behind the others.
#[derive(Clone, Copy, Debug)]
pub struct RepliedDetection(pub Detection);

impl Row for RepliedDetection {
    fn columns() -> String {
        [Detection::columns(), ReplyRow::columns()].join(",")
    }

    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        self.0.write(out, reference)?;
        out.write_all(b",")?;
        ReplyRow(&self.0.reply).write(out, reference)
    }
}

columns! {
    /// Places of the columns of detections.
    DetectionPlaces of Detection: |row|
    time: Column = "time_s" => Time(row.time_of_measurement_ns),
    sensor: Column = "sensor_id" => row.sensor_id,
    scan: Column = "scan" => row.scan,
    number: Column = "detection_id" => row.detection_id,
    kind: Column = "kind" => row.kind.word(),
    values: [Column; QUANTITIES_MAX + 1] = ["m0", "m1", "m2", "m3"] => measured(row),
    sigmas: [Column; QUANTITIES_MAX + 1] = ["s0", "s1", "s2", "s3"] => deviations(row),
    platform: [Column; 3] = ["px", "py", "pz"] => row.platform_m,
    truth: Option<Column> = "truth_id" => row.truth,
}

/// Columns of detections.
#[derive(Debug)]
pub struct DetectionColumns {
    pub(crate) base: TimeBase,
    at: DetectionPlaces,
    on_board: OnBoardPlaces,
    velocity: VelocityPlaces,
    reply: ReplyPlaces,
}

impl<R: Read> DetectionReader<R> {
    /// Reads the header line. Times of rows count from `first_day_ns` (UTC, nanoseconds), or from 1970.
    ///
    /// # Errors
    /// [`CsvError`] if a column is missing or the input fails.
    pub fn new(input: R, first_day_ns: i64) -> Result<Self, CsvError> {
        let table = Table::new(input)?;
        let columns = DetectionColumns::find(&table, first_day_ns)?;
        Ok(Self { table, columns })
    }
}

impl Columns for DetectionColumns {
    type Value = Detection;

    fn read(&mut self, row: Cells<'_>) -> Result<Detection, CsvError> {
        let time_of_measurement_ns = self.base.utc_ns(row, self.at.time)?;
        let kind = self.kind(row)?;
        let values = self.values(row, kind)?;
        let range_rate_mps = row.number_or_empty(self.at.values[RANGE_RATE])?;
        let platform_m = row.numbers(self.at.platform)?;
        Ok(Detection {
            time_of_measurement_ns,
            sensor_id: row.whole(self.at.sensor)?,
            scan: row.whole(self.at.scan)?,
            detection_id: row.whole(self.at.number)?,
            kind,
            values,
            range_rate_mps,
            sigmas: self.sigmas(row, kind, range_rate_mps.is_some())?,
            platform_m,
            platform: self.on_board.read(row)?,
            height: None,
            velocity: self.velocity.read(row)?,
            reply: self.reply.read(row)?,
            truth: self.truth(row)?,
        })
    }
}

impl DetectionColumns {
    /// Finds the columns in a header.
    pub(crate) fn find<R: Read>(table: &Table<R>, first_day_ns: i64) -> Result<Self, CsvError> {
        Ok(Self {
            base: TimeBase::new(first_day_ns),
            at: DetectionPlaces::find(table)?,
            on_board: OnBoardPlaces::find(table)?,
            velocity: VelocityPlaces::find(table)?,
            reply: ReplyPlaces::find(table)?,
        })
    }

    fn kind(&self, row: Cells<'_>) -> Result<DetectionKind, CsvError> {
        let word = row.text(self.at.kind)?.unwrap_or_default();
        DetectionKind::from_word(word).ok_or_else(|| {
            let words = DetectionKind::ALL.map(DetectionKind::word).join(", ");
            row.error(self.at.kind, format!("is no kind of detection; write one of {words}"))
        })
    }

    fn values(&self, row: Cells<'_>, kind: DetectionKind) -> Result<[f64; QUANTITIES_MAX], CsvError> {
        let mut values = [0.0; QUANTITIES_MAX];
        let quantities = kind.quantities();
        for ((value, quantity), column) in values.iter_mut().zip(quantities).zip(self.at.values) {
            *value = row.number(column)?;
            if let Some(fault) = quantity.fault(*value) {
                return Err(row.error(column, fault));
            }
        }
        for column in &self.at.values[quantities.len()..RANGE_RATE] {
            expect_empty(row, *column, kind)?;
        }
        Ok(values)
    }

    /// Returns the standard deviations of all measured values, or `None` if none is stated.
    fn sigmas(
        &self,
        row: Cells<'_>,
        kind: DetectionKind,
        range_rate: bool,
    ) -> Result<Option<[f64; QUANTITIES_MAX + 1]>, CsvError> {
        let mut sigmas = [0.0; QUANTITIES_MAX + 1];
        let (mut stated, mut unstated) = (None, None);
        for (place, column) in self.at.sigmas.into_iter().enumerate() {
            let measured = place < kind.quantities().len() || (place == RANGE_RATE && range_rate);
            if !measured {
                expect_empty(row, column, kind)?;
                continue;
            }
            match row.number_or_empty(column)? {
                Some(sigma) if sigma > 0.0 => {
                    sigmas[place] = sigma;
                    stated = Some(column);
                }
                Some(_) => return Err(row.error(column, "must be greater than 0; a standard deviation is")),
                None => unstated = Some(column),
            }
        }
        match (stated, unstated) {
            (Some(_), Some(column)) => {
                let reason = "is empty where others of the row are given; state all standard deviations or none";
                Err(row.error(column, reason))
            }
            (stated, _) => Ok(stated.map(|_| sigmas)),
        }
    }

    fn truth(&self, row: Cells<'_>) -> Result<Option<DetectionTruth>, CsvError> {
        let (Some(column), Some(text)) = (self.at.truth, row.text(self.at.truth)?) else {
            return Ok(None);
        };
        match (text, text.parse()) {
            ("-1", _) => Ok(Some(DetectionTruth::FalseAlarm)),
            ("merged", _) => Ok(Some(DetectionTruth::Merged)),
            (_, Ok(target)) => Ok(Some(DetectionTruth::Target(target))),
            _ => Err(row.error(
                column,
                "is no target; write its number, -1 for a false alarm, or merged",
            )),
        }
    }
}

fn expect_empty(row: Cells<'_>, column: Column, kind: DetectionKind) -> Result<(), CsvError> {
    match row.text(column)? {
        None => Ok(()),
        Some(_) => Err(row.error(
            column,
            format!("belongs to no value of the kind {}; leave it empty", kind.word()),
        )),
    }
}

/// Measured values, the range rate last.
fn measured(detection: &Detection) -> [Option<f64>; QUANTITIES_MAX + 1] {
    let mut values = [None; QUANTITIES_MAX + 1];
    let quantities = detection.kind.quantities().len();
    for (place, value) in values.iter_mut().zip(detection.values).take(quantities) {
        *place = Some(value);
    }
    values[RANGE_RATE] = detection.range_rate_mps;
    values
}

/// Standard deviations of the measured values.
fn deviations(detection: &Detection) -> [Option<f64>; QUANTITIES_MAX + 1] {
    let mut deviations = measured(detection);
    for (place, deviation) in deviations.iter_mut().enumerate() {
        *deviation = deviation.and(detection.sigmas).map(|sigmas| sigmas[place]);
    }
    deviations
}

impl Cell for DetectionTruth {
    fn write(self, out: &mut impl Write, _: &Reference) -> io::Result<()> {
        match self {
            Self::Target(target) => write!(out, "{target}"),
            Self::FalseAlarm => write!(out, "-1"),
            Self::Merged => write!(out, "merged"),
        }
    }
}

#[cfg(test)]
mod tests {
    use observations::{DetectionPlatform, TransponderReply};
    use proptest::prelude::*;

    use super::*;

    const HEADER: &str = "time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz,truth_id";

    fn read(rows: &str) -> Vec<Result<Detection, String>> {
        let text = format!("{HEADER}\n{rows}");
        let reader = DetectionReader::new(text.as_bytes(), 1_000).unwrap();
        reader.map(|row| row.map_err(|error| error.to_string())).collect()
    }

    #[test]
    fn rows_of_several_kinds_are_read() {
        let rows = "2.500,1,1,7,position2,-100.25,2000,,,50,50,,,0,0,0,3\n\
                    3,2,9,0,bearing,-2.5,,,,0.01,,,,10,20,30,-1\n\
                    3.25,3,9,1,range_bearing_elevation,5e3,1,0.5,-30,,,,,1,2,3,\n\
                    4,3,9,2,range_bearing,5000,1,,-30,20,0.01,,1.5,1,2,3,merged\n";
        let found: Vec<_> = read(rows).into_iter().map(Result::unwrap).collect();
        let position = Detection {
            time_of_measurement_ns: 2_500_001_000,
            sensor_id: 1,
            scan: 1,
            detection_id: 7,
            kind: DetectionKind::Position2,
            values: [-100.25, 2000.0, 0.0],
            range_rate_mps: None,
            sigmas: Some([50.0, 50.0, 0.0, 0.0]),
            platform_m: [0.0; 3],
            platform: DetectionPlatform::default(),
            height: None,
            velocity: None,
            reply: TransponderReply::default(),
            truth: Some(DetectionTruth::Target(3)),
        };
        assert_eq!(found[0], position);
        assert_eq!(
            (found[1].kind, found[1].values[0], found[1].sigmas),
            (DetectionKind::Bearing, -2.5, Some([0.01, 0.0, 0.0, 0.0]))
        );
        assert_eq!(
            (found[1].platform_m, found[1].truth),
            ([10.0, 20.0, 30.0], Some(DetectionTruth::FalseAlarm))
        );
        assert_eq!(
            (found[2].range_rate_mps, found[2].sigmas, found[2].truth),
            (Some(-30.0), None, None)
        );
        assert_eq!(
            (found[3].sigmas, found[3].truth),
            (Some([20.0, 0.01, 0.0, 1.5]), Some(DetectionTruth::Merged))
        );
    }

    #[test]
    fn what_cannot_be_meant_is_refused_with_place_and_remedy() {
        for (row, expected) in [
            (
                "2,1,1,7,plot,1,2,,,5,5,,,0,0,0,",
                "column kind: \"plot\" is no kind of detection; write one of position2",
            ),
            ("2,1,1,7,position2,1,,,,5,5,,,0,0,0,", "column m1: \"\" is empty"),
            (
                "2,1,1,7,position2,1,2,3,,5,5,,,0,0,0,",
                "column m2: \"3\" belongs to no value of the kind position2",
            ),
            (
                "2,1,1,7,position2,1,2,,,5,,,,0,0,0,",
                "column s1: \"\" is empty where others",
            ),
            (
                "2,1,1,7,position2,1,2,,,5,5,9,,0,0,0,",
                "column s2: \"9\" belongs to no value",
            ),
            (
                "2,1,1,7,position2,1,2,,,5,5,,9,0,0,0,",
                "column s3: \"9\" belongs to no value",
            ),
            (
                "2,1,1,7,position2,1,2,,30,5,5,,,0,0,0,",
                "column s3: \"\" is empty where others",
            ),
            (
                "2,1,1,7,position2,1,2,,,5,0,,,0,0,0,",
                "column s1: \"0\" must be greater than 0",
            ),
            (
                "2,1,1,7,bearing,270,,,,,,,,0,0,0,",
                "column m0: \"270\" is more than a full turn; write radians",
            ),
            (
                "2,1,1,7,range_bearing,-5,1,,,,,,,0,0,0,",
                "column m0: \"-5\" is negative",
            ),
            (
                "2,1.0,1,7,bearing,1,,,,,,,,0,0,0,",
                "column sensor_id: \"1.0\" is no whole number",
            ),
            (
                "2,1,-1,7,bearing,1,,,,,,,,0,0,0,",
                "column scan: \"-1\" is no whole number of the kind u32",
            ),
            ("2,1,1,7,bearing,1,,,,,,,,0,0,,", "column pz: \"\" is empty"),
            (
                "2,1,1,7,bearing,1,,,,,,,,0,0,0,ghost",
                "column truth_id: \"ghost\" is no target",
            ),
            (
                "1620114891000,1,1,7,bearing,1,,,,,,,,0,0,0,",
                "column time_s: \"1620114891000\" is no time",
            ),
        ] {
            let [found] = &read(row)[..] else { panic!("{row}") };
            let text = found.as_ref().unwrap_err();
            assert!(text.starts_with("line 2, ") && text.contains(expected), "{text}");
        }
    }

    #[test]
    fn the_header_must_name_every_column_but_the_truth() {
        let without = |name: &str| {
            HEADER
                .split(',')
                .filter(|column| *column != name)
                .collect::<Vec<_>>()
                .join(",")
        };
        for name in HEADER.split(',') {
            let result = DetectionReader::new(without(name).as_bytes(), 0).map(|_| ());
            match name {
                "truth_id" => result.unwrap(),
                _ => assert!(
                    result
                        .unwrap_err()
                        .to_string()
                        .contains(&format!("column {name} is missing"))
                ),
            }
        }
    }

    fn detection() -> impl Strategy<Value = Detection> {
        let numbers = (any::<u32>(), any::<u32>(), any::<u32>());
        let time_ns = -4_000_000_000_000_000i64..4_000_000_000_000_000;
        let truth = prop_oneof![
            Just(None),
            Just(Some(DetectionTruth::FalseAlarm)),
            Just(Some(DetectionTruth::Merged)),
            any::<u32>().prop_map(|target| Some(DetectionTruth::Target(target))),
        ];
        let measured = (
            prop::sample::select(DetectionKind::ALL.to_vec()),
            prop::array::uniform3(0.0..1.5),
            prop::option::of(-1e3..1e3),
            prop::option::of(prop::array::uniform4(1e-9..1e9)),
        );
        (time_ns, numbers, measured, prop::array::uniform3(-1e7..1e7), truth).prop_map(
            |(
                time_ns,
                (sensor_id, scan, detection_id),
                (kind, mut values, range_rate_mps, mut sigmas),
                platform_m,
                truth,
            )| {
                let measured = kind.quantities().len();
                values[measured..].fill(0.0);
                if let Some(sigmas) = &mut sigmas {
                    sigmas[measured..RANGE_RATE].fill(0.0);
                    sigmas[RANGE_RATE] *= f64::from(u8::from(range_rate_mps.is_some()));
                }
                Detection {
                    time_of_measurement_ns: time_ns,
                    sensor_id,
                    scan,
                    detection_id,
                    kind,
                    values,
                    range_rate_mps,
                    sigmas,
                    platform_m,
                    platform: DetectionPlatform::default(),
                    height: None,
                    velocity: None,
                    reply: TransponderReply::default(),
                    truth,
                }
            },
        )
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_again_exactly(
            detections in prop::collection::vec(detection(), 0..5),
            first_day_ns in 0i64..2_000_000_000_000_000_000,
        ) {
            let moved = |mut detection: Detection| {
                detection.time_of_measurement_ns += first_day_ns;
                detection
            };
            let detections: Vec<_> = detections.into_iter().map(moved).collect();
            let mut writer = DetectionWriter::begin(Vec::new(), first_day_ns).unwrap();
            for detection in &detections {
                writer.write(detection).unwrap();
            }
            let text = writer.into_inner();
            let reader = DetectionReader::new(&text[..], first_day_ns).unwrap();
            let found: Vec<_> = reader.map(Result::unwrap).collect();
            prop_assert_eq!(found, detections);
        }
    }
}

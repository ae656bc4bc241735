//! Rows of a file with stated arrivals, in the order of arrival, independent of the order in the file (FM-15).
//!
//! A row can be passed on once no row that follows in the file arrived before it. How far the file is out of order is
//! therefore found first: the greatest time by which a row arrived before a row further up. A second reading then holds
//! only the rows of so much time, so that a file in order costs no memory at any length.

use std::io::Read;

use formats::sensor_tracks_csv::SensorTrackReader;
use messages::SensorTrack;
use sources::Reorder;

use super::refusals::MIDNIGHT_STEP_NS;

/// Order of the rows of a file with stated arrivals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RowOrder {
    Arrival,
    /// Of measurement, as if each had arrived at once.
    Time,
}

/// A report at the time of arrival.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArrivedReport {
    pub(crate) track: SensorTrack,
    /// Time of arrival, nanoseconds: not before the time of measurement.
    pub(crate) arrival_ns: i64,
    /// Line of the file.
    pub(crate) line: u64,
}

/// Puts the rows of a file in the order of arrival.
#[derive(Debug)]
pub(super) struct ArrivalOrder {
    order: RowOrder,
    /// Line and time of the first row that came half a day and more before a row further up.
    midnight: Option<(u64, i64)>,
    /// Holds rows back for the greatest time by which a row arrived before a row further up.
    rows: Reorder<ArrivedReport>,
}

impl ArrivalOrder {
    /// That of the rows of `reader`, which reads the whole file for this.
    pub(super) fn of<R: Read>(
        mut reader: SensorTrackReader<R, impl FnMut(u32) -> Option<u16>>,
        order: RowOrder,
    ) -> Self {
        let mut new = Self {
            order,
            midnight: None,
            rows: Reorder::new(0),
        };
        let (mut latest_ns, mut disorder_ns) = (i64::MIN, 0);
        while let Some(row) = reader.next() {
            if let Ok(track) = row {
                let arrival_ns = new.arrival_of(&track, reader.arrival_ns());
                latest_ns = latest_ns.max(arrival_ns);
                let behind_ns = latest_ns.saturating_sub(arrival_ns);
                disorder_ns = behind_ns.max(disorder_ns);
                if behind_ns > MIDNIGHT_STEP_NS {
                    new.midnight.get_or_insert((reader.line(), arrival_ns));
                }
            }
        }
        new.rows = Reorder::new(disorder_ns);
        new
    }

    /// Line and time, nanoseconds, of the first row with which the times begin again.
    pub(super) fn midnight(&self) -> Option<(u64, i64)> {
        self.midnight
    }

    /// When a report arrives that did so at `stated_ns`.
    fn arrival_of(&self, track: &SensorTrack, stated_ns: i64) -> i64 {
        match self.order {
            RowOrder::Arrival => stated_ns,
            RowOrder::Time => track.time_of_measurement_ns,
        }
    }

    /// Takes in the next row of the file. Rows of one arrival come in the order of the times of measurement.
    pub(super) fn push(&mut self, row: &ArrivedReport) {
        let arrival_ns = self.arrival_of(&row.track, row.arrival_ns);
        let row = ArrivedReport { arrival_ns, ..*row };
        self.rows.push(arrival_ns, row.track.time_of_measurement_ns, row);
    }

    /// The file has ended.
    pub(super) fn end(&mut self) {
        self.rows.finish();
    }

    /// The next row in the order of arrival; `None` while the file may have an earlier row.
    pub(super) fn pop(&mut self) -> Option<ArrivedReport> {
        self.rows.pop()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,state,trace,arrival_s\n";

    /// The lines of rows that are measured and arrive at these times, in this order, and the most rows held.
    fn ordered(rows: &[(f64, f64)], order: RowOrder) -> (Vec<u64>, usize) {
        let mut text = HEADER.to_owned();
        for (time_s, arrival_s) in rows {
            text += &format!("{time_s},1,1,0,0,0,0,0,0,confirmed,9,{arrival_s}\n");
        }
        let reader = || SensorTrackReader::new(text.as_bytes(), 0, |_| Some(0)).unwrap();
        let mut order = ArrivalOrder::of(reader(), order);
        let (mut lines, mut pushed, mut most) = (Vec::new(), 0, 0);
        let mut reader = reader();
        while let Some(row) = reader.next() {
            let row = ArrivedReport {
                track: row.unwrap(),
                arrival_ns: reader.arrival_ns(),
                line: reader.line(),
            };
            order.push(&row);
            pushed += 1;
            most = most.max(pushed - lines.len());
            while let Some(row) = order.pop() {
                lines.push(row.line);
            }
        }
        order.end();
        lines.extend(std::iter::from_fn(|| order.pop()).map(|row| row.line));
        (lines, most)
    }

    #[test]
    fn rows_come_in_the_order_of_arrival_whatever_their_order_in_the_file() {
        // By time of measurement; line 1 is the header.
        let by_time = [
            (1.0, 4.0),
            (2.0, 2.0),
            (3.0, 3.5),
            (4.0, 4.0),
            (5.0, 5.0),
            (6.0, 9.0),
            (7.0, 8.0),
        ];
        assert_eq!(ordered(&by_time, RowOrder::Arrival).0, [3, 4, 2, 5, 6, 8, 7]);
        let mut reversed = by_time;
        reversed.reverse();
        // Equal arrivals come in the order of the times of measurement.
        assert_eq!(ordered(&reversed, RowOrder::Arrival).0, [7, 6, 8, 5, 4, 2, 3]);
        assert_eq!(ordered(&reversed, RowOrder::Time).0, [8, 7, 6, 5, 4, 3, 2]);
    }

    #[test]
    fn a_file_in_order_is_not_held() {
        let rows: Vec<(f64, f64)> = (0..1000).map(|row| (f64::from(row), f64::from(row) + 2.0)).collect();
        let (lines, most) = ordered(&rows, RowOrder::Arrival);
        assert!(lines.is_sorted() && lines.len() == 1000);
        assert!(most <= 2, "{most}");
    }
}

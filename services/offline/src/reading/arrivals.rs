//! Rows of a file with stated arrivals, in the order of arrival, independent of the order in the file (FM-15).
//!
//! A row can be passed on once no row that follows in the file arrived before it. How far the file is out of order is
//! therefore found first: the greatest time by which a row arrived before a row further up. A second reading then holds
//! only the rows of so much time, so that a file in order costs no memory at any length.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::io::Read;

use formats::sensor_tracks_csv::SensorTrackReader;
use messages::SensorTrack;

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

impl ArrivedReport {
    /// Reports that arrive at once come in the order of the times of measurement.
    fn order(&self) -> (i64, i64, u64) {
        (self.arrival_ns, self.track.time_of_measurement_ns, self.line)
    }
}

impl PartialEq for ArrivedReport {
    fn eq(&self, other: &Self) -> bool {
        self.order() == other.order()
    }
}

impl Eq for ArrivedReport {}

impl PartialOrd for ArrivedReport {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for ArrivedReport {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.order().cmp(&other.order())
    }
}

/// Puts the rows of a file in the order of arrival.
#[derive(Debug)]
pub(super) struct ArrivalOrder {
    order: RowOrder,
    /// Greatest time by which a row arrived before a row further up, nanoseconds.
    disorder_ns: i64,
    /// Line and time of the first row that came half a day and more before a row further up.
    midnight: Option<(u64, i64)>,
    /// Latest arrival of the rows so far, nanoseconds.
    latest_ns: i64,
    rows: BinaryHeap<Reverse<ArrivedReport>>,
}

impl ArrivalOrder {
    /// That of the rows of `reader`, which reads the whole file for this.
    pub(super) fn of<R: Read>(
        mut reader: SensorTrackReader<R, impl FnMut(u32) -> Option<u16>>,
        order: RowOrder,
    ) -> Self {
        let mut new = Self {
            order,
            disorder_ns: 0,
            midnight: None,
            latest_ns: i64::MIN,
            rows: BinaryHeap::new(),
        };
        let mut latest_ns = i64::MIN;
        while let Some(row) = reader.next() {
            if let Ok(track) = row {
                let arrival_ns = new.arrival_of(&track, reader.arrival_ns());
                latest_ns = latest_ns.max(arrival_ns);
                let behind_ns = latest_ns.saturating_sub(arrival_ns);
                new.disorder_ns = new.disorder_ns.max(behind_ns);
                if behind_ns > MIDNIGHT_STEP_NS {
                    new.midnight.get_or_insert((reader.line(), arrival_ns));
                }
            }
        }
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

    /// Takes in the next row of the file.
    pub(super) fn push(&mut self, row: &ArrivedReport) {
        let arrival_ns = self.arrival_of(&row.track, row.arrival_ns);
        self.latest_ns = self.latest_ns.max(arrival_ns);
        self.rows.push(Reverse(ArrivedReport { arrival_ns, ..*row }));
    }

    /// The next row in the order of arrival; `None` while the file may have an earlier row, until it has `ended`.
    pub(super) fn pop(&mut self, has_ended: bool) -> Option<ArrivedReport> {
        let Reverse(first) = self.rows.peek()?;
        // A row that follows may have arrived at the very same time.
        let is_first = has_ended || first.arrival_ns < self.latest_ns.saturating_sub(self.disorder_ns);
        is_first.then(|| self.rows.pop().map(|Reverse(row)| row)).flatten()
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
        let (mut lines, mut most) = (Vec::new(), 0);
        let mut reader = reader();
        while let Some(row) = reader.next() {
            let row = ArrivedReport {
                track: row.unwrap(),
                arrival_ns: reader.arrival_ns(),
                line: reader.line(),
            };
            order.push(&row);
            most = most.max(order.rows.len());
            while let Some(row) = order.pop(false) {
                lines.push(row.line);
            }
        }
        lines.extend(std::iter::from_fn(|| order.pop(true)).map(|row| row.line));
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

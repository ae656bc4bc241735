//! Reports into the order of their times.
//!
//! A sensor sends reports in the order of its processing, some tenths of a second out of order in time. A fixed delay
//! sorts the reports, and yields the *watermark*: all reports measured before the watermark have been delivered.
//!
//! Adapters of recorded sources use this module; live reports keep the order of their arrival. Several sources, each
//! in order, are merged elsewhere: live by their watermarks (`fusion::Merger`), because the next report of a source may
//! not have arrived; of files by the next row of each file (`koseki fuse`). Detections need no order: a scan is cut at
//! boundaries and sorted when complete (`tracking::cutting`).

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use messages::SensorTrack;

/// Reports held back until no earlier one can follow.
#[derive(Debug)]
pub struct Reorder {
    held: BinaryHeap<HeldReport>,
    window_ns: i64,
    newest_ns: i64,
    next_place: u64,
}

#[derive(Debug)]
struct HeldReport {
    time_ns: i64,
    place: u64,
    report: SensorTrack,
}

impl Reorder {
    /// Holds reports back for `window_ns` of the source's own time.
    pub fn new(window_ns: i64) -> Self {
        Self {
            held: BinaryHeap::new(),
            window_ns,
            newest_ns: i64::MIN,
            next_place: 0,
        }
    }

    /// Everything measured before this has been handed out once [`Reorder::pop`] yields nothing.
    pub fn mark_ns(&self) -> i64 {
        self.newest_ns.saturating_sub(self.window_ns)
    }

    /// The source's time has come to `time_ns`, with or without a report.
    pub fn advance(&mut self, time_ns: i64) {
        self.newest_ns = self.newest_ns.max(time_ns);
    }

    /// Adds a report; `false` if the report is older than the delivered reports, and was dropped.
    pub fn push(&mut self, report: SensorTrack) -> bool {
        let time_ns = report.time_of_measurement_ns;
        if time_ns < self.mark_ns() {
            return false;
        }
        self.advance(time_ns);
        self.held.push(HeldReport {
            time_ns,
            place: self.next_place,
            report,
        });
        self.next_place += 1;
        true
    }

    /// Returns the earliest report if due; reports with the same time keep their order of arrival.
    pub fn pop(&mut self) -> Option<SensorTrack> {
        if self.held.peek()?.time_ns >= self.mark_ns() {
            return None;
        }
        self.held.pop().map(|held| held.report)
    }

    /// Nothing follows: all that is still held may be handed out.
    pub fn finish(&mut self) {
        self.newest_ns = i64::MAX;
        self.window_ns = 0;
    }
}

impl Ord for HeldReport {
    fn cmp(&self, other: &Self) -> Ordering {
        // The heap's greatest is the earliest.
        (other.time_ns, other.place).cmp(&(self.time_ns, self.place))
    }
}

impl PartialOrd for HeldReport {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for HeldReport {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for HeldReport {}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn report(time_ns: i64, track_number: u32) -> SensorTrack {
        SensorTrack {
            time_of_measurement_ns: time_ns,
            track_number,
            ..SensorTrack::default()
        }
    }

    #[test]
    fn late_reports_are_refused() {
        let mut reorder = Reorder::new(10);
        assert!(reorder.push(report(100, 0)));
        assert!(reorder.push(report(90, 1)));
        assert!(!reorder.push(report(89, 2)));
        assert_eq!(reorder.mark_ns(), 90);
        assert_eq!(reorder.pop(), None, "another of time 90 may follow");
    }

    proptest! {
        #[test]
        fn what_comes_out_is_sorted_and_complete(jitter in prop::collection::vec(0i64..50, 0..100)) {
            let mut reorder = Reorder::new(50);
            let mut times = Vec::new();
            for (place, jitter) in jitter.iter().enumerate() {
                prop_assert!(reorder.push(report(20 * place as i64 - jitter, place as u32)));
                while let Some(report) = reorder.pop() {
                    prop_assert!(report.time_of_measurement_ns < reorder.mark_ns());
                    times.push(report.time_of_measurement_ns);
                }
            }
            reorder.finish();
            while let Some(report) = reorder.pop() {
                times.push(report.time_of_measurement_ns);
            }
            prop_assert_eq!(times.len(), jitter.len());
            prop_assert!(times.windows(2).all(|pair| pair[0] <= pair[1]));
        }
    }
}

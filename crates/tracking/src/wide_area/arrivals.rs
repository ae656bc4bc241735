//! Queue of reports until the scans reach their arrival.
//!
//! A report is used in the first scan after the arrival. Scans are usually processed with delay, so reports come before
//! the scan; given to the tracker at once, such reports would take the room of reports needed earlier. Reports wait
//! here, ordered by content and not by arrival at the queue. So the tracker receives the same sequence from a file and
//! from several sensors.

use std::cmp::Ordering;
use std::collections::VecDeque;

use observations::WideAreaReport;

use super::report::ReportRejection;
use crate::tracker::Tracker;

/// Most reports that wait, of sensors that go on without an end: more would be of no use to the tracker either.
pub const WAITING_MAX: usize = 1024;

/// Reports of wide-area sensors in the order of arrival.
#[derive(Clone, Debug)]
pub struct Arrivals {
    waiting: VecDeque<WideAreaReport>,
    room: usize,
}

impl Arrivals {
    /// None yet, with room for [`WAITING_MAX`].
    pub fn new() -> Self {
        Self {
            waiting: VecDeque::with_capacity(WAITING_MAX),
            room: WAITING_MAX,
        }
    }

    /// Makes a queue of all reports of a file.
    pub fn of(mut reports: Vec<WideAreaReport>) -> Self {
        reports.sort_by(order);
        Self {
            room: reports.len(),
            waiting: reports.into(),
        }
    }

    /// Takes a report. `false` without room.
    pub fn arrive(&mut self, report: WideAreaReport) -> bool {
        if self.waiting.len() == self.room {
            return false;
        }
        let place = self.waiting.partition_point(|kept| order(kept, &report).is_le());
        self.waiting.insert(place, report);
        true
    }

    /// Gives the tracker the reports that have arrived until `time_ns`; calls `rejected` for each rejected report.
    pub fn give(&mut self, time_ns: i64, tracker: &mut Tracker, mut rejected: impl FnMut(ReportRejection)) {
        while self.waiting.front().is_some_and(|report| report.arrival_ns <= time_ns)
            && let Some(report) = self.waiting.pop_front()
        {
            if let Err(reason) = tracker.wide_area(&report) {
                rejected(reason);
            }
        }
    }

    /// Number of reports that wait.
    pub fn waiting(&self) -> usize {
        self.waiting.len()
    }
}

impl Default for Arrivals {
    fn default() -> Self {
        Self::new()
    }
}

/// Orders by arrival and observation; at equal times, by all other fields, so that only equal reports are unordered.
pub fn order(one: &WideAreaReport, other: &WideAreaReport) -> Ordering {
    let times = |report: &WideAreaReport| (report.arrival_ns, report.time_ns, report.targets);
    let numbers = |report: &WideAreaReport| {
        let [x, y, z] = report.position_m;
        let [vx, vy, vz] = report.velocity_mps;
        let [east, north] = report.origin_m.unwrap_or([f64::NEG_INFINITY; 2]);
        [x, y, z, vx, vy, vz, east, north]
    };
    let by_numbers = || {
        let pairs = numbers(one).into_iter().zip(numbers(other));
        pairs
            .map(|(one, other)| one.total_cmp(&other))
            .find(|order| order.is_ne())
            .unwrap_or(Ordering::Equal)
    };
    times(one).cmp(&times(other)).then_with(by_numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{S, settings};

    fn report(arrival_s: i64, east_m: f64) -> WideAreaReport {
        WideAreaReport {
            time_ns: 0,
            arrival_ns: arrival_s * S,
            position_m: [east_m, 0.0, 0.0],
            velocity_mps: [0.0; 3],
            targets: 2,
            origin_m: None,
        }
    }

    #[test]
    fn the_order_in_which_they_came_does_not_matter() {
        let reports = [report(9, 5.0), report(3, 1.0), report(9, -5.0), report(4, 0.0)];
        let (mut one, mut other) = (Arrivals::new(), Arrivals::new());
        for place in 0..4 {
            assert!(one.arrive(reports[place]) && other.arrive(reports[3 - place]));
        }
        assert_eq!(
            (&one.waiting, &one.waiting),
            (&other.waiting, &Arrivals::of(reports.to_vec()).waiting)
        );
    }

    #[test]
    fn each_is_given_when_its_time_has_come_and_refusals_are_heard() {
        let mut tracker = Tracker::new(settings()).unwrap();
        let bad = WideAreaReport {
            targets: 10_000,
            ..report(5, 0.0)
        };
        let mut arrivals = Arrivals::of(vec![report(4, 0.0), report(3, 0.0), bad]);
        let mut refused = Vec::new();
        arrivals.give(3 * S, &mut tracker, |refusal| refused.push(refusal));
        assert_eq!((arrivals.waiting(), tracker.counts().wide_area_reports), (2, 1));
        arrivals.give(9 * S, &mut tracker, |refusal| refused.push(refusal));
        assert_eq!(refused, [ReportRejection::TooManyTargets(10_000)]);
        assert_eq!((arrivals.waiting(), tracker.counts().wide_area_reports), (0, 2));
    }

    #[test]
    fn a_flood_is_refused_where_there_is_no_room() {
        let mut arrivals = Arrivals::new();
        for second in 0..WAITING_MAX as i64 {
            assert!(arrivals.arrive(report(second, 0.0)));
        }
        assert!(!arrivals.arrive(report(0, 0.0)));
    }
}

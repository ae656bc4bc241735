//! Rows of counts in datagrams.
//!
//! Each datagram is a separate table (FM-6): a header line, and a row per report, as with bearings. Times are seconds
//! since midnight (UTC), on the day with the result nearest to the time of receipt.
//!
//! A report arrives when the kernel takes the datagram from the network. The `arrival_s` of the row counts only if
//! later, for a sender that states the earliest time of use. No report is therefore used before its arrival.

use formats::wide_area_csv::WideAreaReader;
use runtime::HealthEntry;
use tracking::wide_area::WideAreaReport;

use super::RejectedReports;
use crate::receiver::ReceiptTime;
use crate::tables::{TableCounts, utc_ns};

/// Longest time from receipt to the stated arrival of a report, nanoseconds.
const AHEAD_MAX_NS: i64 = 60_000_000_000;

/// Reader of tables of counts.
#[derive(Debug, Default)]
pub(super) struct CountRows {
    tables: TableCounts,
    rejected: RejectedReports,
}

impl CountRows {
    /// Takes the rows of a datagram that was received at `received`.
    pub(super) fn take(&mut self, bytes: &[u8], received: ReceiptTime, reports: &mut Vec<WideAreaReport>) {
        let received_ns = received.utc_ns;
        for row in self.tables.rows(bytes, received, WideAreaReader::new) {
            let stated = WideAreaReport {
                time_ns: utc_ns(received_ns, row.time_ns),
                arrival_ns: utc_ns(received_ns, row.arrival_ns),
                ..row
            };
            if !self.rejected.passes(&stated) {
                continue;
            }
            if stated.arrival_ns.saturating_sub(received_ns) > AHEAD_MAX_NS {
                self.rejected.time += 1;
                continue;
            }
            reports.push(WideAreaReport {
                arrival_ns: stated.arrival_ns.max(received_ns),
                ..stated
            });
        }
    }

    pub(super) fn count(&self, health: &mut HealthEntry) {
        self.tables.count(health);
        self.rejected.count(&mut health.counters);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use frames::time::NS_PER_DAY;
    use messages::{Counter, Counters};

    use super::*;

    const HEADER: &str = "time_s,arrival_s,x,y,z,vx,vy,vz,count\n";
    /// Noon of a day, and five seconds.
    const NOON_NS: i64 = 20_000 * NS_PER_DAY + 43_205_000_000_000;

    fn at_noon() -> ReceiptTime {
        ReceiptTime {
            utc_ns: NOON_NS,
            mono_ns: 0,
            steady_ns: NOON_NS,
        }
    }

    fn take(rows: &str) -> (Vec<WideAreaReport>, Counters) {
        let (mut table, mut reports, mut health) = (CountRows::default(), Vec::new(), HealthEntry::default());
        table.take(format!("{HEADER}{rows}").as_bytes(), at_noon(), &mut reports);
        table.count(&mut health);
        (reports, health.counters)
    }

    #[test]
    fn a_report_arrives_when_it_was_received_or_later_if_it_says_so() {
        let (reports, _) = take("43200,43201,1,2,3,4,5,6,2\n43200,43209,1,2,3,4,5,6,0\n");
        let arrivals: Vec<i64> = reports
            .iter()
            .map(|report| (report.arrival_ns - NOON_NS) / 1_000_000_000)
            .collect();
        assert_eq!(arrivals, [0, 4]);
        assert_eq!(reports[0].time_ns, NOON_NS - 5_000_000_000);
        assert_eq!((reports[0].targets, reports[1].targets), (2, 0));
    }

    #[test]
    fn what_cannot_be_is_counted_by_reason_and_the_rest_is_taken() {
        let (reports, counters) = take(
            "43200,43201,1,2,3,4,5,6,10000\n43200,43201,nan,2,3,4,5,6,1\n43200,43201,1e9,2,3,4,5,6,1\n\
             43202,43201,1,2,3,4,5,6,1\n43200,43201,1,2\n43200,43299,1,2,3,4,5,6,1\n43200,43201,1,2,3,4,5,6,256\n",
        );
        assert_eq!(reports.len(), 1);
        for (counter, expected) in [
            (Counter::Records, 7),
            (Counter::BlocksRejected, 2),
            (Counter::RejectedTargets, 1),
            (Counter::RejectedPosition, 1),
            (Counter::RejectedTime, 2),
        ] {
            assert_eq!(counters[counter], expected, "{counter:?}");
        }
    }

    proptest! {
        #[test]
        fn whatever_comes_is_taken_or_counted(
            bytes in prop::collection::vec(any::<u8>(), 0..400),
            rows in "([0-9]{1,6}(\\.[0-9])?,){8}[0-9]{1,5}\n",
            place in 0..300usize,
        ) {
            let mut datagram = format!("{HEADER}{rows}").into_bytes();
            let place = place.min(datagram.len());
            datagram.splice(place..place, bytes.iter().copied().take(3));
            for bytes in [&bytes[..], &datagram] {
                let (mut table, mut reports, mut health) = (CountRows::default(), Vec::new(), HealthEntry::default());
                table.take(bytes, at_noon(), &mut reports);
                table.count(&mut health);
                let of = |counter: Counter| health.counters[counter];
                let refused = of(Counter::RejectedTargets) + of(Counter::RejectedPosition) + of(Counter::RejectedTime)
                    + of(Counter::BlocksRejected);
                let unreadable = u64::from(of(Counter::BytesRejected) > 0 || bytes.is_empty());
                prop_assert_eq!(reports.len() as u64 + refused, of(Counter::Records) + unreadable);
                for report in &reports {
                    prop_assert!(tracking::wide_area::fault_in(report).is_none() && report.arrival_ns >= NOON_NS);
                }
            }
        }
    }
}

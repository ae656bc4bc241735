//! Statistics of senders: how much, and when.
//!
//! Records are counted per sender, that is, per system identification (SAC/SIC, item 010) in each category, and per
//! second. The second is that of the record's own time of day if its category has one, otherwise that of the
//! recording. Times of day are followed across midnight. Both kinds of time are times of day here, so that a sender
//! with times in some of its records has a single axis.
//!
//! Rates are records per second over the sender's whole time, silent seconds included. The first and the last second
//! are rarely recorded whole and are left out where there are others.

use std::collections::BTreeMap;

use frames::time::{DayUnroller, NS_PER_DAY, NS_PER_S, seconds, time_of_day_ns};
use serde::Serialize;

use crate::containers::TimeStamp;
use asterix::Record;

/// A sender of records of one category.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct RecordSender {
    /// The category.
    pub category: u8,
    /// System area and identification codes, SAC and SIC; `None` where records carry none.
    pub source: Option<(u8, u8)>,
}

/// Records counted by sender and second.
#[derive(Debug, Clone, Default)]
pub struct Statistics {
    senders: BTreeMap<RecordSender, SenderTally>,
}

/// Sums over one sender.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SenderSummary {
    /// The sender.
    #[serde(flatten)]
    pub sender: RecordSender,
    /// Number of records.
    pub records: u64,
    /// The earliest time, in seconds since midnight of the first record's day; less than 0 or more than 86,400 on
    /// other days. None where no time is known.
    pub first_s: Option<f64>,
    /// The latest time.
    pub last_s: Option<f64>,
    /// Records per second.
    pub rate: Option<Rate>,
}

/// Records per second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Rate {
    /// In the quietest second.
    pub min: u64,
    /// In half of the seconds at most so many.
    pub median: u64,
    /// In the busiest second.
    pub max: u64,
}

#[derive(Debug, Clone, Default)]
struct SenderTally {
    records: u64,
    times: Option<Times>,
}

#[derive(Debug, Clone)]
struct Times {
    unroller: DayUnroller,
    first_ns: i64,
    last_ns: i64,
    per_second: BTreeMap<i64, u64>,
}

impl Statistics {
    /// Counts a record and when it was recorded.
    pub fn add(&mut self, record: &Record<'_>, time_stamp: Option<TimeStamp>) {
        let sender = RecordSender {
            category: record.table().number,
            source: record.sender(),
        };
        let tally = self.senders.entry(sender).or_default();
        tally.records += 1;
        if let Some(time_ns) = time_of_day(record).or_else(|| time_stamp.map(of_day)) {
            tally.times.get_or_insert_with(|| Times::new(time_ns)).add(time_ns);
        }
    }

    /// The senders by category and source.
    pub fn senders(&self) -> impl Iterator<Item = SenderSummary> + '_ {
        self.senders.iter().map(|(sender, tally)| SenderSummary {
            sender: *sender,
            records: tally.records,
            first_s: tally.times.as_ref().map(|times| seconds(times.first_ns)),
            last_s: tally.times.as_ref().map(|times| seconds(times.last_ns)),
            rate: tally.times.as_ref().map(Times::rate),
        })
    }
}

impl Times {
    fn new(time_ns: i64) -> Self {
        Self {
            unroller: DayUnroller::near(time_ns),
            first_ns: time_ns,
            last_ns: time_ns,
            per_second: BTreeMap::new(),
        }
    }

    fn add(&mut self, time_of_day_ns: i64) {
        let time_ns = self.unroller.utc_ns(time_of_day_ns);
        self.unroller.advance(time_ns);
        self.first_ns = self.first_ns.min(time_ns);
        self.last_ns = self.last_ns.max(time_ns);
        *self.per_second.entry(time_ns.div_euclid(NS_PER_S)).or_default() += 1;
    }

    fn rate(&self) -> Rate {
        let (first, last) = (self.first_ns.div_euclid(NS_PER_S), self.last_ns.div_euclid(NS_PER_S));
        let whole = match last - first {
            0 | 1 => first..=last,
            _ => first + 1..=last - 1,
        };
        let mut counts: Vec<u64> = self.per_second.range(whole.clone()).map(|(_, count)| *count).collect();
        counts.sort_unstable();
        // Silent seconds come before all others; they are not in the list, since there may be a great many.
        let silent = (whole.end() - whole.start() + 1) as usize - counts.len();
        let nth = |place: usize| place.checked_sub(silent).map_or(0, |place| counts[place]);
        let seconds = silent + counts.len();
        Rate {
            min: nth(0),
            median: nth((seconds - 1) / 2),
            max: nth(seconds - 1),
        }
    }
}

/// The time of day that a record carries, in ns.
fn time_of_day(record: &Record<'_>) -> Option<i64> {
    let octets = record.table().times.iter().find_map(|item| record.item_named(item))?;
    let &[high, middle, low] = octets else { return None };
    Some(time_of_day_ns(u32::from_be_bytes([0, high, middle, low])))
}

/// The time of day of a recorder's clock, in ns.
fn of_day(time_stamp: TimeStamp) -> i64 {
    time_stamp.ns().rem_euclid(NS_PER_DAY)
}

//! Samples into the order of their times.
//!
//! A sensor sends reports in the order of its processing, some tenths of a second out of order in time. The rows of a
//! file are out of order by a known time at most. A fixed delay sorts either, and yields the *watermark*: all samples
//! of times before the watermark have been delivered.
//!
//! Adapters of recorded sources and readers of files with stated arrivals use this module; live reports keep the order
//! of their arrival. Several sources, each in order, are merged elsewhere: live by their watermarks (`fusion::Merger`),
//! because the next report of a source may not have arrived; of files by the next row of each file (`koseki fuse`).
//! Detections need no order: a scan is cut at boundaries and sorted when complete (`tracking::cutting`).

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Samples held back until no earlier sample can follow.
#[derive(Debug)]
pub struct Reorder<T> {
    held: BinaryHeap<Held<T>>,
    window_ns: i64,
    newest_ns: i64,
    next_place: u64,
}

#[derive(Debug)]
struct Held<T> {
    /// Time, time among samples of equal time, and order of arrival.
    order: (i64, i64, u64),
    sample: T,
}

impl<T> Reorder<T> {
    /// Holds samples back for `window_ns` of the source's own time.
    pub fn new(window_ns: i64) -> Self {
        Self {
            held: BinaryHeap::new(),
            window_ns,
            newest_ns: i64::MIN,
            next_place: 0,
        }
    }

    /// Everything of times before this has been handed out once [`Reorder::pop`] yields nothing.
    pub fn mark_ns(&self) -> i64 {
        self.newest_ns.saturating_sub(self.window_ns)
    }

    /// The source's time has come to `time_ns`, with or without a sample.
    pub fn advance(&mut self, time_ns: i64) {
        self.newest_ns = self.newest_ns.max(time_ns);
    }

    /// Adds a sample of this time, by `tie_ns` among samples of equal time; `false` if the sample is older than the
    /// delivered samples, and was dropped.
    pub fn push(&mut self, time_ns: i64, tie_ns: i64, sample: T) -> bool {
        if time_ns < self.mark_ns() {
            return false;
        }
        self.advance(time_ns);
        let order = (time_ns, tie_ns, self.next_place);
        self.held.push(Held { order, sample });
        self.next_place += 1;
        true
    }

    /// Returns the earliest sample if due; equal samples keep their order of arrival.
    pub fn pop(&mut self) -> Option<T> {
        if self.held.peek()?.order.0 >= self.mark_ns() {
            return None;
        }
        self.held.pop().map(|held| held.sample)
    }

    /// Nothing follows: all held samples may be handed out.
    pub fn finish(&mut self) {
        self.newest_ns = i64::MAX;
        self.window_ns = 0;
    }
}

impl<T> Ord for Held<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        // The heap's greatest is the earliest.
        other.order.cmp(&self.order)
    }
}

impl<T> PartialOrd for Held<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> PartialEq for Held<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<T> Eq for Held<T> {}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn late_samples_are_refused() {
        let mut reorder = Reorder::new(10);
        assert!(reorder.push(100, 0, "first"));
        assert!(reorder.push(90, 0, "early"));
        assert!(!reorder.push(89, 0, "late"));
        assert_eq!(reorder.mark_ns(), 90);
        assert_eq!(reorder.pop(), None, "another of time 90 may follow");
    }

    proptest! {
        #[test]
        fn what_comes_out_is_sorted_and_complete(jitter in prop::collection::vec(0i64..50, 0..100)) {
            let mut reorder = Reorder::new(50);
            let mut times = Vec::new();
            for (place, jitter) in jitter.iter().enumerate() {
                let time_ns = 20 * place as i64 - jitter;
                prop_assert!(reorder.push(time_ns, 0, time_ns));
                while let Some(time_ns) = reorder.pop() {
                    prop_assert!(time_ns < reorder.mark_ns());
                    times.push(time_ns);
                }
            }
            reorder.finish();
            times.extend(std::iter::from_fn(|| reorder.pop()));
            prop_assert_eq!(times.len(), jitter.len());
            prop_assert!(times.windows(2).all(|pair| pair[0] <= pair[1]));
        }
    }
}

//! Merging the sources by time (order of work `time`, PL-12).
//!
//! Reports of several recorded sources reach fusion in an order that depends on scheduling and replay speed. Processing
//! in this order would make the result depend on scheduling and speed. Therefore each source also publishes its
//! *watermark*: no older report will follow. The earliest waiting report is processed when no other source can deliver
//! an earlier report: every source has a waiting report, or a watermark beyond the report, or has ended. The price is
//! latency (the slowest source sets the pace), acceptable for recorded inputs but not for live inputs, which use order
//! `arrival` without a merger.

use std::collections::VecDeque;

use messages::SensorTrack;

/// Reports of all sources, waiting for their turn.
#[derive(Debug)]
pub struct Merger {
    sources: Vec<SourceQueue>,
    capacity: usize,
    worked_off_ns: i64,
}

#[derive(Debug)]
struct SourceQueue {
    queue: VecDeque<SensorTrack>,
    watermark_ns: i64,
    ended: bool,
    next_sequence: u64,
}

/// Fate of a report that was handed in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PushOutcome {
    /// The report waits for its turn.
    Waiting,
    /// The report waits, and the source's oldest waiting report was dropped because its queue was full.
    DroppedOldest,
    /// The report is older than a report already worked off, and was rejected.
    OutOfOrder,
    /// The report has been handed in before (a restarted publisher repeats reports).
    Repeated,
}

impl Merger {
    /// A merger for `sources` sources with room for `capacity` waiting reports each.
    pub fn new(sources: usize, capacity: usize) -> Self {
        let queue = || SourceQueue {
            queue: VecDeque::with_capacity(capacity),
            watermark_ns: i64::MIN,
            ended: false,
            next_sequence: 0,
        };
        Self {
            sources: (0..sources).map(|_| queue()).collect(),
            capacity,
            worked_off_ns: i64::MIN,
        }
    }

    /// Number of further reports of `source` that fit without a drop.
    pub fn room(&self, source: usize) -> usize {
        self.capacity - self.sources[source].queue.len()
    }

    /// Adds a report. Sequence numbers of a source must increase; a number not above the last is a repetition.
    pub fn push(&mut self, source: usize, report: &SensorTrack) -> PushOutcome {
        let worked_off_ns = self.worked_off_ns;
        let waiting = &mut self.sources[source];
        if report.sequence < waiting.next_sequence {
            return PushOutcome::Repeated;
        }
        waiting.next_sequence = report.sequence + 1;
        let newest = waiting
            .queue
            .back()
            .map_or(worked_off_ns, |last| last.time_of_measurement_ns);
        if report.time_of_measurement_ns < newest {
            return PushOutcome::OutOfOrder;
        }
        let mut result = PushOutcome::Waiting;
        if waiting.queue.len() == self.capacity {
            waiting.queue.pop_front();
            result = PushOutcome::DroppedOldest;
        }
        waiting.queue.push_back(*report);
        result
    }

    /// Notes a source's watermark: no further report was measured before `watermark_ns`.
    pub fn set_watermark(&mut self, source: usize, watermark_ns: i64) {
        let waiting = &mut self.sources[source];
        waiting.watermark_ns = waiting.watermark_ns.max(watermark_ns);
    }

    /// Notes the end of `source`.
    pub fn end(&mut self, source: usize) {
        self.sources[source].ended = true;
    }

    /// Whether every source has ended and nothing waits.
    pub fn finished(&self) -> bool {
        self.sources
            .iter()
            .all(|waiting| waiting.ended && waiting.queue.is_empty())
    }

    /// Sequence number up to which `source`'s reports have been handed in.
    pub fn next_sequence(&self, source: usize) -> u64 {
        self.sources[source].next_sequence
    }

    /// The next report in time order, if its turn has come. Among equal times the source with the smaller number goes
    /// first.
    pub fn pop(&mut self) -> Option<SensorTrack> {
        let (first, time_ns) = self
            .sources
            .iter()
            .enumerate()
            .filter_map(|(index, waiting)| Some((index, waiting.queue.front()?.time_of_measurement_ns)))
            .min_by_key(|(index, time_ns)| (*time_ns, *index))?;
        let safe = self.sources.iter().enumerate().all(|(index, waiting)| {
            // A source with a smaller number would go first at an equal time, so the watermark must lie beyond.
            let bound_ns = if index < first {
                time_ns.saturating_add(1)
            } else {
                time_ns
            };
            waiting.ended || !waiting.queue.is_empty() || waiting.watermark_ns >= bound_ns
        });
        if !safe {
            return None;
        }
        self.worked_off_ns = time_ns;
        self.sources[first].queue.pop_front()
    }

    /// Time before which every report has been worked off, once [`Merger::pop`] yields nothing: UTC, nanoseconds.
    /// `i64::MAX` when all sources have ended.
    pub fn safe_ns(&self) -> i64 {
        self.sources
            .iter()
            .map(|waiting| match waiting.queue.front() {
                Some(report) => report.time_of_measurement_ns,
                None if waiting.ended => i64::MAX,
                None => waiting.watermark_ns,
            })
            .min()
            .unwrap_or(i64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn report(source: u16, sequence: u64, time_ns: i64) -> SensorTrack {
        SensorTrack {
            source,
            sequence,
            time_of_measurement_ns: time_ns,
            ..SensorTrack::default()
        }
    }

    #[test]
    fn a_report_waits_until_no_earlier_one_can_come() {
        let mut merger = Merger::new(2, 4);
        merger.push(0, &report(0, 0, 10));
        assert_eq!(merger.pop(), None, "source 1 may still be at 5");
        merger.set_watermark(1, 10);
        assert_eq!(merger.pop().unwrap().source, 0, "source 1 comes second at equal times");
        merger.push(1, &report(1, 0, 20));
        merger.set_watermark(0, 20);
        assert_eq!(merger.pop(), None, "source 0 would go first at 20");
        merger.set_watermark(0, 21);
        assert_eq!(merger.pop().unwrap().source, 1);
        assert_eq!(merger.safe_ns(), 10, "source 1 has said nothing beyond 10");
        merger.end(0);
        merger.end(1);
        assert!(merger.finished());
        assert_eq!(merger.safe_ns(), i64::MAX);
    }

    #[test]
    fn overflow_drops_the_oldest_and_lateness_the_late() {
        let mut merger = Merger::new(1, 2);
        assert_eq!(merger.push(0, &report(0, 0, 1)), PushOutcome::Waiting);
        assert_eq!(merger.push(0, &report(0, 1, 2)), PushOutcome::Waiting);
        assert_eq!(merger.push(0, &report(0, 1, 2)), PushOutcome::Repeated);
        assert_eq!(merger.push(0, &report(0, 2, 3)), PushOutcome::DroppedOldest);
        merger.end(0);
        assert_eq!(merger.pop().unwrap().time_of_measurement_ns, 2);
        assert_eq!(merger.push(0, &report(0, 3, 2)), PushOutcome::OutOfOrder);
    }

    proptest! {
        /// The merged order is the same with any interleaving of deliveries.
        #[test]
        fn the_result_does_not_depend_on_the_interleaving(
            steps in prop::array::uniform3(prop::collection::vec(0i64..5, 0..40)),
            schedule in prop::collection::vec((0usize..3, 1usize..6), 1..200),
        ) {
            let streams: Vec<Vec<SensorTrack>> = steps
                .iter()
                .enumerate()
                .map(|(source, steps)| {
                    let mut time = 0;
                    steps.iter().enumerate().map(|(index, step)| {
                        time += step;
                        report(source as u16, index as u64, time)
                    }).collect()
                })
                .collect();
            let mut expected: Vec<_> = streams.iter().flatten().map(|r| (r.time_of_measurement_ns, r.source, r.sequence)).collect();
            expected.sort_unstable();

            let mut merger = Merger::new(3, 64);
            let mut delivered = [0usize; 3];
            let mut merged = Vec::new();
            let everything = [(0, usize::MAX), (1, usize::MAX), (2, usize::MAX)];
            for (source, count) in schedule.into_iter().chain(everything) {
                let stream = &streams[source];
                for report in &stream[delivered[source]..stream.len().min(delivered[source].saturating_add(count))] {
                    prop_assert_eq!(merger.push(source, report), PushOutcome::Waiting);
                    merger.set_watermark(source, report.time_of_measurement_ns);
                    delivered[source] += 1;
                }
                if delivered[source] == stream.len() {
                    merger.end(source);
                }
                while let Some(report) = merger.pop() {
                    merged.push((report.time_of_measurement_ns, report.source, report.sequence));
                }
            }
            prop_assert!(merger.finished());
            prop_assert_eq!(merged, expected);
        }
    }
}

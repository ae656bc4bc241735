//! Back-pressure for recorded inputs: producers wait for their consumers, so that no sample is lost.
//!
//! On a live system a publisher never waits: a slow reader loses and counts its oldest samples. The replay of a
//! recording can wait, and its users want every report. Each consumer therefore publishes its progress on each topic
//! ([`ConsumerProgress`]), and a producer ([`Flow`]) sends only while no consumer is more than a window behind. The
//! window is a fraction of the topic's depth: a consumer that restarts cannot be overrun, even if the producer's count
//! of its progress is slightly wrong.

use bus::{Bus, Mark, Publisher, Subscriber, Transport};
use messages::{BatchHeader, ProcessKind, Progress, StreamId};

use crate::clock::Now;

/// Minimum time between two requests to a consumer without progress, nanoseconds.
const REPEAT_NS: i64 = 50_000_000;
/// Progress that is published at times waits at most for so many slices, or so long, nanoseconds.
const SLICES_TOGETHER: u32 = 16;
const TOGETHER_NS: i64 = 10_000_000;

/// Producer's side: progress of the consumers of one topic.
#[derive(Debug)]
pub struct Flow<S: Transport> {
    progress: Subscriber<S, Progress>,
    stream: StreamId,
    publisher_incarnation: u64,
    window: u64,
    consumers: Vec<Consumer>,
}

#[derive(Debug)]
struct Consumer {
    kind: ProcessKind,
    latest: Option<Progress>,
    /// Slices sent before the consumer's own count began.
    base: u64,
    /// Slices of this publisher that the consumer has finished since.
    done: u64,
}

impl<S: Transport> Flow<S> {
    /// Follows `consumers` of `stream`, whose topic has a depth of `depth` slices; the publisher is this process, of
    /// epoch `incarnation`.
    ///
    /// # Errors
    /// If the progress topic cannot be opened.
    pub fn new(
        bus: &Bus<S>,
        incarnation: u64,
        stream: StreamId,
        depth: usize,
        consumers: &[ProcessKind],
    ) -> anyhow::Result<Self> {
        let consumer = |kind: &ProcessKind| Consumer {
            kind: *kind,
            latest: None,
            base: 0,
            done: 0,
        };
        Ok(Self {
            progress: bus.subscriber(&messages::progress(), || incarnation)?,
            stream,
            publisher_incarnation: incarnation,
            window: (depth / 4).max(1) as u64,
            consumers: consumers.iter().map(consumer).collect(),
        })
    }

    /// Reads the consumers' progress. `sent` is the number of slices sent so far.
    ///
    /// # Errors
    /// If shared memory fails.
    pub fn update(&mut self, sent: u64) -> anyhow::Result<()> {
        let (stream, publisher, consumers) = (self.stream, self.publisher_incarnation, &mut self.consumers);
        self.progress.take(usize::MAX, |_, said| {
            let of_stream = |said: &&Progress| (said.stream, said.number) == (stream.stream.code(), stream.number);
            for progress in said.iter().filter(of_stream) {
                let of = |consumer: &&mut Consumer| consumer.kind.code() == progress.consumer;
                if let Some(consumer) = consumers.iter_mut().find(of) {
                    consumer.hear(progress, publisher, sent);
                }
            }
        })?;
        Ok(())
    }

    /// Whether progress has been published that [`Flow::update`] has not read yet.
    pub fn has_news(&self) -> bool {
        self.progress.has_slices()
    }

    /// Whether every consumer has joined.
    pub fn all_present(&self) -> bool {
        self.consumers.iter().all(|consumer| consumer.latest.is_some())
    }

    /// Whether another slice may be sent after `sent` slices.
    pub fn may_send(&self, sent: u64) -> bool {
        let behind = |consumer: &Consumer| sent.saturating_sub(consumer.base + consumer.done);
        self.consumers
            .iter()
            .all(|consumer| consumer.latest.is_some() && behind(consumer) < self.window)
    }

    /// Whether every consumer has finished all `sent` slices.
    pub fn all_done(&self, sent: u64) -> bool {
        self.consumers
            .iter()
            .all(|consumer| consumer.latest.is_some() && consumer.base + consumer.done >= sent)
    }

    /// Returns the sequence number of the first sample that a consumer has not finished: a restarted source resumes
    /// there.
    pub fn first_needed(&self) -> u64 {
        let done = |consumer: &Consumer| consumer.latest.map_or(0, |latest| latest.done_sequence);
        self.consumers.iter().map(done).min().unwrap_or(0)
    }
}

impl Consumer {
    fn hear(&mut self, progress: &Progress, publisher_incarnation: u64, sent: u64) {
        // Progress on an earlier publisher of the topic does not count for this publisher.
        self.done = if progress.publisher_incarnation == publisher_incarnation {
            progress.done_batches
        } else {
            0
        };
        let known = self
            .latest
            .is_some_and(|latest| latest.consumer_incarnation == progress.consumer_incarnation);
        if !known {
            self.base = sent.saturating_sub(self.done);
        }
        self.latest = Some(*progress);
    }
}

/// Consumer's side: own progress on each of its topics.
#[derive(Debug)]
pub struct ConsumerProgress<S: Transport> {
    publisher: Publisher<S, Progress>,
    topics: Vec<Progress>,
    changed: bool,
    /// Finished slices that have not been published.
    unsaid: u32,
    said_ns: i64,
}

impl<S: Transport> ConsumerProgress<S> {
    /// Publishes progress as `kind` on `streams`, with the number of the first unfinished sample of each.
    ///
    /// # Errors
    /// If the progress topic cannot be opened.
    pub fn new(bus: &Bus<S>, incarnation: u64, kind: ProcessKind, streams: &[(StreamId, u64)]) -> anyhow::Result<Self> {
        let topic = |(stream, done_sequence): &(StreamId, u64)| Progress {
            consumer_incarnation: incarnation,
            done_sequence: *done_sequence,
            number: stream.number,
            stream: stream.stream.code(),
            consumer: kind.code(),
            ..Progress::default()
        };
        Ok(Self {
            publisher: bus.publisher(&messages::progress(), incarnation)?,
            topics: streams.iter().map(topic).collect(),
            changed: true,
            unsaid: 0,
            said_ns: i64::MIN,
        })
    }

    /// Notes that a slice of the topic at `index` and all samples below `done_sequence` are finished.
    pub fn done(&mut self, index: usize, header: &BatchHeader, done_sequence: u64) {
        let topic = &mut self.topics[index];
        if topic.publisher_incarnation != header.incarnation {
            topic.publisher_incarnation = header.incarnation;
            topic.done_batches = 0;
        }
        topic.done_batches += 1;
        topic.done_sequence = done_sequence;
        topic.progress_ns = topic.progress_ns.max(header.progress_ns);
        self.changed = true;
        self.unsaid += 1;
    }

    /// Publishes progress as [`say`](Self::say) does, but of several slices together: after 16 slices, after 10 ms, or
    /// when the consumer `is_idle`. A producer may then wait for it.
    ///
    /// # Errors
    /// If shared memory fails.
    pub fn say_at_times(&mut self, now: Now, is_idle: bool) -> anyhow::Result<()> {
        let waits = self.unsaid < SLICES_TOGETHER && now.mono_ns < self.said_ns.saturating_add(TOGETHER_NS);
        if waits && !is_idle {
            return Ok(());
        }
        self.say(now)
    }

    /// Publishes changed progress, and repeats it from time to time for producers that join later.
    ///
    /// # Errors
    /// If shared memory fails.
    pub fn say(&mut self, now: Now) -> anyhow::Result<()> {
        if !self.changed && now.mono_ns < self.said_ns.saturating_add(REPEAT_NS) {
            return Ok(());
        }
        let topics = &self.topics;
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: now.mono_ns,
            end: false,
        };
        let said = |index: usize, _| Progress {
            said_ns: now.mono_ns,
            ..topics[index]
        };
        self.publisher.send(mark, topics.len(), said)?;
        self.changed = false;
        self.unsaid = 0;
        self.said_ns = now.mono_ns;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::{InProcess, Root};
    use messages::Stream;

    const NOW: Now = Now {
        mono_ns: 1_000_000_000,
        utc_ns: 0,
    };

    struct Bench {
        _folder: tempfile::TempDir,
        bus: Bus<InProcess>,
        _held: bus::TopicHold,
    }

    impl Bench {
        fn new(name: &str) -> Self {
            let folder = tempfile::tempdir().unwrap();
            let bus = Bus::open(&Root::in_base(folder.path(), name).unwrap(), "test").unwrap();
            let held = bus.hold(&messages::progress()).unwrap();
            Self {
                _folder: folder,
                bus,
                _held: held,
            }
        }

        fn flow(&self, consumers: &[ProcessKind]) -> Flow<InProcess> {
            Flow::new(&self.bus, 7, stream(3), 40, consumers).unwrap()
        }

        fn reached(&self, incarnation: u64, kind: ProcessKind) -> ConsumerProgress<InProcess> {
            ConsumerProgress::new(&self.bus, incarnation, kind, &[(stream(2), 0), (stream(3), 0)]).unwrap()
        }
    }

    fn stream(number: u16) -> StreamId {
        StreamId {
            stream: Stream::SensorTracks,
            number,
        }
    }

    fn slice(publisher_incarnation: u64) -> BatchHeader {
        BatchHeader {
            incarnation: publisher_incarnation,
            ..BatchHeader::default()
        }
    }

    #[test]
    fn nothing_is_sent_before_every_consumer_is_there() {
        let bench = Bench::new("present");
        let mut flow = bench.flow(&[ProcessKind::Fusion, ProcessKind::Recorder]);
        let mut fusion = bench.reached(100, ProcessKind::Fusion);
        fusion.say(NOW).unwrap();
        flow.update(0).unwrap();
        assert!(!flow.all_present() && !flow.may_send(0));
        let mut recorder = bench.reached(101, ProcessKind::Recorder);
        recorder.say(NOW).unwrap();
        flow.update(0).unwrap();
        assert!(flow.all_present() && flow.may_send(0));
    }

    #[test]
    fn the_slowest_consumer_sets_the_pace() {
        let bench = Bench::new("pace");
        let mut flow = bench.flow(&[ProcessKind::Fusion]);
        let mut fusion = bench.reached(100, ProcessKind::Fusion);
        fusion.say(NOW).unwrap();
        flow.update(0).unwrap();
        assert!(flow.may_send(9) && !flow.may_send(10), "a quarter of the depth");
        fusion.done(1, &slice(7), 640);
        fusion.say(NOW).unwrap();
        flow.update(10).unwrap();
        assert!(flow.may_send(10) && !flow.may_send(11));
        assert!(flow.all_done(1) && !flow.all_done(2));
        assert_eq!(flow.first_needed(), 640);
    }

    #[test]
    fn progress_of_many_slices_is_published_together_but_no_producer_waits_for_it() {
        let bench = Bench::new("together");
        let mut flow = bench.flow(&[ProcessKind::Fusion]);
        let mut fusion = bench.reached(100, ProcessKind::Fusion);
        fusion.say(NOW).unwrap();
        let mut done_after = |slices: u32, now: Now, is_idle: bool| {
            (0..slices).for_each(|_| fusion.done(1, &slice(7), 1));
            fusion.say_at_times(now, is_idle).unwrap();
            flow.update(40).unwrap();
            flow.consumers[0].done
        };
        let later = |ns: i64| Now {
            mono_ns: NOW.mono_ns + ns,
            ..NOW
        };
        assert_eq!(done_after(15, later(TOGETHER_NS - 1), false), 0);
        assert_eq!(done_after(1, later(TOGETHER_NS - 1), false), 16, "after 16 slices");
        assert_eq!(done_after(1, later(2 * TOGETHER_NS - 2), false), 16);
        assert_eq!(done_after(0, later(2 * TOGETHER_NS - 1), false), 17, "after 10 ms");
        assert_eq!(
            done_after(1, later(2 * TOGETHER_NS), true),
            18,
            "at once when there is no work"
        );
    }

    #[test]
    fn a_restarted_consumer_starts_from_what_has_been_sent() {
        let bench = Bench::new("consumer");
        let mut flow = bench.flow(&[ProcessKind::Fusion]);
        let mut before = bench.reached(100, ProcessKind::Fusion);
        before.say(NOW).unwrap();
        flow.update(0).unwrap();
        assert!(!flow.may_send(50));
        let mut after = bench.reached(200, ProcessKind::Fusion);
        after.say(NOW).unwrap();
        flow.update(50).unwrap();
        assert!(flow.may_send(50) && !flow.may_send(60));
    }

    #[test]
    fn a_restarted_producer_does_not_count_what_its_predecessor_sent() {
        let bench = Bench::new("producer");
        let mut fusion = bench.reached(100, ProcessKind::Fusion);
        for _ in 0..30 {
            fusion.done(1, &slice(5), 900);
        }
        let mut flow = bench.flow(&[ProcessKind::Fusion]);
        fusion.say(NOW).unwrap();
        flow.update(0).unwrap();
        assert!(flow.may_send(9) && !flow.may_send(10));
        assert!(!flow.all_done(1));
        assert_eq!(flow.first_needed(), 900, "where it resumes");
    }

    #[test]
    fn streams_of_one_number_are_told_apart() {
        let bench = Bench::new("streams");
        let detections = StreamId {
            stream: Stream::Detections,
            number: 3,
        };
        let mut flow = Flow::new(&bench.bus, 7, detections, 40, &[ProcessKind::Fusion]).unwrap();
        let streams = [(stream(3), 0), (detections, 0)];
        let mut fusion = ConsumerProgress::new(&bench.bus, 100, ProcessKind::Fusion, &streams).unwrap();
        fusion.say(NOW).unwrap();
        flow.update(0).unwrap();
        fusion.done(0, &slice(7), 640);
        fusion.say(NOW).unwrap();
        flow.update(1).unwrap();
        assert!(flow.all_present() && !flow.all_done(1));
        fusion.done(1, &slice(7), 64);
        fusion.say(NOW).unwrap();
        flow.update(1).unwrap();
        assert!(flow.all_done(1));
        assert_eq!(flow.first_needed(), 64);
    }
}

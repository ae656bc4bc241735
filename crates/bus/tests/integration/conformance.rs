//! What every transport promises: one suite, run over shared memory and over its twin in the process.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Barrier, mpsc};
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{Home, Line, PATIENCE, mark, send, shared_memory, suite, take_all, topic, track, until};
use bus::{
    Bus, BusError, InProcess, Mark, Payload, PortRole, Publisher, PublisherRecord, ReceiveOutcome, Root, SharedMemory,
    Subscriber, Transport, WaitMode, Waiter, Woken,
};
use messages::layout::Sample as _;
use messages::{BatchHeader, SensorTrack, Topic};
use proptest::prelude::*;

suite! {
    samples_come_in_the_order_in_which_they_were_sent
    a_send_longer_than_a_slice_becomes_several
    only_the_last_slice_of_a_send_carries_its_mark
    an_empty_slice_carries_its_header
    overflow_drops_the_oldest_and_is_counted_exactly
    loss_before_the_first_take_is_counted
    a_late_joiner_has_lost_nothing
    a_budget_is_kept
    a_kept_slice_outlives_its_subscriber
    a_restarted_publisher_starts_a_new_sequence
    two_publishers_are_counted_apart
    what_eight_leavers_left_is_read
    another_layout_is_refused
    slices_of_older_epochs_are_dropped_and_counted_unless_asked_for
    lagging_subscribers_never_exhaust_the_memory
    what_is_taken_or_lost_is_what_was_sent
    a_missing_topic_is_named
    another_type_or_size_is_refused
    places_are_limited_and_come_back
    a_wait_ends_by_time_where_nothing_comes
    what_came_before_the_wait_ends_it
    wake_ups_cross_threads
    a_bus_may_move_to_another_thread
    a_waiting_subscriber_connects_before_the_first_slice
}

fn samples_come_in_the_order_in_which_they_were_sent<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 256, 8);
    let (mut publisher, mut subscriber) = (line.publisher(10), line.subscriber(5));
    for count in [1, 3, 8, 2, 5] {
        send(&mut publisher, count);
    }
    assert_eq!(take_all(&mut subscriber), (0..19).collect::<Vec<_>>());
    let counts = subscriber.counts();
    assert_eq!((counts.taken, counts.slices, counts.lost), (19, 5, 0));
    assert_eq!(publisher.next_sequence(), 19);
    assert!(!subscriber.has_slices());
}

fn a_send_longer_than_a_slice_becomes_several<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 16, 8);
    let (mut publisher, mut subscriber) = (line.publisher(10), line.subscriber(5));
    publisher
        .send(mark(0), 20, |index, sequence| {
            assert_eq!(index as u64, sequence);
            track(sequence)
        })
        .unwrap();
    let mut slices = Vec::new();
    subscriber
        .take(9, |header, samples| {
            slices.push((header.first_sequence, samples.len()));
        })
        .unwrap();
    assert_eq!(slices, [(0, 8), (8, 8), (16, 4)]);
    assert_eq!(publisher.counts().slices, 3);
}

fn only_the_last_slice_of_a_send_carries_its_mark<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 16, 2);
    let (mut publisher, mut subscriber) = (line.publisher(10), line.subscriber(5));
    let mut at = |progress_ns, end, count| {
        let mark = Mark {
            progress_ns,
            sent_ns: progress_ns + 1,
            end,
        };
        publisher.send(mark, count, |_, s| track(s)).unwrap();
    };
    at(100, false, 4);
    at(200, true, 3);
    let mut marks = Vec::new();
    subscriber
        .take(9, |header, _| {
            marks.push((header.progress_ns, header.sent_ns, header.flags));
        })
        .unwrap();
    let end = BatchHeader::END;
    assert_eq!(
        marks,
        [(i64::MIN, 101, 0), (100, 101, 0), (100, 201, 0), (200, 201, end)]
    );
}

fn an_empty_slice_carries_its_header<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 16, 2);
    let (mut publisher, mut subscriber) = (line.publisher(10), line.subscriber(5));
    send(&mut publisher, 2);
    let mark = Mark {
        progress_ns: 7,
        sent_ns: 8,
        end: true,
    };
    publisher.send(mark, 0, |_, _| unreachable!()).unwrap();
    let mut seen = Vec::new();
    subscriber
        .take(9, |header, samples| seen.push((*header, samples.len())))
        .unwrap();
    let (header, length) = seen[1];
    assert_eq!(length, 0);
    assert_eq!(
        header,
        BatchHeader {
            schema: SensorTrack::SCHEMA,
            incarnation: 10,
            first_sequence: 2,
            progress_ns: 7,
            sent_ns: 8,
            flags: BatchHeader::END,
            ..BatchHeader::default()
        }
    );
}

fn overflow_drops_the_oldest_and_is_counted_exactly<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 4, 3);
    let (mut publisher, mut subscriber) = (line.publisher(10), line.subscriber(5));
    send(&mut publisher, 1);
    assert_eq!(take_all(&mut subscriber), [0]);
    for _ in 0..10 {
        send(&mut publisher, 3);
    }
    // Four slices of three wait; the six older ones are gone.
    assert_eq!(take_all(&mut subscriber), (19..31).collect::<Vec<_>>());
    let counts = subscriber.counts();
    assert_eq!((counts.taken, counts.lost), (13, 18));
    assert_eq!(counts.taken + counts.lost, publisher.next_sequence());
}

fn loss_before_the_first_take_is_counted<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 2, 1);
    let mut subscriber = line.subscriber(5);
    let mut publisher = line.publisher(6);
    for _ in 0..5 {
        send(&mut publisher, 1);
    }
    assert_eq!(take_all(&mut subscriber), [3, 4]);
    assert_eq!(subscriber.counts().lost, 3);
}

fn a_late_joiner_has_lost_nothing<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 8, 4);
    let mut publisher = line.publisher(10);
    for _ in 0..5 {
        send(&mut publisher, 4);
    }
    let mut subscriber = line.subscriber(11);
    assert_eq!(take_all(&mut subscriber), []);
    send(&mut publisher, 2);
    assert_eq!(take_all(&mut subscriber), [20, 21]);
    assert_eq!(subscriber.counts().lost, 0);
}

fn a_budget_is_kept<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 8, 4);
    let (mut publisher, mut subscriber) = (line.publisher(10), line.subscriber(5));
    for _ in 0..5 {
        send(&mut publisher, 1);
    }
    let mut take = |budget| {
        let mut seen = 0;
        let taken = subscriber.take(budget, |_, _| seen += 1).unwrap();
        assert_eq!(taken, seen);
        taken
    };
    assert_eq!((take(0), take(3), take(3), take(3)), (0, 3, 2, 0));
}

fn a_kept_slice_outlives_its_subscriber<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 4, 2);
    let (mut publisher, mut subscriber) = (line.publisher(10), line.subscriber(5));
    send(&mut publisher, 2);
    let ReceiveOutcome::Slice(kept) = subscriber.receive().unwrap() else {
        panic!("the slice did not come");
    };
    drop(subscriber);
    let before = kept.samples().to_vec();
    // Slices that wait: one that is taken is written anew before any other.
    let _later = line.subscriber(20);
    for _ in 0..100 {
        send(&mut publisher, 2);
    }
    assert_eq!(kept.samples(), before);
}

fn a_restarted_publisher_starts_a_new_sequence<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 8, 4);
    let mut subscriber = line.subscriber(5);
    let mut publisher = line.publisher(10);
    assert!(!subscriber.has_slices()); // but it has looked, and is connected
    send(&mut publisher, 3);
    drop(publisher);
    let mut publisher = line.publisher(20);
    send(&mut publisher, 2);
    // What the first one sent is not gone with it.
    assert_eq!(take_all(&mut subscriber), [0, 1, 2, 0, 1]);
    let counts = subscriber.counts();
    assert_eq!((counts.taken, counts.lost, counts.out_of_order), (5, 0, 0));
    assert_eq!(heard(&subscriber), [(10, 3), (20, 2)]);
}

fn two_publishers_are_counted_apart<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 2, 4);
    let mut subscriber = line.subscriber(5);
    let (mut one, mut two) = (line.publisher(10), line.publisher(20));
    for _ in 0..4 {
        send(&mut one, 1);
    }
    send(&mut two, 3);
    take_all(&mut subscriber);
    assert_eq!(subscriber.counts().lost, 2);
    send(&mut two, 1);
    send(&mut one, 1);
    take_all(&mut subscriber);
    let counts = subscriber.counts();
    assert_eq!((counts.taken, counts.lost, counts.out_of_order), (7, 2, 0));
    assert_eq!(heard(&subscriber), [(10, 5), (20, 4)]);
}

fn what_eight_leavers_left_is_read<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 8, 4);
    let bus = Bus::<S>::open_for_few(home.root(), "reader").unwrap();
    let mut subscriber = bus.subscriber(&line.topic, || 5).unwrap();
    for incarnation in 10..18 {
        let mut publisher = line.publisher(incarnation);
        assert!(!subscriber.has_slices() || incarnation > 10); // it has looked, and is connected
        send(&mut publisher, 2);
    }
    assert_eq!(take_all(&mut subscriber), [0, 1].repeat(8));
    assert_eq!(subscriber.counts().lost, 0);
}

fn another_layout_is_refused<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 8, 4);
    let (mut publisher, mut subscriber) = (line.publisher(10), line.subscriber(5));
    publisher.pretend_schema(1);
    send(&mut publisher, 3);
    publisher.pretend_schema(SensorTrack::SCHEMA);
    let taken = subscriber.take(9, |_, _| panic!("shown")).unwrap();
    assert_eq!(taken, 1);
    let counts = subscriber.counts();
    assert_eq!((counts.schema_mismatch, counts.taken), (1, 0));
}

fn slices_of_older_epochs_are_dropped_and_counted_unless_asked_for<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 8, 4);
    let (mut old, mut new) = (line.publisher(10).with_epoch(1), line.publisher(20).with_epoch(2));
    let (mut subscriber, mut keeper) = (line.subscriber(5), line.subscriber(5).of_all_epochs());
    for (publisher, count) in [(&mut old, 1), (&mut new, 2)] {
        send(publisher, count);
        assert_eq!(take_all(&mut subscriber).len(), count);
    }
    send(&mut old, 3);
    assert_eq!(take_all(&mut subscriber), [0; 0]);
    send(&mut new, 1);
    assert_eq!(take_all(&mut subscriber), [2]);
    let counts = subscriber.counts();
    assert_eq!((counts.taken, counts.of_older_epochs, counts.lost), (4, 3, 0));
    assert_eq!(subscriber.epoch(), 2);
    assert_eq!(take_all(&mut keeper).len(), 7);
    assert_eq!((keeper.counts().of_older_epochs, keeper.epoch()), (0, 2));
}

fn lagging_subscribers_never_exhaust_the_memory<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 8, 1);
    let mut publisher = line.publisher(10);
    let places = line.topic.capacity.subscribers;
    let mut subscribers: Vec<_> = (0..places).map(|_| line.subscriber(5)).collect();
    for round in 0..400_usize {
        send(&mut publisher, 1);
        // Each one lags in its own way, the first one completely.
        for (index, subscriber) in subscribers.iter_mut().enumerate().skip(1) {
            if round.is_multiple_of(index) {
                subscriber.take(index % 7, |_, _| ()).unwrap();
            }
        }
    }
    assert_eq!(publisher.counts().not_sent, 0);
    for subscriber in &mut subscribers {
        take_all(subscriber);
        let counts = subscriber.counts();
        assert_eq!(counts.taken + counts.lost, 400);
    }
}

/// What a random history is made of.
#[derive(Clone, Copy, Debug)]
enum Deed {
    Send(usize),
    Take(usize),
    Restart,
}

fn deeds() -> impl Strategy<Value = Vec<Deed>> {
    let deed = prop_oneof![
        6 => (0..10_usize).prop_map(Deed::Send),
        4 => (0..6_usize).prop_map(Deed::Take),
        1 => Just(Deed::Restart),
    ];
    prop::collection::vec(deed, 0..60)
}

fn what_is_taken_or_lost_is_what_was_sent<S: Transport>() {
    static CASES: AtomicUsize = AtomicUsize::new(0);
    let home = Home::new();
    let config = ProptestConfig::with_cases(48);
    proptest!(config, |(deeds in deeds())| {
        let name = format!("case-{}", CASES.fetch_add(1, Ordering::Relaxed));
        let line = Line::<S>::new(&home, &name, 4, 3);
        let mut subscriber = line.subscriber(0);
        let mut publisher = line.publisher(1);
        subscriber.has_slices();
        let mut sent = 0;
        let mut previous = std::collections::HashMap::new();
        let mut check = |header: &BatchHeader, samples: &[SensorTrack]| {
            for (sequence, sample) in (header.first_sequence..).zip(samples) {
                assert_eq!(sample.sequence, sequence);
                let previous = previous.insert(header.incarnation, sequence);
                assert!(previous.is_none_or(|previous| previous < sequence));
            }
        };
        for deed in deeds {
            match deed {
                Deed::Send(count) => {
                    send(&mut publisher, count);
                    sent += count as u64;
                }
                Deed::Take(budget) => {
                    subscriber.take(budget, &mut check).unwrap();
                }
                Deed::Restart => {
                    let next = publisher.incarnation() + 1;
                    drop(publisher);
                    publisher = line.publisher(next);
                    subscriber.has_slices();
                }
            }
        }
        while subscriber.take(64, &mut check).unwrap() == 64 {}
        let counts = subscriber.counts();
        prop_assert_eq!(counts.taken + counts.lost, sent);
        prop_assert_eq!(counts.out_of_order, 0);
        prop_assert_eq!(publisher.counts().not_sent, 0);
    });
}

fn a_missing_topic_is_named<S: Transport>() {
    let home = Home::new();
    let bus = home.bus::<S>("test").with_patience(Duration::from_millis(20));
    let error = bus.publisher(&topic("nowhere", 4, 4), 1).unwrap_err();
    assert!(matches!(error, BusError::NoSuchTopic { .. }), "{error}");
    assert!(error.to_string().contains("sensor/nowhere/tracks"));
    assert!(error.to_string().contains("koseki up"));
    let error = bus.subscriber(&topic("nowhere", 4, 4), || 0).unwrap_err();
    assert!(matches!(error, BusError::NoSuchTopic { .. }), "{error}");
}

fn another_type_or_size_is_refused<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 4, 4);
    let deeper = topic("a", 5, 4);
    let error = line.bus.subscriber(&deeper, || 0).unwrap_err();
    assert!(matches!(error, BusError::Incompatible { .. }), "{error}");
    let error = line.bus.hold(&deeper).unwrap_err();
    assert!(matches!(error, BusError::Incompatible { .. }), "{error}");
    let mut other_type = messages::health();
    other_type.name = line.topic.name.clone();
    let error = line.bus.publisher(&other_type, 0).unwrap_err();
    assert!(matches!(error, BusError::Incompatible { .. }), "{error}");
}

fn places_are_limited_and_come_back<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 4, 4);
    let limit = line.topic.capacity.publishers;
    let mut publishers: Vec<_> = (0..limit).map(|i| line.publisher(i as u64)).collect();
    let error = line.bus.publisher(&line.topic, 9).unwrap_err();
    let expected = matches!(
        error,
        BusError::Full { role: PortRole::Publisher, limit: stated, .. } if stated == limit
    );
    assert!(expected, "{error}");
    publishers.pop();
    line.publisher(9);
}

/// Wake-ups that may be found by the backstop only. A waiter that is never woken misses them all; a machine that stands
/// still at the wrong moment looks like a few.
const MISSED_MAX: u64 = 3;

const MODES: [WaitMode; 3] = [WaitMode::Spin, WaitMode::Event, WaitMode::Hybrid { spin_ns: 20_000 }];

fn a_wait_ends_by_time_where_nothing_comes<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 4, 4);
    let subscriber = line.subscriber(0);
    for mode in MODES {
        let mut waiter = line.bus.waiter(mode);
        waiter.watch(&line.bus, &line.topic).unwrap();
        let time = Duration::from_millis(2);
        let start = Instant::now();
        let woken = waiter.wait(time, || subscriber.has_slices()).unwrap();
        assert_eq!(woken, Woken::Timeout);
        assert!(start.elapsed() >= time);
    }
}

fn what_came_before_the_wait_ends_it<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 64, 4);
    let (mut publisher, mut subscriber) = (line.publisher(10), line.subscriber(5));
    for mode in MODES {
        let mut waiter = line.bus.waiter(mode);
        waiter.watch(&line.bus, &line.topic).unwrap();
        for _ in 0..5 {
            send(&mut publisher, 1);
        }
        // Even if the first question comes too early, the notification is still there.
        let mut early = true;
        let woken = waiter
            .wait(PATIENCE, || !std::mem::take(&mut early) && subscriber.has_slices())
            .unwrap();
        assert_eq!(woken, Woken::Work);
        assert_eq!(take_all(&mut subscriber).len(), 5);
        let nothing = waiter
            .wait(Duration::from_millis(1), || subscriber.has_slices())
            .unwrap();
        assert_eq!(nothing, Woken::Timeout);
    }
}

/// Two threads hand one sample to and fro over two topics, so that each must be woken for each sample.
fn wake_ups_cross_threads<S: Transport>() {
    const ROUNDS: u32 = 300;
    for mode in MODES {
        let home = Home::new();
        let there = Line::<S>::new(&home, "there", 4, 4);
        let back = Line::<S>::new(&home, "back", 4, 4);
        let ready = Barrier::new(2);
        let missed = thread::scope(|scope| {
            let (root, ready) = (home.root(), &ready);
            let (hears, says) = (&there.topic, &back.topic);
            scope.spawn(move || {
                let mut end = End::<S>::new(root, hears, says, mode);
                ready.wait();
                for _ in 0..ROUNDS {
                    end.receive();
                    send(&mut end.publisher, 1);
                }
            });
            let mut end = End::<S>::new(root, says, hears, mode);
            ready.wait();
            for _ in 0..ROUNDS {
                send(&mut end.publisher, 1);
                end.receive();
            }
            end.waiter.missed_wake_ups()
        });
        assert!(missed <= MISSED_MAX, "{mode:?}: {missed} of {ROUNDS} not woken");
    }
}

/// One end of the exchange above.
struct End<S: Transport> {
    publisher: Publisher<S, SensorTrack>,
    subscriber: Subscriber<S, SensorTrack>,
    waiter: Waiter<S>,
}

impl<S: Transport> End<S> {
    fn new(root: &Root, hears: &Topic<SensorTrack>, says: &Topic<SensorTrack>, mode: WaitMode) -> Self {
        let bus = Bus::<S>::open(root, "end").unwrap();
        let mut waiter = bus.waiter(mode);
        waiter.watch(&bus, hears).unwrap();
        Self {
            publisher: bus.publisher(says, 10).unwrap(),
            subscriber: bus.subscriber(hears, || 0).unwrap(),
            waiter,
        }
    }

    /// Waits for one sample.
    fn receive(&mut self) {
        let subscriber = &mut self.subscriber;
        let woken = self.waiter.wait(PATIENCE, || subscriber.has_slices());
        assert_eq!(woken.unwrap(), Woken::Work);
        assert_eq!(take_all(subscriber).len(), 1);
    }
}

fn a_bus_may_move_to_another_thread<S: Transport>() {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 64, 4);
    let mut publisher = line.publisher(10);
    let (bus, topic) = (home.bus::<S>("other"), line.topic.clone());
    let (ready, there) = mpsc::channel();
    let other = thread::spawn(move || {
        let mut subscriber = bus.subscriber(&topic, || 11).unwrap();
        ready.send(()).unwrap();
        let mut taken = 0;
        until("nine samples", || {
            taken += take_all(&mut subscriber).len();
            taken == 9
        });
    });
    there.recv().unwrap();
    send(&mut publisher, 9);
    other.join().unwrap();
}

fn a_waiting_subscriber_connects_before_the_first_slice<S: Transport>() {
    const ROUNDS: u64 = 10;
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 4, 4);
    let mut subscriber = line.subscriber(5);
    let mut waiter = line.bus.waiter(WaitMode::Event);
    waiter.watch(&line.bus, &line.topic).unwrap();
    for round in 0..ROUNDS {
        let mut publisher = line.publisher(10 + round);
        let mut questions = 0;
        let woken = waiter.wait(PATIENCE, || {
            questions += 1;
            questions > 1 || subscriber.has_slices()
        });
        assert_eq!(woken.unwrap(), Woken::Work);
        send(&mut publisher, 2);
        drop(publisher);
        assert_eq!(take_all(&mut subscriber), [0, 1]);
        waiter.wait(Duration::ZERO, || false).unwrap();
    }
    let missed = waiter.missed_wake_ups();
    assert!(missed <= MISSED_MAX, "{missed} of {ROUNDS} not woken");
}

fn heard<S: Transport, T: Payload>(subscriber: &Subscriber<S, T>) -> Vec<(u64, u64)> {
    let pair = |heard: PublisherRecord| (heard.incarnation, heard.next_sequence);
    subscriber.heard().map(pair).collect()
}

#[test]
fn the_twin_in_the_process_leaves_no_file() {
    let home = Home::unclaimed();
    let line = Line::<InProcess>::new(&home, "a", 4, 4);
    let _ports = (line.publisher(1), line.subscriber(0));
    assert!(shared_memory(home.root()).is_empty());
    assert!(!home.root().path().exists());
}

#[test]
fn needed_space_covers_what_is_really_taken() {
    let home = Home::new();
    let line = Line::<SharedMemory>::new(&home, "a", 64, 64);
    let places = line.topic.capacity.subscribers;
    let subscribers: Vec<_> = (0..places).map(|_| line.subscriber(0)).collect();
    let mut publisher = line.publisher(1);
    for _ in 0..1000 {
        send(&mut publisher, 64);
    }
    let folder = std::path::Path::new("/dev/shm");
    let taken: u64 = shared_memory(home.root())
        .iter()
        .map(|name| folder.join(name).metadata().unwrap())
        .map(|found| std::os::unix::fs::MetadataExt::blocks(&found) * 512)
        .sum();
    let needed = bus::needed_bytes(&line.topic, 1);
    assert!(taken <= needed, "{taken} taken, {needed} reckoned with");
    assert!(bus::free_space().unwrap() > 0);
    assert!(bus::check_space(0).is_ok());
    let error = bus::check_space(u64::MAX).unwrap_err();
    assert!(error.to_string().contains(&u64::MAX.to_string()));
    drop(subscribers);
}

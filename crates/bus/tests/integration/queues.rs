//! Length of a subscriber's queue, up to the number with which the topic is held.

use std::os::unix::fs::MetadataExt as _;
use std::path::Path;

use bus::{BusError, SharedMemory, Transport};

use crate::common::{Home, Line, send, shared_memory, suite, take_all, topic};

suite! {
    loses_nothing_with_a_longer_queue
    too_long_a_queue_is_refused_with_the_limit
    readers_with_the_longest_queues_never_exhaust_the_memory
}

/// Length of the queue of a subscriber that requests none.
const USUAL: usize = 16;
/// Number with which the topic is held.
const LONGEST: usize = 128;

/// A topic held with the longest queues, whose users expect the usual queues.
fn line<S: Transport>(home: &Home) -> Line<S> {
    let mut line = Line::new(home, "a", LONGEST, 4);
    line.topic.capacity.depth = USUAL;
    line
}

fn loses_nothing_with_a_longer_queue<S: Transport>() {
    let home = Home::new();
    let line = line::<S>(&home);
    let lengths = [1, USUAL - 1, USUAL + 1, LONGEST];
    let mut readers = vec![(USUAL, line.subscriber(5))];
    for length in lengths {
        let subscriber = line.bus.subscriber_with_queue(&line.topic, length, || 5);
        readers.push((length, subscriber.unwrap()));
    }
    let mut publisher = line.publisher(10);
    for round in 1..=3 {
        (0..LONGEST).for_each(|_| send(&mut publisher, 1));
        for (length, reader) in &mut readers {
            assert_eq!(take_all(reader).len(), *length);
            assert_eq!(reader.counts().lost as usize, round * (LONGEST - *length));
        }
    }
    assert_eq!(publisher.counts().not_sent, 0);
}

fn too_long_a_queue_is_refused_with_the_limit<S: Transport>() {
    let home = Home::new();
    let line = line::<S>(&home);
    for length in [0, LONGEST + 1] {
        let refused = line.bus.subscriber_with_queue(&line.topic, length, || 5).unwrap_err();
        let BusError::Queue { queue, limit, .. } = refused else {
            panic!("{refused}")
        };
        assert_eq!((queue, limit), (length, LONGEST));
    }
}

fn readers_with_the_longest_queues_never_exhaust_the_memory<S: Transport>() {
    let home = Home::new();
    let line = line::<S>(&home);
    let mut publisher = line.publisher(10);
    let places = line.topic.capacity.subscribers;
    let subscriber = || line.bus.subscriber_with_queue(&line.topic, LONGEST, || 5).unwrap();
    let mut subscribers: Vec<_> = (0..places).map(|_| subscriber()).collect();
    let sent = 6 * LONGEST;
    for round in 0..sent {
        send(&mut publisher, 1);
        // Each subscriber lags in its own way, the first one completely.
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
        assert_eq!((counts.taken + counts.lost) as usize, sent);
    }
}

#[test]
fn needed_space_grows_with_the_longest_queue_and_covers_what_is_taken() {
    let home = Home::new();
    let line = line::<SharedMemory>(&home);
    let places = line.topic.capacity.subscribers;
    let subscriber = || line.bus.subscriber_with_queue(&line.topic, LONGEST, || 5).unwrap();
    let subscribers: Vec<_> = (0..places).map(|_| subscriber()).collect();
    let mut publisher = line.publisher(10);
    (0..6 * LONGEST).for_each(|_| send(&mut publisher, 4));
    let folder = Path::new("/dev/shm");
    let taken: u64 = shared_memory(home.root())
        .iter()
        .map(|name| folder.join(name).metadata().unwrap().blocks() * 512)
        .sum();
    let needed = |length| bus::needed_bytes(&topic("a", length, 4), 1);
    assert!(taken <= needed(LONGEST), "{taken} taken, {} computed", needed(LONGEST));
    // Two slices for each further place of the queue, besides the entries of the queues.
    let slices = 2 * 4 * size_of::<messages::SensorTrack>() * (LONGEST - USUAL);
    assert!(needed(LONGEST) - needed(USUAL) > slices as u64);
    drop(subscribers);
}

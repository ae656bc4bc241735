//! Publishers' lines in shared memory.

use std::fs::{self, OpenOptions};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};

use crate::common::{Home, Line, send, shared_memory, take_all, track};
use bus::{Mark, PublisherState, SharedMemory};

const DEPTH: usize = 4;

fn line(home: &Home) -> Line<SharedMemory> {
    Line::new(home, "a", DEPTH, 4)
}

/// The file of the topic's lines.
fn file(home: &Home) -> PathBuf {
    let names = shared_memory(home.root());
    let name = names.iter().find(|name| name.contains("lines.")).unwrap();
    Path::new("/dev/shm").join(name)
}

#[test]
fn a_line_says_how_far_its_publisher_came_and_when() {
    let home = Home::new();
    let line = line(&home);
    let mut publisher = line.publisher(7);
    let mark = Mark {
        progress_ns: 0,
        sent_ns: 123,
        end: false,
    };
    publisher.send(mark, 5, |_, sequence| track(sequence)).unwrap();
    let read = || line.bus.publisher_lines(&line.topic).unwrap();
    let living = read();
    assert_eq!(living.len(), 1);
    assert_eq!((living[0].incarnation, living[0].next_sequence), (7, 5));
    assert_eq!((living[0].heartbeat_ns, living[0].life), (123, PublisherState::Lives));
    line.bus.remove_dead();
    assert_eq!(read(), living, "whoever lives is not marked");
    drop(publisher);
    let ended = read();
    assert_eq!((ended[0].next_sequence, ended[0].life), (5, PublisherState::Ended));
}

#[test]
fn publishers_that_came_and_went_between_two_looks_are_counted() {
    let home = Home::new();
    let line = line(&home);
    let mut subscriber = line.subscriber(10);
    for incarnation in 10..13 {
        let mut publisher = line.publisher(incarnation);
        send(&mut publisher, 3);
    }
    let mut older = line.publisher(9);
    send(&mut older, 3);
    drop(older);
    let taken = take_all(&mut subscriber).len() as u64;
    let counts = subscriber.counts();
    assert_eq!(
        taken + counts.lost,
        9,
        "and nothing of what began before the subscriber"
    );
    let mut late = line.subscriber(0);
    assert!(take_all(&mut late).is_empty());
    assert_eq!(
        late.counts().lost,
        0,
        "what ended before the subscriber joined is not its loss"
    );
}

#[test]
fn lines_are_filled_again_and_every_end_is_told_once() {
    let home = Home::new();
    let line = line(&home);
    let mut subscriber = line.subscriber(0);
    let (mut sent, rounds) = (0, 5 * line.topic.capacity.publishers);
    for round in 0..rounds {
        let mut publisher = line.publisher(round as u64);
        send(&mut publisher, 1 + round % 3);
        sent += 1 + round as u64 % 3;
        drop(publisher);
        take_all(&mut subscriber);
        let counts = subscriber.counts();
        assert_eq!(counts.taken + counts.lost, sent);
    }
    assert!(line.bus.publisher_lines(&line.topic).unwrap().len() <= 2 * line.topic.capacity.publishers);
}

#[test]
fn garbage_in_the_lines_is_not_believed() {
    let home = Home::new();
    let line = line(&home);
    let mut subscriber = line.subscriber(0);
    let mut publisher = line.publisher(1);
    send(&mut publisher, 1);
    let path = file(&home);
    let length = fs::metadata(&path).unwrap().len() as usize;
    let shared = OpenOptions::new().write(true).open(&path).unwrap();
    for seed in 1..50_u8 {
        let garbage: Vec<u8> = (0..length)
            .map(|index| (index as u8).wrapping_mul(37).wrapping_add(seed).rotate_left(3))
            .collect();
        shared.write_all_at(&garbage, 0).unwrap();
        send(&mut publisher, 1);
        take_all(&mut subscriber);
        line.bus.remove_dead();
        line.bus.publisher_lines(&line.topic).unwrap();
    }
    let counts = subscriber.counts();
    assert_eq!((counts.taken, counts.lost), (50, 0));
    let other = line.publisher(2);
    drop(other);
}

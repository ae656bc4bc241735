//! The line of a publisher: a publisher, its successor in the line, and a reader, in all orders of operations.

use loom::sync::Arc;
use loom::sync::atomic::Ordering;

use crate::atomic::{Weakness, check, fence};
use crate::last_words::{
    ENDED, EndsSeen, Identity, LIVES, Line, LineHead, PublisherLine, PublisherState, fold, word_of,
};

/// A process that starts all its publishers with one incarnation, as the services do.
const NODE: u128 = 7;
const SCHEMA: u64 = 9;

/// A topic with one line.
#[derive(Default)]
struct TopicModel {
    head: LineHead,
    line: [Line; 1],
}

impl TopicModel {
    /// A publisher of `node` has the line from its first word to its last, and numbers `samples`.
    fn publish(&self, before: u64, node: u128, origin: u128, samples: u64) -> bool {
        let who = Identity {
            node,
            origin,
            incarnation: 3,
            schema: SCHEMA,
        };
        let line = &self.line[0];
        let has_begun = line.begin(before, &who);
        if has_begun {
            line.number(samples);
            line.mark(&self.head, word_of(node) | LIVES, ENDED);
        }
        has_begun
    }

    /// Of the first publisher, with one sample.
    fn with_an_ended_line() -> Arc<Self> {
        let topic = Self::default();
        assert!(topic.publish(0, NODE, 1, 1));
        Arc::new(topic)
    }
}

/// Whether the words are those of one publisher: the first with one sample, or the second with two.
fn are_of_one(line: &PublisherLine) -> bool {
    let is_first = line.origin == fold(1) && line.next_sequence == 1;
    let is_second = line.origin == fold(2) && line.next_sequence == 2;
    let has_begun = line.origin == fold(2) && line.next_sequence == 0;
    match line.life {
        PublisherState::Lives => is_second || has_begun,
        PublisherState::Ended | PublisherState::Died => is_first || is_second,
    }
}

/// A second publisher of process `node` takes the line over while `read` reads.
fn take_over(weakness: Weakness, node: u128, read: fn(&Line) -> Option<PublisherLine>) {
    check(weakness, move || {
        let topic = TopicModel::with_an_ended_line();
        let successor = Arc::clone(&topic);
        loom::thread::spawn(move || successor.publish(word_of(NODE) | ENDED, node, 2, 2));
        let found = read(&topic.line[0]);
        assert!(
            found.is_none_or(|line| are_of_one(&line)),
            "two publishers in one line: {found:?}"
        );
    });
}

/// Without the second look: the check alone, which does not cover the numbers.
fn read_once(line: &Line) -> Option<PublisherLine> {
    let check = line.check.load(Ordering::Acquire);
    line.look(check, line.owner.load(Ordering::Acquire))
}

/// With a second look at the owner's word only, which a process brings back when it takes its own line over.
fn read_by_owner(line: &Line) -> Option<PublisherLine> {
    let owner = line.owner.load(Ordering::Acquire);
    let found = line.look(line.check.load(Ordering::Acquire), owner)?;
    fence(Ordering::Acquire);
    (line.owner.load(Ordering::Acquire) == owner).then_some(found)
}

#[test]
fn no_reader_mixes_two_publishers_of_one_process_or_of_two() {
    take_over(Weakness::None, NODE, Line::read);
    take_over(Weakness::None, NODE + 1, Line::read);
}

#[test]
#[should_panic = "two publishers in one line"]
fn a_publisher_without_a_fence_is_mixed_with_its_predecessor() {
    take_over(Weakness::ReleaseFences, NODE, Line::read);
}

#[test]
#[should_panic = "two publishers in one line"]
fn a_reader_without_a_fence_mixes_two_publishers() {
    take_over(Weakness::AcquireFences, NODE, Line::read);
}

#[test]
#[should_panic = "two publishers in one line"]
fn a_publisher_that_does_not_release_is_mixed_with_its_predecessor() {
    take_over(Weakness::Stores, NODE, Line::read);
}

#[test]
#[should_panic = "two publishers in one line"]
fn a_reader_that_does_not_acquire_mixes_two_publishers() {
    take_over(Weakness::Loads, NODE, Line::read);
}

#[test]
#[should_panic = "two publishers in one line"]
fn a_reader_without_the_second_look_mixes_two_publishers() {
    take_over(Weakness::None, NODE, read_once);
}

#[test]
#[should_panic = "two publishers in one line"]
fn a_reader_that_compares_owners_only_mixes_two_publishers_of_one_process() {
    take_over(Weakness::None, NODE, read_by_owner);
}

#[test]
fn one_of_two_publishers_gets_the_line() {
    check(Weakness::None, || {
        let topic = TopicModel::with_an_ended_line();
        let other = Arc::clone(&topic);
        let ended = word_of(NODE) | ENDED;
        let other = loom::thread::spawn(move || other.publish(ended, NODE + 1, 2, 2));
        let own = topic.publish(ended, NODE + 2, 3, 3);
        assert_ne!(own, other.join().unwrap());
    });
}

/// A publisher ends, and a subscriber asks for news once the count of ends has changed.
fn end(weakness: Weakness) {
    check(weakness, || {
        let topic = Arc::new(TopicModel::default());
        let mut ends = EndsSeen::from_now_on(&topic.head, &topic.line, SCHEMA);
        let publisher = Arc::clone(&topic);
        loom::thread::spawn(move || publisher.publish(0, NODE, 2, 2));
        while topic.head.ends.load(Ordering::Relaxed) == 0 {
            loom::thread::yield_now();
        }
        let mut told = Vec::new();
        assert!(ends.news(&topic.head, &topic.line));
        ends.settle(|line| told.push(line.next_sequence));
        assert_eq!(told, [2], "an end was overlooked");
    });
}

#[test]
fn no_end_is_overlooked() {
    end(Weakness::None);
}

#[test]
#[should_panic = "an end was overlooked"]
fn an_end_whose_count_does_not_release_is_overlooked() {
    end(Weakness::Stores);
}

#[test]
#[should_panic = "an end was overlooked"]
fn an_end_whose_count_is_not_acquired_is_overlooked() {
    end(Weakness::Loads);
}

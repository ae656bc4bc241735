//! The hint of a topic: two publishers and a reader, in all orders of operations.

use loom::sync::Arc;
use loom::sync::atomic::Ordering;

use crate::atomic::{AtomicU64, Weakness, check};
use crate::sends::{ReceivedSends, Word as _};

/// A topic: a queue for each publisher, with nothing but the word to order them.
#[derive(Default)]
struct TopicModel {
    queues: [AtomicU64; 2],
    word: AtomicU64,
}

/// The reader of a topic.
#[derive(Default)]
struct ReaderModel {
    received: ReceivedSends,
    taken: [u64; 2],
}

impl ReaderModel {
    /// Takes slices while the hint allows.
    fn work(&mut self, topic: &TopicModel) {
        while !self.received.are_all(&topic.word) {
            let before = topic.word.value();
            let found_nothing = !self.take(topic);
            self.received.note(before, found_nothing);
        }
    }

    /// Likewise, with the word read after each look: a send in between is taken for received.
    fn work_without_order(&mut self, topic: &TopicModel) {
        while !self.received.are_all(&topic.word) {
            let found_nothing = !self.take(topic);
            self.received.note(topic.word.value(), found_nothing);
        }
    }

    /// Takes a slice; `false` if none waits.
    fn take(&mut self, topic: &TopicModel) -> bool {
        let mut queues = self.taken.iter_mut().zip(&topic.queues);
        let next = queues.find(|(taken, queue)| **taken < queue.load(Ordering::Relaxed));
        let Some((taken, _)) = next else { return false };
        *taken += 1;
        true
    }
}

/// Publishers that send so many slices each; the reader works meanwhile, and once more when the word has all sends.
fn model(weakness: Weakness, slices: [u64; 2], work: fn(&mut ReaderModel, &TopicModel)) {
    check(weakness, move || {
        let topic = Arc::new(TopicModel::default());
        for publisher in (0..slices.len()).filter(|publisher| slices[*publisher] > 0) {
            let topic = Arc::clone(&topic);
            loom::thread::spawn(move || {
                for slice in 1..=slices[publisher] {
                    topic.queues[publisher].store(slice, Ordering::Relaxed);
                    topic.word.raise();
                }
            });
        }
        let mut reader = ReaderModel::default();
        work(&mut reader, &topic);
        // Not by the ends of the threads, which would show everything whatever the order.
        while topic.word.load(Ordering::Relaxed) < slices.iter().sum() {
            loom::thread::yield_now();
        }
        work(&mut reader, &topic);
        assert_eq!(reader.taken, slices, "a slice was overlooked");
    });
}

#[test]
fn no_slice_is_overlooked_whatever_the_order_of_operations() {
    model(Weakness::None, [2, 0], ReaderModel::work);
    model(Weakness::None, [1, 1], ReaderModel::work);
}

#[test]
#[should_panic = "a slice was overlooked"]
fn a_word_that_does_not_release_overlooks_slices() {
    model(Weakness::Stores, [1, 0], ReaderModel::work);
}

#[test]
#[should_panic = "a slice was overlooked"]
fn a_reader_that_does_not_acquire_overlooks_slices() {
    model(Weakness::Loads, [1, 0], ReaderModel::work);
}

#[test]
#[should_panic = "a slice was overlooked"]
fn a_reader_that_reads_the_word_after_the_queue_overlooks_slices() {
    model(Weakness::None, [1, 0], ReaderModel::work_without_order);
}

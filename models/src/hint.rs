//! The hint of a topic: two publishers and a reader, in all orders of operations.

use loom::sync::Arc;
use loom::sync::atomic::{AtomicU64, Ordering};

use crate::sends::{ReceivedSends, Word};

impl Word for AtomicU64 {
    fn raise(&self) {
        self.fetch_add(1, Ordering::Release);
    }

    fn value(&self) -> u64 {
        self.load(Ordering::Acquire)
    }
}

/// Most changes of the running thread, apart from waits, in a checked order.
const PREEMPTIONS: usize = 3;

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
            let mut queues = self.taken.iter_mut().zip(&topic.queues);
            let next = queues.find(|(taken, queue)| **taken < queue.load(Ordering::Relaxed));
            self.received.note(before, next.is_none());
            if let Some((taken, _)) = next {
                *taken += 1;
            }
        }
    }
}

/// Publishers that send so many slices each; the reader works meanwhile, and once more after their ends.
fn model(slices: [u64; 2]) {
    let mut model = loom::model::Builder::new();
    // Without a bound, the orders of three threads take hours.
    model.preemption_bound = Some(PREEMPTIONS);
    model.check(move || {
        let topic = Arc::new(TopicModel::default());
        let publishers: Vec<_> = (0..slices.len())
            .filter(|publisher| slices[*publisher] > 0)
            .map(|publisher| {
                let topic = Arc::clone(&topic);
                loom::thread::spawn(move || {
                    for slice in 1..=slices[publisher] {
                        topic.queues[publisher].store(slice, Ordering::Relaxed);
                        topic.word.raise();
                    }
                })
            })
            .collect();
        let mut reader = ReaderModel::default();
        reader.work(&topic);
        publishers.into_iter().for_each(|publisher| publisher.join().unwrap());
        reader.work(&topic);
        assert_eq!(reader.taken, slices, "a slice was overlooked");
    });
}

#[test]
fn no_slice_is_overlooked_whatever_the_order_of_operations() {
    model([2, 0]);
    model([1, 1]);
}

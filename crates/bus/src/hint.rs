//! Hint of a topic: a word that changes after each send.
//!
//! A look into an empty queue of iceoryx2 costs some 400 instructions, and a spinning reader of several topics mostly
//! looks into empty queues. Therefore each publisher increments a word of the topic after a slice has entered the
//! queues. A reader that found its queue empty looks again when the word has changed: one load of a cache line that is
//! written by senders only.
//!
//! The word is a hint, not the truth: a publisher in another language never touches the word, and a publisher may be
//! killed between the queue and the word. Readers therefore look fully at times as well, and after each wake-up.
//!
//! # No slice of a living publisher of this crate is overlooked
//! The publisher writes the queue, and then increments the word (release). A reader reads the word (acquire) before it
//! looks into the queue. If the queue is empty, it has received all sends up to that value of the word; from then on it
//! counts received slices. It looks again while its count differs from the word.
//!
//! The count never exceeds the number of received sends. Once all increments are visible, the word is the number of
//! sends: if the two are equal, nothing waits. Only while an increment is still missing (a slice was received before its
//! publisher incremented the word), a slice of another publisher may wait unseen. A publisher that is killed at this
//! moment, or gives no hint, makes this last until the next full look. After an overflow the count is too small, and the
//! reader looks until the queue is empty. The tests check the protocol in all orders of operations with `loom`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::{Acquire, Release};
use std::sync::{Arc, LazyLock, Mutex, PoisonError, Weak};

use messages::TopicName;

use crate::line::Lines;

/// The word of a topic.
pub(crate) trait Word {
    /// States that a slice has entered the queues.
    fn raise(&self);
    /// Present value.
    fn value(&self) -> u64;
}

macro_rules! word {
    ($atomic:ty) => {
        impl Word for $atomic {
            #[inline]
            fn raise(&self) {
                self.fetch_add(1, Release);
            }

            #[inline]
            fn value(&self) -> u64 {
                self.load(Acquire)
            }
        }
    };
}

word!(AtomicU64);

/// A reader's count of the sends that it has received.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ReceivedSends {
    /// In the terms of the word; `None` before the first empty queue.
    count: Option<u64>,
}

impl ReceivedSends {
    /// Whether all sends have been received, as far as the word shows.
    #[inline]
    pub(crate) fn are_all(self, word: &impl Word) -> bool {
        self.count == Some(word.value())
    }

    /// Notes the result of a look: a slice, or nothing; `before` is the word before the look.
    #[inline]
    pub(crate) fn note(&mut self, before: u64, found_nothing: bool) {
        self.count = match found_nothing {
            true => Some(before),
            false => self.count.map(|count| count.wrapping_add(1)),
        };
    }
}

/// The word of a topic, in the memory of the topic's lines or of the process.
#[derive(Debug)]
pub(crate) enum Hint {
    Shared(Lines),
    InProcess(Arc<AtomicU64>),
}

impl Hint {
    /// The word of `topic` among the users of `root` in this process.
    pub(crate) fn in_process(root: &Path, topic: &TopicName) -> Self {
        type Words = HashMap<(PathBuf, String), Weak<AtomicU64>>;
        static WORDS: LazyLock<Mutex<Words>> = LazyLock::new(Mutex::default);
        let mut words = WORDS.lock().unwrap_or_else(PoisonError::into_inner);
        words.retain(|_, word| word.strong_count() > 0);
        let place = words.entry((root.to_owned(), topic.as_str().to_owned())).or_default();
        Self::InProcess(place.upgrade().unwrap_or_else(|| {
            let word = Arc::default();
            *place = Arc::downgrade(&word);
            word
        }))
    }

    #[inline]
    pub(crate) fn word(&self) -> &AtomicU64 {
        match self {
            Self::Shared(lines) => lines.sends(),
            Self::InProcess(word) => word,
        }
    }
}

#[cfg(test)]
mod tests {
    use loom::sync::Arc;
    use loom::sync::atomic::{AtomicU64, Ordering};

    use super::*;

    word!(AtomicU64);

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

    #[test]
    fn the_word_of_a_topic_is_the_same_in_the_whole_process() {
        let topic = messages::sensor_tracks("a").name;
        let [first, second] = [(); 2].map(|()| Hint::in_process(Path::new("/hint"), &topic));
        let other = Hint::in_process(Path::new("/other"), &topic);
        first.word().raise();
        assert_eq!((second.word().value(), other.word().value()), (1, 0));
        drop((first, second));
        assert_eq!(Hint::in_process(Path::new("/hint"), &topic).word().value(), 0);
    }
}

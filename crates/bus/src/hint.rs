//! Hint of a topic: a word that changes after each send.
//!
//! A look into an empty queue of iceoryx2 costs some 400 instructions, and a spinning reader of several topics mostly
//! looks into empty queues. Therefore each publisher increments a word of the topic after a slice has entered the
//! queues. A reader that found an empty queue looks again when the word has changed: one load of a cache line that is
//! written by senders only.
//!
//! The word is a hint, not the truth: a publisher in another language never touches the word, and a publisher may be
//! killed between the queue and the word. Readers therefore look fully at times as well, and after each wake-up.
//!
//! The protocol of both sides is in `sends`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, LazyLock, Mutex, PoisonError, Weak};

use messages::TopicName;

use crate::line::Lines;

/// The words of a topic, in the memory of the topic's lines or of the process.
#[derive(Debug)]
pub(crate) enum Hint {
    Shared(Lines),
    InProcess(Arc<Words>),
}

/// The words of a topic in a process.
#[derive(Debug, Default)]
pub(crate) struct Words {
    sends: AtomicU64,
    listeners: AtomicU64,
}

impl Hint {
    /// The word of `topic` among the users of `root` in this process.
    pub(crate) fn in_process(root: &Path, topic: &TopicName) -> Self {
        type OfTopics = HashMap<(PathBuf, String), Weak<Words>>;
        static WORDS: LazyLock<Mutex<OfTopics>> = LazyLock::new(Mutex::default);
        let mut words = WORDS.lock().unwrap_or_else(PoisonError::into_inner);
        words.retain(|_, word| word.strong_count() > 0);
        let place = words.entry((root.to_owned(), topic.as_str().to_owned())).or_default();
        Self::InProcess(place.upgrade().unwrap_or_else(|| {
            let words = Arc::default();
            *place = Arc::downgrade(&words);
            words
        }))
    }

    #[inline]
    pub(crate) fn word(&self) -> &AtomicU64 {
        match self {
            Self::Shared(lines) => lines.sends(),
            Self::InProcess(words) => &words.sends,
        }
    }

    /// The word that changes with each new listener.
    #[inline]
    pub(crate) fn listeners(&self) -> &AtomicU64 {
        match self {
            Self::Shared(lines) => lines.listeners(),
            Self::InProcess(words) => &words.listeners,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sends::Word as _;
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

//! Messages of a topic that were sent lately, for readers that miss some.
//!
//! The network drops messages sent during an interruption. A reader detects the gap by the next sequence numbers, and
//! requests everything after its own position. The history answers from its bounded memory.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use messages::{BatchHeader, SensorTrack};

use crate::wire::{self, Head, Message};

/// Size at which an answer begins another message.
const ANSWER_BYTES: usize = 1 << 20;
/// Bytes of a [`ReaderPosition`] in a question.
const POSITION_BYTES: usize = 16;

/// How far a reader has got in a topic: the epoch of a publisher, and the sequence number that the reader expects next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ReaderPosition {
    pub(crate) publisher: u64,
    pub(crate) next: u64,
}

impl ReaderPosition {
    pub(crate) fn to_bytes(self) -> Vec<u8> {
        [self.publisher.to_le_bytes(), self.next.to_le_bytes()].concat()
    }

    /// `None` if these bytes are no position.
    pub(crate) fn of_bytes(bytes: &[u8]) -> Option<Self> {
        let (publisher, next) = bytes.split_at_checked(POSITION_BYTES / 2)?;
        Some(Self {
            publisher: u64::from_le_bytes(publisher.try_into().ok()?),
            next: u64::from_le_bytes(next.try_into().ok()?),
        })
    }
}

/// History that the agent writes and the network's threads read.
pub(crate) type SharedHistory = Arc<Mutex<MessageHistory>>;

pub(crate) fn lock(history: &SharedHistory) -> MutexGuard<'_, MessageHistory> {
    history.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Messages that were sent lately, the oldest first.
#[derive(Debug, Default)]
pub(crate) struct MessageHistory {
    /// Bytes at most.
    room: usize,
    bytes: usize,
    sent: VecDeque<SentMessage>,
    /// Header of a slice that would come next.
    reached: Option<BatchHeader>,
}

#[derive(Debug)]
struct SentMessage {
    /// Position of a reader that has the message.
    position: ReaderPosition,
    message: Vec<u8>,
}

impl MessageHistory {
    /// A history of at most so many bytes.
    pub(crate) fn with_room(room: usize) -> SharedHistory {
        Arc::new(Mutex::new(Self {
            room,
            ..Self::default()
        }))
    }

    /// Keeps a message that goes out; `reached` is the header of a slice that would follow the message's last slice.
    pub(crate) fn keep(&mut self, message: &[u8], reached: &BatchHeader) {
        self.reached = Some(*reached);
        self.bytes += message.len();
        self.sent.push_back(SentMessage {
            position: ReaderPosition {
                publisher: reached.incarnation,
                next: reached.first_sequence,
            },
            message: message.to_vec(),
        });
        while self.bytes > self.room
            && let Some(oldest) = self.sent.pop_front()
        {
            self.bytes -= oldest.message.len();
        }
    }

    /// Returns messages with the slices after `position`, as far as the history reaches back, and an empty slice at
    /// the end with the topic's present position. Readers drop known slices.
    pub(crate) fn after(&self, position: ReaderPosition, head: Head) -> Vec<Vec<u8>> {
        let Some(reached) = self.reached else {
            return Vec::new();
        };
        let has =
            |sent: &SentMessage| sent.position.publisher == position.publisher && sent.position.next <= position.next;
        let first = self.sent.iter().rposition(has).map_or(0, |last| last + 1);
        let mut answers: Vec<Vec<u8>> = Vec::new();
        for sent in self.sent.range(first..) {
            match answers.last_mut() {
                Some(answer) if answer.len() < ANSWER_BYTES => answer.extend(wire::slices_of(&sent.message)),
                _ => answers.push(sent.message.clone()),
            }
        }
        let mut end = Message::new();
        // The type of no samples does not matter; the header states that of the topic.
        end.add::<SensorTrack>(&reached, &[]);
        answers.push(end.finish(head));
        answers
    }
}

#[cfg(test)]
mod tests {
    use messages::layout::Sample as _;

    use super::*;

    /// A message of one report of `publisher` with this number, and the header behind the report.
    fn message(publisher: u64, number: u64) -> (Vec<u8>, BatchHeader) {
        let header = BatchHeader {
            schema: SensorTrack::SCHEMA,
            incarnation: publisher,
            first_sequence: number,
            ..BatchHeader::default()
        };
        let mut message = Message::new();
        let report = SensorTrack {
            sequence: number,
            ..SensorTrack::default()
        };
        message.add(&header, &[report]);
        let behind = BatchHeader {
            first_sequence: number + 1,
            ..header
        };
        (message.finish(Head::default()), behind)
    }

    /// Numbers of the reports in the answer for a reader at this position, by publisher.
    fn answered(history: &MessageHistory, publisher: u64, next: u64) -> Vec<(u64, u64)> {
        let answers = history.after(ReaderPosition { publisher, next }, Head::default());
        let slices = answers
            .iter()
            .flat_map(|answer| wire::read::<SensorTrack>(answer, 8).unwrap().1);
        slices
            .flat_map(|(header, reports)| {
                reports
                    .into_iter()
                    .map(move |report| (header.incarnation, report.sequence))
            })
            .collect()
    }

    fn history(messages: usize) -> SharedHistory {
        MessageHistory::with_room(messages * message(0, 0).0.len())
    }

    #[test]
    fn a_reader_gets_what_follows_its_position_over_a_change_of_the_publisher() {
        let history = history(10);
        let mut history = lock(&history);
        assert!(
            history
                .after(ReaderPosition { publisher: 7, next: 0 }, Head::default())
                .is_empty()
        );
        for (publisher, number) in [(7, 5), (7, 6), (9, 0), (9, 1)] {
            let (message, behind) = message(publisher, number);
            history.keep(&message, &behind);
        }
        assert_eq!(answered(&history, 7, 6), [(7, 6), (9, 0), (9, 1)]);
        assert_eq!(answered(&history, 9, 1), [(9, 1)]);
        assert_eq!(answered(&history, 9, 2), []);
        assert_eq!(
            answered(&history, 3, 2).len(),
            4,
            "a publisher of before: all that there is"
        );
    }

    #[test]
    fn the_oldest_messages_give_way() {
        let history = history(3);
        let mut history = lock(&history);
        for number in 0..100 {
            let (message, behind) = message(7, number);
            history.keep(&message, &behind);
        }
        assert_eq!(answered(&history, 7, 2), [(7, 97), (7, 98), (7, 99)]);
        assert!(history.bytes <= history.room);
    }

    #[test]
    fn a_position_is_read_as_it_was_written() {
        let position = ReaderPosition {
            publisher: u64::MAX - 3,
            next: 9,
        };
        assert_eq!(ReaderPosition::of_bytes(&position.to_bytes()), Some(position));
        assert!((0..16).all(|cut| ReaderPosition::of_bytes(&position.to_bytes()[..cut]).is_none()));
    }
}

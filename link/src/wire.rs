//! The form in which slices travel between hosts.
//!
//! A message is a [`Head`] followed by slices in their shared-memory layout: the [`BatchHeader`], the number of
//! samples in eight bytes, and the samples. The message's key and the header's fingerprint determine the sample type.
//! Bytes are in the processors' order, little-endian.

use messages::layout::Sample;
use messages::{BatchHeader, FrameOrigin};

/// Words with which every message begins.
const MAGIC: u64 = u64::from_le_bytes(*b"KOSEKI/1");
/// Octets of a [`Head`].
const HEAD: usize = 9 * 8;
/// Bytes before the samples of a slice.
const SLICE_HEAD: usize = size_of::<BatchHeader>() + 8;

/// Statements of a message besides its slices.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Head {
    /// Number of samples omitted by the sender because newer samples replaced them.
    pub(crate) conflated: u64,
    /// When it was sent by the sender's clocks: UTC, nanoseconds.
    pub(crate) sent_utc_ns: i64,
    /// The same, monotonic.
    pub(crate) sent_mono_ns: i64,
    /// Origin of the frame that its samples' positions are in.
    pub(crate) frame: FrameOrigin,
    /// Number of the sending deployment; 0 without a number.
    pub(crate) origin: u32,
    /// Part of a requested snapshot; `None` for a message of the sequence.
    pub(crate) part: Option<MessagePart>,
}

/// Part of an answer too large for one message. All parts have the same time of sending.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MessagePart {
    /// Its place, from 0.
    pub(crate) index: u32,
    /// Number of all parts.
    pub(crate) of: u32,
}

/// Parts of an answer at most.
const PARTS_MAX: u32 = 64;

impl MessagePart {
    /// 0 is none.
    fn word(part: Option<Self>) -> u64 {
        part.map_or(0, |part| u64::from(part.of) << 32 | u64::from(part.index + 1))
    }

    /// `None` if there is no such part.
    fn of_word(word: u64) -> Option<Option<Self>> {
        let Some(index) = (word as u32).checked_sub(1) else {
            return (word == 0).then_some(None);
        };
        let of = (word >> 32) as u32;
        (index < of && of <= PARTS_MAX).then_some(Some(Self { index, of }))
    }
}

/// A message that is being written.
#[derive(Clone, Debug)]
pub(crate) struct Message {
    octets: Vec<u8>,
    samples: usize,
}

impl Message {
    pub(crate) fn new() -> Self {
        Self {
            octets: vec![0; HEAD],
            samples: 0,
        }
    }

    /// Adds a slice.
    pub(crate) fn add<T: Sample>(&mut self, header: &BatchHeader, samples: &[T]) {
        self.octets
            .extend_from_slice(BatchHeader::octets(std::slice::from_ref(header)));
        self.octets.extend_from_slice(&(samples.len() as u64).to_le_bytes());
        self.octets.extend_from_slice(T::octets(samples));
        self.samples += samples.len();
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.octets.len() == HEAD
    }

    pub(crate) fn octets(&self) -> usize {
        self.octets.len()
    }

    /// Number of samples in it.
    pub(crate) fn samples(&self) -> usize {
        self.samples
    }

    /// The whole message, with `head`.
    pub(crate) fn finish(mut self, head: Head) -> Vec<u8> {
        let words = [
            MAGIC,
            head.conflated,
            head.sent_utc_ns.cast_unsigned(),
            head.sent_mono_ns.cast_unsigned(),
            head.frame.latitude_deg.to_bits(),
            head.frame.longitude_deg.to_bits(),
            head.frame.height_m.to_bits(),
            u64::from(head.origin),
            MessagePart::word(head.part),
        ];
        for (place, word) in self.octets.chunks_exact_mut(8).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
        self.octets
    }
}

/// A slice of a message, its samples copied.
pub(crate) type SliceCopy<T> = (BatchHeader, Vec<T>);

/// Reads a message. `None` if malformed, with a slice of more than `slice_len` samples, or with another layout than
/// `T`.
pub(crate) fn read<T: Sample>(octets: &[u8], slice_len: usize) -> Option<(Head, Vec<SliceCopy<T>>)> {
    let (head, mut rest) = octets.split_at_checked(HEAD)?;
    let mut words = head.chunks_exact(8).map(word);
    if words.next()? != MAGIC {
        return None;
    }
    let head = Head {
        conflated: words.next()?,
        sent_utc_ns: words.next()?.cast_signed(),
        sent_mono_ns: words.next()?.cast_signed(),
        frame: FrameOrigin {
            latitude_deg: f64::from_bits(words.next()?),
            longitude_deg: f64::from_bits(words.next()?),
            height_m: f64::from_bits(words.next()?),
        },
        origin: u32::try_from(words.next()?).ok()?,
        part: MessagePart::of_word(words.next()?)?,
    };
    let mut slices = Vec::new();
    while !rest.is_empty() {
        let (before, after) = rest.split_at_checked(SLICE_HEAD)?;
        let (header, count) = before.split_at(size_of::<BatchHeader>());
        let header = BatchHeader::of_octets(header)?;
        let count = usize::try_from(word(count)).ok().filter(|count| *count <= slice_len)?;
        if header.schema != T::SCHEMA {
            return None;
        }
        let (samples, after) = after.split_at_checked(count * size_of::<T>())?;
        let samples: Option<Vec<T>> = samples.chunks_exact(size_of::<T>()).map(T::of_octets).collect();
        slices.push((header, samples?));
        rest = after;
    }
    Some((head, slices))
}

/// The slices of a message that [`Message::finish`] has made, to be added to another one.
pub(crate) fn slices_of(message: &[u8]) -> &[u8] {
    message.get(HEAD..).unwrap_or_default()
}

/// Returns whether the first slice of an unreadable message has another layout than `T`.
pub(crate) fn is_of_another_layout<T: Sample>(octets: &[u8]) -> bool {
    let header = octets.get(HEAD..HEAD + size_of::<BatchHeader>());
    let schema = header.and_then(BatchHeader::of_octets).map(|header| header.schema);
    word(octets.get(..8).unwrap_or_default()) == MAGIC && schema.is_some_and(|schema| schema != T::SCHEMA)
}

fn word(octets: &[u8]) -> u64 {
    octets.try_into().map_or(0, u64::from_le_bytes)
}

#[cfg(test)]
mod tests {
    use messages::{SensorTrack, SystemTrack};

    use super::*;

    const HEADED: Head = Head {
        conflated: 1,
        sent_utc_ns: -2,
        sent_mono_ns: 3,
        frame: FrameOrigin {
            latitude_deg: 41.3,
            longitude_deg: -2.0,
            height_m: 7.0,
        },
        origin: 5,
        part: Some(MessagePart { index: 2, of: 3 }),
    };

    fn message() -> Vec<u8> {
        let mut message = Message::new();
        let header = BatchHeader {
            schema: SensorTrack::SCHEMA,
            first_sequence: 7,
            ..BatchHeader::default()
        };
        let track = SensorTrack {
            track_number: 3,
            ..SensorTrack::default()
        };
        message.add(&header, &[track, track]);
        message.add::<SensorTrack>(&header, &[]);
        message.finish(HEADED)
    }

    #[test]
    fn a_message_is_read_as_it_was_written() {
        let (head, slices) = read::<SensorTrack>(&message(), 64).unwrap();
        assert_eq!(head, HEADED);
        assert_eq!(slices.len(), 2);
        assert_eq!((slices[0].0.first_sequence, slices[0].1[1].track_number), (7, 3));
        assert!(slices[1].1.is_empty());
    }

    #[test]
    fn a_part_is_one_of_those_that_there_are() {
        let words = [
            None,
            Some(MessagePart { index: 0, of: 1 }),
            Some(MessagePart { index: 63, of: 64 }),
        ];
        assert!(
            words
                .iter()
                .all(|part| MessagePart::of_word(MessagePart::word(*part)) == Some(*part))
        );
        assert!(
            [1 << 32, 1 << 32 | 2, 65 << 32 | 1]
                .iter()
                .all(|word| MessagePart::of_word(*word).is_none())
        );
    }

    #[test]
    fn what_is_no_message_of_the_type_is_refused() {
        let good = message();
        assert!(read::<SystemTrack>(&good, 64).is_none(), "another layout");
        assert!(read::<SensorTrack>(&good, 1).is_none(), "longer than a slice");
        assert!(is_of_another_layout::<SystemTrack>(&good) && !is_of_another_layout::<SensorTrack>(&good));
        assert!(!is_of_another_layout::<SensorTrack>(&good[..HEAD + 3]) && !is_of_another_layout::<SensorTrack>(&[]));
        let whole: Vec<usize> = (0..=good.len())
            .filter(|cut| read::<SensorTrack>(&good[..*cut], 64).is_some())
            .collect();
        let first = HEAD + SLICE_HEAD + 2 * size_of::<SensorTrack>();
        assert_eq!(whole, [HEAD, first, first + SLICE_HEAD], "cut elsewhere");
        for place in 0..good.len() {
            let mut bad = good.clone();
            bad[place] ^= 0x80;
            // For any input, there is no panic and no length beyond the limit.
            if let Some((_, slices)) = read::<SensorTrack>(&bad, 64) {
                assert!(slices.iter().all(|(_, samples)| samples.len() <= 64));
            }
        }
    }
}

//! Copy of a part of a recording, or of all its files into a single file.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Seek, Write};

use messages::BatchHeader;

use crate::RecordingError;
use crate::reader::{Item, read_as_recorded};
use crate::survey::Survey;
use crate::tally::Tally;
use crate::writer::{Channel, Compression, Writer};

/// Part of a recording.
#[derive(Clone, Debug, Default)]
pub struct RecordingPart {
    /// Time at which the first slice was taken, UTC, nanoseconds; `None` for the beginning.
    pub from_ns: Option<u64>,
    /// Time at which the last slice was taken, UTC, nanoseconds; `None` for the end.
    pub to_ns: Option<u64>,
    /// Names of topics, or beginnings of names up to a `/`; empty for all topics.
    pub topics: Vec<String>,
    /// Compression of the copy.
    pub compression: Compression,
}

/// Whether `wanted` is a topic's name, or its beginning up to a `/`.
fn is_wanted(wanted: &str, name: &str) -> bool {
    let rest = name.strip_prefix(wanted);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

impl RecordingPart {
    fn has_topic(&self, name: &str) -> bool {
        self.topics.is_empty() || self.topics.iter().any(|wanted| is_wanted(wanted, name))
    }

    /// Refuses a part with a topic that is none of `known`.
    fn check(&self, known: &BTreeSet<String>) -> Result<(), RecordingError> {
        let is_unknown = |wanted: &&String| !known.iter().any(|name| is_wanted(wanted, name));
        match self.topics.iter().find(is_unknown) {
            Some(wanted) => Err(RecordingError::UnknownTopic {
                wanted: wanted.clone(),
                known: known.iter().cloned().collect(),
            }),
            None => Ok(()),
        }
    }

    /// Returns the side of the part on which a time is.
    fn side(&self, taken_ns: u64) -> Side {
        match (self.is_before(taken_ns), self.is_after(taken_ns)) {
            (true, _) => Side::Before,
            (_, true) => Side::After,
            _ => Side::In,
        }
    }

    fn is_before(&self, taken_ns: u64) -> bool {
        self.from_ns.is_some_and(|from_ns| taken_ns < from_ns)
    }

    fn is_after(&self, taken_ns: u64) -> bool {
        self.to_ns.is_some_and(|to_ns| taken_ns > to_ns)
    }
}

/// Side of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Before,
    In,
    After,
}

/// What a copy holds, and what it lacks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Copied {
    /// Samples.
    pub samples: u64,
    /// Damaged parts of the files, which were skipped. Damage that is surely before or after the copied part is not
    /// counted.
    pub damaged: u64,
    /// Bytes of the damaged parts.
    pub damaged_bytes: u64,
}

/// Copies a part of the recording that consists of `files`, in their order, into one file. Damaged parts are skipped.
///
/// The copy states the progress of the topics at the beginning of the part. Losses within the part are counted;
/// samples before the part are not.
///
/// # Errors
/// If a file cannot be read, if no file has a topic of the part, or if `out` cannot be written.
pub fn copy<R: Read + Seek, W: Write + Seek>(
    files: impl IntoIterator<Item = R>,
    part: &RecordingPart,
    out: W,
) -> Result<Copied, RecordingError> {
    let mut copying = PartCopier {
        part,
        before: Survey::default(),
        known: BTreeSet::new(),
        topics: BTreeMap::new(),
        out: Some(out),
        writer: None,
        place: SlicePlace::Outside,
        copied: Copied::default(),
        side: Side::Before,
        damage: (0, 0),
    };
    for mut file in files {
        read_as_recorded::<_, RecordingError>(&mut file, |item| copying.item(item))?;
        copying.end_slice()?;
    }
    if copying.side != Side::After {
        copying.count_damage();
    }
    part.check(&copying.known)?;
    copying.writer()?;
    copying.writer.map_or(Ok(()), Writer::finish)?;
    Ok(copying.copied)
}

struct PartCopier<'a, W: Write + Seek> {
    part: &'a RecordingPart,
    /// Contents before the part.
    before: Survey,
    /// Names of all topics.
    known: BTreeSet<String>,
    topics: BTreeMap<String, CopiedTopic>,
    out: Option<W>,
    /// Copy, once the part has begun.
    writer: Option<Writer<W>>,
    place: SlicePlace,
    copied: Copied,
    /// Side of the latest slice.
    side: Side,
    /// Damaged parts since the latest slice, and their bytes.
    damage: (u64, u64),
}

/// Place of the present slice.
enum SlicePlace {
    Before,
    In(CopiedSlice),
    Outside,
}

struct CopiedTopic {
    schema: String,
    definition: Vec<u8>,
    fingerprint: String,
    channel: Option<Channel>,
}

/// Slice in progress.
struct CopiedSlice {
    topic: String,
    header: BatchHeader,
    taken_ns: u64,
    sent_ns: u64,
    octets: Vec<u8>,
    sample_size: usize,
}

impl<W: Write + Seek> PartCopier<'_, W> {
    fn item(&mut self, item: Item<'_>) -> Result<(), RecordingError> {
        if let Item::Topic { name, .. } = item {
            self.known.insert(name.to_owned());
        }
        match item {
            Item::Facts(_) => self.before.item(item),
            Item::Topic {
                name,
                schema,
                definition,
                fingerprint,
                ..
            } if self.part.has_topic(name) && !self.topics.contains_key(name) => {
                let topic = CopiedTopic {
                    schema: schema.to_owned(),
                    definition: definition.to_owned(),
                    fingerprint: fingerprint.to_owned(),
                    channel: None,
                };
                self.topics.insert(name.to_owned(), topic);
            }
            Item::Topic { .. } => {}
            Item::Slice {
                topic,
                header,
                taken_ns,
                sent_ns,
            } => {
                self.end_slice()?;
                self.go_on(self.part.side(taken_ns));
                if self.writer.is_none() && self.part.is_before(taken_ns) {
                    self.place = SlicePlace::Before;
                    self.before.item(item);
                } else if self.part.has_topic(topic) && !self.part.is_after(taken_ns) {
                    self.place = SlicePlace::In(CopiedSlice {
                        topic: topic.to_owned(),
                        header,
                        taken_ns,
                        sent_ns,
                        octets: Vec::new(),
                        sample_size: 0,
                    });
                }
            }
            Item::Sample { octets, .. } => match &mut self.place {
                SlicePlace::Before => self.before.item(item),
                SlicePlace::In(slice) => {
                    slice.octets.extend_from_slice(octets);
                    slice.sample_size = octets.len();
                }
                SlicePlace::Outside => {}
            },
            Item::Damaged { bytes, .. } => {
                self.damage.0 += 1;
                self.damage.1 += bytes.end - bytes.start;
            }
        }
        Ok(())
    }

    /// Goes on to a slice on this side. The damage since the latest slice is outside the part if both are on the same
    /// side of it.
    fn go_on(&mut self, side: Side) {
        match (self.side, side) {
            (Side::Before, Side::Before) | (Side::After, Side::After) => self.damage = (0, 0),
            _ => self.count_damage(),
        }
        self.side = side;
    }

    fn count_damage(&mut self) {
        let (parts, bytes) = std::mem::take(&mut self.damage);
        self.copied.damaged += parts;
        self.copied.damaged_bytes += bytes;
    }

    fn end_slice(&mut self) -> Result<(), RecordingError> {
        let SlicePlace::In(slice) = std::mem::replace(&mut self.place, SlicePlace::Outside) else {
            return Ok(());
        };
        self.writer()?;
        let (Some(writer), Some(topic)) = (&mut self.writer, self.topics.get_mut(&slice.topic)) else {
            return Ok(());
        };
        let size = slice.sample_size.max(1);
        let channel = match topic.channel {
            Some(channel) => channel,
            None => {
                let (definition, fingerprint) = (&topic.definition, &topic.fingerprint);
                writer.channel_of(&slice.topic, size, &topic.schema, definition, fingerprint)?
            }
        };
        // The sample size of a slice without samples is unknown.
        topic.channel = Some(channel).filter(|_| slice.sample_size > 0);
        let (taken_ns, sent_ns) = (slice.taken_ns as i64, slice.sent_ns as i64);
        writer.slice(channel, &slice.header, &slice.octets, taken_ns, sent_ns)?;
        self.copied.samples += (slice.octets.len() / size) as u64;
        Ok(())
    }

    /// Begins the copy if it has not begun.
    fn writer(&mut self) -> Result<(), RecordingError> {
        let Some(out) = self.out.take() else { return Ok(()) };
        self.before.end_slices();
        let mut facts = self.before.facts.clone();
        for (name, topic) in &self.before.topics {
            topic.tally.state(name, &mut facts);
        }
        if self.part.from_ns.is_some() {
            Tally::forget_losses(&mut facts);
        }
        self.writer = Some(Writer::compressed(out, &facts, self.part.compression)?);
        Ok(())
    }
}

//! Reader of one file, message by message.

use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;

use mcap::records::op;
use messages::layout::{ALL, Sample as _};
use messages::{BatchHeader, Conversion};

use crate::damage::{footer, hides_chunk, next_chunk, summary};
use crate::record::{Fields, HEAD, contradiction, head_of, is_known, is_needed};
use crate::{CDR, FACTS, FINGERPRINT, Facts, RecordingError, SCHEMA_PREFIX, SLICES, fingerprint_of};

/// Item of a file, in the file's order.
#[derive(Clone, Debug, PartialEq)]
pub enum Item<'a> {
    /// Facts at the beginning.
    Facts(Facts),
    /// Topic.
    Topic {
        /// Name.
        name: &'a str,
        /// Name of the schema of the samples.
        schema: &'a str,
        /// Schema for ROS 2.
        definition: &'a [u8],
        /// Fingerprint of the samples' layout.
        fingerprint: &'a str,
        /// Byte ranges that the recorded samples lack, if they were recorded with another layout.
        missing: &'a [Range<usize>],
    },
    /// Beginning of a slice; its samples follow.
    Slice {
        /// Name of the topic.
        topic: &'a str,
        /// Header of the slice.
        header: BatchHeader,
        /// Time at which the recorder took the slice, UTC, nanoseconds.
        taken_ns: u64,
        /// Time at which the publisher sent the slice, UTC, nanoseconds.
        sent_ns: u64,
    },
    /// Sample of the topic's latest slice.
    Sample {
        /// Name of the topic.
        topic: &'a str,
        /// Sample in this build's layout, unless the file is read as recorded.
        octets: &'a [u8],
    },
    /// Damaged bytes that were skipped, or a chunk with samples of channels that no readable chunk describes. Slices
    /// before the item are complete.
    Damaged {
        /// Bytes of the file.
        bytes: Range<u64>,
        /// Kind of damage.
        reason: &'static str,
    },
}

/// Passes all items of a file to `visit`; of a file without an end, the readable items. Returns whether the file has
/// its end.
///
/// # Errors
/// If the file cannot be read, or is not written by a recorder; or the first error of `visit`.
pub fn read<R: Read + Seek, E: From<RecordingError>>(
    file: &mut R,
    mut visit: impl FnMut(Item<'_>) -> Result<(), E>,
) -> Result<bool, E> {
    let mut chunks = Chunks::new(file)?;
    while chunks.read(&mut visit)? {}
    Ok(chunks.is_ended)
}

/// Reads as [`read`] does, without conversion of samples that another build recorded with another layout.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_as_recorded<R: Read + Seek, E: From<RecordingError>>(
    file: &mut R,
    mut visit: impl FnMut(Item<'_>) -> Result<(), E>,
) -> Result<bool, E> {
    let mut chunks = Chunks::new(file)?;
    chunks.names.as_recorded = true;
    while chunks.read(&mut visit)? {}
    Ok(chunks.is_ended)
}

/// Reader of a file chunk by chunk, in any order after a first pass.
#[derive(Debug)]
pub struct Chunks<R> {
    file: R,
    /// Bytes of the file.
    length: u64,
    /// End of the data, as far as it is known: nothing is read from here on.
    end: u64,
    /// Whether the file has its end.
    is_ended: bool,
    /// Whether the channels that the summary describes are known.
    is_summary_known: bool,
    next: u64,
    /// Position of `file`; `None` if unknown.
    at: Option<u64>,
    names: ChannelNames,
    record: Vec<u8>,
    /// Records of the latest compressed chunk.
    unpacked: Vec<u8>,
}

impl<R: Read + Seek> Chunks<R> {
    /// Opens the file at its beginning.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn new(mut file: R) -> Result<Self, RecordingError> {
        let length = file.seek(SeekFrom::End(0))?;
        if !begins_as_recording(&mut file)? {
            return Err(RecordingError::OtherKind);
        }
        let is_ended = footer(&mut file, length)?.is_some();
        Ok(Self {
            file,
            length,
            end: length,
            is_ended,
            is_summary_known: false,
            next: mcap::MAGIC.len() as u64,
            at: None,
            names: ChannelNames::default(),
            record: Vec::new(),
            unpacked: Vec::new(),
        })
    }

    /// Returns another reader of the same file, opened again as `file`, which knows what this one has read so far.
    pub fn beside<F: Read + Seek>(&self, file: F) -> Chunks<F> {
        Chunks {
            file,
            length: self.length,
            end: self.end,
            is_ended: self.is_ended,
            is_summary_known: self.is_summary_known,
            next: self.next,
            at: None,
            names: self.names.clone(),
            record: Vec::new(),
            unpacked: Vec::new(),
        }
    }

    /// Returns the offset of the next [`Chunks::read`], bytes.
    pub fn place(&self) -> u64 {
        self.next
    }

    /// Continues at an offset from [`Chunks::place`].
    pub fn go_to(&mut self, place: u64) {
        self.next = place;
    }

    /// Passes the items of the next chunk, and of the records before it, to `visit`. Returns `false` at the end.
    /// Damaged chunks are skipped: each is one item, [`Item::Damaged`].
    ///
    /// # Errors
    /// If the file cannot be read, or is not written by a recorder; or the first error of `visit`.
    pub fn read<E: From<RecordingError>>(
        &mut self,
        mut visit: impl FnMut(Item<'_>) -> Result<(), E>,
    ) -> Result<bool, E> {
        loop {
            let place = self.next;
            if place >= self.end {
                return Ok(false);
            }
            match self.pass(place, &mut visit) {
                Ok(Ok(is_chunk)) if is_chunk => return Ok(true),
                Ok(Ok(_)) => {}
                Ok(Err(refused)) => return Err(refused),
                Err(RecordingError::Damaged { reason, .. }) => {
                    if !self.skip(place, reason, &mut visit)? {
                        return Ok(false);
                    }
                }
                Err(other) => return Err(other.into()),
            }
        }
    }

    /// Passes the items of the next record. Returns whether it is a chunk.
    fn pass<E>(
        &mut self,
        place: u64,
        visit: &mut impl FnMut(Item<'_>) -> Result<(), E>,
    ) -> Result<Result<bool, E>, RecordingError> {
        let Some(code) = self.record()? else {
            return Ok(Ok(false));
        };
        let fields = Fields::of(&self.record, place);
        self.names.undescribed = 0;
        if code == op::CHUNK {
            let mut records = fields.records(&mut self.unpacked)?;
            while let Some((code, fields)) = records.record()? {
                if let Err(refused) = self.names.show(code, fields, visit)? {
                    return Ok(Err(refused));
                }
            }
        } else {
            fields.check(code)?;
            if let Err(refused) = self.names.show(code, fields, visit)? {
                return Ok(Err(refused));
            }
        }
        if self.names.undescribed > 0 {
            let bytes = place..self.next;
            let reason = "no readable chunk describes the channels of its samples";
            return Ok(visit(Item::Damaged { bytes, reason }).map(|()| code == op::CHUNK));
        }
        Ok(Ok(code == op::CHUNK))
    }

    /// Goes from damage at `place` to the next chunk, and passes the bytes between. `false` if there is none.
    #[cold]
    fn skip<E: From<RecordingError>>(
        &mut self,
        place: u64,
        reason: &'static str,
        visit: &mut impl FnMut(Item<'_>) -> Result<(), E>,
    ) -> Result<bool, E> {
        self.at = None;
        let length = self.length;
        let found = next_chunk(&mut self.file, place + 1..length, length).map_err(RecordingError::from)?;
        self.next = found.unwrap_or(place);
        if found.is_none() {
            self.end = place;
            // A killed recorder leaves a torn record: the file then has no end, which is no damage.
            if !self.is_ended && matches!(reason, CUT_OFF | UNKNOWN) {
                return Ok(false);
            }
        }
        let bytes = place..found.unwrap_or(length);
        visit(Item::Damaged { bytes, reason })?;
        if found.is_some() && !std::mem::replace(&mut self.is_summary_known, true) {
            self.learn_channels(visit)?;
        }
        Ok(found.is_some())
    }

    /// Learns the channels that the damaged part may have described.
    fn learn_channels<E: From<RecordingError>>(
        &mut self,
        visit: &mut impl FnMut(Item<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let (mut refused, names, length) = (None, &mut self.names, self.length);
        let summarised = summary(&mut self.file, length, DESCRIPTION_BYTES, |code, data| {
            let fields = Fields::of(data, length);
            let mut number = fields;
            let is_known = number.u16().is_ok_and(|number| names.knows(code, number));
            if matches!(code, op::SCHEMA | op::CHANNEL)
                && !is_known
                && let Ok(Err(error)) = names.show(code, fields, visit)
            {
                refused.get_or_insert(error);
            }
        });
        summarised.map_err(RecordingError::from)?;
        refused.map_or(Ok(()), Err)
    }

    /// Reads the next record. Returns its code; `None` for a record without items, such as an index.
    fn record(&mut self) -> Result<Option<u8>, RecordingError> {
        let place = self.next;
        let mut head = [0; HEAD];
        if self.at.take() != Some(place) {
            self.file.seek(SeekFrom::Start(place))?;
        }
        if place.saturating_add(HEAD as u64) > self.length {
            return Err(RecordingError::damaged(place, CUT_OFF));
        }
        self.file.read_exact(&mut head)?;
        let (code, length) = head_of(&head);
        if !is_known(code) {
            return Err(RecordingError::damaged(place, UNKNOWN));
        }
        let end = place.saturating_add(HEAD as u64).saturating_add(length);
        // Memory follows the size of the file, not the length stated by a damaged file.
        if end > self.length {
            return Err(RecordingError::damaged(place, CUT_OFF));
        }
        let is_needed = is_needed(code) || code == op::HEADER;
        if is_needed {
            self.data(length)?;
        } else {
            self.pass_over(code, place, end)?;
        }
        if matches!(code, op::DATA_END | op::FOOTER) {
            self.end = place;
            return Ok(None);
        }
        self.next = end;
        self.at = Some(end).filter(|_| !is_foreign(code));
        Ok(is_needed.then_some(code))
    }

    /// Reads the data of a record.
    fn data(&mut self, length: u64) -> Result<(), RecordingError> {
        let bytes = usize::try_from(length).unwrap_or(usize::MAX);
        self.record.clear();
        self.record
            .try_reserve_exact(bytes)
            .map_err(|_| RecordingError::damaged(self.next, "a record is larger than the memory at hand"))?;
        let read = (&mut self.file).take(length).read_to_end(&mut self.record)? as u64;
        if read < length {
            return Err(std::io::Error::from(std::io::ErrorKind::UnexpectedEof).into());
        }
        Ok(())
    }

    /// Passes over the data of a record without items, from behind its head to `end`.
    fn pass_over(&mut self, code: u8, place: u64, end: u64) -> Result<(), RecordingError> {
        let length = end - place - HEAD as u64;
        let mut begin = [0; 6];
        let begin = &mut begin[..usize::try_from(length).map_or(6, |length| length.min(6))];
        self.file.read_exact(begin)?;
        if let Some(reason) = contradiction(code, length, begin) {
            return Err(RecordingError::damaged(place, reason));
        }
        if is_foreign(code) {
            if hides_chunk(&mut self.file, place, end, self.length)? {
                return Err(RecordingError::damaged(place, "a record hides a chunk"));
            }
            return Ok(());
        }
        let left = length - begin.len() as u64;
        match i64::try_from(left) {
            Ok(left) => self.file.seek_relative(left)?,
            Err(_) => drop(self.file.seek(SeekFrom::Start(end))?),
        }
        Ok(())
    }
}

/// Reason: a record that is longer than the rest of the file.
const CUT_OFF: &str = "a record is longer than the file";
/// Reason: a record of no known kind.
const UNKNOWN: &str = "there is no record of this code";

/// Whether no recorder writes records of this code: attachments, and records of other programs.
fn is_foreign(code: u8) -> bool {
    code == op::ATTACHMENT || code > op::DATA_END
}

/// Whether a file begins as a recording does; a killed recorder may have left less than the first bytes.
fn begins_as_recording<R: Read + Seek>(file: &mut R) -> std::io::Result<bool> {
    let mut begin = Vec::new();
    file.rewind()?;
    file.take(mcap::MAGIC.len() as u64).read_to_end(&mut begin)?;
    Ok(mcap::MAGIC.starts_with(&begin))
}

/// Fault of a file that its recorder has not ended, in words.
pub const UNENDED: &str = "has no end: its recorder still writes it, or was killed; what is complete in it is read";

/// Returns whether a file is a recording without an end.
///
/// # Errors
/// If the file cannot be read.
pub fn is_unended<R: Read + Seek>(file: &mut R) -> std::io::Result<bool> {
    let length = file.seek(SeekFrom::End(0))?;
    Ok(begins_as_recording(file)? && footer(file, length)?.is_none())
}

/// Returns the facts at the beginning of a file; `None` without facts.
///
/// # Errors
/// If the file cannot be read.
pub fn facts<R: Read + Seek>(file: &mut R) -> Result<Option<Facts>, RecordingError> {
    enum ReadStop {
        Found(Facts),
        Failed(RecordingError),
    }
    impl From<RecordingError> for ReadStop {
        fn from(error: RecordingError) -> Self {
            Self::Failed(error)
        }
    }
    let found = read(file, |item| match item {
        Item::Facts(facts) => Err(ReadStop::Found(facts)),
        _ => Ok(()),
    });
    match found {
        Ok(_) => Ok(None),
        Err(ReadStop::Found(facts)) => Ok(Some(facts)),
        Err(ReadStop::Failed(error)) => Err(error),
    }
}

/// Maximum bytes of a record that describes a topic or the file. A recorder's longest such record contains a
/// configuration.
const DESCRIPTION_BYTES: usize = 4 << 20;

/// Channels and schemas of one file.
#[derive(Clone, Debug, Default)]
struct ChannelNames {
    schemas: BTreeMap<u16, (String, Vec<u8>)>,
    topics: BTreeMap<u16, ChannelTopic>,
    /// Messages of the present chunk whose channel has not been described.
    undescribed: u64,
    /// Whether samples of other layouts are passed without conversion.
    as_recorded: bool,
    /// Latest converted sample.
    converted: Vec<u8>,
}

/// Topic of one channel.
#[derive(Clone, Debug)]
struct ChannelTopic {
    name: String,
    /// Conversion of the samples, if another build recorded them with another layout.
    conversion: Option<Conversion>,
}

/// Returns the conversion of samples with this schema and layout fingerprint; `None` if no conversion is needed, or
/// if this build has no such sample.
fn conversion_of(schema: &str, definition: &[u8], fingerprint: Option<&String>) -> Option<Conversion> {
    let name = schema.strip_prefix(SCHEMA_PREFIX)?;
    let layout = ALL.iter().find(|layout| layout.name == name)?;
    if *fingerprint? == fingerprint_of(layout) {
        return None;
    }
    Conversion::of_schema(name, std::str::from_utf8(definition).ok()?)
}

impl ChannelNames {
    /// Passes the item of a record to `visit`.
    ///
    /// # Errors
    /// Damage; within, the error of `visit`.
    fn show<E>(
        &mut self,
        code: u8,
        mut fields: Fields<'_>,
        visit: &mut impl FnMut(Item<'_>) -> Result<(), E>,
    ) -> Result<Result<(), E>, RecordingError> {
        if code != op::MESSAGE && is_needed(code) && fields.rest().len() > DESCRIPTION_BYTES {
            return Err(fields.damaged("a description has more than 4 MiB"));
        }
        match code {
            op::METADATA => match fields.text()? {
                FACTS => Ok(visit(Item::Facts(fields.map()?))),
                _ => Ok(Ok(())),
            },
            op::SCHEMA => {
                let id = fields.u16()?;
                let (name, _encoding) = (fields.text()?, fields.text()?);
                let definition = fields.octets()?;
                self.schemas.insert(id, (name.to_owned(), definition.to_vec()));
                Ok(Ok(()))
            }
            op::CHANNEL => self.channel(fields, visit),
            op::MESSAGE => self.message(fields, visit),
            _ => Ok(Ok(())),
        }
    }

    /// Whether a schema or channel of this number has been described.
    fn knows(&self, code: u8, number: u16) -> bool {
        match code {
            op::SCHEMA => self.schemas.contains_key(&number),
            _ => self.topics.contains_key(&number),
        }
    }

    fn channel<E>(
        &mut self,
        mut fields: Fields<'_>,
        visit: &mut impl FnMut(Item<'_>) -> Result<(), E>,
    ) -> Result<Result<(), E>, RecordingError> {
        let (id, schema) = (fields.u16()?, fields.u16()?);
        let (name, _encoding) = (fields.text()?, fields.text()?);
        let metadata = fields.map()?;
        let (fingerprint, schema) = (metadata.get(FINGERPRINT), self.schemas.get(&schema));
        let is_converted = !self.as_recorded;
        let topic = self.topics.entry(id).or_insert_with(|| ChannelTopic {
            name: name.to_owned(),
            conversion: schema
                .filter(|_| is_converted)
                .and_then(|(schema, definition)| conversion_of(schema, definition, fingerprint)),
        });
        if topic.name != name {
            return Err(fields.damaged("a channel has the number of another one"));
        }
        match (name.ends_with(SLICES), schema) {
            (false, Some((schema, definition))) => Ok(visit(Item::Topic {
                name,
                schema,
                definition,
                fingerprint: fingerprint.map_or("", String::as_str),
                missing: topic.conversion.as_ref().map_or(&[], Conversion::missing),
            })),
            _ => Ok(Ok(())),
        }
    }

    fn message<E>(
        &mut self,
        mut fields: Fields<'_>,
        visit: &mut impl FnMut(Item<'_>) -> Result<(), E>,
    ) -> Result<Result<(), E>, RecordingError> {
        let (channel, _sequence) = (fields.u16()?, fields.u32()?);
        let (taken_ns, sent_ns) = (fields.u64()?, fields.u64()?);
        let Some(ChannelTopic { name, conversion }) = self.topics.get(&channel) else {
            self.undescribed += 1;
            return Ok(Ok(()));
        };
        let recorded = fields.rest().strip_prefix(&CDR).unwrap_or_default();
        let octets = match conversion {
            Some(conversion) => {
                conversion.convert(recorded, &mut self.converted);
                &self.converted[..]
            }
            None => recorded,
        };
        Ok(match name.strip_suffix(SLICES) {
            None => visit(Item::Sample { topic: name, octets }),
            Some(topic) => match BatchHeader::of_octets(octets) {
                Some(header) => visit(Item::Slice {
                    topic,
                    header,
                    taken_ns,
                    sent_ns,
                }),
                None => Ok(()),
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use messages::PlatformState;

    use super::*;
    use crate::{Compression, Writer};

    /// Layout of a former build: without standard deviations, velocity before position.
    const FORMER: &str = "int64 time_ns # Time.\nfloat64[3] velocity_mps # Velocity.\nfloat64[3] position_m # Place.\n";

    fn former_file() -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        let mut writer = Writer::compressed(&mut file, &Facts::new(), Compression::Zstd).unwrap();
        let schema = format!("{SCHEMA_PREFIX}PlatformState");
        let channel = writer
            .channel_of(
                "platform/ship/state",
                56,
                &schema,
                FORMER.as_bytes(),
                "0123456789abcdef",
            )
            .unwrap();
        let mut sample = 5i64.to_le_bytes().to_vec();
        for value in [1.0f64, 2.0, 3.0, 10.0, 20.0, 30.0] {
            sample.extend(value.to_le_bytes());
        }
        writer.slice(channel, &BatchHeader::default(), &sample, 1, 1).unwrap();
        writer.finish().unwrap();
        file.into_inner()
    }

    fn samples(items: impl FnOnce(&mut dyn FnMut(Item<'_>))) -> (Vec<Vec<u8>>, usize) {
        let (mut found, mut missing) = (Vec::new(), 0);
        items(&mut |item| match item {
            Item::Sample { octets, .. } => found.push(octets.to_vec()),
            Item::Topic { missing: ranges, .. } => missing = ranges.len(),
            _ => {}
        });
        (found, missing)
    }

    #[test]
    fn samples_of_a_former_layout_are_converted() {
        let (found, missing) = samples(|visit| {
            let done = read::<_, RecordingError>(&mut Cursor::new(former_file()), |item| {
                visit(item);
                Ok(())
            });
            assert!(done.unwrap());
        });
        let expected = PlatformState {
            time_ns: 5,
            position_m: [10.0, 20.0, 30.0],
            velocity_mps: [1.0, 2.0, 3.0],
            ..PlatformState::default()
        };
        assert_eq!((found.len(), PlatformState::of_octets(&found[0])), (1, Some(expected)));
        assert!(missing > 0);
    }

    #[test]
    fn a_copy_keeps_the_former_layout() {
        let (found, missing) = samples(|visit| {
            let done = read_as_recorded::<_, RecordingError>(&mut Cursor::new(former_file()), |item| {
                visit(item);
                Ok(())
            });
            assert!(done.unwrap());
        });
        assert_eq!((found[0].len(), missing), (56, 0));
    }
}

//! Writer of an MCAP file: messages on channels, in chunks that may be compressed, with an index at the end.
//!
//! A chunk begins with the schemas and channels that were added since the last one. Nothing is written before a chunk
//! is complete, so that the writer needs no way back in the file.

use std::collections::BTreeMap;
use std::io::Write;

use crate::record::{MAGIC, op};
use crate::zstd::Compressor;
use crate::{Facts, RecordingError};

/// Compression of chunks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// As the messages are.
    #[default]
    None,
    /// Zstandard.
    Zstd,
}

/// Channel, number and times of a message.
#[derive(Clone, Copy, Debug)]
pub struct MessageHead {
    /// Number of the channel.
    pub channel: u16,
    /// Number of the message.
    pub sequence: u32,
    /// Time of writing, UTC, nanoseconds.
    pub log_ns: u64,
    /// Time of sending, UTC, nanoseconds.
    pub publish_ns: u64,
}

/// Writer of an MCAP file.
pub struct Container<W> {
    out: W,
    /// Bytes written.
    at: u64,
    checksum: crc32fast::Hasher,
    compressor: Option<Compressor>,
    chunk: Chunk,
    /// Record under construction, reused.
    record: Vec<u8>,
    packed: Vec<u8>,
    summary: Summary,
}

impl<W> std::fmt::Debug for Container<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Container").field("at", &self.at).finish()
    }
}

/// Chunk in progress.
#[derive(Debug, Default)]
struct Chunk {
    records: Vec<u8>,
    times: Times,
    /// Time and place of the messages of each channel.
    index: BTreeMap<u16, Vec<(u64, u64)>>,
}

/// First and last time, UTC, nanoseconds.
#[derive(Clone, Copy, Debug, Default)]
struct Times(Option<(u64, u64)>);

impl Times {
    fn add(&mut self, time_ns: u64) {
        let (first, last) = self.0.unwrap_or((time_ns, time_ns));
        self.0 = Some((first.min(time_ns), last.max(time_ns)));
    }

    /// Returns the times; 0 without any.
    fn both(self) -> [u64; 2] {
        self.0.map_or([0, 0], |(first, last)| [first, last])
    }
}

/// Contents of the end of the file.
#[derive(Debug, Default)]
struct Summary {
    /// Data of the records.
    schemas: Vec<Vec<u8>>,
    channels: Vec<Vec<u8>>,
    chunks: Vec<Vec<u8>>,
    metadata: Vec<Vec<u8>>,
    /// Messages of each channel.
    counts: BTreeMap<u16, u64>,
    times: Times,
}

/// Data of a record.
trait Put {
    fn number<const BYTES: usize>(&mut self, bytes: [u8; BYTES]) -> &mut Self;
    fn text(&mut self, text: &str) -> &mut Self;
    fn map(&mut self, map: &Facts) -> &mut Self;
}

impl Put for Vec<u8> {
    fn number<const BYTES: usize>(&mut self, bytes: [u8; BYTES]) -> &mut Self {
        self.extend(bytes);
        self
    }

    fn text(&mut self, text: &str) -> &mut Self {
        self.number((text.len() as u32).to_le_bytes());
        self.extend(text.as_bytes());
        self
    }

    fn map(&mut self, map: &Facts) -> &mut Self {
        let bytes: usize = map.iter().map(|(name, value)| 8 + name.len() + value.len()).sum();
        self.number((bytes as u32).to_le_bytes());
        for (name, value) in map {
            self.text(name).text(value);
        }
        self
    }
}

/// Appends a record.
fn put_record(code: u8, data: &[u8], out: &mut Vec<u8>) {
    out.push(code);
    out.extend((data.len() as u64).to_le_bytes());
    out.extend_from_slice(data);
}

impl<W: Write> Container<W> {
    /// Begins a file for readers that know `profile`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn begin(out: W, profile: &str) -> Result<Self, RecordingError> {
        let mut container = Self {
            out,
            at: 0,
            checksum: crc32fast::Hasher::new(),
            compressor: None,
            chunk: Chunk::default(),
            record: Vec::new(),
            packed: Vec::new(),
            summary: Summary::default(),
        };
        container.write(&MAGIC)?;
        let mut header = Vec::new();
        header.text(profile).text("koseki");
        container.write_record(op::HEADER, &header)?;
        Ok(container)
    }

    /// Compresses all further chunks so.
    #[must_use]
    pub fn with(mut self, compression: Compression) -> Self {
        self.compressor = (compression == Compression::Zstd).then(Compressor::default);
        self
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), RecordingError> {
        self.checksum.update(bytes);
        self.at += bytes.len() as u64;
        Ok(self.out.write_all(bytes)?)
    }

    fn write_record(&mut self, code: u8, data: &[u8]) -> Result<(), RecordingError> {
        let mut head = vec![code];
        head.number((data.len() as u64).to_le_bytes());
        self.write(&head)?;
        self.write(data)
    }

    /// Writes named facts at once.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn metadata(&mut self, name: &str, facts: &Facts) -> Result<(), RecordingError> {
        let begin = self.at;
        let mut data = Vec::new();
        data.text(name).map(facts);
        self.write_record(op::METADATA, &data)?;
        let mut index = Vec::new();
        index
            .number(begin.to_le_bytes())
            .number((self.at - begin).to_le_bytes())
            .text(name);
        self.summary.metadata.push(index);
        Ok(())
    }

    /// Adds a schema, once for all channels. Returns its number.
    pub fn schema(&mut self, name: &str, encoding: &str, definition: &[u8]) -> u16 {
        let mut data = Vec::new();
        data.text(name)
            .text(encoding)
            .number((definition.len() as u32).to_le_bytes());
        data.extend_from_slice(definition);
        let known = self.summary.schemas.iter().position(|schema| schema[2..] == data);
        let number = known.unwrap_or(self.summary.schemas.len()) as u16 + 1;
        if known.is_none() {
            data.splice(0..0, number.to_le_bytes());
            put_record(op::SCHEMA, &data, &mut self.chunk.records);
            self.summary.schemas.push(data);
        }
        number
    }

    /// Adds a channel. Returns its number.
    pub fn channel(&mut self, schema: u16, topic: &str, encoding: &str, facts: &Facts) -> u16 {
        let number = self.summary.channels.len() as u16;
        let mut data = Vec::new();
        data.number(number.to_le_bytes())
            .number(schema.to_le_bytes())
            .text(topic)
            .text(encoding)
            .map(facts);
        put_record(op::CHANNEL, &data, &mut self.chunk.records);
        self.summary.channels.push(data);
        number
    }

    /// Adds a message, whose data are `parts` in their order, to the chunk in progress.
    pub fn message(&mut self, head: &MessageHead, parts: &[&[u8]]) {
        let chunk = &mut self.chunk;
        let place = chunk.records.len() as u64;
        chunk.index.entry(head.channel).or_default().push((head.log_ns, place));
        let bytes: usize = parts.iter().map(|part| part.len()).sum();
        let records = &mut chunk.records;
        records.push(op::MESSAGE);
        records
            .number((22 + bytes as u64).to_le_bytes())
            .number(head.channel.to_le_bytes())
            .number(head.sequence.to_le_bytes())
            .number(head.log_ns.to_le_bytes())
            .number(head.publish_ns.to_le_bytes());
        parts.iter().for_each(|part| records.extend_from_slice(part));
        chunk.times.add(head.log_ns);
        *self.summary.counts.entry(head.channel).or_default() += 1;
    }

    /// Returns the first and last time of the messages of written chunks, UTC, nanoseconds.
    pub(crate) fn times_ns(&self) -> Option<(u64, u64)> {
        self.summary.times.0
    }

    /// Returns the number of messages of a channel.
    pub(crate) fn count(&self, channel: u16) -> u64 {
        self.summary.counts.get(&channel).copied().unwrap_or(0)
    }

    /// Returns the size of the chunk in progress, bytes.
    pub fn gathered(&self) -> usize {
        self.chunk.records.len()
    }

    /// Writes the chunk in progress, and hands all to the system.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn flush(&mut self) -> Result<(), RecordingError> {
        self.end_chunk()?;
        Ok(self.out.flush()?)
    }

    fn end_chunk(&mut self) -> Result<(), RecordingError> {
        let mut chunk = std::mem::take(&mut self.chunk);
        if chunk.records.is_empty() {
            return Ok(());
        }
        let times = chunk.times.both();
        if let Some((first, last)) = chunk.times.0 {
            self.summary.times.add(first);
            self.summary.times.add(last);
        }
        let mut packed = std::mem::take(&mut self.packed);
        packed.clear();
        if let Some(compressor) = &mut self.compressor {
            compressor.compress(&chunk.records, &mut packed);
        }
        let is_shorter = !packed.is_empty() && packed.len() < chunk.records.len();
        let (name, stored) = match is_shorter {
            true => ("zstd", &packed),
            false => ("", &chunk.records),
        };
        let (begin, size) = (self.at, chunk.records.len() as u64);
        let mut head = std::mem::take(&mut self.record);
        head.clear();
        head.push(op::CHUNK);
        head.number((40 + name.len() as u64 + stored.len() as u64).to_le_bytes());
        head.number(times[0].to_le_bytes())
            .number(times[1].to_le_bytes())
            .number(size.to_le_bytes())
            .number(crc32fast::hash(&chunk.records).to_le_bytes())
            .text(name)
            .number((stored.len() as u64).to_le_bytes());
        self.write(&head)?;
        self.write(stored)?;
        let (end, stored) = (self.at, stored.len() as u64);
        let mut places = Vec::new();
        for (channel, messages) in &chunk.index {
            places.number(channel.to_le_bytes()).number(self.at.to_le_bytes());
            head.clear();
            head.number(channel.to_le_bytes())
                .number((16 * messages.len() as u32).to_le_bytes());
            for (time, place) in messages {
                head.number(time.to_le_bytes()).number(place.to_le_bytes());
            }
            self.write_record(op::MESSAGE_INDEX, &head)?;
        }
        let mut index = Vec::new();
        index
            .number(times[0].to_le_bytes())
            .number(times[1].to_le_bytes())
            .number(begin.to_le_bytes())
            .number((end - begin).to_le_bytes())
            .number((places.len() as u32).to_le_bytes());
        index.extend_from_slice(&places);
        index
            .number((self.at - end).to_le_bytes())
            .text(name)
            .number(stored.to_le_bytes())
            .number(size.to_le_bytes());
        self.summary.chunks.push(index);
        // The memory serves the next chunk.
        chunk.records.clear();
        self.chunk.records = chunk.records;
        (self.record, self.packed) = (head, packed);
        Ok(())
    }

    /// Writes the last chunk and the index. Returns the output.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn finish(mut self) -> Result<W, RecordingError> {
        self.end_chunk()?;
        let data_checksum = std::mem::take(&mut self.checksum).finalize();
        self.write_record(op::DATA_END, &data_checksum.to_le_bytes())?;
        self.checksum = crc32fast::Hasher::new();
        let (begin, summary) = (self.at, std::mem::take(&mut self.summary));
        let statistics = summary.statistics();
        let groups = [
            (op::SCHEMA, summary.schemas),
            (op::CHANNEL, summary.channels),
            (op::STATISTICS, vec![statistics]),
            (op::CHUNK_INDEX, summary.chunks),
            (op::METADATA_INDEX, summary.metadata),
        ];
        let mut offsets = Vec::new();
        for (code, records) in groups {
            let start = self.at;
            records.iter().try_for_each(|data| self.write_record(code, data))?;
            if self.at > start {
                let mut offset = vec![code];
                offset
                    .number(start.to_le_bytes())
                    .number((self.at - start).to_le_bytes());
                offsets.push(offset);
            }
        }
        let offsets_begin = self.at;
        offsets
            .iter()
            .try_for_each(|data| self.write_record(op::SUMMARY_OFFSET, data))?;
        let mut footer = vec![op::FOOTER];
        footer
            .number(20u64.to_le_bytes())
            .number(begin.to_le_bytes())
            .number(offsets_begin.to_le_bytes());
        self.write(&footer)?;
        let checksum = std::mem::take(&mut self.checksum).finalize();
        self.write(&checksum.to_le_bytes())?;
        self.write(&MAGIC)?;
        self.out.flush()?;
        Ok(self.out)
    }
}

impl Summary {
    fn statistics(&self) -> Vec<u8> {
        let [first, last] = self.times.both();
        let mut data = Vec::new();
        data.number(self.counts.values().sum::<u64>().to_le_bytes())
            .number((self.schemas.len() as u16).to_le_bytes())
            .number((self.channels.len() as u32).to_le_bytes())
            .number(0u32.to_le_bytes())
            .number((self.metadata.len() as u32).to_le_bytes())
            .number((self.chunks.len() as u32).to_le_bytes())
            .number(first.to_le_bytes())
            .number(last.to_le_bytes())
            .number((10 * self.counts.len() as u32).to_le_bytes());
        for (channel, count) in &self.counts {
            data.number(channel.to_le_bytes()).number(count.to_le_bytes());
        }
        data
    }
}

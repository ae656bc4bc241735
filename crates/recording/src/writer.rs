//! Writer of one file.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use mcap::WriteOptions;
use mcap::records::{MessageHeader, Metadata};
use messages::BatchHeader;
use messages::layout::{Layout, Sample};

use crate::contents::Contents;
use crate::{CDR, FACTS, FINGERPRINT, Facts, RecordingError, SLICES, fingerprint_of, schema_name};

/// Bytes of messages after which a chunk is written.
const CHUNK_BYTES: usize = 1 << 20;

/// Compression of chunks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// As the messages are.
    #[default]
    None,
    /// Zstandard.
    Zstd,
}

/// Writer of one file.
pub struct Writer<W: Write + Seek> {
    file: mcap::Writer<W>,
    /// Present message, reused.
    message: Vec<u8>,
    /// Bytes of messages in the chunk.
    gathered: usize,
    /// Name, type and number of messages of each channel, by its number.
    channels: BTreeMap<u16, (String, String, u64)>,
    /// First and last time of the messages, UTC, nanoseconds.
    times_ns: Option<(u64, u64)>,
}

/// Topic of a file.
#[derive(Clone, Copy, Debug)]
pub struct Channel {
    headers: u16,
    samples: u16,
    sample_size: usize,
}

impl<W: Write + Seek> std::fmt::Debug for Writer<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Writer").field("gathered", &self.gathered).finish()
    }
}

impl<W: Write + Seek> Writer<W> {
    /// Begins a file with `facts`, without compression.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn begin(out: W, facts: &Facts) -> Result<Self, RecordingError> {
        Self::compressed(out, facts, Compression::None)
    }

    /// Begins a file with `facts`, whose chunks are compressed so.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn compressed(out: W, facts: &Facts, compression: Compression) -> Result<Self, RecordingError> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library("koseki")
            .compression(match compression {
                Compression::None => None,
                Compression::Zstd => Some(mcap::Compression::Zstd),
            })
            // Higher levels take more time and save little: messages repeat each other.
            .compression_level(1)
            // Threads of the compressor would have no place in the plan of the cores.
            .compression_threads(0)
            .disable_seeking(true)
            // A chunk ends at the end of a slice, so that no slice is torn.
            .chunk_size(None);
        let mut file = options.create(out)?;
        file.write_metadata(&Metadata {
            name: FACTS.to_owned(),
            metadata: facts.clone(),
        })?;
        Ok(Self {
            file,
            message: Vec::new(),
            gathered: 0,
            channels: BTreeMap::new(),
            times_ns: None,
        })
    }

    /// Adds topic `name` with samples of this layout.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn channel(&mut self, name: &str, layout: &Layout) -> Result<Channel, RecordingError> {
        let definition = layout.ros2_schema();
        let fingerprint = fingerprint_of(layout);
        let schema = schema_name(layout);
        self.channel_of(name, layout.size, &schema, definition.as_bytes(), &fingerprint)
    }

    /// Adds topic `name` with samples of `size` bytes.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(crate) fn channel_of(
        &mut self,
        name: &str,
        sample_size: usize,
        schema: &str,
        definition: &[u8],
        fingerprint: &str,
    ) -> Result<Channel, RecordingError> {
        let header = BatchHeader::LAYOUT;
        let of_header = fingerprint_of(&header);
        Ok(Channel {
            headers: self.add(
                &format!("{name}{SLICES}"),
                &schema_name(&header),
                header.ros2_schema().as_bytes(),
                &of_header,
            )?,
            samples: self.add(name, schema, definition, fingerprint)?,
            sample_size,
        })
    }

    fn add(&mut self, name: &str, schema: &str, definition: &[u8], fingerprint: &str) -> Result<u16, RecordingError> {
        let kind = schema.to_owned();
        let schema = self.file.add_schema(schema, "ros2msg", definition)?;
        let fingerprint = (FINGERPRINT.to_owned(), fingerprint.to_owned());
        let channel = self
            .file
            .add_channel(schema, name, "cdr", &Facts::from([fingerprint]))?;
        self.channels.insert(channel, (name.to_owned(), kind, 0));
        Ok(channel)
    }

    /// Adds a slice with the samples `octets`, taken and sent at these times (UTC, nanoseconds). Returns whether a
    /// chunk was written: everything so far is then in the file.
    ///
    /// # Errors
    /// If the chunk cannot be written.
    pub fn slice(
        &mut self,
        channel: Channel,
        header: &BatchHeader,
        octets: &[u8],
        taken_ns: i64,
        sent_ns: i64,
    ) -> Result<bool, RecordingError> {
        let mut message = MessageHeader {
            channel_id: channel.headers,
            sequence: header.first_sequence as u32,
            log_time: taken_ns.max(0) as u64,
            publish_time: sent_ns.max(0) as u64,
        };
        self.message(&message, BatchHeader::octets(std::slice::from_ref(header)))?;
        message.channel_id = channel.samples;
        for sample in octets.chunks_exact(channel.sample_size) {
            self.message(&message, sample)?;
            message.sequence = message.sequence.wrapping_add(1);
        }
        let is_full = self.gathered >= CHUNK_BYTES;
        if is_full {
            self.flush()?;
        }
        Ok(is_full)
    }

    fn message(&mut self, header: &MessageHeader, octets: &[u8]) -> Result<(), RecordingError> {
        self.message.clear();
        self.message.extend_from_slice(&CDR);
        self.message.extend_from_slice(octets);
        self.gathered += self.message.len();
        self.file.write_to_known_channel(header, &self.message)?;
        if let Some((.., count)) = self.channels.get_mut(&header.channel_id) {
            *count += 1;
        }
        let time_ns = header.log_time;
        let (first_ns, last_ns) = self.times_ns.unwrap_or((time_ns, time_ns));
        self.times_ns = Some((first_ns.min(time_ns), last_ns.max(time_ns)));
        Ok(())
    }

    /// Hands all contents so far to the system.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn flush(&mut self) -> Result<(), RecordingError> {
        self.gathered = 0;
        Ok(self.file.flush()?)
    }

    /// Returns the contents so far; right after [`Writer::flush`], those of the file.
    pub fn contents(&self) -> Contents {
        let channels = self.channels.values().cloned();
        Contents {
            times_ns: self.times_ns,
            channels: channels.map(|(name, kind, count)| (name, (kind, count))).collect(),
        }
    }

    /// Writes the remaining contents and the index.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn finish(mut self) -> Result<(), RecordingError> {
        self.file.finish()?;
        Ok(())
    }
}

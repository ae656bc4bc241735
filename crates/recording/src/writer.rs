//! Writer of one file.

use std::io::Write;

use messages::BatchHeader;
use messages::layout::{Layout, Sample};

use crate::container::{Compression, Container, MessageHead};
use crate::contents::Contents;
use crate::{CDR, FACTS, FINGERPRINT, Facts, RecordingError, SCHEMA_PREFIX, SLICES, fingerprint_of};

/// Bytes of messages after which a chunk is written.
const CHUNK_BYTES: usize = 1 << 20;

/// Writer of one file.
#[derive(Debug)]
pub struct Writer<W> {
    file: Container<W>,
    /// Name and type of each channel.
    names: Vec<(String, String)>,
}

/// Topic of a file.
#[derive(Clone, Copy, Debug)]
pub struct Channel {
    headers: u16,
    samples: u16,
    sample_size: usize,
}

impl<W: Write> Writer<W> {
    /// Begins a file with `facts`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn begin(out: W, facts: &Facts) -> Result<Self, RecordingError> {
        let mut file = Container::begin(out, "ros2")?;
        file.metadata(FACTS, facts)?;
        Ok(Self {
            file,
            names: Vec::new(),
        })
    }

    /// Compresses the chunks so.
    #[must_use]
    pub fn with(self, compression: Compression) -> Self {
        Self {
            file: self.file.with(compression),
            names: self.names,
        }
    }

    /// Adds topic `name` with samples of this layout.
    pub fn channel(&mut self, name: &str, layout: &Layout) -> Channel {
        let definition = layout.ros2_schema();
        let fingerprint = fingerprint_of(layout);
        let schema = schema_name(layout);
        self.channel_of(name, layout.size, &schema, definition.as_bytes(), &fingerprint)
    }

    /// Adds topic `name` with samples of `size` bytes.
    pub(crate) fn channel_of(
        &mut self,
        name: &str,
        sample_size: usize,
        schema: &str,
        definition: &[u8],
        fingerprint: &str,
    ) -> Channel {
        let header = BatchHeader::LAYOUT;
        let of_header = fingerprint_of(&header);
        Channel {
            headers: self.add(
                &format!("{name}{SLICES}"),
                &schema_name(&header),
                header.ros2_schema().as_bytes(),
                &of_header,
            ),
            samples: self.add(name, schema, definition, fingerprint),
            sample_size,
        }
    }

    fn add(&mut self, name: &str, schema: &str, definition: &[u8], fingerprint: &str) -> u16 {
        self.names.push((name.to_owned(), schema.to_owned()));
        let schema = self.file.schema(schema, "ros2msg", definition);
        let fingerprint = (FINGERPRINT.to_owned(), fingerprint.to_owned());
        self.file.channel(schema, name, "cdr", &Facts::from([fingerprint]))
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
        let mut message = MessageHead {
            channel: channel.headers,
            sequence: header.first_sequence as u32,
            log_ns: taken_ns.max(0) as u64,
            publish_ns: sent_ns.max(0) as u64,
        };
        self.file
            .message(&message, &[&CDR, BatchHeader::octets(std::slice::from_ref(header))]);
        message.channel = channel.samples;
        for sample in octets.chunks_exact(channel.sample_size) {
            self.file.message(&message, &[&CDR, sample]);
            message.sequence = message.sequence.wrapping_add(1);
        }
        // A chunk ends at the end of a slice, so that no slice is torn.
        let is_full = self.file.gathered() >= CHUNK_BYTES;
        if is_full {
            self.flush()?;
        }
        Ok(is_full)
    }

    /// Hands all contents so far to the system.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn flush(&mut self) -> Result<(), RecordingError> {
        self.file.flush()
    }

    /// Returns the contents so far; right after [`Writer::flush`], those of the file.
    pub fn contents(&self) -> Contents {
        let channels = self.names.iter().zip(0..);
        Contents {
            times_ns: self.file.times_ns(),
            channels: channels
                .map(|((name, schema), number)| (name.clone(), (schema.clone(), self.file.count(number))))
                .collect(),
        }
    }

    /// Writes the remaining contents and the index.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn finish(self) -> Result<(), RecordingError> {
        self.file.finish().map(drop)
    }
}

fn schema_name(layout: &Layout) -> String {
    format!("{SCHEMA_PREFIX}{}", layout.name)
}

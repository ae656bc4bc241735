//! Reading one file, message by message.

use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};

use mcap::read::ChunkReader;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use messages::BatchHeader;
use messages::layout::Sample as _;

use crate::whole::{Whole, whole};
use crate::{CDR, FACTS, FINGERPRINT, Facts, RecordingError, SLICES};

/// Contents of a file, in its order.
#[derive(Clone, Debug, PartialEq)]
pub enum Item<'a> {
    /// Facts at its beginning.
    Facts(Facts),
    /// A topic is in it.
    Topic {
        /// Name.
        name: &'a str,
        /// Name of the schema of its samples.
        schema: &'a str,
        /// Schema itself, as ROS 2 has it.
        definition: &'a [u8],
        /// Fingerprint of the samples' layout.
        fingerprint: &'a str,
    },
    /// A slice begins; its samples follow.
    Slice {
        /// Name of the topic.
        topic: &'a str,
        /// Header of the slice.
        header: BatchHeader,
        /// Time when the recorder took it, UTC, nanoseconds.
        taken_ns: u64,
        /// Time when its publisher sent it, UTC, nanoseconds.
        sent_ns: u64,
    },
    /// A sample of the topic's latest slice.
    Sample {
        /// Name of the topic.
        topic: &'a str,
        /// The sample as it lay in memory.
        octets: &'a [u8],
    },
}

/// Shows all that a file holds to `visit`; of one that has no end, what can be read. Whether it had one.
///
/// # Errors
/// If it cannot be read, or holds what no recorder writes; or the first one of `visit`.
pub fn read<R: Read + Seek, E: From<RecordingError>>(
    file: &mut R,
    mut visit: impl FnMut(Item<'_>) -> Result<(), E>,
) -> Result<bool, E> {
    let Whole { bytes, is_ended } = whole(file).map_err(RecordingError::from)?;
    file.rewind().map_err(RecordingError::from)?;
    let mut file = file.take(bytes);
    let options = LinearReaderOptions::default()
        .with_skip_end_magic(true)
        .with_validate_chunk_crcs(true);
    let mut reader = LinearReader::new_with_options(options);
    let mut names = Names::default();
    while let Some(event) = reader.next_event() {
        match event.map_err(RecordingError::from)? {
            LinearReadEvent::ReadRequest(wanted) => {
                let read = file.read(reader.insert(wanted)).map_err(RecordingError::from)?;
                reader.notify_read(read);
            }
            LinearReadEvent::Record { opcode, data } => {
                let record = mcap::parse_record(opcode, data).map_err(RecordingError::from)?;
                names.show(record, &mut visit)?;
            }
        }
    }
    Ok(is_ended)
}

/// A file that is read chunk by chunk, in any order once all of it was.
#[derive(Debug)]
pub struct Chunks<R> {
    file: R,
    /// Octets of the file that can be read.
    end: u64,
    next: u64,
    names: Names,
    record: Vec<u8>,
}

impl<R: Read + Seek> Chunks<R> {
    /// The file from its beginning.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn new(mut file: R) -> Result<Self, RecordingError> {
        let end = whole(&mut file)?.bytes;
        Ok(Self {
            file,
            end,
            next: mcap::MAGIC.len() as u64,
            names: Names::default(),
            record: Vec::new(),
        })
    }

    /// Place from which [`Chunks::read`] will read, octets from the beginning.
    pub fn place(&self) -> u64 {
        self.next
    }

    /// Reads on from a place that [`Chunks::place`] gave.
    pub fn go_to(&mut self, place: u64) {
        self.next = place;
    }

    /// Shows the next chunk, and what stands before it, to `visit`. `false` at the end.
    ///
    /// # Errors
    /// If it cannot be read, or holds what no recorder writes; or the first one of `visit`.
    pub fn read<E: From<RecordingError>>(
        &mut self,
        mut visit: impl FnMut(Item<'_>) -> Result<(), E>,
    ) -> Result<bool, E> {
        while self.next < self.end {
            let code = self.record().map_err(RecordingError::from)?;
            match mcap::parse_record(code, &self.record).map_err(RecordingError::from)? {
                Record::Chunk { header, data } => {
                    let records = ChunkReader::new(header, &data).map_err(RecordingError::from)?;
                    for record in records {
                        self.names.show(record.map_err(RecordingError::from)?, &mut visit)?;
                    }
                    return Ok(true);
                }
                record => self.names.show(record, &mut visit)?,
            }
        }
        Ok(false)
    }

    /// Takes the next record out of the file. Its code.
    fn record(&mut self) -> std::io::Result<u8> {
        let mut head = [0; 9];
        self.file.seek(SeekFrom::Start(self.next))?;
        self.file.read_exact(&mut head)?;
        let length = u64::from_le_bytes(head[1..].try_into().expect("eight octets"));
        self.record.clear();
        let read = (&mut self.file).take(length).read_to_end(&mut self.record)?;
        self.next += head.len() as u64 + read as u64;
        Ok(head[0])
    }
}

/// Facts at the beginning of a file; `None` without any.
///
/// # Errors
/// If it cannot be read.
pub fn facts<R: Read + Seek>(file: &mut R) -> Result<Option<Facts>, RecordingError> {
    enum Stop {
        Found(Facts),
        Failed(RecordingError),
    }
    impl From<RecordingError> for Stop {
        fn from(error: RecordingError) -> Self {
            Self::Failed(error)
        }
    }
    let found = read(file, |item| match item {
        Item::Facts(facts) => Err(Stop::Found(facts)),
        _ => Ok(()),
    });
    match found {
        Ok(_) => Ok(None),
        Err(Stop::Found(facts)) => Ok(Some(facts)),
        Err(Stop::Failed(error)) => Err(error),
    }
}

/// Channels and schemas of one file.
#[derive(Debug, Default)]
struct Names {
    schemas: BTreeMap<u16, (String, Vec<u8>)>,
    topics: BTreeMap<u16, String>,
}

impl Names {
    fn show<E>(&mut self, record: Record<'_>, visit: &mut impl FnMut(Item<'_>) -> Result<(), E>) -> Result<(), E> {
        match record {
            Record::Metadata(metadata) if metadata.name == FACTS => visit(Item::Facts(metadata.metadata)),
            Record::Schema { header, data } => {
                self.schemas.insert(header.id, (header.name, data.into_owned()));
                Ok(())
            }
            Record::Channel(channel) => {
                let name = &channel.topic;
                let schema = self.schemas.get(&channel.schema_id);
                let shown = match (name.ends_with(SLICES), schema) {
                    (false, Some((schema, definition))) => visit(Item::Topic {
                        name,
                        schema,
                        definition,
                        fingerprint: channel.metadata.get(FINGERPRINT).map_or("", String::as_str),
                    }),
                    _ => Ok(()),
                };
                self.topics.insert(channel.id, channel.topic);
                shown
            }
            Record::Message { header, data } => {
                let Some(name) = self.topics.get(&header.channel_id) else {
                    return Ok(());
                };
                let octets = data.strip_prefix(&CDR).unwrap_or_default();
                match name.strip_suffix(SLICES) {
                    None => visit(Item::Sample { topic: name, octets }),
                    Some(topic) => match BatchHeader::of_octets(octets) {
                        Some(slice) => visit(Item::Slice {
                            topic,
                            header: slice,
                            taken_ns: header.log_time,
                            sent_ns: header.publish_time,
                        }),
                        None => Ok(()),
                    },
                }
            }
            _ => Ok(()),
        }
    }
}

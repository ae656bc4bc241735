//! Finding out what a recording holds.

use std::collections::BTreeMap;
use std::io::{Read, Seek};

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use messages::BatchHeader;
use messages::layout::Sample as _;

use crate::tally::Tally;
use crate::whole::{Whole, whole};
use crate::{CDR, FACTS, Facts, RecordingError, SLICES};

/// Contents of one file, or of several of one recording, in their order.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// Facts at the beginning of the last file.
    pub facts: Facts,
    /// Topics by name.
    pub topics: BTreeMap<String, TopicSurvey>,
    /// Files of which the end was missing.
    pub torn: u64,
}

/// Contents of one topic.
#[derive(Clone, Debug, Default)]
pub struct TopicSurvey {
    /// Schema of its samples.
    pub schema: String,
    /// Slices.
    pub slices: u64,
    /// Samples.
    pub samples: u64,
    /// Time when the first slice was taken, UTC, nanoseconds; `None` without any.
    pub first_ns: Option<u64>,
    /// Time when the last slice was taken, likewise.
    pub last_ns: Option<u64>,
    /// Count of what is missing.
    pub tally: Tally,
    /// Header of the slice at hand, and its samples so far.
    slice: Option<(BatchHeader, usize)>,
}

/// Channels and schemas of one file.
#[derive(Debug, Default)]
struct Channels {
    schemas: BTreeMap<u16, String>,
    topics: BTreeMap<u16, String>,
}

impl Survey {
    /// Adds what a file holds; of one that has no end, what can be read.
    ///
    /// # Errors
    /// If it cannot be read, or holds what no recorder writes.
    pub fn add<R: Read + Seek>(&mut self, file: &mut R) -> Result<(), RecordingError> {
        let Whole { bytes, is_ended } = whole(file)?;
        self.torn += u64::from(!is_ended);
        file.rewind()?;
        let mut file = file.take(bytes);
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_validate_chunk_crcs(true);
        let mut reader = LinearReader::new_with_options(options);
        let mut channels = Channels::default();
        while let Some(event) = reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(wanted) => {
                    let read = file.read(reader.insert(wanted))?;
                    reader.notify_read(read);
                }
                LinearReadEvent::Record { opcode, data } => {
                    self.record(&mut channels, mcap::parse_record(opcode, data)?);
                }
            }
        }
        self.topics.values_mut().for_each(TopicSurvey::end_slice);
        Ok(())
    }

    fn record(&mut self, channels: &mut Channels, record: Record<'_>) {
        match record {
            Record::Metadata(metadata) if metadata.name == FACTS => self.begin(metadata.metadata),
            Record::Schema { header, .. } => {
                channels.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                if !channel.topic.ends_with(SLICES) {
                    self.topic(&channel.topic).schema =
                        channels.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                }
                channels.topics.insert(channel.id, channel.topic);
            }
            Record::Message { header, data } => {
                let Some(name) = channels.topics.get(&header.channel_id) else {
                    return;
                };
                let octets = data.strip_prefix(&CDR);
                match (name.strip_suffix(SLICES), octets.and_then(BatchHeader::of_octets)) {
                    (Some(name), Some(slice)) => self.topic(name).begin_slice(slice, header.log_time),
                    (Some(_), None) => {}
                    (None, _) => self.topic(name).add_sample(),
                }
            }
            _ => {}
        }
    }

    fn begin(&mut self, facts: Facts) {
        for (name, topic) in &mut self.topics {
            topic.tally = Tally::begin(name, &facts);
        }
        self.facts = facts;
    }

    fn topic(&mut self, name: &str) -> &mut TopicSurvey {
        let tally = || Tally::begin(name, &self.facts);
        self.topics.entry(name.to_owned()).or_insert_with(|| TopicSurvey {
            tally: tally(),
            ..TopicSurvey::default()
        })
    }
}

impl TopicSurvey {
    fn begin_slice(&mut self, slice: BatchHeader, taken_ns: u64) {
        self.end_slice();
        self.slice = Some((slice, 0));
        self.slices += 1;
        self.first_ns.get_or_insert(taken_ns);
        self.last_ns = Some(taken_ns);
    }

    fn add_sample(&mut self) {
        self.samples += 1;
        if let Some((_, count)) = &mut self.slice {
            *count += 1;
        }
    }

    fn end_slice(&mut self) {
        if let Some((slice, count)) = self.slice.take() {
            self.tally.slice(&slice, count);
        }
    }
}

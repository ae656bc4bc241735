//! Survey of a recording's contents.

use std::collections::BTreeMap;
use std::io::{Read, Seek};

use messages::BatchHeader;

use crate::reader::{Item, read};
use crate::tally::Tally;
use crate::{Facts, RecordingError};

/// Contents of one file, or of several files of one recording in their order.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// Facts at the beginning of the last file.
    pub facts: Facts,
    /// Topics by name.
    pub topics: BTreeMap<String, TopicSurvey>,
    /// Number of files without their end.
    pub torn: u64,
    /// Damaged parts that were skipped.
    pub damaged: u64,
    /// Their bytes.
    pub damaged_bytes: u64,
    /// Gaps, each from one slice to the next, UTC, nanoseconds: the recorder did not run, or the part was cut out.
    pub gaps_ns: Vec<[u64; 2]>,
    /// Time at which the latest slice was taken.
    taken_ns: Option<u64>,
}

/// Minimum time without slices for a gap, nanoseconds. A recorder that runs records its own health every 0.4 s.
const GAP_NS: u64 = 700_000_000;

/// Contents of one topic.
#[derive(Clone, Debug, Default)]
pub struct TopicSurvey {
    /// Schema of the samples.
    pub schema: String,
    /// Number of slices.
    pub slices: u64,
    /// Number of samples.
    pub samples: u64,
    /// Time at which the first slice was taken, UTC, nanoseconds; `None` without slices.
    pub first_ns: Option<u64>,
    /// Time at which the last slice was taken, UTC, nanoseconds; `None` without slices.
    pub last_ns: Option<u64>,
    /// Count of missing samples.
    pub tally: Tally,
    /// Header of the present slice, and its samples so far.
    slice: Option<(BatchHeader, usize)>,
}

impl Survey {
    /// Adds the contents of a file; of a file without an end, the readable contents.
    ///
    /// # Errors
    /// If the file cannot be read, or is not written by a recorder.
    pub fn add<R: Read + Seek>(&mut self, file: &mut R) -> Result<(), RecordingError> {
        let is_ended = read::<_, RecordingError>(file, |item| {
            self.item(item);
            Ok(())
        })?;
        self.torn += u64::from(!is_ended);
        self.end_slices();
        Ok(())
    }

    /// Adds an item of a file.
    pub(crate) fn item(&mut self, item: Item<'_>) {
        match item {
            Item::Facts(facts) => self.begin(facts),
            Item::Topic { name, schema, .. } => self.topic(name).schema = schema.to_owned(),
            Item::Slice {
                topic,
                header,
                taken_ns,
                ..
            } => {
                let before_ns = self.taken_ns.replace(taken_ns).unwrap_or(taken_ns);
                if taken_ns.saturating_sub(before_ns) > GAP_NS {
                    self.gaps_ns.push([before_ns, taken_ns]);
                }
                self.topic(topic).begin_slice(header, taken_ns);
            }
            Item::Sample { topic, .. } => self.topic(topic).add_sample(),
            Item::Damaged { bytes, .. } => {
                self.damaged += 1;
                self.damaged_bytes += bytes.end - bytes.start;
            }
        }
    }

    /// Ends the slices in progress.
    pub(crate) fn end_slices(&mut self) {
        self.topics.values_mut().for_each(TopicSurvey::end_slice);
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

//! Contents of the files of a recording, and their description as a ROS 2 bag.
//!
//! Programs for ROS 2 open a folder as a bag if `metadata.yaml` describes its files (rosbag2, version 5). The numbers
//! of a complete file are in its summary; a file without an end is read for them.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{Read, Seek, SeekFrom};

use mcap::records::op;

use crate::damage::summary;
use crate::record::Fields;
use crate::survey::Survey;
use crate::{RecordingError, SCHEMA_PREFIX, SLICES};

/// Contents of one file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Contents {
    /// First and last time of its messages, UTC, nanoseconds; `None` without messages.
    pub times_ns: Option<(u64, u64)>,
    /// Type and number of the messages of each channel, by its name.
    pub channels: BTreeMap<String, (String, u64)>,
}

/// Longest record of a summary that describes contents, bytes.
const DESCRIPTION_BYTES: usize = 1 << 20;

impl Contents {
    /// Returns the contents of a file, of a file without an end what can be read.
    ///
    /// # Errors
    /// If the file cannot be read, or is not written by a recorder.
    pub fn of<R: Read + Seek>(file: &mut R) -> Result<Self, RecordingError> {
        match Self::summarised(file)? {
            Some(contents) => Ok(contents),
            None => Self::surveyed(file),
        }
    }

    fn messages(&self) -> u64 {
        self.channels.values().map(|(_, count)| count).sum()
    }

    /// Returns what the summary states; `None` without one.
    fn summarised<R: Read + Seek>(file: &mut R) -> Result<Option<Self>, RecordingError> {
        let length = file.seek(SeekFrom::End(0))?;
        let (mut schemas, mut channels) = (BTreeMap::new(), BTreeMap::new());
        let (mut counts, mut times_ns) = (None, None);
        summary(file, length, DESCRIPTION_BYTES, |code, data| {
            let mut fields = Fields::of(data, length);
            let mut read = || -> Result<(), RecordingError> {
                match code {
                    op::SCHEMA => drop(schemas.insert(fields.u16()?, fields.text()?.to_owned())),
                    op::CHANNEL => {
                        let number = fields.u16()?;
                        let schema = schemas.get(&fields.u16()?).cloned().unwrap_or_default();
                        channels.insert(number, (fields.text()?.to_owned(), schema));
                    }
                    op::STATISTICS => {
                        let messages = fields.u64()?;
                        let _objects = (
                            fields.u16()?,
                            fields.u32()?,
                            fields.u32()?,
                            fields.u32()?,
                            fields.u32()?,
                        );
                        let (first, last) = (fields.u64()?, fields.u64()?);
                        times_ns = (messages > 0).then_some((first, last));
                        let mut each = Fields::of(fields.octets()?, length);
                        let found: &mut BTreeMap<u16, u64> = counts.get_or_insert_default();
                        while !each.rest().is_empty() {
                            found.insert(each.u16()?, each.u64()?);
                        }
                    }
                    _ => {}
                }
                Ok(())
            };
            // A damaged summary lacks numbers, and the file is then read for them.
            if read().is_err() {
                counts = None;
            }
        })?;
        Ok(counts.map(|counts| Self {
            times_ns,
            channels: channels
                .into_iter()
                .map(|(number, (name, schema))| (name, (schema, counts.get(&number).copied().unwrap_or(0))))
                .collect(),
        }))
    }

    fn surveyed<R: Read + Seek>(file: &mut R) -> Result<Self, RecordingError> {
        let mut survey = Survey::default();
        survey.add(file)?;
        let mut contents = Self::default();
        for (name, topic) in survey.topics {
            if let (Some(first), Some(last)) = (topic.first_ns, topic.last_ns) {
                let (begin, end) = contents.times_ns.unwrap_or((first, last));
                contents.times_ns = Some((begin.min(first), end.max(last)));
            }
            let header = format!("{SCHEMA_PREFIX}BatchHeader");
            contents
                .channels
                .insert(format!("{name}{SLICES}"), (header, topic.slices));
            contents.channels.insert(name, (topic.schema, topic.samples));
        }
        Ok(contents)
    }
}

/// Returns the text of `metadata.yaml` for files by their names, in their order.
pub fn bag(files: &[(String, Contents)]) -> String {
    let mut channels: BTreeMap<&str, (&str, u64)> = BTreeMap::new();
    let mut times_ns: Option<(u64, u64)> = None;
    for (_, contents) in files {
        for (name, (schema, count)) in &contents.channels {
            channels.entry(name).or_insert((schema, 0)).1 += count;
        }
        if let Some((first, last)) = contents.times_ns {
            let (begin, end) = times_ns.unwrap_or((first, last));
            times_ns = Some((begin.min(first), end.max(last)));
        }
    }
    let messages: u64 = files.iter().map(|(_, contents)| contents.messages()).sum();
    let mut text = "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n".to_owned();
    put_times(&mut text, "  ", times_ns);
    let mut put = |line: std::fmt::Arguments<'_>| {
        // A text takes every line.
        let _ = writeln!(text, "  {line}");
    };
    put(format_args!("message_count: {messages}"));
    put(format_args!("topics_with_message_count:"));
    for (name, (schema, count)) in channels {
        put(format_args!("  - topic_metadata:"));
        put(format_args!("      name: {}", quoted(name)));
        put(format_args!("      type: {}", quoted(schema)));
        put(format_args!("      serialization_format: cdr"));
        put(format_args!("      offered_qos_profiles: \"\""));
        put(format_args!("    message_count: {count}"));
    }
    put(format_args!("compression_format: \"\""));
    put(format_args!("compression_mode: \"\""));
    put(format_args!("relative_file_paths:"));
    for (name, _) in files {
        put(format_args!("  - {}", quoted(name)));
    }
    put(format_args!("files:"));
    for (name, contents) in files {
        let _ = writeln!(text, "    - path: {}", quoted(name));
        put_times(&mut text, "      ", contents.times_ns);
        let _ = writeln!(text, "      message_count: {}", contents.messages());
    }
    text
}

fn put_times(text: &mut String, indent: &str, times_ns: Option<(u64, u64)>) {
    let (first, last) = times_ns.unwrap_or((0, 0));
    let _ = write!(
        text,
        "{indent}starting_time:\n{indent}  nanoseconds_since_epoch: {first}\n\
         {indent}duration:\n{indent}  nanoseconds: {}\n",
        last.saturating_sub(first)
    );
}

/// Returns a text as YAML: in quotes, so that no character has a meaning.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bag_counts_over_all_files_and_quotes_names() {
        let contents = |first, count| Contents {
            times_ns: Some((first, first + 5)),
            channels: BTreeMap::from([("a \"b\"".to_owned(), ("koseki/msg/Cue".to_owned(), count))]),
        };
        let files = [
            ("1.mcap".to_owned(), contents(10, 2)),
            ("2.mcap".to_owned(), contents(20, 3)),
        ];
        let text = bag(&files);
        assert!(text.contains("        name: \"a \\\"b\\\"\"\n"), "{text}");
        assert!(text.contains("\n      message_count: 5\n"), "{text}");
        assert!(text.contains("\n  message_count: 5\n"), "{text}");
        let times = "  starting_time:\n    nanoseconds_since_epoch: 10\n  duration:\n    nanoseconds: 15\n";
        assert!(text.contains(times), "{text}");
        assert!(text.contains("\n    - path: \"2.mcap\"\n      starting_time:\n        nanoseconds_since_epoch: 20\n"));
    }
}

//! HdrHistogram log: one line per interval, stage and source.
//!
//! The format is that of the usual tools (HistogramLogAnalyzer, HistogramLogProcessor, hdrhistogram's own parser): a
//! header of version 1.3, start and base time, then lines `Tag=…,begin,length,max,histogram` with begin and length in
//! seconds since the base time and the histogram in compressed V2 form. Values are nanoseconds.
//!
//! Tags are `stage` for all sources together and `stage/source` for one source: `end_to_end`,
//! `end_to_end/radar-west`. The first interval without reports still has its lines for all sources, so that a stall is
//! visible; those after it, and a silent source, have none.

use std::io::{self, Write};
use std::time::{Duration, UNIX_EPOCH};

use hdrhistogram::Histogram;
use hdrhistogram::serialization::V2DeflateSerializer;
use hdrhistogram::serialization::interval_log::{IntervalLogWriterBuilder, IntervalLogWriterError, Tag};

use crate::stage::Stage;
use crate::stages::{Span, Stages};

/// Writer of an HdrHistogram log.
pub struct IntervalLog<W: Write> {
    writer: W,
    serializer: V2DeflateSerializer,
    start_utc_ns: i64,
    /// Whether the latest line of a stage for all sources was empty.
    is_silent: [bool; Stage::ALL.len()],
}

impl<W: Write> IntervalLog<W> {
    /// Writes the header; the log's times count from `start_utc_ns` (UTC, nanoseconds since 1970).
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn begin(mut writer: W, start_utc_ns: i64) -> io::Result<Self> {
        let start = UNIX_EPOCH + Duration::from_nanos(start_utc_ns.max(0) as u64);
        let mut serializer = V2DeflateSerializer::new();
        IntervalLogWriterBuilder::new()
            .add_comment("[Latencies of each stage and source, nanoseconds]")
            .add_comment("[Histogram log format version 1.3]")
            .with_start_time(start)
            .with_base_time(start)
            .begin_log_with(&mut writer, &mut serializer)?;
        writeln!(
            writer,
            r#""StartTimestamp","Interval_Length","Interval_Max","Interval_Compressed_Histogram""#
        )?;
        Ok(Self {
            writer,
            serializer,
            start_utc_ns,
            is_silent: Default::default(),
        })
    }

    /// Writes the latest closed interval of `stages`, which began at `begin_utc_ns` and lasted `length_ns`.
    /// `source_name` returns the name of a source.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn write_interval<N: AsRef<str>>(
        &mut self,
        stages: &Stages,
        begin_utc_ns: i64,
        length_ns: u64,
        source_name: impl Fn(u16) -> N,
    ) -> io::Result<()> {
        self.write_part(stages, None, begin_utc_ns, length_ns, &source_name)?;
        stages
            .sources()
            .try_for_each(|source| self.write_part(stages, Some(source), begin_utc_ns, length_ns, &source_name))
    }

    /// Writes the lines of one source, or of all sources together (`None`), as a part of
    /// [`IntervalLog::write_interval`]: compression takes time, and with many sources other work may be urgent in
    /// between.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn write_part<N: AsRef<str>>(
        &mut self,
        stages: &Stages,
        source: Option<u16>,
        begin_utc_ns: i64,
        length_ns: u64,
        source_name: impl Fn(u16) -> N,
    ) -> io::Result<()> {
        let begin = Duration::from_nanos((begin_utc_ns - self.start_utc_ns).max(0) as u64);
        let length = Duration::from_nanos(length_ns);
        for (index, stage) in Stage::ALL.into_iter().enumerate() {
            let Some(histogram) = stages.histogram(stage, source, Span::Interval) else {
                continue;
            };
            match source {
                None => {
                    let was_silent = std::mem::replace(&mut self.is_silent[index], histogram.is_empty());
                    if !(was_silent && histogram.is_empty()) {
                        self.write_line(stage.key(), histogram, begin, length)?;
                    }
                }
                Some(_) if histogram.is_empty() => {}
                Some(source) => {
                    let tag = format!("{}/{}", stage.key(), fit_for_tag(source_name(source).as_ref()));
                    self.write_line(&tag, histogram, begin, length)?;
                }
            }
        }
        Ok(())
    }

    /// Flushes the writer.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }

    /// Returns the writer with all that was written.
    pub fn into_writer(self) -> W {
        self.writer
    }

    fn write_line(
        &mut self,
        tag: &str,
        histogram: &Histogram<u64>,
        begin: Duration,
        length: Duration,
    ) -> io::Result<()> {
        // A log continued without comments and times has no header, so that only the line is added.
        IntervalLogWriterBuilder::new()
            .begin_log_with(&mut self.writer, &mut self.serializer)?
            .write_histogram(histogram, begin, length, Tag::new(tag))
            .map_err(|error| match error {
                IntervalLogWriterError::IoError(error) => error,
                IntervalLogWriterError::SerializeError(error) => io::Error::other(error),
            })
    }
}

/// Tags contain no blanks, commas or line ends.
fn fit_for_tag(name: &str) -> String {
    name.replace([' ', ',', '\r', '\n'], "_")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use base64::Engine as _;
    use hdrhistogram::serialization::Deserializer;
    use hdrhistogram::serialization::interval_log::{IntervalLogIterator, LogEntry};
    use messages::{StageTimes, SystemTrack};

    use super::*;

    const UTC_NS: i64 = 1_700_000_000_250_000_000;

    fn track(source: u16, latency_ns: i64) -> SystemTrack {
        SystemTrack {
            trigger_source: source,
            time_of_measurement_ns: UTC_NS,
            stages: StageTimes {
                ingested_ns: 1_000_000,
                published_ns: 1_000_000 + latency_ns,
                taken_ns: 1_000_000 + 2 * latency_ns,
                fused_ns: 1_000_000 + 3 * latency_ns,
            },
            ..SystemTrack::default()
        }
    }

    #[test]
    fn reads_back_with_the_same_totals() {
        let mut stages = Stages::default();
        let mut log = IntervalLog::begin(Vec::new(), UTC_NS).expect("in memory");
        for interval in 0..5i64 {
            for report in 0..200 * (interval - 2).abs() {
                let latency_ns = 1000 + 37 * report;
                let track = track((report % 3) as u16, latency_ns);
                stages.record(&track, 1_000_000 + 4 * latency_ns, UTC_NS + 5 * latency_ns);
            }
            stages.close_interval();
            log.write_interval(&stages, UTC_NS + interval * 1_000_000_000, 1_000_000_000, |source| {
                format!("sensor {source}")
            })
            .expect("in memory");
        }
        log.flush().expect("in memory");

        let bytes = log.into_writer();
        let mut read: BTreeMap<String, Histogram<u64>> = BTreeMap::new();
        let mut intervals = 0;
        for entry in IntervalLogIterator::new(&bytes) {
            match entry.expect("well-formed") {
                LogEntry::StartTime(time) | LogEntry::BaseTime(time) => {
                    assert_eq!(time, Duration::from_millis(1_700_000_000_250));
                }
                LogEntry::Interval(line) => {
                    let tag = line.tag().expect("every line has one").as_str().to_owned();
                    intervals += u32::from(tag == "age");
                    assert_eq!(line.duration(), Duration::from_secs(1));
                    assert!(line.start_timestamp() <= Duration::from_secs(4));
                    let histogram = decoded(line.encoded_histogram());
                    read.entry(tag)
                        .or_insert_with(|| Histogram::new(3).expect("possible"))
                        .add(histogram)
                        .expect("grows");
                }
            }
        }
        assert_eq!(intervals, 5, "the one silent interval has its line too");
        assert_eq!(read.len(), 6 * 4);
        for stage in Stage::ALL {
            assert_eq!(
                &read[stage.key()],
                stages.histogram(stage, None, Span::Total).expect("exists")
            );
            for source in 0..3u16 {
                assert_eq!(
                    &read[&format!("{}/sensor_{source}", stage.key())],
                    stages.histogram(stage, Some(source), Span::Total).expect("exists")
                );
            }
        }
    }

    fn decoded(text: &str) -> Histogram<u64> {
        let bytes = base64::engine::general_purpose::STANDARD.decode(text).expect("base64");
        Deserializer::new()
            .deserialize(&mut bytes.as_slice())
            .expect("a histogram")
    }

    #[test]
    fn of_a_long_silence_the_first_interval_is_written() {
        let mut stages = Stages::default();
        let mut log = IntervalLog::begin(Vec::new(), UTC_NS).expect("in memory");
        for interval in 0..10i64 {
            if interval == 4 {
                stages.record(&track(0, 1000), 1_005_000, UTC_NS + 5000);
            }
            stages.close_interval();
            log.write_interval(&stages, UTC_NS + interval * 1_000_000_000, 1_000_000_000, |_| "radar")
                .expect("in memory");
        }
        let bytes = log.into_writer();
        let begins = IntervalLogIterator::new(&bytes).filter_map(|entry| match entry.expect("well-formed") {
            LogEntry::Interval(line) if line.tag()?.as_str() == "age" => Some(line.start_timestamp().as_secs()),
            _ => None,
        });
        assert_eq!(begins.collect::<Vec<_>>(), [0, 4, 5]);
    }

    #[test]
    fn header() {
        let log = IntervalLog::begin(Vec::new(), UTC_NS).expect("in memory");
        let text = String::from_utf8(log.into_writer()).expect("text");
        assert_eq!(
            text,
            "#[Latencies of each stage and source, nanoseconds]\n\
             #[Histogram log format version 1.3]\n\
             #[StartTime: 1700000000.250 (seconds since epoch)]\n\
             #[BaseTime: 1700000000.250 (seconds since epoch)]\n\
             \"StartTimestamp\",\"Interval_Length\",\"Interval_Max\",\"Interval_Compressed_Histogram\"\n"
        );
    }
}

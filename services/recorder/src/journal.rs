//! The recorded stream: slices with topic, time, position and losses, written by two sinks.
//!
//! Files of all topics ([`SegmentSink`]) hold every slice bit by bit; [`Tables`] hold a row for each new sample of a
//! data stream. The [`Account`] of each topic holds its position and losses, whichever sinks are configured.
//!
//! On a full disk, each file stands for itself: [`SegmentSink`] counts the samples as lost and tries again in a new
//! file, and each of the [`Tables`] counts its lost rows and tries again after its last complete row.

use std::io::ErrorKind;

use anyhow::Context as _;
use deployment::Deployment;
use messages::layout::{Layout, Sample};
use messages::{BatchHeader, Streamed};
use recording::Facts;
use runtime::{Now, NumberedFiles};

use crate::account::{Account, Losses, SampleNumbers};
use crate::bag::Bag;
use crate::recovery::{self, Earlier};
use crate::segments::{SegmentCounts, SegmentSink};
use crate::settings::{Format, Settings};
use crate::slice::StreamSlice;
use crate::start::Start;
use crate::tables::Tables;

/// Prefix of the names of files of all topics.
const STEM: &str = "all_topics_";

/// Accounts of the topics, and sinks.
#[derive(Debug)]
pub(crate) struct Journal {
    accounts: Vec<Account>,
    tables: Option<Tables>,
    segments: Option<SegmentSink>,
    /// Losses by cause, up to the latest loss, and its cause in words; empty without a loss.
    losses: Losses,
    cause: &'static str,
}

impl Journal {
    /// Begins or continues the recording of the run `start` of `config`, with these topics, at `since_ns`
    /// (monotonic, nanoseconds).
    ///
    /// # Errors
    /// If the folder holds another run, or the files of an earlier recorder cannot be read or continued.
    pub(crate) fn new(
        (config, settings): (&Deployment, &Settings),
        start: &Start<'_>,
        topics: Vec<(String, Layout)>,
        since_ns: i64,
    ) -> anyhow::Result<Self> {
        let (folder, containers) = (start.folder, settings.containers());
        std::fs::create_dir_all(folder).with_context(|| format!("making the folder {}", folder.display()))?;
        let resume = recovery::claim(folder, start.run)?;
        let files = NumberedFiles::new(folder, STEM, ".mcap");
        let earlier = containers.map(|_| Earlier::read(&files)).transpose()?;
        let earlier = earlier.unwrap_or_default();
        let account = |(name, layout): (String, Layout)| {
            let tally = earlier.tally(&name, since_ns.cast_unsigned());
            Account::new(name, layout, tally)
        };
        let mut accounts: Vec<_> = topics.into_iter().map(account).collect();
        let tables = || Tables::resume(config, folder, start.first_day_ns, resume);
        let tables = settings.has(Format::Csv).then(tables).transpose()?;
        for (place, (id, _)) in config.recorded_streams().enumerate() {
            if config.is_recorded() && id.stream.is_replayed() {
                // Only tables state the position of an earlier recorder.
                let numbers = tables
                    .as_ref()
                    .map_or_else(SampleNumbers::default, |rows| rows.numbers(place));
                accounts[place].follow(numbers);
            }
        }
        let facts = || {
            Facts::from([
                ("run".to_owned(), start.run.trim().to_owned()),
                ("version".to_owned(), start.version.to_owned()),
                ("first_day_ns".to_owned(), start.first_day_ns.to_string()),
                ("configuration".to_owned(), config.text_without_secrets()),
            ])
        };
        let topics = accounts.len();
        let segments = |limits| {
            let bag = Bag::new(folder, &files);
            let how = (limits, settings.compression.of_chunks());
            SegmentSink::new((files, earlier.number, bag), how, facts(), topics)
        };
        Ok(Self {
            segments: containers.map(segments),
            accounts,
            tables,
            losses: Losses::default(),
            cause: "",
        })
    }

    /// Adds a slice of a data stream.
    pub(crate) fn add_numbered<T: Streamed>(&mut self, place: usize, header: &BatchHeader, samples: &[T], now: Now) {
        let from_sequence = self.accounts[place].add_samples(samples);
        let slice = StreamSlice {
            place,
            header,
            octets: T::octets(samples),
            from_sequence,
            now,
        };
        self.add_to_segments(&slice);
        if let Some(tables) = &mut self.tables {
            tables.slice(&slice);
        }
    }

    /// Adds a slice of another topic.
    pub(crate) fn add<T: Sample>(&mut self, place: usize, header: &BatchHeader, samples: &[T], now: Now) {
        self.add_to_segments(&StreamSlice {
            place,
            header,
            octets: T::octets(samples),
            from_sequence: 0,
            now,
        });
    }

    fn add_to_segments(&mut self, slice: &StreamSlice<'_>) {
        let accounts = &mut self.accounts;
        if let Some(segments) = &mut self.segments {
            segments.open_if_due(accounts, slice.now);
        }
        let count = slice.octets.len() / accounts[slice.place].layout().size;
        accounts[slice.place].add_slice(slice.header, count);
        if let Some(segments) = &mut self.segments {
            segments.slice(accounts, slice);
        }
    }

    /// Notes that a publisher of the topic at this place had sent all samples below this number.
    pub(crate) fn catch_up(&mut self, place: usize, incarnation: u64, next_sequence: u64) {
        self.accounts[place].catch_up(incarnation, next_sequence);
    }

    /// Passes the rows to the operating system, and performs the periodic work of the files of all topics.
    pub(crate) fn tend(&mut self, now: Now) {
        if let Some(tables) = &mut self.tables {
            tables.tend(now);
        }
        if let Some(segments) = &mut self.segments {
            segments.tend(&mut self.accounts, now);
        }
        self.find_cause();
    }

    /// Finds the cause of the latest loss.
    fn find_cause(&mut self) {
        let losses = self.accounts.iter().map(Account::losses);
        let losses = losses.fold(Losses::default(), Losses::and);
        let failing = self.segments.as_ref().and_then(SegmentSink::failing);
        let failing = failing.or_else(|| self.tables.as_ref().and_then(Tables::failing));
        self.cause = match failing {
            Some(ErrorKind::StorageFull | ErrorKind::QuotaExceeded) => "the disk is full",
            Some(ErrorKind::NotFound) => "its folder is gone",
            Some(_) => "its files cannot be written",
            None if losses.ended > self.losses.ended => "a recorder ended or was killed before it had written",
            None if losses.behind > self.losses.behind => "the recorder is too slow",
            None => self.cause,
        };
        self.losses = losses;
    }

    /// Returns the cause of the latest loss in words; empty without a loss.
    pub(crate) fn cause(&self) -> &'static str {
        self.cause
    }

    /// Whether the files of all topics take what arrives.
    pub(crate) fn is_writing(&self) -> bool {
        self.segments.as_ref().is_some_and(SegmentSink::is_writing)
    }

    /// Returns the failures to write tables, and the rows that they lack.
    pub(crate) fn table_counts(&self) -> (u64, u64) {
        self.tables
            .as_ref()
            .map_or((0, 0), |tables| (tables.failures(), tables.lost()))
    }

    /// Ends the files of all topics.
    ///
    /// # Errors
    /// If the files, or anything before, could not be written.
    pub(crate) fn close(&mut self, now: Now) -> anyhow::Result<()> {
        if let Some(tables) = &mut self.tables {
            tables.tend(now);
        }
        if let Some(segments) = &mut self.segments {
            segments.finish(&mut self.accounts, now);
        }
        let (failures, rows) = self.table_counts();
        anyhow::ensure!(
            failures == 0,
            "tables could not be written {failures} times; they lack {rows} rows"
        );
        let (failures, lost) = (self.segment_counts().unwrap_or_default().failures, self.lost());
        anyhow::ensure!(
            failures == 0,
            "the recording of all topics could not be written {failures} times; it lacks {lost} samples"
        );
        Ok(())
    }

    /// Returns the account of the topic at this place.
    pub(crate) fn account(&self, place: usize) -> &Account {
        &self.accounts[place]
    }

    /// Returns the number of rows written of a data stream; `None` without tables.
    pub(crate) fn rows(&self, place: usize) -> Option<u64> {
        self.tables.as_ref().map(|tables| tables.rows(place))
    }

    /// Returns the counts of the files of all topics; `None` without such files.
    pub(crate) fn segment_counts(&self) -> Option<SegmentCounts> {
        self.segments.as_ref().map(SegmentSink::counts)
    }

    /// Returns the number of samples of all topics.
    pub(crate) fn samples(&self) -> u64 {
        self.accounts.iter().map(Account::samples).sum()
    }

    /// Returns the number of lost samples of all topics.
    pub(crate) fn lost(&self) -> u64 {
        self.accounts.iter().map(Account::lost).sum()
    }
}

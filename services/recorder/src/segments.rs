//! Sink of the recorded stream: successive files of all topics.
//!
//! Samples that cannot be written are counted as lost, and writing is retried in a new file. A full disk thus costs
//! samples, but neither files nor the deployment.

use std::fs::File;
use std::io::{BufWriter, ErrorKind};
use std::path::{Path, PathBuf};

use deployment::Segments as Settings;
use recording::{Channel, Compression, Facts, RecordingError, Writer};
use runtime::{Now, NumberedFiles};

use crate::account::Account;
use crate::bag::Bag;
use crate::recovery;
use crate::slice::StreamSlice;

/// Time between two attempts to write after a failure, nanoseconds.
const RETRY_NS: i64 = 1_000_000_000;
/// Time after which the first samples after a failure are written, nanoseconds: only then it is known that it is over.
const TRIAL_NS: i64 = 100_000_000;

/// Successive files of the recording.
#[derive(Debug)]
pub(crate) struct SegmentSink {
    files: NumberedFiles,
    settings: Settings,
    compression: Compression,
    facts: Facts,
    /// Samples of each topic not yet on disk.
    gathered: Vec<u64>,
    /// Number of the latest file.
    number: u32,
    open: Option<OpenSegment>,
    /// Time of the next attempt to write, monotonic, nanoseconds.
    retry_ns: i64,
    /// Kind of the failure since which nothing has been written.
    failing: Option<ErrorKind>,
    bag: Bag,
    counts: SegmentCounts,
}

/// File being written.
#[derive(Debug)]
struct OpenSegment {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
    channels: Vec<Channel>,
    begun_ns: i64,
    flushed_ns: i64,
    bytes: u64,
}

/// Counts since the recorder started.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SegmentCounts {
    pub(crate) failures: u64,
    pub(crate) deleted: u64,
}

impl SegmentSink {
    /// Continues the recording of `topics` topics in `files` after the file `number`. Each file begins with `facts`.
    pub(crate) fn new(
        (files, number, bag): (NumberedFiles, u32, Bag),
        (settings, compression): (Settings, Compression),
        facts: Facts,
        topics: usize,
    ) -> Self {
        Self {
            files,
            settings,
            compression,
            facts,
            gathered: vec![0; topics],
            number,
            open: None,
            retry_ns: i64::MIN,
            failing: None,
            bag,
            counts: SegmentCounts::default(),
        }
    }

    pub(crate) fn counts(&self) -> SegmentCounts {
        self.counts
    }

    /// Whether what arrives is written, as far as is known.
    pub(crate) fn is_writing(&self) -> bool {
        self.open.is_some() && self.failing.is_none()
    }

    /// Returns the kind of the failure since which nothing has been written.
    pub(crate) fn failing(&self) -> Option<ErrorKind> {
        self.failing
    }

    /// Adds a slice, already noted in its account.
    pub(crate) fn slice(&mut self, accounts: &mut [Account], slice: &StreamSlice<'_>) {
        let StreamSlice {
            place, header, octets, ..
        } = *slice;
        let now = slice.now;
        self.gathered[place] += (octets.len() / accounts[place].layout().size) as u64;
        let Some(open) = &mut self.open else {
            self.give_up_gathered(accounts);
            return;
        };
        let sent_ns = now.utc_ns - (now.mono_ns - header.sent_ns);
        let written = open
            .writer
            .slice(open.channels[place], header, octets, now.utc_ns, sent_ns);
        match written {
            Ok(false) => {}
            Ok(true) => self.flushed(now),
            Err(error) => self.failed(&error, accounts, now),
        }
    }

    /// Performs periodic work: writes gathered samples, begins another file, deletes old files.
    pub(crate) fn tend(&mut self, accounts: &mut [Account], now: Now) {
        self.open_if_due(accounts, now);
        let Some(open) = &mut self.open else { return };
        let has_samples = self.gathered.iter().any(|count| *count > 0);
        let flush_ns = match self.failing {
            Some(_) if has_samples => self.settings.flush_ns.min(TRIAL_NS),
            _ => self.settings.flush_ns,
        };
        if now.mono_ns - open.flushed_ns < flush_ns {
            return;
        }
        match open.writer.flush() {
            Ok(()) => self.flushed(now),
            Err(error) => self.failed(&error, accounts, now),
        }
        let is_over = |open: &OpenSegment| {
            open.bytes >= self.settings.bytes || now.mono_ns - open.begun_ns >= self.settings.length_ns
        };
        if self.open.as_ref().is_some_and(is_over) {
            self.finish(accounts, now);
        }
        self.make_room(accounts, now);
    }

    /// Ends the current file.
    pub(crate) fn finish(&mut self, accounts: &mut [Account], now: Now) {
        if let Some(mut open) = self.open.take() {
            // At the end, the chunk in progress belongs to the file as well.
            let flushed = open.writer.flush();
            let contents = open.writer.contents();
            match flushed.and_then(|()| open.writer.finish()) {
                Ok(()) => {
                    self.gathered.fill(0);
                    self.bag.note(&open.path, contents, now);
                    self.bag.write();
                }
                Err(error) => self.give_up(&open.path, &error, accounts, now),
            }
        }
    }

    fn flushed(&mut self, now: Now) {
        if self.gathered.iter().any(|count| *count > 0) {
            self.failing = None;
        }
        self.gathered.fill(0);
        if let Some(open) = &mut self.open {
            open.flushed_ns = now.mono_ns;
            open.bytes = std::fs::metadata(&open.path).map_or(0, |file| file.len());
            self.bag.note(&open.path, open.writer.contents(), now);
        }
    }

    fn failed(&mut self, error: &RecordingError, accounts: &mut [Account], now: Now) {
        if let Some(open) = self.open.take() {
            // Dropping the writer attempts to write the rest; a failed rest is cut off.
            drop(open.writer);
            self.give_up(&open.path, error, accounts, now);
        }
    }

    fn give_up(&mut self, path: &Path, error: &RecordingError, accounts: &mut [Account], now: Now) {
        if self.counts.failures == 0 {
            let lead = "koseki: the recording of all topics cannot be written";
            let path = path.display();
            runtime::notice(format_args!(
                "{lead} ({path}: {error}); samples are lost and counted until it can"
            ));
        }
        self.counts.failures += 1;
        self.failing = Some(match error {
            RecordingError::System(error) => error.kind(),
            _ => ErrorKind::Other,
        });
        self.retry_ns = now.mono_ns + RETRY_NS;
        self.give_up_gathered(accounts);
        // If this fails as well, the next recorder ends the file.
        let _ = recovery::end(path);
    }

    fn give_up_gathered(&mut self, accounts: &mut [Account]) {
        for (account, gathered) in accounts.iter_mut().zip(&mut self.gathered) {
            account.add_lost(std::mem::take(gathered));
        }
    }

    /// Begins the next file, if none is open. Called before a slice is noted in its account, because a file begins
    /// with the positions of the topics before it.
    pub(crate) fn open_if_due(&mut self, accounts: &mut [Account], now: Now) {
        if self.open.is_some() || now.mono_ns < self.retry_ns {
            return;
        }
        self.number += 1;
        let path = self.files.path(self.number);
        match self.begin(&path, accounts, now) {
            Ok(open) => {
                self.bag.note(&path, open.writer.contents(), now);
                self.open = Some(open);
            }
            Err(error) => {
                self.give_up(&path, &error, accounts, now);
                // The file is empty.
                let _ = std::fs::remove_file(&path);
                self.number -= 1;
            }
        }
    }

    fn begin(&self, path: &Path, accounts: &[Account], now: Now) -> Result<OpenSegment, RecordingError> {
        let mut facts = self.facts.clone();
        accounts.iter().for_each(|account| account.state(&mut facts));
        let file = BufWriter::new(File::create_new(path)?);
        let mut writer = Writer::compressed(file, &facts, self.compression)?;
        let channels = accounts.iter();
        let channels = channels.map(|account| writer.channel(account.name(), account.layout()));
        let channels = channels.collect::<Result<_, _>>()?;
        writer.flush()?;
        Ok(OpenSegment {
            path: path.to_owned(),
            writer,
            channels,
            begun_ns: now.mono_ns,
            flushed_ns: now.mono_ns,
            bytes: 0,
        })
    }

    /// Deletes the oldest files until the others fit the configured space; never deletes the current file.
    fn make_room(&mut self, accounts: &mut [Account], now: Now) {
        let Some(keep_bytes) = self.settings.keep_bytes else {
            return;
        };
        for path in self.files.beyond(keep_bytes).unwrap_or_default() {
            if let Err(error) = std::fs::remove_file(&path) {
                self.failed(&error.into(), accounts, now);
                return;
            }
            self.bag.forget(&path);
            self.counts.deleted += 1;
        }
    }
}

//! Captures of received data, byte for byte, so that the chain can be run again from the sensors' own bytes.
//!
//! A disk may be slow, and an adapter must not wait for the disk. A second thread therefore writes. Both threads
//! exchange batches through queues without locks: the adapter fills a batch while the others are under way, and
//! continues with this batch until an empty batch returns. Data beyond the size of a batch are left out and counted.
//!
//! A line of a connection becomes the payload of a datagram, so that the line has a time of receipt and a single reader
//! suffices. New files begin by size and by time; concatenated files are a capture again. Unwritten data are counted,
//! and writing is tried again in a new file. A killed adapter leaves a file with a torn last packet.

use std::fs::File;
use std::io::{self, Write as _};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::Context as _;
use crossbeam_queue::ArrayQueue;
use deployment::Segments;
use formats::containers::{DatagramRoute, begin_capture, capture};
use messages::Counter;
use runtime::Process;
use runtime::{HealthEntry, Now, NumberedFiles};

/// Number of batches, and bytes of each: a disk may pause for seconds.
const BATCHES: usize = 4;
const BATCH_OCTETS: usize = 4 << 20;
/// Datagrams and lines of a batch.
const BATCH_PIECES: usize = 1 << 14;
/// Period of the second thread.
const PAUSE: Duration = Duration::from_millis(10);
/// Time between two attempts to write after a failure, nanoseconds.
const RETRY_NS: i64 = 1_000_000_000;

/// Capture of a receiver.
#[derive(Debug)]
pub(crate) struct Capture {
    to: SocketAddr,
    filling: CaptureBatch,
    shared: Arc<CaptureData>,
    thread: Option<JoinHandle<()>>,
}

/// Received data, piece after piece.
#[derive(Debug)]
struct CaptureBatch {
    octets: Vec<u8>,
    /// Sender and length of each piece.
    pieces: Vec<(DatagramRoute, usize)>,
}

/// Data of both threads.
#[derive(Debug)]
struct CaptureData {
    full: ArrayQueue<CaptureBatch>,
    empty: ArrayQueue<CaptureBatch>,
    over: AtomicBool,
    written: AtomicU64,
    lost: AtomicU64,
    failures: AtomicU64,
    deleted: AtomicU64,
}

impl Capture {
    /// Creates the capture of data sent to `to`, if the deployment of `process` requests one.
    ///
    /// # Errors
    /// If the second thread cannot be started.
    pub(crate) fn open(process: &Process, to: SocketAddr) -> anyhow::Result<Option<Self>> {
        let Some(settings) = process.config.services.captures else {
            return Ok(None);
        };
        Self::begin(settings, &process.options.out, &process.name, to).map(Some)
    }

    fn begin(settings: Segments, folder: &Path, name: &str, to: SocketAddr) -> anyhow::Result<Self> {
        let shared = Arc::new(CaptureData {
            full: ArrayQueue::new(BATCHES),
            empty: ArrayQueue::new(BATCHES),
            over: AtomicBool::new(false),
            written: AtomicU64::new(0),
            lost: AtomicU64::new(0),
            failures: AtomicU64::new(0),
            deleted: AtomicU64::new(0),
        });
        for _ in 1..BATCHES {
            let _ = shared.empty.push(CaptureBatch::new());
        }
        let mut writing = Writing {
            folder: folder.to_owned(),
            files: NumberedFiles::new(folder, format!("received_{name}_"), ".pcapng"),
            settings,
            open: None,
            retry_ns: i64::MIN,
            octets: Vec::new(),
            shared: Arc::clone(&shared),
        };
        let thread = std::thread::Builder::new().name("capture".to_owned());
        let thread = thread.spawn(move || writing.run());
        Ok(Self {
            to,
            filling: CaptureBatch::new(),
            shared,
            thread: Some(thread.context("starting the thread that writes the capture")?),
        })
    }

    /// Takes data from `from`, received at `received_utc_ns`.
    pub(crate) fn take(&mut self, from: SocketAddr, received_utc_ns: i64, octets: &[u8]) {
        let batch = &mut self.filling;
        if batch.pieces.len() == BATCH_PIECES || batch.octets.len() + octets.len() > BATCH_OCTETS {
            self.shared.lost.fetch_add(1, Ordering::Relaxed);
            return;
        }
        batch.octets.extend_from_slice(octets);
        let way = DatagramRoute {
            from,
            to: self.to,
            received_utc_ns,
        };
        batch.pieces.push((way, octets.len()));
    }

    /// Hands over the present batch, if the second thread keeps up.
    pub(crate) fn hand_over(&mut self) {
        if self.filling.pieces.is_empty() {
            return;
        }
        if let Some(empty) = self.shared.empty.pop() {
            let full = std::mem::replace(&mut self.filling, empty);
            // The queue has a place for every batch.
            let _ = self.shared.full.push(full);
        }
    }

    /// Adds the counts.
    pub(crate) fn count(&self, whole: &mut HealthEntry) {
        let shared = &self.shared;
        for (counter, count) in [
            (Counter::RecordedSamples, &shared.written),
            (Counter::RecordedLost, &shared.lost),
            (Counter::RecordingFailures, &shared.failures),
            (Counter::RecordingsDeleted, &shared.deleted),
        ] {
            whole.set(counter, count.load(Ordering::Relaxed));
        }
    }
}

impl Drop for Capture {
    /// Writes the remaining data.
    fn drop(&mut self) {
        let last = std::mem::replace(
            &mut self.filling,
            CaptureBatch {
                octets: Vec::new(),
                pieces: Vec::new(),
            },
        );
        let _ = self.shared.full.push(last);
        self.shared.over.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // A panic of the thread has been reported already.
            let _ = thread.join();
        }
    }
}

impl CaptureBatch {
    fn new() -> Self {
        Self {
            octets: Vec::with_capacity(BATCH_OCTETS),
            pieces: Vec::with_capacity(BATCH_PIECES),
        }
    }

    fn pieces(&self) -> impl Iterator<Item = (&DatagramRoute, &[u8])> {
        let mut rest = self.octets.as_slice();
        self.pieces.iter().map(move |(way, length)| {
            let (octets, behind) = rest.split_at(*length);
            rest = behind;
            (way, octets)
        })
    }
}

/// Second thread.
#[derive(Debug)]
struct Writing {
    folder: PathBuf,
    files: NumberedFiles,
    settings: Segments,
    open: Option<OpenCapture>,
    /// Time of the next attempt to write, monotonic, nanoseconds.
    retry_ns: i64,
    /// Packets of a batch.
    octets: Vec<u8>,
    shared: Arc<CaptureData>,
}

/// Present file.
#[derive(Debug)]
struct OpenCapture {
    file: File,
    bytes: u64,
    begun_ns: i64,
}

impl Writing {
    fn run(&mut self) {
        loop {
            // Read first: batches handed over before the end are still written.
            let is_over = self.shared.over.load(Ordering::Acquire);
            while let Some(mut batch) = self.shared.full.pop() {
                self.write(&batch, Now::read().mono_ns);
                batch.octets.clear();
                batch.pieces.clear();
                let _ = self.shared.empty.push(batch);
            }
            if is_over {
                return;
            }
            std::thread::park_timeout(PAUSE);
        }
    }

    fn write(&mut self, batch: &CaptureBatch, now_ns: i64) {
        self.octets.clear();
        let mut pieces = 0;
        for (way, octets) in batch.pieces() {
            pieces += u64::from(capture(way, octets, &mut self.octets).is_ok());
        }
        let shared = Arc::clone(&self.shared);
        let mut lost = batch.pieces.len() as u64 - pieces;
        if pieces > 0 && now_ns < self.retry_ns {
            lost += pieces;
        } else if pieces > 0 {
            match self.append(now_ns) {
                Ok(()) => {
                    shared.written.fetch_add(pieces, Ordering::Relaxed);
                }
                Err(error) => {
                    lost += pieces;
                    self.failed(&error, now_ns);
                }
            }
        }
        shared.lost.fetch_add(lost, Ordering::Relaxed);
    }

    /// Writes the packets, after a file header if a new file is due.
    fn append(&mut self, now_ns: i64) -> io::Result<()> {
        let is_over =
            |open: &OpenCapture| open.bytes >= self.settings.bytes || now_ns - open.begun_ns >= self.settings.length_ns;
        if self.open.as_ref().is_none_or(is_over) {
            self.open = None;
            self.open = Some(self.next(now_ns)?);
        }
        let Some(open) = &mut self.open else { return Ok(()) };
        open.file.write_all(&self.octets)?;
        open.bytes += self.octets.len() as u64;
        Ok(())
    }

    fn next(&self, begun_ns: i64) -> io::Result<OpenCapture> {
        std::fs::create_dir_all(&self.folder)?;
        let latest = self.files.list()?.last().map_or(0, |(number, _)| *number);
        let path = self.files.path(latest + 1);
        let begin = begin_capture();
        let mut file = File::create_new(&path)?;
        file.write_all(&begin).inspect_err(|_| {
            // The file is empty.
            let _ = std::fs::remove_file(&path);
        })?;
        if let Some(keep_bytes) = self.settings.keep_bytes {
            for path in self.files.beyond(keep_bytes)? {
                std::fs::remove_file(path)?;
                self.shared.deleted.fetch_add(1, Ordering::Relaxed);
            }
        }
        Ok(OpenCapture {
            file,
            bytes: begin.len() as u64,
            begun_ns,
        })
    }

    fn failed(&mut self, error: &io::Error, now_ns: i64) {
        if let Some(open) = self.open.take() {
            // Otherwise the file ends in a torn packet, as after a crash.
            let _ = open.file.set_len(open.bytes);
        }
        if self.shared.failures.fetch_add(1, Ordering::Relaxed) == 0 {
            let (lead, folder) = (
                "koseki: the capture of received data cannot be written",
                self.folder.display(),
            );
            let rest = "data received meanwhile are missing in the capture, and counted";
            runtime::notice(format_args!("{lead} ({folder}: {error}); {rest}"));
        }
        self.retry_ns = now_ns + RETRY_NS;
    }
}

#[cfg(test)]
mod tests {
    use formats::containers::{TimeStamp, datagrams};

    use super::*;

    fn address(text: &str) -> SocketAddr {
        text.parse().unwrap()
    }

    fn settings(bytes: u64, keep_bytes: Option<u64>) -> Segments {
        Segments {
            flush_ns: 0,
            bytes,
            length_ns: i64::MAX,
            keep_bytes,
        }
    }

    /// Hands over the present batch, and waits until the batch is written or lost.
    fn pass(capture: &mut Capture) {
        let all = || BATCHES - 1 == capture.shared.empty.len();
        while !all() {
            std::thread::yield_now();
        }
        capture.hand_over();
        while BATCHES - 1 != capture.shared.empty.len() {
            std::thread::yield_now();
        }
    }

    fn counted(capture: &Capture) -> [u64; 4] {
        let mut entry = HealthEntry::default();
        capture.count(&mut entry);
        use Counter::{RecordedLost, RecordedSamples, RecordingFailures, RecordingsDeleted};
        [RecordedSamples, RecordedLost, RecordingFailures, RecordingsDeleted].map(|counter| entry.counters[counter])
    }

    #[test]
    fn files_put_together_hold_everything_in_order() {
        let folder = tempfile::tempdir().unwrap();
        let to = address("127.0.0.1:8600");
        let mut capture = Capture::begin(settings(200, None), folder.path(), "lan", to).unwrap();
        for number in 0..20u8 {
            capture.take(address("127.0.0.2:9"), i64::from(number), &[number; 30]);
            if number < 17 {
                pass(&mut capture);
            }
        }
        assert_eq!(counted(&capture), [17, 0, 0, 0]);
        drop(capture);
        let files = NumberedFiles::new(folder.path(), "received_lan_", ".pcapng")
            .list()
            .unwrap();
        assert!(files.len() > 3, "{files:?}");
        let whole: Vec<u8> = files
            .iter()
            .flat_map(|(_, path)| std::fs::read(path).unwrap())
            .collect();
        let read: Vec<_> = datagrams(&whole).map(Result::unwrap).collect();
        let expected = (0..20u8).map(|number| (vec![number; 30], Some(TimeStamp::Utc { ns: number.into() })));
        let read = read
            .into_iter()
            .map(|datagram| (datagram.bytes.into_owned(), datagram.time_stamp));
        assert!(read.eq(expected));
    }

    #[test]
    fn the_oldest_files_make_room_for_later_ones() {
        let folder = tempfile::tempdir().unwrap();
        let to = address("[::1]:8600");
        let mut capture = Capture::begin(settings(100, Some(500)), folder.path(), "lan", to).unwrap();
        for _ in 0..20 {
            capture.take(address("[::1]:9"), 1, &[7; 100]);
            pass(&mut capture);
        }
        let [written, lost, failures, deleted] = counted(&capture);
        assert_eq!((written, lost, failures), (20, 0, 0));
        let left = std::fs::read_dir(folder.path()).unwrap().count() as u64;
        assert!(
            (2..5).contains(&left) && deleted == 20 - left,
            "{left} left, {deleted} deleted"
        );
    }

    #[test]
    fn a_disk_that_takes_nothing_costs_what_comes_meanwhile_and_its_return_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let blocked = folder.path().join("out");
        std::fs::write(&blocked, "a file where the folder should be").unwrap();
        let mut capture = Capture::begin(settings(100, None), &blocked, "lan", address("127.0.0.1:1")).unwrap();
        capture.take(address("127.0.0.1:9"), 1, b"lost");
        pass(&mut capture);
        capture.take(address("127.0.0.1:9"), 2, b"lost before it is tried again");
        pass(&mut capture);
        assert_eq!(counted(&capture), [0, 2, 1, 0]);
        std::fs::remove_file(&blocked).unwrap();
        while counted(&capture)[0] == 0 {
            capture.take(address("127.0.0.1:9"), 3, b"written");
            pass(&mut capture);
        }
        let [written, lost, failures, _] = counted(&capture);
        drop(capture);
        assert_eq!((written, failures), (1, 1));
        let file = std::fs::read(blocked.join("received_lan_000001.pcapng")).unwrap();
        let read = datagrams(&file).map(|datagram| datagram.unwrap().bytes.into_owned());
        assert!(read.eq([b"written"]) && lost >= 2);
    }

    #[test]
    fn what_finds_no_room_is_counted() {
        let folder = tempfile::tempdir().unwrap();
        let mut capture =
            Capture::begin(settings(1 << 30, None), folder.path(), "lan", address("127.0.0.1:1")).unwrap();
        let long = vec![1; BATCH_OCTETS / 3];
        for _ in 0..4 {
            capture.take(address("127.0.0.1:9"), 1, &long);
        }
        assert_eq!(counted(&capture)[1], 1, "three have room");
    }
}

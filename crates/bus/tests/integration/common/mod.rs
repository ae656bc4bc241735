//! A private instance for each test, and bounded waiting.

pub(crate) mod heap;

use std::fs;
use std::path::Path;
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use bus::{Bus, BusError, Claim, Mark, Publisher, Root, Subscriber, TopicHold, Transport};
use messages::{SensorTrack, Topic};

/// Far longer than anything takes, so that only a real hang ends it.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// An instance in its own folder. When dropped, it makes sure that the test left nothing behind.
pub(crate) struct Home {
    root: Root,
    /// Where its memory was, when it was last claimed.
    prefix: Option<String>,
    claim: Option<Claim>,
    folder: tempfile::TempDir,
}

impl Home {
    /// An instance that this process runs.
    pub(crate) fn new() -> Self {
        let mut home = Self::unclaimed();
        home.claim();
        home
    }

    /// An instance that nobody runs.
    pub(crate) fn unclaimed() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let root = Root::in_base(folder.path(), "test").unwrap();
        Self {
            root,
            prefix: None,
            claim: None,
            folder,
        }
    }

    pub(crate) fn claim(&mut self) -> &Claim {
        let claim = self.claim.insert(self.root.claim().unwrap());
        self.prefix = self.root.prefix().unwrap();
        claim
    }

    /// Ends the instance.
    pub(crate) fn end(&mut self) {
        self.claim.take().unwrap().remove().unwrap();
    }

    pub(crate) fn root(&self) -> &Root {
        &self.root
    }

    pub(crate) fn bus<S: Transport>(&self, process: &str) -> Bus<S> {
        Bus::open(&self.root, process).unwrap()
    }
}

impl Drop for Home {
    fn drop(&mut self) {
        let removed = match self.claim.take() {
            Some(claim) => claim.remove().map(drop),
            None => Ok(()),
        };
        if thread::panicking() {
            return;
        }
        removed.unwrap();
        let left: Vec<_> = self.prefix.iter().flat_map(|prefix| memory_of(prefix)).collect();
        assert!(left.is_empty(), "left in shared memory: {left:?}");
        let left: Vec<_> = fs::read_dir(self.folder.path()).unwrap().collect();
        assert!(left.is_empty(), "left in the base folder: {left:?}");
    }
}

/// Names of the files of `root` in shared memory.
pub(crate) fn shared_memory(root: &Root) -> Vec<String> {
    root.prefix()
        .unwrap()
        .map(|prefix| memory_of(&prefix))
        .unwrap_or_default()
}

/// Names of the files in shared memory that begin with `prefix`.
pub(crate) fn memory_of(prefix: &str) -> Vec<String> {
    fs::read_dir(Path::new("/dev/shm"))
        .unwrap()
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.starts_with(prefix))
        .collect()
}

/// A topic that exists, with a bus to make its ports.
pub(crate) struct Line<S: Transport> {
    pub(crate) topic: Topic<SensorTrack>,
    pub(crate) bus: Bus<S>,
    _held: TopicHold,
}

impl<S: Transport> Line<S> {
    /// A topic with queues of `depth` slices of up to `slice_len` samples.
    pub(crate) fn new(home: &Home, name: &str, depth: usize, slice_len: usize) -> Self {
        let topic = topic(name, depth, slice_len);
        let bus = home.bus("test");
        let held = bus.hold(&topic).unwrap();
        Self {
            topic,
            bus,
            _held: held,
        }
    }

    pub(crate) fn publisher(&self, incarnation: u64) -> Publisher<S, SensorTrack> {
        self.try_publisher(incarnation).unwrap()
    }

    /// A publisher, if the topic has a place for it.
    pub(crate) fn try_publisher(&self, epoch: u64) -> Result<Publisher<S, SensorTrack>, BusError> {
        self.bus.publisher(&self.topic, epoch)
    }

    /// A subscriber that joined at time `now`.
    pub(crate) fn subscriber(&self, now: u64) -> Subscriber<S, SensorTrack> {
        self.bus.subscriber(&self.topic, || now).unwrap()
    }
}

pub(crate) fn topic(name: &str, depth: usize, slice_len: usize) -> Topic<SensorTrack> {
    let mut topic = messages::sensor_tracks(name);
    topic.capacity.depth = depth;
    topic.capacity.slice_len = slice_len;
    topic
}

pub(crate) fn track(sequence: u64) -> SensorTrack {
    SensorTrack {
        sequence,
        ..SensorTrack::default()
    }
}

pub(crate) fn mark(progress_ns: i64) -> Mark {
    Mark {
        progress_ns,
        sent_ns: 0,
        end: false,
    }
}

/// Sends `count` samples that hold their own sequence numbers.
pub(crate) fn send<S: Transport>(publisher: &mut Publisher<S, SensorTrack>, count: usize) {
    publisher.send(mark(0), count, |_, sequence| track(sequence)).unwrap();
}

/// Takes everything: the sequence numbers.
pub(crate) fn take_all<S: Transport>(subscriber: &mut Subscriber<S, SensorTrack>) -> Vec<u64> {
    let mut sequences = Vec::new();
    while subscriber
        .take(64, |_, samples| {
            sequences.extend(samples.iter().map(|s| s.sequence));
        })
        .unwrap()
        == 64
    {}
    sequences
}

/// Asks until the answer is yes.
pub(crate) fn until(what: &str, mut condition: impl FnMut() -> bool) {
    let start = Instant::now();
    while !condition() {
        assert!(start.elapsed() < PATIENCE, "never happened: {what}");
        thread::sleep(Duration::from_millis(1));
    }
}

/// Does `work` on another thread, and fails if it hangs.
pub(crate) fn without_hanging<R: Send + 'static>(what: &str, work: impl FnOnce() -> R + Send + 'static) -> R {
    let (sender, receiver) = mpsc::channel();
    let thread = thread::spawn(move || {
        let _ = sender.send(work());
    });
    match receiver.recv_timeout(PATIENCE) {
        Ok(result) => result,
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("hangs: {what}"),
        Err(mpsc::RecvTimeoutError::Disconnected) => std::panic::resume_unwind(thread.join().unwrap_err()),
    }
}

/// Runs each promise of a module over both transports.
macro_rules! suite {
    ($($promise:ident)*) => {
        mod shared_memory {
            $( #[test] fn $promise() { super::$promise::<bus::SharedMemory>(); } )*
        }
        mod in_process {
            $( #[test] fn $promise() { super::$promise::<bus::InProcess>(); } )*
        }
    };
}

pub(crate) use suite;

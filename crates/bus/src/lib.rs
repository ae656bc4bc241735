//! Topics in shared memory: the only crate that uses iceoryx2 (PL-2, PL-5, PL-8, PL-11).
//!
//! Processes of a deployment exchange slices of fixed-layout samples (see the `messages` crate) without copies: a
//! publisher writes samples where subscribers read them. This crate has eight parts, built on iceoryx2:
//!
//! | type | purpose |
//! |---|---|
//! | [`Root`], [`Claim`] | folder of a deployment, right to run the deployment, and removal of all its files |
//! | [`Bus`], [`TopicHold`] | connection of a process; the keeper holds every topic, other processes only open topics |
//! | [`Publisher`] | writes slices in place, with sequence numbers and progress; never waits for anybody |
//! | [`BatchWriter`] | collects samples in the slice that a publisher sends next |
//! | [`Subscriber`] | takes slices, and counts missing samples per publisher |
//! | [`LogWriter`], [`LogReader`] | a log, written with a few stores per sample, for readers at any speed |
//! | [`OrderPort`] | gives orders to fusion and receives their states |
//! | [`Waiter`] | waits for work on several topics: spinning, blocked, or first one, then the other |
//!
//! All parts are generic over a [`Transport`]. [`SharedMemory`] connects processes; [`InProcess`] connects threads,
//! and creates no files. The same conformance suite tests both.
//!
//! Four rules hold throughout:
//! - **A publisher never waits.** A stopped, dead or slow subscriber loses the oldest slices, and counts the loss.
//! - **Loss is counted, not guessed**, from the sequence number in the header of every slice.
//! - **The steady state allocates nothing** once every port is connected to all peers: `take` and `wait` nothing at
//!   all, `send` nothing directly (iceoryx2 0.10 allocates a block of some fifty bytes per slice, and frees the block
//!   at once).
//! - **Removal is explicit.** Dead processes are removed when the keeper calls [`Bus::remove_dead`] or a topic has no
//!   free place; the remains of a dead deployment, when [`Root::claim`] succeeds, or when the last joined process
//!   leaves.
//!
//! ```
//! use bus::{Bus, InProcess, Mark, Root, WaitMode, Woken};
//!
//! # fn main() -> Result<(), bus::BusError> {
//! let root = Root::new("example")?;
//! let topic = messages::progress();
//!
//! // The keeper's part. Over `SharedMemory`, the launcher would first call `root.claim()`.
//! let keeper = Bus::<InProcess>::open(&root, "keeper")?;
//! let held = keeper.hold(&topic)?;
//!
//! // A reader's part: its ports, and something to wait with. The 5 stands for a monotonic clock.
//! let reader = Bus::<InProcess>::open(&root, "reader")?;
//! let mut subscriber = reader.subscriber(&topic, || 5)?;
//! let mut waiter = reader.waiter(WaitMode::Event);
//! waiter.watch(&reader, &topic)?;
//!
//! // A sender's part; it started at 10.
//! let mut publisher = keeper.publisher(&topic, 10)?;
//! let mark = Mark { progress_ns: i64::MIN, sent_ns: 11, end: false };
//! publisher.send(mark, 1, |_, _| messages::Progress { done_sequence: 7, ..Default::default() })?;
//!
//! let woken = waiter.wait(std::time::Duration::from_secs(1), || subscriber.has_slices())?;
//! assert_eq!(woken, Woken::Work);
//! subscriber.take(16, |_, progress| assert_eq!(progress[0].done_sequence, 7))?;
//! assert_eq!(subscriber.counts().lost, 0);
//! # drop(held);
//! # Ok(())
//! # }
//! ```
//!
//! Architecture invariant: no other crate names iceoryx2, no stamp on any sample is read from a clock here, and no
//! function here prints.

mod atomic;
mod bare;
pub mod base;
mod batch_writer;
mod bus;
mod error;
mod hint;
mod last_words;
mod line;
mod loaned;
mod log;
mod mapping;
mod membership;
mod order_port;
mod outlasting;
mod ports;
mod process;
mod publisher;
mod quality;
mod remains;
mod ring;
mod root;
mod seal;
mod sends;
mod service;
mod space;
mod subscriber;
mod transport;
mod unborn;
mod waiter;
mod wake_up;

pub use bare::{BareReceiver, BareSender, BareSettings};
pub use batch_writer::BatchWriter;
pub use bus::Bus;
pub use error::{BusError, PortRole};
pub use line::{LineReader, PublisherLine, PublisherState};
pub use log::{LogReader, LogWriter};
pub use order_port::OrderPort;
pub use outlasting::Outlasting;
pub use ports::Transport;
pub use process::MemberProcess;
pub use publisher::{Mark, Publisher, PublisherCounts};
pub use quality::BORROWED_MAX;
pub use root::{Claim, INSTANCE_NAME_MAX, InstanceEntry, Root, Wiped};
pub use service::{DeadProcesses, TopicHold};
pub use space::{check_space, free_space, needed_bytes, needed_log_bytes};
pub use subscriber::{PublisherRecord, ReceiveOutcome, Slice, Subscriber, SubscriberCounts};
#[cfg(feature = "any-thread")]
pub use transport::SharedMemoryAnyThread;
pub use transport::{InProcess, Payload, SharedMemory};
pub use unborn::Unborn;
pub use waiter::{BACKSTOP, Look, WATCHED_MAX, WaitMode, Waiter, Woken};

//! Topics in shared memory: the only crate that knows iceoryx2 (PL-2, PL-5, PL-8, PL-11).
//!
//! Processes of one deployment exchange slices of fixed-layout samples (see the `messages` crate) without copying
//! them: a publisher writes them where its subscribers read them. This crate turns iceoryx2's building blocks into
//! the seven things that the rest of Koseki needs:
//!
//! | type | what it is |
//! |---|---|
//! | [`Root`], [`Claim`] | where one deployment lives, who runs it, and how nothing of it stays behind |
//! | [`Bus`], [`Held`] | one process's connection; the keeper holds every topic, the others only open them |
//! | [`Publisher`] | writes slices in place, with sequence numbers and progress; never waits for anybody |
//! | [`Subscriber`] | takes slices and counts, per publisher, what it missed |
//! | [`LogWriter`], [`LogReader`] | write down, at the cost of a few stores, what readers follow at their own pace |
//! | [`OrderPort`] | gives orders to fusion and receives their states |
//! | [`Waiter`] | waits for work on several topics: spinning, blocked, or first one, then the other |
//!
//! All of them are generic over a [`Transport`]. [`SharedMemory`] connects processes; [`InProcess`] is its twin that
//! connects threads and leaves no trace outside of the process. One conformance suite runs over both.
//!
//! Four rules hold throughout:
//! - **A publisher never waits.** A subscriber that stops, dies or is slow loses its oldest slices, and counts them.
//! - **Loss is counted, not guessed**, from the sequence number in the header of every slice.
//! - **The steady state allocates nothing** once every port has met its peers: `take` and `wait` nothing at all, `send`
//!   nothing of its own (iceoryx2 0.10 takes one block of some fifty bytes per slice, and gives it back at once).
//! - **Nobody cleans up behind another's back.** Dead processes are removed when [`Bus::remove_dead`] is called (by
//!   the keeper) or a topic has no place left; the remains of a dead deployment, when [`Root::claim`] succeeds, or when
//!   the last process that had joined it leaves.
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

mod bare;
pub mod base;
mod bus;
mod error;
mod line;
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
mod root;
mod seal;
mod service;
mod space;
mod subscriber;
mod transport;
mod unborn;
mod waiter;

pub use bare::{BareReceiver, BareSender, BareSettings};
pub use bus::Bus;
pub use error::{BusError, Role};
pub use line::{Life, PublisherLine};
pub use log::{LogReader, LogWriter};
pub use order_port::OrderPort;
pub use outlasting::Outlasting;
pub use ports::Transport;
pub use process::Process;
pub use publisher::{Mark, Publisher, PublisherCounts};
pub use quality::BORROWED_MAX;
pub use root::{Claim, INSTANCE_NAME_MAX, Instance, Root, Wiped};
pub use service::{DeadProcesses, Held};
pub use space::{check_space, free_space, needed_bytes, needed_log_bytes};
pub use subscriber::{Heard, Received, Slice, Subscriber, SubscriberCounts};
#[cfg(feature = "any-thread")]
pub use transport::SharedMemoryAnyThread;
pub use transport::{InProcess, Payload, SharedMemory};
pub use unborn::Unborn;
pub use waiter::{BACKSTOP, WATCHED_MAX, WaitMode, Waiter, Woken};

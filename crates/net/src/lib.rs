//! Live feeds over the network, Linux first.
//!
//! Radars and multilateration systems send their reports as datagrams, mostly to a *multicast group*: one packet on the
//! wire reaches every recorder, tracker and display that asked for it, and the sender knows none of them. Receivers of
//! transponder signals serve lines of text over TCP instead, to whoever connects. This crate moves such octets, and
//! knows nothing of what they mean:
//!
//! - [`UdpReceiver`]: datagrams to an address of this machine or to a group, each with the kernel's time stamp, and a
//!   count of those that the kernel had to drop;
//! - [`UdpSender`]: datagrams to an address or a group;
//! - [`TcpLines`]: lines of a server, connected to again whenever the connection is lost;
//! - [`LineServer`]: octets for whoever connects.
//!
//! What comes from a network is never believed to be small, whole, friendly or punctual. Every call does a bounded
//! amount of work and waits no longer than it was told, every buffer is allocated when the socket is opened, and
//! whatever is not handed on is counted by reason. No call reads a clock: times of receipt are the kernel's, and where
//! a duration matters the caller says what time it is.

// Without `forbid`: the system call that takes many datagrams at once has no safe form (module `batch`).
#![deny(unsafe_code)]

#[cfg(not(all(target_os = "linux", target_pointer_width = "64")))]
compile_error!("the crate `net` reads control messages as the kernel of 64-bit Linux lays them out");

mod batch;
mod error;
mod interface;
mod line_server;
mod lines;
mod receiver;
mod sender;
mod senders;
mod splitter;
mod wait;

pub use batch::BATCH_MAX;
pub use error::NetError;
pub use interface::Interface;
pub use line_server::{LineServer, LineServerCounters, READERS_MAX};
pub use lines::{LinesCounters, LinesSettings, TcpLines};
pub use receiver::{Datagram, ReceiverCounters, ReceiverSettings, UdpReceiver};
pub use sender::{SenderCounters, SenderSettings, UdpSender};
pub use senders::AllowedSenders;

//! Live feeds over the network, Linux first.
//!
//! Radars and multilateration systems send reports as datagrams, mostly to a *multicast group*: a single packet on the
//! wire reaches every recorder, tracker and display in the group, and the sender needs no list of readers. Receivers of
//! transponder signals serve lines of text over TCP instead, to every client. This crate transports such bytes without
//! interpreting the content:
//!
//! - [`UdpReceiver`]: datagrams to an address of this machine or to a group, each with the kernel's time stamp, and a
//!   count of the datagrams that the kernel had to drop;
//! - [`UdpSender`]: datagrams to an address or a group;
//! - [`TcpLines`]: lines of a server, connected to again whenever the connection is lost;
//! - [`Document`]: a document that is fetched again and again over HTTP;
//! - [`LineServer`]: bytes to all connected clients;
//! - [`Door`]: the permitted connections to a listening socket, and the permitted duration;
//! - [`Reach`]: whether other machines may reach a listening socket.
//!
//! Network input may be large, incomplete, hostile or late. Every call does a bounded amount of work and waits at
//! most for the given time, every buffer is allocated when the socket is opened, and all discarded input is counted
//! by reason. No call reads a clock: the kernel supplies the times of receipt, and the caller passes the present time
//! to calls with durations.

// Without `forbid`: the system call that takes many datagrams at once has no safe form (module `batch`).
#![deny(unsafe_code)]

#[cfg(not(all(target_os = "linux", target_pointer_width = "64")))]
compile_error!("the crate `net` reads control messages as the kernel of 64-bit Linux lays them out");

mod batch;
mod document;
mod door;
mod error;
mod interface;
mod line_server;
mod lines;
mod reach;
mod receiver;
mod sender;
mod senders;
mod splitter;
mod wait;

pub use batch::BATCH_MAX;
pub use document::{Document, DocumentCounters};
pub use door::{Admitted, Door, DoorCounters, DoorLimits, DoorNews, DoorRefusal, Ended, Peer, Ticket};
pub use error::NetError;
pub use interface::Interface;
pub use line_server::LineServer;
pub use lines::{LinesCounters, LinesSettings, TcpLines};
pub use reach::Reach;
pub use receiver::{Datagram, ReceiverCounters, ReceiverSettings, UdpReceiver};
pub use sender::{SenderCounters, SenderSettings, UdpSender};
pub use senders::AllowedSenders;

//! Permitted connections to a listening socket, and the permitted duration.
//!
//! A connection costs the server memory, a descriptor and mostly a thread, and costs a stranger nothing. A mere limit
//! is therefore a switch: a peer that opens that many connections closes the door for all others. A door has four rules
//! instead, the same for each listening socket:
//!
//! 1. At most [`DoorLimits::connections_max`] connections in all, and [`DoorLimits::address_max`] of the same address.
//!    An IPv6 network of 64 bits counts as a single address: a host has all of the network.
//! 2. A connection that has sent no whole message gives way to a new connection as soon as places are short, the oldest
//!    first; such a connection ends after [`DoorLimits::first`] in any case. Silent connections thus keep nobody out.
//! 3. A connection that has sent something gives way after a silence of [`DoorLimits::yields`], and ends after
//!    [`DoorLimits::idle`].
//! 4. Only if nobody gives way, the new connection is refused.
//!
//! Readers send nothing. For readers, rules 2 and 3 do not apply ([`DoorLimits::OF_READERS`]): a server of readers
//! disconnects readers that do not take the data sent.
//!
//! Each refusal is counted by reason, and the last refusal is kept with the address of the peer. A door is bookkeeping:
//! a door has no socket and reads no clock.

use std::fmt;
use std::net::{IpAddr, Ipv6Addr, SocketAddr};
use std::time::Duration;

/// Limits of a door.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DoorLimits {
    /// Most connections at a time.
    pub connections_max: usize,
    /// Most connections of an address at a time.
    pub address_max: usize,
    /// Longest time until a connection has sent a whole message; `None`: the peer need not send.
    pub first: Option<Duration>,
    /// Silence after which a connection gives way to a new connection.
    pub yields: Duration,
    /// Longest silence of a connection that has sent something.
    pub idle: Duration,
}

impl DoorLimits {
    /// Limits of a door for peers that send.
    pub const OF_SENDERS: Self = Self {
        connections_max: 64,
        address_max: 32,
        first: Some(Duration::from_secs(10)),
        yields: Duration::from_secs(60),
        idle: Duration::from_secs(600),
    };

    /// Limits of a door for peers that only read.
    pub const OF_READERS: Self = Self {
        first: None,
        ..Self::OF_SENDERS
    };
}

/// Why a connection was refused or ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum DoorRefusal {
    /// The address is not listed.
    Sender,
    /// There are too many connections in all.
    Full,
    /// There are too many connections of the address.
    Address,
    /// No whole message was sent in time.
    Silent,
    /// No whole message had been sent when a new connection needed the place.
    GaveWay,
    /// Nothing had been sent for long.
    Idle,
    /// The peer did not take the data sent.
    Slow,
}

impl DoorRefusal {
    /// All reasons, in the order of the counts.
    pub const ALL: [Self; 7] = [
        Self::Sender,
        Self::Full,
        Self::Address,
        Self::Silent,
        Self::GaveWay,
        Self::Idle,
        Self::Slow,
    ];

    /// A word for reports.
    pub fn word(self) -> &'static str {
        match self {
            Self::Sender => "not-listed",
            Self::Full => "too-many",
            Self::Address => "too-many-of-address",
            Self::Silent => "silent",
            Self::GaveWay => "gave-way",
            Self::Idle => "idle",
            Self::Slow => "slow",
        }
    }
}

/// Peer of a connection: an address, or a process of this machine at a Unix socket.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Peer(pub Option<SocketAddr>);

impl Peer {
    /// The part that counts as a single address.
    fn origin(self) -> Option<IpAddr> {
        self.0.map(|address| match address.ip().to_canonical() {
            IpAddr::V6(address) => {
                let network = u128::from(address) & (u128::MAX << 64);
                Ipv6Addr::from(if address.is_loopback() {
                    u128::from(address)
                } else {
                    network
                })
                .into()
            }
            address => address,
        })
    }
}

impl fmt::Display for Peer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(address) => write!(f, "{address}"),
            None => f.write_str("a process of this machine"),
        }
    }
}

/// Counts of a door since the opening.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DoorCounters {
    /// Connections that were admitted.
    pub admitted: u64,
    refused: [u64; DoorRefusal::ALL.len()],
    /// The last refusal.
    pub last: Option<(Peer, DoorRefusal)>,
}

impl DoorCounters {
    /// Refusals for a reason.
    pub fn refused(&self, reason: DoorRefusal) -> u64 {
        self.refused[reason as usize]
    }

    /// Refusals, whatever the reason.
    pub fn all_refused(&self) -> u64 {
        self.refused.iter().sum()
    }

    /// The reasons that have occurred, with the counts.
    pub fn reasons(&self) -> impl Iterator<Item = (DoorRefusal, u64)> {
        let all = DoorRefusal::ALL.into_iter().zip(self.refused);
        all.filter(|(_, count)| *count > 0)
    }

    fn add(&mut self, peer: Peer, reason: DoorRefusal) {
        self.refused[reason as usize] += 1;
        self.last = Some((peer, reason));
    }
}

impl fmt::Display for DoorCounters {
    /// As in `silent 3, too-many 1; the last one: too-many, 192.0.2.7:40112`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, (reason, count)) in self.reasons().enumerate() {
            let separator = if place == 0 { "" } else { ", " };
            write!(f, "{separator}{} {count}", reason.word())?;
        }
        match self.last {
            Some((peer, reason)) => write!(f, "; the last one: {}, {peer}", reason.word()),
            None => f.write_str("none"),
        }
    }
}

/// Shortest time between two reports of refusals, nanoseconds.
const NEWS_PERIOD_NS: i64 = 10_000_000_000;

/// Refusals to be reported: the first at once, further refusals together.
#[derive(Clone, Copy, Debug, Default)]
pub struct DoorNews {
    reported: u64,
    due_ns: i64,
}

impl DoorNews {
    /// Whether `counters` contain refusals that are to be reported at the monotonic time `now_ns`, and have not been.
    pub fn is_due(&mut self, counters: &DoorCounters, now_ns: i64) -> bool {
        let refused = counters.all_refused();
        let is_due = refused > self.reported && now_ns >= self.due_ns;
        if is_due {
            *self = Self {
                reported: refused,
                due_ns: now_ns + NEWS_PERIOD_NS,
            };
        }
        is_due
    }
}

/// Number of a connection at a door.
pub type Ticket = u64;

#[derive(Debug)]
struct Visitor<C> {
    ticket: Ticket,
    peer: Peer,
    /// Monotonic time of the last thing whole that came, or of the admission.
    heard_ns: i64,
    has_sent: bool,
    connection: C,
}

/// The connections at a listening socket; `C` is the means to end a connection.
#[derive(Debug)]
pub struct Door<C> {
    limits: DoorLimits,
    visitors: Vec<Visitor<C>>,
    next: Ticket,
    counters: DoorCounters,
}

/// A connection that was admitted.
#[derive(Debug)]
pub struct Admitted<C> {
    /// Number of the connection.
    pub ticket: Ticket,
    /// The connection that gave way, to be ended, and the reason.
    pub instead_of: Option<(DoorRefusal, C)>,
}

fn after(silence_ns: i64, limit: Duration) -> bool {
    u128::try_from(silence_ns).is_ok_and(|silence| silence >= limit.as_nanos())
}

impl<C> Door<C> {
    /// An open door.
    pub fn new(limits: DoorLimits) -> Self {
        Self {
            limits,
            visitors: Vec::with_capacity(limits.connections_max),
            next: 0,
            counters: DoorCounters::default(),
        }
    }

    /// Limits of this door.
    pub fn limits(&self) -> DoorLimits {
        self.limits
    }

    /// Admits a connection at the monotonic time `now_ns`.
    ///
    /// # Errors
    /// The reason, which is counted, and the connection, if there is no place.
    pub fn admit(&mut self, peer: Peer, now_ns: i64, connection: C) -> Result<Admitted<C>, (DoorRefusal, C)> {
        let of_address = |visitor: &&Visitor<C>| visitor.peer.origin() == peer.origin();
        let instead_of = if self.visitors.iter().filter(of_address).count() >= self.limits.address_max {
            self.make_way(now_ns, |visitor| of_address(&visitor))
                .ok_or(DoorRefusal::Address)
        } else if self.visitors.len() >= self.limits.connections_max {
            self.make_way(now_ns, |_| true).ok_or(DoorRefusal::Full)
        } else {
            return Ok(self.enter(peer, now_ns, connection, None));
        };
        match instead_of {
            Ok(other) => Ok(self.enter(peer, now_ns, connection, Some(other))),
            Err(reason) => {
                self.counters.add(peer, reason);
                Err((reason, connection))
            }
        }
    }

    fn enter(&mut self, peer: Peer, now_ns: i64, connection: C, instead_of: Option<(DoorRefusal, C)>) -> Admitted<C> {
        let ticket = self.next;
        self.next += 1;
        self.counters.admitted += 1;
        self.visitors.push(Visitor {
            ticket,
            peer,
            heard_ns: now_ns,
            has_sent: false,
            connection,
        });
        Admitted { ticket, instead_of }
    }

    /// Takes out the connection that gives way first: a connection that has sent nothing, else a silent connection.
    fn make_way(&mut self, now_ns: i64, may: impl Fn(&Visitor<C>) -> bool) -> Option<(DoorRefusal, C)> {
        self.limits.first?;
        let yields = self.limits.yields;
        let gives_way =
            |visitor: &Visitor<C>| may(visitor) && (!visitor.has_sent || after(now_ns - visitor.heard_ns, yields));
        let candidates = self.visitors.iter().enumerate();
        let (place, _) = candidates
            .filter(|(_, visitor)| gives_way(visitor))
            .min_by_key(|(_, visitor)| (visitor.has_sent, visitor.heard_ns, visitor.ticket))?;
        let visitor = self.visitors.remove(place);
        let reason = if visitor.has_sent {
            DoorRefusal::Idle
        } else {
            DoorRefusal::GaveWay
        };
        self.counters.add(visitor.peer, reason);
        Some((reason, visitor.connection))
    }

    /// A connection has sent something whole.
    pub fn heard(&mut self, ticket: Ticket, now_ns: i64) {
        if let Some(visitor) = self.visitors.iter_mut().find(|visitor| visitor.ticket == ticket) {
            visitor.has_sent = true;
            visitor.heard_ns = now_ns;
        }
    }

    /// A connection has ended by itself.
    pub fn leave(&mut self, ticket: Ticket) {
        self.visitors.retain(|visitor| visitor.ticket != ticket);
    }

    /// Takes out the connections that have been silent for too long, each with the reason: these connections are to be
    /// ended.
    pub fn expired(&mut self, now_ns: i64) -> Vec<(DoorRefusal, C)> {
        let Some(first) = self.limits.first else {
            return Vec::new();
        };
        let idle = self.limits.idle;
        let is_over = |visitor: &mut Visitor<C>| {
            let limit = if visitor.has_sent { idle } else { first };
            after(now_ns - visitor.heard_ns, limit)
        };
        let over: Vec<Visitor<C>> = self.visitors.extract_if(.., is_over).collect();
        let ended = over.into_iter().map(|visitor| {
            let reason = if visitor.has_sent {
                DoorRefusal::Idle
            } else {
                DoorRefusal::Silent
            };
            self.counters.add(visitor.peer, reason);
            (reason, visitor.connection)
        });
        ended.collect()
    }

    /// Counts a connection that is turned away before the admission.
    pub fn refuse(&mut self, peer: Peer, reason: DoorRefusal) {
        self.counters.add(peer, reason);
    }

    /// Ends the connections for which `take` returns a reason, or `Err` if already ended.
    pub fn retain(&mut self, mut take: impl FnMut(&mut C) -> Result<Option<DoorRefusal>, Ended>) {
        let counters = &mut self.counters;
        self.visitors.retain_mut(|visitor| match take(&mut visitor.connection) {
            Ok(None) => true,
            Ok(Some(reason)) => {
                counters.add(visitor.peer, reason);
                false
            }
            Err(Ended) => false,
        });
    }

    /// Number of connections.
    pub fn len(&self) -> usize {
        self.visitors.len()
    }

    /// Whether there is no connection.
    pub fn is_empty(&self) -> bool {
        self.visitors.is_empty()
    }

    /// Counts so far.
    pub fn counters(&self) -> DoorCounters {
        self.counters
    }
}

/// A connection has ended by itself.
#[derive(Clone, Copy, Debug)]
pub struct Ended;

#[cfg(test)]
#[path = "door_tests.rs"]
mod tests;

//! Serves pages and pictures to browsers and scripts on a thread of its own. Clients read; only those that a
//! [`WriteAccess`] names write, to one path.
//!
//! HTTP and WebSockets are axum's, on a runtime of one thread. All services pass the same [`Guard`] and have the
//! same limits, so that access is decided in a single place:
//!
//! **Protection against foreign pages.** A page in a browser may not read answers of other servers; but its own name
//! can be redirected here (DNS rebinding), and then it may. The browser still sends the requested name. So a request
//! is answered only if its `Host` is the address of the connection, a local name of this machine, or a configured
//! name. A WebSocket, which browsers open across sites, must come from a page of the same host, or of a site that
//! [`ForeignPages`] names for its path. A client shows a
//! required token once, and then has it in a cookie that no script and no other site can use.
//!
//! **Protection against blocking.** Each connection carries one request. It has [`PATIENCE`] from its acceptance to
//! the last byte of the answer, however the client spends it, and a request has a maximum length. There are at most
//! [`CONNECTIONS_MAX`] connections, behind a [`net::Door`]: a further connection replaces the oldest that has sent no
//! request, else the oldest, so that silent clients cannot lock out active clients. These limits bound the memory that
//! clients can use. A WebSocket leaves this count; the service that opens WebSockets limits their number. The same
//! holds for a [`LongAnswer`]: its client must take a part of the answer in each [`PATIENCE`].
//!
//! Refused requests are counted by reason ([`RequestCounts`]).

#![forbid(unsafe_code)]

mod guard;
mod host_name;
mod server;

pub use axum;
pub use tokio;

pub use guard::{ForeignPages, Guard, RequestCounts, RequestRefusal, WriteAccess};
pub use host_name::HostName;
pub use server::{CONNECTIONS_MAX, LongAnswer, PATIENCE, Server, listen};

//! Serves pages and pictures to browsers and scripts, read only, on a thread of its own.
//!
//! HTTP and WebSockets are axum's, on a runtime of one thread. Everything that is served passes the same [`Guard`], and
//! lives within the same limits, so that there is one place that says whom an answer is for:
//!
//! **Nobody is tricked.** A page in a browser may not read answers of other servers; but its own name can be made to
//! lead here (DNS rebinding), and then it may. The browser still says the name that it asked for. So a request is
//! answered only if its `Host` is the address that the client connected to, a name of this machine for itself, or one
//! that is configured. A WebSocket, which browsers open across sites, must come from a page of the same host. Whoever
//! has to know a token shows it once, and has it in a cookie from then on that no script and no other site can use.
//!
//! **Nobody holds up anybody.** Each connection brings one request. It has [`PATIENCE`] from being accepted to the last
//! octet of the answer, however it spends it, and a request a greatest length. There are at most [`CONNECTIONS_MAX`] of
//! them: one more takes the place of the oldest, so that a client that says nothing cannot keep one out that does. What
//! clients can take of memory is limited by that. A WebSocket leaves this count; who opens one limits how many.
//!
//! Whatever is refused is counted, by reason ([`Counts`]).

#![forbid(unsafe_code)]

mod guard;
mod server;

pub use axum;
pub use tokio;

pub use guard::{Counts, Guard, Refusal};
pub use server::{CONNECTIONS_MAX, PATIENCE, Server, listen};

//! Sockets on the loopback interface.

mod allocation;
mod lines;
mod udp;

//! Sockets on the loopback interface.

mod allocation;
mod line_server;
mod lines;
mod udp;

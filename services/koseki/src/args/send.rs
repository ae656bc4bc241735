//! `koseki send`.

use std::net::SocketAddr;
use std::path::PathBuf;

use asterix::choice::ChosenEdition;
use clap::{Args, ValueEnum};
use net::Interface;
use runtime::Speed;

use super::values::{editions_help, speed};

pub(super) const SEND_EXAMPLES: &str = "\
Examples:
  koseki send radar.pcap --to 127.0.0.1:8600 --retime now
  koseki send north.ast south.ast mlat.ast=239.255.20.1:8600 --to 239.255.48.1:8600 --interface 127.0.0.1 --retime now
  koseki send radar.ast --to 239.255.48.1:8600 --interface eth1 --speed 4
  koseki send aircraft.sbs --to 127.0.0.1:30003 --retime now      lines, to whoever connects

FILE     data blocks of ASTERIX, bare or in a capture (pcap, pcapng) or in the final format, each sent as the datagram
         that it came in (bare: a datagram for each block); or lines of a transponder receiver (SBS-1), served over TCP:
         sending begins when somebody connects. Recordings of several sensors keep the distances
         of their times.
--retime without it records say the times that they were recorded with, and a live deployment isolates their source,
         whose clock is wrong by years. With `now` all times are moved by the same whole seconds.

Pieces are sent when they were recorded, counted from the first; where a recording does not say when that was, by the
times of day in its records. Ctrl-C ends it. What the network does not take is counted, not sent again.";

/// `koseki send`.
#[derive(Debug, Args)]
pub(crate) struct Send {
    /// The recordings, each with an address of its own if it has another than --to
    #[arg(value_name = "FILE[=ADDRESS:PORT]", required = true, value_parser = sent)]
    pub(crate) files: Vec<Sent>,
    /// Address and port, or a multicast group, to send datagrams to; for lines, the address to serve them at
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub(crate) to: Option<SocketAddr>,
    /// Name or address of the interface by which a multicast group is sent to
    #[arg(long, value_name = "INTERFACE")]
    pub(crate) interface: Option<Interface>,
    /// Factor of the speed at which it was recorded, or max
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = speed)]
    pub(crate) speed: Speed,
    /// Time that the first record is to be of [default: times stay as they are]
    #[arg(long, value_name = "TIME")]
    pub(crate) retime: Option<Retime>,
    /// Read a category by this edition, as in 21=0.23, to find its times (repeatable) [default: see --help]
    #[arg(long = "edition", value_name = "CAT=ED", long_help = editions_help())]
    pub(crate) editions: Vec<ChosenEdition>,
    /// Print the summary as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// A recording, and where it goes if not where all others do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Sent {
    pub(crate) file: PathBuf,
    pub(crate) to: Option<SocketAddr>,
}

fn sent(text: &str) -> Result<Sent, String> {
    // A name may have a = in it.
    let with_address = text.rsplit_once('=').filter(|_| !PathBuf::from(text).exists());
    let Some((file, to)) = with_address else {
        return Ok(Sent {
            file: text.into(),
            to: None,
        });
    };
    let to = to.parse().map_err(|_| format!("{to} is no ADDRESS:PORT"))?;
    Ok(Sent {
        file: file.into(),
        to: Some(to),
    })
}

/// Time that a recording is moved to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Retime {
    /// The present.
    Now,
}

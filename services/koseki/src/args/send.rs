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
  koseki send north.ast south.ast mlat.ast=239.255.20.1:8600 \\
      --to 239.255.48.1:8600 --interface 127.0.0.1 --retime now
  koseki send radar.ast --to 239.255.48.1:8600 --interface eth1 --speed 4
  koseki send aircraft.sbs --to 127.0.0.1:30003 --retime now
      lines, to each client
  koseki send flight.csv --to 127.0.0.1:8701 --retime now
      array snapshots, for [source.array]

FILE     data blocks of ASTERIX, bare, in a capture (pcap, pcapng) or in the
         final format, sent in their original datagrams (bare: a datagram per
         block); or lines of a transponder receiver (SBS-1), served over TCP
         from the first connection on; or array snapshots, as rows for `koseki
         bearings` or captured datagrams. Recordings of several sensors keep
         their relative times.
--retime with `now` all times are moved by the same number of whole seconds.
         Without --retime records keep their times, and a live deployment
         isolates the source, because its clock seems wrong by years.

The times of the recording, relative to the first time, set the times of
sending; a recording without times uses the times of day in its records. Ctrl-C
ends the command. Failures to send are counted, without a repetition.";

/// `koseki send`.
#[derive(Debug, Args)]
pub(crate) struct Send {
    /// The recordings, each with its own address if different from --to
    #[arg(value_name = "FILE[=ADDRESS:PORT]", required = true, value_parser = sent)]
    pub(crate) files: Vec<SentRecording>,
    /// Destination of datagrams: address and port, or a multicast group; for lines, the address of the TCP server
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub(crate) to: Option<SocketAddr>,
    /// Name or address of the interface for a multicast group
    #[arg(long, value_name = "INTERFACE")]
    pub(crate) interface: Option<Interface>,
    /// For lines, permit an address that other machines reach
    #[arg(long)]
    pub(crate) remote: bool,
    /// Factor of the original speed, or max
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = speed)]
    pub(crate) speed: Speed,
    /// New time of the first record [default: times are unchanged]
    #[arg(long, value_name = "TIME")]
    pub(crate) retime: Option<Retime>,
    /// Read a category by this edition, as in 21=0.23, to find its times (repeatable) [default: see --help]
    #[arg(long = "edition", value_name = "CAT=ED", long_help = editions_help())]
    pub(crate) editions: Vec<ChosenEdition>,
    /// Print the summary as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// A recording, and its own destination, if any.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SentRecording {
    pub(crate) file: PathBuf,
    pub(crate) to: Option<SocketAddr>,
}

fn sent(text: &str) -> Result<SentRecording, String> {
    // A file name may contain a =.
    let with_address = text.rsplit_once('=').filter(|_| !PathBuf::from(text).exists());
    let Some((file, to)) = with_address else {
        return Ok(SentRecording {
            file: text.into(),
            to: None,
        });
    };
    let to = to.parse().map_err(|_| format!("{to} is no ADDRESS:PORT"))?;
    Ok(SentRecording {
        file: file.into(),
        to: Some(to),
    })
}

/// New time of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Retime {
    /// The present.
    Now,
}

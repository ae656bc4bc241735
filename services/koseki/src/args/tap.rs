//! `koseki tap`.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use outgoing::HeightReference;

pub(super) const TAP_EXAMPLES: &str = "\
Examples:
  koseki tap --instance demo | jq -c '[.track_number, .position_m]'
  koseki tap --instance demo --format csv --count 1000 > tracks.csv
  koseki tap --instance demo --format cat062 --sac 1 --sic 2 > tracks.ast
  koseki tap system/alarms --instance demo
  koseki tap --instance demo --unix /run/tracks.sock --mode 660 --group 1001 &
  socat - UNIX-CONNECT:/run/tracks.sock
  koseki tap --instance demo --tcp 127.0.0.1:9000 &
  curl -sN telnet://127.0.0.1:9000

Each sample is a line with its fields by name, in the units of docs/integrate.md. An unknown value is null in JSON and
empty in CSV. Nested samples are JSON objects; in CSV they are columns such as stages.fused_ns, and lists are omitted.
CAT062 has the items of a gateway, except the kinds of contributing sensors. A socket's reader that is too slow is
disconnected, and may connect again; samples lost by this program are reported on standard error.";

/// `koseki tap`.
#[derive(Debug, Args)]
pub(crate) struct Tap {
    /// The topic: also system/alarms, system/decisions, sensor/NAME/tracks, health, …
    #[arg(value_name = "TOPIC", default_value = "system/tracks")]
    pub(crate) topic: String,
    /// The instance that is read
    #[arg(long, value_name = "NAME")]
    pub(crate) instance: String,
    /// Form of the samples
    #[arg(long, value_name = "FORM", default_value = "json")]
    pub(crate) format: TapFormat,
    /// System area code of the sender, in CAT062
    #[arg(long, value_name = "SAC", default_value_t = 0)]
    pub(crate) sac: u8,
    /// System identification code of the sender, in CAT062
    #[arg(long, value_name = "SIC", default_value_t = 0)]
    pub(crate) sic: u8,
    /// Kind of the system's heights, for CAT062: geometric or barometric
    #[arg(long, value_name = "WORD", default_value = "geometric", value_parser = heights)]
    pub(crate) heights: HeightReference,
    /// End after this number of samples
    #[arg(long, value_name = "SAMPLES")]
    pub(crate) count: Option<u64>,
    /// Serve the lines at this address instead of printing them
    #[arg(long, value_name = "ADDRESS:PORT", conflicts_with = "unix")]
    pub(crate) tcp: Option<SocketAddr>,
    /// Serve the lines at a Unix socket instead of printing them
    #[arg(long, value_name = "FILE")]
    pub(crate) unix: Option<PathBuf>,
    /// File mode of the Unix socket, octal
    #[arg(long, value_name = "MODE", default_value = "600", value_parser = mode, requires = "unix")]
    pub(crate) mode: u32,
    /// Number of the Unix socket's group [default: that of this process]
    #[arg(long, value_name = "GROUP", requires = "unix")]
    pub(crate) group: Option<u32>,
}

/// Form of the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TapFormat {
    /// A JSON object per line
    Json,
    /// Comma-separated values; the first line has the names
    Csv,
    /// ASTERIX data blocks, of system tracks
    Cat062,
}

fn heights(text: &str) -> Result<HeightReference, String> {
    HeightReference::from_word(text).ok_or_else(|| format!("\"{text}\" is neither geometric nor barometric"))
}

fn mode(text: &str) -> Result<u32, String> {
    let mode = u32::from_str_radix(text, 8).ok().filter(|mode| *mode <= 0o777);
    mode.ok_or_else(|| format!("\"{text}\" is no mode: three octal digits, as in 660"))
}

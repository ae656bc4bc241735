//! `koseki decode` on the command line.

use std::path::PathBuf;

use asterix::choice::ChosenEdition;
use clap::Args;
use formats::containers::Container;

use super::values::editions_help;

pub(super) const DECODE_EXAMPLES: &str = "\
Examples:
  koseki decode radar.pcap --out radar.jsonl
  koseki decode adsb.ast --edition 21=0.23 --out - | head -1
  koseki decode night.ff --statistics --json night.json

FILE holds data blocks and nothing else, or is a capture (pcap, pcapng), or has frames of the final format; its first
octets tell. A line of output has the item numbers of a record as keys, \"_c\" for its category and \"_ts\" for the
second in which it was recorded, where that is known.

What cannot be decoded is summed up on standard error, and is no failure. Only blocks that fit their edition to the last
octet are given, and only categories of which half of the blocks do: the others were made by another edition. The file
is read into memory whole.";

/// `koseki decode`.
#[derive(Debug, Args)]
pub(crate) struct Decode {
    /// The recording
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Read a category by this edition, as in 21=0.23 (repeatable) [default: see --help]
    #[arg(long = "edition", value_name = "CAT=ED", long_help = editions_help())]
    pub(crate) editions: Vec<ChosenEdition>,
    /// Kind of the recording: raw, pcap, pcapng or final [default: what its first octets tell]
    #[arg(long, value_name = "KIND")]
    pub(crate) container: Option<Container>,
    /// Refuse blocks with spare bits set, or with items that go on beyond their edition
    #[arg(long)]
    pub(crate) strict: bool,
    /// File for the records, one JSON object a line; - for standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Print who sent how much and when, and what was refused
    #[arg(long)]
    pub(crate) statistics: bool,
    /// File for the same statistics as JSON
    #[arg(long, value_name = "FILE", requires = "statistics")]
    pub(crate) json: Option<PathBuf>,
}

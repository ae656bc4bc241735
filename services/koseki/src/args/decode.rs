//! `koseki decode` on the command line.

use std::path::PathBuf;

use asterix::choice::ChosenEdition;
use clap::Args;
use formats::containers::Container;

use super::values::editions_help;

pub(super) const DECODE_EXAMPLES: &str = "\
Examples:
  koseki decode radar.pcap                     statistics: what it holds
  koseki decode radar.pcap --out radar.jsonl
  koseki decode adsb.ast --edition 21=0.23 --out - | head -1
  koseki decode night.ff --json night.json

FILE contains bare data blocks, is a capture (pcap, pcapng), has frames of the
final format, is a .gps recording, or has hexadecimal lines with or without a
time; its first bytes identify the kind. A line of output has the item numbers
of a record as keys, \"_c\" for the category and \"_ts\" for the second of the
recording, if known.

A summary of undecodable blocks goes to standard error; such blocks are no
failure. The output has only blocks that fit their edition to the last byte, and
only categories with at least half of their blocks fitting: other categories
were encoded with another edition. The whole file is read into memory.";

/// `koseki decode`.
#[derive(Debug, Args)]
pub(crate) struct DecodeArgs {
    /// The recording
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Read a category by this edition, as in 21=0.23 (repeatable) [default: see --help]
    #[arg(long = "edition", value_name = "CAT=ED", long_help = editions_help())]
    pub(crate) editions: Vec<ChosenEdition>,
    /// Kind of the recording: raw, pcap, pcapng, final, gps or hex [default: by the first bytes]
    #[arg(long, value_name = "KIND")]
    pub(crate) container: Option<Container>,
    /// Reject blocks with spare bits set, or with items longer than in their edition
    #[arg(long)]
    pub(crate) strict: bool,
    /// File for the records, a JSON object per line; - for standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Print amounts and times per sender, and rejected blocks [default: without --out]
    #[arg(long)]
    pub(crate) statistics: bool,
    /// File for the same statistics as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
}

impl DecodeArgs {
    /// Whether statistics are printed: where nothing else is asked for, too.
    pub(crate) fn shows_statistics(&self) -> bool {
        self.statistics || self.out.is_none() || self.json.is_some()
    }
}

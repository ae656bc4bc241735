//! `koseki encode`.

use std::path::PathBuf;

use asterix::choice::ChosenEdition;
use clap::Args;

use super::values::editions_help;

pub(super) const ENCODE_EXAMPLES: &str = "\
Examples:
  koseki encode radar.jsonl --out radar.ast
  koseki decode old.ast --edition 21=0.23 --out - | koseki encode - \\
      --edition 21=0.23 --out copy.ast
  echo '{\"_c\":10,\"010\":{\"SAC\":0,\"SIC\":7},\"000\":1,\"140\":43200.5}' | \\
      koseki encode - --out one.ast

FILE     a record per line in the form of `koseki decode`: a JSON object with
         the item numbers of the category as keys and \"_c\" for the category.
         Numbers are in the document's units and rounded to the LSB; items may
         come in any order. The output contains data blocks only, without \"_ts\",
         the time of the recording. - is standard input.
--out    data blocks of at most 1,400 bytes, which fit a datagram; a longer
         record has a block of its own.

Records with an unknown name, a missing element, a value of another kind, or a
value too large for its bits are omitted. Standard error reports their number,
and the first record of each place. With --strict the first such record ends the
command with exit code 2, without output.";

/// `koseki encode`.
#[derive(Debug, Args)]
pub(crate) struct EncodeArgs {
    /// The records, a JSON object per line; - for standard input
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Write a category by this edition, as in 21=0.23 (repeatable) [default: see --help]
    #[arg(long = "edition", value_name = "CAT=ED", long_help = editions_help())]
    pub(crate) editions: Vec<ChosenEdition>,
    /// End at the first record without an encoding
    #[arg(long)]
    pub(crate) strict: bool,
    /// File for the data blocks; - for standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
}

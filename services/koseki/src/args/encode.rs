//! `koseki encode`.

use std::path::PathBuf;

use asterix::choice::ChosenEdition;
use clap::Args;

use super::values::editions_help;

pub(super) const ENCODE_EXAMPLES: &str = "\
Examples:
  koseki encode radar.jsonl --out radar.ast
  koseki decode old.ast --edition 21=0.23 --out - | koseki encode - --edition 21=0.23 --out copy.ast
  echo '{\"_c\":10,\"010\":{\"SAC\":0,\"SIC\":7},\"000\":1,\"140\":43200.5}' | koseki encode - --out one.ast

FILE     a record a line, as `koseki decode` writes them: a JSON object with the item numbers of the category as keys and
         \"_c\" for the category. Numbers are in the document's units and rounded to the LSB; items may come in any order.
         \"_ts\", the time of the recording, is not kept: the output is data blocks and nothing else. - is standard input.
--out    data blocks of at most 1,400 octets, as they fit a datagram; a longer record has a block of its own.

Nothing is guessed: a name that the edition does not know, an element that is missing, a value of another kind or one that
its bits cannot hold leaves the record out. Standard error says how many, and the first of each place; with --strict the
first of them ends it, with exit code 2, and nothing is written.";

/// `koseki encode`.
#[derive(Debug, Args)]
pub(crate) struct Encode {
    /// The records, one JSON object a line; - for standard input
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Write a category by this edition, as in 21=0.23 (repeatable) [default: see --help]
    #[arg(long = "edition", value_name = "CAT=ED", long_help = editions_help())]
    pub(crate) editions: Vec<ChosenEdition>,
    /// End at the first record that cannot be written
    #[arg(long)]
    pub(crate) strict: bool,
    /// File for the data blocks; - for standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
}

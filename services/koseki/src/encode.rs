//! `koseki encode`: records as lines of JSON into data blocks of ASTERIX (FM-11), the inverse of `koseki decode`.
//!
//! Successive records of a category share a block up to the size of a datagram. A record without an exact encoding is
//! omitted, counted by place and reported on standard error, because a substitute would be read as other data.

use std::collections::BTreeMap;
use std::io::{self, BufRead, BufReader, Write};
use std::path::Path;

use anyhow::Context as _;
use asterix::choice::ChosenEdition;
use asterix::{BlockWriter, Category, Expansion, NamedRecord, registry};
use offline::{InputError, OutputFile, Usage, is_same_file, open};
use telemetry::table::count;

use crate::args::EncodeArgs;
use crate::given::GivenLine;

/// Value of `FILE` that means standard input.
const STANDARD_INPUT: &str = "-";
/// Largest size of a block of several records, bytes: with the headers of UDP and IP, a block fits an Ethernet frame.
const BLOCK_OCTETS_MAX: u16 = 1400;

/// Encodes.
///
/// # Errors
/// If the arguments are invalid, if a file cannot be read or written, or, with `strict`, if a record has no encoding.
pub(crate) fn run(encode: &EncodeArgs) -> anyhow::Result<()> {
    if is_same_file(&encode.out, &encode.file) {
        return Err(Usage(format!(
            "{} is the input itself: name another file (see `koseki encode --help`)",
            encode.out.display()
        ))
        .into());
    }
    let input: Box<dyn BufRead> = match encode.file == Path::new(STANDARD_INPUT) {
        true => Box::new(io::stdin().lock()),
        false => Box::new(BufReader::new(open(&encode.file)?)),
    };
    let (out, written) = write(encode, input, OutputFile::begin(&encode.out)?)?;
    if written.records == 0 {
        let mut reasons = written.left_out.values().map(|(_, first)| first.as_str());
        let why = reasons.next().unwrap_or("the file is empty");
        return Err(InputError::new(&encode.file, format!("no record can be encoded: {why}")).into());
    }
    out.finish()?;
    let _ = io::stderr().write_all(written.notes(&encode.out).as_bytes());
    Ok(())
}

fn write<W: Write>(encode: &EncodeArgs, input: impl BufRead, out: W) -> anyhow::Result<(W, EncodeCounts)> {
    let unwritten = || format!("{} cannot be written", encode.out.display());
    let encoder = Encoder::new(&encode.editions);
    let (mut blocks, mut written) = (BlockBuilder::new(out), EncodeCounts::default());
    let mut octets = Vec::new();
    for (number, line) in (1u64..).zip(input.lines()) {
        let line = line.map_err(|error| InputError::unreadable(&encode.file, &error))?;
        if line.trim().is_empty() {
            continue;
        }
        octets.clear();
        match encoder.encode(&line, &mut octets) {
            Ok(category) => {
                blocks.push(category, &octets).with_context(unwritten)?;
                written.records += 1;
            }
            Err(fault) if encode.strict => {
                return Err(InputError::new(&encode.file, format!("line {number}: {}", fault.what)).into());
            }
            Err(fault) => written.leave_out(number, fault),
        }
    }
    let (out, count) = blocks.finish().with_context(unwritten)?;
    written.blocks = count;
    Ok((out, written))
}

/// Why a record is left out.
struct LatestFault {
    /// Category or item.
    place: String,
    /// The whole sentence.
    what: String,
}

/// The editions by which records are written.
struct Encoder {
    tables: Vec<&'static Category>,
    expansions: Vec<&'static Expansion>,
}

impl Encoder {
    fn new(chosen: &[ChosenEdition]) -> Self {
        let mut encoder = Self {
            tables: Vec::new(),
            expansions: Vec::new(),
        };
        for chosen in chosen {
            match chosen {
                ChosenEdition::Category(table) => encoder.tables.push(table),
                ChosenEdition::Expansion(rules) => encoder.expansions.push(rules),
            }
        }
        encoder.tables.extend(registry::defaults());
        encoder
    }

    /// Appends the octets of the record in `line`; gives the record's category.
    fn encode(&self, line: &str, octets: &mut Vec<u8>) -> Result<u8, LatestFault> {
        let fault = |place: &str, what: String| LatestFault {
            place: place.to_owned(),
            what,
        };
        let record = GivenLine::read(line.as_bytes()).map_err(|error| {
            fault(
                "JSON",
                format!("no JSON object on a line, as written by `koseki decode`: {error}"),
            )
        })?;
        if let Some((name, _)) = record.twice {
            return Err(fault(
                "a key that is given twice",
                format!("\"{name}\" is given twice: leave out one"),
            ));
        }
        let record = record.value;
        let category = record.get("_c").ok_or_else(|| {
            fault(
                "_c",
                "the category is missing: add it as \"_c\", as in {\"_c\":48,\"010\":…}".to_owned(),
            )
        })?;
        let number = category.as_u64().and_then(|number| u8::try_from(number).ok());
        let table = self.tables.iter().find(|table| Some(table.number) == number);
        let table = table.ok_or_else(|| {
            let known: Vec<String> = registry::defaults().map(|table| table.number.to_string()).collect();
            fault(
                &format!("category {category}"),
                format!(
                    "there is no table of category {category}; there are {}",
                    known.join(", ")
                ),
            )
        })?;
        let expansion = self.expansions.iter().find(|rules| rules.number == table.number);
        NamedRecord::from_json(&record, table, expansion.copied())
            .and_then(|named| named.encode(table, octets))
            .map(|()| table.number)
            .map_err(|error| {
                let item = error.place.path.first();
                let place = item.map_or(format!("category {:03}", table.number), |item| {
                    format!("I{:03}/{item}", table.number)
                });
                fault(&place, format!("{error} (edition {})", table.edition))
            })
    }
}

/// Records waiting for blocks.
struct BlockBuilder<W> {
    out: W,
    category: u8,
    open: BlockWriter,
    count: u64,
}

impl<W: Write> BlockBuilder<W> {
    fn new(out: W) -> Self {
        Self {
            out,
            category: 0,
            open: BlockWriter::new(0, BLOCK_OCTETS_MAX),
            count: 0,
        }
    }

    fn push(&mut self, category: u8, record: &[u8]) -> anyhow::Result<()> {
        let is_long = record.len() + 3 > usize::from(BLOCK_OCTETS_MAX);
        if category != self.category || is_long {
            self.close()?;
            let octets_max = if is_long { u16::MAX } else { BLOCK_OCTETS_MAX };
            self.open = BlockWriter::new(category, octets_max);
            self.category = category;
        }
        if let Some(block) = self.open.push(record)? {
            self.out.write_all(block)?;
            self.count += 1;
        }
        if is_long {
            self.close()?;
            self.open = BlockWriter::new(category, BLOCK_OCTETS_MAX);
        }
        Ok(())
    }

    fn close(&mut self) -> io::Result<()> {
        if let Some(block) = self.open.finish() {
            self.out.write_all(block)?;
            self.count += 1;
        }
        Ok(())
    }

    fn finish(mut self) -> io::Result<(W, u64)> {
        self.close()?;
        self.out.flush()?;
        Ok((self.out, self.count))
    }
}

/// Counts of written and omitted records.
#[derive(Default)]
struct EncodeCounts {
    records: u64,
    blocks: u64,
    /// Number of records left out at a place, and the first of these.
    left_out: BTreeMap<String, (u64, String)>,
}

impl EncodeCounts {
    fn leave_out(&mut self, line: u64, fault: LatestFault) {
        let first = || (0, format!("line {line}: {}", fault.what));
        self.left_out.entry(fault.place).or_insert_with(first).0 += 1;
    }

    /// Returns a line about written records, and a line per place with omitted records.
    fn notes(&self, out: &Path) -> String {
        let several = |number: u64, what: &str| {
            let plural = if number == 1 { "" } else { "s" };
            format!("{} {what}{plural}", count(number))
        };
        let (records, blocks) = (several(self.records, "record"), several(self.blocks, "block"));
        let mut text = format!("koseki: {}: {records} in {blocks}\n", out.display());
        for (place, (number, first)) in &self.left_out {
            let records = several(*number, "record");
            text += &format!("koseki: {records} left out for {place}, the first: {first}\n");
        }
        text
    }
}

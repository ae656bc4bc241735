//! Decodes a file of ASTERIX blocks to one JSON object a line, and says what it met.
//!
//! ```text
//! cargo run --release -p formats --example decode_json -- FILE OUT.jsonl [CATEGORY=EDITION ...]
//! ```
//!
//! `48=1.32` reads category 048 with this edition's table instead of the default. `48/RE=1.13` decodes the content of the
//! reserved expansion field by this edition of its coding rules; otherwise the field is shown as octets.

use std::error::Error;
use std::fs;

use formats::asterix::{Decoder, Edition, Expansion, Mode, NamedRecord, Record, registry};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, out, choices @ ..] = arguments.as_slice() else {
        return Err("usage: decode_json FILE OUT.jsonl [CATEGORY=EDITION ...] [CATEGORY/RE=EDITION ...]".into());
    };
    let mut decoder = Decoder::new(Mode::Lenient);
    let mut expansions = Vec::new();
    for choice in choices {
        let (category, edition) = choice.split_once('=').ok_or("write CATEGORY=EDITION")?;
        let edition: Edition = edition.parse()?;
        let unknown = || format!("no table for {category} edition {edition}");
        if let Some(category) = category.strip_suffix("/RE") {
            expansions.push(registry::find_expansion(category.parse()?, edition).ok_or_else(unknown)?);
        } else {
            decoder = decoder.with_table(registry::find(category.parse()?, edition).ok_or_else(unknown)?);
        }
    }
    let bytes = fs::read(file)?;
    let mut lines = Vec::with_capacity(8 * bytes.len());
    for record in decoder.records(&bytes) {
        match record {
            Ok(record) => {
                let mut named = NamedRecord::new(&record);
                expand(&record, &mut named, &expansions);
                named.write_json(&mut lines);
                lines.push(b'\n');
            }
            Err(error) => eprintln!("{error}"),
        }
    }
    fs::write(out, lines)?;
    for (label, sentence, value) in decoder.counts().entries() {
        println!("{value:>12} {label}: {sentence}");
    }
    Ok(())
}

/// Puts the content of the reserved expansion field in the place of its octets.
fn expand(record: &Record<'_>, named: &mut NamedRecord, expansions: &[&'static Expansion]) {
    for expansion in expansions {
        match expansion.read(record) {
            Ok(Some(content)) => named
                .items
                .iter_mut()
                .filter(|(name, _)| *name == "RE")
                .for_each(|(_, value)| *value = content.clone()),
            Ok(None) => {}
            Err(error) => eprintln!("{error}"),
        }
    }
}

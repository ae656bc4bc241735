//! Decodes a file of ASTERIX blocks to one JSON object a line, and says what it met.
//!
//! ```text
//! cargo run --release -p formats --example decode_json -- FILE OUT.jsonl [CATEGORY=EDITION ...]
//! ```

use std::error::Error;
use std::fs;

use formats::asterix::{Decoder, Edition, Mode, NamedRecord, registry};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, out, choices @ ..] = arguments.as_slice() else {
        return Err("usage: decode_json FILE OUT.jsonl [CATEGORY=EDITION ...]".into());
    };
    let mut decoder = Decoder::new(Mode::Lenient);
    for choice in choices {
        let (category, edition) = choice.split_once('=').ok_or("write CATEGORY=EDITION")?;
        let edition: Edition = edition.parse()?;
        let table = registry::find(category.parse()?, edition)
            .ok_or_else(|| format!("no table for category {category} edition {edition}"))?;
        decoder = decoder.with_table(table);
    }
    let bytes = fs::read(file)?;
    let mut lines = Vec::with_capacity(8 * bytes.len());
    for record in decoder.records(&bytes) {
        match record {
            Ok(record) => {
                NamedRecord::new(&record).write_json(&mut lines);
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

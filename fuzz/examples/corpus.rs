//! Makes a corpus for the target `codec` from recordings in any container.
//!
//! ```text
//! cargo run --release --manifest-path fuzz/Cargo.toml --example corpus -- fuzz/corpus/codec FILE...
//! ```
//!
//! Of blocks with the same category, length and FSPEC of the first record only the first is kept: the others would
//! lead the fuzzer to the same places. A block becomes one input for each edition of its category.

use std::collections::HashSet;
use std::error::Error;
use std::fs;
use std::path::Path;

use asterix::{blocks, registry};
use formats::containers::datagrams;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, files @ ..] = arguments.as_slice() else {
        return Err("usage: corpus FOLDER FILE...".into());
    };
    fs::create_dir_all(folder)?;
    let mut seen = HashSet::new();
    for file in files {
        let bytes = fs::read(file)?;
        for datagram in datagrams(&bytes).flatten() {
            for block in blocks(&datagram.bytes).flatten() {
                let body = block.body();
                let goes_on = body.iter().take_while(|octet| *octet & 1 == 1).count();
                let fspec = body[..body.len().min(goes_on + 1)].to_vec();
                if seen.insert((block.category, body.len(), fspec)) {
                    write_inputs(Path::new(folder), seen.len(), block.category, body)?;
                }
            }
        }
    }
    println!("{} different blocks", seen.len());
    Ok(())
}

/// Writes one input for each edition of the category.
fn write_inputs(folder: &Path, number: usize, category: u8, body: &[u8]) -> std::io::Result<()> {
    for (index, table) in registry::REGISTRY.iter().enumerate() {
        if table.number == category {
            let name = format!("{number:05}_{category:03}_{}", table.edition);
            fs::write(folder.join(name), fuzz::codec::join(index, body))?;
        }
    }
    Ok(())
}

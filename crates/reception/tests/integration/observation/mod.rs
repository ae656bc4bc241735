//! Tests of ASTERIX records as observations.

mod allocation;
mod recordings;
mod reports;

/// A block with this body.
fn block(category: u8, body: &[u8]) -> Vec<u8> {
    let [high, low] = (body.len() as u16 + 3).to_be_bytes();
    [&[category, high, low], body].concat()
}

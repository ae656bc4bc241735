//! ASTERIX codec: decodes a block's body in all ways with any table, and encodes it again.
//!
//! `crates/asterix/tests/any_bytes` defines the required properties. The bytes are read as the body of a block of
//! the table's category, which reaches deep code, and unchanged, which tests the framing.

#![no_main]

#[path = "../../crates/asterix/tests/any_bytes/mod.rs"]
mod any_bytes;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    if let Some((table, mode, body)) = fuzz::codec::split(input) {
        any_bytes::check(table, mode, &any_bytes::block(table.number, body));
        any_bytes::check(table, mode, body);
    }
});

//! The ASTERIX codec: a block's body read in all ways with any table, and written again.
//!
//! What must hold is in `crates/asterix/tests/any_bytes`. The octets are read as the body of a block of the table's
//! category, which goes deep, and as they are, which tries the framing.

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

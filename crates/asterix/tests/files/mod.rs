//! The data blocks of real sensors' recordings, where these are.

use formats::containers::datagrams;

/// The data blocks of a recording, whatever they are packed in, one after the other. It is named by its path in the
/// folder of recordings.
pub(crate) fn recording(name: &str) -> Option<Vec<u8>> {
    let bytes = test_support::recording(name)?;
    let datagrams = datagrams(&bytes).flatten();
    Some(datagrams.flat_map(|datagram| datagram.bytes.into_owned()).collect())
}

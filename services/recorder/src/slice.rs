//! Slice of the recorded stream.

use messages::BatchHeader;
use runtime::Now;

/// Slice of the stream.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StreamSlice<'a> {
    /// Place of the topic in the list of topics; that of a data stream is its place in `Deployment::streams`.
    pub(crate) place: usize,
    pub(crate) header: &'a BatchHeader,
    /// Bytes of the samples.
    pub(crate) octets: &'a [u8],
    /// Number below which the samples had been recorded before.
    pub(crate) from_sequence: u64,
    /// Time at which the slice was taken.
    pub(crate) now: Now,
}

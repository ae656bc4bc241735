//! Bit stream, written from the lowest bit of each byte upwards.

/// Writer of a bit stream.
#[derive(Debug, Default)]
pub(super) struct Bits {
    bytes: Vec<u8>,
    /// Bits not yet in `bytes`, the earliest lowest.
    pending: u64,
    count: u32,
}

impl Bits {
    /// Appends the low `count` bits of `value`; at most 32.
    pub(super) fn add(&mut self, value: u32, count: u32) {
        debug_assert!(count <= 32, "more bits than the value has");
        self.pending |= (u64::from(value) & ((1 << count) - 1)) << self.count;
        self.count += count;
        while self.count >= 8 {
            self.bytes.push(self.pending as u8);
            self.pending >>= 8;
            self.count -= 8;
        }
    }

    /// Ends a stream that is read forwards.
    pub(super) fn finish(mut self) -> Vec<u8> {
        if self.count > 0 {
            self.bytes.push(self.pending as u8);
        }
        self.bytes
    }

    /// Ends a stream that is read backwards, with the bit by which a reader finds its end.
    pub(super) fn close(mut self) -> Vec<u8> {
        self.add(1, 1);
        self.finish()
    }
}

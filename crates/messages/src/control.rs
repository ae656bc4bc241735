//! Messages from consumers to producers, and from operators to fusion.

use crate::layout::sample;

sample! {
    /// Progress of one consumer on one topic. Producers of recorded data wait for it, so that no reader falls
    /// behind and no sample is lost.
    Progress, size 56 {
        /// Monotonic start time of the consumer, nanoseconds: a restart shows as a new value.
        consumer_incarnation: u64,
        /// Monotonic start time of the publisher whose samples are counted.
        publisher_incarnation: u64,
        /// Samples of that source worked off: all with a sequence number below this.
        done_sequence: u64,
        /// Slices of that publisher taken since the consumer joined.
        done_batches: u64,
        /// How far the consumer has got in the time of the data, UTC, nanoseconds; i64::MIN if unknown.
        progress_ns: i64 = i64::MIN,
        /// Number of the source, or of the wide-area sensor; 0 for the system tracks.
        number: u16,
        /// Kind of topic: a `Stream` code.
        stream: u8,
        /// Kind of the consumer: a `ProcessKind` code.
        consumer: u8,
        /// Reserved, 0.
        reserved: u32,
        /// Monotonic time at which this was said, nanoseconds.
        said_ns: i64,
    }
}

sample! {
    /// Command to the fusion process.
    Control, size 40 {
        /// Kind of order; 1: the condition (weather) named in `name` holds from now on (TI-7); 2: an image of the whole
        /// engine is to be said, for a recorder.
        kind: u32,
        /// Reserved, 0.
        reserved: u32,
        /// Name that the order speaks of, UTF-8, padded with zeros.
        name: [u8; 32],
    }
}

impl Control {
    /// [`Control::kind`]: a named condition holds from now on.
    pub const CONDITION: u32 = 1;

    /// [`Control::kind`]: fusion publishes a snapshot of the whole engine.
    pub const IMAGE: u32 = 2;

    /// Returns the command to publish a snapshot of the whole engine.
    pub fn image() -> Self {
        Self {
            kind: Self::IMAGE,
            ..Self::default()
        }
    }

    /// Returns the command that condition `name` holds; `None` if the name is too long.
    pub fn condition(name: &str) -> Option<Self> {
        let mut control = Self {
            kind: Self::CONDITION,
            ..Self::default()
        };
        control.name.get_mut(..name.len())?.copy_from_slice(name.as_bytes());
        Some(control)
    }

    /// Returns the name stated in the command.
    pub fn name(&self) -> &str {
        let end = self.name.iter().position(|byte| *byte == 0).unwrap_or(self.name.len());
        std::str::from_utf8(&self.name[..end]).unwrap_or_default()
    }
}

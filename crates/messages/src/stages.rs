//! Times of a report at the stages of processing.

use crate::layout::sample;

sample! {
    /// Monotonic stamps of a report's stages (PL-8), nanoseconds of the machine's `CLOCK_MONOTONIC`; 0 for a stage
    /// not reached. All processes of a deployment share that clock.
    StageTimes, size 32 {
        /// The adapter had the report's last byte.
        ingested_ns: i64,
        /// The adapter handed the report to shared memory.
        published_ns: i64,
        /// Fusion took the report from shared memory.
        taken_ns: i64,
        /// Fusion handed the system track to shared memory.
        fused_ns: i64,
    }
}

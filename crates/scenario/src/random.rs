//! Random numbers that do not depend on the order in which they are asked for.
//!
//! One generator for a whole run would give every draw a value that depends on all draws before it: one target more,
//! one sensor restarted, and everything after it differs. Here each purpose has a stream of its own, keyed by what
//! it is for; ChaCha is a cipher, so streams of keys that differ in one bit have nothing in common.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// Purpose of a stream of random numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    /// Path and identity of a target.
    Target,
    /// Properties of a target as seen by one sensor: phase, equipment.
    Acquaintance,
    /// One look of a sensor at a target: detection and measurement errors.
    Look,
    /// Time of one broadcast.
    Broadcast,
    /// Outages of one target at one sensor.
    Outage,
    /// How many false targets one period brings.
    FalseCount,
    /// One false target.
    FalseTarget,
    /// False plots of one delivery.
    FalsePlots,
    /// Whether a target transmits, and on which frequency.
    Transmitter,
    /// One look of a direction finder at a transmitter.
    Bearing,
    /// Size, way and speed of a formation.
    Formation,
    /// Whether a radar resolves two targets in one turn.
    Resolution,
    /// One look of a radar at several targets that it does not resolve.
    MergedLook,
    /// One report of a wide-area sensor.
    WideArea,
}

/// The stream for `purpose` at `source`, of the thing numbered (`first`, `second`).
pub(crate) fn stream(seed: u64, purpose: Purpose, source: u16, first: u64, second: u64) -> ChaCha8Rng {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8] = purpose as u8;
    key[10..12].copy_from_slice(&source.to_le_bytes());
    key[16..24].copy_from_slice(&first.to_le_bytes());
    key[24..].copy_from_slice(&second.to_le_bytes());
    ChaCha8Rng::from_seed(key)
}

//! Random numbers independent of the order of draws.
//!
//! With a single generator for a whole run, every draw depends on all earlier draws: an additional target or a
//! restarted sensor changes everything after it. Here each purpose has a separate stream, keyed by the purpose.
//! ChaCha is a cipher, so streams of keys that differ in one bit are unrelated.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// Purpose of a stream of random numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    /// Path and identity of a target.
    Target,
    /// Properties of a target relative to one sensor: phase, equipment.
    Acquaintance,
    /// One look of a sensor at a target: detection and measurement errors.
    Look,
    /// Time of one broadcast.
    Broadcast,
    /// Outages of one target at one sensor.
    Outage,
    /// Number of false targets appearing in one period.
    FalseCount,
    /// One false target.
    FalseTarget,
    /// False plots of one delivery.
    FalsePlots,
    /// Presence of a transmitter on a target, and its frequency.
    Transmitter,
    /// One look of a direction finder at a transmitter.
    Bearing,
    /// Size, way and speed of a formation.
    Formation,
    /// Resolution of two targets by a radar in one turn.
    Resolution,
    /// One look of a radar at several unresolved targets.
    MergedLook,
    /// One report of a wide-area sensor.
    WideArea,
    /// The transponder's reply in one look of a radar.
    Reply,
    /// Errors of a ship's navigation.
    Navigation,
    /// Equipment of a ship with AIS, and the errors of its positions.
    Ship,
    /// Reception of a message of AIS.
    Slot,
}

/// Returns the stream for `purpose` at `source`, of the thing numbered (`first`, `second`).
pub(crate) fn stream(seed: u64, purpose: Purpose, source: u16, first: u64, second: u64) -> ChaCha8Rng {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8] = purpose as u8;
    key[10..12].copy_from_slice(&source.to_le_bytes());
    key[16..24].copy_from_slice(&first.to_le_bytes());
    key[24..].copy_from_slice(&second.to_le_bytes());
    ChaCha8Rng::from_seed(key)
}

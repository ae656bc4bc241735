//! Hash of track numbers, and of addresses, for the tables.
//!
//! A scattering hash is right for keys of unknown structure. Track numbers have a structure: a source counts them up
//! and reports them in much the same order every time. Scattered over a table of megabytes, each look-up would go to
//! another corner of memory. Therefore consecutive numbers of a source lie next to each other, and the sources lie as
//! far apart as the table allows (bit-reversed, for any number of sources). Only numbers far apart are scattered, by
//! blocks: a source may number by multiples of anything.
//!
//! Limit: numbers chosen with bad intent can make look-ups slow, as with any hash without a secret.

use serde::{Deserialize, Serialize};
use std::hash::{BuildHasher, Hasher};

/// Numbers of the same block lie next to each other.
const BLOCK_BITS: u32 = 16;
/// Uppermost bits, by which the table distinguishes neighbours without a read.
const TAG_SHIFT: u32 = 57;

/// Makes hashes of (source, track number), or of an address, for a table of a certain size.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct NumberHasher {
    places: u64,
}

impl NumberHasher {
    /// For a table with room for `capacity` numbers.
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            // The number of places in the table, which keeps an eighth empty.
            places: (capacity as u64 * 8 / 7).next_power_of_two(),
        }
    }
}

impl BuildHasher for NumberHasher {
    type Hasher = TableSlot;

    fn build_hasher(&self) -> TableSlot {
        TableSlot {
            places: self.places,
            place: 0,
        }
    }
}

/// Place of a number in the table.
#[derive(Debug)]
pub(crate) struct TableSlot {
    places: u64,
    place: u64,
}

impl Hasher for TableSlot {
    fn write_u16(&mut self, source: u16) {
        self.place += (u64::from(source.reverse_bits()) * self.places) >> u16::BITS;
    }

    fn write_u32(&mut self, number: u32) {
        let block = u64::from(number >> BLOCK_BITS).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> u32::BITS;
        self.place += block + u64::from(number & ((1 << BLOCK_BITS) - 1));
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.place = self.place.wrapping_mul(0x0100_0000_01b3) ^ u64::from(*byte);
        }
    }

    fn finish(&self) -> u64 {
        self.place ^ (self.place << TAG_SHIFT)
    }
}

/// A table in serde's form.
pub(crate) mod table {
    use std::collections::HashMap;

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::NumberHasher;

    pub(crate) fn serialize<K: Serialize, V: Serialize, S: Serializer>(
        table: &HashMap<K, V, NumberHasher>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let entries: Vec<(&K, &V)> = table.iter().collect();
        (table.hasher(), entries).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, K, V, D>(deserializer: D) -> Result<HashMap<K, V, NumberHasher>, D::Error>
    where
        K: Deserialize<'de> + Eq + std::hash::Hash,
        V: Deserialize<'de>,
        D: Deserializer<'de>,
    {
        let (hasher, entries) = <(NumberHasher, Vec<(K, V)>)>::deserialize(deserializer)?;
        let mut table = HashMap::with_capacity_and_hasher(entries.len(), hasher);
        table.extend(entries);
        Ok(table)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_lie_side_by_side_sources_apart_and_multiples_scattered() {
        let numbers = NumberHasher::new(50_000);
        let place = |source: u16, number: u32| numbers.hash_one((source, number)) & 0xffff;
        assert_eq!(place(0, 5), place(0, 4) + 1);
        assert_ne!(
            numbers.hash_one((0u16, 5u32)) >> TAG_SHIFT,
            numbers.hash_one((0u16, 4u32)) >> TAG_SHIFT
        );
        for (source, quarter) in [(0, 0), (1, 2), (2, 1), (3, 3)] {
            assert_eq!(place(source, 0), quarter << 14);
        }
        for step in [1 << 8, 1 << 16, 1 << 20] {
            let mut taken: Vec<_> = (0..1000).map(|index| place(0, index * step)).collect();
            taken.sort_unstable();
            taken.dedup();
            assert!(taken.len() > 900, "{step}: {}", taken.len());
        }
    }
}

//! Snapshots of an antenna array in datagrams (EL-1), version 1.
//!
//! All numbers are little-endian. A datagram has 72 bytes of head, then the samples.
//!
//! | bytes | type | contents |
//! | --- | --- | --- |
//! | 0 | 4 bytes | `KSNP` |
//! | 4 | `u8` | version: 1 |
//! | 5 | `u8` | bit 0: a position is stated; bit 1: a heading is stated; other bits 0 |
//! | 6 | `u16` | number of antennas, 2 to 256 |
//! | 8 | `u32` | number of the measurement, counted by the sender |
//! | 12 | `u32` | snapshots of the whole measurement |
//! | 16 | `u32` | place of the datagram's first snapshot in the measurement, from 0 |
//! | 20 | `u32` | snapshots in this datagram |
//! | 24 | `i64` | time of the measurement, UTC, nanoseconds since 1970 |
//! | 32 | `f64` | frequency, hertz |
//! | 40 | 3 × `f64` | position of the platform east, north, up in the system frame, metres; 0 if not stated |
//! | 64 | `f64` | heading of the platform, radians clockwise from north; 0 if not stated |
//! | 72 | pairs of `f32` | real and imaginary part of each antenna's sample, snapshot after snapshot |
//!
//! A measurement of some hundred snapshots exceeds the 1,500 bytes that networks carry in one piece, so it may take
//! several datagrams. Each datagram has the whole head: a lost datagram costs its own snapshots only.

use std::f64::consts::TAU;
use std::fmt;

use observations::SnapshotBlock;

/// First bytes of every datagram.
const MAGIC: &[u8; 4] = b"KSNP";
/// Version of the layout.
const VERSION: u8 = 1;
/// Bytes before the samples.
const HEAD_OCTETS: usize = 72;
/// Bytes of a sample.
const SAMPLE_OCTETS: usize = 8;
/// Largest number of antennas.
pub const ANTENNAS_MAX: u16 = 256;
/// Largest number of samples of a measurement, over all its snapshots and antennas.
pub const SAMPLES_MAX: u64 = 1 << 20;
/// Latest time, nanoseconds since 1970 (the year 2116): differences of times do not overflow.
const TIME_MAX_NS: i64 = 1 << 62;
/// Largest coordinate of a platform, metres.
const COORDINATE_MAX_M: f64 = 1e9;
/// Largest magnitude of a part of a sample: its square still has a finite sum.
const PART_MAX: f32 = 1e15;
/// Bits of the flags.
const HAS_POSITION: u8 = 1;
const HAS_HEADING: u8 = 1 << 1;

/// Reason why a datagram is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SnapshotRefusal {
    /// Another layout, or another version of it.
    Foreign,
    /// A length other than the one that the head states.
    Length,
    /// A value that cannot be: its name.
    Value(&'static str),
}

impl fmt::Display for SnapshotRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Foreign => f.write_str("is no datagram of snapshots of version 1"),
            Self::Length => f.write_str("has another length than its head states"),
            Self::Value(name) => write!(f, "has an impossible {name}"),
        }
    }
}

impl std::error::Error for SnapshotRefusal {}

/// Whether a datagram begins as one of snapshots, of any version.
pub fn is_snapshots(octets: &[u8]) -> bool {
    octets.starts_with(MAGIC)
}

/// Reads a datagram into `block`, whose memory is used again.
///
/// # Errors
/// [`SnapshotRefusal`]; `block` then has no meaning.
pub fn decode(octets: &[u8], block: &mut SnapshotBlock) -> Result<(), SnapshotRefusal> {
    if !is_snapshots(octets) || octets.get(4) != Some(&VERSION) {
        return Err(SnapshotRefusal::Foreign);
    }
    let (head, samples) = octets.split_at_checked(HEAD_OCTETS).ok_or(SnapshotRefusal::Length)?;
    let u32_at = |at: usize| u32::from_le_bytes(array(&head[at..]));
    let f64_at = |at: usize| f64::from_le_bytes(array(&head[at..]));
    let (flags, antennas) = (head[5], u16::from_le_bytes(array(&head[6..])));
    let (total, first, count) = (u32_at(12), u32_at(16), u32_at(20));
    if !(2..=ANTENNAS_MAX).contains(&antennas) {
        return Err(SnapshotRefusal::Value("number of antennas"));
    }
    let is_within = count > 0 && u64::from(first) + u64::from(count) <= u64::from(total);
    if !is_within || u64::from(total) * u64::from(antennas) > SAMPLES_MAX {
        return Err(SnapshotRefusal::Value("number of snapshots"));
    }
    if samples.len() != count as usize * usize::from(antennas) * SAMPLE_OCTETS {
        return Err(SnapshotRefusal::Length);
    }
    block.antennas = antennas;
    (block.measurement, block.total, block.first) = (u32_at(8), total, first);
    block.time_ns = i64::from_le_bytes(array(&head[24..]));
    block.frequency_hz = f64_at(32);
    let (position_m, heading_rad) = ([40, 48, 56].map(f64_at), f64_at(64));
    block.platform_m = (flags & HAS_POSITION != 0).then_some(position_m);
    block.heading_rad = (flags & HAS_HEADING != 0).then_some(heading_rad);
    block.samples.clear();
    let part = |octets: &[u8]| f32::from_le_bytes(array(octets));
    let pairs = samples.as_chunks::<SAMPLE_OCTETS>().0;
    block
        .samples
        .extend(pairs.iter().map(|pair| [part(&pair[..4]), part(&pair[4..])]));
    let unstated = |is_stated: bool, values: &[f64]| is_stated || values.iter().all(|value| value.to_bits() == 0);
    let is_clean = flags & !(HAS_POSITION | HAS_HEADING) == 0
        && unstated(block.platform_m.is_some(), &position_m)
        && unstated(block.heading_rad.is_some(), &[heading_rad]);
    if !is_clean {
        return Err(SnapshotRefusal::Value("flag"));
    }
    check(block).map_err(SnapshotRefusal::Value)
}

/// Name of a value that cannot be.
fn check(block: &SnapshotBlock) -> Result<(), &'static str> {
    if !(0..=TIME_MAX_NS).contains(&block.time_ns) {
        return Err("time");
    }
    if !(block.frequency_hz.is_finite() && block.frequency_hz > 0.0) {
        return Err("frequency");
    }
    // Comparisons with NaN are false.
    let is_place = |values: [f64; 3]| values.iter().all(|value| value.abs() < COORDINATE_MAX_M);
    if !block.platform_m.is_none_or(is_place) {
        return Err("position");
    }
    if !block.heading_rad.is_none_or(|heading_rad| heading_rad.abs() <= TAU) {
        return Err("heading");
    }
    let is_sample = |sample: &[f32; 2]| sample.iter().all(|part| part.abs() < PART_MAX);
    if !block.samples.iter().all(is_sample) {
        return Err("sample");
    }
    Ok(())
}

/// Appends the datagram of a block to `octets`.
pub fn encode(block: &SnapshotBlock, octets: &mut Vec<u8>) {
    let mut flags = 0;
    flags |= if block.platform_m.is_some() { HAS_POSITION } else { 0 };
    flags |= if block.heading_rad.is_some() { HAS_HEADING } else { 0 };
    octets.extend_from_slice(MAGIC);
    octets.extend_from_slice(&[VERSION, flags]);
    octets.extend_from_slice(&block.antennas.to_le_bytes());
    for number in [block.measurement, block.total, block.first, block.snapshots() as u32] {
        octets.extend_from_slice(&number.to_le_bytes());
    }
    octets.extend_from_slice(&block.time_ns.to_le_bytes());
    let position_m = block.platform_m.unwrap_or_default();
    let heading_rad = block.heading_rad.unwrap_or_default();
    for value in [block.frequency_hz].into_iter().chain(position_m).chain([heading_rad]) {
        octets.extend_from_slice(&value.to_le_bytes());
    }
    for part in block.samples.iter().flatten() {
        octets.extend_from_slice(&part.to_le_bytes());
    }
}

/// Passes the datagrams of a whole measurement to `each`: as many snapshots in each as fit into `octets_max` bytes, at
/// least one.
pub fn each_datagram(measurement: &SnapshotBlock, octets_max: usize, mut each: impl FnMut(&[u8])) {
    let of_snapshot = usize::from(measurement.antennas);
    let at_once = (octets_max.saturating_sub(HEAD_OCTETS) / (SAMPLE_OCTETS * of_snapshot)).max(1);
    let mut octets = Vec::with_capacity(octets_max);
    for (place, samples) in measurement.samples.chunks(at_once * of_snapshot).enumerate() {
        let part = SnapshotBlock {
            first: (place * at_once) as u32,
            samples: samples.to_vec(),
            ..*measurement
        };
        octets.clear();
        encode(&part, &mut octets);
        each(&octets);
    }
}

/// Time that a datagram of snapshots states, nanoseconds since 1970; `None` if it is none.
pub fn stated_ns(octets: &[u8]) -> Option<i64> {
    let time = octets.get(24..32).filter(|_| is_snapshots(octets))?;
    Some(i64::from_le_bytes(array(time)))
}

/// Replaces the time that a datagram of snapshots states; other bytes stay as they are.
pub fn set_time(octets: &mut [u8], time_ns: i64) {
    if stated_ns(octets).is_some() {
        octets[24..32].copy_from_slice(&time_ns.to_le_bytes());
    }
}

/// The first bytes of a slice that is long enough.
fn array<const N: usize>(octets: &[u8]) -> [u8; N] {
    std::array::from_fn(|at| octets[at])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn block() -> SnapshotBlock {
        SnapshotBlock {
            time_ns: 1_700_000_000_123_456_789,
            measurement: 7,
            total: 5,
            first: 2,
            antennas: 2,
            frequency_hz: 9.4e9,
            platform_m: Some([1.5, -2.5, 3000.0]),
            heading_rad: Some(6.1),
            samples: vec![[1.0, -2.0], [0.5, 0.25], [3.0, 4.0], [-1.0, 0.0]],
        }
    }

    fn octets(block: &SnapshotBlock) -> Vec<u8> {
        let mut octets = Vec::new();
        encode(block, &mut octets);
        octets
    }

    fn read(octets: &[u8]) -> Result<SnapshotBlock, SnapshotRefusal> {
        let mut block = SnapshotBlock::default();
        decode(octets, &mut block).map(|()| block)
    }

    /// The bytes of the table in the module's documentation.
    #[test]
    fn a_datagram_has_the_stated_bytes() {
        let octets = octets(&block());
        assert_eq!(octets.len(), HEAD_OCTETS + 4 * SAMPLE_OCTETS);
        assert_eq!(octets[..8], [b'K', b'S', b'N', b'P', 1, 3, 2, 0]);
        assert_eq!(octets[8..24], [7, 0, 0, 0, 5, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0]);
        assert_eq!(octets[24..32], 1_700_000_000_123_456_789_i64.to_le_bytes());
        assert_eq!(octets[32..40], 9.4e9_f64.to_le_bytes());
        assert_eq!(octets[56..64], 3000.0_f64.to_le_bytes());
        assert_eq!(octets[64..72], 6.1_f64.to_le_bytes());
        assert_eq!(octets[76..80], (-2.0_f32).to_le_bytes());
        assert_eq!(read(&octets), Ok(block()));
    }

    #[test]
    fn what_cannot_be_is_refused_by_reason() {
        let with = |at: usize, bytes: &[u8]| {
            let mut octets = octets(&block());
            octets[at..at + bytes.len()].copy_from_slice(bytes);
            read(&octets)
        };
        use SnapshotRefusal::{Foreign, Length, Value};
        assert_eq!(with(0, b"X"), Err(Foreign));
        assert_eq!(with(4, &[2]), Err(Foreign));
        assert_eq!(with(5, &[7]), Err(Value("flag")));
        assert_eq!(with(5, &[2]), Err(Value("flag")), "a position that is not stated");
        assert_eq!(with(6, &[1, 0]), Err(Value("number of antennas")));
        assert_eq!(with(6, &[4, 0]), Err(Length));
        assert_eq!(
            with(12, &[3, 0]),
            Err(Value("number of snapshots")),
            "beyond the measurement"
        );
        assert_eq!(
            with(12, &[0, 0, 0, 1]),
            Err(Value("number of snapshots")),
            "too large a measurement"
        );
        assert_eq!(with(20, &[0]), Err(Value("number of snapshots")));
        assert_eq!(with(24, &(-1_i64).to_le_bytes()), Err(Value("time")));
        assert_eq!(with(24, &i64::MAX.to_le_bytes()), Err(Value("time")));
        assert_eq!(with(32, &0.0_f64.to_le_bytes()), Err(Value("frequency")));
        assert_eq!(with(40, &f64::NAN.to_le_bytes()), Err(Value("position")));
        assert_eq!(with(64, &359.0_f64.to_le_bytes()), Err(Value("heading")), "degrees");
        assert_eq!(with(72, &f32::INFINITY.to_le_bytes()), Err(Value("sample")));
        let whole = octets(&block());
        for length in 5..whole.len() {
            assert_eq!(read(&whole[..length]), Err(Length), "cut after {length} bytes");
        }
        assert_eq!(read(&[&whole[..], &[0]].concat()), Err(Length));
    }

    #[test]
    fn a_time_is_replaced_and_nothing_else() {
        let mut moved = octets(&block());
        set_time(&mut moved, 5_000);
        assert_eq!(stated_ns(&moved), Some(5_000));
        let time_ns = 5_000;
        assert_eq!(read(&moved), Ok(SnapshotBlock { time_ns, ..block() }));
        let mut other = [0; 40];
        set_time(&mut other, 5_000);
        assert_eq!(other, [0; 40]);
    }

    proptest! {
        /// Bytes that are read are written again to the same bytes.
        #[test]
        fn any_bytes_are_refused_or_come_back(mut bytes in prop::collection::vec(any::<u8>(), 0..120)) {
            for (at, known) in [0, 1, 2, 3, 4].into_iter().zip(*b"KSNP\x01") {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = known;
                }
            }
            if let Ok(block) = read(&bytes) {
                prop_assert_eq!(octets(&block), bytes);
            }
        }
    }
}

//! Zstandard (RFC 8878): compression of the chunks of a recording.
//!
//! The library in C costs the build more than all other parts of a recording's writer, and a compiler of C. A recording
//! needs one level of compression only, since its messages repeat each other: headers, numbers that hardly change,
//! and fields without a value. This encoder therefore searches repetitions in two tables (`matches`), states recent
//! distances by their place in a list, and codes literals and repetitions by their frequency (`literals`, `entropy`).
//! It allocates by the size of the chunk only, and cannot fail. Decoding is the work of the crate `ruzstd`.

mod bits;
mod entropy;
mod literals;
mod matches;

use std::io::Read as _;

use bits::Bits;
use entropy::StateTable;
use matches::{Match, Matcher};
use ruzstd::decoding::StreamingDecoder;

/// Largest block, bytes.
const BLOCK: usize = 1 << 17;
/// First bytes of a frame: the magic number, and a descriptor: one segment, whose size follows in four bytes.
const BEGIN: [u8; 5] = [0x28, 0xb5, 0x2f, 0xfd, 0xa0];

/// Largest chunk, bytes: a damaged size makes a reader take no more memory.
const UNPACKED_MAX: u64 = 1 << 30;

/// Returns the `size` bytes that `packed` contains, by way of `unpacked`; or the kind of damage.
///
/// Memory follows what is unpacked, not what a damaged chunk states.
pub(crate) fn unpack<'u>(packed: &[u8], size: u64, unpacked: &'u mut Vec<u8>) -> Result<&'u [u8], &'static str> {
    if size > UNPACKED_MAX {
        return Err("the chunk states more than 1 GiB");
    }
    unpacked.clear();
    let decoder = StreamingDecoder::new(packed).map_err(|_| "the compressed data of the chunk have no beginning")?;
    decoder
        .take(size + 1)
        .read_to_end(unpacked)
        .map_err(|_| "the compressed data of the chunk contradict themselves")?;
    match unpacked.len() as u64 == size {
        true => Ok(unpacked),
        false => Err("the sizes of the chunk contradict each other"),
    }
}

/// Compressor of chunks, with tables for reuse.
#[derive(Debug, Default)]
pub(crate) struct Compressor {
    matcher: Matcher,
    sequences: Vec<Sequence>,
    literals: Vec<u8>,
}

/// Repetition as the format states it.
#[derive(Clone, Copy, Debug)]
struct Sequence {
    literals: u32,
    length: u32,
    /// 1 to 3: place in the list of recent distances; else the distance plus 3.
    distance: u32,
}

/// Recent distances, the latest first.
#[derive(Clone, Copy, Debug)]
struct Recent([u32; 3]);

impl Recent {
    /// Returns the code of a distance, and notes the distance. Without literals before the repetition, the latest
    /// distance cannot repeat, so the list begins with the second.
    fn code(&mut self, distance: u32, has_literals: bool) -> u32 {
        let [latest, second, third] = self.0;
        let candidates = match has_literals {
            true => [latest, second, third],
            false => [second, third, latest.wrapping_sub(1)],
        };
        let place = candidates.iter().position(|candidate| *candidate == distance);
        self.0 = match place.map(|place| place + usize::from(!has_literals)) {
            Some(0) => return 1,
            Some(1) => [second, latest, third],
            Some(2) => [third, latest, second],
            _ => [distance, latest, second],
        };
        place.map_or(distance + 3, |place| place as u32 + 1)
    }
}

impl Compressor {
    /// Appends `data`, at most 4 GiB, as one frame to `out`.
    pub(crate) fn compress(&mut self, data: &[u8], out: &mut Vec<u8>) {
        out.extend(BEGIN);
        out.extend((data.len() as u32).to_le_bytes());
        self.matcher.reset();
        let mut recent = Recent([1, 4, 8]);
        let mut begin = 0;
        loop {
            let end = data.len().min(begin + BLOCK);
            let before = recent;
            let block = self.block(&data[..end], begin, &mut recent);
            let is_last = u32::from(end == data.len());
            let head = |kind: u32, bytes: usize| (is_last | kind << 1 | (bytes as u32) << 3).to_le_bytes();
            if block.len() < end - begin {
                out.extend(&head(2, block.len())[..3]);
                out.extend(block);
            } else {
                recent = before;
                out.extend(&head(0, end - begin)[..3]);
                out.extend_from_slice(&data[begin..end]);
            }
            begin = end;
            if begin == data.len() {
                return;
            }
        }
    }

    /// Returns the compressed block from `begin` to the end of `data`.
    fn block(&mut self, data: &[u8], begin: usize, recent: &mut Recent) -> Vec<u8> {
        let Self {
            matcher,
            sequences,
            literals,
        } = self;
        sequences.clear();
        literals.clear();
        let mut at = begin;
        let left = matcher.find(data, begin, recent.0[0] as usize, |found: Match| {
            let literal_end = at + found.literals as usize;
            literals.extend_from_slice(&data[at..literal_end]);
            at = literal_end + found.length as usize;
            sequences.push(Sequence {
                literals: found.literals,
                length: found.length,
                distance: recent.code(found.distance, found.literals > 0),
            });
        });
        literals.extend_from_slice(&data[data.len() - left..]);
        let mut block = Vec::with_capacity(literals.len() + 4 * sequences.len());
        literals::write(literals, &mut block);
        write_sequences(sequences, &mut block);
        block
    }
}

/// Code of a number, its further bits, and their count.
#[derive(Clone, Copy, Debug, Default)]
struct Coded {
    code: u8,
    rest: u32,
    count: u32,
}

/// Number of further bits of the codes from 16 on for numbers of literals, from 32 on for lengths of repetitions.
const LITERAL_BITS: [u32; 20] = [1, 1, 1, 1, 2, 2, 3, 3, 4, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16];
const LENGTH_BITS: [u32; 21] = [1, 1, 1, 1, 2, 2, 3, 3, 4, 4, 5, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16];

/// Codes `number`: below `first` by itself, else by the ranges of widths that are powers of two.
fn coded(number: u32, first: u32, widths: &[u32]) -> Coded {
    if number < first {
        return Coded {
            code: number as u8,
            ..Coded::default()
        };
    }
    let mut begin = first;
    let mut coded = Coded::default();
    for (place, count) in widths.iter().enumerate() {
        coded = Coded {
            code: (first as usize + place) as u8,
            rest: number - begin,
            count: *count,
        };
        if number - begin < 1 << count {
            break;
        }
        begin += 1 << count;
    }
    coded
}

fn write_sequences(sequences: &[Sequence], out: &mut Vec<u8>) {
    let count = sequences.len();
    match count {
        0..128 => out.push(count as u8),
        128..0x7f00 => out.extend([(count >> 8) as u8 | 0x80, count as u8]),
        _ => out.extend([0xff, (count - 0x7f00) as u8, ((count - 0x7f00) >> 8) as u8]),
    }
    if sequences.is_empty() {
        return;
    }
    // By literals, distance and length of the repetition: the order of the tables.
    let coded: Vec<[Coded; 3]> = sequences
        .iter()
        .map(|sequence| {
            let log = sequence.distance.ilog2();
            let distance = Coded {
                code: log as u8,
                rest: sequence.distance - (1 << log),
                count: log,
            };
            let literals = coded(sequence.literals, 16, &LITERAL_BITS);
            [literals, distance, coded(sequence.length - 3, 32, &LENGTH_BITS)]
        })
        .collect();
    let mut modes = 0;
    let mut descriptions = Vec::new();
    let tables: [Option<StateTable>; 3] = std::array::from_fn(|kind| {
        let mut counts = [0u32; 64];
        coded.iter().for_each(|each| counts[usize::from(each[kind].code)] += 1);
        let table = StateTable::of(&counts, [9, 8, 9][kind]);
        modes |= if table.is_some() { 2 } else { 1 } << (6 - 2 * kind);
        match &table {
            Some(table) => descriptions.extend(table.description()),
            // One code for all.
            None => descriptions.push(coded[0][kind].code),
        }
        table
    });
    out.push(modes);
    out.extend(descriptions);
    let mut bits = Bits::default();
    let rest = |each: &[Coded; 3], bits: &mut Bits| {
        for kind in [LITERALS, LENGTH, DISTANCE] {
            bits.add(each[kind].rest, each[kind].count);
        }
    };
    let mut backwards = coded.iter().rev();
    let Some(last) = backwards.next() else { return };
    let begin = |kind: usize| tables[kind].as_ref().map(|table| table.begin(last[kind].code));
    let mut states = [begin(LITERALS), begin(DISTANCE), begin(LENGTH)];
    rest(last, &mut bits);
    for each in backwards {
        for kind in [DISTANCE, LENGTH, LITERALS] {
            if let Some(state) = &mut states[kind] {
                state.add(each[kind].code, &mut bits);
            }
        }
        rest(each, &mut bits);
    }
    let [literals, distance, length] = states;
    for state in [length, distance, literals].into_iter().flatten() {
        state.end(&mut bits);
    }
    out.extend(bits.close());
}

/// Places of the codes of a sequence.
const LITERALS: usize = 0;
const DISTANCE: usize = 1;
const LENGTH: usize = 2;

#[cfg(test)]
#[path = "tests.rs"]
mod tests;

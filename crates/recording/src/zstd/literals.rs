//! Section of literals of a block (RFC 8878, 3.1.1.3.1): bytes that repeat nothing, by a Huffman code if this is
//! shorter.

use super::bits::Bits;
use super::entropy::StateTable;

/// Longest code, bits.
const BITS_MAX: u32 = 11;
/// Fewer bytes are not worth a code.
const CODED_MIN: usize = 64;
/// Largest logarithm of the table for weights.
const WEIGHTS_LOG_MAX: u32 = 6;
/// Most weights that are stated without a code.
const PLAIN_WEIGHTS_MAX: usize = 128;

/// Appends the section for `literals`.
pub(super) fn write(literals: &[u8], out: &mut Vec<u8>) {
    match literals {
        [first, rest @ ..] if rest.len() > 3 && rest.iter().all(|byte| byte == first) => {
            head(1, literals.len(), out);
            out.push(*first);
        }
        _ => {
            let coded = (literals.len() >= CODED_MIN).then(|| coded(literals)).flatten();
            match coded {
                Some(coded) => out.extend(coded),
                None => {
                    head(0, literals.len(), out);
                    out.extend_from_slice(literals);
                }
            }
        }
    }
}

/// Appends the head of a section without a code.
fn head(kind: u32, bytes: usize, out: &mut Vec<u8>) {
    let bytes = bytes as u32;
    match bytes {
        0..32 => out.push((bytes << 3 | kind) as u8),
        32..4096 => out.extend(&(bytes << 4 | 1 << 2 | kind).to_le_bytes()[..2]),
        _ => out.extend(&(bytes << 4 | 3 << 2 | kind).to_le_bytes()[..3]),
    }
}

/// Returns the section with a code; `None` if it is no shorter.
fn coded(literals: &[u8]) -> Option<Vec<u8>> {
    let mut counts = [0u32; 256];
    literals.iter().for_each(|byte| counts[usize::from(*byte)] += 1);
    let code = Code::of(&counts)?;
    let mut data = code.description()?;
    let (form, width) = match literals.len() {
        0..1024 => (0u64, 10),
        1024..16384 => (2, 14),
        _ => (3, 18),
    };
    if form == 0 {
        data.extend(code.stream(literals));
    } else {
        let streams: Vec<_> = literals
            .chunks(literals.len().div_ceil(4))
            .map(|part| code.stream(part))
            .collect();
        for stream in &streams[..3] {
            data.extend(u16::try_from(stream.len()).ok()?.to_le_bytes());
        }
        data.extend(streams.concat());
    }
    let head_bytes = if form == 0 { 3 } else { 2 + form as usize };
    if data.len() + head_bytes >= literals.len() {
        return None;
    }
    let head = 2 | form << 2 | (literals.len() as u64) << 4 | (data.len() as u64) << (4 + width);
    let mut section = head.to_le_bytes()[..head_bytes].to_vec();
    section.extend(data);
    Some(section)
}

/// Huffman code.
#[derive(Debug)]
struct Code {
    /// Code and its length in bits, of each byte.
    codes: [(u16, u32); 256],
    /// Length of the longest code, bits.
    longest: u32,
}

impl Code {
    /// Makes the code for bytes that occur so many times; `None` for fewer than two bytes.
    fn of(counts: &[u32; 256]) -> Option<Self> {
        let lengths = lengths(counts)?;
        let longest = lengths.iter().copied().max()?;
        let mut codes = [(0, 0); 256];
        let mut next = 0;
        for length in (1..=longest).rev() {
            for (byte, _) in lengths.iter().enumerate().filter(|(_, of)| **of == length) {
                codes[byte] = (next, length);
                next += 1;
            }
            next >>= 1;
        }
        Some(Self { codes, longest })
    }

    /// Returns the weights of the bytes; `None` if they cannot be stated.
    fn description(&self) -> Option<Vec<u8>> {
        let weight = |(_, length): &(u16, u32)| match *length {
            0 => 0,
            length => (self.longest + 1 - length) as u8,
        };
        let last = self.codes.iter().rposition(|(_, length)| *length > 0)?;
        // The weight of the last byte follows from the others.
        let weights: Vec<u8> = self.codes[..last].iter().map(weight).collect();
        let by_code = coded_weights(&weights).filter(|coded| coded.len() < weights.len().div_ceil(2).min(128));
        if let Some(coded) = by_code {
            return Some([vec![coded.len() as u8], coded].concat());
        }
        if weights.len() > PLAIN_WEIGHTS_MAX {
            return None;
        }
        let mut plain = vec![127 + weights.len() as u8];
        plain.extend(weights.chunks(2).map(|pair| pair[0] << 4 | pair.get(1).unwrap_or(&0)));
        Some(plain)
    }

    /// Returns the codes of bytes, from the last to the first.
    fn stream(&self, bytes: &[u8]) -> Vec<u8> {
        let mut bits = Bits::default();
        for byte in bytes.iter().rev() {
            let (code, length) = self.codes[usize::from(*byte)];
            bits.add(code.into(), length);
        }
        bits.close()
    }
}

/// Returns weights by two states that take turns.
fn coded_weights(weights: &[u8]) -> Option<Vec<u8>> {
    let mut counts = [0u32; 16];
    weights.iter().for_each(|weight| counts[usize::from(*weight)] += 1);
    let table = StateTable::of(&counts, WEIGHTS_LOG_MAX)?;
    let [.., before, last] = weights else { return None };
    // The weights at even places belong to the first state.
    let is_last_first = weights.len() % 2 == 1;
    let mut bits = Bits::default();
    let (last, before) = (table.begin(*last), table.begin(*before));
    let [mut first, mut second] = if is_last_first { [last, before] } else { [before, last] };
    for (place, weight) in weights[..weights.len() - 2].iter().enumerate().rev() {
        match place % 2 {
            0 => first.add(*weight, &mut bits),
            _ => second.add(*weight, &mut bits),
        }
    }
    second.end(&mut bits);
    first.end(&mut bits);
    Some([table.description(), bits.close()].concat())
}

/// Returns the lengths of the codes of bytes that occur so many times, bits; `None` for fewer than two bytes.
fn lengths(counts: &[u32; 256]) -> Option<[u32; 256]> {
    let mut leaves: Vec<(u32, u8)> = (0..=255u8)
        .map(|byte| (counts[usize::from(byte)], byte))
        .filter(|(count, _)| *count > 0)
        .collect();
    if leaves.len() < 2 {
        return None;
    }
    leaves.sort_unstable();
    // The two rarest nodes are joined until one is left: leaves and joints are both in order of their counts.
    let mut joints: Vec<u64> = Vec::with_capacity(leaves.len());
    let mut parents = vec![0; 2 * leaves.len()];
    let (mut leaf, mut joint) = (0, 0);
    for parent in 0..leaves.len() - 1 {
        let mut sum = 0;
        for _ in 0..2 {
            let next_leaf = leaves.get(leaf).map(|(count, _)| u64::from(*count));
            let next_joint = joints.get(joint).copied();
            let is_leaf = next_leaf.is_some_and(|count| next_joint.is_none_or(|other| count <= other));
            if is_leaf {
                sum += next_leaf.unwrap_or(0);
                parents[leaf] = parent;
                leaf += 1;
            } else {
                sum += next_joint.unwrap_or(0);
                parents[leaves.len() + joint] = parent;
                joint += 1;
            }
        }
        joints.push(sum);
    }
    let mut depths = vec![0u32; joints.len()];
    for joint in (0..joints.len() - 1).rev() {
        depths[joint] = depths[parents[leaves.len() + joint]] + 1;
    }
    let mut lengths = [0; 256];
    let mut used = 0u32;
    for (place, (_, byte)) in leaves.iter().enumerate() {
        let length = (depths[parents[place]] + 1).min(BITS_MAX);
        lengths[usize::from(*byte)] = length;
        used += 1 << (BITS_MAX - length);
    }
    // Codes cut to the longest length need too much room: others become longer, then shorter where room is left.
    for (_, byte) in leaves.iter().cycle() {
        let length = &mut lengths[usize::from(*byte)];
        if used <= 1 << BITS_MAX {
            break;
        }
        if *length < BITS_MAX {
            *length += 1;
            used -= 1 << (BITS_MAX - *length);
        }
    }
    for (_, byte) in leaves.iter().rev() {
        let length = &mut lengths[usize::from(*byte)];
        while *length > 1 && used + (1 << (BITS_MAX - *length)) <= 1 << BITS_MAX {
            used += 1 << (BITS_MAX - *length);
            *length -= 1;
        }
    }
    Some(lengths)
}

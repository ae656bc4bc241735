//! Damaged ASTERIX blocks.

/// Numbers that depend on a seed alone: the generator SplitMix64 (G. Steele, D. Lea, C. Flood, OOPSLA 2014).
#[derive(Clone, Debug)]
pub struct Dice(u64);

impl Dice {
    /// A generator for the mutation with this number.
    pub fn new(number: u64) -> Self {
        Self(number << 32)
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    /// A whole number below `end`; 0 if there is none.
    pub fn below(&mut self, end: usize) -> usize {
        (self.bits() % end.max(1) as u64) as usize
    }

    /// One of these.
    ///
    /// # Panics
    /// If there is none.
    pub fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }
}

/// The block `source` with one to three kinds of damage: bits flipped, bytes changed or repeated, the end cut off, or
/// the end of one of `others` in its place.
pub fn mutated(source: &[u8], others: &[&[u8]], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = source.to_vec();
    for _ in 0..1 + dice.below(3) {
        let at = dice.below(bytes.len());
        match dice.below(8) {
            0 | 1 => bytes[at] ^= 1 << dice.below(8),
            2 => bytes[at] = dice.bits() as u8,
            3 => bytes[at] = dice.one_of(&[0, 1, 2, 0x7F, 0x80, 0xFE, 0xFF]), // lengths, counts, FX
            4 => {
                let end = (at + 1 + dice.below(12)).min(bytes.len());
                bytes[at..end].iter_mut().for_each(|byte| *byte |= 1); // everything goes on
            }
            5 => bytes.truncate(at.max(1)),
            6 => {
                let other = dice.one_of(others);
                bytes.truncate(at.max(1));
                bytes.extend(&other[dice.below(other.len())..]);
            }
            _ => {
                let end = at + dice.below(bytes.len() - at);
                let again = bytes[at..end].to_vec();
                bytes.splice(at..at, again);
            }
        }
    }
    // The length is made right as a rule, so that what lies behind it is read.
    if dice.below(8) > 0 && bytes.len() >= 3 {
        bytes[0] = source[0];
        let [high, low] = (bytes.len() as u16).to_be_bytes();
        bytes[1..3].copy_from_slice(&[high, low]);
    }
    bytes
}

use proptest::prelude::*;

use super::*;

/// Compresses and decompresses; returns the size in between.
fn there_and_back(compressor: &mut Compressor, data: &[u8]) -> usize {
    let (mut packed, mut unpacked) = (Vec::new(), Vec::new());
    compressor.compress(data, &mut packed);
    assert_eq!(unpack(&packed, data.len() as u64, &mut unpacked), Ok(data));
    packed.len()
}

/// Part of a chunk.
#[derive(Clone, Debug)]
enum Piece {
    /// Random bytes, so many kinds of them.
    Random(Vec<u8>, u8),
    /// A byte again and again.
    Run(u8, usize),
    /// Bytes from this place on, as a share of what there is, again.
    Again(f64, usize),
}

fn pieces() -> impl Strategy<Value = Vec<Piece>> {
    let bytes = prop_oneof![0..30usize, 0..3_000usize];
    let length = prop_oneof![0..40usize, 0..1_000usize, 0..150_000usize];
    let piece = prop_oneof![
        4 => (bytes.prop_flat_map(|count| prop::collection::vec(any::<u8>(), count)), any::<u8>())
            .prop_map(|(bytes, kinds)| Piece::Random(bytes, kinds)),
        1 => (any::<u8>(), length.clone()).prop_map(|(byte, count)| Piece::Run(byte, count)),
        4 => (0.0..1.0, length).prop_map(|(from, count)| Piece::Again(from, count)),
    ];
    prop::collection::vec(piece, 0..30)
}

fn joined(pieces: &[Piece]) -> Vec<u8> {
    let mut data = Vec::new();
    for piece in pieces {
        match piece {
            Piece::Random(bytes, kinds) => data.extend(bytes.iter().map(|byte| byte % kinds.saturating_add(1).max(1))),
            Piece::Run(byte, count) => data.extend(std::iter::repeat_n(*byte, *count)),
            Piece::Again(from, count) => {
                let from = (from * data.len() as f64) as usize;
                let end = (from + count).min(data.len());
                data.extend_from_within(from..end);
            }
        }
    }
    data
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn what_is_compressed_is_decompressed_to_the_same_bytes(pieces in prop::collection::vec(pieces(), 1..3)) {
        // The tables of one chunk do not show in the next.
        let mut compressor = Compressor::default();
        for pieces in &pieces {
            let data = joined(pieces);
            there_and_back(&mut compressor, &data);
        }
    }
}

#[test]
fn blocks_of_all_kinds_follow_each_other() {
    let mut compressor = Compressor::default();
    assert!(there_and_back(&mut compressor, &[]) < 20);
    // Numbers of a congruential generator have no repetitions: they cost a head for each block.
    let mut state = 1_u64;
    let mut random = |count: usize| -> Vec<u8> {
        let next = |_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 56) as u8
        };
        (0..count).map(next).collect()
    };
    let noise = random(BLOCK + 1_000);
    assert!((noise.len()..noise.len() + 20).contains(&there_and_back(&mut compressor, &noise)));
    // Repetitions across blocks, after a block that is stored as it is.
    let data = [&noise[..], &[7; 300_000], &noise, &noise[5_000..]].concat();
    assert!(there_and_back(&mut compressor, &data) < noise.len() + 1_000);
    // Every number of literals and every length of a repetition up to some hundreds.
    let mut data = random(400);
    for count in 1..400 {
        data.extend(random(400 - count));
        data.extend_from_within(..count);
    }
    there_and_back(&mut compressor, &data);
}

#[test]
fn damage_is_named_and_takes_no_memory() {
    let (mut packed, mut unpacked) = (Vec::new(), Vec::new());
    Compressor::default().compress(&[3; 1_000], &mut packed);
    let mut read = |packed: &[u8], size| unpack(packed, size, &mut unpacked).map(<[u8]>::len);
    assert_eq!(read(&packed, 1_000), Ok(1_000));
    assert_eq!(read(&packed, 999), Err("the sizes of the chunk contradict each other"));
    assert_eq!(
        read(&packed, 1_001),
        Err("the sizes of the chunk contradict each other")
    );
    assert_eq!(read(&packed, 1 << 31), Err("the chunk states more than 1 GiB"));
    assert_eq!(
        read(&packed[..packed.len() - 1], 1_000),
        Err("the compressed data of the chunk contradict themselves")
    );
    assert_eq!(
        read(&packed[1..], 1_000),
        Err("the compressed data of the chunk have no beginning")
    );
}

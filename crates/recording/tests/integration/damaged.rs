//! Damaged files: damaged chunks are skipped and counted, all others are read, within twice the memory of the file.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::Cursor;

use messages::layout::Sample as _;
use messages::{BatchHeader, Cue};
use recording::{Chunks, Compression, Facts, Item, RecordingError, RecordingPart, Survey, Writer, copy, facts};

/// Memory of the system, counted for each thread.
struct Counting;

thread_local! {
    static HELD: Cell<usize> = const { Cell::new(0) };
    static MOST: Cell<usize> = const { Cell::new(0) };
}

/// Any file may take so much besides twice its own size: buffers of the test, names of topics.
const CONSTANT: usize = 1 << 20;
/// A request beyond this is refused, as by a machine that has no more: a panic names it, where a real one aborts.
const MACHINE: usize = 1 << 30;
/// The contents of chunks, and what decompresses them, may take so much.
const UNPACKED: usize = 4 << 20;

#[expect(unsafe_code, reason = "an allocator cannot be had otherwise")]
// SAFETY: each call goes to the allocator of the system as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        taken(layout.size());
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        let _ = HELD.try_with(|held| held.set(held.get().saturating_sub(layout.size())));
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(at, layout) };
    }
}

#[global_allocator]
static MEMORY: Counting = Counting;

fn taken(bytes: usize) {
    let _ = HELD.try_with(|held| {
        held.set(held.get() + bytes);
        MOST.with(|most| most.set(most.get().max(held.get())));
        assert!(bytes < MACHINE, "{bytes} bytes were asked for at once");
    });
}

/// Largest memory that this thread held in `work`, beyond what it held before.
fn most_memory(work: impl FnOnce()) -> usize {
    let before = HELD.get();
    MOST.set(before);
    work();
    MOST.get() - before
}

/// Damaged parts of a file, each by its beginning and reason.
fn damage(file: &[u8]) -> Vec<String> {
    let mut found = Vec::new();
    let read = recording::read::<_, RecordingError>(&mut Cursor::new(file), |item| {
        if let Item::Damaged { bytes, reason } = item {
            found.push(format!("byte {}: {reason}", bytes.start));
        }
        Ok(())
    });
    read.unwrap();
    found
}

/// Sequence numbers of the samples that are read of a file.
fn sequences(file: &[u8]) -> Vec<u64> {
    let mut found = Vec::new();
    let read = recording::read::<_, RecordingError>(&mut Cursor::new(file), |item| {
        if let Item::Sample { octets, .. } = item {
            found.extend(Cue::of_octets(octets).map(|cue| cue.sequence));
        }
        Ok(())
    });
    read.unwrap();
    found
}

/// Reads a file in all ways that there are. First refusal, and largest memory.
fn read(file: &[u8]) -> (Result<(), RecordingError>, usize) {
    let mut first = Ok(());
    let most = most_memory(|| {
        let chunks = || {
            let mut chunks = Chunks::new(Cursor::new(file))?;
            while chunks.read::<RecordingError>(|_| Ok(()))? {}
            Ok(())
        };
        first = Survey::default()
            .add(&mut Cursor::new(file))
            .and_then(|()| chunks())
            .and_then(|()| facts(&mut Cursor::new(file)).map(drop));
    });
    let copying = most_memory(|| {
        let out = Cursor::new(Vec::new());
        let _ = copy([Cursor::new(file)], &RecordingPart::default(), out);
    });
    // The copy itself is in memory here, and a second one while its vector grows.
    (first, most.max(copying.saturating_sub(2 * file.len())))
}

fn limit(file: &[u8]) -> usize {
    2 * file.len() + CONSTANT
}

fn file(slices: u64) -> Vec<u8> {
    file_of(slices, Compression::None)
}

fn file_of(slices: u64, compression: Compression) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let facts = Facts::from([("build".to_owned(), "one".to_owned())]);
    let mut writer = Writer::compressed(&mut out, &facts, compression).unwrap();
    let channel = writer.channel("sensor/a/cues", &Cue::LAYOUT).unwrap();
    for slice in 0..slices {
        let header = BatchHeader {
            first_sequence: slice,
            ..BatchHeader::default()
        };
        let cue = Cue {
            sequence: slice,
            ..Cue::default()
        };
        writer
            .slice(channel, &header, Cue::octets(&[cue]), 1_000 + slice as i64, 5)
            .unwrap();
        if slice % 8 == 7 {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
    out.into_inner()
}

const HEAD: usize = 9;

/// Places and codes of the file's own records.
fn records(file: &[u8], from: usize, to: usize) -> Vec<(usize, u8)> {
    let mut found = Vec::new();
    let mut at = from;
    while at + HEAD <= to {
        found.push((at, file[at]));
        at += HEAD + u64::from_le_bytes(file[at + 1..at + HEAD].try_into().unwrap()) as usize;
    }
    found
}

/// Place of the first chunk, of the records in it, and of what follows it.
fn first_chunk(file: &[u8]) -> (usize, usize, usize) {
    let own = records(file, mcap::MAGIC.len(), file.len() - mcap::MAGIC.len());
    let chunk = own.iter().position(|(_, code)| *code == 6).unwrap();
    (
        own[chunk].0,
        own[chunk].0 + HEAD + 8 + 8 + 8 + 4 + 4 + 8,
        own[chunk + 1].0,
    )
}

fn with(file: &[u8], at: usize, bytes: &[u8]) -> Vec<u8> {
    let mut changed = file.to_vec();
    changed[at..at + bytes.len()].copy_from_slice(bytes);
    changed
}

const LENGTHS: [u64; 5] = [2_000_000_000, 6_000_000_000, 1 << 48, i64::MAX as u64, u64::MAX];

#[test]
fn a_chunk_with_a_length_beyond_it_is_skipped_and_named() {
    let file = file(20);
    assert!(read(&file).0.is_ok());
    let (chunk, contents, end) = first_chunk(&file);
    for (record, code) in records(&file, contents, end) {
        for length in LENGTHS {
            let mut damaged = with(&file, record + 1, &length.to_le_bytes());
            let (read_all, most) = read(&damaged);
            read_all.unwrap();
            let expected = format!("byte {chunk}: the checksum of the chunk is wrong");
            assert_eq!(damage(&damaged), [expected]);
            assert_eq!(sequences(&damaged), (8..20).collect::<Vec<_>>());
            assert!(most <= limit(&file), "code {code}, length {length}: {most} bytes");
            // Without a checksum in the chunk.
            damaged[chunk + HEAD + 24..chunk + HEAD + 28].fill(0);
            let (read_all, most) = read(&damaged);
            read_all.unwrap();
            let expected = format!("byte {chunk}: a record in the chunk is longer than the chunk");
            assert_eq!(damage(&damaged), [expected]);
            assert!(most <= limit(&file), "code {code}, length {length}: {most} bytes");
        }
    }
}

#[test]
fn lengths_of_records_chunks_and_what_describes_them_take_no_memory() {
    let file = file(20);
    let own = records(&file, mcap::MAGIC.len(), file.len() - mcap::MAGIC.len());
    let (chunk, contents, end) = first_chunk(&file);
    let mut tried = 0;
    for length in LENGTHS {
        // Of each record of the file: what follows it is cut off, as after a kill.
        let heads = own.iter().map(|(place, _)| (place + 1, 8));
        // Sizes in the header of the chunk, with and without compression; the length of the compression's name.
        let sizes = [(chunk + HEAD + 16, 8), (chunk + HEAD + 28, 4), (chunk + HEAD + 32, 8)];
        // Each field of 32 bits in descriptions within the chunk and in the metadata.
        let described = records(&file, contents, end)
            .into_iter()
            .chain(own.iter().copied())
            .filter(|(_, code)| matches!(code, 3 | 4 | 12))
            .flat_map(|(place, _)| (place + HEAD..place + HEAD + 40).map(|at| (at, 4)));
        for (at, bytes) in heads.chain(sizes).chain(described) {
            if at + bytes > file.len() {
                continue;
            }
            let mut damaged = with(&file, at, &length.to_le_bytes()[..bytes]);
            for checksum in [true, false] {
                if !checksum {
                    damaged[chunk + HEAD + 24..chunk + HEAD + 28].fill(0);
                }
                let (_, most) = read(&damaged);
                assert!(most <= limit(&file), "byte {at}, length {length}: {most} bytes");
                tried += 1;
            }
        }
    }
    assert!(tried > 500, "{tried} files");
}

/// A chunk of zstd that states and contains zeros.
fn bomb(stated: u64, contained: usize) -> Vec<u8> {
    let packed = zstd::encode_all(&vec![0; contained][..], 1).unwrap();
    let mut data = [0_u64, 0, stated].map(u64::to_le_bytes).concat();
    data.extend_from_slice(&[0; 4]);
    data.extend_from_slice(&4_u32.to_le_bytes());
    data.extend_from_slice(b"zstd");
    data.extend_from_slice(&(packed.len() as u64).to_le_bytes());
    data.extend_from_slice(&packed);
    [&[6][..], &(data.len() as u64).to_le_bytes(), &data].concat()
}

#[test]
fn chunks_that_unpack_to_much_take_bounded_memory_and_the_others_are_read() {
    /// Contents of the largest chunk that is unpacked.
    const LARGEST: usize = 16 << 20;
    let sound = file_of(64, Compression::Zstd);
    let (_, _, next) = first_chunk(&sound);
    for (stated, contained) in [
        (64 << 20, 64 << 20),
        (1 << 30, 64 << 20),
        (8 << 20, 64 << 20),
        (LARGEST as u64, LARGEST),
        (LARGEST as u64 + 1, LARGEST + 1),
    ] {
        let bombs = bomb(stated, contained).repeat(12);
        let file = [&sound[..next], &bombs, &sound[next..]].concat();
        assert!(file.len() < 2 << 20, "{}", file.len());
        let (read, most) = read(&file);
        assert!(read.is_ok(), "{read:?}");
        // A vector that grows holds its contents, and twice as much beside them.
        assert!(most < limit(&file) + 3 * LARGEST, "{stated} {contained}: {most}");
        assert_eq!(sequences(&file), (0..64).collect::<Vec<_>>(), "{stated} {contained}");
        assert!(!damage(&file).is_empty());
    }
}

#[test]
fn thousands_of_damaged_files_are_read_within_twice_their_size() {
    damage_thousands(Compression::None, CONSTANT);
}

#[test]
fn thousands_of_damaged_compressed_files_are_read_in_bounded_memory() {
    damage_thousands(Compression::Zstd, UNPACKED);
}

/// Damages files of this kind at random; each may take so much memory besides twice its own size.
fn damage_thousands(compression: Compression, constant: usize) {
    let file = file_of(40, compression);
    let (_, contents, end) = first_chunk(&file);
    let chunk = first_chunk(&file).0;
    let mut random = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = move |below: usize| {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as usize % below
    };
    let (mut refused, mut accepted) = (0, 0);
    for round in 0..6_000 {
        let mut damaged = file.clone();
        // One in two has no checksum in its first chunk, so that what is in the chunk is looked at.
        if round % 2 == 0 {
            damaged[chunk + HEAD + 24..chunk + HEAD + 28].fill(0);
        }
        for _ in 0..=next(4) {
            let length = damaged.len();
            let at = if next(3) == 0 {
                contents + next(end - contents)
            } else {
                next(length)
            }
            .min(length - 1);
            match next(5) {
                0 => damaged[at] ^= 1 << next(8),
                1 => damaged[at] = [0, 1, 127, 128, 255][next(5)],
                2 => drop(damaged.drain(at..(at + 1 + next(64)).min(length))),
                3 => {
                    let more = damaged[at..(at + 1 + next(64)).min(length)].to_vec();
                    drop(damaged.splice(at..at, more));
                }
                _ => {
                    let word = [u32::MAX, 1 << 31, i32::MAX as u32, 0][next(4)];
                    let to = (at + 4).min(length);
                    damaged[at..to].copy_from_slice(&word.to_le_bytes()[..to - at]);
                }
            }
            if damaged.len() < 64 {
                break;
            }
        }
        let (result, most) = read(&damaged);
        assert!(most <= 2 * damaged.len() + constant, "round {round}: {most} bytes");
        match result {
            Ok(()) => accepted += 1,
            Err(RecordingError::OtherKind | RecordingError::UnknownCompression(_)) => refused += 1,
            Err(error) => panic!("round {round}: {error}"),
        }
    }
    assert!(refused < 300 && accepted > 5_000, "{refused} refused, {accepted} read");
}

#[test]
fn one_flipped_bit_costs_at_most_the_chunk_that_it_is_in() {
    flip_bits(Compression::None);
}

#[test]
fn one_flipped_bit_costs_at_most_the_compressed_chunk_that_it_is_in() {
    flip_bits(Compression::Zstd);
}

fn flip_bits(compression: Compression) {
    const SLICES: u64 = 40;
    let whole = file_of(SLICES, compression);
    let magic = mcap::MAGIC.len();
    let own = records(&whole, magic, whole.len() - magic);
    let ends = own.iter().skip(1).map(|(place, _)| *place).chain([whole.len()]);
    let chunks: Vec<_> = own.iter().zip(ends).filter(|((_, code), _)| *code == 6).collect();
    assert_eq!(chunks.len() as u64, SLICES / 8);
    let mut in_chunks = 0;
    for round in 0..1_000 {
        let at = magic + round * (whole.len() - magic) / 1_000;
        let mut damaged = whole.clone();
        damaged[at] ^= 1 << (round % 8);
        let mut survey = Survey::default();
        survey.add(&mut Cursor::new(&damaged)).unwrap();
        let hit = chunks.iter().position(|((begin, _), end)| (*begin..*end).contains(&at));
        let lost = hit.map_or(0..0, |chunk| 8 * chunk as u64..8 * (chunk as u64 + 1));
        let read = sequences(&damaged);
        let beside: Vec<_> = read.iter().copied().filter(|number| !lost.contains(number)).collect();
        let expected: Vec<_> = (0..SLICES).filter(|number| !lost.contains(number)).collect();
        assert_eq!(beside, expected, "byte {at}");
        // A bit of a time in the head of a chunk changes nothing that is read.
        let is_whole = read.len() as u64 == SLICES;
        assert!(
            is_whole || survey.damaged == 1 || survey.torn == 1,
            "byte {at}: {survey:?}"
        );
        in_chunks += u64::from(hit.is_some());
        // The copy is whole again.
        let mut repaired = Cursor::new(Vec::new());
        let copied = copy([Cursor::new(&damaged)], &RecordingPart::default(), &mut repaired).unwrap();
        assert_eq!((copied.samples, copied.damaged), (read.len() as u64, survey.damaged));
        let repaired = repaired.into_inner();
        assert_eq!((damage(&repaired), sequences(&repaired)), (Vec::new(), read));
    }
    assert!(in_chunks > 250, "{in_chunks}");
}

/// Checks that all slices of a file are read but those of chunk `hit`, and that this chunk is counted.
fn check_all_but(file: &[u8], is_torn: bool, hit: Option<u64>, what: &str) {
    const SLICES: u64 = 40;
    let mut survey = Survey::default();
    survey.add(&mut Cursor::new(file)).unwrap();
    let lost = hit.map_or(0..0, |chunk| 8 * chunk..8 * chunk + 8);
    let expected: Vec<_> = (0..SLICES).filter(|number| !lost.contains(number)).collect();
    assert_eq!(sequences(file), expected, "{what}: {survey:?}");
    let is_counted = survey.damaged == 1 || (survey.torn == 1 && is_torn);
    assert!(is_counted || hit.is_none(), "{what}: {survey:?}");
}

#[test]
fn a_wrong_length_or_code_of_a_record_hides_no_chunk() {
    check_lengths_and_codes(Compression::None);
    check_lengths_and_codes(Compression::Zstd);
}

fn check_lengths_and_codes(compression: Compression) {
    const SLICES: u64 = 40;
    let ended = file_of(SLICES, compression);
    let magic = mcap::MAGIC.len();
    let own = records(&ended, magic, ended.len() - magic);
    let data_end = own.iter().find(|(_, code)| *code == 0x0f).unwrap().0;
    // A recorder that was killed writes no end.
    let killed = ended[..data_end].to_vec();
    let lengths = 0..24;
    let mut in_data = 0;
    for (place, code) in &own {
        let is_chunk = *code == 6;
        let chunk = own.iter().filter(|(other, code)| *code == 6 && other < place).count() as u64;
        // Without its first chunk, a file without an end does not describe its channels.
        let hit = is_chunk.then_some(chunk);
        for bit in lengths.clone() {
            let at = place + 1 + bit / 8;
            let what = format!("code {code} at {place}, bit {bit} of the length");
            check_all_but(&with(&ended, at, &[ended[at] ^ (1 << (bit % 8))]), true, hit, &what);
            if at < killed.len() && hit != Some(0) {
                let damaged = with(&killed, at, &[killed[at] ^ (1 << (bit % 8))]);
                check_all_but(&damaged, true, hit, &format!("{what}, no end"));
                in_data += 1;
            }
        }
        for bit in 0..8 {
            let what = format!("code {code} at {place}, bit {bit}");
            check_all_but(&with(&ended, *place, &[ended[*place] ^ (1 << bit)]), false, hit, &what);
        }
    }
    assert!(in_data > 200, "{in_data}");
}

#[test]
fn a_wrong_length_that_ends_at_the_head_of_a_later_chunk_is_found() {
    const SLICES: u64 = 40;
    let whole = file(SLICES);
    let magic = mcap::MAGIC.len();
    let own = records(&whole, magic, whole.len() - magic);
    let chunks: Vec<_> = own.iter().filter(|(_, code)| *code == 6).map(|(at, _)| *at).collect();
    let index = own.iter().find(|(_, code)| *code == 7).unwrap().0;
    let length = (chunks[3] - index - HEAD) as u64;
    let damaged = with(&whole, index + 1, &length.to_le_bytes());
    assert_eq!(
        damage(&damaged),
        [format!("byte {index}: the length of a record contradicts its contents")]
    );
    assert_eq!(sequences(&damaged), (0..SLICES).collect::<Vec<_>>());
    // A record of another program, for which no rule is known.
    let mut foreign = damaged;
    foreign[index] = 0x90;
    assert_eq!(damage(&foreign), [format!("byte {index}: a record hides a chunk")]);
    assert_eq!(sequences(&foreign), (0..SLICES).collect::<Vec<_>>());
}

#[test]
fn samples_of_channels_that_nothing_describes_are_counted() {
    let ended = file(40);
    let magic = mcap::MAGIC.len();
    let own = records(&ended, magic, ended.len() - magic);
    let data_end = own.iter().find(|(_, code)| *code == 0x0f).unwrap().0;
    let (chunk, contents, _) = first_chunk(&ended);
    let mut damaged = ended[..data_end].to_vec();
    damaged[contents + 20] ^= 1;
    let found = damage(&damaged);
    assert_eq!(found.len(), 5, "{found:?}");
    assert_eq!(found[0], format!("byte {chunk}: the checksum of the chunk is wrong"));
    let undescribed = ": no readable chunk describes the channels of its samples";
    assert!(
        found[1..].iter().all(|reason| reason.ends_with(undescribed)),
        "{found:?}"
    );
    let copied = copy(
        [Cursor::new(&damaged)],
        &RecordingPart::default(),
        Cursor::new(Vec::new()),
    );
    let copied = copied.unwrap();
    assert_eq!((copied.samples, copied.damaged), (0, 5));
}

/// A file that counts the calls.
struct Counted<'a>(Cursor<&'a [u8]>, u64);

impl std::io::Read for Counted<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        self.1 += 1;
        self.0.read(bytes)
    }
}

impl std::io::Seek for Counted<'_> {
    fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
        self.1 += 1;
        self.0.seek(to)
    }
}

#[test]
fn the_work_grows_with_the_damage_and_not_with_its_square() {
    let calls = |slices: u64| {
        let mut damaged = file(slices);
        let magic = mcap::MAGIC.len();
        let own = records(&damaged, magic, damaged.len() - magic);
        for (place, _) in own.iter().filter(|(_, code)| *code == 6) {
            damaged[place + 80] ^= 1;
        }
        let mut survey = Survey::default();
        let mut counted = Counted(Cursor::new(&damaged), 0);
        survey.add(&mut counted).unwrap();
        assert_eq!(survey.damaged, slices / 8);
        counted.1
    };
    let (few, many) = (calls(80), calls(800));
    assert!(many < 12 * few, "{few} calls for 10 chunks, {many} for 100");
}

#[test]
fn a_part_counts_only_the_damage_within_it() {
    let whole = file(40);
    let magic = mcap::MAGIC.len();
    let own = records(&whole, magic, whole.len() - magic);
    let chunks: Vec<_> = own.iter().filter(|(_, code)| *code == 6).map(|(at, _)| *at).collect();
    // Slices are taken at 1000 + their number, eight a chunk.
    for (from, to, expected) in [
        (None, None, 1),
        (Some(1_010), Some(1_020), 1),
        (Some(1_017), None, 1),
        (None, Some(1_016), 1),
        (Some(1_026), None, 0),
        (None, Some(1_012), 0),
        (Some(1_026), Some(1_030), 0),
    ] {
        let part = RecordingPart {
            from_ns: from,
            to_ns: to,
            ..RecordingPart::default()
        };
        let damaged = with(&whole, chunks[2] + 80, &[!whole[chunks[2] + 80]]);
        let copied = copy([Cursor::new(&damaged)], &part, Cursor::new(Vec::new())).unwrap();
        assert_eq!(copied.damaged, expected, "{from:?} to {to:?}");
        assert_eq!(copied.damaged_bytes > 0, expected > 0);
    }
}

#[test]
fn a_file_of_another_kind_and_a_topic_that_is_not_there_are_refused() {
    let text = Survey::default().add(&mut Cursor::new(b"time_s,x\n1,2\n")).unwrap_err();
    assert!(matches!(text, RecordingError::OtherKind), "{text}");
    // What a recorder leaves that is killed at once.
    for begin in [0, 5] {
        Survey::default().add(&mut Cursor::new(&mcap::MAGIC[..begin])).unwrap();
    }
    for wanted in ["sensor/b", "sensor/a/cue"] {
        let part = RecordingPart {
            topics: vec!["sensor/a".to_owned(), wanted.to_owned()],
            ..RecordingPart::default()
        };
        let refused = copy([Cursor::new(file(8))], &part, Cursor::new(Vec::new())).unwrap_err();
        assert_eq!(
            refused.to_string(),
            format!("has no topic {wanted}; its topics: sensor/a/cues")
        );
    }
}

#[test]
fn one_chunk_of_a_whole_file_is_held_once() {
    let mut out = Cursor::new(Vec::new());
    let mut writer = Writer::begin(&mut out, &Facts::new()).unwrap();
    let channel = writer.channel("sensor/a/cues", &Cue::LAYOUT).unwrap();
    let cues = vec![Cue::default(); 200_000];
    writer
        .slice(channel, &BatchHeader::default(), Cue::octets(&cues), 1, 1)
        .unwrap();
    writer.finish().unwrap();
    let file = out.into_inner();
    let most = most_memory(|| Survey::default().add(&mut Cursor::new(&file)).unwrap());
    assert!(
        most <= file.len() + CONSTANT,
        "{most} bytes for a file of {}",
        file.len()
    );
}

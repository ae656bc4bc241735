//! Files that are written, cut anywhere, and read again.

use std::io::Cursor;

use messages::layout::Sample as _;
use messages::{BatchHeader, Cue, Health};
use proptest::prelude::*;
use recording::{Chunks, Facts, Item, RecordingError, RecordingPart, Survey, Tally, Writer, closing, copy, whole};

const TOPIC: &str = "sensor/a/cues";

/// A file of slices with these numbers of samples, and its length and samples after each flush, which is every third
/// slice.
fn file(slices: &[usize], is_finished: bool) -> (Vec<u8>, Vec<(usize, u64)>) {
    let (mut bytes, mut first, mut flushed) = (Shared::default(), 0, Vec::new());
    let facts = Facts::from([("build".to_owned(), "one".to_owned())]);
    let mut writer = Writer::begin(bytes.clone(), &facts).unwrap();
    let channel = writer.channel(TOPIC, &Cue::LAYOUT).unwrap();
    writer.channel("health", &Health::LAYOUT).unwrap();
    for (index, count) in slices.iter().enumerate() {
        let header = BatchHeader {
            first_sequence: first,
            ..BatchHeader::default()
        };
        let sample = |number: usize| Cue {
            sequence: first + number as u64,
            ..Cue::default()
        };
        let samples: Vec<Cue> = (0..*count).map(sample).collect();
        writer
            .slice(channel, &header, Cue::octets(&samples), 1_000 + index as i64, 5)
            .unwrap();
        first += *count as u64;
        if index % 3 == 2 {
            writer.flush().unwrap();
            flushed.push((bytes.len(), first));
        }
    }
    if is_finished {
        writer.finish().unwrap();
    } else {
        // Killed: what it would still write is nowhere.
        let before = bytes.len();
        drop(writer);
        bytes.truncate(before);
    }
    (bytes.bytes(), flushed)
}

/// Bytes that the test sees while they are written.
#[derive(Clone, Default)]
struct Shared(std::rc::Rc<std::cell::RefCell<Cursor<Vec<u8>>>>);

impl Shared {
    fn len(&self) -> usize {
        self.0.borrow().get_ref().len()
    }

    fn truncate(&mut self, length: usize) {
        self.0.borrow_mut().get_mut().truncate(length);
    }

    fn bytes(&self) -> Vec<u8> {
        self.0.borrow().get_ref().clone()
    }
}

impl std::io::Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl std::io::Seek for Shared {
    fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
        self.0.borrow_mut().seek(to)
    }
}

fn survey(files: &[&[u8]]) -> Survey {
    let mut survey = Survey::default();
    for file in files {
        survey.add(&mut Cursor::new(file)).unwrap();
    }
    survey
}

/// What a reader that asks for a proper end makes of a file: the data of its messages.
fn messages_of(file: &[u8]) -> Vec<Vec<u8>> {
    let stream = mcap::MessageStream::new(file).unwrap();
    stream.map(|message| message.unwrap().data.into_owned()).collect()
}

#[test]
fn what_is_written_is_read_again() {
    let (file, _) = file(&[2, 0, 3, 1], true);
    let found = survey(&[&file]);
    assert_eq!((found.torn, found.facts["build"].as_str()), (0, "one"));
    let topic = &found.topics[TOPIC];
    assert_eq!((topic.slices, topic.samples, topic.tally.lost), (4, 6, 0));
    assert_eq!((topic.first_ns, topic.last_ns), (Some(1_000), Some(1_003)));
    assert_eq!(topic.schema, "koseki/msg/Cue");
    assert_eq!(found.topics["health"].slices, 0);
    let numbers = messages_of(&file)
        .into_iter()
        .filter_map(|data| Cue::of_octets(&data[4..]));
    assert_eq!(numbers.map(|cue| cue.sequence).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5]);
}

/// Numbers of the samples in the next chunk; `None` at the end.
fn chunk(chunks: &mut Chunks<Cursor<&Vec<u8>>>) -> Option<Vec<u64>> {
    let mut numbers = Vec::new();
    let is_there = chunks.read::<RecordingError>(|item| {
        if let Item::Sample { octets, .. } = item {
            numbers.push(Cue::of_octets(octets).unwrap().sequence);
        }
        Ok(())
    });
    is_there.unwrap().then_some(numbers)
}

#[test]
fn chunks_are_read_in_any_order_also_where_the_end_is_missing() {
    for is_finished in [true, false] {
        let (mut file, _) = file(&[1, 1, 1, 2, 0, 1, 1, 1, 1], is_finished);
        file.extend([6, 1].repeat(usize::from(!is_finished)));
        let mut chunks = Chunks::new(Cursor::new(&file)).unwrap();
        let mut read = Vec::new();
        loop {
            let place = chunks.place();
            let Some(numbers) = chunk(&mut chunks) else { break };
            read.push((place, numbers));
        }
        let numbers: Vec<_> = read.iter().map(|(_, numbers)| numbers.clone()).collect();
        assert_eq!(numbers, [vec![0, 1, 2], vec![3, 4, 5], vec![6, 7, 8]]);
        let mut beside = chunks.beside(Cursor::new(&file));
        for (place, numbers) in read.into_iter().rev() {
            for chunks in [&mut chunks, &mut beside] {
                chunks.go_to(place);
                assert_eq!(chunk(chunks), Some(numbers.clone()));
            }
        }
    }
}

/// Bytes of the samples on all topics.
fn samples_of(file: &[u8]) -> Vec<(String, Vec<u8>)> {
    let stream = mcap::MessageStream::new(file).unwrap();
    let messages = stream.map(|message| message.unwrap());
    messages
        .map(|message| (message.channel.topic.clone(), message.data.into_owned()))
        .collect()
}

fn copied(files: &[&[u8]], part: &RecordingPart) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let copied = copy(files.iter().map(Cursor::new), part, &mut out).unwrap();
    let out = out.into_inner();
    let survey = survey(&[&out]);
    assert_eq!(
        copied.samples,
        survey.topics.values().map(|topic| topic.samples).sum::<u64>()
    );
    out
}

#[test]
fn a_part_has_the_same_messages_and_counts_what_it_lacks_but_not_what_was_left_out() {
    let (whole, _) = file(&[2, 0, 3, 1, 4], true);
    assert_eq!(
        samples_of(&copied(&[&whole], &RecordingPart::default())),
        samples_of(&whole)
    );
    let part = RecordingPart {
        from_ns: Some(1_002),
        to_ns: Some(1_003),
        topics: vec!["sensor/a".to_owned()],
        ..RecordingPart::default()
    };
    let cut = copied(&[&whole], &part);
    // Before them are two headers with two samples; after them one with four.
    assert_eq!(samples_of(&cut), samples_of(&whole)[4..10]);
    let found = survey(&[&cut]);
    assert_eq!(found.facts["build"], "one");
    let topic = &found.topics[TOPIC];
    assert_eq!((topic.samples, topic.tally.lost, topic.first_ns), (4, 0, Some(1_002)));
    for (topics, samples) in [(&["sensor"][..], 10), (&["sensor/a"], 10), (&["health", TOPIC], 10)] {
        let topics = topics.iter().map(|name| (*name).to_owned()).collect();
        let part = RecordingPart {
            topics,
            ..RecordingPart::default()
        };
        assert_eq!(
            survey(&[&copied(&[&whole], &part)])
                .topics
                .get(TOPIC)
                .map_or(0, |topic| topic.samples),
            samples
        );
    }
}

#[test]
fn one_file_of_several_counts_what_was_lost_between_them() {
    let (first, _) = file(&[2, 1], true);
    let mut tally = Tally::since(TOPIC, 0);
    let mut facts = Facts::new();
    tally.slice(&BatchHeader::default(), 3);
    tally.state(TOPIC, &mut facts);
    let bytes = Shared::default();
    let mut writer = Writer::begin(bytes.clone(), &facts).unwrap();
    let channel = writer.channel(TOPIC, &Cue::LAYOUT).unwrap();
    let header = BatchHeader {
        first_sequence: 8,
        ..BatchHeader::default()
    };
    writer
        .slice(channel, &header, Cue::octets(&[Cue::default()]), 2_000, 5)
        .unwrap();
    writer.finish().unwrap();
    let files = [&first[..], &bytes.bytes()];
    let merged = copied(&files, &RecordingPart::default());
    let (one, several) = (survey(&[&merged]), survey(&files));
    let lost = |survey: &Survey| (survey.topics[TOPIC].samples, survey.topics[TOPIC].tally.lost);
    assert_eq!((lost(&one), lost(&several)), ((4, 5), (4, 5)));
}

#[test]
fn times_in_which_nothing_was_taken_are_gaps_within_a_file_and_between_files() {
    let taken = |times_ms: &[i64]| {
        let bytes = Shared::default();
        let mut writer = Writer::begin(bytes.clone(), &Facts::new()).unwrap();
        let channel = writer.channel(TOPIC, &Cue::LAYOUT).unwrap();
        for time_ms in times_ms {
            let header = BatchHeader::default();
            writer.slice(channel, &header, &[], time_ms * 1_000_000, 5).unwrap();
        }
        writer.finish().unwrap();
        bytes.bytes()
    };
    let files = [taken(&[1_000, 1_200, 1_800]), taken(&[4_000, 4_650, 6_000])];
    let gaps = survey(&[&files[0], &files[1]]).gaps_ns;
    let ms = gaps.iter().map(|gap| gap.map(|time_ns| time_ns / 1_000_000));
    assert_eq!(ms.collect::<Vec<_>>(), [[1_800, 4_000], [4_650, 6_000]]);
}

#[test]
fn what_no_recorder_wrote_is_nothing() {
    for bytes in [&b""[..], b"MCAP", b"time_s,sensor_id\n1,2\n"] {
        assert_eq!(whole(&mut Cursor::new(bytes)).unwrap().bytes, 0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_file_that_is_cut_anywhere_holds_what_was_flushed_before(
        slices in prop::collection::vec(0_usize..5, 3..40),
        part in 0.0_f64..1.0,
        is_finished: bool,
    ) {
        let (bytes, flushed) = file(&slices, is_finished);
        let cut = &bytes[..(part * bytes.len() as f64) as usize];
        let found = whole(&mut Cursor::new(cut)).unwrap();
        prop_assert!(found.bytes <= cut.len() as u64 && !found.is_ended);
        if found.bytes == 0 {
            return Ok(());
        }
        let samples = survey(&[cut]).topics.get(TOPIC).map_or(0, |topic| topic.samples);
        let expected = flushed.iter().rfind(|(length, _)| *length <= cut.len());
        prop_assert!(samples >= expected.map_or(0, |(_, samples)| *samples));
        let mended = [&cut[..found.bytes as usize], &closing()].concat();
        prop_assert!(whole(&mut Cursor::new(&mended)).unwrap().is_ended);
        let of_cues = messages_of(&mended).iter().filter(|data| Cue::of_octets(&data[4..]).is_some()).count();
        prop_assert_eq!(of_cues as u64, samples);
    }
}

//! Blocks and frames made by hand, and what a recording of them gives.

use asterix::{Edition, registry};
use formats::recording::{RecordingBytes, RecordingSurvey};

/// A data block.
pub(crate) fn block(category: u8, records: &[Vec<u8>]) -> Vec<u8> {
    let body = records.concat();
    let mut bytes = vec![category];
    bytes.extend((body.len() as u16 + 3).to_be_bytes());
    bytes.extend(body);
    bytes
}

/// A CAT010 record: I010/010 is 0/7, I010/000 says target report, I010/140 is the time in 1/128 s.
pub(crate) fn report(time_128: u32) -> Vec<u8> {
    let time = time_128.to_be_bytes();
    vec![0b1101_0000, 0, 7, 1, time[1], time[2], time[3]]
}

/// A record that runs off its block in I010/140.
pub(crate) fn cut() -> Vec<u8> {
    report(0)[..5].to_vec()
}

/// A CAT021 record of ed 0.23: source 0/107, descriptor, time of day. By ed 2.4 its last bytes are a record without
/// end.
pub(crate) fn early_report() -> Vec<u8> {
    vec![0b1110_0000, 0, 107, 0, 0, 0x9A, 0xB0, 0]
}

/// A frame of the final format.
pub(crate) fn frame(hundredths: u32, payload: &[u8]) -> Vec<u8> {
    let mut bytes = (payload.len() as u16 + 12).to_be_bytes().to_vec();
    bytes.extend([0; 2]);
    bytes.extend(hundredths.to_be_bytes());
    bytes.extend(payload);
    bytes.extend([0xA5; 4]);
    bytes
}

/// The survey, and for each record given its category, its offset, and the second in which it was recorded.
pub(crate) fn read(recording: &RecordingBytes<'_>) -> (RecordingSurvey, Vec<(u8, usize, Option<f64>)>) {
    let survey = recording.survey();
    let mut given = Vec::new();
    let visited = recording.for_each(&survey, |found| {
        let seconds = found.time_stamp.map(|stamp| stamp.seconds());
        given.push((found.record.table().number, found.record.offset(), seconds));
        Ok::<(), ()>(())
    });
    assert_eq!(visited, Ok(()));
    let believed = survey.categories.values().filter(|category| !category.is_withheld());
    assert_eq!(
        believed.map(|category| category.records).sum::<u64>(),
        given.len() as u64
    );
    (survey, given)
}

/// The recording, with one category in another edition than the default.
pub(crate) fn in_edition(bytes: &[u8], category: u8, major: u8, minor: u8) -> RecordingBytes<'_> {
    RecordingBytes::new(bytes).with_table(registry::find(category, Edition::new(major, minor)).unwrap())
}

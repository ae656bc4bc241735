//! Who sent how much, and when.

use formats::recording::{Rate, RecordSender, RecordingBytes, SenderSummary, Statistics};

use super::forge::{block, frame, report};

fn gather(bytes: &[u8]) -> Vec<SenderSummary> {
    let recording = RecordingBytes::new(bytes);
    let mut statistics = Statistics::default();
    let visited = recording.for_each(&recording.survey(), |found| {
        statistics.add(found.record, found.time_stamp);
        Ok::<(), ()>(())
    });
    assert_eq!(visited, Ok(()));
    statistics.senders().collect()
}

/// Blocks of one report each, at these times in s.
fn reports(times_s: &[f64]) -> Vec<u8> {
    let blocks = times_s
        .iter()
        .map(|time_s| block(10, &[report((time_s * 128.0) as u32)]));
    blocks.flatten().collect()
}

fn rate(times_s: &[f64]) -> Rate {
    gather(&reports(times_s))[0].rate.unwrap()
}

#[test]
fn silent_seconds_count_and_those_at_the_ends_do_not() {
    // Seconds 10 to 15 with 1, 3, 0, 2, 2, 5 reports; the first and the last are left out.
    let times = [
        10.9, 11.0, 11.2, 11.9, 13.0, 13.5, 14.0, 14.1, 15.0, 15.0, 15.0, 15.0, 15.1,
    ];
    let expected = Rate {
        min: 0,
        median: 2,
        max: 3,
    };
    assert_eq!(rate(&times), expected);
}

#[test]
fn where_there_are_two_seconds_at_most_they_count() {
    let same = |count| Rate {
        min: count,
        median: count,
        max: count,
    };
    assert_eq!(rate(&[5.0]), same(1));
    assert_eq!(rate(&[5.0, 5.5]), same(2));
    let two = Rate {
        min: 1,
        median: 1,
        max: 2,
    };
    assert_eq!(rate(&[5.0, 6.0, 6.5]), two);
    // Three seconds of which the one that counts is silent.
    assert_eq!(rate(&[5.0, 7.0]), same(0));
}

#[test]
fn times_go_on_over_midnight_and_late_reports_stay_on_their_day() {
    let found = gather(&reports(&[86_399.5, 0.25, 86_399.75, 61.0]));
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].first_s, found[0].last_s), (Some(86_399.5), Some(86_461.0)));
    // Seconds 86,400 to 86,460, of which 60 are silent.
    let expected = Rate {
        min: 0,
        median: 0,
        max: 1,
    };
    assert_eq!(found[0].rate, Some(expected));
}

#[test]
fn senders_are_told_apart_by_category_and_source() {
    let other_source = vec![0b1101_0000, 0, 8, 1, 0, 0, 128];
    let service = vec![0b1000_0000, 0, 7];
    let without_source = vec![0b0101_0000, 1, 0, 0, 128];
    let bytes = block(10, &[report(0), other_source, without_source, report(1)]);
    let found = gather(&[bytes, block(19, &[service])].concat());
    let senders: Vec<_> = found.iter().map(|summary| (summary.sender, summary.records)).collect();
    let sender = |category, source| RecordSender { category, source };
    let expected = [
        (sender(10, None), 1),
        (sender(10, Some((0, 7))), 2),
        (sender(10, Some((0, 8))), 1),
        (sender(19, Some((0, 7))), 1),
    ];
    assert_eq!(senders, expected);
    // The service message has no time, and raw blocks neither.
    assert_eq!((found[3].first_s, found[3].rate), (None, None));
}

/// The record's own time counts; where it has none, the time of the recording does.
#[test]
fn the_time_of_the_recording_stands_in() {
    let service = vec![0b1000_0000, 0, 7];
    let bytes = [
        frame(50_000, &block(10, &[report(128 * 400)])),
        frame(50_125, &block(19, &[service])),
    ]
    .concat();
    let found = gather(&bytes);
    assert_eq!((found[0].first_s, found[1].first_s), (Some(400.0), Some(501.25)));
}

//! Which records of a recording are given, and what is said about the others.

use asterix::{Edition, Mode};
use formats::containers::Container;
use formats::recording::RecordingBytes;
use proptest::collection::vec;
use proptest::prelude::*;

use super::forge::{block, cut, early_report, frame, in_edition, read, report};

#[test]
fn records_come_in_order_with_their_offset_and_time() {
    let bytes = [
        frame(100, &block(10, &[report(0), report(1)])),
        frame(250, &[block(10, &[report(2)]), block(10, &[report(3)])].concat()),
    ]
    .concat();
    let (survey, given) = read(&RecordingBytes::new(&bytes));
    // Header of the frame, header of the block; the second frame begins at 29.
    let expected = [
        (10, 11, Some(1.0)),
        (10, 18, Some(1.0)),
        (10, 40, Some(2.5)),
        (10, 50, Some(2.5)),
    ];
    assert_eq!(given, expected);
    assert_eq!((survey.container, survey.unpacked.datagrams), (Container::Final, 2));
    assert_eq!((survey.blocks(), survey.categories[&10].records), (3, 4));
    assert!(survey.refusals.by_count().is_empty());
}

/// The first record of the second block is as good as any, and still not given.
#[test]
fn a_block_is_given_as_a_whole_or_not_at_all() {
    let bytes = [
        block(10, &[report(0)]),
        block(10, &[report(1), cut()]),
        block(10, &[report(2)]),
    ]
    .concat();
    let (survey, given) = read(&RecordingBytes::new(&bytes));
    assert_eq!(given, [(10, 3, None), (10, 28, None)]);
    let category = &survey.categories[&10];
    assert_eq!((category.blocks, category.blocks_refused, category.records), (3, 1, 2));
    let refusals = survey.refusals.by_count();
    assert_eq!(refusals.len(), 1);
    let refusal = refusals[0];
    assert_eq!((refusal.category, refusal.item), (Some(10), Some("140")));
    assert_eq!((refusal.count, refusal.octets, refusal.first_offset), (1, 15, 24));
    assert!(
        refusal.first.starts_with("byte 24: I010/140 takes"),
        "{}",
        refusal.first
    );
}

#[test]
fn a_category_is_given_if_half_of_its_blocks_fit() {
    let (good, bad) = (block(10, &[report(0)]), block(10, &[cut()]));
    let other = block(19, &[vec![0b1000_0000, 0, 107]]);
    let half = [good.clone(), bad.clone(), other.clone()].concat();
    let (survey, given) = read(&RecordingBytes::new(&half));
    assert!(!survey.categories[&10].is_withheld());
    assert_eq!(given.len(), 2);
    let less = [half, bad].concat();
    let (survey, given) = read(&RecordingBytes::new(&less));
    assert!(survey.categories[&10].is_withheld());
    // The other category is not to blame.
    assert_eq!(given, [(19, good.len() + 8 + 3, None)]);
}

#[test]
fn the_editions_that_fit_are_named() {
    let bytes = block(21, &[early_report()]).repeat(3);
    let (survey, given) = read(&RecordingBytes::new(&bytes));
    assert_eq!(given, []);
    let category = &survey.categories[&21];
    assert_eq!(
        (category.edition, category.is_withheld()),
        (Some(Edition::new(2, 4)), true)
    );
    let (editions, blocks) = category.better().unwrap();
    assert!(editions.contains(&Edition::new(0, 23)), "{editions:?}");
    assert!(editions.iter().all(|edition| edition.major == 0), "{editions:?}");
    assert_eq!(blocks, 3);
    let (survey, given) = read(&in_edition(&bytes, 21, 0, 23));
    assert_eq!((given.len(), survey.categories[&21].better()), (3, None));
}

/// Fits ed 2.4 with a latitude of 217°, and ed 0.24 to 0.26 with one of 41.3°.
#[test]
fn an_impossible_latitude_counts_against_the_edition_unless_the_caller_has_chosen_it() {
    let report = vec![
        0b1101_0010,
        0,
        107,
        1,
        1,
        0x00,
        0x75,
        0x4D,
        0x10,
        0x00,
        0x06,
        0x10,
        0x00,
        0x00,
        0x00,
    ];
    let bytes = block(21, &[report]).repeat(2);
    let (survey, given) = read(&RecordingBytes::new(&bytes));
    let category = &survey.categories[&21];
    assert_eq!((category.is_withheld(), given.len()), (true, 0));
    let (editions, blocks) = category.better().unwrap();
    assert_eq!(
        (editions.contains(&Edition::new(0, 26)), blocks),
        (true, 2),
        "{editions:?}"
    );
    let refusal = survey.refusals.by_count()[0];
    assert_eq!(refusal.reason, "impossible latitude");
    assert!(
        refusal.first.contains("latitude 217°, the limit is 90°"),
        "{}",
        refusal.first
    );
    let (survey, given) = read(&in_edition(&bytes, 21, 0, 26));
    assert_eq!((survey.categories[&21].is_withheld(), given.len()), (false, 2));
    let (survey, given) = read(&in_edition(&bytes, 21, 2, 4));
    assert_eq!((survey.categories[&21].is_withheld(), given.len()), (false, 2));
}

#[test]
fn where_no_edition_fits_none_is_named() {
    let bytes = block(21, &[vec![0xFF; 4]]);
    let (survey, _) = read(&RecordingBytes::new(&bytes));
    assert!(survey.categories[&21].is_withheld());
    assert_eq!(survey.categories[&21].better(), None);
}

#[test]
fn categories_without_a_table_are_counted() {
    let bytes = [block(250, &[vec![1, 2]]), block(10, &[report(0)])].concat();
    let (survey, given) = read(&RecordingBytes::new(&bytes));
    assert_eq!(given.len(), 1);
    let category = &survey.categories[&250];
    assert_eq!(
        (category.edition, category.blocks, category.is_withheld()),
        (None, 1, true)
    );
    assert_eq!((category.better(), category.others.len()), (None, 0));
    assert_eq!(survey.refusals.by_count()[0].reason, "no table of the category");
    assert!(!survey.is_mostly_without_table());
    // Radar video is known by its name.
    let named = |bodies: [Vec<u8>; 2]| {
        let bytes = [block(240, &bodies[..1]), block(250, &bodies[1..])].concat();
        read(&RecordingBytes::new(&bytes)).0.is_mostly_without_table()
    };
    assert!(named([vec![1; 9], vec![1]]) && !named([vec![1], vec![1; 9]]));
}

#[test]
fn strictness_is_asked_of_every_block() {
    // I010/161 with a spare bit set, and a record without.
    let spare = vec![0b1000_0001, 0b0010_0000, 0, 7, 0x80, 1];
    let bytes = [block(10, &[spare]), block(10, &[report(0)])].concat();
    assert_eq!(read(&RecordingBytes::new(&bytes)).1.len(), 2);
    let (survey, given) = read(&RecordingBytes::new(&bytes).with_mode(Mode::Strict));
    assert_eq!(given.len(), 1);
    assert_eq!(survey.refusals.by_count()[0].reason, "spare bit set");
}

/// The most frequent reason comes first; what is no block and what is no frame are among them.
#[test]
fn refusals_are_counted_by_reason() {
    let mut bytes = frame(0, &[block(10, &[report(0)]), vec![10, 0, 2]].concat());
    bytes.extend(frame(0, &block(10, &[cut()])).repeat(2));
    bytes.extend([0, 40, 0]);
    let (survey, _) = read(&RecordingBytes::new(&bytes));
    let found: Vec<_> = survey
        .refusals
        .by_count()
        .iter()
        .map(|refusal| (refusal.count, refusal.category, refusal.reason, refusal.first_offset))
        .collect();
    let expected = [
        (2, Some(10), "item cut", 25 + 8 + 3 + 4),
        (1, None, "recording cut short", 25 + 2 * 20),
        (1, Some(10), "impossible block length", 18),
    ];
    assert_eq!(found, expected);
}

#[test]
fn the_kind_can_be_given() {
    let bytes = frame(0, &block(10, &[report(0)]));
    let (survey, given) = read(&RecordingBytes::new(&bytes).in_container(Container::Raw));
    assert_eq!((survey.container, given.len()), (Container::Raw, 0));
}

#[test]
fn a_visitor_can_end_it() {
    let bytes = block(10, &[report(0), report(1)]);
    let recording = RecordingBytes::new(&bytes);
    let mut visits = 0;
    let ended = recording.for_each(&recording.survey(), |_| {
        visits += 1;
        Err("enough")
    });
    assert_eq!((ended, visits), (Err("enough"), 1));
}

proptest! {
    #[test]
    fn any_bytes_are_surveyed_and_read_to_their_end(
        bodies in vec((prop::sample::select(vec![10, 19, 20, 21, 34, 48, 62, 250]), vec(any::<u8>(), 0..60)), 0..8),
        tail in vec(any::<u8>(), 0..6),
    ) {
        let blocks: Vec<u8> = bodies.iter().flat_map(|(category, body)| block(*category, std::slice::from_ref(body))).collect();
        read(&RecordingBytes::new(&[blocks, tail].concat()));
    }
}

//! Recordings of real sensors: what is given of them, and that nothing is made up.

use asterix::Edition;
use formats::recording::{RecordingBytes, Statistics};
use test_support::recording;

use super::forge::{in_edition, read};

#[test]
fn seven_radars() {
    let Some(bytes) = recording("cro/cat_034_048.pcap") else {
        return;
    };
    let recording = RecordingBytes::new(&bytes);
    let (survey, given) = read(&recording);
    assert_eq!((survey.blocks(), given.len()), (120, 162));
    assert!(survey.refusals.by_count().is_empty());
    assert!(
        given
            .iter()
            .all(|(_, _, second)| second.unwrap().floor() == 1_462_433_756.0)
    );
    let mut statistics = Statistics::default();
    let visited = recording.for_each(&survey, |found| {
        statistics.add(found.record, found.time_stamp);
        Ok::<(), ()>(())
    });
    assert_eq!(visited, Ok(()));
    let of = |category| move |found: &&_| sender_is(found, category);
    let senders: Vec<_> = statistics.senders().collect();
    assert_eq!(
        (
            senders.iter().filter(of(34)).count(),
            senders.iter().filter(of(48)).count()
        ),
        (7, 7)
    );
}

fn sender_is(found: &formats::recording::SenderSummary, category: u8) -> bool {
    found.sender.category == category
}

/// Tracks by an edition of CAT062 from before 1.0: some blocks fit by accident, and no record of it is given.
#[test]
fn system_tracks_of_an_edition_that_nobody_knows() {
    let Some(bytes) = recording("cro/asterix.pcap") else {
        return;
    };
    let (survey, given) = read(&RecordingBytes::new(&bytes));
    let category = &survey.categories[&62];
    assert_eq!((survey.blocks(), given.len()), (100, 0));
    assert!(
        category.blocks_refused < 100,
        "some do fit: that is what the rule is for"
    );
    assert!(category.is_withheld());
    assert_eq!(category.better(), None);
}

#[test]
fn ads_b_of_another_edition_than_the_default() {
    let Some(bytes) = recording("lebl2016/160510-lebl-220001_ADSB_cat21_v023.ast") else {
        return;
    };
    let (survey, given) = read(&RecordingBytes::new(&bytes));
    let category = &survey.categories[&21];
    assert_eq!(
        (category.blocks, category.is_withheld(), given.len()),
        (49_330, true, 0)
    );
    let (editions, _) = category.better().unwrap();
    assert_eq!(editions[0], Edition::new(0, 23));
    let (survey, given) = read(&in_edition(&bytes, 21, 0, 23));
    assert_eq!((survey.categories[&21].blocks_refused, given.len()), (0, 49_330));
}

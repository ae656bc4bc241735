//! Recordings of real sensors: what is given of them, and that nothing is made up.

use asterix::{Edition, NamedRecord};
use formats::recording::{RecordingBytes, Statistics};
use serde_json::json;
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

#[test]
fn messages_of_safety_nets_and_version_numbers() {
    let source = json!({"SAC": 0, "SIC": 1});
    let functions = json!({"MRVA": 0, "RAMLD": 0, "RAMHD": 0, "MSAW": 0, "APW": 1, "CLAM": 1, "STCA": 1});
    let area = json!({"EP": 0, "VAL": 0});
    let versions = [[21, 2, 1], [23, 1, 2], [247, 1, 2]]
        .map(|[category, main, sub]| json!({"CAT": category, "MAIN": main, "SUB": sub}));
    for (name, expected) in [
        (
            "cat004.bin",
            json!([
                {"_c": 4, "010": source, "000": 1, "020": 2829.0, "060": functions},
                {"_c": 4, "010": source, "000": 6, "020": 70_666.0, "040": 15_496, "030": 3027},
                {
                    "_c": 4, "010": source, "000": 7, "020": 70_658.0, "040": 15_497,
                    "045": {"AREA": area, "STAT": 3}, "030": 3130, "120": {}, "035": 2417,
                },
            ]),
        ),
        (
            "cat247.bin",
            json!([{"_c": 247, "010": source, "015": 1, "140": 14_431.460_937_5, "550": versions}]),
        ),
    ] {
        let Some(bytes) = recording(&format!("round4/unread-categories/{name}")) else {
            continue;
        };
        let recording = RecordingBytes::new(&bytes);
        let survey = recording.survey();
        let mut found = Vec::new();
        let visited = recording.for_each(&survey, |record| {
            serde_json::to_value(NamedRecord::new(record.record)).map(|named| found.push(named))
        });
        assert!(visited.is_ok() && survey.refusals.by_count().is_empty(), "{survey:?}");
        assert_eq!(json!(found), expected, "{name}");
    }
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

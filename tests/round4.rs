//! Recordings on which Koseki once failed, a function for each case of the folder `round4`.

use test_support::recordings;

use crate::common::Folder;

/// Five records of a radar with flight level −10: decoded text has the sign, as the live path does.
#[test]
fn bugs_negative_level() {
    const CASE: &str = "round4/bugs/negative-level/radar.pcap";
    let Some(data) = recordings(CASE) else { return };
    let folder = Folder::with::<&str>(&[]);
    folder.succeed(&format!("decode {} --out decoded.jsonl", data.join(CASE).display()));
    let text = folder.read("decoded.jsonl");
    let levels = text.lines().map(|line| {
        let record: serde_json::Value = serde_json::from_str(line).unwrap();
        record["090"]["FL"].as_f64()
    });
    assert_eq!(levels.collect::<Vec<_>>(), [Some(-10.0); 5]);
}

/// A target that is reported every 4 to 38 s, and once after nine minutes, beside four that are every 5 s: it is shown
/// from its third report at the latest, under one number.
#[test]
fn irregular_address() {
    const CASE: &str = "round4/irregular-address/target.csv";
    let Some(data) = recordings(CASE) else { return };
    let folder = Folder::with::<&str>(&[]);
    folder.succeed(&format!("fuse --tracks {} --out states.csv", data.join(CASE).display()));
    let text = folder.read("states.csv");
    let mut rows = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = rows.next().unwrap();
    let column = |name: &str| header.iter().position(|column| *column == name).unwrap();
    let (time, number, state, address) = (
        column("time_s"),
        column("system_track_id"),
        column("state"),
        column("address"),
    );
    let rows: Vec<_> = rows.filter(|row| row[address] == "ABCD01").collect();
    let numbers: std::collections::BTreeSet<_> = rows.iter().map(|row| row[number]).collect();
    assert_eq!(numbers.len(), 1, "{numbers:?}");
    let shown_from = rows.iter().find(|row| row[state] == "confirmed").map(|row| row[time]);
    assert!(
        ["1009", "1028"].map(Some).contains(&shown_from),
        "second or third report: {shown_from:?}"
    );
    assert_eq!(
        rows.last().map(|row| (row[time], row[state])),
        Some(("1745", "confirmed"))
    );
}

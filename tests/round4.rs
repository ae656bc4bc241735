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

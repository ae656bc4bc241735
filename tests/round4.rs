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

/// A centre's tracks that jump while their velocity is stated: the picture states that velocity, too.
#[test]
fn source_jump() {
    for case in ["round4/source-jump/track.csv", "round4/source-jump/straight.csv"] {
        let Some(data) = recordings(case) else { return };
        let folder = Folder::with::<&str>(&[]);
        let stated = data.join(case);
        folder.succeed(&format!("fuse --tracks {} --out fused.csv", stated.display()));
        let velocities = |text: &str| -> Vec<[f64; 3]> {
            let mut rows = csv::Reader::from_reader(text.as_bytes());
            let names = rows.headers().unwrap().clone();
            let places = ["time_s", "vx", "vy"].map(|name| names.iter().position(|other| other == name).unwrap());
            rows.records()
                .map(|row| row.unwrap())
                .map(|row| places.map(|place| row[place].parse().unwrap()))
                .collect()
        };
        let stated = velocities(&std::fs::read_to_string(stated).unwrap());
        let fused = velocities(&folder.read("fused.csv"));
        assert_eq!(fused.len(), stated.len(), "{case}");
        for ([time_s, vx, vy], [_, stated_vx, stated_vy]) in fused.into_iter().zip(stated) {
            let off_mps = (vx - stated_vx).hypot(vy - stated_vy);
            assert!(off_mps < 50.0, "{case}, {time_s} s: {off_mps} m/s");
        }
    }
}

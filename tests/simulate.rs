//! `koseki simulate` as a user calls it: the same world for the same seed, and files that the other commands take.

use std::collections::BTreeSet;

use test_support::{column, numbers};

use crate::common::Folder;

#[test]
fn a_simulation_is_the_same_for_the_same_seed_and_can_be_fused() {
    let folder = Folder::new();
    let files = [
        "truth.csv",
        "sensor_tracks_1.csv",
        "sensor_tracks_4.csv",
        "detections_1.csv",
        "detections_4.csv",
    ];
    for (name, seed) in [("one", 3), ("two", 3), ("other", 4)] {
        folder.succeed(&format!("simulate --scenario demo --seed {seed} --for 20 --out {name}"));
    }
    for file in files {
        let text = folder.read(&format!("one/{file}"));
        assert!(text.lines().count() > 100, "{file}");
        assert_eq!(text, folder.read(&format!("two/{file}")), "{file}");
        assert_ne!(text, folder.read(&format!("other/{file}")), "{file}");
    }
    // A detection is what was measured: of the sensor tracks' times, about as far from the truth as it says.
    let detections = folder.read("one/detections_4.csv");
    assert!(
        detections.starts_with("time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz,truth_id")
    );
    let tracked: BTreeSet<_> = column(&folder.read("one/sensor_tracks_4.csv"), "time_s")
        .into_iter()
        .collect();
    let detected = column(&detections, "time_s");
    assert!(detected.iter().all(|time| tracked.contains(time)));
    let found = folder.json(
        "fuse --tracks one/sensor_tracks_1.csv one/sensor_tracks_2.csv one/sensor_tracks_3.csv one/sensor_tracks_4.csv \
         --refresh 1 --out fused.csv --json",
    );
    assert_eq!(found["rows_refused"], 0, "rows are in the order of time: {found}");
    let score = folder.json("score --truth one/truth.csv --tracks fused.csv --json");
    assert!(score["completeness"].as_f64().unwrap() > 0.9, "{score}");
    let line = folder.refusal("simulate --scenario rain --out rain");
    assert!(line.contains("there are demo, en-route, dense"), "{line}");
}

#[test]
fn simulated_counts_are_the_same_for_the_same_seed() {
    let folder = Folder::new();
    for (out, seed) in [("one", 3), ("again", 3), ("other", 4)] {
        folder.succeed(&format!(
            "simulate --scenario wide-area --seed {seed} --for 40 --out {out}"
        ));
    }
    for name in [
        "truth.csv",
        "detections_1.csv",
        "detections_2.csv",
        "wide_area_remote.csv",
    ] {
        let [one, again, other] = ["one", "again", "other"].map(|run| folder.read(&format!("{run}/{name}")));
        assert!(one == again, "{name}");
        assert!(one != other, "{name}");
    }
    let truths = column(&folder.read("one/detections_1.csv"), "truth_id");
    let of_several = truths.iter().filter(|of| *of == "merged").count();
    assert!(of_several > 30, "{of_several} plots of several targets");
    let counted = folder.read("one/wide_area_remote.csv");
    let [times, arrivals, counts] = ["time_s", "arrival_s", "count"].map(|name| numbers(&counted, name));
    assert_eq!(counts.len(), 6 * 3, "every 8 s, of three formations");
    assert!(
        times
            .iter()
            .zip(arrivals)
            .all(|(time_s, arrival_s)| arrival_s - time_s == 8.0)
    );
    assert!(counts.iter().all(|count| (2.0..=4.0).contains(count)), "{counts:?}");
}

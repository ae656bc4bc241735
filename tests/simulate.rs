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

/// The shipped file for the sea: the speeds of ships on a straight course are theirs within a knot, a minute after
/// their tracks began.
#[test]
fn ships_of_the_shipped_file_have_their_speeds() {
    const KNOT_MPS: f64 = 1852.0 / 3600.0;
    const STRAIGHT_S: usize = 60;
    let folder = Folder::new();
    folder.write("coast.toml", include_str!("../config/coast.toml"));
    for seed in [3, 5] {
        folder.succeed(&format!(
            "simulate --scenario coast.toml --seed {seed} --for 240 --out sea"
        ));
        folder.succeed("fuse --tracks sea/sensor_tracks_1.csv --config coast.toml --refresh 1 --out fused.csv");
        let [truth, fused] = ["sea/truth.csv", "fused.csv"].map(|file| {
            let text = folder.read(file);
            let columns = ["time_s", "x", "y", "vx", "vy"].map(|name| numbers(&text, name));
            (
                column(
                    &text,
                    if file == "fused.csv" {
                        "system_track_id"
                    } else {
                        "target_id"
                    },
                ),
                columns,
            )
        });
        // Positions and velocities of each target, a row a second.
        let mut targets = std::collections::BTreeMap::<String, Vec<[f64; 4]>>::new();
        for row in 0..truth.0.len() {
            let [_, values @ ..] = truth.1.each_ref().map(|column| column[row]);
            targets.entry(truth.0[row].clone()).or_default().push(values);
        }
        let mut begun = std::collections::BTreeMap::<&str, f64>::new();
        let (mut right, mut all) = (0, 0);
        for row in 0..fused.0.len() {
            let [time_s, x, y, vx, vy] = fused.1.each_ref().map(|column| column[row]);
            let begun_s = *begun.entry(&fused.0[row]).or_insert(time_s);
            let second = time_s as usize;
            if time_s < begun_s + 60.0 || second < STRAIGHT_S {
                continue;
            }
            let off_m = |rows: &&Vec<[f64; 4]>| (rows[second][0] - x).hypot(rows[second][1] - y);
            let target = targets.values().min_by(|a, b| off_m(a).total_cmp(&off_m(b))).unwrap();
            let [before, now] = [target[second - STRAIGHT_S], target[second]];
            if (before[2] - now[2]).hypot(before[3] - now[3]) > 0.01 {
                continue;
            }
            all += 1;
            right += usize::from((vx.hypot(vy) - now[2].hypot(now[3])).abs() < KNOT_MPS);
        }
        assert!(all > 1000 && right * 20 >= all * 19, "seed {seed}: {right} of {all}");
    }
}

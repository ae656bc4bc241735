//! What a wide-area sensor is worth where its situation is simulated: formations that radars see as one, from
//! `koseki simulate` over `koseki track` to `koseki score` (WA-4, WA-8, WA-10). Seeds are fixed, so the figures are
//! always the same ones.

use std::collections::{BTreeMap, BTreeSet};

use test_support::rows;

use crate::common::Folder;

/// One formation in view from the start on.
const ONE: &str = "simulate --scenario wide-area --set scenario.formation[0].count=1";

fn number(field: &str) -> f64 {
    field.parse().unwrap()
}

/// Share of the times at which the picture shows as many tracks as there are targets, over these runs.
fn count_right(folder: &Folder, truths: &str, tracks: &str, since_s: u32) -> f64 {
    let score = format!("score tracks --truth {truths} --tracks {tracks} --since {since_s} --json");
    folder.json(&score)["count_right"].as_f64().unwrap()
}

/// Pairs that two radars see as one in four turns of five: with the count of a remote sensor both are shown far more
/// often, and with the counts of one that is wrong in a quarter of its reports still.
#[test]
fn support_makes_the_count_right_more_often() {
    let folder = Folder::new();
    let [mut truths, mut without, mut with, mut misled] = [(); 4].map(|()| String::new());
    for seed in 1..=4 {
        for (name, wrong) in [("run", 0.0), ("misled", 0.25)] {
            let simulate = format!(
                "{ONE} --set scenario.formation[0].sizes=[[2,1.0]] --seed {seed} --for 200 --out {name}{seed} \
                 --set wide_area_sensor[0].simulated.count_wrong_probability={wrong:?}"
            );
            folder.succeed(&simulate);
        }
        for name in ["truth.csv", "detections_1.csv", "detections_2.csv"] {
            let [one, other] = ["run", "misled"].map(|run| folder.read(&format!("{run}{seed}/{name}")));
            assert!(one == other, "{name} does not depend on what the remote sensor counts");
        }
        let track = format!("track --detections run{seed}/detections_1.csv run{seed}/detections_2.csv --out");
        folder.succeed(&format!("{track} without{seed}.csv"));
        let counts = |run: &str| format!("--wide-area {run}{seed}/wide_area_remote.csv");
        folder.succeed(&format!("{track} with{seed}.csv {}", counts("run")));
        folder.succeed(&format!("{track} misled{seed}.csv {}", counts("misled")));
        truths += &format!(" run{seed}/truth.csv");
        without += &format!(" without{seed}.csv");
        with += &format!(" with{seed}.csv");
        misled += &format!(" misled{seed}.csv");
    }
    let [without, with, misled] = [without, with, misled].map(|tracks| count_right(&folder, &truths, &tracks, 20));
    assert!(with > without + 0.1, "{without} without, {with} with");
    assert!(
        misled > without + 0.05,
        "{without} without, {misled} with some wrong counts"
    );
}

/// Fours of which the remote sensor counts two. It is known that from the first quarter of the bearings fours come:
/// there more of them are shown, and elsewhere nothing changes.
#[test]
fn what_is_known_of_a_sector_raises_counts_there_only() {
    let folder = Folder::new();
    folder.write(
        "fours.toml",
        "[[wide_area.prior]]\nsector = { from_m = [0.0, 0.0], bearings_deg = [0.0, 90.0] }\nformations = { 4 = 0.8 }\n",
    );
    let [mut inside, mut outside, mut plain, mut known] = [(); 4].map(|()| String::new());
    for seed in 1..=3 {
        folder.succeed(&format!(
            "simulate --scenario wide-area --set scenario.formation[0].count=4 --set scenario.formation[0].sizes=[[4,1.0]] \
             --set wide_area_sensor[0].simulated.counted_max=2 --set wide_area_sensor[0].simulated.origins=true \
             --seed {seed} --for 200 --out run{seed}"
        ));
        let truth = folder.read(&format!("run{seed}/truth.csv"));
        let (header, all) = truth.split_once('\n').unwrap();
        // The first formation, targets 0 to 3, is the one of the first quarter.
        let (within, elsewhere): (Vec<&str>, Vec<&str>) = all
            .lines()
            .partition(|row| number(row.split(',').nth(1).unwrap()) < 4.0);
        for (name, part) in [("inside", within), ("outside", elsewhere)] {
            folder.write(&format!("{name}{seed}.csv"), format!("{header}\n{}\n", part.join("\n")));
        }
        let track = format!(
            "track --detections run{seed}/detections_1.csv run{seed}/detections_2.csv \
             --wide-area run{seed}/wide_area_remote.csv"
        );
        folder.succeed(&format!("{track} --out plain{seed}.csv"));
        folder.succeed(&format!("{track} --config fours.toml --out known{seed}.csv"));
        inside += &format!(" inside{seed}.csv");
        outside += &format!(" outside{seed}.csv");
        plain += &format!(" plain{seed}.csv");
        known += &format!(" known{seed}.csv");
    }
    let score = |truths: &str, tracks: &str| {
        let figures = folder.json(&format!(
            "score tracks --truth {truths} --tracks {tracks} --since 20 --json"
        ));
        ["target_share", "count_right"].map(|name| figures[name].as_f64().unwrap())
    };
    let ([plain_share, plain_right], [known_share, known_right]) = (score(&inside, &plain), score(&inside, &known));
    assert!(
        known_share > plain_share + 0.02,
        "{plain_share} without, {known_share} with knowledge"
    );
    assert!(
        known_right > plain_right,
        "{plain_right} without, {known_right} with knowledge"
    );
    // The learned detection probability and mean life are of all targets: both change a little with those inside.
    let ([plain_share, plain_right], [known_share, known_right]) = (score(&outside, &plain), score(&outside, &known));
    assert!(
        (plain_share - known_share).abs() < 0.01 && (plain_right - known_right).abs() < 0.03,
        "{plain_share} and {plain_right}, {known_share} and {known_right}"
    );
}

/// A pair descends below what the sensors see. For a radar that misses half of its targets silence says little; a
/// remote sensor that reports none there says more, and the tracks end sooner.
#[test]
fn tracks_of_targets_that_have_vanished_end_sooner() {
    let folder = Folder::new();
    let sensor = "[[sensor]]\nid = 1\ndetection_probability = 0.5\n";
    folder.write("late.toml", sensor);
    folder.write(
        "early.toml",
        format!("{sensor}[wide_area.deletion]\nexistence_min = 0.98\n"),
    );
    let [mut late_s, mut early_s] = [Vec::new(), Vec::new()];
    for seed in 1..=6 {
        folder.succeed(&format!(
            "{ONE} --set scenario.formation[0].sizes=[[2,1.0]] --set scenario.formation[0].height_m=1000 \
             --set scenario.formation[0].low_m=50 --set scenario.formation[0].start_m=[35000,30000] \
             --set source[0].simulated.detection_probability=0.5 --set wide_area_sensor[0].simulated.absence_s=60 \
             --set wide_area_sensor[0].simulated.period_s=4 --set wide_area_sensor[0].simulated.delay_s=4 --seed {seed} \
             --for 260 --out run{seed}"
        ));
        let counts = rows(&folder.read(&format!("run{seed}/wide_area_remote.csv")), ["count"]);
        assert!(counts.iter().any(|[count]| count == "0"), "it says that they are gone");
        let track = format!(
            "track --detections run{seed}/detections_1.csv --wide-area run{seed}/wide_area_remote.csv --config"
        );
        folder.succeed(&format!("{track} late.toml --out late{seed}.csv"));
        folder.succeed(&format!("{track} early.toml --out early{seed}.csv"));
        late_s.extend(lives_after(&folder, seed, "late"));
        early_s.extend(lives_after(&folder, seed, "early"));
    }
    let mean = |lives: &[f64]| lives.iter().sum::<f64>() / lives.len() as f64;
    assert!(late_s.len() >= 5 && early_s.len() >= 5, "{late_s:?} {early_s:?}");
    assert!(
        mean(&early_s) < 0.5 * mean(&late_s),
        "{early_s:?} s with reports of absence, {late_s:?} s without"
    );
}

/// How long those tracks go on that were near the targets when these were seen last, seconds.
fn lives_after(folder: &Folder, seed: u32, tracks: &str) -> Vec<f64> {
    let truth = rows(&folder.read(&format!("run{seed}/truth.csv")), ["time_s", "x", "y"]);
    let last = truth.last().unwrap().each_ref().map(|field| number(field));
    let [gone_s, east, north] = last;
    let text = folder.read(&format!("{tracks}{seed}.csv"));
    let (mut near, mut ends) = (BTreeSet::new(), BTreeMap::new());
    for [time, track, x, y, state] in rows(&text, ["time_s", "sensor_track_id", "x", "y", "state"]) {
        if state == "tentative" || state == "terminated" {
            continue;
        }
        let time_s = number(&time);
        if (time_s - gone_s).abs() <= 3.0 && (number(&x) - east).hypot(number(&y) - north) < 1500.0 {
            near.insert(track.clone());
        }
        ends.insert(track, time_s);
    }
    near.iter().map(|track| ends[track] - gone_s).collect()
}

//! `koseki fuse` on rows that arrive late (FM-15): the state is that of the order of measurement.

use std::collections::BTreeMap;

use test_support::{Random, column};

use crate::common::Folder;

/// East and north of what there is at each whole second.
type Places = BTreeMap<u32, Vec<[f64; 2]>>;

const SECONDS: u32 = 60;
/// Files of the simulated sensors.
const SENSORS: [&str; 4] = [
    "made/sensor_tracks_1.csv",
    "made/sensor_tracks_2.csv",
    "made/sensor_tracks_3.csv",
    "made/sensor_tracks_4.csv",
];

/// Sensor tracks of simulated traffic, all in time, and the truth.
fn traffic() -> Folder {
    let folder = Folder::new();
    folder.succeed(&format!(
        "simulate --scenario en-route --seed 3 --for {SECONDS} --out made"
    ));
    folder
}

fn time_s(row: &str) -> f64 {
    row.split(',').next().unwrap().parse().unwrap()
}

/// A file with the time of arrival of each row, `delay_s` after its time.
fn arriving(text: &str, mut delay_s: impl FnMut() -> f64) -> String {
    let (header, rows) = text.split_once('\n').unwrap();
    let mut made = format!("{header},arrival_s\n");
    for row in rows.lines() {
        made += &format!("{row},{:.9}\n", time_s(row) + delay_s());
    }
    made
}

/// The rows of files that have arrived by `second`, without their time of arrival, in the order of time, and a row at
/// `second` that lets time pass and says nothing.
fn arrived_by(files: &[String], second: u32) -> String {
    let mut rows: Vec<&str> = Vec::new();
    for line in files.iter().flat_map(|file| file.lines().skip(1)) {
        let (row, arrival_s) = line.rsplit_once(',').unwrap();
        if arrival_s.parse::<f64>().unwrap() <= f64::from(second) {
            rows.push(row);
        }
    }
    rows.sort_by(|one, other| time_s(one).total_cmp(&time_s(other)));
    let header = files[0].lines().next().unwrap().rsplit_once(',').unwrap().0;
    let state = header.split(',').position(|name| name == "state").unwrap();
    let mut last: Vec<String> = rows[0].split(',').map(str::to_owned).collect();
    (last[0], last[2], last[state]) = (second.to_string(), "999999".to_owned(), "coasted".to_owned());
    format!("{header}\n{}\n{}\n", rows.join("\n"), last.join(","))
}

fn places(text: &str) -> Places {
    let [times, x, y] = ["time_s", "x", "y"].map(|name| column(text, name));
    let mut places = Places::new();
    for (time, (x, y)) in times.iter().zip(x.iter().zip(&y)) {
        if let Ok(second) = time.parse() {
            let place = [x, y].map(|value| value.parse().unwrap());
            places.entry(second).or_default().push(place);
        }
    }
    places
}

/// Squared distances of each place of the truth to the nearest one found, if that is the same target.
fn squares(truth: &[[f64; 2]], found: &[[f64; 2]]) -> Vec<Option<f64>> {
    const SAME_M: f64 = 1500.0;
    let square = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
    let nearest = |place: &[f64; 2]| found.iter().map(|other| square(place, other)).min_by(f64::total_cmp);
    let is_same = |square: &f64| *square < SAME_M * SAME_M;
    truth.iter().map(|place| nearest(place).filter(is_same)).collect()
}

/// Root mean square error of each fused file relative to that of fusing anew, at each of some seconds, all that had
/// arrived by then; over the targets that both show.
fn over_fused_anew(folder: &Folder, files: &[String], fused: [&str; 2]) -> [f64; 2] {
    let truth = places(&folder.read("made/truth.csv"));
    let fused = fused.map(|name| places(&folder.read(name)));
    let mut sums = [[0.0; 2]; 2];
    for second in (12..SECONDS).step_by(4) {
        folder.write("anew.csv", arrived_by(files, second));
        folder.succeed("fuse --tracks anew.csv --refresh 1 --out fused_anew.csv");
        let of = |states: &Places| squares(&truth[&second], states.get(&second).map_or(&[], Vec::as_slice));
        let anew = of(&places(&folder.read("fused_anew.csv")));
        for (sums, live) in sums.iter_mut().zip(&fused) {
            for pair in of(live).into_iter().zip(&anew) {
                if let (Some(live), Some(anew)) = pair {
                    *sums = [sums[0] + live, sums[1] + anew];
                }
            }
        }
    }
    sums.map(|[live, anew]| (live / anew).sqrt())
}

#[test]
fn late_rows_give_nearly_the_state_of_all_that_has_arrived() {
    let folder = traffic();
    let names = "late_1.csv late_2.csv late_3.csv late_4.csv";
    folder.write("carried.toml", "[fusion]\nlate_window_s = 0\n");
    // One sensor, each in turn, and all; by up to so many seconds.
    for (late, most_s) in [(Some(0), 8.0), (Some(2), 4.0), (Some(3), 4.0), (None, 5.0)] {
        let mut random = Random::new(5);
        let mut files = Vec::new();
        for (sensor, name) in SENSORS.into_iter().enumerate() {
            let is_late = late.is_none_or(|late| late == sensor);
            let delay_s = || if is_late { random.between(0.0, most_s) } else { 0.0 };
            let text = arriving(&folder.read(name), delay_s);
            folder.write(&format!("late_{}.csv", sensor + 1), &text);
            files.push(text);
        }
        let found = folder.json(&format!("fuse --tracks {names} --refresh 1 --out fused.csv --json"));
        let used: u64 = (0..4)
            .map(|sensor| found["sensors"][sensor]["late_used"].as_u64().unwrap())
            .sum();
        assert!(used > 100, "{used} of {late:?}");
        folder.succeed(&format!(
            "fuse --tracks {names} --config carried.toml --refresh 1 --out carried.csv"
        ));
        let [ratio, carried] = over_fused_anew(&folder, &files, ["fused.csv", "carried.csv"]);
        println!("{late:?}: {ratio:.4}, carried forward {carried:.4}");
        // If all are late, starts and joins of tracks are.
        let limit = if late.is_some() { 1.02 } else { 1.06 };
        assert!(ratio <= limit, "{late:?}: {ratio}");
        assert!(carried > ratio, "{late:?}: {ratio}, carried forward {carried}");
    }
}

#[test]
fn rows_come_in_the_order_of_arrival_whatever_their_order_in_the_file() {
    let folder = traffic();
    let mut random = Random::new(9);
    let by_time = arriving(&folder.read(SENSORS[2]), || random.between(0.0, 5.0));
    let (header, rows) = by_time.split_once('\n').unwrap();
    let mut rows: Vec<&str> = rows.lines().collect();
    let arrival_s = |row: &str| row.rsplit_once(',').unwrap().1.parse::<f64>().unwrap();
    rows.sort_by(|one, other| arrival_s(one).total_cmp(&arrival_s(other)));
    folder.write("by_time.csv", &by_time);
    folder.write("by_arrival.csv", format!("{header}\n{}\n", rows.join("\n")));
    rows.reverse();
    folder.write("reversed.csv", format!("{header}\n{}\n", rows.join("\n")));
    let fused = ["by_time", "by_arrival", "reversed"].map(|name| {
        folder.succeed(&format!(
            "fuse --tracks {name}.csv {} --refresh 1 --out fused.csv",
            SENSORS[0]
        ));
        folder.read("fused.csv")
    });
    assert!(fused[0].lines().count() > 100);
    assert!(fused[0] == fused[1] && fused[0] == fused[2]);
}

#[test]
fn rows_that_arrive_at_once_give_the_bytes_of_files_without_times_of_arrival() {
    let folder = traffic();
    let plain = SENSORS.join(" ");
    for (place, name) in SENSORS.into_iter().enumerate() {
        folder.write(&format!("{}.csv", place + 1), arriving(&folder.read(name), || 0.0));
    }
    for refresh in ["--refresh 1", "--rule best-source", ""] {
        folder.succeed(&format!(
            "fuse --tracks {plain} {refresh} --out plain.csv --explain plain_why.csv"
        ));
        folder.succeed(&format!(
            "fuse --tracks 1.csv 2.csv 3.csv 4.csv {refresh} --out at_once.csv --explain at_once_why.csv"
        ));
        assert!(folder.read("plain.csv") == folder.read("at_once.csv"), "{refresh}");
        assert!(
            folder.read("plain_why.csv") == folder.read("at_once_why.csv"),
            "{refresh}"
        );
    }
}

#[test]
fn a_row_that_arrives_before_its_measurement_is_left_out() {
    let folder = traffic();
    let mut rows = 0;
    let text = arriving(&folder.read(SENSORS[0]), || {
        rows += 1;
        if rows == 7 { -0.5 } else { 1.0 }
    });
    folder.write("a.csv", text);
    let found = folder.json("fuse --tracks a.csv --refresh 1 --out fused.csv --json");
    assert_eq!(found["refused"], serde_json::json!({ "column arrival_s": 1 }));
    let first = found["first_refused"][0].as_str().unwrap();
    assert!(
        first.contains("line 8") && first.contains("is before time_s"),
        "{first}"
    );
}

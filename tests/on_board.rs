//! A radar on a ship that rolls and turns, against the same radar at rest (HT-12, EL-11).

use std::collections::BTreeMap;
use std::fs;

use crate::common::Folder;

/// From when on the tracks are judged, seconds.
const SETTLED_S: f64 = 60.0;

/// Positions and velocities by target, second by second.
type Truth = BTreeMap<u32, Vec<[f64; 4]>>;

fn rows(folder: &Folder, name: &str) -> Vec<BTreeMap<String, f64>> {
    let text = fs::read_to_string(folder.path(name)).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let values = |line: &str| {
        let cells = header.iter().zip(line.split(','));
        cells
            .filter_map(|(name, cell)| Some(((*name).to_owned(), cell.parse().ok()?)))
            .collect()
    };
    lines.map(values).collect()
}

fn truth(folder: &Folder) -> Truth {
    let mut truth = Truth::new();
    for row in rows(folder, "sea/truth.csv") {
        let state = ["x", "y", "vx", "vy"].map(|name| row[name]);
        truth.entry(row["target_id"] as u32).or_default().push(state);
    }
    truth
}

/// Sum of squared errors, sum of normalised squared errors per coordinate, and number of the rows of tracks.
fn errors(folder: &Folder, tracks: &str, truth: &Truth) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for row in rows(folder, tracks) {
        let time_s = row["time_s"];
        let place = |states: &Vec<[f64; 4]>| {
            let second = (time_s as usize).min(states.len() - 1);
            let ([x, y, vx, vy], since) = (states[second], time_s - second as f64);
            [row["x"] - x - vx * since, row["y"] - y - vy * since]
        };
        let nearest = truth
            .values()
            .map(place)
            .min_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])));
        let [east, north] = nearest.unwrap();
        // A track of false detections is no error of a target's position.
        if time_s < SETTLED_S || east.hypot(north) > 1000.0 {
            continue;
        }
        let [p, q, r] = ["P00", "P01", "P11"].map(|name| row[name]);
        let squared = (r * east * east - 2.0 * q * east * north + p * north * north) / (p * r - q * q);
        sums[0] += east * east + north * north;
        sums[1] += squared / 2.0;
        sums[2] += 1.0;
    }
    sums
}

#[test]
fn a_rolling_turning_ship_tracks_as_well_as_a_radar_at_rest() {
    let folder = Folder::new();
    let (mut moving, mut resting) = ([0.0; 3], [0.0; 3]);
    for seed in 1..=4 {
        folder.succeed(&format!(
            "simulate --scenario on-board --seed {seed} --for 240 --out sea"
        ));
        let truth = truth(&folder);
        let options = "--config sea/mounting.toml --out tracks.csv";
        let said = folder.json(&format!(
            "track --detections sea/detections.csv --platform sea/platform.csv {options} --json"
        ));
        assert_eq!(said["platform"]["refused"]["gap"], 0);
        assert!(said["platform"]["carried"].as_u64().unwrap() > 1500);
        let add = |sums: &mut [f64; 3], more: [f64; 3]| {
            sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        };
        add(&mut moving, errors(&folder, "tracks.csv", &truth));
        folder.succeed(&format!("track --detections sea/at_rest.csv {options}"));
        add(&mut resting, errors(&folder, "tracks.csv", &truth));
    }
    let rmse = |[squared, _, count]: [f64; 3]| (squared / count).sqrt();
    let nees = |[_, normalised, count]: [f64; 3]| normalised / count;
    println!(
        "on board: {:.1} m, NEES {:.2}; at rest: {:.1} m, NEES {:.2}",
        rmse(moving),
        nees(moving),
        rmse(resting),
        nees(resting)
    );
    assert!(moving[2] > 0.95 * resting[2], "{moving:?} {resting:?}");
    assert!(rmse(moving) <= 1.05 * rmse(resting));
    assert!((0.8..1.25).contains(&nees(moving)), "{}", nees(moving));
}

#[test]
fn detections_without_a_state_near_their_time_are_refused_and_counted() {
    let folder = Folder::new();
    folder.succeed("simulate --scenario on-board --seed 1 --for 60 --out sea");
    let text = fs::read_to_string(folder.path("sea/platform.csv")).unwrap();
    // The navigation is silent for ten seconds, and ends before the radar.
    let kept = |line: &&str| {
        let time_s: Option<f64> = line.split(',').next().and_then(|cell| cell.parse().ok());
        time_s.is_none_or(|time_s| time_s < 20.0 || (30.0..50.0).contains(&time_s))
    };
    let thinned: Vec<&str> = text.lines().filter(kept).collect();
    folder.write("thin.csv", thinned.join("\n") + "\n");
    let said = folder.json(
        "track --detections sea/detections.csv --platform thin.csv --config sea/mounting.toml --out tracks.csv --json",
    );
    let of = |word: &str| said["platform"]["refused"][word].as_u64().unwrap();
    assert!(of("gap") > 40 && of("no_state") > 40 && of("too_old") == 0, "{said}");
    let line = folder.refusal("track --detections sea/detections.csv --platform sea/truth.csv --out other.csv");
    assert!(line.contains("has no row with a position in px, py and pz"), "{line}");
}

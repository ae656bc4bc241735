//! Golden outputs: what `koseki simulate`, `fuse`, `track`, `locate` and `decode` gave when somebody last looked at it.
//!
//! A change of the engine, the tracker, the locator or the decoder that changes what comes out shows as a change of the
//! files in `tests/golden`, and is to be explained where it is made. The figures of one small run are no measure of
//! quality: `docs/fusion.md` and `docs/tracking.md` have those. To accept a change:
//!
//! ```text
//! UPDATE_GOLDEN=1 cargo test -p koseki --test integration golden
//! ```
//!
//! Each file has a line for each row that is shown, with some of its columns rounded to 0.001, and hashes of what is
//! not shown: the rows after the first 200, the other columns of all rows, and the decisions of `--explain`. A hash
//! that differs while no row does says that the difference is there.
//!
//! What is promised is that one build gives the same bytes on processors of one family. Other compilers, optimisations
//! or mathematical libraries may differ in the last bits of a floating-point number; rounding hides that as a rule, and
//! where it does not, the goldens are accepted anew.
//!
//! All inputs are made here, by `koseki simulate` or from numbers: a difference in the golden file of an input
//! (`inputs.txt`) explains all others.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use test_support::{Digest, Random, assert_golden, places, rows};

use crate::common::{Folder, repository};

/// Rows of a table that a golden file shows.
const SHOWN_MAX: usize = 200;
/// Columns of the covariance of a state.
pub(crate) const COVARIANCE: [&str; 21] = [
    "P00", "P01", "P02", "P03", "P04", "P05", "P11", "P12", "P13", "P14", "P15", "P22", "P23", "P24", "P25", "P33",
    "P34", "P35", "P44", "P45", "P55",
];

/// Compares with the file of this name in `tests/golden`.
pub(crate) fn golden(name: &str, found: &str) {
    assert_golden(&repository("tests/golden").join(name), found);
}

/// A value as golden files have it: numbers, also several joined by `|`, to three digits after the point.
fn rounded(value: &str) -> String {
    let one = |part: &str| match part.parse::<f64>() {
        Ok(number) if part.contains(['.', 'e']) => {
            let text = format!("{number:.3}");
            let text = text.trim_end_matches('0').trim_end_matches('.');
            if text == "-0" { "0".to_owned() } else { text.to_owned() }
        }
        _ => part.to_owned(),
    };
    value.split('|').map(one).collect::<Vec<_>>().join("|")
}

/// A table as a golden file has it: a line of `title`, the `shown` columns of its first rows, and hashes of the shown
/// columns of the others and of the columns `hashed` of all.
fn excerpt<const S: usize, const H: usize>(title: &str, text: &str, shown: [&str; S], hashed: [&str; H]) -> String {
    let (header, rows) = text.split_once('\n').unwrap_or((text, ""));
    let (shown_at, hashed_at) = (places(header, shown), places(header, hashed));
    let mut out = format!("# {title}\n{}\n", shown.join(","));
    let (mut others, mut rest) = (Digest::default(), Digest::default());
    let mut count = 0;
    for row in rows.lines() {
        let values: Vec<String> = row.split(',').map(rounded).collect();
        let line = |places: &[usize]| {
            places
                .iter()
                .map(|place| values[*place].as_str())
                .collect::<Vec<_>>()
                .join(",")
                + "\n"
        };
        if count < SHOWN_MAX {
            out += &line(&shown_at);
        } else {
            rest.add(line(&shown_at).as_bytes());
        }
        others.add(line(&hashed_at).as_bytes());
        count += 1;
    }
    if count > SHOWN_MAX {
        writeln!(out, "# {} more rows: {rest}", count - SHOWN_MAX).unwrap();
    }
    if H > 0 {
        writeln!(out, "# {}…{} of {count} rows: {others}", hashed[0], hashed[H - 1]).unwrap();
    }
    out
}

/// A line about these columns of a table, of which nothing is shown.
pub(crate) fn hash_of_columns<const N: usize>(title: &str, text: &str, columns: [&str; N]) -> String {
    let rows = rows(text, columns).into_iter().map(|row| row.join(",") + "\n");
    hash_of(title, &format!("{}\n{}", columns.join(","), rows.collect::<String>()))
}

/// A line about a table of which nothing is shown.
fn hash_of(title: &str, text: &str) -> String {
    let mut digest = Digest::default();
    for line in text.lines() {
        let values: Vec<String> = line.split(',').map(rounded).collect();
        digest.add((values.join(",") + "\n").as_bytes());
    }
    format!("# {title}: {} rows: {digest}\n", text.lines().count().saturating_sub(1))
}

// ---------------------------------------------------------------------------------------------------------------------
// Fusion
// ---------------------------------------------------------------------------------------------------------------------

/// A case of the comparison of rules in `docs/fusion.md`, in little.
struct Case {
    name: &'static str,
    /// What is special about it.
    what: &'static str,
    /// Values of `world.toml` that are replaced, and tables that are added.
    set: &'static [&'static str],
    added: &'static str,
    sensors: usize,
    seconds: u32,
    refresh_s: u32,
    /// Error of a position that the simulation does not know, metres: of this sensor (from 0), at this time in s and
    /// velocity in m/s.
    error: fn(usize, f64, [f64; 2], &mut Random) -> [f64; 2],
}

const OFFSETS: [&str; 3] = [
    "source[1].simulated.bias_m=[60.0,0.0,0.0]",
    "source[2].simulated.bias_m=[30.0,52.0,0.0]",
    "source[3].simulated.bias_m=[-30.0,52.0,0.0]",
];
/// Vehicles instead of aircraft, and sensors as accurate as those of an airport.
const SURFACE: [&str; 16] = [
    "scenario.surface_share=1.0",
    "source[0].simulated.period_s=1.0",
    "source[1].simulated.period_s=1.5",
    "source[2].simulated.period_s=2.0",
    "source[0].simulated.range_sigma_m=3.0",
    "source[1].simulated.range_sigma_m=2.0",
    "source[2].simulated.range_sigma_m=5.0",
    "source[0].simulated.azimuth_sigma_rad=6e-5",
    "source[1].simulated.azimuth_sigma_rad=4e-5",
    "source[2].simulated.azimuth_sigma_rad=1e-4",
    "source[0].simulated.acceleration_density_m2ps3=0.5",
    "source[1].simulated.acceleration_density_m2ps3=0.5",
    "source[2].simulated.acceleration_density_m2ps3=0.5",
    "source[0].simulated.first_speed_sigma_mps=10.0",
    "source[1].simulated.first_speed_sigma_mps=10.0",
    "source[2].simulated.first_speed_sigma_mps=10.0",
];
const FORMATIONS: &str = "[[scenario.formation]]\ncount = 5\nspacing_m = 300.0\nway_m = [40000.0, 5000.0]\n\
                          together_m = [40000.0, 5000.0]\nstart_m = [30000.0, 15000.0]\n";

const CASES: [Case; 6] = [
    Case {
        name: "a",
        what: "few targets, apart from each other, three sensors",
        set: &[],
        added: "",
        sensors: 3,
        seconds: 60,
        refresh_s: 2,
        error: none,
    },
    Case {
        name: "b",
        what: "paths that cross, four sensors, more false tracks",
        set: &[
            "scenario.targets=20",
            "scenario.crossing_share=1.0",
            "source[0].simulated.false_tracks_per_period=1.0",
        ],
        added: "",
        sensors: 4,
        seconds: 60,
        refresh_s: 5,
        error: none,
    },
    Case {
        name: "c",
        what: "case a with sensors 60 m off each other, of which the second becomes four times worse than it says",
        set: &OFFSETS,
        added: "",
        sensors: 3,
        seconds: 60,
        refresh_s: 2,
        error: worse_than_stated,
    },
    Case {
        name: "d",
        what: "many targets, five sensors",
        set: &[
            "scenario.targets=120",
            "scenario.half_width_m=100000.0",
            "scenario.crossing_share=0.1",
        ],
        added: "",
        sensors: 5,
        seconds: 24,
        refresh_s: 8,
        error: none,
    },
    Case {
        name: "e",
        what: "pairs in formation 300 m apart, sensors 60 m off each other that lose targets often",
        set: &[
            OFFSETS[0],
            OFFSETS[1],
            OFFSETS[2],
            "source[0].simulated.dropouts_per_hour=60.0",
            "source[1].simulated.dropouts_per_hour=60.0",
        ],
        added: FORMATIONS,
        sensors: 4,
        seconds: 60,
        refresh_s: 4,
        error: none,
    },
    Case {
        name: "f",
        what: "vehicles of which each sensor sees another point, 20 m apart and turning with the vehicle",
        set: &SURFACE,
        added: "",
        sensors: 3,
        seconds: 60,
        refresh_s: 2,
        error: another_point,
    },
];

/// No error that the simulation does not make itself.
fn none(_: usize, _: f64, _: [f64; 2], _: &mut Random) -> [f64; 2] {
    [0.0; 2]
}

/// From half a minute on the second sensor's errors are larger by three times its standard deviation.
fn worse_than_stated(sensor: usize, time_s: f64, _: [f64; 2], random: &mut Random) -> [f64; 2] {
    let mut off = || 220.0 * (random.unit() + random.unit() - 1.0);
    if sensor == 1 && time_s > 30.0 {
        [off(), off()]
    } else {
        [0.0; 2]
    }
}

/// The first sensor sees the middle, the second the bow, the third a point ahead on the left.
fn another_point(sensor: usize, _: f64, [east, north]: [f64; 2], _: &mut Random) -> [f64; 2] {
    let [ahead, left] = [[0.0, 0.0], [20.0, 0.0], [10.0, 17.3]][sensor];
    let speed = east.hypot(north);
    if speed < 0.5 {
        return [0.0; 2];
    }
    [
        (ahead * east - left * north) / speed,
        (ahead * north + left * east) / speed,
    ]
}

impl Case {
    /// Simulates the case; gives the names of the files of sensor tracks, apart by blanks.
    fn simulate(&self, folder: &Folder) -> String {
        let name = self.name;
        let world = include_str!("golden/world.toml");
        folder.write(&format!("{name}.toml"), format!("{world}\n{}", self.added));
        let set: String = self.set.iter().map(|value| format!(" --set {value}")).collect();
        folder.succeed(&format!(
            "simulate --scenario {name}.toml --seed 1 --for {} --out {name}{set}",
            self.seconds
        ));
        let mut names = String::new();
        for sensor in 0..self.sensors {
            let file = format!("{name}/sensor_tracks_{}.csv", sensor + 1);
            let text = self.with_errors(sensor, &folder.read(&file));
            folder.write(&file, &text);
            names += &format!(" {file}");
        }
        names
    }

    fn with_errors(&self, sensor: usize, text: &str) -> String {
        let mut random = Random::new(sensor as u64);
        let (header, rows) = text.split_once('\n').unwrap();
        let at = places(header, ["time_s", "x", "y", "vx", "vy"]);
        let mut out = format!("{header}\n");
        for row in rows.lines() {
            let mut values: Vec<String> = row.split(',').map(str::to_owned).collect();
            let [time_s, x, y, vx, vy] = at.map(|place| values[place].parse::<f64>().unwrap());
            let [east, north] = (self.error)(sensor, time_s, [vx, vy], &mut random);
            values[at[1]] = format!("{:.3}", x + east);
            values[at[2]] = format!("{:.3}", y + north);
            writeln!(out, "{}", values.join(",")).unwrap();
        }
        out
    }

    /// Smooths the case; gives the golden text.
    fn smooth(&self, folder: &Folder) -> String {
        let (name, what, refresh_s) = (self.name, self.what, self.refresh_s);
        let tracks = self.simulate(folder);
        folder.succeed(&format!(
            "smooth --tracks{tracks} --refresh {refresh_s} --out {name}/smoothed.csv"
        ));
        let shown = [
            "time_s",
            "system_track_id",
            "x",
            "y",
            "z",
            "vx",
            "vy",
            "vz",
            "P00",
            "P11",
            "state",
        ];
        let smoothed = folder.read(&format!("{name}/smoothed.csv"));
        let title = format!("case {name}, {what}: smoothed, every {refresh_s} s");
        excerpt(&title, &smoothed, shown, COVARIANCE)
    }

    /// Fuses the case with a rule; gives the golden text.
    fn fuse(&self, folder: &Folder, rule: &str, refresh_s: u32) -> String {
        let (name, what) = (self.name, self.what);
        let tracks = self.simulate(folder);
        let options = format!("--rule {rule} --refresh {refresh_s} --out {name}/fused.csv --explain {name}/why.csv");
        folder.succeed(&format!("fuse --tracks{tracks} {options}"));
        let shown = [
            "time_s",
            "system_track_id",
            "x",
            "y",
            "z",
            "vx",
            "vy",
            "vz",
            "P00",
            "P11",
            "state",
            "sources",
            "weights",
            "selected",
        ];
        let fused = folder.read(&format!("{name}/fused.csv"));
        let title = format!("case {name}, {what}: rule {rule}, every {refresh_s} s");
        excerpt(&title, &fused, shown, COVARIANCE) + &hash_of("decisions", &folder.read(&format!("{name}/why.csv")))
    }
}

/// The inputs of all cases: where one of these differs, the simulation has changed, and not (only) what is tested with
/// it.
#[test]
fn inputs_are_simulated_as_they_were() {
    let folder = Folder::new();
    let mut out = String::new();
    for case in CASES {
        case.simulate(&folder);
        for sensor in 1..=case.sensors {
            let file = format!("{}/sensor_tracks_{sensor}.csv", case.name);
            out += &hash_of(&file, &folder.read(&file));
        }
    }
    golden("inputs.txt", &out);
}

/// The rule for unknown data on each case.
#[test]
fn every_case_is_fused_as_it_was() {
    let folder = Folder::new();
    for case in CASES {
        golden(
            &format!("fuse_{}.csv", case.name),
            &case.fuse(&folder, "auto", case.refresh_s),
        );
    }
}

/// Sensors off each other: the errors that are known at the end are taken off from the beginning.
#[test]
fn a_case_is_smoothed_as_it_was() {
    golden("smooth_c.csv", &CASES[2].smooth(&Folder::new()));
}

/// Each rule on the first case.
#[test]
fn every_rule_fuses_as_it_did() {
    let folder = Folder::new();
    for rule in fusion::rules::REGISTRY {
        golden(
            &format!("rule_{}.csv", rule.name()),
            &CASES[0].fuse(&folder, rule.name(), 5),
        );
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Tracking
// ---------------------------------------------------------------------------------------------------------------------

/// Tracks a simulated scenario's detections; gives the golden text.
fn track(scenario: &str, seconds: u32, what: &str, options: &str) -> String {
    let folder = Folder::new();
    folder.succeed(&format!(
        "simulate --scenario {scenario} --seed 3 --for {seconds} --out {scenario}"
    ));
    folder.succeed(&format!(
        "track {options} --out tracks.csv --explain why.csv --cues cues.csv"
    ));
    let shown = [
        "time_s",
        "sensor_track_id",
        "x",
        "y",
        "vx",
        "vy",
        "P00",
        "P11",
        "state",
        "hypotheses",
        "reliability",
    ];
    let mut out = excerpt(what, &folder.read("tracks.csv"), shown, COVARIANCE);
    out += &hash_of("decisions", &folder.read("why.csv"));
    out + &hash_of("cues", &folder.read("cues.csv"))
}

/// Two targets that pass each other, each row with what is most easily understood.
#[test]
fn two_targets_that_pass_each_other_are_tracked_as_they_were() {
    let folder = Folder::new();
    folder.write("plots.csv", crate::track::scene_of(12));
    folder.succeed("track --detections plots.csv --out tracks.csv");
    let shown = ["time_s", "sensor_track_id", "x", "y", "vx", "state", "hypotheses"];
    let tracks = folder.read("tracks.csv");
    golden(
        "track_passing.csv",
        &excerpt("two targets that pass each other", &tracks, shown, COVARIANCE),
    );
}

/// Plots of one radar, two of five of them false.
#[test]
fn plots_with_clutter_are_tracked_as_they_were() {
    let found = track(
        "demo",
        24,
        "targets of the demonstration in clutter",
        "--detections demo/detections_5.csv",
    );
    golden("track_clutter.csv", &found);
}

/// Formations that two radars mostly see as one target, with the counts of a remote sensor.
#[test]
fn formations_are_tracked_as_they_were() {
    let detections = "--detections wide-area/detections_1.csv wide-area/detections_2.csv";
    let counts = "--wide-area wide-area/wide_area_remote.csv";
    let found = track(
        "wide-area",
        50,
        "formations, with counts",
        &format!("{detections} {counts}"),
    );
    golden("track_formations.csv", &found);
    let found = track("wide-area", 50, "formations, without counts", detections);
    golden("track_formations_unsupported.csv", &found);
}

// ---------------------------------------------------------------------------------------------------------------------
// Location
// ---------------------------------------------------------------------------------------------------------------------

/// Ships that transmit, heard by an aircraft.
#[test]
fn emitters_are_located_as_they_were() {
    let folder = Folder::new();
    folder.write("coast.toml", include_str!("../config/coast.toml"));
    let fewer = "--set scenario.targets=4 --set source[1].simulated_direction_finder.period_s=4.0";
    folder.succeed(&format!(
        "simulate --scenario coast.toml {fewer} --seed 3 --for 300 --out sea"
    ));
    for (name, options) in [
        ("auto", ""),
        ("fixed", "--filter fixed --select staged"),
        ("straight", "--filter straight --select minimum"),
    ] {
        folder.succeed(&format!(
            "locate --bearings sea/bearings_2.csv {options} --out fixes.csv --explain why.csv"
        ));
        let shown = [
            "time_s",
            "emitter_id",
            "x",
            "y",
            "vx",
            "vy",
            "variance_m2",
            "stage",
            "selected",
            "motion",
            "agreed",
        ];
        let title = format!("ships heard by an aircraft {options}");
        let mut out = excerpt(
            title.trim_end(),
            &folder.read("fixes.csv"),
            shown,
            ["raw_x", "raw_y", "Pxx", "Pxy", "Pyy", "raw_vx", "raw_vy"],
        );
        out += &hash_of("decisions", &folder.read("why.csv"));
        golden(&format!("locate_{name}.csv"), &out);
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Decoding
// ---------------------------------------------------------------------------------------------------------------------

/// Two records of every edition, with each item that it has in some of them; then those of the default editions again,
/// with what is known of reserved expansion fields. Decoding is exact, so nothing is rounded.
#[test]
fn records_are_decoded_as_they_were() {
    let folder = Folder::new();
    let mut blocks: BTreeMap<(u8, String), Vec<u8>> = BTreeMap::new();
    for line in include_str!("golden/records.txt").lines().skip(1) {
        let [category, edition, octets] = *line.split(' ').collect::<Vec<_>>() else {
            panic!("{line}")
        };
        let octets = (0..octets.len())
            .step_by(2)
            .map(|at| u8::from_str_radix(&octets[at..at + 2], 16).unwrap());
        let key = (category.parse().unwrap(), edition.to_owned());
        blocks.entry(key).or_default().extend(octets);
    }
    let mut out = String::new();
    let mut decode = |category: u8, octets: &[u8], editions: &str| {
        folder.write("x.ast", octets);
        let (printed, _) = folder.succeed(&format!("decode x.ast --out -{editions}"));
        writeln!(out, "# category {category:03}{editions}\n{printed}").unwrap();
    };
    for ((category, edition), octets) in &blocks {
        decode(*category, octets, &format!(" --edition {category}={edition}"));
    }
    for expansion in asterix::registry::EXPANSIONS {
        let (category, edition) = (expansion.number, expansion.edition);
        let octets: Vec<u8> = blocks
            .iter()
            .filter(|((of, _), _)| *of == category)
            .flat_map(|(_, octets)| octets)
            .copied()
            .collect();
        decode(category, &octets, &format!(" --edition {category}/RE={edition}"));
    }
    golden("decode.jsonl", &out);
}

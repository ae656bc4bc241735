//! Errors over the stated covariance, of simulated ADS-B with NACp 6 to 11 and of simulated AIS: of the reports as
//! published, and of system tracks made of them.
//!
//! A mean of 1 is honest (NEES over its dimension, Bar-Shalom, Li and Kirubarajan, section 5.4). Reports of the best
//! categories, and system tracks made of a single source, are within 0.7 to 1.4.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::common::{Home, system};
use test_support::{column, numbers};

/// What is honest.
const BOUNDS: std::ops::Range<f64> = 0.7..1.4;
/// The tests' day, as lines of AIS have it, seconds since 1970.
const MIDNIGHT_S: f64 = 1_577_836_800.0;
/// Time of the truth from which tracks count, seconds.
const SETTLED_S: f64 = 30.0;
const KT: f64 = 1852.0 / 3600.0;
/// Bounds of 95 % of the errors, metres, of NACp 6 to 11.
const NACP_M: [f64; 6] = [555.6, 185.2, 92.6, 30.0, 10.0, 3.0];
/// The same of velocities, metres per second, of NACv 1 to 4.
const NACV_MPS: [f64; 4] = [10.0, 3.0, 1.0, 0.3];
/// Ratio of such a bound to a standard deviation.
const RADIUS95_SIGMAS: f64 = 2.447_746_8;
/// Step of coordinates in squitters, metres.
const STEP_M: f64 = 5.09;
/// First address of simulated targets is random; theirs here begin here.
const ADDRESS_FROM: u32 = 0x84_0000;

/// Place (x, y) and velocity of each target at each whole second.
type Truth = BTreeMap<(i64, u32), [f64; 4]>;

fn truth(text: &str) -> Truth {
    let [time_s, id, x, y, vx, vy] = ["time_s", "target_id", "x", "y", "vx", "vy"].map(|name| numbers(text, name));
    (0..time_s.len())
        .map(|row| ((time_s[row] as i64, id[row] as u32), [x[row], y[row], vx[row], vy[row]]))
        .collect()
}

/// Normalised squares of position and velocity of a table's rows, by the number of the target that `target` finds for a
/// row, its time and its place.
fn squares(text: &str, truth: &Truth, target: impl Fn(usize, i64, [f64; 2]) -> Option<u32>) -> Vec<(u32, [f64; 2])> {
    let names = ["time_s", "x", "y", "vx", "vy", "P00", "P01", "P11", "P33", "P34", "P44"];
    let columns = names.map(|name| numbers(text, name));
    let square = |[x, y]: [f64; 2], [xx, xy, yy]: [f64; 3]| {
        (x * x * yy - 2.0 * x * y * xy + y * y * xx) / (xx * yy - xy * xy) / 2.0
    };
    let row = |row: usize| {
        let [time_s, x, y, vx, vy, p00, p01, p11, p33, p34, p44] = columns.each_ref().map(|column| column[row]);
        let time_s = time_s.rem_euclid(86_400.0);
        let second = time_s as i64;
        let id = target(row, second, [x, y]).filter(|_| time_s.fract() == 0.0 && time_s >= SETTLED_S)?;
        let [true_x, true_y, true_vx, true_vy] = truth.get(&(second, id))?;
        let of_position = square([x - true_x, y - true_y], [p00, p01, p11]);
        let of_velocity = square([vx - true_vx, vy - true_vy], [p33, p34, p44]);
        Some((id, [of_position, of_velocity]))
    };
    (0..columns[0].len()).filter_map(row).collect()
}

/// Means of the squares of the chosen targets, with their number.
fn means(squares: &[(u32, [f64; 2])], chosen: impl Fn(u32) -> bool) -> ([f64; 2], usize) {
    let chosen: Vec<[f64; 2]> = squares
        .iter()
        .filter(|(id, _)| chosen(*id))
        .map(|(_, both)| *both)
        .collect();
    let sum = |place: usize| chosen.iter().map(|both| both[place]).sum::<f64>();
    ([0, 1].map(|place| sum(place) / chosen.len() as f64), chosen.len())
}

/// Tables of sensor tracks and system tracks of a deployment with this source in a recording. The targets are measured
/// at the times in the lines, which are multiples of half a second.
fn tables(home: &Home, place_deg: [f64; 2], source: &str) -> [String; 2] {
    let [latitude, longitude] = place_deg;
    let config = format!(
        "name = \"test\"\n[frame]\nlatitude_deg = {latitude:?}\nlongitude_deg = {longitude:?}\n\
         [time]\ndate = \"2020-01-01\"\norder = \"time\"\n[recorder]\nformat = [\"csv\"]\n\
         [[source]]\nname = \"own\"\nstamps = \"exact\"\n{source}"
    );
    home.write("test.toml", config);
    let up = "up test.toml --data . --speed max --instance test --out out";
    let output = home.run(&up.split(' ').collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    ["out/latest/sensor_tracks_own.csv", "out/latest/system_tracks.csv"].map(|table| home.read(table))
}

fn assert_honest(what: &str, ([position, velocity], count): ([f64; 2], usize), counts_velocity: bool) {
    println!("{what}: NEES of position {position:.2}, of velocity {velocity:.2}; {count} rows");
    assert!(count > 200 && BOUNDS.contains(&position), "{what}: {position}");
    assert!(!counts_velocity || BOUNDS.contains(&velocity), "{what}: {velocity}");
}

/// States of the targets of a truth as a receiver writes them, a line each, with errors of their categories: the NACp
/// of target n is 6 + n mod 6, its NACv 1 + n mod 4.
fn adsb_lines(truth: &Truth, heights_m: &BTreeMap<(i64, u32), f64>, seed: u64) -> String {
    let (_, frame) = system();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 {
        let [radius, turn]: [f64; 2] = [random.random_range(0.0..1.0), random.random_range(0.0..1.0)];
        (-2.0 * (1.0 - radius).ln()).sqrt() * (std::f64::consts::TAU * turn).cos()
    };
    let mut lines = String::new();
    for ((second, id), [x, y, vx, vy]) in truth {
        let [nacp, nacv] = [id % 6, id % 4];
        let sigma_m = NACP_M[nacp as usize] / RADIUS95_SIGMAS;
        let sigma_mps = NACV_MPS[nacv as usize] / RADIUS95_SIGMAS;
        let height_m = heights_m[&(*second, *id)];
        let [to_east, to_north, _] = frame.axes([*x, *y, height_m]);
        let [east, north] = [to_east, to_north].map(|axis| {
            let knots = (axis[0] * vx + axis[1] * vy + sigma_mps * normal()) / KT;
            knots.round()
        });
        let place = frame.to_geodetic([x + sigma_m * normal(), y + sigma_m * normal(), height_m]);
        let steps_deg = [
            STEP_M / 111_120.0,
            STEP_M / 111_120.0 / place.latitude_deg().to_radians().cos(),
        ];
        let rounded = [
            (place.latitude_deg(), steps_deg[0]),
            (place.longitude_deg(), steps_deg[1]),
        ]
        .map(|(degrees, step)| (degrees / step).round() * step);
        let _ = writeln!(
            lines,
            "{{\"now\":{},\"hex\":\"{:06x}\",\"type\":\"adsb_icao\",\"lat\":{},\"lon\":{},\"gs\":{},\"track\":{},\
             \"alt_baro\":{},\"nac_p\":{},\"nac_v\":{},\"nic\":8,\"sil\":3,\"version\":2,\"seen\":0,\"seen_pos\":0}}",
            MIDNIGHT_S + *second as f64,
            ADDRESS_FROM + id,
            rounded[0],
            rounded[1],
            east.hypot(north),
            east.atan2(north).to_degrees().rem_euclid(360.0),
            (place.height_m() / 0.3048).round(),
            6 + nacp,
            1 + nacv,
        );
    }
    lines
}

/// Aircraft that state NACp 6 to 11 in a run of their own.
#[test]
fn errors_of_ads_b_are_as_stated() {
    let home = Home::new();
    let simulate = "simulate --scenario demo --seed 5 --for 300 --set scenario.surface_share=0 --out air";
    let output = home.run(&simulate.split(' ').collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = home.read("air/truth.csv");
    let (truth, z_m) = (truth(&text), numbers(&text, "z"));
    let [time_s, id] = ["time_s", "target_id"].map(|name| numbers(&text, name));
    let heights_m = (0..z_m.len())
        .map(|row| ((time_s[row] as i64, id[row] as u32), z_m[row]))
        .collect();
    home.write("air.json", adsb_lines(&truth, &heights_m, 5));
    let source = "[source.recorded]\nfile = \"air.json\"\nformat = \"readsb\"\nreorder_s = 1.0\n\
                  [source.limits]\njump_m = 3000.0\n\
                  [source.covariance]\nfrom = \"report\"\nposition_sigma_m = 1.0\nvelocity_sigma_mps = 0.1\n\
                  [source.accuracy]\nmodel = \"reported\"\n";
    let [sensor, fused] = tables(&home, crate::common::PLACE, source);
    for (what, text, is_report) in [("reports", &sensor, true), ("system tracks", &fused, false)] {
        let addresses = column(text, "address");
        let of_row = |row: usize, _, _| {
            let address = u32::from_str_radix(&addresses[row], 16).ok()?;
            address.checked_sub(ADDRESS_FROM)
        };
        let squares = squares(text, &truth, of_row);
        for nacp in 0..6 {
            let what = format!("{what}, NACp {}", 6 + nacp);
            assert_honest(&what, means(&squares, |id| id % 6 == nacp), is_report);
        }
    }
}

/// Ships of the shipped coast.
#[test]
fn errors_of_ais_are_as_stated() {
    let home = Home::new();
    home.write("coast.toml", include_str!("../config/coast.toml"));
    let simulate = "simulate --scenario coast.toml --set scenario.targets=60 --seed 5 --for 900 --out sea";
    let output = home.run(&simulate.split(' ').collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let truth = truth(&home.read("sea/truth.csv"));
    let source = "period_s = 10.0\nfresh_s = 65.0\n[source.recorded]\nfile = \"sea/ais_3.nmea\"\nformat = \"ais\"\n\
                  [source.covariance]\nfrom = \"report\"\nposition_sigma_m = 1.0\nvelocity_sigma_mps = 0.05\n\
                  [source.accuracy]\nmodel = \"reported\"\n";
    let [sensor, fused] = tables(&home, [34.75, 139.35], source);
    let mut by_second: BTreeMap<i64, Vec<(u32, [f64; 2])>> = BTreeMap::new();
    for ((second, id), [x, y, ..]) in &truth {
        by_second.entry(*second).or_default().push((*id, [*x, *y]));
    }
    // Ships are kilometres apart.
    let nearest = |_: usize, second: i64, [x, y]: [f64; 2]| {
        let far = |place: [f64; 2]| (place[0] - x).hypot(place[1] - y);
        let found = by_second
            .get(&second)?
            .iter()
            .min_by(|one, other| far(one.1).total_cmp(&far(other.1)))?;
        (far(found.1) < 500.0).then_some(found.0)
    };
    for (what, text, is_report) in [
        ("reports of ships", &sensor, true),
        ("system tracks of ships", &fused, false),
    ] {
        assert_honest(what, means(&squares(text, &truth, nearest), |_| true), is_report);
    }
}

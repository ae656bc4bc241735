//! Tables whose times count from 1970 instead of from a midnight: the commands on files make the same of them.

use std::fmt::Write as _;

use test_support::since_1970;

use crate::common::Folder;

/// Commands on the tables of a folder, with the columns of their outputs that hold times.
struct Case {
    tables: &'static [&'static str],
    /// `{}` stands for the ending of the names of tables and outputs.
    command: &'static str,
    outputs: &'static [&'static str],
}

/// Columns of times.
const TIMES: [&str; 2] = ["time_s", "arrival_s"];

fn check(folder: &Folder, case: &Case) {
    for table in case.tables {
        folder.write(
            &format!("{table}70.csv"),
            since_1970(&folder.read(&format!("{table}.csv")), &TIMES),
        );
    }
    folder.succeed(&case.command.replace("{}", ""));
    folder.succeed(&case.command.replace("{}", "70"));
    for output in case.outputs {
        let [midnight, since] = ["", "70"].map(|ending| folder.read(&format!("{output}{ending}.csv")));
        assert!(midnight.lines().count() > 3, "{midnight}");
        let moved = since_1970(&midnight, &TIMES);
        let different = moved.lines().zip(since.lines()).find(|(moved, since)| moved != since);
        assert_eq!(different, None, "{}", case.command);
        assert_eq!(moved.len(), since.len(), "{}", case.command);
    }
    // One table that counts from elsewhere than the others is named.
    let [first, others @ ..] = case.tables else {
        panic!("{} has no tables", case.command)
    };
    for other in others {
        let mixed = case
            .command
            .replace(&format!("{other}{{}}"), &format!("{other}70"))
            .replace("{}", "");
        let line = folder.refusal(&mixed.replace("--out ", "--out mixed_"));
        let expected = format!("{other}70.csv: times count from 1970, but those of {first}.csv from a midnight");
        assert!(line.contains(&expected), "{mixed}: {line}");
    }
}

#[test]
fn detections_counts_and_emissions_are_tracked_alike() {
    let folder = Folder::new();
    let header = "time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz,truth_id\n";
    let (mut plots, mut counts) = (
        header.to_owned(),
        "time_s,arrival_s,x,y,z,vx,vy,vz,count,route\n".to_owned(),
    );
    let mut heard =
        "time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz,heading_rad,frequency_hz,pulse_interval_s\n".to_owned();
    for second in 0..30 {
        let east = 15 * second;
        match second {
            7 => writeln!(plots, "7.125,1,7,,none,,,,,,,,,,,,").unwrap(),
            _ => writeln!(
                plots,
                "{second}.125,1,{second},0,position2,{east},{second},,,10,10,,,0,0,0,"
            )
            .unwrap(),
        }
        if second % 5 == 4 {
            writeln!(counts, "{second}.5,{}.75,{},0,0,15,0,0,2,", second + 3, east + 300).unwrap();
            let bearing = f64::from(east + 3_000).atan2(4_000.0);
            writeln!(heard, "{second}.25,,{bearing},0.02,-3000,-4000,0,,9.41e9,1e-3").unwrap();
        }
    }
    folder.write("plots.csv", plots);
    folder.write("counts.csv", counts);
    folder.write("heard.csv", heard);
    folder.write(
        "track.toml",
        "[[sensor]]\nid = 1\nclutter_density = 1e-6\n[[wide_area.type]]\nname = \"ferry\"\n\
         emissions = [{ frequency_hz = [9.3e9, 9.5e9] }]\n",
    );
    check(
        &folder,
        &Case {
            tables: &["plots", "counts", "heard"],
            command: "track --detections plots{}.csv --config track.toml --wide-area counts{}.csv \
                      --emissions heard{}.csv --out tracks{}.csv",
            outputs: &["tracks"],
        },
    );
}

#[test]
fn detections_and_states_of_a_platform_are_tracked_alike() {
    let folder = Folder::new();
    folder.succeed("simulate --scenario on-board --seed 1 --for 60 --out .");
    check(
        &folder,
        &Case {
            tables: &["detections", "platform"],
            command: "track --detections detections{}.csv --platform platform{}.csv --config mounting.toml \
                      --out tracks{}.csv",
            outputs: &["tracks"],
        },
    );
}

#[test]
fn bearings_arrivals_and_fixes_are_located_alike() {
    let folder = Folder::new();
    let mut fixes = "time_s,emitter_id,x,y,z,Pxx,Pxy,Pyy\n".to_owned();
    let mut bearings = "time_s,emitter_id,kind,bearing_rad,sigma_rad,sigma_s,px,py,pz,receiver,receiver_2,px_2,py_2,\
                        pz_2,tdoa_s\n"
        .to_owned();
    for second in 0..20 {
        writeln!(fixes, "{second},4,3400,-4000,0,250000,0,100").unwrap();
        let bearing = std::f64::consts::PI;
        writeln!(bearings, "{second}.5,4,bearing,{bearing},0.001,,3000,6000,0,,,,,,").unwrap();
        writeln!(bearings, "{second}.625,4,tdoa,,,1e-8,0,0,0,a,b,6000,0,0,0").unwrap();
    }
    folder.write("fixes.csv", fixes);
    folder.write("bearings.csv", bearings);
    check(
        &folder,
        &Case {
            tables: &["bearings", "fixes"],
            command: "locate --bearings bearings{}.csv --fixes fixes{}.csv --explain why{}.csv --out out{}.csv",
            outputs: &["out", "why"],
        },
    );
}

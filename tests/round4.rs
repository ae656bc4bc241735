//! Recordings on which Koseki once failed, a function for each case of the folder `round4`.

use test_support::{column, recordings};

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

/// Reports of one track without a velocity, 0.4 s apart, of a target at 60 m/s: it is not taken for one that stands
/// still.
#[test]
fn bugs_position_only_track() {
    const CASE: &str = "round4/bugs/position-only-track/track.csv";
    let Some(data) = recordings(CASE) else { return };
    let folder = Folder::with::<&str>(&[]);
    folder.succeed(&format!("fuse --tracks {} --out fused.csv", data.join(CASE).display()));
    let fused = folder.read("fused.csv");
    let numbers = |name: &str| -> Vec<f64> {
        let cells = column(&fused, name).into_iter();
        cells.map(|cell| cell.parse().unwrap()).collect()
    };
    let [times_s, places_m, variances_m2, known] = ["time_s", "x", "P00", "velocity_valid"].map(numbers);
    let from = 3;
    assert!(times_s.len() > 30, "{} rows", times_s.len());
    assert_eq!(
        (known[0], known[from]),
        (0.0, 1.0),
        "the first position shows no velocity"
    );
    for ((time_s, place_m), variance_m2) in times_s.iter().zip(&places_m).zip(&variances_m2).skip(from) {
        let error_m = place_m - 60.0 * (time_s - times_s[0]);
        let sigma_m = variance_m2.sqrt();
        assert!(error_m.abs() <= 3.0 * sigma_m, "{time_s} s: {error_m} m at {sigma_m} m");
    }
}

/// A deployment of one source with a recording, as data blocks of the default editions.
fn recorded(name: &str) -> String {
    format!(
        "name = \"kinds\"\n[frame]\nlatitude_deg = 41.0\nlongitude_deg = 2.0\n[time]\ndate = \"2016-05-10\"\n\
         [[source]]\nname = \"radar\"\n[source.recorded]\nfile = \"{name}\"\n"
    )
}

/// Text of which two letters are a length of a data block: every command names it, and none sends it.
#[test]
fn text_kinds() {
    const CASE: &str = "round4/text-kinds";
    let Some(data) = recordings(CASE) else { return };
    for (name, kind) in [("receiver.sbs", "it is an SBS log"), ("history.jsonl", "it is JSON")] {
        let file = data.join(CASE).join(name);
        let configuration = recorded(&file.display().to_string());
        let folder = Folder::with(&[("live.toml", configuration.as_bytes())]);
        let file = file.display();
        let mut commands = vec![
            (2, format!("decode {file} --out x.jsonl")),
            (2, format!("decode {file} --statistics")),
            (2, "check live.toml".to_owned()),
            (2, "up live.toml --for 1".to_owned()),
        ];
        if name == "history.jsonl" {
            commands.push((2, format!("send {file} --to 127.0.0.1:9")));
        }
        for (code, command) in commands {
            let said = folder.line_of(code, &command);
            assert!(said.contains(kind), "{command}: {said}");
            for wrong in [".gps", "cut short"] {
                assert!(!said.contains(wrong), "{command}: {said}");
            }
        }
    }
}

/// ADS-B of edition 0.23, read as 2.4: every command names the edition.
#[test]
fn recordings_of_another_edition() {
    const CASE: &str = "lebl2016/160510-lebl-220001_ADSB_cat21_v023.ast";
    let Some(data) = recordings(CASE) else { return };
    let file = data.join(CASE);
    let configuration = recorded(&file.display().to_string());
    let folder = Folder::with(&[("live.toml", configuration.as_bytes())]);
    let file = file.display();
    for (command, remedy) in [
        (
            "check live.toml",
            "set source[0].recorded.editions = { \"21\" = \"0.23\" }",
        ),
        (
            "up live.toml --for 1",
            "set source[0].recorded.editions = { \"21\" = \"0.23\" }",
        ),
        (
            &format!("send {file} --to 127.0.0.1:9 --retime now"),
            "add --edition 21=0.23",
        ),
    ] {
        let said = folder.line_of(2, command);
        assert!(
            said.contains("category 021: ") && said.contains(remedy),
            "{command}: {said}"
        );
    }
    let decoded = folder.run(&format!("decode {file} --statistics"));
    assert!(String::from_utf8_lossy(&decoded.stderr).contains("try --edition 21=0.23"));
    folder.succeed("check live.toml --set source[0].recorded.editions={\"21\"=\"0.23\"}");
}

/// Files in which nothing is known of any position, or a variance is beyond all limits.
#[test]
fn bugs_all_rows_invalid() {
    for (name, limit) in [("zero", "is 0, so nothing is known"), ("huge", "is beyond 1e14")] {
        let case = format!("round4/bugs/all-rows-invalid/{name}.csv");
        let Some(data) = recordings(&case) else { return };
        let folder = Folder::with::<&str>(&[]);
        let said = folder.line_of(
            2,
            &format!("fuse --tracks {} --out fused.csv", data.join(&case).display()),
        );
        assert!(said.contains("line 2, column P00") && said.contains(limit), "{said}");
    }
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

/// A target that is reported every 4 to 38 s, and once after nine minutes, beside four that are every 5 s: it is shown
/// from its third report at the latest, under one number.
#[test]
fn irregular_address() {
    const CASE: &str = "round4/irregular-address/target.csv";
    let Some(data) = recordings(CASE) else { return };
    let folder = Folder::with::<&str>(&[]);
    folder.succeed(&format!("fuse --tracks {} --out states.csv", data.join(CASE).display()));
    let text = folder.read("states.csv");
    let mut rows = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = rows.next().unwrap();
    let column = |name: &str| header.iter().position(|column| *column == name).unwrap();
    let (time, number, state, address) = (
        column("time_s"),
        column("system_track_id"),
        column("state"),
        column("address"),
    );
    let rows: Vec<_> = rows.filter(|row| row[address] == "ABCD01").collect();
    let numbers: std::collections::BTreeSet<_> = rows.iter().map(|row| row[number]).collect();
    assert_eq!(numbers.len(), 1, "{numbers:?}");
    let shown_from = rows.iter().find(|row| row[state] == "confirmed").map(|row| row[time]);
    assert!(
        ["1009", "1028"].map(Some).contains(&shown_from),
        "second or third report: {shown_from:?}"
    );
    assert_eq!(
        rows.last().map(|row| (row[time], row[state])),
        Some(("1745", "confirmed"))
    );
}

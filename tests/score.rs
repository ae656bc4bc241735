//! `koseki score` as a user calls it: figures as text and as JSON, and what it refuses.

use std::fs;

use crate::common::Folder;

/// One target at rest; a track 3 m east and 4 m north of it.
fn picture() -> Folder {
    let header = "time_s,system_track_id,x,y,z,vx,vy,vz";
    Folder::with(&[
        (
            "truth.csv",
            "time_s,target_id,x,y,z,vx,vy,vz\n10,1,0,0,0,0,0,0\n11,1,0,0,0,0,0,0\n",
        ),
        (
            "fused.csv",
            &format!("{header},state\n10,4,3,4,0,0,0,0,confirmed\n11,4,3,4,0,0,0,0,coasted\n"),
        ),
        ("broken.csv", &format!("{header}\n10,4,3,4,0,0,0,0\n11,4,3,?,0,0,0,0\n")),
        ("other.csv", "time_s,x,y\n"),
    ])
}

#[test]
fn a_picture_is_scored_as_text_and_as_json() {
    let files = picture();
    let found = files.json("score --json --truth truth.csv --tracks fused.csv");
    for (word, expected) in [
        ("gospa", 5.0),
        ("rmse_pos", 5.0),
        ("completeness", 1.0),
        ("wander_max", 0.0),
    ] {
        assert_eq!(found[word].as_f64(), Some(expected), "{word}");
    }
    assert_eq!((&found["id_switches"], &found["system_tracks"]), (&0.into(), &1.into()));
    assert!(found["direction_std_deg"].is_null(), "the target stands still");
    // Beyond the cut-off; and one second only.
    let found = files.json("score --json --truth truth.csv --tracks fused.csv --c 4 --t0 11 --t1 11");
    assert_eq!(
        (found["gospa"].as_f64(), found["missed_per_s"].as_f64()),
        (Some(4.0), Some(1.0))
    );

    let output = files.run("score --truth truth.csv --tracks fused.csv");
    let text = String::from_utf8(output.stdout).unwrap();
    let line = text.lines().find(|line| line.starts_with("rmse_pos")).unwrap();
    assert_eq!(
        line.split_whitespace().take(3).collect::<Vec<_>>(),
        ["rmse_pos", "5", "m"]
    );
    let line = text.lines().find(|line| line.starts_with("direction_std_deg")).unwrap();
    assert_eq!(line.split_whitespace().nth(1), Some("-"));
}

/// A target that flies east for 60 s at Barcelona, and a track 5 m beside it.
fn flight() -> Folder {
    let rows = |id: u32, north: i32, end: &str| -> String {
        let row = |second: i32| format!("{second},{id},{},{north},900,100,0,0{end}\n", 100 * second);
        (0..=60).map(row).collect()
    };
    let header = "x,y,z,vx,vy,vz";
    let runway = |properties: &str| {
        format!(
            r#"{{"type": "Feature", "properties": {properties}, "geometry": {{"type": "Polygon", "coordinates":
               [[[2.11, 41.29], [2.14, 41.29], [2.14, 41.3], [2.11, 41.3], [2.11, 41.29]]]}}}}"#
        )
    };
    Folder::with(&[
        (
            "truth.csv",
            &format!("time_s,target_id,{header},address\n{}", rows(1, 0, ",3444CF")),
        ),
        (
            "fused.csv",
            &format!(
                "time_s,system_track_id,{header},state,address\n{}",
                rows(8, 5, ",confirmed,3444CF")
            ),
        ),
        (
            "areas.geojson",
            &format!(
                r#"{{"type": "FeatureCollection", "features": [{}, {}]}}"#,
                runway(r#"{"name": "<07L>", "kind": "runway"}"#),
                runway("{}")
            ),
        ),
        ("lake.geojson", &runway(r#"{"kind": "lake"}"#)),
    ])
}

const ORIGIN: &str = "--origin 41.297063,2.078447";
const STANDARDS: &str = "--standard ed-87,ed-116,ed-117,ed-142,esassp";

#[test]
fn a_scorecard_has_every_line_of_every_standard_with_a_verdict() {
    let files = flight();
    let asked = format!("score --json --truth truth.csv --tracks fused.csv {STANDARDS} --areas areas.geojson {ORIGIN}");
    let found = files.json(&asked);
    assert_eq!(found["rmse_pos"].as_f64(), Some(5.0), "the figures of before stay");
    assert_eq!(
        (&found["reference"], &found["target_seconds"]),
        (&"truth".into(), &36.into())
    );
    let straight = &found["phases"]["straight"];
    assert_eq!(
        (straight["across"]["mean"].as_f64(), straight["along"]["rms"].as_f64()),
        (Some(-5.0), Some(0.0))
    );
    assert_eq!(found["phases"].as_object().unwrap().len(), 13);
    let counts = |card: &serde_json::Value| -> Vec<usize> {
        let standards = card["standards"].as_array().unwrap().iter();
        standards
            .map(|standard| standard["lines"].as_array().unwrap().len())
            .collect()
    };
    assert_eq!(counts(&found), [16, 7, 16, 8, 12]);
    assert_eq!(counts(&found["areas"][0]), [11, 7, 9, 4, 8], "a runway");
    assert_eq!(counts(&found["areas"][1]), counts(&found));
    // The area reaches from 2.6 to 5.2 km to the east.
    assert_eq!(found["areas"][0]["target_seconds"], 25);
    let line = &found["standards"][0]["lines"][1];
    assert_eq!(
        (
            &line["line"],
            line["figure"].as_f64(),
            line["limit"].as_f64(),
            &line["comparison"],
            &line["verdict"]
        ),
        (
            &"position_p95".into(),
            Some(5.0),
            Some(12.0),
            &"<=".into(),
            &"pass".into()
        )
    );

    let smoothed = files.json(&format!("{asked} --reference smoothed")).to_string();
    assert!(
        smoothed.contains("\"precision only\"") && !smoothed.contains("\"pass\"") && !smoothed.contains("\"fail\"")
    );

    let text = String::from_utf8(files.run(&asked.replace("--json", "")).stdout).unwrap();
    for expected in [
        "rmse_pos                           5 m    position error of the pairs",
        "Compared with the truth: a line passes or fails.",
        "<07L> (runway): 1 targets, 25 target-seconds, 25 with a track",
        "EUROCONTROL-SPEC-0147 (ESASSP)",
    ] {
        assert!(text.contains(expected), "{expected}:\n{text}");
    }
    let line = |name: &str| text.lines().find(|line| line.starts_with(name)).unwrap();
    assert!(
        line("update_1s").contains("1      >= 0.99     pass"),
        "{}",
        line("update_1s")
    );
    assert!(
        line("longest_gap").contains("1 s                no limit known"),
        "{}",
        line("longest_gap")
    );
}

/// A recording counts seconds of the day; the truth has gaps, and the radar no heights.
#[test]
fn what_was_compared_is_printed_and_nothing_else_counts() {
    let header = "x,y,z,vx,vy,vz";
    let truth: String = (0..40)
        .filter(|second| *second != 30)
        .map(|second| format!("{},1,{},0,3000,100,0,0\n", 43_200 + second, 100 * second))
        .collect();
    let track = |second: i32| format!("{},8,{},4,0,100,0,0,confirmed,0\n", 43_200 + second, 100 * second + 3);
    let tracks: String = (-300..300).map(track).collect();
    let since_1970: String = truth
        .lines()
        .map(|row| {
            let (time, rest) = row.split_once(',').unwrap();
            format!("{},{rest}\n", 1_767_139_200 + time.parse::<i64>().unwrap())
        })
        .collect();
    let files = Folder::with(&[
        ("truth.csv", &format!("time_s,target_id,{header}\n{truth}")),
        ("unix.csv", &format!("time_s,target_id,{header}\n{since_1970}")),
        (
            "radar.csv",
            &format!("time_s,sensor_track_id,{header},state,height_valid\n{tracks}"),
        ),
    ]);
    let found = files.json("score --json --truth truth.csv --tracks radar.csv");
    let figures = ["gospa", "rmse_pos", "completeness"].map(|word| found[word].as_f64());
    assert_eq!(figures, [Some(5.0), Some(5.0), Some(1.0)]);
    assert_eq!((&found["spurious"], &found["false_per_s"]), (&0.into(), &0.0.into()));
    let compared = &found["compared"];
    let counts = [
        "first_s",
        "last_s",
        "seconds",
        "seconds_without_truth",
        "pairs",
        "pairs_without_height",
    ];
    assert_eq!(
        counts.map(|word| compared[word].as_i64().unwrap()),
        [43_210, 43_239, 29, 1, 29, 29]
    );
    assert_eq!(found, files.json("score --json --truth unix.csv --tracks radar.csv"));
    let text = String::from_utf8(files.run("score --truth truth.csv --tracks radar.csv").stdout).unwrap();
    for expected in [
        "Compared: 29 whole seconds from 43210 s to 43239 s, 1 targets (target-seconds: 29), 1 tracks",
        "1 seconds in between without a row of the truth are left out.",
        "29 pairs have no height on one side: the plane alone is compared.",
    ] {
        assert!(text.contains(expected), "{expected}:\n{text}");
    }
    for (arguments, expected) in [
        ("--truth radar.csv --tracks radar.csv", "--reference independent"),
        ("--truth radar.csv --tracks truth.csv", "column target_id is missing"),
    ] {
        let line = files.refusal(&format!("score {arguments}"));
        assert!(line.contains(expected), "{arguments}: {line}");
    }
    files.succeed("score --truth radar.csv --reference independent --tracks truth.csv --settle 0");
    // The simulation that the tracks are not of.
    let files = Folder::with(&[
        ("truth.csv", &format!("time_s,target_id,{header}\n{truth}")),
        (
            "early.csv",
            &format!("time_s,system_track_id,{header}\n10,1,0,0,0,0,0,0\n"),
        ),
    ]);
    let line = files.refusal("score --truth truth.csv --tracks early.csv");
    assert!(line.contains("no second is common to both"), "{line}");
}

#[test]
fn the_page_of_a_scorecard_stands_alone() {
    let files = flight();
    let asked = "score --truth truth.csv --tracks fused.csv --areas areas.geojson --html card.html";
    files.succeed(&format!("{asked} {ORIGIN} {STANDARDS}"));
    let page = files.read("card.html");
    assert_eq!(
        page.matches("<figure>").count(),
        3 * 4,
        "no covariance, so no picture of it"
    );
    assert_eq!(page.matches("</svg>").count(), page.matches("<svg ").count());
    assert!(page.contains("&lt;07L&gt; (runway)") && !page.contains("<07L>"));
    for word in ["<script", "http", "src=", "@import", "url("] {
        assert!(!page.contains(word), "{word}");
    }
    // An area without a target, and a comparison that is too short.
    let elsewhere = "--origin 50,2";
    files.succeed(&format!("{asked} {elsewhere} --settle 100 {STANDARDS}"));
    let page = files.read("card.html");
    assert!(page.contains("No target counts here.") && page.contains("not measured"));
    let text = String::from_utf8(
        files
            .run("score --truth truth.csv --tracks fused.csv --settle 100")
            .stdout,
    )
    .unwrap();
    assert!(!text.contains("phase"), "{text}");
}

#[test]
fn two_pictures_are_held_against_each_other() {
    let header = "time_s,system_track_id,x,y,z,vx,vy,vz,state\n";
    let moves = |east: f64| {
        let row = |second: i32| format!("{second},1,{},0,0,10,0,0,confirmed\n", east + 10.0 * f64::from(second));
        (100..110).map(row).collect::<String>()
    };
    let also = "100,7,9000,0,0,0,0,0,confirmed\n104,8,0,9000,0,0,0,0,tentative\n";
    let files = Folder::with(&[("after.csv", format!("{header}{}{also}", moves(3.0)))]);
    fs::create_dir(files.path("before")).unwrap();
    files.write("before/system_tracks.csv", format!("{header}{}", moves(0.0)));
    let same = files.json("compare pictures before before --json");
    let figures = ["gospa", "rmse_pos", "missed_per_s", "false_per_s"];
    assert_eq!(figures.map(|word| same[word].as_f64()), [Some(0.0); 4]);
    let found = files.json("compare pictures before after.csv --json --max-age 2");
    assert_eq!(found["rmse_pos"].as_f64(), Some(3.0));
    assert_eq!(found["missed_per_s"].as_f64(), Some(0.0));
    assert_eq!(found["false_per_s"].as_f64(), Some(0.2), "two seconds of ten");
    assert_eq!(found["system_tracks"], 2, "what is tentative is not shown");
    let back = files.json("compare pictures after.csv before --json --max-age 2");
    assert_eq!(back["missed_per_s"].as_f64(), Some(0.2));
    let text = String::from_utf8(files.run("compare pictures before after.csv").stdout).unwrap();
    assert!(text.starts_with("gospa "), "{text}");
}

#[test]
fn what_cannot_be_scored_is_refused_with_file_place_and_remedy() {
    let files = picture();
    for (arguments, expected) in [
        ("--truth gone.csv --tracks fused.csv", "gone.csv: cannot be read"),
        (
            "--truth truth.csv --tracks broken.csv",
            "broken.csv: line 3, column y: \"?\" is no number",
        ),
        (
            "--truth truth.csv --tracks other.csv",
            "other.csv: header: column system_track_id is missing",
        ),
        ("--truth truth.csv --tracks fused.csv --t0 12", "see --t0 and --t1"),
        ("--truth truth.csv", "--tracks <FILE>"),
        (
            "--truth truth.csv --tracks fused.csv --gate 0",
            "it must be more than 0",
        ),
        (
            "tracks --truth truth.csv truth.csv --tracks fused.csv",
            "--truth names 2 files and --tracks 1",
        ),
        (
            "tracks --truth truth.csv --tracks fused.csv --since 12",
            "earlier --since",
        ),
        ("fixes --truth truth.csv --fixes fused.csv", "meta.json: cannot be read"),
    ] {
        let line = files.refusal(&format!("score {arguments}"));
        assert!(line.contains(expected), "{arguments}: {line}");
    }
    let files = flight();
    for (arguments, expected) in [
        ("--areas areas.geojson", "--origin"),
        ("--areas areas.geojson --origin 41", "latitude and longitude in degrees"),
        ("--areas areas.geojson --origin 141,2", "latitude"),
        ("--areas gone.geojson --origin 41.3,2.1", "gone.geojson: cannot be read"),
        ("--areas truth.csv --origin 41.3,2.1", "areas are GeoJSON, or airspaces"),
        ("--areas lake.geojson --origin 41.3,2.1", "the kind \"lake\" is unknown"),
        ("--standard ed-88", "ed-87"),
        ("--reference me", "smoothed"),
    ] {
        let line = files.refusal(&format!("score --truth truth.csv --tracks fused.csv {arguments}"));
        assert!(line.contains(expected), "{arguments}: {line}");
    }
}

#[test]
fn several_runs_are_pooled_in_one_call() {
    let tracks = |x: u32| {
        format!("time_s,sensor_track_id,x,y,vx,vy,state\n10,4,{x},0,0,0,confirmed\n11,4,{x},0,0,0,confirmed\n")
    };
    let files = Folder::with(&[
        ("truth.csv", "time_s,target_id,x,y\n10,1,0,0\n11,1,0,0\n"),
        ("near.csv", &tracks(100)),
        ("far.csv", &tracks(5000)),
    ]);
    let one = files.json("score tracks --json --truth truth.csv --tracks near.csv");
    assert_eq!((one["count_right"].as_f64(), one.get("runs")), (Some(1.0), None));
    let both = files.json("score tracks --json --truth truth.csv truth.csv --tracks near.csv far.csv");
    assert_eq!(
        (both["count_right"].as_f64(), &both["false_tracks"]),
        (Some(0.5), &1.into())
    );
    assert_eq!((&both["runs"], &both["each"][0]), (&2.into(), &one));
    let wide = files.json("score tracks --json --truth truth.csv --tracks far.csv --gate 6000");
    assert_eq!(wide["covered"].as_f64(), Some(1.0));
}

#[test]
fn fixes_are_scored_by_the_case_that_stands_beside_the_truth() {
    let files = Folder::with(&[
        (
            "meta.json",
            "{\"case\": \"turn\", \"baseline\": 10000.0, \"sigma_deg\": 1.0, \"runs\": 2, \"seed\": 1}",
        ),
        ("truth.csv", "time_s,emitter_id,x,y\n500,0,0,0\n502,0,0,0\n"),
        (
            "fixes.csv",
            "time_s,emitter_id,x,y,z,vx,vy,vz,variance_m2,raw_x,raw_y\n\
             500,0,3,4,0,0,0,0,1,0,7\n502,0,3,4,0,0,0,0,1,0,7\n",
        ),
    ]);
    let found = files.json("score fixes --json --truth truth.csv --fixes fixes.csv");
    assert_eq!((&found["runs"], &found["runs_without_fix"]), (&1.into(), &1.into()));
    assert_eq!(
        (found["rmse"].as_f64(), found["raw_rmse"].as_f64()),
        (Some(5.0), Some(7.0))
    );
    let pooled = files.json("score fixes --json --truth truth.csv truth.csv --fixes fixes.csv fixes.csv");
    assert_eq!((&pooled["runs"], &pooled["runs_without_fix"]), (&2.into(), &2.into()));
    fs::write(files.path("meta.json"), "{\"case\": \"loop\"}").unwrap();
    let line = files.refusal("score fixes --truth truth.csv --fixes fixes.csv");
    assert!(line.contains("meta.json: ") && line.contains("`loop`"), "{line}");
}

/// Two aircraft meet head on at 200 s, from 177 s on nearer than 5 NM.
#[test]
fn alerts_are_scored_as_text_and_as_json_and_bad_ones_refused() {
    let rows = |id: &str| {
        let row = |second: i32| {
            let x = 200 * (second - 200);
            format!("{second},1,{x},0,9000,200,0,0\n{second},2,{},0,9000,-200,0,0\n", -x)
        };
        let all: String = (0..=400).map(row).collect();
        format!("time_s,{id},x,y,z,vx,vy,vz\n{all}")
    };
    let header = "time_s,event,alert,rule,kind,system_track_id,other_system_track_id,area,probability,time_to_s";
    let zone =
        &r#"{"type": "Feature", "properties": {"name": "Zone", "ceiling": "FL310"}, "geometry": {"type": "Polygon",
        "coordinates": [[[2.0, 41.2], [2.2, 41.2], [2.2, 41.4], [2.0, 41.4], [2.0, 41.2]]]}}"#
            .to_owned();
    let files = Folder::with(&[
        ("truth.csv", &rows("target_id")),
        ("fused.csv", &rows("system_track_id")),
        (
            "alerts.csv",
            &format!(
                "{header}\n77,raised,3,stca,conflict,1,2,,0.6,100\n90,raised,4,low,low,1,,,1,\n\
                 150,raised,5,zone,enter,2,,Zone,1,\n160,predicted,,stca,conflict,2,1,,0.75,17\n"
            ),
        ),
        (
            "broken.csv",
            &format!("{header}\n77,raised,3,stca,conflct,1,2,,0.6,100\n"),
        ),
        (
            "other.csv",
            &format!("{header}\n77,raised,3,zone,enter,1,,Elsewhere,0.6,100\n"),
        ),
        ("zone.json", zone),
    ]);
    let score = "score alerts --truth truth.csv --tracks fused.csv --alerts";
    let found = files.json(&format!(
        "{score} alerts.csv --areas zone.json --origin 41.3,2.1 --json"
    ));
    let kinds = found["kinds"].as_array().unwrap();
    let of = |word: &str| kinds.iter().find(|kind| kind["kind"] == word).unwrap();
    assert_eq!(
        (&of("conflict")["hits"], &of("conflict")["misses"]),
        (&1.into(), &0.into())
    );
    assert!(
        (of("conflict")["lead_s_median"].as_f64().unwrap() - 99.85).abs() < 0.1,
        "{found}"
    );
    assert_eq!((&of("enter")["events"], &of("enter")["hits"]), (&2.into(), &1.into()));
    assert_eq!((&of("low")["alerts"], of("low").get("hits")), (&1.into(), None));
    assert_eq!(found["reliability"][0]["bins"][7]["violated"], 1);

    let output = files.run(&format!("{score} alerts.csv --minimum-nm 1 --minimum-ft 300"));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("give --origin") && text.contains("\nlow: 1 alerts\nnot judged\n"),
        "{text}"
    );
    for (rest, expected) in [
        ("broken.csv", "is no kind; write enter, leave"),
        (
            "other.csv --areas zone.json --origin 41.3,2.1",
            "has no area \"Elsewhere\"",
        ),
        ("alerts.csv --areas zone.json", "--origin"),
        ("absent.csv", "absent.csv"),
    ] {
        let output = files.run(&format!("{score} {rest}"));
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && text.contains(expected), "{text}");
    }
}

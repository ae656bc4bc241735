//! Mistakes on the command line: each is refused in one line that names what is wrong and what is possible.

use crate::common::{Folder, repository};

/// Command lines, and words that their refusals contain.
const MISTAKES: [(&str, &[&str]); 20] = [
    ("upp", &["unrecognized subcommand 'upp'", "'up'"]),
    (
        "recording",
        &["a command is missing", "info, cut, merge, repair, export"],
    ),
    ("--json status", &["it follows the command: koseki status --json"]),
    ("--once top", &["it follows the command: koseki top --once"]),
    ("demo --for -5", &["'-5'", "--for", "more than 0"]),
    ("demo --for -0.5", &["'-0.5'", "--for", "more than 0"]),
    ("demo --for=-5", &["'-5'", "--for", "more than 0"]),
    ("top --interval -1", &["'-1'", "--interval"]),
    ("demo --fr 5", &["did you mean --for?"]),
    (
        "track absent.csv",
        &["unexpected argument 'absent.csv'", "koseki track --help"],
    ),
    ("up absent.toml", &["absent.toml", "cannot be read"]),
    ("up there.toml", &["there.toml", "did you mean config/there.toml?"]),
    ("check there.toml", &["there.toml", "did you mean config/there.toml?"]),
    ("up .", &[".: cannot be read", "directory"]),
    ("up bad.csv", &["bad.csv:1", "key with no value"]),
    (
        "fuse --tracks absent.csv --out o.csv",
        &["absent.csv", "cannot be read"],
    ),
    (
        "fuse --tracks bad.csv --out o.csv",
        &["bad.csv", "column time_s is missing"],
    ),
    (
        "simulate --scenario nowhere --for 5 --out o",
        &["nowhere", "there are demo"],
    ),
    ("tap nothing --instance none", &["nothing", "no topic"]),
    ("top --instance none", &["no instance none runs", "koseki status"]),
];

#[test]
fn mistakes_are_refused_by_what_is_wrong() {
    let folder = Folder::new();
    folder.write("bad.csv", "a,b\n");
    std::fs::create_dir(folder.path("config")).unwrap();
    folder.write("config/there.toml", "");
    for (command, expected) in MISTAKES {
        let said = folder.refusal(command);
        assert!(!said.contains("error:"), "{command}: {said}");
        for words in expected {
            assert!(said.contains(words), "{command}: {words} is missing in {said}");
        }
    }
}

/// Commands that read FILE, which the command line names.
const READERS: [&str; 40] = [
    "up FILE",
    "check FILE",
    "doctor FILE",
    "adapter --config FILE --name a",
    "fusion --config FILE",
    "monitor --config FILE",
    "recorder --config FILE",
    "gateway --config FILE --name a",
    "simulator --config FILE",
    "display --config FILE",
    "display --recording FILE",
    "recording info FILE",
    "recording cut FILE --out o",
    "recording merge FILE --out o",
    "recording repair FILE --out o",
    "recording export FILE --asterix o",
    "replay FILE",
    "replay FILE --verify",
    "smooth FILE --out o",
    "decode FILE",
    "decode FILE --out o",
    "decode FILE --statistics --json o",
    "encode FILE --out o",
    "send FILE --to 127.0.0.1:9",
    "simulate --scenario FILE --for 1 --out o",
    "fuse --tracks FILE --out o",
    "smooth --tracks FILE --out o",
    "compare --tracks FILE",
    "compare --tracks tracks.csv --truth FILE",
    "track --detections FILE --out o",
    "track --detections plots.csv --wide-area FILE --out o",
    "track --detections plots.csv --platform FILE --out o",
    "locate --bearings FILE --out o",
    "locate --fixes FILE --out o",
    "score --truth FILE --tracks tracks.csv",
    "score --truth truth.csv --tracks FILE",
    "score tracks --truth FILE --tracks tracks.csv",
    "score fixes --truth FILE --fixes fixes.csv",
    "bearings --snapshots FILE --array array.toml --out o",
    "bearings --snapshots snapshots.csv --array FILE --out o",
];

/// Commands with a configuration that may be empty, or a map.
const READERS_OF_SETTINGS: [&str; 5] = [
    "fuse --tracks tracks.csv --config FILE --out o",
    "smooth --tracks tracks.csv --config FILE --out o",
    "compare --tracks tracks.csv --config FILE",
    "track --detections plots.csv --config FILE --out o",
    "locate --bearings bearings.csv --config FILE --out o",
];

/// Commands that write to PLACE, which the command line names.
const WRITERS: [&str; 18] = [
    "fuse --tracks tracks.csv --out PLACE",
    "fuse --tracks tracks.csv --out o --explain PLACE",
    "fuse --tracks tracks.csv --out o --smoothed PLACE",
    "fuse --tracks tracks.csv --out o --picture PLACE",
    "smooth --tracks tracks.csv --out PLACE",
    "smooth --tracks tracks.csv --out o --asterix PLACE --origin 41.3,2.1",
    "track --detections plots.csv --out PLACE",
    "track --detections plots.csv --out o --explain PLACE",
    "track --detections plots.csv --out o --cues PLACE",
    "locate --bearings bearings.csv --out PLACE",
    "locate --bearings bearings.csv --out o --explain PLACE",
    "locate --bearings bearings.csv --out o --picture PLACE",
    "bearings --snapshots snapshots.csv --array array.toml --out PLACE",
    "score --truth truth.csv --tracks fused.csv --html PLACE",
    "decode reports.ast --out PLACE",
    "decode reports.ast --statistics --json PLACE",
    "encode reports.jsonl --out PLACE",
    "simulate --scenario demo --for 1 --out PLACE",
];

/// A folder with an input for each command on files.
fn folder_of_inputs() -> Folder {
    let folder = Folder::with(&[
        ("reports.ast", &[10, 0, 10, 0b1101_0000, 0, 7, 1, 0, 0, 128][..]),
        (
            "bearings.csv",
            b"time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz\n0,1,0.1,0.02,0,0,0\n5,1,0.2,0.02,500,0,0\n",
        ),
        (
            "array.toml",
            b"frequency_max_hz = 1.1e9\n[[antenna]]\nright_m = 0\nforward_m = 0\n[[antenna]]\nright_m = 0.1\nforward_m = 0\n\
              [[antenna]]\nright_m = 0\nforward_m = 0.1\n",
        ),
        (
            "snapshots.csv",
            b"time_s,px,py,pz,heading_rad,frequency_hz,re_1,im_1,re_2,im_2,re_3,im_3\n0,0,0,0,0,1e9,1,0,0,1,1,1\n",
        ),
        ("fixes.csv", b"time_s,emitter_id,x,y,z,variance_m2\n0,1,0,0,0,1\n"),
        ("meta.json", br#"{"case": "turn", "sigma_deg": 1, "baseline": 1e4, "runs": 1}"#),
        ("empty", b""),
        ("other", b"a,b\n"),
    ]);
    folder.succeed("simulate --scenario demo --for 20 --seed 1 --out world");
    for (from, to) in [
        ("detections_1", "plots"),
        ("sensor_tracks_1", "tracks"),
        ("truth", "truth"),
    ] {
        std::fs::rename(
            folder.path(&format!("world/{from}.csv")),
            folder.path(&format!("{to}.csv")),
        )
        .unwrap();
    }
    folder.succeed("fuse --tracks tracks.csv --refresh 1 --out fused.csv");
    folder.succeed("decode reports.ast --out reports.jsonl");
    folder
}

/// Adds the command to `wrong` unless its refusal is one line that begins so.
fn refused(folder: &Folder, command: &str, begin: &str, wrong: &mut Vec<String>) {
    let output = folder.run(command);
    let said = String::from_utf8_lossy(&output.stderr);
    let is_right = output.status.code() == Some(2) && output.stdout.is_empty() && said.lines().count() == 1;
    if !is_right || !said.starts_with(begin) {
        wrong.push(format!("{command}: {:?} {said}", output.status.code()));
    }
}

#[test]
fn a_file_that_cannot_be_used_is_wrong_usage_of_every_command() {
    let folder = folder_of_inputs();
    let mut wrong = Vec::new();
    let all: &[&str] = &["absent", "world", "empty", "other"];
    let not_empty: &[&str] = &["absent", "world", "other"];
    let commands = READERS.iter().map(|command| (command, all));
    for (command, files) in commands.chain(READERS_OF_SETTINGS.iter().map(|command| (command, not_empty))) {
        for file in files {
            refused(
                &folder,
                &command.replace("FILE", file),
                &format!("koseki: {file}:"),
                &mut wrong,
            );
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.concat());
    assert!(!folder.path("o").exists());
}

#[test]
fn an_instance_that_does_not_run_is_wrong_usage_of_every_command() {
    let folder = Folder::new();
    let config = repository("config/demo.toml");
    let mut wrong = Vec::new();
    for command in [
        "status --instance none",
        "top --instance none",
        "tap --instance none",
        "feed --instance none",
        "order --instance none",
        "condition --instance none rain",
        "display --instance none",
        "monitor --instance none --config CONFIG",
        "adapter --instance none --config CONFIG --name radar-west",
    ] {
        let command = command.replace("CONFIG", config.to_str().unwrap());
        refused(&folder, &command, "koseki: ", &mut wrong);
    }
    assert!(wrong.is_empty(), "{}", wrong.concat());
}

#[test]
fn a_place_where_nothing_can_be_written_is_wrong_usage_of_every_command() {
    let folder = folder_of_inputs();
    let mut wrong = Vec::new();
    for command in WRITERS {
        for place in ["absent/o", "other/o"] {
            // `simulate` makes the folder.
            if !(command.starts_with("simulate") && place == "absent/o") {
                let begin = format!("koseki: {place}: cannot be written: ");
                refused(&folder, &command.replace("PLACE", place), &begin, &mut wrong);
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.concat());
}

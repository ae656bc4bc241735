//! Mistakes on the command line: each is refused in one line that names what is wrong and what is possible.

use crate::common::{Folder, repository};

/// Command lines, and words that their refusals contain.
const MISTAKES: &[(&str, &[&str])] = &[
    // Commands, and places of options.
    ("", &["a command is missing", "demo, open, new, up, check"]),
    ("upp", &["unrecognized subcommand 'upp'; did you mean 'up'?"]),
    ("help upp", &["unrecognized subcommand 'upp'"]),
    (
        "recording",
        &[
            "a command is missing",
            "info, cut, merge, repair, export",
            "`koseki recording --help`",
        ],
    ),
    (
        "recording inf x",
        &["unrecognized subcommand 'inf'; did you mean 'info'?"],
    ),
    ("--json status", &["it follows the command: koseki status --json"]),
    ("--once top", &["it follows the command: koseki top --once"]),
    ("demo --fr 5", &["did you mean --for?"]),
    (
        "track absent.csv",
        &["unexpected argument 'absent.csv'", "`koseki track --help`"],
    ),
    ("check a.toml b.toml --jsn", &["did you mean --json?"]),
    ("top extra", &["unexpected argument 'extra' found (see"]),
    ("up", &["required", "<CONFIG>", "`koseki up --help`"]),
    ("fuse --tracks", &["a value is required for '--tracks <FILE>...'"]),
    ("fuse --out o", &["required", "--tracks <FILE>..."]),
    ("adapter", &["required", "--config <CONFIG>"]),
    ("status --root", &["a value is required for '--root <DIR>'"]),
    (
        "decode x.ast x.ast --out o",
        &["unexpected argument 'x.ast' found (see"],
    ),
    ("demo --for 1 --for 2", &["--for <SECONDS>", "multiple times"]),
    // Values of options.
    ("demo --for -5", &["'-5'", "--for", "more than 0"]),
    ("demo --for -0.5", &["'-0.5'", "--for", "more than 0"]),
    ("demo --for=-5", &["'-5'", "--for", "more than 0"]),
    ("demo --for soon", &["'soon'", "--for", "write a number of seconds"]),
    ("demo --for 1min", &["'1min'", "write a number of seconds"]),
    ("demo --for nan", &["'nan'", "more than 0"]),
    ("top --interval -1", &["'-1'", "--interval"]),
    ("top --interval 0.01", &["'0.01'", "between 0.1 and 3600"]),
    (
        "demo --seed -1",
        &["'-1'", "--seed", "write a whole number, 0 or greater"],
    ),
    ("demo --seed 1.5", &["'1.5'", "write a whole number, 0 or greater"]),
    (
        "demo --seed 99999999999999999999",
        &["--seed", "the number is too large"],
    ),
    ("tap --sac 256", &["'256'", "--sac", "it must lie between 0 and 255"]),
    ("up there.toml --speed 0", &["'0'", "--speed", "more than 0; write max"]),
    ("up there.toml --speed fast", &["'fast'", "write a factor, or max"]),
    (
        "send bad.csv --to 127.0.0.1",
        &["'127.0.0.1'", "write an address and a port, as in 127.0.0.1:8600"],
    ),
    (
        "recording cut x --from yesterday --out o",
        &["'yesterday'", "2026-05-01T10:00:00Z (see `koseki recording cut"],
    ),
    (
        "recording cut x --from 2026-13-01T00:00:00Z --out o",
        &["--from", "write a time as in 2026-05-01T10:00:00Z"],
    ),
    ("decode x.ast --edition 21", &["'21'", "as in 21=0.23"]),
    ("decode x.ast --edition 21=9.9", &["21=9.9", "--edition", "0.23"]),
    (
        "locate --bearings bad.csv --filter fixd --out o",
        &["--filter fixd: there are auto, fixed"],
    ),
    (
        "score --truth a --tracks b --origin 41",
        &["'41'", "latitude and longitude"],
    ),
    (
        "score --truth a --tracks b --origin 141,2",
        &["141", "latitude", "between"],
    ),
    ("score --truth a --tracks b --c -1", &["'-1'", "more than 0"]),
    ("score --truth a --tracks b --standard ed-1", &["'ed-1'", "ed-87"]),
    ("fuse --tracks bad.csv --out o --refresh 0", &["'0'", "--refresh"]),
    (
        "fuse --tracks bad.csv --out o --rule bst",
        &["--rule bst", "there are auto, "],
    ),
    (
        "simulate --scenario nowhere --for 5 --out o",
        &["nowhere", "there are demo"],
    ),
    // Names of instances, topics, processes and keys.
    ("demo --instance a/b", &["\"a/b\"", "1 to 40 letters, digits"]),
    ("tap nothing --instance none", &["nothing", "no topic"]),
    ("top --instance none", &["no instance none runs", "koseki status"]),
    (
        "adapter --config demo.toml --name radar-wst",
        &["radar-wst", "there are: radar-west"],
    ),
    ("adapter --config demo.toml", &["adapter needs --name", "radar-west"]),
    ("demo --set a", &["--set a: write it as key.path=value"]),
    (
        "demo --set scenario.targts=3",
        &["scenario.targts: unknown key", "did you mean targets?"],
    ),
    (
        "demo --set scenario.targets=-3",
        &["scenario.targets: -3 is out of range", "(--set)"],
    ),
    (
        "demo --set source.name=a",
        &["--set source.name=a: source is a list; name an item, as in source[0]"],
    ),
    ("feed --tcp port", &["\"port\" is neither a port nor an address"]),
    (
        "track --detections bad.csv --tracker a --out o",
        &["--tracker a: goes with a recording", "tables have no trackers"],
    ),
    ("demo --set source[9].name=a", &["there is no source[9]"]),
    // Files that are absent, of another kind, or contradict each other.
    ("up absent.toml", &["absent.toml", "cannot be read"]),
    ("up there.toml", &["there.toml", "did you mean config/there.toml?"]),
    ("check there.toml", &["there.toml", "did you mean config/there.toml?"]),
    ("up .", &[".: cannot be read", "directory"]),
    ("up bad.csv", &["bad.csv:1", "key with no value"]),
    (
        "fuse --tracks bad.csv --out o",
        &["bad.csv", "column time_s is missing"],
    ),
    ("fuse --tracks bad.csv bad.csv --out o", &["bad.csv", "twice"]),
    (
        "fuse --tracks bad.csv --out bad.csv",
        &["--out bad.csv is an input; name another file"],
    ),
    (
        "fuse --tracks bad.csv --out o --explain o",
        &["--out and --explain name one file"],
    ),
    (
        "fuse --tracks bad.csv --out - --json",
        &["--out - and --json would mix"],
    ),
    ("up binary.toml", &["binary.toml: is no text in UTF-8"]),
    ("encode binary.toml --out o", &["binary.toml: is no text in UTF-8"]),
    (
        "encode bad.csv --out o",
        &["bad.csv: no record can be encoded: line 1: no JSON object"],
    ),
    ("demo --for 1 --root bad.csv/x", &["bad.csv/x", "Not a directory"]),
    (
        "demo --for 1 --set recorder.enabled=true --out bad.csv/x",
        &["--out bad.csv/x", "Not a directory"],
    ),
];

/// Changes of a sound configuration, and words that its refusals contain.
const MISTAKES_OF_FILES: &[(&str, &str, &[&str])] = &[
    // Spelling.
    (
        "[[source]]",
        "[[sorce]]",
        &[":6: sorce: unknown key", "did you mean source?"],
    ),
    (
        "[[source]]",
        "[[sensr]]",
        &[":6: sensr: unknown key", "a sensor of a deployment is a [[source]]"],
    ),
    (
        "[[source]]",
        "[source]",
        &[":6: source: a table is no list of tables; write each below [[source]]"],
    ),
    (
        "period_s = 4",
        "perod_s = 4",
        &[":8: source[0].perod_s: unknown key", "did you mean period_s?"],
    ),
    (
        "latitude_deg",
        "latitude",
        &[":4: frame.latitude: unknown key", "did you mean latitude_deg?"],
    ),
    ("[frame]", "[fram]", &[":3: fram: unknown key", "did you mean frame?"]),
    (
        "rule.name = \"auto\"",
        "rule.name = \"atuo\"",
        &["fusion.rule.name: \"atuo\" is not known; there are: auto, "],
    ),
    // Syntax.
    (
        "period_s = 4",
        "period_s = 4 s",
        &[":8: period_s: 4 s is no value", "the unit, s, is in the name"],
    ),
    (
        "period_s = 4",
        "period_s = four",
        &[":8: period_s: four is no value", "text in quotes"],
    ),
    ("period_s = 4", "period_s =", &[":8: period_s: the value is missing"]),
    ("period_s = 4", "period_s 4", &[":8: ", "expected"]),
    ("[frame]", "[frame", &[":3: unclosed table"]),
    ("name = \"a\"", "name = \"a", &[":7: invalid basic string"]),
    ("period_s = 4", "name = \"b\"", &[":8: name: is given twice"]),
    (
        "[fusion]",
        "[frame]",
        &[":14: frame: is given twice; write all its keys below one [frame]"],
    ),
    (
        "[fusion]",
        "[source]",
        &[":14: source: is given twice; each table of a list stands below [[source]]"],
    ),
    // Types.
    (
        "latitude_deg = 43.3",
        "latitude_deg = \"43N\"",
        &[":4: frame.latitude_deg: \"43N\" is no number"],
    ),
    (
        "latitude_deg = 43.3",
        "latitude_deg = {}",
        &[":4: frame.latitude_deg: a table is no number"],
    ),
    (
        "period_s = 4",
        "period_s = \"4\"",
        &[":8: source[0].period_s: \"4\" is a text; write 4 without quotes"],
    ),
    (
        "period_s = 4",
        "period_s = \"4 s\"",
        &[":8: source[0].period_s: \"4 s\" is no number", "the unit, s, is in"],
    ),
    (
        "period_s = 4",
        "period_s = true",
        &[":8: source[0].period_s: true is no number"],
    ),
    (
        "name = \"a\"",
        "name = 5",
        &[":7: source[0].name: 5 is no text; write a text in quotes"],
    ),
    (
        "queue = 128",
        "queue = 1.5",
        &["fusion.capacity.queue: 1.5 is no whole number"],
    ),
    (
        "queue = 128",
        "queue = -1",
        &["fusion.capacity.queue: -1 is out of range"],
    ),
    (
        "queue = 128",
        "queue = 99999999999999999999",
        &["fusion.capacity.queue: ", "out of range"],
    ),
    (
        "enabled = false",
        "enabled = \"no\"",
        &["recorder.enabled: \"no\" is neither true nor false"],
    ),
    (
        "enabled = false",
        "enabled = 0",
        &["recorder.enabled: 0 is neither true nor false"],
    ),
    (
        "enabled = false",
        "enabled = no",
        &["enabled: no is no value; write a number, true, false, "],
    ),
    (
        "format = [\"csv\"]",
        "format = \"csv\"",
        &["recorder.format: \"csv\" is no list; write it in brackets"],
    ),
    (
        "format = [\"csv\"]",
        "format = [\"cvs\"]",
        &["recorder.format: \"cvs\" is not known; there are: csv, "],
    ),
    (
        "[recorder]",
        "[[recorder]]",
        &["recorder: a list is no table; write its keys below [recorder]"],
    ),
    // Ranges, and what has to be given once.
    (
        "latitude_deg = 43.3",
        "latitude_deg = 143.3",
        &[":4: frame.latitude_deg: ", "143.3", "-90° and 90°"],
    ),
    (
        "latitude_deg = 43.3",
        "latitude_deg = nan",
        &[":4: frame.latitude_deg: ", "NaN"],
    ),
    (
        "period_s = 4",
        "period_s = 0",
        &[":8: source[0].period_s: 0 is out of range; it must lie between 0.001 and 3600"],
    ),
    ("name = \"x\"", "", &["name: missing; the key is mandatory"]),
    (
        "name = \"x\"",
        "name = \"x y\"",
        &[":1: name: \"x y\" cannot be a name"],
    ),
    (
        "longitude_deg = 5.2",
        "",
        &["frame.longitude_deg: missing; the key is mandatory"],
    ),
    (
        "[source.external]",
        "",
        &["source[0].name: \"a\" needs exactly one of [source.recorded], "],
    ),
    (
        "[fusion]",
        "[[source]]\nname = \"a\"\nperiod_s = 4\n[source.external]\n[fusion]",
        &[":15: source[1].name: \"a\" is the name of an earlier source"],
    ),
    (
        "[fusion]",
        "[source.live]\nreceiver = \"r\"\nsac = 1\nsic = 1\n[fusion]",
        &["source[0].name: \"a\" needs exactly one of"],
    ),
    (
        "[fusion]",
        "[display]\nlisten = \"8900\"\n[fusion]",
        &["display.listen: \"8900\" is no address with a port"],
    ),
    (
        "[fusion]",
        "[[gateway]]\nname = \"g\"\n[fusion]",
        &["gateway[0]: give either send_to (datagrams) or listen"],
    ),
];

/// A sound configuration.
const SOUND: &str = "name = \"x\"

[frame]
latitude_deg = 43.3
longitude_deg = 5.2
[[source]]
name = \"a\"
period_s = 4
[source.external]

[recorder]
enabled = false
format = [\"csv\"]
[fusion]
rule.name = \"auto\"
capacity.queue = 128
";

#[test]
fn mistakes_are_refused_by_what_is_wrong() {
    let folder = Folder::new();
    folder.write("bad.csv", "a,b\n");
    folder.write("binary.toml", [0xff, 0xfe, 0x80]);
    std::fs::copy(repository("config/demo.toml"), folder.path("demo.toml")).unwrap();
    std::fs::create_dir(folder.path("config")).unwrap();
    folder.write("config/there.toml", "");
    let mut wrong = Vec::new();
    for (command, expected) in MISTAKES {
        refused(&folder, command, expected, &mut wrong);
    }
    assert!(wrong.is_empty(), "{}", wrong.concat());
    assert!(!folder.path("o").exists());
}

#[test]
fn mistakes_in_a_configuration_are_refused_by_file_line_and_key() {
    let folder = Folder::with(&[("sound.toml", SOUND)]);
    folder.succeed("check sound.toml");
    let mut wrong = Vec::new();
    for (right, mistaken, expected) in MISTAKES_OF_FILES {
        assert!(SOUND.contains(right), "{right}");
        folder.write("wrong.toml", SOUND.replacen(right, mistaken, 1));
        let mut expected = expected.to_vec();
        expected.push("koseki: wrong.toml:");
        let before = wrong.len();
        refused(&folder, "check wrong.toml", &expected, &mut wrong);
        wrong[before..]
            .iter_mut()
            .for_each(|line| line.insert_str(0, &format!("{mistaken}: ")));
    }
    assert!(wrong.is_empty(), "{}", wrong.concat());
}

/// Adds the command to `wrong` unless it is refused in one line that contains these words.
fn refused(folder: &Folder, command: &str, words: &[&str], wrong: &mut Vec<String>) {
    let output = folder.run(command);
    let said = String::from_utf8_lossy(&output.stderr);
    let is_one_line = output.status.code() == Some(2) && output.stdout.is_empty() && said.lines().count() == 1;
    let is_clear = ["error:", "tip:", "panicked", "f64", "u32"]
        .iter()
        .all(|word| !said.contains(word));
    if !is_one_line || !is_clear || !said.starts_with("koseki: ") || words.iter().any(|word| !said.contains(word)) {
        wrong.push(format!("{command}: {:?} {said}\n", output.status.code()));
    }
}

/// Commands that read FILE, which the command line names.
const READERS: &[&str] = &[
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
    "score --truth truth.csv --tracks tracks.csv --origin 41.3,2.1 --areas FILE",
    "score tracks --truth FILE --tracks tracks.csv",
    "score fixes --truth FILE --fixes fixes.csv",
    "bearings --snapshots FILE --array array.toml --out o",
    "bearings --snapshots snapshots.csv --array FILE --out o",
];

/// Commands with a configuration that may be empty, or a map.
const READERS_OF_SETTINGS: &[&str] = &[
    "fuse --tracks tracks.csv --config FILE --out o",
    "smooth --tracks tracks.csv --config FILE --out o",
    "compare --tracks tracks.csv --config FILE",
    "track --detections plots.csv --config FILE --out o",
    "locate --bearings bearings.csv --config FILE --out o",
];

/// Commands that write to PLACE, which the command line names.
const WRITERS: &[&str] = &[
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
    "score --truth truth.csv --tracks tracks.csv --html PLACE",
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
                &[&format!("koseki: {file}:")],
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
        refused(&folder, &command, &["none"], &mut wrong);
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
                refused(&folder, &command.replace("PLACE", place), &[&begin], &mut wrong);
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.concat());
}

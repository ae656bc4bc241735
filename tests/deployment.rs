//! Whole deployments, as a user starts them: real processes, killed, stopped, refused and watched (PL-1, PL-11).
//!
//! Each test has its own folder for instances, so tests can run side by side. Nothing here waits for a time to pass:
//! every wait is for a condition, and its limit only ends a test that hangs. At its end each test makes sure that no
//! process, no file in shared memory and no folder of the instance is left.

use std::fs;
use std::os::unix::process::ExitStatusExt as _;
use std::process::Output;

use bus::{Bus, SharedMemory};
use messages::{Health, LifeState, ProcessKind};
use runtime::clock::mono_ns;
use rustix::process::Signal;
use test_support::recordings;

use crate::common::{Home, kill, repository, until};

// ---------------------------------------------------------------------------------------------------------------------
// Refusals: configurations, recordings, command lines.
// ---------------------------------------------------------------------------------------------------------------------

/// Mistakes: what is changed in a sound deployment, and what the line about it must contain.
#[test]
fn bad_input_is_refused_in_one_line_with_place_value_and_remedy() {
    let cases: [(&str, Mistake, &[&str]); 12] = [
        (
            "a recording that is not there",
            Mistake::Config("file = \"radar.ast\"", "file = \"gone.ast\""),
            &["gone.ast: cannot be read", "--data", "source[0].recorded.file"],
        ),
        (
            "a folder instead of a recording",
            Mistake::Config("file = \"radar.ast\"", "file = \".\""),
            &["cannot be read", "directory"],
        ),
        (
            "another category",
            Mistake::Recording(|_| [48, 0, 4, 0].repeat(3)),
            &[
                "radar.ast: byte 0: ",
                "category 048",
                "expected 010",
                "source[0].recorded.file",
            ],
        ),
        (
            "a recording cut in the middle of a block",
            Mistake::Recording(|bytes| bytes[..bytes.len() - 3].to_vec()),
            &["radar.ast: byte 990: ", "10 octets", "7 left", "truncated = \"accept\""],
        ),
        (
            "a length that cannot be",
            Mistake::Recording(|bytes| [bytes, &[10, 0, 1, 0]].concat()),
            &["radar.ast: byte 1000: ", "length as 1", "first 1000 bytes"],
        ),
        (
            "an empty recording",
            Mistake::Recording(|_| Vec::new()),
            &["radar.ast: byte 0: ", "empty"],
        ),
        (
            "a core that does not exist",
            Mistake::Config("# core", "core = 4711"),
            &["site.toml:18: ", "fusion.core", "4711", "offers cores"],
        ),
        (
            "a capacity of 0",
            Mistake::Config("system_tracks = 10", "system_tracks = 0"),
            &["site.toml:20: ", "fusion.capacity.system_tracks: 0", "between 1 and"],
        ),
        (
            "an unknown key",
            Mistake::Config("period_s = 1.0", "periode_s = 1.0"),
            &[
                "site.toml:10: ",
                "source[0].periode_s: unknown key",
                "there are: name, uid",
            ],
        ),
        (
            "two sources with one name",
            Mistake::Config("name = \"mlat\"", "name = \"radar\""),
            &["site.toml:25: ", "source[1].name", "\"radar\"", "give each its own"],
        ),
        ("no TOML", Mistake::Config("[frame]", "[frame"), &["site.toml:2: "]),
        ("no configuration", Mistake::NoConfig, &["site.toml: cannot be read"]),
    ];
    let home = Home::new();
    for (name, mistake, expected) in cases {
        write_site(&home, |text, recording| match mistake {
            Mistake::Config(old, new) => {
                assert!(text.contains(old), "{name}");
                *text = text.replacen(old, new, 1);
            }
            Mistake::Recording(change) => *recording = change(recording),
            Mistake::NoConfig => {}
        });
        if matches!(mistake, Mistake::NoConfig) {
            fs::remove_file(home.path("site.toml")).unwrap();
        }
        for command in ["check", "up"] {
            let output = home.run(&[command, "site.toml", "--data", "."]);
            assert_refused(&output, 2, expected, &format!("{command}: {name}"));
        }
    }
    home.assert_nothing_is_left("test");
}

enum Mistake {
    Config(&'static str, &'static str),
    Recording(fn(&[u8]) -> Vec<u8>),
    NoConfig,
}

#[test]
fn a_folder_that_cannot_be_made_is_refused_before_anything_starts() {
    let home = Home::new();
    write_site(&home, |_, _| ());
    let output = home.run(&["up", "site.toml", "--data", ".", "--out", "/proc/none"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.lines().count() == 1 && said.contains("--out /proc/none") && said.contains("name another"),
        "{said}"
    );
}

#[test]
fn a_sound_deployment_is_summed_up() {
    let home = Home::new();
    write_site(&home, |_, _| ());
    let output = home.run(&["check", "site.toml", "--data", "."]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0), "{text}");
    for expected in [
        "is sound",
        "radar",
        "100 records",
        "00:01:40",
        "10 system tracks",
        "CAT010 ed 1.1",
    ] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
}

/// As on an isolated core, which the scheduler gives to nobody by itself.
#[test]
fn a_core_outside_of_the_affinity_mask_may_be_configured() {
    let [first, .., last] = runtime::cores::available()[..] else {
        println!("skipped: there is one core only");
        return;
    };
    let home = Home::new();
    write_site(&home, |_, _| ());
    let core = format!("fusion.core={last}");
    let output = std::thread::scope(|scope| {
        let checked = scope.spawn(|| {
            assert!(core_affinity::set_for_current(core_affinity::CoreId { id: first }));
            home.run(&["check", "site.toml", "--data", ".", "--set", &core])
        });
        checked.join().unwrap()
    });
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

#[test]
fn every_example_is_sound() {
    let home = Home::new();
    for entry in fs::read_dir(repository("config")).unwrap() {
        let path = entry.unwrap().path();
        let data = match path.file_stem().and_then(|name| name.to_str()) {
            Some("barcelona") => recordings("lebl2016"),
            Some("ferry") => recordings("autoferry"),
            _ => Some(home.path("no recordings")),
        };
        let Some(data) = data else { continue };
        let output = home.run(&["check", path.to_str().unwrap(), "--data", data.to_str().unwrap()]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{}: {said}", path.display());
    }
}

#[test]
fn an_overlay_that_cannot_be_drawn_is_refused() {
    let home = Home::new();
    write_site(&home, |_, _| ());
    let line = r#"{"type":"FeatureCollection","features":[{"geometry":{"type":"LineString","coordinates":[[LON,41],[3,42]]}}]}"#;
    let checked = |overlay: Option<&str>| {
        let path = home.path("zones.json");
        match overlay {
            Some(text) => fs::write(path, text).unwrap(),
            None => drop(fs::remove_file(path)),
        }
        let overlays = [
            "--set",
            "display.listen=\"127.0.0.1:0\"",
            "--set",
            "display.overlays=[\"zones.json\"]",
        ];
        home.run(&[&["check", "site.toml", "--data", "."][..], &overlays].concat())
    };
    let sound = checked(Some(&line.replace("LON", "2")));
    assert_eq!(sound.status.code(), Some(0), "{sound:?}");
    let off_the_earth = line.replace("LON", "200");
    for (overlay, expected) in [
        (None, "No such file"),
        (Some("{\"features\": 3}"), "no FeatureCollection"),
        (Some("features:"), "zones.json: "),
        (Some(&off_the_earth), "is no place"),
    ] {
        let refused = checked(overlay);
        let said = String::from_utf8(refused.stderr).unwrap();
        assert_eq!((refused.status.code(), said.lines().count()), (Some(2), 1), "{said}");
        assert!(
            said.contains(expected) && said.contains("display.overlays[0]"),
            "{said}"
        );
    }
}

#[test]
fn a_recording_cut_short_can_be_accepted() {
    let home = Home::new();
    write_site(&home, |_, recording| recording.truncate(997));
    let accept = "source[0].recorded.truncated=\"accept\"";
    let output = home.run(&["check", "site.toml", "--data", ".", "--set", accept]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(String::from_utf8(output.stdout).unwrap().contains("99 records"));
}

#[test]
fn wrong_usage_is_one_line() {
    let home = Home::new();
    write_site(&home, |_, _| ());
    let cases: [(&[&str], &[&str]); 8] = [
        (&[], &["a command is missing", "demo, open, new, up, check, doctor"]),
        (&["upp"], &["unrecognized subcommand 'upp'", "--help"]),
        (&["up"], &["<CONFIG>", "koseki up --help"]),
        (&["demo", "--for", "soon"], &["--for", "number of seconds"]),
        (&["up", "site.toml", "--speed", "0"], &["--speed", "more than 0"]),
        (&["adapter", "--config", "site.toml"], &["--name", "radar, mlat"]),
        (
            &["adapter", "--config", "site.toml", "--name", "x"],
            &["--name x", "radar, mlat"],
        ),
        (&["status", "--instance", "a/b"], &["\"a/b\"", "letters"]),
    ];
    for (arguments, expected) in cases {
        assert_refused(&home.run(arguments), 2, expected, &arguments.join(" "));
    }
}

#[test]
fn every_command_has_help_with_examples() {
    let home = Home::new();
    let commands = [
        "demo",
        "up",
        "check",
        "status",
        "adapter",
        "fusion",
        "monitor",
        "recorder",
        "gateway",
        "simulator",
    ];
    for command in commands {
        let output = home.run(&[command, "--help"]);
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(0));
        assert!(
            text.contains("Examples:") && text.contains(&format!("koseki {command}"))
                || text.contains("koseki adapter"),
            "{text}"
        );
        assert!(!text.contains("--launcher"), "for the launcher only: {text}");
    }
}

#[test]
fn a_process_without_a_deployment_says_so() {
    let home = Home::new();
    write_site(&home, |_, _| ());
    let output = home.run(&["fusion", "--config", "site.toml"]);
    assert_refused(
        &output,
        2,
        &["fusion: ", "test is not running", "koseki up"],
        "fusion alone",
    );
}

// ---------------------------------------------------------------------------------------------------------------------
// Life: start, stop, finish.
// ---------------------------------------------------------------------------------------------------------------------

#[test]
fn a_demo_runs_for_its_time_and_leaves_nothing() {
    let home = Home::new();
    let demo = home.start(&["demo", "--for", "1"]);
    let (status, said) = demo.end();
    assert_eq!(status.code(), Some(0), "{said}");
    assert!(said.contains("instance demo runs"), "{said}");
    home.assert_nothing_is_left("demo");
}

#[test]
fn a_request_to_stop_stops_everything() {
    // Tests that are started with `nohup` hand that on to what they start.
    let ends = |signal: &Signal| !runtime::signals::is_ignored(signal.as_raw());
    for signal in [Signal::TERM, Signal::INT, Signal::HUP].into_iter().filter(ends) {
        let home = Home::new();
        let demo = home.demo();
        assert!(home.processes().len() > 5, "{:?}", home.processes());
        demo.signal(signal);
        let (status, said) = demo.end();
        assert_eq!(status.code(), Some(0), "{said}");
        assert!(said.contains("asked to stop"), "{said}");
        home.assert_nothing_is_left("demo");
    }
}

#[test]
fn recordings_are_worked_off_and_the_deployment_ends() {
    let home = Home::new();
    write_site(&home, |_, _| ());
    let up = home.start(&["up", "site.toml", "--data", ".", "--speed", "max", "--out", "out"]);
    let (status, said) = up.end();
    // Its records are of radars that say no more than that they are there.
    assert_eq!(status.code(), Some(1), "{said}");
    for each in [
        "fusion has finished",
        "recorder has finished",
        "fusion did not receive a single report",
    ] {
        assert!(said.contains(each), "{each}: {said}");
    }
    home.assert_nothing_is_left("test");
}

#[test]
fn a_second_start_is_refused_and_another_name_is_not() {
    let home = Home::new();
    let demo = home.demo();
    let second = home.run(&["demo", "--for", "1"]);
    let pid = demo.pid().to_string();
    assert_refused(&second, 1, &["instance demo", &pid, "--instance NAME"], "second start");
    let beside = home.run(&["demo", "--for", "0.5", "--instance", "beside"]);
    assert_eq!(beside.status.code(), Some(0), "{beside:?}");
    demo.stop();
    home.assert_nothing_is_left("demo");
    home.assert_nothing_is_left("beside");
}

#[test]
fn status_shows_what_runs() {
    let home = Home::new();
    assert_eq!(home.status(), format!("nothing runs in {}\n", home.base().display()));
    let demo = home.demo();
    let status = home.status();
    for expected in [
        "instance demo",
        &demo.pid().to_string(),
        "launcher",
        "fusion",
        "monitor",
        "radar-west",
        "running",
    ] {
        assert!(status.contains(expected), "{expected}: {status}");
    }
    let row = home.status_row("ads-b");
    assert!(row.published.parse::<f64>().unwrap() > 0.0, "{status}");
    let other = home.run(&["status", "--instance", "other"]);
    let line = String::from_utf8(other.stderr).unwrap();
    assert_eq!((other.status.code(), other.stdout.len()), (Some(2), 0), "{line}");
    assert!(line.contains("no instance other runs"), "{line}");
    let json = |arguments: &[&str]| -> serde_json::Value {
        let output = home.run(arguments);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let status = json(&["status", "--json"]);
    assert_eq!(
        (&status[0]["instance"], &status[0]["pid"]),
        (&"demo".into(), &demo.pid().into())
    );
    let processes = status[0]["processes"].as_array().unwrap();
    let fusion = processes.iter().find(|process| process["name"] == "fusion").unwrap();
    assert_eq!((&fusion["state"], &fusion["restarts"]), (&"running".into(), &0.into()));
    let top = json(&["top", "--once", "--json"]);
    assert_eq!(top["instance"], "demo");
    assert!(
        top["sources"].as_array().is_some_and(|sources| !sources.is_empty()),
        "{top}"
    );
    demo.stop();
    home.assert_nothing_is_left("demo");
}

#[test]
fn a_reader_gets_system_tracks_and_learns_of_the_end() {
    let home = Home::new();
    let demo = home.demo();
    let bus = Bus::<SharedMemory>::open(&home.root("demo"), "reader").unwrap();
    let mut tracks = bus.subscriber(&messages::system_tracks(), || mono_ns() as u64).unwrap();
    let mut health = bus.subscriber(&messages::health(), || mono_ns() as u64).unwrap();
    let mut updates = 0;
    until("system tracks come", || {
        tracks.take(64, |_, slice| updates += slice.len()).unwrap();
        updates > 50
    });
    demo.signal(Signal::TERM);
    let is_end = |said: &Health| {
        let launcher = said.kind() == Some(ProcessKind::Launcher) && said.name() == "launcher";
        launcher && said.life() == Some(LifeState::Finished)
    };
    let mut ended = false;
    until("the launcher says that it is over", || {
        health.take(64, |_, slice| ended |= slice.iter().any(is_end)).unwrap();
        ended
    });
    drop((tracks, health, bus));
    let (status, said) = demo.end();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("demo");
}

// ---------------------------------------------------------------------------------------------------------------------
// Death: of children, and of the launcher.
// ---------------------------------------------------------------------------------------------------------------------

#[test]
fn a_condition_is_ordered_while_running_and_a_slip_of_the_pen_is_refused() {
    let home = Home::new();
    let demo = home.demo();
    let order = |name: &str| home.run(&["condition", name, "--instance", "demo"]);
    let normal = order("normal");
    assert!(normal.status.success(), "{}", String::from_utf8_lossy(&normal.stderr));
    assert_eq!(
        String::from_utf8(normal.stdout).unwrap(),
        "demo: order 1, condition name=normal: done\n"
    );
    let unknown = order("hailstorm");
    assert_eq!(unknown.status.code(), Some(2));
    assert!(
        String::from_utf8(unknown.stderr)
            .unwrap()
            .contains("no source has an accuracy for the condition")
    );
    demo.stop();
    home.assert_nothing_is_left("demo");
}

#[test]
fn killed_children_are_restarted_and_counted() {
    let home = Home::new();
    let demo = home.demo();
    for (name, title, pause) in [
        ("radar-west", "adapter radar-west", "0.1"),
        ("fusion", "fusion", "0.0"),
        ("monitor", "monitor", "0.1"),
    ] {
        let before = home.status_row(name);
        kill(before.pid, Signal::KILL);
        demo.until_said(&format!("{title} was killed by SIGKILL; restarting it in {pause} s"));
        demo.until_said(&format!("{title} restarted (1), back after "));
        let after = home.status_row(name);
        assert_ne!(after.pid, before.pid);
        assert_eq!(
            (after.state.as_str(), after.restarts.as_str()),
            ("running", "1"),
            "{name}"
        );
    }
    // The others have not noticed.
    assert_eq!(home.status_row("radar-east").restarts, "0");
    let (status, said) = demo.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("demo");
}

#[test]
fn children_of_a_killed_launcher_end_and_the_next_start_finds_room() {
    let home = Home::new();
    let demo = home.demo();
    demo.signal(Signal::KILL);
    let (status, _) = demo.end();
    assert_eq!(status.signal(), Some(9));
    // Started at once: the children may still be on their way out.
    let next = home.demo();
    next.stop();
    home.assert_nothing_is_left("demo");
}

#[test]
fn what_is_left_where_all_were_killed_is_listed_and_the_next_start_clears_up() {
    let home = Home::new();
    let demo = home.demo();
    // It cannot start any of them again.
    demo.signal(Signal::STOP);
    for pid in home.pids() {
        if pid != demo.pid() {
            kill(pid, Signal::KILL);
        }
    }
    demo.signal(Signal::KILL);
    demo.end();
    let status = home.status();
    assert!(status.contains("instance demo: does not run"), "{status}");
    assert!(status.contains(home.base().to_str().unwrap()), "{status}");
    let next = home.demo();
    let said = next.said();
    assert!(
        said.contains("removed the remains of an earlier run of instance demo"),
        "{said}"
    );
    next.stop();
    home.assert_nothing_is_left("demo");
}

/// `--root` says for a command and all that it starts where instances are; nothing else is looked at.
#[test]
fn the_base_folder_can_be_named() {
    let home = Home::new();
    let folder = home.path("elsewhere");
    let root = ["--root", folder.to_str().unwrap()];
    let demo = home.start(&[&["demo"], &root[..]].concat());
    demo.until_said("instance demo runs");
    assert_eq!(home.status(), format!("nothing runs in {}\n", home.base().display()));
    let status = home.run(&[&root[..], &["status"]].concat());
    let status = String::from_utf8(status.stdout).unwrap();
    let begin = format!(
        "instance demo: run by process {}, in {}/demo\n",
        demo.pid(),
        folder.display()
    );
    assert!(status.starts_with(&begin) && status.contains("fusion"), "{status}");
    demo.stop();
    let left = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name());
    let left: Vec<String> = left.map(|name| name.into_string().unwrap()).collect();
    let is_for_the_next = |name: &String| name.ends_with(".end") || name == "demo.numbered";
    assert!(left.iter().all(is_for_the_next), "{left:?}");
}

#[test]
fn a_child_that_does_not_stop_is_killed_and_named() {
    let home = Home::new();
    let demo = home.demo();
    kill(home.status_row("radar-west").pid, Signal::STOP);
    demo.signal(Signal::TERM);
    let (status, said) = demo.end();
    assert_eq!(status.code(), Some(1), "{said}");
    assert!(
        said.contains("adapter radar-west did not stop within 5 s and was killed"),
        "{said}"
    );
    home.assert_nothing_is_left("demo");
}

#[test]
fn a_second_request_ends_the_launcher_at_once() {
    let home = Home::new();
    let demo = home.demo();
    // One child that does not stop, so that the first request is still being worked on.
    let stopped = home.status_row("radar-west").pid;
    kill(stopped, Signal::STOP);
    demo.signal(Signal::INT);
    demo.until_said("asked to stop");
    demo.signal(Signal::INT);
    kill(stopped, Signal::CONT);
    let (status, said) = demo.end();
    assert_eq!(status.code(), Some(1), "{said}");
    until("the children have ended", || home.processes().is_empty());
    // What is left is the next start's business.
    assert_eq!(home.run(&["demo", "--for", "0.5"]).status.code(), Some(0));
    home.assert_nothing_is_left("demo");
}

#[test]
fn a_deployment_that_received_nothing_has_failed_unless_it_was_asked_to_stop() {
    let home = Home::new();
    let site = "name = \"test\"\n[frame]\nlatitude_deg = 41.3\nlongitude_deg = 2.1\n[[source]]\nname = \"mine\"\n\
                period_s = 1.0\n[source.external]\n";
    home.write("site.toml", site);
    let nothing = "fusion did not receive a single report";
    let ended = home.run(&["up", "site.toml", "--for", "0.2"]);
    let said = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(ended.status.code(), Some(1), "{said}");
    assert!(said.lines().last().unwrap().contains(nothing), "{said}");
    let asked = home.start(&["up", "site.toml"]);
    asked.until_said("instance test runs");
    let (status, said) = asked.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    assert!(said.contains(&format!("warning: {nothing}")), "{said}");
    home.assert_nothing_is_left("test");
}

#[test]
fn a_recorder_that_is_not_there_in_the_end_is_a_failure_and_another_process_a_warning() {
    for (victim, title, code) in [("recorder", "recorder", 1), ("ads-b", "adapter ads-b", 0)] {
        let home = Home::new();
        let demo = home.start(&["demo", "--set", "recorder.enabled=true"]);
        demo.until_said("instance demo runs");
        let mut last = 0;
        // Its pauses double: the last one is long enough to be asked to stop in it.
        for pause in ["0.1", "0.2", "0.4", "0.8", "1.6"] {
            let row = loop {
                let row = home.status_row(victim);
                if row.pid != last && row.state == "running" {
                    break row;
                }
            };
            last = row.pid;
            kill(row.pid, Signal::KILL);
            demo.until_said(&format!("{title} was killed by SIGKILL; restarting it in {pause} s"));
        }
        let (status, said) = demo.stop();
        assert_eq!(status.code(), Some(code), "{said}");
        let word = format!("{title} was not there in the end: the last time, it was killed by SIGKILL");
        assert!(said.contains(&word), "{said}");
        assert_eq!(said.contains(&format!("warning: {word}")), code == 0, "{said}");
        home.assert_nothing_is_left("demo");
    }
}

#[test]
fn a_configuration_that_a_child_refuses_ends_the_deployment() {
    let home = Home::new();
    write_demo(&home);
    let up = home.start(&["up", "copy.toml", "--instance", "demo"]);
    up.until_said("instance demo runs");
    // Somebody edits the file while the deployment runs; the next child that starts reads it.
    fs::write(home.path("copy.toml"), "nonsense = 1\n").unwrap();
    kill(home.status_row("fusion").pid, Signal::KILL);
    let (status, said) = up.end();
    assert_eq!(status.code(), Some(2), "{said}");
    assert!(said.contains("copy.toml:1: ") && said.contains("nonsense"), "{said}");
    assert!(said.contains("fusion refuses its configuration"), "{said}");
    home.assert_nothing_is_left("demo");
}

// ---------------------------------------------------------------------------------------------------------------------
// What the tests stand on.
// ---------------------------------------------------------------------------------------------------------------------

/// A deployment of two recorded sources, of which tests change a line. Its name is `test`.
const SITE: &str = r#"name = "test"
[frame]
latitude_deg = 41.3
longitude_deg = 2.1
[time]
order = "time"
date = "2016-05-10"
[[source]]
name = "radar"
period_s = 1.0
[source.recorded]
file = "radar.ast"
editions = { "10" = "1.1" }
# space
# for
# changes
[fusion]
# core
[fusion.capacity]
system_tracks = 10
sensor_tracks = 100
# a second
# source
[[source]]
name = "mlat"
[source.recorded]
file = "mlat.ast"
editions = { "10" = "1.1" }
[monitor]
files = false
"#;

/// Bytes of CAT010: one target report each second from 00:01:40 on.
fn recording() -> Vec<u8> {
    let report = |seconds: u32| {
        let time = (seconds * 128).to_be_bytes();
        // Items I010/010, /000 and /140: sender, message type, time of day.
        [10, 0, 10, 0b1101_0000, 0, 7, 1, time[1], time[2], time[3]]
    };
    (100..200).flat_map(report).collect()
}

/// Writes a sound deployment after `change` has had its way with configuration and first recording.
fn write_site(home: &Home, change: impl FnOnce(&mut String, &mut Vec<u8>)) {
    let (mut text, mut bytes) = (SITE.to_owned(), recording());
    change(&mut text, &mut bytes);
    fs::write(home.path("site.toml"), text).unwrap();
    fs::write(home.path("radar.ast"), bytes).unwrap();
    fs::write(home.path("mlat.ast"), recording()).unwrap();
}

/// Writes a copy of the demonstration's configuration.
fn write_demo(home: &Home) {
    fs::write(home.path("copy.toml"), configuration::DEMO).unwrap();
}

/// The command ended with `code` after exactly one line on standard error, which contains everything `expected`.
fn assert_refused(output: &Output, code: i32, expected: &[&str], case: &str) {
    let line = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!(output.status.code(), Some(code), "{case}: {line}");
    assert_eq!(output.stdout, b"", "{case}");
    assert_eq!(line.lines().count(), 1, "{case}: {line}");
    assert!(line.starts_with("koseki: "), "{case}: {line}");
    for each in expected {
        assert!(line.contains(each), "{case}: \"{each}\" is not in: {line}");
    }
}

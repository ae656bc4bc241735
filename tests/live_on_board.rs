//! Tracker processes on a ship that rolls and turns: the tracks of `koseki track --platform`, and the same detections
//! refused (HT-12, EL-11).

use std::collections::BTreeSet;
use std::fs;
use std::io::Write as _;
use std::net::{TcpListener, UdpSocket};
use std::time::Duration;

use serde_json::Value;

use crate::alarms::assert_no_alarm;
use crate::common::{Home, PLACE, counter, free_address, repository, since_first_day_ns, until, utc_ns};
use crate::joint_tracker::{assert_equal, common_columns, free, tracked_again};

/// Mounting and the tracker's settings, as those that the simulation writes for `koseki track`.
const SENSOR: &str = "on_board = { platform = \"ship\", lever_arm_m = [20.0, 2.0, 15.0] }\n";
const SETTINGS: &str = "[tracker.settings.motion]\nprocess_noise_m2ps3 = [0.02, 0.001]\nslow_mps = 0.001\n\
    [tracker.settings.motion.manoeuvres]\nenabled = false\n\
    [tracker.settings.initiation]\nheight_sigma_m = 30.0\nclimb_sigma_mps = 0.1\n";

fn simulate(home: &Home, options: &[&str]) {
    let fixed = ["simulate", "--scenario", "on-board", "--seed", "1", "--out", "sea"];
    let output = home.run(&[&fixed[..], options].concat());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

/// The rows of a table with their times, nanoseconds; the header apart.
fn table(home: &Home, name: &str) -> (String, Vec<(i64, String)>) {
    let text = fs::read_to_string(home.path(name)).unwrap();
    let mut lines = text.lines();
    let header = lines.next().unwrap().to_owned();
    assert!(header.starts_with("time_s,"), "{header}");
    let row = |line: &str| {
        let (time, rest) = line.split_once(',').unwrap();
        ((time.parse::<f64>().unwrap() * 1e9).round() as i64, rest.to_owned())
    };
    (header, lines.map(row).collect())
}

/// The table, with times that begin at `begun_ns`.
fn write(home: &Home, name: &str, header: &str, rows: &[(i64, String)], begun_ns: i64) {
    let lines: Vec<String> = rows.iter().map(|row| line(row, begun_ns)).collect();
    fs::write(home.path(name), format!("{header}\n{}\n", lines.join("\n"))).unwrap();
}

fn line((time_ns, rest): &(i64, String), begun_ns: i64) -> String {
    let ns = since_first_day_ns(begun_ns, begun_ns + time_ns);
    format!("{}.{:09},{rest}", ns / 1_000_000_000, ns % 1_000_000_000)
}

/// What `koseki track --platform` makes of the same tables: its summary and its tracks beside the published ones.
fn offline(home: &Home, detections: &str, platform: &str) -> (Value, [Vec<Vec<String>>; 2]) {
    let options = ["--config", "sea/mounting.toml", "--out", "offline.csv", "--json"];
    let fixed = ["track", "--detections", detections, "--platform", platform];
    let output = home.run(&[&fixed[..], &options[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let read = |name: &str| fs::read_to_string(home.path(name)).unwrap();
    let published = read("out/latest/sensor_tracks_sea.csv");
    let rows = common_columns(&read("offline.csv"), &published).map(free);
    (serde_json::from_slice(&output.stdout).unwrap(), rows)
}

/// Count of the tracker in the report of the run.
fn counted(home: &Home, label: &str) -> u64 {
    let report = fs::read_to_string(home.path("out/latest/report.json")).unwrap();
    let report: Value = serde_json::from_str(&report).unwrap();
    let sources = report["sources"].as_array().unwrap();
    let tracker = sources.iter().find(|source| source["name"] == "sea").unwrap();
    counter(&tracker["adapter"], label)
}

fn refused(summary: &Value) -> u64 {
    let of = |reason: &str| summary["platform"]["refused"][reason].as_u64().unwrap();
    of("gap") + of("no_state") + of("too_old")
}

#[test]
fn recorded_detections_on_board_give_the_tracks_of_track_with_a_platform() {
    let home = Home::new();
    simulate(&home, &["--for", "120"]);
    // The navigation is silent for ten seconds.
    let (header, mut states) = table(&home, "sea/platform.csv");
    states.retain(|(time_ns, _)| !(40_000_000_000..50_000_000_000).contains(time_ns));
    // Times before midnight are those of the day before.
    states.retain(|(time_ns, _)| *time_ns >= 0);
    write(&home, "thin.csv", &header, &states, 0);
    let text = format!(
        "name = \"test\"\n[frame]\nlatitude_deg = {}\nlongitude_deg = {}\n[time]\norder = \"time\"\ndate = \"2026-01-05\"\n\
         [[platform]]\nname = \"ship\"\nrecorded = {{ file = \"thin.csv\" }}\n\
         [[tracker]]\nname = \"sea\"\n{SETTINGS}\
         [[tracker.sensor]]\nname = \"radar\"\n{SENSOR}\
         recorded = {{ file = \"sea/detections.csv\", format = \"rows\" }}\n\
         [recorder]\nformat = [\"csv\", \"mcap\"]\n",
        PLACE[0], PLACE[1]
    );
    fs::write(home.path("site.toml"), text).unwrap();
    let arguments = [
        "up",
        "site.toml",
        "--instance",
        "test",
        "--data",
        ".",
        "--speed",
        "max",
        "--out",
        "out",
    ];
    let (status, said) = home.start(&arguments).end();
    assert_eq!(status.code(), Some(0), "{said}");
    let (again, tracks) = tracked_again(&home, "sea");
    assert_equal(&tracks);
    assert!(tracks[0].len() > 300, "{}", tracks[0].len());
    let (summary, tracks) = offline(&home, "sea/detections.csv", "thin.csv");
    assert_equal(&tracks);
    let rejected = counted(&home, "rejected_platform");
    assert!(rejected > 40, "{rejected}");
    assert_eq!(refused(&summary), rejected);
    assert_eq!(again["refused"]["no state of the platform near the time"], rejected);
    // The settings of the deployment serve for the tables, too.
    let options = ["--config", "site.toml", "--out", "offline.csv"];
    let (text, number) = (fs::read_to_string(home.path("sea/detections.csv")).unwrap(), "2");
    let renumbered: Vec<String> = text
        .lines()
        .map(|line| line.replacen(",1,", &format!(",{number},"), 1))
        .collect();
    fs::write(home.path("renumbered.csv"), renumbered.join("\n")).unwrap();
    let fixed = ["track", "--detections", "renumbered.csv", "--platform", "thin.csv"];
    let output = home.run(&[&fixed[..], &options[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let read = |name: &str| fs::read_to_string(home.path(name)).unwrap();
    let rows = common_columns(&read("offline.csv"), &read("out/latest/sensor_tracks_sea.csv")).map(free);
    assert_equal(&rows);
}

#[test]
fn live_detections_on_board_give_the_tracks_of_their_recording_and_of_track_with_a_platform() {
    let home = Home::new();
    simulate(&home, &["--for", "24", "--set", "period_s=0.5"]);
    // The rows come over a connection, the states in datagrams.
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let (rows_at, states_at) = (server.local_addr().unwrap(), free_address());
    let text = format!(
        "name = \"test\"\n[frame]\nlatitude_deg = {}\nlongitude_deg = {}\n\
         [[receiver]]\nname = \"rows\"\n[receiver.tcp]\nconnect = \"{rows_at}\"\n\
         [[platform]]\nname = \"ship\"\nwait_s = 1.0\n[platform.live]\nudp = {{ listen = \"{states_at}\" }}\n\
         [[tracker]]\nname = \"sea\"\nperiod_s = 0.5\nfresh_s = 5.0\n{SETTINGS}\
         [[tracker.sensor]]\nname = \"radar\"\n{SENSOR}\
         live = {{ receiver = \"rows\", format = \"rows\", sensor_id = 1 }}\n\
         [recorder]\nformat = [\"csv\", \"mcap\"]\n",
        PLACE[0], PLACE[1]
    );
    fs::write(home.path("site.toml"), text).unwrap();
    let running = home.start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
    running.until_said("instance test runs");
    for name in ["rows", "ship", "sea"] {
        until("it runs", || home.status_row(name).state == "running");
    }
    let (state_header, mut states) = table(&home, "sea/platform.csv");
    // A gap of the navigation: what is measured in it is refused, at the latest when the next state comes.
    states.retain(|(time_ns, _)| !(9_000_000_000..13_500_000_000).contains(time_ns));
    let (row_header, rows) = table(&home, "sea/detections.csv");
    // States come a quarter of a second after the detections of their time.
    let delayed = |time_ns: i64| time_ns + 250_000_000;
    let of_states = states.iter().map(|row| (delayed(row.0), true, row));
    let mut sent: Vec<(i64, bool, &(i64, String))> =
        rows.iter().map(|row| (row.0, false, row)).chain(of_states).collect();
    sent.sort_by_key(|(at_ns, is_state, _)| (*at_ns, *is_state));
    let (mut connection, _) = server.accept().unwrap();
    writeln!(connection, "{row_header}").unwrap();
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let begun_ns = utc_ns() + 500_000_000;
    for (at_ns, is_state, row) in sent {
        let wait_ns = begun_ns + at_ns - utc_ns();
        std::thread::sleep(Duration::from_nanos(u64::try_from(wait_ns).unwrap_or(0)));
        if is_state {
            let datagram = format!("{state_header}\n{}\n", line(row, begun_ns));
            socket.send_to(datagram.as_bytes(), states_at).unwrap();
        } else {
            writeln!(connection, "{}", line(row, begun_ns)).unwrap();
        }
    }
    let last = |rows: &[(i64, String)]| rows.last().unwrap().0;
    // The states reach beyond the last detection, so no detection waits at the end.
    assert!(last(&states) > last(&rows));
    until("all detections are carried", || {
        home.status_row("sea").state == "running" && utc_ns() > begun_ns + last(&states) + 2_000_000_000
    });
    let (ended, said) = running.stop();
    assert_eq!(ended.code(), Some(0), "{said}");
    let (again, tracks) = tracked_again(&home, "sea");
    assert_equal(&tracks);
    assert!(tracks[0].len() > 150, "{} rows", tracks[0].len());
    let rejected = counted(&home, "rejected_platform");
    assert!(rejected > 80, "{rejected}");
    assert_eq!(again["refused"]["no state of the platform near the time"], rejected);
    assert_eq!(counted(&home, "rejected_late"), 0);

    write(&home, "rows.csv", &row_header, &rows, begun_ns);
    write(&home, "states.csv", &state_header, &states, begun_ns);
    let (summary, [offline, published]) = offline(&home, "rows.csv", "states.csv");
    assert_eq!(refused(&summary), rejected);
    // The last scan of a live tracker is never complete.
    assert!(published.len() + 20 > offline.len() && published.len() <= offline.len());
    assert_equal(&[offline[..published.len()].to_vec(), published]);
    home.assert_nothing_is_left("test");
}

/// The shipped ship runs by itself: its sentences place the radar's detections, each target has a track, and nothing is
/// an alarm.
#[test]
fn a_simulated_ship_tracks_its_targets_live() {
    let home = Home::new();
    let config = repository("config/on-board.toml").display().to_string();
    let arguments = [
        "up",
        &config,
        "--instance",
        "test",
        "--for",
        "40",
        "--seed",
        "3",
        "--out",
        "out",
        "--set",
        "monitor.files=true",
    ];
    let (status, said) = home.start(&arguments).end();
    assert_eq!(status.code(), Some(0), "{said}");
    assert_no_alarm(&home);
    let (_, tracks) = tracked_again(&home, "sea");
    assert_equal(&tracks);
    let rows = &tracks[0];
    let time_s = |row: &[String]| row[0].parse::<f64>().unwrap();
    let last_s = rows.iter().map(|row| time_s(row)).fold(0.0, f64::max);
    let shown: Vec<_> = rows.iter().filter(|row| time_s(row) > last_s - 5.0).collect();
    let numbers: BTreeSet<&String> = shown.iter().map(|row| &row[1]).collect();
    assert!((11..=13).contains(&numbers.len()), "{} tracks", numbers.len());
    for row in shown {
        let speed = |column: usize| row[column].parse::<f64>().unwrap();
        assert!(speed(5).hypot(speed(6)) < 40.0, "{row:?}");
    }
    // Only what was measured before the first state is refused.
    assert!(counted(&home, "rejected_platform") < 40);
}

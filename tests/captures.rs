//! Captures of what sensors send, and the same sensor tracks made of them again.

use std::collections::BTreeSet;
use std::io::Write as _;
use std::net::{Ipv4Addr, TcpListener};
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;

use formats::containers::datagrams;

use crate::common::{Home, PLACE, until, utc_ns};

/// Simulated sensors that send datagrams.
const SIMULATED: [(&str, &str, &str); 2] = [
    (
        "mlat",
        "[source.simulated]\nkind = \"multilateration\"",
        "position_sigma_m = 2.0\nvelocity_sigma_mps = 8.0",
    ),
    (
        "ads-b",
        "[source.simulated]\nkind = \"ads-b\"",
        "position_sigma_m = 2.0\nvelocity_sigma_mps = 6.5",
    ),
];

/// A site of three sources, whose inputs `input` says.
fn site(more: &str, input: impl Fn(usize, &str) -> String) -> String {
    let [latitude, longitude] = PLACE;
    let mut text = format!("name = \"test\"\n[frame]\nlatitude_deg = {latitude}\nlongitude_deg = {longitude}\n{more}");
    for (index, (name, _, sigmas)) in SIMULATED.iter().enumerate() {
        let covariance = format!("[source.covariance]\nfrom = \"report\"\n{sigmas}\nheight_sigma_m = 10.0");
        let input = input(index, name);
        text += &format!("[[source]]\nname = \"{name}\"\nperiod_s = 1.0\nfresh_s = 3.5\n{input}\n{covariance}\n");
    }
    text + &format!(
        "[[source]]\nname = \"box\"\nperiod_s = 1.0\nfresh_s = 3.5\n{}\n",
        input(2, "box")
    )
}

fn files(folder: &Path, name: &str) -> Vec<std::path::PathBuf> {
    let begin = format!("received_{name}_");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_one = |path: &std::path::PathBuf| path.file_name().unwrap().to_str().unwrap().starts_with(&begin);
    let mut files: Vec<_> = entries.filter(is_one).collect();
    files.sort();
    files
}

/// Rows of a table, in an order that does not depend on that of arrival.
fn rows(folder: &Path, name: &str) -> Vec<String> {
    let table = std::fs::read_to_string(folder.join(format!("sensor_tracks_{name}.csv"))).unwrap();
    let mut rows: Vec<_> = table.lines().map(str::to_owned).collect();
    rows.sort();
    rows
}

#[test]
fn what_sensors_sent_gives_the_same_sensor_tracks_again() {
    let home = Home::new();
    let feed = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let server = feed.local_addr().unwrap();
    let receiver =
        format!("[scenario]\ntargets = 40\n[[receiver]]\nname = \"lines\"\n[receiver.sbs]\nconnect = \"{server}\"\n");
    let live = site(&receiver, |index, _| match SIMULATED.get(index) {
        Some((_, input, _)) => (*input).to_owned(),
        None => "[source.live]\nreceiver = \"lines\"".to_owned(),
    });
    std::fs::write(home.path("live.toml"), live).unwrap();
    let running = home.start(&[
        "up",
        "live.toml",
        "--instance",
        "live",
        "--out",
        "out",
        "--set",
        "recorder.format=[\"csv\", \"pcapng\"]",
        // Each batch in a file of its own, all but.
        "--set",
        "recorder.segment_s=1",
    ]);
    running.until_said("instance live runs");
    let (mut reader, _) = feed.accept().unwrap();
    let folder = home.path("out/latest");
    let has_rows = |name: &str, count: usize| {
        let table = std::fs::read_to_string(folder.join(format!("sensor_tracks_{name}.csv"))).unwrap_or_default();
        table.lines().count() > count
    };
    let mut line = 0;
    until("all sources have been heard", || {
        let ms = utc_ns() / 1_000_000 % 86_400_000;
        let (seconds, ms) = (ms / 1000, ms % 1000);
        let time = format!(
            "{:02}:{:02}:{:02}.{ms:03}",
            seconds / 3600,
            seconds / 60 % 60,
            seconds % 60
        );
        line += 1;
        // One line has no time, and is of the moment when it comes.
        let stamp = match line {
            7 => ",,,".to_owned(),
            _ => format!("2026/01/01,{time},2026/01/01,{time}"),
        };
        write!(reader, "MSG,3,1,1,4CA2D6,1,{stamp},,10000,,,41.5,2.3,,,0,0,0,0\r\n").unwrap();
        has_rows("mlat", 150) && has_rows("ads-b", 150) && has_rows("box", 3)
    });
    let (status, said) = running.stop();
    assert!(status.success(), "{said}");
    assert!(!said.contains("has lost"), "{said}");

    let mut date = String::new();
    for (name, adapter) in [("mlat", "mlat"), ("ads-b", "ads-b"), ("box", "lines")] {
        let files = files(&folder, adapter);
        let whole: Vec<u8> = files.iter().flat_map(|path| std::fs::read(path).unwrap()).collect();
        let first = datagrams(&whole).next().unwrap().unwrap().time_stamp.unwrap();
        date = formats::rows::Utc(first.ns()).to_string()[..10].to_owned();
        std::fs::write(home.path(&format!("{name}.pcapng")), whole).unwrap();
    }
    assert!(files(&folder, "mlat").len() > 1);
    let time = format!("[time]\norder = \"time\"\ndate = \"{date}\"\n");
    let again = site(&time, |index, name| {
        let format = if index == 2 { "sbs" } else { "asterix" };
        format!("[source.recorded]\nfile = \"{name}.pcapng\"\nformat = \"{format}\"")
    });
    std::fs::write(home.path("again.toml"), again).unwrap();
    let data = home.path("");
    let (status, said) = home
        .start(&[
            "up",
            "again.toml",
            "--data",
            data.to_str().unwrap(),
            "--speed",
            "max",
            "--out",
            "second",
        ])
        .end();
    assert!(status.success(), "{said}");
    for name in ["mlat", "ads-b", "box"] {
        let (before, after) = (rows(&folder, name), rows(&home.path("second/latest"), name));
        assert!(before.len() > 3);
        assert!(
            before == after,
            "{name}: {} rows before, {} again",
            before.len(),
            after.len()
        );
    }
}

/// Modes of all files, and of all folders, in `folder`.
fn modes(folder: &Path, found: &mut [BTreeSet<u32>; 2]) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let kind = entry.file_type().unwrap();
        if kind.is_symlink() {
            continue;
        }
        let mode = entry.metadata().unwrap().permissions().mode() & 0o7777;
        found[usize::from(kind.is_dir())].insert(mode);
        if kind.is_dir() {
            modes(&entry.path(), found);
        }
    }
}

#[test]
fn files_of_a_deployment_are_for_its_user_alone_unless_a_key_lets_others_read() {
    for (key, file, folder) in [(None, 0o600, 0o700), (Some("launcher.file_mode=\"640\""), 0o640, 0o750)] {
        let home = Home::new();
        let format = "recorder.format=[\"csv\", \"mcap\", \"pcapng\"]";
        let mut options = vec!["--out", "out", "--set", format];
        options.extend(["--set", "recorder.enabled=true", "--set", "monitor.files=true"]);
        options.extend(key.iter().flat_map(|key| ["--set", key]));
        let demo = home.demo_with(&options);
        let latest = home.path("out/latest");
        let has = |begin: &str, end: &str| {
            let entries = std::fs::read_dir(&latest).into_iter().flatten().flatten();
            let mut names = entries.map(|entry| entry.file_name().into_string().unwrap());
            names.any(|name| name.starts_with(begin) && name.ends_with(end))
        };
        until("all kinds of files are there", || {
            has("system_tracks", ".csv") && has("received_", ".pcapng") && has("", ".mcap")
        });
        demo.stop();
        let mut found = [BTreeSet::new(), BTreeSet::new()];
        modes(&home.path("out"), &mut found);
        assert_eq!(found, [BTreeSet::from([file]), BTreeSet::from([folder])], "{key:?}");
        home.assert_nothing_is_left("demo");
    }
}

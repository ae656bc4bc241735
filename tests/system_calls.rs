//! What fusion asks of the kernel once it runs on a core of its own: nothing (PL-4).

use std::io::Read as _;
use std::process::{Command, Stdio};

use rustix::process::Signal;

use crate::common::{Home, kill, until};

/// States that fusion must have published while it was watched.
const STATES_MIN: f64 = 20.0;

#[test]
fn a_spinning_fusion_makes_no_system_call() {
    if Command::new("strace").arg("--version").output().is_err() {
        println!("skipped: there is no strace to watch system calls with");
        return;
    }
    let core = runtime::cores::available().last().copied().unwrap();
    let home = Home::new();
    let demo = home.start(&[
        "demo",
        "--set",
        "fusion.wait=spin",
        "--set",
        &format!("fusion.core={core}"),
        "--set",
        "recorder.enabled=false",
    ]);
    demo.until_said("instance demo runs");
    let published_per_s = || home.status_row("fusion").published.parse::<f64>().unwrap_or(0.0);
    until("fusion publishes", || published_per_s() > STATES_MIN);

    let pid = home.status_row("fusion").pid.to_string();
    let mut strace = Command::new("strace")
        .args(["-c", "-p", &pid])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Its first line says that it watches.
    let mut said = strace.stderr.take().unwrap();
    let mut first = [0; 64];
    let length = said.read(&mut first).unwrap();
    let first = String::from_utf8_lossy(&first[..length]).into_owned();
    if first.contains("not permitted") {
        strace.wait().unwrap();
        println!("skipped: this machine does not allow to watch system calls: {first}");
        return;
    }
    until("it publishes while it is watched", || published_per_s() > STATES_MIN);
    kill(strace.id(), Signal::INT);
    let mut summary = String::new();
    said.read_to_string(&mut summary).unwrap();
    strace.wait().unwrap();
    assert!(first.contains("attached"), "{first}{summary}");
    let calls: Vec<&str> = summary.lines().filter(|line| is_of_a_call(line)).collect();
    assert!(calls.is_empty(), "{summary}");

    let (status, said) = demo.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("demo");
}

/// Rows of the summary begin with a share of the time; those of the heading and the total are no calls.
fn is_of_a_call(line: &str) -> bool {
    let share = line.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
    share.is_some() && !line.trim_end().ends_with("total")
}

//! Whoever looks on: `koseki top` in a terminal and in a pipe, and collectors of metrics, at deployments of real
//! processes (PL-9).
//!
//! Each test has its own folder for instances. Every wait is for a condition.

use std::fs::File;
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::os::fd::OwnedFd;
use std::process::{Child, ExitStatus};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

use rustix::process::Signal;
use rustix::pty::{OpenptFlags, grantpt, ioctl_tiocgptpeer, openpt, unlockpt};
use rustix::termios::{LocalModes, Winsize, tcgetattr, tcsetwinsize};

use crate::common::home::read;
use crate::common::{Home, Running, kill, until};

/// Switch to another screen, and back.
const ENTER: &str = "\x1b[?1049h";
const LEAVE: &str = "\x1b[?1049l";

#[test]
fn what_cannot_be_looked_at_is_refused_in_one_line_with_a_remedy() {
    let home = Home::new();
    let refused = |arguments: &[&str], code: i32, expected: &str| {
        let output = home.run(arguments);
        let line = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), line.lines().count()), (Some(code), 1), "{line}");
        assert!(line.contains(expected), "{line}");
        assert_eq!(output.stdout, b"");
    };
    refused(
        &["top"],
        1,
        "nothing runs; start a deployment with `koseki up` or `koseki demo`",
    );
    for command in [&["top"][..], &["tap"], &["status"], &["condition", "rain"]] {
        let of_another = [command, &["--instance", "demo"]].concat();
        refused(&of_another, 2, "no instance demo runs; `koseki status` shows");
    }
    for command in [
        &["top"][..],
        &["tap"],
        &["status"],
        &["condition", "rain"],
        &["demo"],
        &["up", "demo.toml"],
        &["fusion", "--config", "demo.toml"],
    ] {
        let wrong = [command, &["--instance", "bad name!"]].concat();
        refused(&wrong, 2, "bad name!");
    }
    refused(&["top", "--instance", "no name"], 2, "no name");
    refused(&["top", "--interval", "0"], 2, "it must be more than 0");
    refused(&["top", "--interval", "4000"], 2, "between 0.1 and 3600");
    let (first, second) = (home.demo(), home.start(&["demo", "--instance", "beside"]));
    second.until_said("instance beside runs");
    refused(&["top", "--once"], 2, "name one with --instance: beside, demo");
    let named = home.run(&["top", "--once", "--instance", "beside"]);
    assert!(named.stdout.starts_with(b"Koseki beside "), "{named:?}");
    assert_eq!(
        [first, second].map(|running| running.stop().0.code()),
        [Some(0), Some(0)]
    );
    for instance in ["demo", "beside"] {
        home.assert_nothing_is_left(instance);
    }
}

#[test]
fn everything_is_printed_once_with_the_names_of_sources_and_processes() {
    let home = Home::new();
    let demo = home.demo();
    let mut text = String::new();
    // The first words of some process may come later than one interval.
    until("all is known", || {
        let output = home.run(&["top", "--once", "--interval", "0.5"]);
        assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0), "{output:?}");
        text = String::from_utf8(output.stdout).unwrap();
        let known = [
            "\nall sources ",
            "\nradar-west ",
            "\nradar-east ",
            "\nmultilateration ",
            "\nads-b ",
            "\nads-b: end to end ",
            "\nadapter ads-b ",
            "\nfusion ",
            "\nsimulator ",
            "\nmonitor ",
            "\nlauncher ",
            " records_sent ",
        ];
        known.iter().all(|words| text.contains(words))
    });
    assert!(!text.contains("source 1") && !text.contains("\x1b"), "{text}");
    // The display chooses its port, and its address is known everywhere.
    let said = demo.said();
    let address = said
        .lines()
        .find_map(|line| line.split_once("the picture is at "))
        .unwrap()
        .1;
    assert!(address.starts_with("http://"), "{said}");
    assert!(text.contains(&format!("\nthe picture is at {address}\n")), "{text}");
    let status = home.status();
    assert!(
        status.contains(&format!("\n  the picture is at {address}\n")),
        "{status}"
    );
    demo.stop();
    home.assert_nothing_is_left("demo");
}

#[test]
fn lines_go_on_when_fusion_is_restarted_and_end_with_the_deployment() {
    let home = Home::new();
    let demo = home.demo();
    let top = home.start(&["top", "--interval", "0.2"]);
    let lines = |top: &Running| top.stdout.lock().unwrap().clone();
    until("latencies are shown", || lines(&top).contains("end to end p50"));
    kill(home.status_row("fusion").pid, Signal::KILL);
    until("the restart is shown", || lines(&top).contains("| 1 restart"));
    let before = lines(&top).len();
    until("latencies are shown again", || {
        lines(&top)[before..].contains("end to end p50")
    });
    assert_eq!(demo.stop().0.code(), Some(0));
    let stdout = Arc::clone(&top.stdout);
    let (status, said) = top.end();
    assert_eq!((status.code(), said.as_str()), (Some(0), ""));
    let text = stdout.lock().unwrap().clone();
    assert_eq!(text.lines().last(), Some("instance demo has ended"), "{text}");
    assert!(text.lines().all(|line| line.contains("demo")), "{text}");
    home.assert_nothing_is_left("demo");
}

#[test]
fn a_killed_launcher_is_an_end_too() {
    let home = Home::new();
    let demo = home.demo();
    let top = home.start(&["top", "--interval", "0.2"]);
    until("something is shown", || top.stdout.lock().unwrap().contains("demo |"));
    demo.signal(Signal::KILL);
    let (status, said) = top.end();
    assert_eq!((status.code(), said.as_str()), (Some(0), ""));
    demo.end();
    until("the children have ended", || home.processes().is_empty());
    assert_eq!(home.run(&["demo", "--for", "0.5"]).status.code(), Some(0));
    home.assert_nothing_is_left("demo");
}

#[test]
fn the_terminal_is_restored_however_it_ends() {
    let home = Home::new();
    let demo = home.demo();
    for end in [End::Key(b"q"), End::Key(b"\x03"), End::Signal(Signal::TERM)] {
        let mut top = Seated::start(&home, &["top", "--interval", "0.2"]);
        until("the sources are shown", || top.shown().contains("radar-west"));
        assert!(!top.is_as_before(), "keys come one by one");
        top.press(b"4");
        // Only cells that change are written, so a word must come where there was none.
        until("the counters are shown", || top.shown().contains("decoded"));
        top.press(b"\tp");
        until("it is paused", || top.shown().contains("paused"));
        match end {
            End::Key(key) => top.press(key),
            End::Signal(signal) => kill(top.child.id(), signal),
        }
        let (status, text) = top.end();
        assert_eq!(status.code(), Some(0), "{text}");
        assert_eq!((text.matches(ENTER).count(), text.matches(LEAVE).count()), (1, 1));
    }
    let mut top = Seated::start(&home, &["top", "--interval", "0.2"]);
    until("the sources are shown", || top.shown().contains("radar-west"));
    assert_eq!(demo.stop().0.code(), Some(0));
    top.wait();
    let (status, text) = top.end();
    assert_eq!(status.code(), Some(0), "{text}");
    let last = text.split(LEAVE).last().unwrap();
    assert!(last.contains("instance demo has ended"), "{last}");
    home.assert_nothing_is_left("demo");
}

#[test]
fn the_end_of_the_terminal_is_an_end_too() {
    let home = Home::new();
    let demo = home.demo();
    let (keyboard, terminal) = pseudo_terminal();
    let command = home
        .command(&["top", "--interval", "0.2"])
        .stdin(terminal.try_clone().unwrap())
        .stdout(terminal.try_clone().unwrap())
        .stderr(terminal)
        .spawn();
    let mut top = Ending(command.unwrap());
    let (mut screen, mut shown) = (File::from(keyboard), String::new());
    let mut read = [0; 4096];
    // The terminal controls no process: its end sends no signal.
    while !shown.contains("radar-west") {
        let count = screen.read(&mut read).unwrap();
        shown.push_str(&String::from_utf8_lossy(&read[..count]));
    }
    drop(screen);
    until("top has ended", || top.0.try_wait().unwrap().is_some());
    demo.stop();
    home.assert_nothing_is_left("demo");
}

#[test]
fn metrics_are_collected_from_a_deployment_that_runs() {
    let home = Home::new();
    let demo = home.start(&["demo", "--set", "monitor.prometheus=\"127.0.0.1:0\""]);
    demo.until_said("metrics are at http://127.0.0.1:");
    let said = demo.said();
    let (_, url) = said.split_once("metrics are at http://").unwrap();
    let address = url.split('/').next().unwrap().to_owned();
    let collect = || {
        let mut stream = TcpStream::connect(&address).unwrap();
        stream
            .write_all(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n")
            .unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        text
    };
    until("fusion is up and states have come", || {
        let text = collect();
        let up = "koseki_process_up{kind=\"fusion\",process=\"fusion\"} 1.0\n";
        let count = "koseki_stage_latency_seconds_count{stage=\"end_to_end\",source=\"ads-b\"} ";
        text.contains(up) && text.contains(count) && text.ends_with("# EOF\n")
    });
    assert_eq!(demo.stop().0.code(), Some(0));
    assert!(TcpStream::connect(&address).is_err());
    home.assert_nothing_is_left("demo");
}

/// How somebody ends it.
enum End {
    Key(&'static [u8]),
    Signal(Signal),
}

/// Process that ends with the test.
struct Ending(Child);

impl Drop for Ending {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A keyboard with a screen, and the terminal as programs have it. It controls no process.
fn pseudo_terminal() -> (OwnedFd, OwnedFd) {
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
    let keyboard = openpt(flags).unwrap();
    grantpt(&keyboard).unwrap();
    unlockpt(&keyboard).unwrap();
    let terminal = ioctl_tiocgptpeer(&keyboard, flags).unwrap();
    let size = Winsize {
        ws_row: 40,
        ws_col: 160,
        ws_xpixel: 0,
        ws_ypixel: 0,
    };
    tcsetwinsize(&terminal, size).unwrap();
    (keyboard, terminal)
}

/// A `koseki` at a terminal.
struct Seated {
    child: Child,
    keyboard: File,
    /// The terminal as programs see it.
    terminal: Option<OwnedFd>,
    screen: Arc<Mutex<String>>,
    reader: JoinHandle<()>,
}

impl Seated {
    fn start(home: &Home, arguments: &[&str]) -> Self {
        let (keyboard, terminal) = pseudo_terminal();
        let screen = Arc::default();
        let reader = read(File::from(keyboard.try_clone().unwrap()), Arc::clone(&screen));
        let child = home
            .command(arguments)
            .stdin(terminal.try_clone().unwrap())
            .stdout(terminal.try_clone().unwrap())
            .stderr(terminal.try_clone().unwrap())
            .spawn()
            .unwrap();
        Self {
            child,
            keyboard: keyboard.into(),
            terminal: Some(terminal),
            screen,
            reader,
        }
    }

    fn press(&mut self, keys: &[u8]) {
        self.keyboard.write_all(keys).unwrap();
    }

    /// All that was written to it so far.
    fn shown(&self) -> String {
        self.screen.lock().unwrap().clone()
    }

    /// Whether lines are edited and letters echoed, as at a shell's prompt.
    fn is_as_before(&self) -> bool {
        let modes = tcgetattr(self.terminal.as_ref().unwrap()).unwrap().local_modes;
        modes.contains(LocalModes::ICANON | LocalModes::ECHO | LocalModes::ISIG)
    }

    fn wait(&mut self) {
        until("it ends", || self.child.try_wait().unwrap().is_some());
    }

    /// Waits for the end. The terminal must be as before then.
    fn end(mut self) -> (ExitStatus, String) {
        self.wait();
        assert!(self.is_as_before(), "the terminal is restored");
        let status = self.child.wait().unwrap();
        // With the last holder of the terminal gone, the reader ends.
        self.terminal = None;
        until("all is read", || self.reader.is_finished());
        let text = self.shown();
        (status, text)
    }
}

impl Drop for Seated {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

//! Reports that a link saves while it is cut, and brings in faster than they were made: they are used, or counted as
//! late, and the clock of their sensor is sound.

use std::collections::VecDeque;
use std::io::Write as _;
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use messages::{Counter, CounterClass};
use serde_json::Value;
use test_support::Random;

use crate::common::{Home, PLACE, counter, until, utc_ns};

/// Least time between two reports of a sensor, and between two that the link brings: five times as fast as they were
/// made. Least length of the cut.
const PERIOD: Duration = Duration::from_millis(100);
const STEP: Duration = Duration::from_millis(20);
const CUT: Duration = Duration::from_secs(4);
/// Reports of each sensor before the cut and after the saved ones: enough to know its clock.
const REPORTS: usize = 40;

/// A receiver of transponder signals that serves lines: of the moment when each is made.
struct Feed {
    listener: TcpListener,
    stream: Option<TcpStream>,
    saved: VecDeque<String>,
    lines: usize,
    made: Instant,
    sent: Instant,
    /// Errors of its own: sources that repeat each other are one.
    random: Random,
}

impl Feed {
    fn new(seed: u64) -> Self {
        Self {
            random: Random::new(seed),
            listener: TcpListener::bind("127.0.0.1:0").unwrap(),
            stream: None,
            saved: VecDeque::new(),
            lines: 0,
            made: Instant::now(),
            sent: Instant::now(),
        }
    }

    /// Makes the next line if it is time, and sends the first of those that wait, if it is time for that.
    fn pass(&mut self) {
        if self.made.elapsed() >= PERIOD {
            self.made = Instant::now();
            self.lines += 1;
            let line = self.line();
            self.saved.push_back(line);
        }
        if let Some(stream) = self.stream.as_mut().filter(|_| self.sent.elapsed() >= STEP)
            && let Some(line) = self.saved.pop_front()
        {
            self.sent = Instant::now();
            stream.write_all(line.as_bytes()).unwrap();
        }
    }

    fn line(&mut self) -> String {
        let ms = utc_ns() / 1_000_000 % 86_400_000;
        let (hours, minutes, ms) = (ms / 3_600_000, ms / 60_000 % 60, ms % 60_000);
        let time = format!("2026/01/01,{hours:02}:{minutes:02}:{:02}.{:03}", ms / 1000, ms % 1000);
        let [latitude, longitude] = [41.5, 2.3].map(|place| place + self.random.between(-4e-4, 4e-4));
        format!("MSG,3,1,1,4CA2D6,1,{time},{time},,10000,,,{latitude:.5},{longitude:.5},,,0,0,0,0\r\n")
    }

    /// Lets time pass for `feeds` until `done`.
    fn pass_until(feeds: &mut [Self; 2], what: &str, mut done: impl FnMut(&mut [Self; 2]) -> bool) {
        until(what, || {
            feeds.iter_mut().for_each(Self::pass);
            done(feeds)
        });
    }

    /// Takes a connection, if somebody connects.
    fn connect(&mut self) -> bool {
        self.listener.set_nonblocking(true).unwrap();
        if let Ok((stream, _)) = self.listener.accept() {
            stream.set_nonblocking(false).unwrap();
            self.stream = Some(stream);
        }
        self.stream.is_some()
    }
}

#[test]
fn reports_saved_through_a_cut_are_used_or_counted_as_late() {
    let home = Home::new();
    let mut feeds = [Feed::new(1), Feed::new(2)];
    let mut text = format!(
        "name = \"test\"\nframe = {{ latitude_deg = {}, longitude_deg = {} }}\nrecorder = {{ enabled = false }}\n\
         display = {{ listen = \"off\" }}\n",
        PLACE[0], PLACE[1]
    );
    for (name, feed) in ["near", "far"].into_iter().zip(&feeds) {
        let address = feed.listener.local_addr().unwrap();
        text += &format!(
            "[[receiver]]\nname = \"{name}\"\nsbs = {{ connect = \"{address}\" }}\n[[source]]\nname = \"{name}\"\n\
             period_s = 0.1\nfresh_s = 60.0\nsilent_periods = 0\nlive = {{ receiver = \"{name}\" }}\n\
             covariance = {{ position_sigma_m = 30.0 }}\n"
        );
    }
    home.write("site.toml", text);
    let running = home.start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
    running.until_said("instance test runs");
    let connected = |feeds: &mut [Feed; 2]| feeds.iter_mut().all(Feed::connect);
    Feed::pass_until(&mut feeds, "both are connected", connected);
    // What was made before the connection was saved, too.
    let known = feeds.each_ref().map(|feed| feed.lines + REPORTS);
    let all_known = |feeds: &mut [Feed; 2]| feeds.iter().zip(known).all(|(feed, known)| feed.lines >= known);
    Feed::pass_until(&mut feeds, "both clocks are known", all_known);

    // The far link is cut for some seconds, while the near one goes on.
    let nothing_waits = |feeds: &mut [Feed; 2]| feeds.iter().all(|feed| feed.saved.is_empty());
    Feed::pass_until(&mut feeds, "all is sent", nothing_waits);
    let (before, begun) = (feeds[1].lines, Instant::now());
    feeds[1].stream = None;
    Feed::pass_until(&mut feeds, "the cut is over", |_| begun.elapsed() >= CUT);
    let saved = feeds[1].lines - before;
    Feed::pass_until(&mut feeds, "the link is back", connected);
    let last = feeds.each_ref().map(|feed| feed.lines + REPORTS);
    let all_sent = |feeds: &mut [Feed; 2]| feeds.iter().zip(last).all(|(feed, last)| feed.lines >= last);
    Feed::pass_until(&mut feeds, "the present goes on", all_sent);
    Feed::pass_until(&mut feeds, "all is sent again", nothing_waits);
    let is_taken = |report: &Value, name: &str, lines: usize| {
        let mut sources = report["sources"].as_array().into_iter().flatten();
        sources.any(|source| source["name"] == name && source["taken"].as_u64() == Some(lines as u64))
    };
    until("all lines are taken", || {
        let top = home.run(&["top", "--instance", "test", "--once", "--json", "--interval", "0.5"]);
        let top: Value = serde_json::from_slice(&top.stdout).unwrap_or_default();
        is_taken(&top, "near", feeds[0].lines) && is_taken(&top, "far", feeds[1].lines)
    });
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");

    let report: Value = serde_json::from_str(&home.read("out/latest/report.json")).unwrap();
    for (source, feed) in report["sources"].as_array().unwrap().iter().zip(&feeds) {
        let fusion = |label: &str| counter(&source["fusion"], label);
        assert_eq!(fusion("taken"), feed.lines as u64);
        let unused: u64 = Counter::of(CounterClass::FusionRejection)
            .map(|counter| fusion(counter.label()))
            .sum();
        assert_eq!(unused, 0, "{}", source["fusion"]);
        assert_eq!(counter(&source["adapter"], "rejected_late"), 0);
    }
    let far = &report["sources"][1]["fusion"];
    let late = ["late_used", "late_beyond_window", "late_unkept"].map(|label| counter(far, label));
    assert!(saved >= 10, "{saved} were saved");
    assert!(late.iter().sum::<u64>() >= saved as u64 / 2, "{late:?} of {saved}");
    let of_clocks = ["clock-off", "source-isolated", "machine-clock-off", "clocks-differ"];
    let alarms = report["alarms"].as_array().unwrap().iter();
    let alarms: Vec<_> = alarms
        .filter(|alarm| of_clocks.iter().any(|kind| alarm["alarm"] == *kind))
        .collect();
    assert!(alarms.is_empty(), "{alarms:?}");
    home.assert_nothing_is_left("test");
}

//! `koseki order`: orders to a live deployment, their effects on the system tracks, their records, and refusals.

use std::fs;
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::os::unix::process::CommandExt as _;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use bus::{Bus, Mark, SharedMemory, Subscriber};
use messages::layout::Sample as _;
use messages::{FusionRule, Order, OrderKind, OrderState, OrderStatus, SystemTrack, TrackState};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use runtime::Now;
use runtime::clock::mono_ns;
use runtime::instance::leading_fusion;
use rustix::process::Signal;

use crate::common::home::{Home, kill, until};

/// Recorded, with decisions and all that any rule needs.
const RECORDED: [&str; 8] = [
    "--set",
    "recorder.format=[\"csv\", \"mcap\"]",
    "--set",
    "recorder.enabled=true",
    "--set",
    "fusion.rule.accuracy_values=true",
    "--out",
    "out",
];

/// A reader of the system tracks.
struct Watcher {
    tracks: Subscriber<SharedMemory, SystemTrack>,
    _bus: Bus<SharedMemory>,
}

impl Watcher {
    fn of(home: &Home) -> Self {
        let bus = Bus::open(&home.root("demo"), "watcher").unwrap();
        let tracks = bus.subscriber(&messages::system_tracks(), || mono_ns() as u64).unwrap();
        Self { tracks, _bus: bus }
    }

    /// Waits for a state that `is_meant`.
    fn state(&mut self, what: &str, is_meant: impl Fn(&SystemTrack) -> bool) -> SystemTrack {
        let mut found = None;
        until(what, || {
            let taken = self.tracks.take(usize::MAX, |_, tracks: &[SystemTrack]| {
                found = found.or(tracks.iter().copied().find(&is_meant));
            });
            taken.unwrap();
            found.is_some()
        });
        found.unwrap()
    }

    /// Waits for so many states in a row that all are as `is_meant`.
    fn states(&mut self, what: &str, count: usize, is_meant: impl Fn(&SystemTrack) -> bool) {
        let mut row = 0;
        until(what, || {
            let judge = |row: usize, track: &SystemTrack| if is_meant(track) { row + 1 } else { 0 };
            self.tracks
                .take(usize::MAX, |_, tracks| row = tracks.iter().fold(row, judge))
                .unwrap();
            row >= count
        });
    }
}

fn confirmed(track: &SystemTrack) -> bool {
    track.state == TrackState::Confirmed as u8
}

/// Gives an order as a command line has it; the words that follow `koseki order`.
fn order(home: &Home, words: &str) -> Output {
    let words: Vec<&str> = words.split_whitespace().collect();
    home.run(&[&["order", "--instance", "demo"], &words[..]].concat())
}

fn obeyed(home: &Home, words: &str) {
    let output = order(home, words);
    assert!(output.status.success(), "{words}: {output:?}");
}

fn refused(home: &Home, words: &str, why: &str) {
    let output = order(home, words);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && said.contains(why), "{words}: {said}");
}

fn in_force(home: &Home) -> Vec<(u64, String, String)> {
    let list: serde_json::Value = serde_json::from_slice(&order(home, "--json").stdout).unwrap();
    let states = list
        .as_array()
        .unwrap()
        .iter()
        .filter(|state| state["state"] == "in-force");
    let text = |value: &serde_json::Value| value.as_str().unwrap().to_owned();
    states
        .map(|state| {
            (
                state["number"].as_u64().unwrap(),
                text(&state["kind"]),
                text(&state["operator"]),
            )
        })
        .collect()
}

#[test]
fn orders_of_every_kind_have_their_effects_and_are_fused_again_to_the_bit() {
    let home = Home::new();
    let demo = home.demo_with(&[&RECORDED[..], &["--set", "fusion.standby=true"]].concat());
    let mut watcher = Watcher::of(&home);
    let source = 3;
    watcher.state("ads-b contributes", |track| {
        confirmed(track) && track.contributions().iter().any(|part| part.source == source)
    });

    obeyed(&home, "out source=ads-b --operator anna");
    watcher.states("nothing of ads-b is in the picture", 400, |track| {
        track.contributions().iter().all(|part| part.source != source)
    });
    obeyed(&home, "in source=ads-b --operator anna");
    watcher.state("ads-b contributes again", |track| {
        track.contributions().iter().any(|part| part.source == source)
    });

    obeyed(&home, "rule name=best-source --operator ben");
    let best = FusionRule::BestSource.code();
    watcher.states("the ordered rule weighs", 200, |track| {
        track.rule == best || track.state == TrackState::Terminated as u8
    });
    obeyed(&home, "eta value=0.25 --operator anna --for 3600");
    // A large k makes another source the best one of its targets: the first weight of the hand-over is eta_0 (TI-13).
    let config = configuration::Config::of_running(home.root("demo").path()).unwrap();
    let name = |source: u16| config.sources[usize::from(source)].name.clone();
    let chosen = watcher.state("a track of two sources is shown", |track| {
        confirmed(track) && track.contribution_count >= 2 && track.contributions().iter().any(|part| part.weight == 1.0)
    });
    obeyed(&home, &format!("k source={} value=1e9", name(chosen.selected_source)));
    watcher.state("eta_0 is a weight", |track| {
        let weights = |weight: f64| {
            track
                .contributions()
                .iter()
                .any(|part| (part.weight - weight).abs() < 1e-9)
        };
        weights(0.25) && weights(0.75)
    });
    obeyed(&home, "reset source=radar-west");

    let dropped = watcher.state("a target is shown", confirmed).track_number;
    obeyed(&home, &format!("drop track={dropped}"));
    let other = |track: &SystemTrack| confirmed(track) && track.track_number != dropped;
    let renumbered = watcher.state("another target is shown", other).track_number;
    obeyed(&home, &format!("renumber track={renumbered}"));
    let ended = watcher.state("the old number ends", |track| {
        track.track_number == renumbered && track.state == TrackState::Terminated as u8
    });
    assert!(ended.merged_into > renumbered);
    let split = watcher.state("a track of two sources is shown", |track| {
        confirmed(track) && track.contribution_count >= 2 && ![dropped, renumbered].contains(&track.track_number)
    });
    let part = split.contributions()[1];
    let number = split.track_number;
    let source = name(part.source);
    obeyed(
        &home,
        &format!(
            "split track={number} source={source} sensor_track={}",
            part.track_number
        ),
    );

    // Kill and take-over: all orders that last are in force afterwards, under their numbers.
    let before = in_force(&home);
    let kinds: Vec<&str> = before.iter().map(|(_, kind, _)| kind.as_str()).collect();
    for kind in ["rule", "eta", "k", "drop", "split"] {
        assert!(kinds.contains(&kind), "{kind}: {before:?}");
    }
    for _ in 0..2 {
        let leads = || leading_fusion(&home.root("demo"));
        until("one stands by", || home.status_row("standby").state == "running");
        let leader = leads().unwrap();
        kill(leader, Signal::KILL);
        until("another leads", || leads().is_some_and(|now| now != leader));
        until("the orders are in force", || in_force(&home) == before);
        watcher.states("the ordered rule weighs", 100, |track| {
            track.rule == best || track.state == TrackState::Terminated as u8
        });
    }
    let status = home.status();
    assert!(status.contains(" of anna: eta value=0.25"), "{status}");
    let eta = before.iter().find(|(_, kind, _)| kind == "eta").unwrap().0;
    obeyed(&home, &format!("cancel number={eta}"));
    refused(
        &home,
        &format!("cancel number={eta}"),
        "no order in force has the number",
    );
    drop(watcher);
    let (status, said) = demo.stop();
    assert!(status.success(), "{said}");
    home.assert_nothing_is_left("demo");

    let rows = fs::read_to_string(home.path("out/latest/orders.csv")).unwrap();
    for state in [
        ",in-force,out,anna,",
        ",replaced,out,anna,",
        ",done,in,anna,",
        ",in-force,rule,ben,",
        ",cancelled,eta,anna,",
        ",refused,cancel,",
    ] {
        assert!(rows.contains(state), "{state}: {rows}");
    }
    let output = home.run(&["replay", "out/latest", "--verify"]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(
        output.status.success() && said.contains(", 0 differences\n") && !said.contains("not verified"),
        "{said}{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn joined_targets_that_lie_far_apart_are_two_again_after_ten_seconds() {
    let home = Home::new();
    let more = [
        "--set",
        "fusion.association.use_identity=false",
        "--set",
        "fusion.decisions=true",
    ];
    let demo = home.demo_with(&[&RECORDED[..], &more].concat());
    let mut watcher = Watcher::of(&home);
    // Targets that no source mistakes for each other.
    let one = watcher.state("a target is shown", confirmed);
    let other = watcher.state("another one is shown far away", |track| {
        let apart = |axis: usize| track.position_m[axis] - one.position_m[axis];
        confirmed(track) && apart(0).hypot(apart(1)) > 20e3
    });
    obeyed(
        &home,
        &format!("join track={} with={}", one.track_number, other.track_number),
    );
    let left = one.track_number.min(other.track_number);
    let ended = watcher.state("one of the numbers ends", |track| track.merged_into == left);
    assert!([one.track_number, other.track_number].contains(&ended.track_number));
    until("the order ends by itself", || in_force(&home).is_empty());
    drop(watcher);
    let (status, said) = demo.stop();
    assert!(status.success(), "{said}");
    let decisions = fs::read_to_string(home.path("out/latest/decisions.csv")).unwrap();
    let ends: Vec<&str> = decisions.lines().filter(|row| row.contains(",order_ended,")).collect();
    assert_eq!(ends.len(), 1, "{decisions}");
    let time_s = |row: &str| row.split(',').next().unwrap().parse::<f64>().unwrap();
    let given = decisions.lines().find(|row| row.contains(",ordered,")).unwrap();
    let lasted_s = time_s(ends[0]) - time_s(given);
    assert!((10.0..13.0).contains(&lasted_s), "{lasted_s} s");
    let rows = fs::read_to_string(home.path("out/latest/orders.csv")).unwrap();
    assert!(rows.contains(",ended,join,"), "{rows}");
    let verified = home.run(&["replay", "out/latest", "--verify"]);
    assert!(verified.status.success(), "{verified:?}");
}

#[test]
fn two_operators_at_once_are_told_apart_in_the_record() {
    const EACH: usize = 8;
    let home = Home::new();
    let demo = home.demo_with(&RECORDED);
    obeyed(&home, "rule name=best-source");
    std::thread::scope(|scope| {
        for (operator, source) in [("anna", "radar-west"), ("ben", "radar-east")] {
            let home = &home;
            scope.spawn(move || {
                for value in 1..=EACH {
                    obeyed(home, &format!("k source={source} value={value} --operator {operator}"));
                }
            });
        }
    });
    let last = in_force(&home);
    assert_eq!(last.len(), 3, "{last:?}");
    demo.stop();
    let rows = fs::read_to_string(home.path("out/latest/orders.csv")).unwrap();
    let given: Vec<&str> = rows.lines().filter(|row| row.contains(",in-force,k,")).collect();
    assert_eq!(given.len(), 2 * EACH, "{rows}");
    let numbers = given
        .iter()
        .map(|row| row.split(',').nth(1).unwrap().parse::<u32>().unwrap());
    let mut numbers: Vec<u32> = numbers.collect();
    numbers.sort_unstable();
    assert_eq!(
        numbers,
        // The first one chose the rule.
        (2..=1 + 2 * EACH as u32).collect::<Vec<_>>(),
        "each order has a number of its own"
    );
    for operator in ["anna", "ben"] {
        let own = given.iter().filter(|row| row.contains(&format!(",k,{operator},")));
        assert_eq!(own.count(), EACH);
    }
}

#[test]
fn wrong_orders_are_refused_with_a_sentence() {
    let home = Home::new();
    let demo = home.demo();
    for (words, why) in [
        ("eta value=1.5", "value must lie between 0 and 1"),
        ("out source=radar-nowhere", "there is no source of this name"),
        ("shoot", "there is no order \"shoot\""),
        ("join track=1", "join track=NUMBER with=NUMBER"),
        ("drop track=4000000000", "no such system track"),
        ("rule name=best-source", "needs stored reports"),
        (
            "condition name=hailstorm",
            "no source has an accuracy for the condition",
        ),
        ("in source=ads-b", "the source is not out"),
    ] {
        refused(&home, words, why);
    }
    let nobody = home.run(&["order", "--instance", "nobody"]);
    assert_eq!(nobody.status.code(), Some(2));
    if rustix::process::geteuid().is_root() {
        // Another user: the file mode of the instance's folder keeps the order out.
        let executable = env!("CARGO_BIN_EXE_koseki");
        let copy = home.path("koseki-of-all");
        let reachable = fs::copy(executable, &copy).is_ok();
        let mut command = Command::new(if reachable {
            copy.as_os_str()
        } else {
            executable.as_ref()
        });
        command.args(["order", "out", "source=ads-b", "--instance", "demo", "--root"]);
        let output = command
            .arg(home.base())
            .uid(54_321)
            .gid(54_321)
            .current_dir("/")
            .output();
        assert!(output.is_err() || !output.unwrap().status.success());
    }
    assert!(in_force(&home).is_empty());
    demo.stop();
    home.assert_nothing_is_left("demo");
}

#[test]
fn malformed_orders_and_a_flood_reach_nothing_and_lock_nobody_out() {
    let home = Home::new();
    let demo = home.demo();
    let mut watcher = Watcher::of(&home);
    let bus = Bus::<SharedMemory>::open(&home.root("demo"), "vandal").unwrap();
    let mut orders = bus.publisher(&messages::orders(), mono_ns() as u64).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(2026);
    let fusion = home.status_row("fusion").pid;
    for number in 0..10_000u64 {
        let sound = Order {
            token: 1 + number,
            sent_ns: Now::read().utc_ns,
            track: random.random_range(1..200),
            ..Order::new(OrderKind::ALL[number as usize % OrderKind::ALL.len()])
        };
        let mut bytes = Order::octets(std::slice::from_ref(&sound)).to_vec();
        for _ in 0..random.random_range(1..8) {
            let place = random.random_range(0..bytes.len());
            bytes[place] = random.random();
        }
        let order = Order::of_octets(&bytes).unwrap();
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: mono_ns(),
            end: false,
        };
        orders.send(mark, 1, |_, _| order).unwrap();
    }
    watcher.state("the picture goes on", confirmed);
    // In the flood, a sound order is obeyed.
    let mut port = bus::OrderPort::open(&bus, 1 + mono_ns() as u64).unwrap();
    let out = Order {
        source: 0,
        ..Order::new(OrderKind::Out)
    };
    port.give(&out.with_operator("anna"), Now::read().utc_ns);
    let mut answer = None;
    until("the order is answered", || {
        let malformed = Order {
            token: 1,
            ..Order::default()
        };
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: mono_ns(),
            end: false,
        };
        orders.send(mark, 1, |_, _| malformed).unwrap();
        answer = answer.or(port.turn(mono_ns()).unwrap());
        answer.is_some()
    });
    let answer: OrderState = answer.unwrap();
    assert_eq!(answer.status(), Some(OrderStatus::InForce), "{}", answer.text());
    assert_eq!(home.status_row("fusion").pid, fusion, "the same fusion");
    drop((orders, port, watcher, bus));
    let (status, said) = demo.stop();
    assert!(status.success(), "{said}");
    home.assert_nothing_is_left("demo");
}

/// Token of the operators of a test.
const TOKEN: &str = "0123456789abcdef-operators";

/// Status and body of the answer to a request.
pub(crate) fn ask(address: &str, head: &str, headers: &[(&str, &str)], body: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(address).unwrap();
    let headers: String = headers
        .iter()
        .map(|(name, value)| format!("{name}: {value}\r\n"))
        .collect();
    let length = body.len();
    let request = format!("{head} HTTP/1.1\r\nHost: localhost\r\nContent-Length: {length}\r\n{headers}\r\n{body}");
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let status = answer.split_whitespace().nth(1).unwrap().parse().unwrap();
    (status, answer.split_once("\r\n\r\n").unwrap().1.to_owned())
}

#[test]
fn the_display_takes_orders_of_operators_alone() {
    let home = Home::new();
    let port = crate::common::free_address();
    let listen = format!("display.listen=\"{port}\"");
    let format = "recorder.format=[\"csv\", \"mcap\"]";
    let set = [
        "--set",
        &listen,
        "--set",
        "recorder.enabled=true",
        "--set",
        format,
        "--out",
        "out",
    ];
    // A command line is readable for every user of the machine.
    let token = format!("display.operator_token=\"{TOKEN}\"");
    let refused = home.run(&["demo", "--set", &token]);
    let said = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(
        said.contains("KOSEKI_DISPLAY_OPERATOR_TOKEN") && !said.contains(TOKEN),
        "{said}"
    );
    let mut command = home.command(&[&["demo"][..], &set].concat());
    let demo = home.start_command(command.env("KOSEKI_DISPLAY_OPERATOR_TOKEN", TOKEN));
    demo.until_said("instance demo runs");
    for process in std::fs::read_dir("/proc").unwrap().flatten() {
        let line = std::fs::read(process.path().join("cmdline")).unwrap_or_default();
        assert!(!String::from_utf8_lossy(&line).contains(TOKEN), "{process:?}");
    }
    let address = port.to_string();
    let order = |headers: &[(&str, &str)], body: &str| {
        let json = ("Content-Type", "application/json");
        ask(&address, "POST /api/order", &[&[json], headers].concat(), body)
    };
    let bearer_text = format!("Bearer {TOKEN}");
    let bearer = ("Authorization", bearer_text.as_str());
    let out = r#"{"kind": "out", "source": "radar-west", "operator": "anna", "for_s": 600}"#;
    assert_eq!(order(&[], out).0, 403);
    assert_eq!(order(&[("Authorization", "Bearer wrong")], out).0, 403);
    assert_eq!(order(&[bearer, ("Origin", "http://evil.example")], out).0, 403);
    let (status, body) = order(&[bearer], out);
    assert!(
        status == 200 && body.contains("out source=radar-west"),
        "{status} {body}"
    );
    for (wrong, why) in [
        ("[]", "no JSON object"),
        (r#"{"kind": "out", "operator": "anna"}"#, "incomplete"),
        (r#"{"kind": "out", "source": "radar-west"}"#, "needs an operator"),
        (r#"{"kind": "eta", "value": 2, "operator": "anna"}"#, "between 0 and 1"),
    ] {
        let (status, body) = order(&[bearer], wrong);
        assert!(status == 400 && body.contains(why), "{wrong}: {status} {body}");
    }
    let (status, body) = order(
        &[bearer],
        r#"{"kind": "drop", "track": 4000000000, "operator": "anna"}"#,
    );
    assert!(
        status == 409 && body.contains("no such system track"),
        "{status} {body}"
    );
    // A browser: logs in, and then has the cookie.
    let own = "http://localhost";
    let login = ask(&address, "POST /api/operator", &[bearer, ("Origin", own)], "");
    assert_eq!(login.0, 204);
    let cookie = format!("koseki_operator={TOKEN}");
    let page = [("Cookie", cookie.as_str()), ("Origin", own)];
    assert_eq!(
        order(&page, r#"{"kind": "cancel", "number": 1, "operator": "ben"}"#).0,
        200
    );
    assert_eq!(order(&page[..1], out).0, 403, "a cookie without the page's own origin");
    // A flood is refused, and ends nothing: all come at once, however long an answer takes.
    let flood = || order(&[bearer], r#"{"kind": "in", "source": "ads-b", "operator": "x"}"#).0;
    let statuses = std::thread::scope(|scope| {
        let all: Vec<_> = (0..40).map(|_| scope.spawn(flood)).collect();
        all.into_iter().map(|one| one.join().unwrap()).collect::<Vec<u16>>()
    });
    let refused = statuses.iter().filter(|status| **status == 429).count();
    assert!(refused > 5, "{statuses:?}");
    let (_, list) = ask(&address, "GET /api/orders.json", &[], "");
    assert!(
        list.contains("cancelled") && list.contains("anna") && list.contains("ben"),
        "{list}"
    );
    let (status, said) = demo.stop();
    assert!(status.success() && !said.contains(TOKEN), "{said}");
    home.assert_nothing_is_left("demo");
    for entry in fs::read_dir(home.path("out/latest")).unwrap() {
        let path = entry.unwrap().path();
        let bytes = fs::read(&path).unwrap_or_default();
        let has_token = bytes.windows(TOKEN.len()).any(|window| window == TOKEN.as_bytes());
        assert!(!has_token, "{} has the token", path.display());
    }
    let verified = home.run(&["replay", "out/latest", "--verify"]);
    assert!(verified.status.success(), "{verified:?}");
}

/// Campaign that prints the time of reports in fusion, with a flood of 10,000 orders a second and without, by turns:
/// `cargo test --release -p koseki --test integration time_in_fusion -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement"]
fn time_in_fusion_with_a_flood_beside_and_without() {
    const ROUND: Duration = Duration::from_secs(3);
    let home = Home::new();
    let demo = home.demo();
    let bus = Bus::<SharedMemory>::open(&home.root("demo"), "watcher").unwrap();
    let mut tracks = bus.subscriber(&messages::system_tracks(), || mono_ns() as u64).unwrap();
    for round in 0..6 {
        let floods = round % 2 == 1;
        let (mut times_ns, start, mut sent) = (Vec::new(), Instant::now(), 0u64);
        let mut orders = bus.publisher(&messages::orders(), mono_ns() as u64).unwrap();
        while start.elapsed() < ROUND {
            let due = (start.elapsed().as_secs_f64() * 10_000.0) as u64;
            while floods && sent < due {
                sent += 1;
                let order = Order {
                    token: sent,
                    sent_ns: Now::read().utc_ns,
                    track: 4_000_000_000,
                    ..Order::new(OrderKind::Drop)
                };
                let mark = Mark {
                    progress_ns: i64::MIN,
                    sent_ns: mono_ns(),
                    end: false,
                };
                orders.send(mark, 1, |_, _| order).unwrap();
            }
            let take = |tracks: &[SystemTrack]| {
                let stages = tracks.iter().map(|track| track.stages);
                let measured = stages.filter(|stages| stages.taken_ns > 0);
                times_ns.extend(measured.map(|stages| stages.fused_ns - stages.taken_ns));
            };
            let mut take = take;
            tracks.take(usize::MAX, |_, tracks| take(tracks)).unwrap();
            std::thread::sleep(Duration::from_millis(1));
        }
        times_ns.sort_unstable();
        let at = |share: f64| times_ns[(times_ns.len() as f64 * share) as usize] as f64 / 1e3;
        println!(
            "{sent:6} orders: {} reports, p50 {:.1} us, p90 {:.1} us, p99 {:.1} us",
            times_ns.len(),
            at(0.5),
            at(0.9),
            at(0.99)
        );
    }
    drop((tracks, bus));
    demo.stop();
}

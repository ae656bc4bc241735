//! Real processes that are killed, stopped and restarted (PL-11).
//!
//! The other processes are this very test program: it starts itself with a role in its environment, and runs nothing
//! but the test [`role`], which plays it.

use std::fs::{self, File};
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{
    Home, Line, PATIENCE, memory_of, send, shared_memory, take_all, topic, track, until, without_hanging,
};
use bus::{Bus, BusError, Mark, PublisherState, Root, SharedMemory, Subscriber, Unborn, WaitMode};
use messages::{BatchHeader, SensorTrack};
use rustix::process::{Pid, Signal, kill_process};

const ROLE: &str = "KOSEKI_BUS_TEST_ROLE";
const BASE: &str = "KOSEKI_BUS_TEST_BASE";

const DEPTH: usize = 16;
const SLICE_LEN: usize = 4;
const KILLS_WHILE_JOINING: u64 = 30;
/// Samples of a burst: more than a queue holds.
const BURST: usize = 2 * DEPTH * SLICE_LEN;

/// Plays the role that this process was started for; as a test of its own, it does nothing.
#[test]
fn role() {
    let Ok(role) = std::env::var(ROLE) else {
        return;
    };
    let base = std::env::var(BASE).unwrap();
    let root = Root::in_base(base, "test").unwrap();
    match role.as_str() {
        "launcher" => launch(&root),
        "publisher" => publish(&root),
        "burst" => publish_burst(&root),
        "subscriber" => subscribe(&root),
        "joiner" => join_and_leave(&root),
        other => panic!("no role {other}"),
    }
}

/// Holds the instance and a topic with some content, until killed.
fn launch(root: &Root) {
    let _claim = root.claim().unwrap();
    let bus = Bus::<SharedMemory>::open(root, "launcher").unwrap();
    let topic = topic("a", DEPTH, SLICE_LEN);
    let _held = bus.hold(&topic).unwrap();
    let mut waiter = bus.waiter(WaitMode::Event);
    waiter.watch(&bus, &topic).unwrap();
    let _subscriber = bus.subscriber(&topic, || 0).unwrap();
    let mut publisher = bus.publisher(&topic, 1).unwrap();
    for _ in 0..100 {
        send(&mut publisher, SLICE_LEN);
    }
    say("ready");
    wait_for_the_end();
}

/// Sends slice after slice, until killed.
fn publish(root: &Root) {
    let bus = Bus::<SharedMemory>::open(root, "publisher").unwrap();
    let incarnation = std::process::id().into();
    let mut publisher = bus.publisher(&topic("a", DEPTH, SLICE_LEN), incarnation).unwrap();
    say("ready");
    loop {
        send(&mut publisher, 1);
        thread::sleep(Duration::from_micros(200));
    }
}

/// Sends more than a queue holds, and waits to be killed.
fn publish_burst(root: &Root) {
    let bus = Bus::<SharedMemory>::open(root, "publisher").unwrap();
    let incarnation = std::process::id().into();
    let mut publisher = bus.publisher(&topic("a", DEPTH, SLICE_LEN), incarnation).unwrap();
    send(&mut publisher, BURST);
    say("ready");
    wait_for_the_end();
}

/// Joins and leaves again and again, until killed at whatever it is doing.
fn join_and_leave(root: &Root) {
    say("ready");
    loop {
        let bus = Bus::<SharedMemory>::open(root, "joiner").unwrap();
        let topic = topic("a", DEPTH, SLICE_LEN);
        let mut subscriber = bus.subscriber(&topic, || 0).unwrap();
        let mut publisher = bus.publisher(&topic, 1).unwrap();
        send(&mut publisher, 1);
        subscriber.take(1, |_, _| ()).unwrap();
    }
}

/// Takes everything up to the end of the source, then says what it counted.
fn subscribe(root: &Root) {
    let bus = Bus::<SharedMemory>::open(root, "subscriber").unwrap();
    let topic = topic("a", DEPTH, SLICE_LEN);
    let mut subscriber = bus.subscriber(&topic, || 0).unwrap();
    let mut waiter = bus.waiter(WaitMode::Event);
    waiter.watch(&bus, &topic).unwrap();
    say("ready");
    let mut ended = false;
    while !ended {
        waiter.wait(PATIENCE, || subscriber.has_slices()).unwrap();
        let visit = |header: &BatchHeader, _: &[SensorTrack]| {
            ended |= header.flags & BatchHeader::END != 0;
        };
        subscriber.take(64, visit).unwrap();
    }
    let counts = subscriber.counts();
    say(&format!("{} {}", counts.taken, counts.lost));
    wait_for_the_end();
}

/// Lines that begin so are meant for the parent; the others are the test harness's.
const SAYS: &str = "role says: ";

fn say(words: &str) {
    println!("\n{SAYS}{words}");
}

/// The parent closes this process's input when it wants it to end.
fn wait_for_the_end() {
    let _ = std::io::stdin().read_to_end(&mut Vec::new());
}

/// Another process. It is killed when dropped.
struct Other {
    child: Child,
    output: Option<BufReader<ChildStdout>>,
    input: Option<ChildStdin>,
}

impl Other {
    /// Starts a process for `role`, and waits until it is ready.
    fn start(root: &Root, role: &str) -> Self {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "processes::role", "--nocapture", "--test-threads=1"])
            .env(ROLE, role)
            .env(BASE, root.base())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut other = Self {
            output: child.stdout.take().map(BufReader::new),
            input: child.stdin.take(),
            child,
        };
        assert_eq!(other.hear(), "ready");
        other
    }

    /// The next words of the other process.
    fn hear(&mut self) -> String {
        let mut output = self.output.take().unwrap();
        let (words, output) = without_hanging("another process's words", move || {
            let mut line = String::new();
            loop {
                line.clear();
                let read = output.read_line(&mut line).unwrap();
                assert_ne!(read, 0, "the other process ended without a word");
                if let Some(words) = line.strip_prefix(SAYS) {
                    return (words.trim().to_owned(), output);
                }
            }
        });
        self.output = Some(output);
        words
    }

    /// Stops it where it stands.
    fn stop(&self) {
        kill_process(Pid::from_child(&self.child), Signal::STOP).unwrap();
        let status = format!("/proc/{}/status", self.pid());
        until("a stopped process", || {
            let status = std::fs::read_to_string(&status).unwrap();
            status.contains("State:\tT")
        });
    }

    fn go_on(&self) {
        kill_process(Pid::from_child(&self.child), Signal::CONT).unwrap();
    }

    /// Kills it on the spot, as the system does when memory runs out.
    fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Lets it end by itself.
    fn end(mut self) {
        drop(self.input.take());
        assert!(self.child.wait().unwrap().success());
    }

    fn pid(&self) -> u32 {
        self.child.id()
    }
}

impl Drop for Other {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn line(home: &Home) -> Line<SharedMemory> {
    Line::new(home, "a", DEPTH, SLICE_LEN)
}

/// All files of the instance, in its folder and in shared memory.
fn files(home: &Home) -> Vec<String> {
    fn list(folder: &Path, found: &mut Vec<String>) {
        for entry in fs::read_dir(folder).unwrap().flatten() {
            found.push(entry.path().display().to_string());
            if entry.path().is_dir() {
                list(&entry.path(), found);
            }
        }
    }
    let mut found = shared_memory(home.root());
    list(home.root().path(), &mut found);
    found.sort();
    found
}

#[test]
fn a_killed_publisher_is_survived_removed_and_replaced() {
    let home = Home::new();
    let line = line(&home);
    let mut subscriber = line.subscriber(0);
    let mut first = Other::start(home.root(), "publisher");
    take_some_of(&mut subscriber, first.pid());
    first.kill();
    // What it had sent is still there, and then nothing more comes; not even an error.
    until("an empty queue", || subscriber.take(64, |_, _| ()).unwrap() == 0);

    // It seems to live as long as a process that another test starts holds copies of its descriptors.
    until("it is removed", || line.bus.remove_dead().removed == 1);
    assert_eq!(line.bus.remove_dead().removed, 0);

    let second = Other::start(home.root(), "publisher");
    take_some_of(&mut subscriber, second.pid());
    let counts = subscriber.counts();
    let heard: u64 = subscriber.heard().map(|each| each.next_sequence).sum();
    assert_eq!(counts.taken + counts.lost, heard);
    assert_eq!(counts.out_of_order, 0);
    drop(second);
    line.bus.remove_dead();
}

#[test]
fn all_that_died_with_a_publisher_nobody_had_heard_is_counted() {
    let home = Home::new();
    let line = line(&home);
    let mut subscriber = line.subscriber(0);
    let mut publisher = Other::start(home.root(), "burst");
    publisher.kill();
    while line.bus.remove_dead().failed > 0 {}
    take_all(&mut subscriber);
    let counts = subscriber.counts();
    assert_eq!(counts.taken + counts.lost, BURST as u64);
    assert_eq!(counts.lost_at_end, counts.lost, "nothing came");
    take_all(&mut subscriber);
    assert_eq!(subscriber.counts(), counts, "counted once");
}

#[test]
fn what_a_killed_publisher_left_in_the_queue_is_not_lost() {
    let home = Home::new();
    let line = line(&home);
    let mut subscriber = line.subscriber(0);
    let mut publisher = Other::start(home.root(), "burst");
    assert!(subscriber.has_slices());
    publisher.kill();
    while line.bus.remove_dead().failed > 0 {}
    take_all(&mut subscriber);
    let counts = subscriber.counts();
    assert_eq!(counts.taken, (DEPTH * SLICE_LEN) as u64);
    assert_eq!((counts.taken + counts.lost, counts.lost_at_end), (BURST as u64, 0));
}

#[test]
fn a_kill_at_any_moment_leaves_a_sum_that_the_publishers_line_confirms() {
    let home = Home::new();
    let line = line(&home);
    let mut subscriber = line.subscriber(0);
    let mut numbered = 0;
    for _ in 0..4 {
        let mut publisher = Other::start(home.root(), "publisher");
        take_some_of(&mut subscriber, publisher.pid());
        publisher.kill();
        while line.bus.remove_dead().failed > 0 {}
        take_all(&mut subscriber);
        let lines = line.bus.publisher_lines(&line.topic).unwrap();
        let dead = lines.iter().find(|line| line.incarnation == publisher.pid().into());
        let dead = dead.unwrap();
        assert_eq!(dead.life, PublisherState::Died);
        numbered += dead.next_sequence;
        let counts = subscriber.counts();
        assert_eq!(counts.taken + counts.lost, numbered);
    }
}

#[test]
fn nothing_stays_of_processes_killed_while_they_join_or_leave() {
    let home = Home::new();
    let line = line(&home);
    line.bus.remove_dead();
    let before = files(&home);
    // As the launcher does: nobody waits for ever for memory that a killed process had only begun.
    let (running, ended) = mpsc::channel::<()>();
    let mut unborn = Unborn::new(home.root());
    let launcher = thread::spawn(move || {
        while ended.recv_timeout(Unborn::PERIOD) == Err(mpsc::RecvTimeoutError::Timeout) {
            unborn.remove().unwrap();
        }
    });
    for round in 0..KILLS_WHILE_JOINING {
        let mut joiner = Other::start(home.root(), "joiner");
        thread::sleep(Duration::from_micros(700 * round));
        joiner.kill();
        // What was only begun goes when the launcher has seen that nobody goes on with it.
        let begun = Instant::now();
        loop {
            while line.bus.remove_dead().failed > 0 {}
            let now = files(&home);
            if now == before {
                break;
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "after kill {round}: {now:?}");
            thread::sleep(Unborn::PERIOD);
        }
    }
    drop(running);
    launcher.join().unwrap();
}

#[test]
fn places_of_killed_publishers_are_found_by_the_next_one() {
    let home = Home::new();
    let line = line(&home);
    for _ in 0..line.topic.capacity.publishers {
        Other::start(home.root(), "publisher").kill();
    }
    // Nobody has removed the dead, and they have all places. A dead process seems to live as long as a process that
    // another test starts holds copies of its descriptors.
    until("a place is free", || line.try_publisher(1).is_ok());
}

#[test]
fn a_killed_subscriber_does_not_hold_the_publisher_up() {
    let home = Home::new();
    let root = home.root().clone();
    without_hanging("a publisher whose subscriber was killed", move || {
        let topic = topic("a", DEPTH, SLICE_LEN);
        let bus = Bus::<SharedMemory>::open(&root, "test").unwrap();
        let _held = bus.hold(&topic).unwrap();
        let mut publisher = bus.publisher(&topic, 1).unwrap();
        let mut living = bus.subscriber(&topic, || 0).unwrap();
        let mut taken = 0;
        let mut send_and_take = |count: usize| {
            for _ in 0..count {
                send(&mut publisher, 1);
                living.take(64, |_, samples| taken += samples.len()).unwrap();
            }
        };
        let mut other = Other::start(&root, "subscriber");
        send_and_take(50);
        other.stop(); // so that it is killed with a full queue
        send_and_take(5 * DEPTH);
        other.kill();
        send_and_take(5 * DEPTH);
        // It seems to live as long as a process that another test starts holds copies of its descriptors.
        until("it is removed", || bus.remove_dead().removed == 1);
        send_and_take(5 * DEPTH);
        assert_eq!(taken, 50 + 15 * DEPTH);
        assert_eq!(living.counts().lost, 0);
        assert_eq!(publisher.counts().not_sent, 0);
    });
}

#[test]
fn a_subscriber_killed_before_its_memory_had_a_size_keeps_nobody_from_removing_it() {
    let home = Home::new();
    let root = home.root().clone();
    without_hanging("the removal of a subscriber whose memory is empty", move || {
        let topic = topic("a", DEPTH, SLICE_LEN);
        let bus = Bus::<SharedMemory>::open(&root, "test").unwrap();
        let _held = bus.hold(&topic).unwrap();
        // It sends nothing, so that the subscriber alone has the connection.
        let mut publisher = bus.publisher(&topic, 1).unwrap();
        Other::start(&root, "subscriber").kill();
        let mut connections = shared_memory(&root);
        connections.retain(|name| name.ends_with(".connection"));
        assert_eq!(connections.len(), 1);
        let path = Path::new("/dev/shm").join(&connections[0]);
        File::options().write(true).open(&path).unwrap().set_len(0).unwrap();

        let launcher = thread::spawn(move || {
            let mut unborn = Unborn::new(&root);
            assert_eq!(unborn.remove().unwrap(), 0, "it may still get a size");
            assert_eq!(unborn.remove().unwrap(), 1);
        });
        until("it is removed", || bus.remove_dead().removed == 1);
        send(&mut publisher, 1);
        launcher.join().unwrap();
    });
}

#[test]
fn a_stopped_subscriber_holds_nobody_up_and_counts_what_it_missed() {
    let home = Home::new();
    let root = home.root().clone();
    without_hanging("a publisher whose subscriber is stopped", move || {
        let topic = topic("a", DEPTH, SLICE_LEN);
        let bus = Bus::<SharedMemory>::open(&root, "test").unwrap();
        let _held = bus.hold(&topic).unwrap();
        let mut publisher = bus.publisher(&topic, 1).unwrap();
        let mut other = Other::start(&root, "subscriber");
        other.stop();
        for _ in 0..20 * DEPTH {
            send(&mut publisher, SLICE_LEN);
        }
        let end = Mark {
            progress_ns: 0,
            sent_ns: 0,
            end: true,
        };
        publisher.send(end, 1, |_, s| track(s)).unwrap();
        other.go_on();
        // Its queue held the last slices: full ones, and the one with the end.
        let taken = (DEPTH - 1) * SLICE_LEN + 1;
        let lost = publisher.next_sequence() - taken as u64;
        assert_eq!(other.hear(), format!("{taken} {lost}"));
        assert_eq!(publisher.counts().not_sent, 0);
        other.end();
    });
}

#[test]
fn one_instance_has_one_launcher() {
    let home = Home::unclaimed();
    assert!(matches!(
        Bus::<SharedMemory>::open(home.root(), "test"),
        Err(BusError::NotRunning { .. })
    ));
    let launcher = Other::start(home.root(), "launcher");
    let error = home.root().claim().unwrap_err();
    assert!(
        matches!(error, BusError::AlreadyRunning { pid: Some(pid), .. } if pid == launcher.pid()),
        "{error}"
    );
    let found = Root::list(home.root().base()).unwrap();
    assert_eq!(found.len(), 1);
    assert_eq!(&found[0].root, home.root());
    assert_eq!((found[0].runs, found[0].pid), (true, Some(launcher.pid())));
    let processes = home.root().processes().unwrap();
    assert_eq!(processes.len(), 1);
    assert_eq!(
        (processes[0].pid, processes[0].name.as_str()),
        (launcher.pid(), "launcher")
    );
    let mut launcher = launcher;
    launcher.kill();
    // It did not remove the instance: everything is still listed, and can be claimed.
    assert!(!Root::list(home.root().base()).unwrap()[0].runs);
    let claim = home.root().claim().unwrap();
    claim.remove().unwrap();
}

#[test]
fn what_a_guest_makes_in_memory_that_was_replaced_is_removed_at_the_end() {
    let home = Home::unclaimed();
    let mut claim = home.root().claim().unwrap();
    let prefix = home.root().prefix().unwrap().unwrap();
    claim.empty().unwrap();
    assert_ne!(home.root().prefix().unwrap().unwrap(), prefix);
    // The guest has joined before, and meets its publishers now.
    std::fs::write(format!("/dev/shm/{prefix}late.connection"), "").unwrap();
    claim.remove().unwrap();
    assert!(memory_of(&prefix).is_empty());
}

#[test]
fn what_a_killed_launcher_left_is_removed() {
    let mut home = Home::unclaimed();
    for _ in 0..3 {
        let mut launcher = Other::start(home.root(), "launcher");
        launcher.kill();
        let prefix = home.root().prefix().unwrap().unwrap();
        assert!(!memory_of(&prefix).is_empty());
        let claim = home.root().claim().unwrap();
        assert!(claim.wiped().files > 5, "{:?}", claim.wiped());
        assert!(claim.wiped().bytes > 0);
        assert!(memory_of(&prefix).is_empty());
        assert_ne!(
            home.root().prefix().unwrap(),
            Some(prefix),
            "nobody can know the next one"
        );
        claim.remove().unwrap();
        assert!(!home.root().path().exists());
    }
    // And the next run is as good as the first.
    home.claim();
    let line = line(&home);
    let (mut publisher, mut subscriber) = (line.publisher(2), line.subscriber(1));
    send(&mut publisher, 3);
    assert_eq!(crate::common::take_all(&mut subscriber), [0, 1, 2]);
}

#[test]
fn an_instance_is_not_taken_from_under_processes_that_outlived_their_launcher() {
    let home = Home::unclaimed();
    let mut launcher = Other::start(home.root(), "launcher");
    let orphan = Other::start(home.root(), "subscriber");
    launcher.kill();
    let error = home.root().claim().unwrap_err();
    let BusError::StillUsed { processes, .. } = &error else {
        panic!("{error}");
    };
    assert_eq!(processes.len(), 1);
    assert_eq!(processes[0].pid, orphan.pid());
    assert!(error.to_string().contains("subscriber"), "{error}");
    // The failed claim has given the lock back, and touched nothing.
    // A process that another test starts holds a copy of the lock's descriptor until it is another program.
    until("the lock is given back", || home.root().holder().unwrap().is_none());
    assert!(!shared_memory(home.root()).is_empty());
    drop(orphan);
    let claim = home.root().claim().unwrap();
    claim.remove().unwrap();
}

#[test]
fn the_last_to_leave_an_instance_without_launcher_removes_it() {
    let home = Home::unclaimed();
    let mut launcher = Other::start(home.root(), "launcher");
    let prefix = home.root().prefix().unwrap().unwrap();
    let first = Bus::<SharedMemory>::open(home.root(), "first").unwrap();
    let second = Bus::<SharedMemory>::open(home.root(), "second").unwrap();
    launcher.kill();
    assert!(matches!(
        Bus::<SharedMemory>::open(home.root(), "late"),
        Err(BusError::NotRunning { .. })
    ));
    drop(first);
    assert!(!memory_of(&prefix).is_empty(), "the second is still there");
    drop(second);
    assert_eq!(memory_of(&prefix), [""; 0]);
    assert!(!home.root().path().exists());
}

/// Whatever the moment in which an instance ends, those who are just joining it leave nothing behind (and those who are
/// in it, nothing that the next does not find).
#[test]
fn joining_while_an_instance_ends_brings_nothing_back() {
    let home = Home::unclaimed();
    for _ in 0..20 {
        let claim = home.root().claim().unwrap();
        let prefix = home.root().prefix().unwrap().unwrap();
        let joiners: Vec<_> = (0..4)
            .map(|_| {
                let root = home.root().clone();
                thread::spawn(move || {
                    let mut joined = 0;
                    while let Ok(bus) = Bus::<SharedMemory>::open(&root, "joiner") {
                        drop(bus);
                        joined += 1;
                    }
                    joined
                })
            })
            .collect();
        drop(claim);
        for joiner in joiners {
            joiner.join().unwrap();
        }
        assert_eq!(memory_of(&prefix), [""; 0]);
        assert!(!home.root().path().exists());
        assert_eq!(home.root().holder().unwrap(), None);
    }
}

#[test]
fn an_instance_in_use_is_not_removed() {
    let home = Home::unclaimed();
    let claim = home.root().claim().unwrap();
    let bus = Bus::<SharedMemory>::open(home.root(), "test").unwrap();
    assert!(matches!(claim.remove(), Err(BusError::StillUsed { .. })));
    drop(bus);
    home.root().claim().unwrap().remove().unwrap();
}

#[test]
fn a_base_folder_open_to_others_is_refused() {
    use std::fs::{Permissions, set_permissions};
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    set_permissions(folder.path(), Permissions::from_mode(0o777)).unwrap();
    let error = Root::in_base(folder.path(), "test").unwrap().claim();
    assert!(matches!(error, Err(BusError::BaseNotPrivate { .. })));
    assert!(matches!(Root::list(Path::new("/nowhere")), Ok(list) if list.is_empty()));
}

/// Takes until some samples of the process `pid` have come.
fn take_some_of(subscriber: &mut Subscriber<SharedMemory, SensorTrack>, pid: u32) {
    let mut some = 0;
    until("samples of the other process", || {
        let visit = |header: &BatchHeader, samples: &[SensorTrack]| {
            if header.incarnation == u64::from(pid) {
                some += samples.len();
            }
        };
        subscriber.take(64, visit).unwrap();
        some >= 100
    });
}

//! A deployment whose parts fail: what the launcher makes of children that hang, ports that are taken, and shared
//! memory that somebody has written rubbish into.

use std::fs::{self, OpenOptions};
use std::io::Read as _;
use std::net::UdpSocket;
use std::os::unix::fs::FileExt as _;
use std::os::unix::net::UnixDatagram;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use bus::{Bus, SharedMemory};
use rand::RngExt as _;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use runtime::clock::mono_ns;
use rustix::process::Signal;

use crate::common::home::PATIENCE;
use crate::common::{Home, Running, free_address, kill, until};

/// Watched closely, so that a test need not wait for long; a machine that is busy gives each process its turn in less.
const WATCHED: [&str; 2] = ["--set", "launcher.watchdog_s=3"];
/// Longer than the launcher waits for a sign of life.
const TOO_LONG: Duration = Duration::from_millis(3500);

/// System tracks reach whoever joins now.
fn until_tracks_come(home: &Home) {
    until("system tracks come", || {
        let Ok(bus) = Bus::<SharedMemory>::open(&home.root("demo"), "reader") else {
            return false;
        };
        let Ok(mut tracks) = bus.subscriber(&messages::system_tracks(), || mono_ns() as u64) else {
            return false;
        };
        let start = Instant::now();
        let mut updates = 0;
        while updates < 20 && start.elapsed() < Duration::from_secs(3) {
            if tracks.take(64, |_, slice| updates += slice.len()).is_err() {
                return false;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        updates >= 20
    });
}

#[test]
fn too_few_open_files_are_refused_at_once_with_a_remedy_and_a_low_default_is_raised() {
    let home = Home::new();
    let demo = |limit: &str| {
        let demo = home.command(&["demo", "--for", "1", "--set", "display.listen=off"]);
        let mut limited = Command::new("sh");
        limited.arg("-c").arg(format!("ulimit {limit}; exec \"$0\" \"$@\""));
        limited.arg(demo.get_program()).args(demo.get_args());
        let changed = demo.get_envs().filter_map(|(name, value)| Some((name, value?)));
        limited.envs(changed).current_dir(demo.get_current_dir().unwrap());
        limited
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        home.start_command(&mut limited).end()
    };
    for limit in ["24", "64", "100", "255"] {
        let (status, said) = demo(&format!("-n {limit}"));
        assert_eq!(status.code(), Some(1), "{said}");
        let words = format!("a process may have only {limit} files open, and needs up to 256: raise `ulimit -n`");
        assert!(
            said.contains(&words) && !said.contains("InternalFailure"),
            "{limit}: {said}"
        );
    }
    // The limit that can be raised.
    let (status, said) = demo("-S -n 64");
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("demo");
}

fn stop(home: &Home, demo: Running) {
    let (status, said) = demo.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("demo");
}

// ---------------------------------------------------------------------------------------------------------------------
// Shared memory.
// ---------------------------------------------------------------------------------------------------------------------

#[test]
fn the_launcher_maps_no_shared_memory() {
    let home = Home::new();
    let demo = home.demo();
    let maps = |pid: u32| fs::read_to_string(format!("/proc/{pid}/maps")).unwrap();
    assert!(!maps(demo.pid()).contains("/dev/shm/"), "{}", maps(demo.pid()));
    assert!(maps(home.status_row("keeper").pid).contains("/dev/shm/"));
    stop(&home, demo);
}

#[test]
fn the_death_of_the_keeper_is_like_any_other() {
    let home = Home::new();
    let demo = home.demo();
    let bus = Bus::<SharedMemory>::open(&home.root("demo"), "reader").unwrap();
    let mut tracks = bus.subscriber(&messages::system_tracks(), || mono_ns() as u64).unwrap();
    for restart in 1..=2 {
        kill(home.status_row("keeper").pid, Signal::KILL);
        demo.until_said(&format!("keeper restarted ({restart}), back after "));
        // It has taken its predecessor's place: others can die and come back as before.
        kill(home.status_row("radar-west").pid, Signal::KILL);
        demo.until_said(&format!("adapter radar-west restarted ({restart}), back after "));
    }
    let mut updates = 0;
    until("who has joined before goes on reading", || {
        tracks.take(64, |_, slice| updates += slice.len()).unwrap();
        updates > 50
    });
    assert_eq!(tracks.counts().lost, 0);
    drop((tracks, bus));
    until_tracks_come(&home);
    assert_eq!(home.status_row("fusion").restarts, "0");
    assert!(!demo.said().contains("rebuilding"), "{}", demo.said());
    stop(&home, demo);
}

#[test]
fn faults_of_the_keeper_or_of_several_children_have_the_deployment_rebuilt_and_that_of_one_has_not() {
    let home = Home::new();
    let demo = home.demo();
    let fault = |name: &str| kill(home.status_row(name).pid, Signal::ABORT);
    fault("radar-west");
    demo.until_said("adapter radar-west restarted (1)");
    assert!(!demo.said().contains("rebuilding"), "{}", demo.said());
    let runs = |times: usize| {
        until("it runs again", || {
            demo.said().matches("instance demo runs").count() == times
        });
        until_tracks_come(&home);
    };
    fault("keeper");
    demo.until_said("the shared memory seems to be corrupt: keeper was killed by SIGABRT; rebuilding the deployment");
    runs(2);
    assert_eq!(home.status_row("fusion").restarts, "1");
    for pid in ["radar-east", "ads-b"].map(|name| home.status_row(name).pid) {
        kill(pid, Signal::ABORT);
    }
    runs(3);
    stop(&home, demo);
}

/// Random bytes at random places of the instance's files, as any process of the same user can write them.
fn corrupt(home: &Home, ending: &str, count: usize, seed: u64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut names = home.shared_memory();
    names.retain(|name| name.ends_with(ending));
    names.sort();
    assert!(!names.is_empty(), "{ending}");
    for _ in 0..count {
        let path = format!("/dev/shm/{}", names[random.random_range(0..names.len())]);
        // Files come and go.
        let Ok(file) = OpenOptions::new().write(true).open(path) else {
            continue;
        };
        let length = file.metadata().unwrap().len();
        let place = random.random_range(0..length.max(1));
        file.write_at(&[random.random()], place).unwrap();
    }
}

#[test]
fn corrupt_shared_memory_ends_no_launcher() {
    let cases = [(".data", 32_000), (".connection", 400), (".dynamic", 2_000), ("", 20)];
    for (seed, (ending, count)) in cases.into_iter().enumerate() {
        let home = Home::new();
        let mut demo = home.demo();
        corrupt(&home, ending, count, seed as u64);
        // Who joins anew meets what others may have read already. A reader of ours could be killed by it: ask another
        // process.
        let pid_of_fusion = || {
            let status = home.run(&["status"]);
            let status = String::from_utf8_lossy(&status.stdout).into_owned();
            let fusion = status.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
            let mut fusion = fusion.filter(|words| words.first() == Some(&"fusion") && words.len() >= 6);
            let row = fusion.next()?;
            let published: f64 = row[5].parse().ok()?;
            (row[2] == "running" && published > 20.0).then(|| row[1].parse::<u32>().unwrap())
        };
        let mut fusion = None;
        let start = Instant::now();
        while fusion.is_none() {
            assert!(
                start.elapsed() < PATIENCE,
                "{count} octets in *{ending}: {}\n{}",
                demo.said(),
                home.status()
            );
            fusion = pid_of_fusion();
        }
        // It may have been replaced a moment ago.
        let _ = rustix::process::kill_process(
            rustix::process::Pid::from_raw(fusion.unwrap() as i32).unwrap(),
            Signal::KILL,
        );
        until("another fusion publishes", || {
            pid_of_fusion().is_some_and(|pid| Some(pid) != fusion)
        });
        assert_eq!(demo.child.try_wait().unwrap(), None, "{}", demo.said());
        // What nobody has run into yet may trouble those who leave.
        let rebuilt = demo.said().contains("rebuilding the deployment");
        let (status, said) = demo.stop();
        println!("{count} octets in *{ending}: rebuilt: {rebuilt}, {status}");
        assert!(status.code().is_some(), "{said}");
        home.assert_nothing_is_left("demo");
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Children that stand still.
// ---------------------------------------------------------------------------------------------------------------------

#[test]
fn children_that_stand_still_are_replaced() {
    let home = Home::new();
    let demo = home.demo_with(&WATCHED);
    for (name, title) in [
        ("fusion", "fusion"),
        ("radar-west", "adapter radar-west"),
        ("keeper", "keeper"),
        ("monitor", "monitor"),
    ] {
        kill(home.status_row(name).pid, Signal::STOP);
        demo.until_said(&format!("{title} stood still for "));
        demo.until_said(&format!("{title} restarted (1), back after "));
        assert_eq!(home.status_row(name).restarts, "1", "{name}");
    }
    assert_eq!(home.status_row("radar-east").restarts, "0");
    stop(&home, demo);
}

#[test]
fn a_housekeeping_thread_that_stands_still_takes_its_process_with_it() {
    if Command::new("strace").arg("--version").output().is_err() {
        println!("skipped: there is no strace to hold up a thread with");
        return;
    }
    let home = Home::new();
    let demo = home.demo_with(&WATCHED);
    let tasks = format!("/proc/{}/task", home.status_row("fusion").pid);
    let is_housekeeper = |task: &fs::DirEntry| {
        let name = fs::read_to_string(task.path().join("comm")).unwrap_or_default();
        name.trim() == "housekeeping"
    };
    let thread = fs::read_dir(tasks).unwrap().flatten().find(is_housekeeper).unwrap();
    let mut strace = Command::new("strace")
        .args(["-e", "inject=clock_nanosleep,futex:delay_enter=5000000", "-p"])
        .arg(thread.file_name())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = [0; 64];
    let length = strace.stderr.as_mut().unwrap().read(&mut first).unwrap();
    let first = String::from_utf8_lossy(&first[..length]).into_owned();
    if first.contains("not permitted") {
        println!("skipped: this machine does not allow to hold up a thread: {first}");
    } else {
        demo.until_said("fusion stood still for ");
        demo.until_said("fusion restarted (1), back after ");
    }
    strace.wait().unwrap();
    stop(&home, demo);
}

#[test]
fn who_stood_still_with_the_whole_machine_is_let_live() {
    let home = Home::new();
    let demo = home.demo_with(&WATCHED);
    let names = [
        "keeper",
        "monitor",
        "fusion",
        "radar-west",
        "radar-east",
        "ads-b",
        "simulator",
    ];
    let children = names.map(|name| home.status_row(name).pid);
    for _ in 0..2 {
        demo.signal(Signal::STOP);
        for pid in children {
            kill(pid, Signal::STOP);
        }
        std::thread::sleep(TOO_LONG);
        // The worst order: who watches is the first to wake up.
        demo.signal(Signal::CONT);
        std::thread::sleep(Duration::from_millis(300));
        for pid in children {
            kill(pid, Signal::CONT);
        }
        until_tracks_come(&home);
    }
    assert!(!demo.said().contains("stood still"), "{}", demo.said());
    stop(&home, demo);
}

// ---------------------------------------------------------------------------------------------------------------------
// What a machine does not have.
// ---------------------------------------------------------------------------------------------------------------------

/// Two sensors, each behind a port of its own, and a gateway.
fn two_ports(home: &Home, first: &str, second: &str, extra: &str) {
    let mut text = "name = \"demo\"\n[frame]\nlatitude_deg = 41.3\nlongitude_deg = 2.1\n".to_owned();
    for (name, address) in [("first", first), ("second", second)] {
        text += &format!(
            "[[receiver]]\nname = \"{name}\"\n[receiver.udp]\nlisten = \"{address}\"\n\
             [[source]]\nname = \"radar-{name}\"\n[source.live]\nreceiver = \"{name}\"\n"
        );
    }
    text += "[recorder]\nenabled = false\n[monitor]\nfiles = false\n";
    fs::write(home.path("site.toml"), text + extra).unwrap();
}

#[test]
fn a_port_that_is_taken_harms_its_own_source_only_and_only_as_long() {
    let home = Home::new();
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let gateway =
        "[[gateway]]\nname = \"out\"\nsend_to = \"239.255.1.2:8600\"\ninterface = \"nosuch0\"\nsac = 1\nsic = 1\n";
    two_ports(&home, &address, &free_address().to_string(), gateway);

    let required = home.run(&["up", "site.toml", "--set", "source[0].required=true"]);
    let said = String::from_utf8(required.stderr).unwrap();
    assert_eq!((required.status.code(), said.lines().count()), (Some(1), 1), "{said}");
    for words in [
        "receiver first: ",
        &address,
        "in use",
        "ss -ltunp",
        "source radar-first behind it is required",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }

    let up = home.start(&["up", "site.toml"]);
    up.until_said("instance demo runs");
    let said = up.said();
    let before = said.find("instance demo runs").unwrap();
    for words in [
        "receiver first: ",
        "gateway out: interface nosuch0: this machine has none",
    ] {
        let at = said.find(words).unwrap_or_else(|| panic!("{words}: {said}"));
        assert!(
            at < before
                && said[at..]
                    .lines()
                    .next()
                    .unwrap()
                    .contains("tried again until it works"),
            "{said}"
        );
    }
    assert!(said.contains("going on without adapter first"), "{said}");
    assert_eq!(home.status_row("second").state, "running");
    // More often than any deployment used to survive.
    let failures = || up.said().matches("adapter first ended with exit code 1").count();
    until("it is tried again", || failures() >= 5);
    drop(taken);
    up.until_said("adapter first restarted");
    assert_eq!(home.status_row("second").restarts, "0");
    stop(&home, up);
}

#[test]
fn a_folder_that_cannot_be_written_is_refused_before_anything_starts() {
    let home = Home::new();
    let demo = home.run(&["demo", "--set", "recorder.enabled=true", "--out", "/proc"]);
    let said = String::from_utf8(demo.stderr).unwrap();
    assert_eq!((demo.status.code(), said.lines().count()), (Some(2), 1), "{said}");
    assert!(said.contains("--out /proc: nothing can be written there"), "{said}");
}

// ---------------------------------------------------------------------------------------------------------------------
// The service manager.
// ---------------------------------------------------------------------------------------------------------------------

#[test]
fn a_service_manager_is_told_that_it_runs_how_it_is_and_that_the_launcher_lives() {
    let home = Home::new();
    let path = home.path("notify");
    let manager = UnixDatagram::bind(&path).unwrap();
    manager.set_read_timeout(Some(PATIENCE)).unwrap();
    let hear = |words: &str| {
        let start = Instant::now();
        let mut heard = String::new();
        while !heard.contains(words) {
            assert!(start.elapsed() < PATIENCE, "not told: {words}; {heard}");
            let mut octets = [0; 4096];
            let length = manager.recv(&mut octets).unwrap();
            heard.push_str(&String::from_utf8_lossy(&octets[..length]));
        }
    };
    let mut command = home.command(&["demo"]);
    let demo = home.start_command(command.env("NOTIFY_SOCKET", &path).env("WATCHDOG_USEC", "4000000"));
    hear("STATUS=10 processes run");
    hear("READY=1");
    hear("WATCHDOG=1");
    kill(home.status_row("ads-b").pid, Signal::KILL);
    hear("STATUS=down: adapter ads-b was killed by SIGKILL");
    hear("STATUS=10 processes run");
    hear("WATCHDOG=1");
    stop(&home, demo);
    hear("STOPPING=1");
}

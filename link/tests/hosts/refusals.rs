//! Those who may not join, and messages that are none.

use std::cell::Cell;
use std::path::Path;
use std::time::Duration;

use koseki_client::messages::layout::Sample as _;
use koseki_client::messages::{BatchHeader, Counter, Health, NO_SOURCE, ProcessKind, health};
use koseki_client::{Root, Subscription};
use zenoh::Wait as _;

use crate::certificates::Authority;
use crate::host::{Host, free_port, until};
use crate::mirror::{Mirror, Reader, mirror, tower};

/// Options with which a mirror shows who it is.
const IDENTIFIED: [&str; 1] = ["--certificates"];

/// Waits until the link of `there` has turned away so many connections.
fn until_refused(there: &Host, count: u64) {
    let root = Root::in_base(there.shared(), "tower").unwrap();
    let mut health: Subscription<Health> = Subscription::at(&root, &health()).unwrap();
    let mut refused = 0;
    until(
        || {
            while let Some(slice) = health.next(Duration::ZERO).unwrap() {
                for link in slice
                    .iter()
                    .filter(|said| said.kind() == Some(ProcessKind::Link) && said.source == NO_SOURCE)
                {
                    refused = link.counters[Counter::RequestsRejected];
                }
            }
            refused >= count
        },
        || there.status("tower"),
    );
}

/// A mirror on a host that is refused, and what its status gives as the cause.
type Refused = ((Host, Mirror), &'static str);

/// Waits until the status of the deployment `there` gives all these causes of refusals.
fn until_named(there: &Host, causes: &[&str]) {
    until(
        || causes.iter().all(|cause| there.status("tower").contains(cause)),
        || format!("{causes:?}: {}", there.status("tower")),
    );
}

/// A mirror that the others are compared with, and those that must learn nothing but why.
fn only_the_first_sees(there: &Host, allowed: (&Host, &Mirror), refused: &[Refused], from: &str) {
    for ((host, _), cause) in refused {
        let named = format!("tower is not there: {cause}");
        until(
            || host.status("tower").contains(&named),
            || format!("{from}, {cause}: {}", host.status("tower")),
        );
    }
    let mut original = Reader::of(there, "tower");
    let mut seen = Reader::until_there(allowed.0, "tower");
    until(
        || {
            original.read();
            seen.read();
            seen.tracks.len() >= 25
        },
        || allowed.0.status("tower"),
    );
    for ((host, _), _) in refused {
        let status = host.status("tower");
        assert!(status.contains("tower is not there"), "{status}");
        let mut reader = Reader::of(host, "tower");
        reader.read();
        assert!(reader.tracks.is_empty(), "{status}");
    }
}

#[test]
fn who_has_no_certificate_of_the_authority_or_is_not_named_learns_nothing() {
    let Some(there) = Host::new() else { return };
    let (authority, forger) = (Authority::new(), Authority::new());
    let port = free_port();
    let named = "[[link.peer]]\nname = \"display\"\n";
    let config = |identity: &str| tower(&format!("tls/127.0.0.1:{port}"), &format!("{identity}{named}"));
    let own = authority.certify(&there, "tower", &authority);
    let mut deployment = there.up("tower", &config(&own), &[]);
    deployment.until_up();
    let join = |name: &str, signed: &Authority| {
        let host = Host::new().unwrap();
        let identity = signed.certify(&host, name, &authority);
        let mirror = mirror(&host, &config(&identity), &format!("tls/127.0.0.1:{port}"), &IDENTIFIED);
        (host, mirror)
    };
    let expired = {
        let host = Host::new().unwrap();
        let identity = authority.certify_until(2020, &host, "display", &authority);
        let mirror = mirror(&host, &config(&identity), &format!("tls/127.0.0.1:{port}"), &IDENTIFIED);
        (host, mirror)
    };
    let refused = [
        (join("display", &forger), "certificate of another authority"),
        (join("stranger", &authority), "it does not name this host"),
        (expired, "a certificate has expired"),
    ];
    let (host, display) = join("display", &authority);
    only_the_first_sees(&there, (&host, &display), &refused, "certificates");
    // They try again and again.
    until_refused(&there, 3);
    let causes = [
        "certificate of another authority",
        "not named in [[link.peer]]",
        "certificate has expired",
    ];
    until_named(&there, &causes);
}

#[test]
fn a_mirror_that_cannot_begin_names_the_cause_and_ends() {
    let Some(host) = Host::new() else { return };
    let path = host.path("tower.toml");
    let absent = "authority = \"absent.pem\"\ncertificate = \"absent.pem\"\nprivate_key = \"absent.pem\"\n";
    std::fs::write(&path, tower("tls/127.0.0.1:1", absent)).unwrap();
    let ends = |options: &[&str], code: i32, said: &str| {
        let mut command = host.command(Path::new(env!("CARGO_BIN_EXE_koseki-link")));
        command.args(["mirror", "--config"]).arg(&path).args(options);
        let output = command.output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.code() == Some(code) && error.contains(said),
            "{:?}: {error}",
            output.status
        );
    };
    ends(&["--connect", "tls/127.0.0.1:1", "--certificates"], 1, "absent.pem");
    ends(&["--connect", "tls/127.0.0.1:1"], 2, "needs --certificates");
    ends(&["--connect", "tcp/192.0.2.1:7447"], 2, "--insecure");
    ends(&["--connect", "nonsense"], 2, "is no endpoint");
}

#[test]
fn who_is_no_user_or_has_no_password_learns_nothing() {
    let Some(there) = Host::new() else { return };
    let port = free_port();
    let users = there.path("users");
    std::fs::write(&users, "display:one\nrecorder:two\n").unwrap();
    let listed = format!("users_file = {users:?}\n[[link.peer]]\nname = \"display\"\n");
    let endpoint = format!("tcp/127.0.0.1:{port}");
    let mut deployment = there.up("tower", &tower(&endpoint, &listed), &[]);
    deployment.until_up();
    let join = |user: &str, password: &str| {
        let host = Host::new().unwrap();
        let file = host.path("password");
        std::fs::write(&file, password).unwrap();
        let identity = format!("user = \"{user}\"\npassword_file = {file:?}\n");
        let mirror = mirror(&host, &tower(&endpoint, &identity), &endpoint, &IDENTIFIED);
        (host, mirror)
    };
    let anonymous = Host::new().unwrap();
    let nobody = mirror(&anonymous, &tower(&endpoint, ""), &endpoint, &[]);
    let refused = [
        (join("display", "two"), "wrong user or password"),
        (join("stranger", "one"), "wrong user or password"),
        // A user, but none that the link deals with.
        (join("recorder", "two"), "it does not name this host"),
        ((anonymous, nobody), "wrong user or password"),
    ];
    let (host, display) = join("display", "one");
    only_the_first_sees(&there, (&host, &display), &refused, "users");
    until_refused(&there, 2);
    until_named(&there, &["wrong user or password", "not named in [[link.peer]]"]);
}

/// A message with no slice, and a byte too many.
fn cut_off() -> Vec<u8> {
    let mut message = b"KOSEKI/1".to_vec();
    message.resize(72 + 1, 0);
    message
}

/// A message with an empty slice of the layout that `schema` stands for.
pub(crate) fn of_layout(schema: u64) -> Vec<u8> {
    let mut message = cut_off();
    message.pop();
    let header = BatchHeader {
        schema,
        ..BatchHeader::default()
    };
    message.extend_from_slice(BatchHeader::octets(&[header]));
    message.extend_from_slice(&[0; 8]);
    message
}

/// A session at a link's endpoint, of a program other than Koseki.
pub(crate) fn intruder(door: &str, said: impl Fn() -> String) -> zenoh::Session {
    session(door, None, said)
}

/// The same, with the name and password of a user.
fn session(door: &str, user: Option<(&str, &str)>, said: impl Fn() -> String) -> zenoh::Session {
    let mut config = zenoh::Config::default();
    let mut set = |key: &str, value: &str| config.insert_json5(key, value).unwrap();
    set("mode", "\"client\"");
    set("scouting/multicast/enabled", "false");
    set("connect/endpoints", &format!("[\"{door}\"]"));
    if let Some((user, password)) = user {
        set("transport/auth/usrpwd/user", &format!("\"{user}\""));
        set("transport/auth/usrpwd/password", &format!("\"{password}\""));
    }
    let mut session = None;
    until(
        || {
            session = zenoh::open(config.clone()).wait().ok();
            session.is_some()
        },
        said,
    );
    session.unwrap()
}

#[test]
fn messages_that_are_none_are_counted_and_do_no_harm() {
    let (Some(there), Some(here)) = (Host::new(), Host::new()) else {
        return;
    };
    let (port, door) = (free_port(), free_port());
    let endpoint = format!("tcp/127.0.0.1:{port}");
    let mut deployment = there.up("tower", &tower(&endpoint, ""), &[]);
    deployment.until_up();
    let door = format!("tcp/127.0.0.1:{door}");
    let _mirror = mirror(&here, &tower(&endpoint, ""), &endpoint, &["--listen", &door]);
    let mut seen = Reader::until_there(&here, "tower");
    let intruder = intruder(&door, || here.status("tower"));
    let root = Root::in_base(here.shared(), "tower").unwrap();
    let mut health: Subscription<Health> = Subscription::at(&root, &health()).unwrap();
    let (mut rejected, mut of_others) = (0, 0);
    let malformed = [Vec::new(), vec![0xFF; 5000], cut_off()];
    until(
        || {
            for message in malformed.iter().chain([&of_layout(7)]) {
                let key = "koseki/0123456789abcdef/tower/system/tracks";
                intruder.put(key, message.clone()).wait().unwrap();
            }
            while let Some(slice) = health.next(Duration::ZERO).unwrap() {
                for entry in slice
                    .iter()
                    .filter(|entry| entry.name() == "mirror" && entry.source == NO_SOURCE)
                {
                    rejected = entry.counters[Counter::MessagesRejected];
                    of_others = entry.counters[Counter::RejectedSchema];
                }
            }
            rejected >= malformed.len() as u64 && of_others > 0
        },
        || here.status("tower"),
    );
    // Larger than any message may be: the network drops it.
    intruder
        .put("koseki/0/tower/system/tracks", vec![0; 20 << 20])
        .wait()
        .unwrap();
    let mut original = Reader::of(&there, "tower");
    seen.agrees_with(&mut original, &here);
}

#[test]
fn a_named_peer_writes_only_the_topics_of_its_own_deployment() {
    let Some(there) = Host::new() else { return };
    let port = free_port();
    let users = there.path("users");
    std::fs::write(&users, "west:one\neast:two\n").unwrap();
    let door = format!("tcp/127.0.0.1:{port}");
    let topic = "sensor/radar/tracks";
    let of = |name: &str| {
        format!(
            "[[link.peer]]\nname = \"{name}\"\ndeployment = \"{name}\"\n\
             [[link.receive]]\ndeployment = \"{name}\"\ntopic = \"{topic}\"\ninto = \"sensor/{name}/tracks\"\n"
        )
    };
    let source = |name: &str| format!("[[source]]\nname = \"{name}\"\nperiod_s = 4.0\n[source.external]\n");
    let config = format!(
        "name = \"centre\"\n[frame]\nlatitude_deg = 41.3\nlongitude_deg = 2.1\n[recorder]\nenabled = false\n{}{}\
         [[link]]\nname = \"in\"\nlisten = [\"{door}\"]\nsend = []\ninsecure = true\nusers_file = {users:?}\n{}{}",
        source("west"),
        source("east"),
        of("west"),
        of("east")
    );
    let mut deployment = there.up("centre", &config, &[]);
    deployment.until_up();
    let east = session(&door, Some(("east", "two")), || there.status("centre"));
    let root = Root::in_base(there.shared(), "centre").unwrap();
    let mut health: Subscription<Health> = Subscription::at(&root, &health()).unwrap();
    let mut refused_layouts = || {
        let mut count = 0;
        while let Some(slice) = health.next(Duration::ZERO).unwrap() {
            let links = slice.iter().filter(|entry| entry.kind() == Some(ProcessKind::Link));
            count = links
                .map(|entry| entry.counters[Counter::RejectedSchema])
                .fold(count, u64::max);
        }
        count
    };
    // A message of another layout is counted wherever it arrives. Messages of one session arrive in their order.
    let put = |deployment: &str| {
        let key = format!("koseki/0123456789abcdef/{deployment}/{topic}");
        east.put(key, of_layout(7)).wait().unwrap();
    };
    for _ in 0..20 {
        put("west");
    }
    let mut sent = 0;
    until(
        || {
            put("east");
            sent += 1;
            refused_layouts() > 0
        },
        || there.status("centre"),
    );
    let counted = Cell::new(0);
    until(
        || {
            counted.set(refused_layouts().max(counted.get()));
            counted.get() >= sent
        },
        || format!("{} of {sent}: {}", counted.get(), there.status("centre")),
    );
    assert_eq!(
        counted.get(),
        sent,
        "messages for another deployment's topic are counted"
    );
}

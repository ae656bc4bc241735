//! Mistakes that people make in the configurations of two centres, each planted in a pair that is sound: `koseki check`
//! has to refuse each with the file or the key, the value, and what to do.
//!
//! [`EDITS`] are mistakes in the text, [`FILES`] those in the files that a link names. Mistakes of feeds have a table
//! of their own where feeds are tested.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::process::Output;

use rcgen::date_time_ymd;

use crate::certificates::Authority;
use crate::host::Host;
use crate::two_centres::succeed;

const WEST: &str = "west/west.toml";
const EAST: &str = "east/east.toml";

/// File, text that is replaced (the end if empty), text in its place, and what the answer has to name.
type Edit = (&'static str, &'static str, &'static str, &'static [&'static str]);

#[rustfmt::skip]
const EDITS: &[Edit] = &[
    (WEST, "shares = \"unknown\"\n", "", &["west.toml", "source[1].shares", "\"east\"", "shares = \"unknown\""]),
    (WEST, "shares = \"unknown\"", "shares = \"unknwon\"", &["west.toml", "shares", "\"unknwon\"", "write \"unknown\""]),
    (WEST, "topic = \"system/own-tracks\"", "topic = \"system/tracks\"", &["west.toml", "receive[0].topic", "\"system/tracks\"", "system/own-tracks"]),
    (WEST, "topic = \"system/own-tracks\"", "topic = \"system/own-track\"", &["west.toml", "receive[0].topic", "\"system/own-track\"", "system/own-tracks"]),
    (WEST, "topic = \"system/own-tracks\"", "topic = \"system/alarms\"", &["west.toml", "receive[0].topic", "\"system/alarms\"", "system/own-tracks"]),
    (WEST, "topic = \"system/own-tracks\"", "topic = \"sensor/radar-east/tracks\"", &["west.toml", "receive[0].topic", "\"sensor/radar-east/tracks\"", "add it to send"]),
    (WEST, "topic = \"system/own-tracks\"", "topic = \"sensor/radar-eats/tracks\"", &["west.toml", "receive[0].topic", "\"sensor/radar-eats/tracks\"", "write \"sensor/radar-east/tracks\""]),
    (EAST, "send = [\"system/own-tracks\"]", "send = [\"sensor/radar/tracks\"]", &["east.toml:", "link[0].send", "\"sensor/radar/tracks\"", "write \"sensor/radar-east/tracks\""]),
    (EAST, "send = [\"system/own-tracks\"]", "send = [\"system/owntracks\"]", &["east.toml:", "link[0].send", "\"system/owntracks\"", "system/tracks"]),
    (EAST, "send = [\"system/own-tracks\"]", "send = []", &["west.toml", "receive[0].topic", "sends nothing", "add it to send"]),
    (EAST, "exchange = true", "exchange = false", &["east.toml:", "link[0].send", "system/own-tracks", "exchange = true"]),
    (EAST, "origin = 2", "origin = 1", &["east.toml:", "origin", "1 is the number", "its own"]),
    (EAST, "origin = 2\n", "", &["east.toml:", "link[0].send", "origin other than 0"]),
    (EAST, "name = \"east\"\n", "name = \"west\"\n", &["east.toml", "\"west\"", "its own"]),
    (WEST, "deployment = \"east\"", "deployment = \"eats\"", &["west.toml", "peer.deployment", "\"eats\"", "correct receive.deployment"]),
    (WEST, "deployment = \"east\"", "deployment = \"west\"", &["west.toml", "peer.deployment", "\"west\"", "correct receive.deployment"]),
    (WEST, "into = \"sensor/east/tracks\"", "into = \"sensor/eats/tracks\"", &["west.toml", "receive", "\"sensor/eats/tracks\"", "external"]),
    (WEST, "into = \"sensor/east/tracks\"", "into = \"sensor/radar-west/tracks\"", &["west.toml", "receive", "\"sensor/radar-west/tracks\"", "external"]),
    (WEST, "into = \"sensor/east/tracks\"\n", "", &["west.toml", "receive", "\"system/own-tracks\"", "into = \"sensor/NAME/tracks\""]),
    (WEST, "name = \"east\"\n\n[[link.receive]]", "name = \"eats\"\n\n[[link.receive]]", &["west.toml", "peer.deployment", "\"east\"", "deployment = \"east\""]),
    (EAST, "[[link.peer]]\nname = \"west\"", "[[link.peer]]\nname = \"wets\"\ndeployment = \"west\"", &["east.toml:", "peer[0].name", "wets", "[[link.peer]]"]),
    (WEST, "[[link.peer]]\nname = \"east\"", "[[link.peer]]\nname = \"east\"\nread = []", &["west.toml", "peer[0].read", "[]", "add it"]),
    (WEST, "[[link.peer]]\nname = \"east\"", "[[link.peer]]\nname = \"east\"\nread = [\"system/tracks\"]", &["west.toml", "peer.read", "\"system/tracks\"", "give it in send"]),
    (EAST, ":7447", ":7448", &["east.toml:", "connect", "7448", "same protocol and port"]),
    (EAST, ":7447", "", &["east.toml:", "connect", "tls/127.0.0.1", "tls/host:7447"]),
    (EAST, ":7447", ":74470", &["east.toml:", "connect", "74470", "tls/host:7447"]),
    (EAST, "connect = [\"tls/", "connect = [\"tcp/", &["east.toml:", "connect", "tcp/127.0.0.1", "same protocol"]),
    (EAST, "connect = [\"tls/", "connect = [\"udp/", &["east.toml:", "connect", "udp/127.0.0.1", "tls/host:7447"]),
    (EAST, "connect = [\"tls/127.0.0.1:7447\"]", "connect = []", &["east.toml", "link[0]", "listen or connect"]),
    (EAST, "connect = [\"tls/127.0.0.1:7447\"]", "listen = [\"tls/[::]:7447\"]", &["west.toml", "listen", "waits", "connect"]),
    (EAST, "connect = [\"tls/127.0.0.1:7447\"]", "connect = [\"tls/localhost:7447\"]", &["west.toml", "certificate", "localhost", "subjectAltName"]),
    (WEST, "listen = [\"tls/127.0.0.1:7447\"]", "connect = [\"tls/127.0.0.1:7447\"]", &["connect", "listens nowhere", "give listen"]),
    (EAST, "authority = \"authority.pem\"\n", "", &["east.toml:", "authority", "needed with the other two"]),
    (EAST, "certificate = \"east.pem\"", "certificate = \"esat.pem\"", &["east.toml:", "link[0].certificate", "esat.pem", "koseki link init"]),
    (EAST, "private_key = \"east.key\"", "private_key = \"east.pem\"", &["east.toml:", "link[0].private_key", "east.pem", "PEM"]),
    (EAST, "private_key = \"east.key\"", "private_key = \"../west/west.key\"", &["east.toml:", "private_key", "west.key", "the key that was made with it"]),
    (EAST, "certificate = \"east.pem\"\nprivate_key = \"east.key\"", "certificate = \"authority.pem\"\nprivate_key = \"east.key\"", &["east.toml:", "private_key", "east.key", "give"]),
    (EAST, "latitude_deg = 41.2971\nlongitude_deg = 2.0785", "latitude_deg = 2.0785\nlongitude_deg = 41.2971", &["east.toml:", "frame.latitude_deg", "2.0785, 41.2971", "exchanged"]),
    (EAST, "latitude_deg = 41.2971", "latitude_deg = -41.2971", &["east.toml:", "frame.latitude_deg", "-41.2971", "minus"]),
    (EAST, "latitude_deg = 41.2971", "latitude_deg = 412.971", &["east.toml:", "frame.latitude_deg", "412.971", "90"]),
    (EAST, "[[link]]", "[[lnik]]", &["east.toml:", "link", "table", "list of"]),
    (EAST, "period_s = 1.0", "period_s = \"1\"", &["east.toml:", "period_s", "\"1\"", "write 1 without quotes"]),
    (EAST, "period_s = 1.0", "period_s = -1.0", &["east.toml:", "period_s", "-1"]),
    (EAST, "range_sigma_m", "range_sigma", &["east.toml:", "range_sigma", "range_sigma_m"]),
    (EAST, "kind = \"radar\"", "kind = \"rador\"", &["east.toml:", "rador", "radar"]),
    (EAST, "targets = 20", "targets = -20", &["east.toml:", "targets", "-20"]),
    (EAST, "name = \"radar-east\"", "name = \"west\"", &["east.toml:", "\"west\"", "name"]),
    (EAST, "exchange = true", "exchange = 1", &["east.toml:", "exchange", ": 1 is neither true nor false", "without quotes"]),
    (EAST, "[fusion]\nexchange = true", "[fusion]\nexchange = true\ncore = 4096", &["east.toml:", "core", "4096"]),
    (EAST, "[fusion]", "[fusion", &["east.toml:"]),
    (EAST, "", "\n[recorder]\nformat = [\"mcab\"]\n", &["east.toml:", "format", "mcab", "mcap"]),
    (EAST, "", "\n[monitor]\nprometheus = \"9464\"\n", &["east.toml:", "prometheus", "9464"]),
    (EAST, "", "\n[[region]]\nname = \"east\"\norigin = 2\ncorners_deg = [[40.0, 2.0], [43.0, 2.0], [43.0, 4.0], [40.0, 4.0]]\n", &["east.toml:", "region[0].name", "\"east\"", "add it there"]),
];

/// Name, mistake in the folder of both centres, and what the answer has to name.
type FileMistake = (&'static str, fn(&Host), &'static [&'static str]);

const FILES: &[FileMistake] = &[
    (
        "the key was not copied",
        |host| fs::remove_file(host.path("west/west.key")).unwrap(),
        &["west.toml:", "private_key", "west.key", "copy the file there"],
    ),
    (
        "an empty certificate",
        |host| fs::write(host.path("east/east.pem"), "").unwrap(),
        &["east.toml:", "certificate", "east.pem", "give a file in PEM"],
    ),
    (
        "a damaged certificate",
        |host| {
            let path = host.path("east/east.pem");
            let text = fs::read_to_string(&path).unwrap();
            let mut lines: Vec<&str> = text.lines().collect();
            lines.drain(3..5);
            fs::write(path, lines.join("\n")).unwrap();
        },
        &["east.toml:", "certificate", "east.pem", "copy it again"],
    ),
    (
        "a certificate of another authority",
        |host| certify(host, 2096, "east", &["127.0.0.1"]),
        &[
            "east.toml:",
            "certificate",
            "east.pem",
            "not signed by the authority",
            "give both sides",
        ],
    ),
    (
        "both have their own authority",
        |host| {
            certify(host, 2096, "east", &["127.0.0.1"]);
            fs::copy(host.path("other.pem"), host.path("east/authority.pem")).unwrap();
        },
        &[
            "certificate",
            "is not signed by the authority",
            "give both sides",
            "east/east.toml",
        ],
    ),
    (
        "a certificate that has expired",
        |host| {
            certify(host, 2020, "east", &["127.0.0.1"]);
            fs::copy(host.path("other.pem"), host.path("east/authority.pem")).unwrap();
        },
        &[
            "east.toml:",
            "certificate",
            "expired on 2020-01-01",
            "koseki link renew",
        ],
    ),
    (
        "a file of users that is not there",
        |host| edit(host, EAST, "[[link.peer]]", "users_file = \"users\"\n[[link.peer]]"),
        &[
            "east.toml:",
            "users_file",
            "users cannot be read",
            "give a file that is there",
        ],
    ),
    (
        "a line of users without a password",
        |host| {
            fs::write(host.path("west/users"), "east\n").unwrap();
            edit(host, WEST, "[[link.peer]]", "users_file = \"users\"\n[[link.peer]]");
        },
        &["west.toml:", "users_file", "users:1", "USER:PASSWORD"],
    ),
    (
        "no user where users are wanted",
        |host| {
            fs::write(host.path("west/users"), "east:word\n").unwrap();
            edit(host, WEST, "[[link.peer]]", "users_file = \"users\"\n[[link.peer]]");
        },
        &["east.toml:", "link[0].user", "is missing", "give a user of"],
    ),
    (
        "another password",
        |host| {
            fs::write(host.path("west/users"), "east:word\n").unwrap();
            fs::write(host.path("east/password"), "world\n").unwrap();
            edit(host, WEST, "[[link.peer]]", "users_file = \"users\"\n[[link.peer]]");
            let with = "user = \"east\"\npassword_file = \"password\"\n[[link.peer]]";
            edit(host, EAST, "[[link.peer]]", with);
        },
        &["east.toml:", "password_file", "east/password", "write the same in both"],
    ),
    (
        "a user that is unknown there",
        |host| {
            fs::write(host.path("west/users"), "west:word\n").unwrap();
            fs::write(host.path("east/password"), "word\n").unwrap();
            edit(host, WEST, "[[link.peer]]", "users_file = \"users\"\n[[link.peer]]");
            let with = "user = \"east\"\npassword_file = \"password\"\n[[link.peer]]";
            edit(host, EAST, "[[link.peer]]", with);
        },
        &["east.toml:", "link[0].user", "\"east\" is not in", "add a line"],
    ),
];

/// Gives the east the certificate of an authority that nobody knows; its own certificate is `other.pem`.
fn certify(host: &Host, year: i32, name: &str, hosts: &[&str]) {
    let authority = Authority::new();
    fs::write(host.path("other.pem"), authority.pem()).unwrap();
    let (certificate, key) = authority.signed(date_time_ymd(year, 1, 1), name, hosts);
    fs::write(host.path("east/east.pem"), certificate).unwrap();
    fs::write(host.path("east/east.key"), key).unwrap();
}

fn edit(host: &Host, file: &str, was: &str, is: &str) {
    let path = host.path(file);
    let text = fs::read_to_string(&path).unwrap();
    let edited = match was {
        "" => text.clone() + is,
        was => text.replacen(was, is, 1),
    };
    assert_ne!(edited, text, "{file} has no {was:?}");
    fs::write(path, edited).unwrap();
}

fn check(host: &Host) -> Output {
    host.koseki().args(["check", WEST, EAST]).output().unwrap()
}

/// Both centres anew, without a mistake.
fn sound(host: &Host) {
    for folder in ["west", "east"] {
        let (from, to) = (host.path("sound").join(folder), host.path(folder));
        let _ = fs::remove_dir_all(&to);
        fs::create_dir(&to).unwrap();
        for file in fs::read_dir(from).unwrap() {
            let file = file.unwrap();
            fs::copy(file.path(), to.join(file.file_name())).unwrap();
        }
    }
}

/// A pair of centres that is sound. `None` where Koseki has not been built.
fn pair() -> Option<Host> {
    let host = Host::new()?;
    succeed(
        host.koseki()
            .args(["link", "init", "west=127.0.0.1", "east=127.0.0.1", "--out", "sound"]),
    );
    sound(&host);
    Some(host)
}

/// What is wrong with the answer to a mistake.
fn fault(output: &Output, wanted: &[&str]) -> Option<String> {
    let said = String::from_utf8_lossy(&output.stderr);
    let lacks: Vec<&&str> = wanted.iter().filter(|word| !said.contains(**word)).collect();
    (output.status.code() != Some(2) || !lacks.is_empty())
        .then(|| format!("exit {:?}, not named: {lacks:?}\n{said}", output.status.code()))
}

#[test]
fn every_planted_mistake_is_answered_with_place_value_and_remedy() {
    let Some(host) = pair() else {
        return;
    };
    let mut faults = Vec::new();
    for (file, was, is, wanted) in EDITS {
        sound(&host);
        edit(&host, file, was, is);
        faults.extend(fault(&check(&host), wanted).map(|fault| format!("{file}: {was:?} -> {is:?}: {fault}")));
    }
    for (name, plant, wanted) in FILES {
        sound(&host);
        plant(&host);
        faults.extend(fault(&check(&host), wanted).map(|fault| format!("{name}: {fault}")));
    }
    let all = EDITS.len() + FILES.len();
    assert!(
        all >= 50 && faults.is_empty(),
        "{} of {all}:\n{}",
        faults.len(),
        faults.join("\n")
    );
    sound(&host);
    let output = check(&host);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_machine_without_the_program_of_links_is_told_where_it_is_searched() {
    let Some(host) = pair() else {
        return;
    };
    // Beside this copy, there is none.
    let alone = host.path("koseki");
    let program = host.koseki().get_program().to_owned();
    if fs::hard_link(&program, &alone).is_err() {
        fs::copy(&program, &alone).unwrap();
    }
    let asked = |configs: &[&str]| {
        let mut command = host.command(&alone);
        command
            .arg("check")
            .args(configs)
            .env_remove("KOSEKI_LINK")
            .env("PATH", "");
        command.output().unwrap()
    };
    let wanted = ["koseki-link is not at $KOSEKI_LINK", "install the package"];
    assert_eq!(fault(&asked(&[WEST, EAST]), &wanted), None);
    let one = asked(&[WEST]);
    let said = String::from_utf8_lossy(&one.stdout);
    assert!(
        one.status.success() && wanted.iter().all(|word| said.contains(word)),
        "{said}"
    );
}

#[test]
fn a_key_that_others_may_read_and_a_certificate_that_ends_soon_are_warned_of() {
    let Some(host) = Host::new() else {
        return;
    };
    succeed(
        host.koseki()
            .args(["link", "init", "west=127.0.0.1", "east", "--days", "29"]),
    );
    fs::set_permissions(host.path("east/east.key"), fs::Permissions::from_mode(0o644)).unwrap();
    let output = host.koseki().args(["check", EAST, "--json"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    let wanted = [
        "east.key may be read by others (mode 644); give it chmod 600",
        "east.pem expires on",
        "renew",
    ];
    assert!(
        output.status.success() && wanted.iter().all(|word| said.contains(word)),
        "{said}"
    );
}

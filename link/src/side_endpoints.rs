//! Whether two links find each other, and let each other in: endpoints, certificates, users and peers of both sides.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;

use deployment::Link;

use crate::credentials::{self, Credentials, RENEW_BEFORE, date};
use crate::sides::{Findings, Side};

/// Credentials of each link with certificates that are sound.
pub(crate) type Sound = BTreeMap<(String, usize), Credentials>;

/// Protocol, host and port of an endpoint.
fn parts(endpoint: &str) -> Option<(&str, &str, &str)> {
    let (protocol, place) = endpoint.split_once('/')?;
    let (host, port) = place.rsplit_once(':')?;
    Some((protocol, host.trim_start_matches('[').trim_end_matches(']'), port))
}

/// Examines the certificates of one configuration, and the files that its links name.
pub(crate) fn of_one(side: &Side, found: &mut Findings) -> Sound {
    let now = credentials::utc();
    let mut sound = Sound::new();
    for (index, link) in side.links() {
        let at = |key: &str, what: String| side.at(&format!("link[{index}].{key}"), what);
        let secrets = [
            ("private_key", &link.private_key),
            ("password_file", &link.password_file),
            ("users_file", &link.users_file),
        ];
        for (key, file) in secrets {
            let Some(file) = file else { continue };
            match std::fs::metadata(file) {
                Ok(about) if about.permissions().mode() & 0o077 != 0 => {
                    let mode = about.permissions().mode() & 0o777;
                    let what = format!("{file} may be read by others (mode {mode:03o}); give it chmod 600");
                    found.warnings.push(at(key, what));
                }
                // The key is examined below.
                Err(error) if key != "private_key" => {
                    found.refused.push(at(
                        key,
                        format!("{file} cannot be read: {error}; give a file that is there"),
                    ));
                }
                _ => {}
            }
        }
        if let Some(fault) = link.users_file.as_ref().and_then(|file| users_fault(Path::new(file))) {
            found.refused.push(at("users_file", fault));
        }
        let Some(files) = link.tls() else { continue };
        match Credentials::read(&files, now) {
            Err(fault) => found.refused.push(at(fault.key, fault.what)),
            Ok(credentials) => {
                let until = credentials.until();
                if time::OffsetDateTime::from(now) + RENEW_BEFORE >= until {
                    let file = files.certificate.display();
                    let what = format!("{file} expires on {}; renew it with `koseki link renew`", date(until));
                    found.warnings.push(at("certificate", what));
                }
                sound.insert((side.file(), index), credentials);
            }
        }
    }
    sound
}

/// A line of a file of users that is none.
fn users_fault(file: &Path) -> Option<String> {
    let text = std::fs::read_to_string(file).ok()?;
    let mut lines = text.lines().zip(1..).filter(|(line, _)| !line.trim().is_empty());
    let (_, number) = lines.find(|(line, _)| {
        line.split_once(':')
            .is_none_or(|(user, word)| user.is_empty() || word.is_empty())
    })?;
    Some(format!(
        "{}:{number} is no line USER:PASSWORD; write it so",
        file.display()
    ))
}

/// Finds what keeps the links of both sides apart.
pub(crate) fn check(sides: [&Side; 2], found: &mut Findings) {
    let [west, east] = sides;
    if west.config.links.is_empty() || east.config.links.is_empty() {
        return;
    }
    let mut sound = of_one(west, found);
    sound.extend(of_one(east, found));
    let mut met = false;
    for (calls, listens) in [(west, east), (east, west)] {
        for (caller, link) in calls.links() {
            for (callee, other) in listens.links() {
                for endpoint in link.connect.iter().filter(|endpoint| is_met(endpoint, other)) {
                    met = true;
                    let pair = [(calls, caller, link), (listens, callee, other)];
                    let host = parts(endpoint).map(|(_, host, _)| host);
                    meet(pair, host, &sound, found);
                }
            }
        }
    }
    if !met {
        explain(sides, found);
    }
}

/// Whether a link listens at the port of an endpoint, in the same way, and not only on its own machine.
fn is_met(endpoint: &str, other: &Link) -> bool {
    let Some((protocol, host, port)) = parts(endpoint) else {
        return false;
    };
    let is_here = |host: &str| host == "localhost" || host.parse().is_ok_and(|ip: IpAddr| ip.is_loopback());
    other
        .listen
        .iter()
        .filter_map(|listen| parts(listen))
        .any(|(theirs, at, number)| theirs == protocol && number == port && (is_here(host) || !is_here(at)))
}

/// Why no link of one side reaches a link of the other.
fn explain([west, east]: [&Side; 2], found: &mut Findings) {
    let all = |side: &Side, of: fn(&Link) -> &Vec<String>| -> Vec<String> {
        side.config.links.iter().flat_map(|link| of(link).clone()).collect()
    };
    let listens = |side: &Side| all(side, |link| &link.listen);
    for (side, other) in [(west, east), (east, west)] {
        if let Some((index, link)) = side.links().find(|(_, link)| !link.connect.is_empty()) {
            let (there, file) = (listens(other).join(", "), other.file());
            let what = match there.is_empty() {
                true => format!(
                    "{} meets nobody: {file} listens nowhere; give listen there",
                    link.connect.join(", ")
                ),
                false => format!(
                    "{} meets nobody: {file} listens at {there}; give both the same protocol and port, and listen at an \
                     address that others reach",
                    link.connect.join(", ")
                ),
            };
            found.refused.push(side.at(&format!("link[{index}].connect"), what));
            return;
        }
    }
    let what = format!(
        "{} waits here, and {} waits at {}; give one of them connect",
        listens(west).join(", "),
        east.file(),
        listens(east).join(", ")
    );
    found.refused.push(west.at("link[0].listen", what));
}

/// A link of a side.
type End<'a> = (&'a Side, usize, &'a Link);

/// Checks that two links which reach each other let each other in: the first calls the second at `host`.
fn meet(pair: [End<'_>; 2], host: Option<&str>, sound: &Sound, found: &mut Findings) {
    let of = |(side, index, _): &End<'_>| sound.get(&(side.file(), *index));
    let [caller, callee] = pair;
    for (own, other, host) in [(&caller, &callee, None), (&callee, &caller, host)] {
        let (side, index, link) = *own;
        let at = |key: &str, what: String| side.at(&format!("link[{index}].{key}"), what);
        let (there, _, others) = *other;
        if let (Some(shown), Some(judge)) = (of(own), of(other))
            && let Some(fault) = shown.fault_at(judge, host, credentials::utc())
        {
            let file = link.certificate.as_deref().unwrap_or_default();
            let what = format!("{file} {fault} ({})", there.file());
            found.refused.push(at("certificate", what));
        }
        let names = [
            of(own).map(|credentials| credentials.own.common_name.as_str()),
            link.user.as_deref(),
        ];
        let names: Vec<&str> = names.into_iter().flatten().collect();
        admit((own, other), &names, found);
        let Some(users) = others
            .users_file
            .as_ref()
            .and_then(|file| std::fs::read_to_string(file).ok())
        else {
            continue;
        };
        let user = link.user.as_deref().unwrap_or_default();
        let entry = users
            .lines()
            .filter_map(|line| line.split_once(':'))
            .find(|(name, _)| *name == user);
        let file = others.users_file.as_deref().unwrap_or_default();
        let password = link
            .password_file
            .as_ref()
            .and_then(|file| std::fs::read_to_string(file).ok());
        match (entry, password) {
            _ if user.is_empty() => {
                let what = format!(
                    "is missing, and {} admits users only; give a user of {file}",
                    there.file()
                );
                found.refused.push(at("user", what));
            }
            (None, _) => {
                found.refused.push(at(
                    "user",
                    format!("\"{user}\" is not in {file}; add a line {user}:PASSWORD there"),
                ));
            }
            (Some((_, wanted)), Some(given)) if given.lines().next() != Some(wanted) => {
                let here = link.password_file.as_deref().unwrap_or_default();
                let what = format!("{here} has another password than {file}; write the same in both");
                found.refused.push(at("password_file", what));
            }
            _ => {}
        }
    }
}

/// Checks that the link at the `other` end names this one, by one of `names`, as a peer, with the topics that this one
/// receives.
fn admit((own, other): (&End<'_>, &End<'_>), names: &[&str], found: &mut Findings) {
    let ((side, _, link), (there, index, others)) = (own, other);
    if others.peers.is_empty() || names.is_empty() {
        return;
    }
    let at = |key: &str, what: String| there.at(&format!("link[{index}].{key}"), what);
    let Some(place) = others.peers.iter().position(|peer| names.contains(&peer.name.as_str())) else {
        let named: Vec<&str> = others.peers.iter().map(|peer| peer.name.as_str()).collect();
        let what = format!(
            "names {}, and {} shows \"{}\"; add a [[link.peer]] with that name",
            named.join(", "),
            side.file(),
            names.join("\" or \"")
        );
        found.refused.push(at("peer[0].name", what));
        return;
    };
    let peer = &others.peers[place];
    let from_there = link
        .receive
        .iter()
        .filter(|remote| remote.deployment == there.config.name);
    for remote in from_there.filter(|remote| others.send.contains(&remote.topic)) {
        if !peer.read(others).contains(&remote.topic) {
            let what = format!(
                "[{}] lacks \"{}\", which {} receives; add it",
                peer.read(others).join(", "),
                remote.topic,
                side.file()
            );
            found.refused.push(at(&format!("peer[{place}].read"), what));
        }
    }
    let from_here = others
        .receive
        .iter()
        .any(|remote| remote.deployment == side.config.name);
    if from_here && peer.gives() != side.config.name {
        let what = format!(
            "\"{}\" may give the topics of \"{}\" only, and is \"{}\"; give it deployment = \"{2}\"",
            peer.name,
            peer.gives(),
            side.config.name
        );
        found.refused.push(at(&format!("peer[{place}].deployment"), what));
    }
}

//! Two centres on two hosts that begin with nothing: `koseki link init` makes them.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::Command;

use crate::host::{Host, until};
use crate::mirror::Reader;
use crate::network::Network;

/// Runs a command that ends well. Returns its output.
pub(crate) fn succeed(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {error}");
    String::from_utf8(output.stdout).unwrap()
}

fn mode(path: &Path) -> u32 {
    fs::metadata(path).unwrap().permissions().mode() & 0o777
}

/// Whether a reader sees a track to which the centre with the number `origin` contributes.
fn sees(reader: &mut Reader, origin: u32) -> bool {
    reader.read();
    let mut tracks = reader.tracks.values();
    tracks.any(|track| track.contributions().iter().any(|part| part.origin == origin))
}

#[test]
fn two_clean_hosts_exchange_tracks_after_four_commands() {
    let Some(network) = Network::new() else {
        return;
    };
    let place = network.endpoint.strip_prefix("tcp/").unwrap();
    let (address, port) = place.rsplit_once(':').unwrap();
    let [west, east] = &network.hosts;
    // The first: certificates that end soon, so that the alarm can be seen.
    let centre = format!("west={address}");
    succeed(
        west.koseki()
            .args(["link", "init", &centre, "east", "--port", port, "--days", "20"]),
    );
    // The second: its folder goes to the other host.
    succeed(
        Command::new("cp")
            .arg("-a")
            .arg(west.path("east"))
            .arg(east.path("east")),
    );
    // The third and the fourth.
    let mut up = [west.up_from("west", &[]), east.up_from("east", &[])];
    up.iter_mut().for_each(|deployment| deployment.until_up());
    let mut readers = [Reader::until_there(west, "west"), Reader::until_there(east, "east")];
    let status = || west.status("west") + &east.status("east");
    for (reader, origin) in readers.iter_mut().zip([2, 1]) {
        until(|| sees(reader, origin), status);
    }
    let told = |host: &Host, name: &str| host.status(name).contains("\"alarm\": \"certificate-expires\"");
    until(|| told(west, "west") && told(east, "east"), status);
    assert!(status().contains("certificate expires on 20"), "{}", status());
}

#[test]
fn keys_are_for_their_owner_and_nothing_is_overwritten() {
    let Some(host) = Host::new() else {
        return;
    };
    let init = ["link", "init", "west=west.example", "east=192.0.2.9", "--json"];
    let said = succeed(host.koseki().args(init));
    for word in ["certificate_until", "\"west/west.toml\"", "192.0.2.9"] {
        assert!(said.contains(word), "{said}");
    }
    for key in ["west/west.key", "east/east.key", "authority/authority.key"] {
        assert_eq!(mode(&host.path(key)), 0o600, "{key}");
    }
    assert_eq!(mode(&host.path("authority")), 0o700);
    assert!(!host.path("west/authority.key").exists() && !host.path("east/authority.key").exists());
    let before = fs::read(host.path("authority/authority.key")).unwrap();
    let again = host.koseki().args(init).output().unwrap();
    let refused = String::from_utf8_lossy(&again.stderr);
    assert_eq!(again.status.code(), Some(2), "{refused}");
    assert!(refused.contains("west exists, and nothing is overwritten"), "{refused}");
    assert_eq!(fs::read(host.path("authority/authority.key")).unwrap(), before);
}

#[test]
fn renewed_certificates_keep_names_and_hosts_and_are_signed_by_their_own_authority_only() {
    let Some(host) = Host::new() else {
        return;
    };
    succeed(
        host.koseki()
            .args(["link", "init", "west=west.example", "east=192.0.2.9", "--days", "10"]),
    );
    let configs = ["west/west.toml", "east/east.toml"];
    let warned = || succeed(host.koseki().arg("check").args(configs));
    assert!(warned().contains("east.pem expires on"), "{}", warned());
    let old = fs::read(host.path("east/east.key")).unwrap();
    succeed(host.koseki().args(["link", "renew"]).args(configs));
    assert_ne!(fs::read(host.path("east/east.key")).unwrap(), old);
    assert_eq!(mode(&host.path("east/east.key")), 0o600);
    // The east connects to west.example, and each names the other.
    assert!(!warned().contains("warning"), "{}", warned());
    succeed(
        host.koseki()
            .args(["link", "init", "north=127.0.0.1", "south", "--out", "else"]),
    );
    let kept = fs::read(host.path("east/east.pem")).unwrap();
    let foreign = host
        .koseki()
        .args(["link", "renew", "--authority", "else/authority"])
        .args(configs)
        .output();
    let foreign = foreign.unwrap();
    let refused = String::from_utf8_lossy(&foreign.stderr);
    assert_eq!(foreign.status.code(), Some(2), "{refused}");
    assert!(
        refused.contains("another authority than that of --authority else/authority"),
        "{refused}"
    );
    assert_eq!(fs::read(host.path("east/east.pem")).unwrap(), kept);
}

#[test]
fn configurations_that_exist_are_joined_and_stay_as_they_are() {
    let Some(host) = Host::new() else {
        return;
    };
    let own = "# Ours.\nname = \"tower\"\norigin = 7\n[frame]\nlatitude_deg = 41.3\nlongitude_deg = 2.1\n[[source]]\n\
               name = \"radar\"\nperiod_s = 4.0\n[source.external]\n[recorder]\nenabled = false\n";
    fs::write(host.path("tower.toml"), own).unwrap();
    succeed(host.koseki().args(["link", "init", "tower.toml=127.0.0.1", "east"]));
    assert_eq!(fs::read_to_string(host.path("tower.toml")).unwrap(), own);
    let joined = fs::read_to_string(host.path("tower/tower.toml")).unwrap();
    assert!(
        joined.starts_with("# Ours.") && joined.contains("origin = 7"),
        "{joined}"
    );
    succeed(host.koseki().args(["check", "tower/tower.toml", "east/east.toml"]));
}

//! Connections that say nothing, beside peers that are welcome.

use std::net::TcpStream;
use std::time::{Duration, Instant};

use crate::certificates::Authority;
use crate::host::{Host, free_port, until};
use crate::mirror::{Reader, mirror, tower};

/// Silent connections, unless `KOSEKI_SILENT` names another number.
const SILENT: usize = 1000;
/// Time in which a welcome peer joins, beside the start of its process on a busy machine.
const JOINS: Duration = Duration::from_secs(20);

/// Time after which silent connections are replaced by others.
const RENEWED: Duration = Duration::from_secs(1);

/// Opens so many connections to `port` that never send a byte.
fn silent(port: u16, count: usize) -> Vec<TcpStream> {
    (0..count)
        .map_while(|_| TcpStream::connect(("127.0.0.1", port)).ok())
        .collect()
}

/// A mirror joins a link at an endpoint beside silent connections, which are renewed until the mirror shows the
/// picture.
fn a_mirror_joins_beside_silence(is_encrypted: bool) {
    let Some(there) = Host::new() else { return };
    let count = std::env::var("KOSEKI_SILENT").ok().and_then(|count| count.parse().ok());
    let count: usize = count.unwrap_or(SILENT);
    let (authority, port) = (Authority::new(), free_port());
    let (protocol, options): (_, &[&str]) = match is_encrypted {
        true => ("tls", &["--certificates"]),
        false => ("tcp", &[]),
    };
    let endpoint = format!("{protocol}/127.0.0.1:{port}");
    let identify = |host: &Host, name: &str| match is_encrypted {
        true => authority.certify(host, name, &authority),
        false => String::new(),
    };
    let mut deployment = there.up("tower", &tower(&endpoint, &identify(&there, "tower")), &[]);
    deployment.until_up();
    let here = Host::new().unwrap();
    let config = tower(&endpoint, &identify(&here, "display"));
    let (mut held, mut renewed) = (silent(port, count), Instant::now());
    let begun = Instant::now();
    let _mirror = mirror(&here, &config, &endpoint, options);
    let mut seen = Reader::until_there(&here, "tower");
    until(
        || {
            // The link closes them; more come.
            if renewed.elapsed() > RENEWED {
                held = silent(port, count);
                renewed = Instant::now();
            }
            seen.read();
            seen.tracks.len() >= 20
        },
        || here.status("tower"),
    );
    println!(
        "{protocol}: joined {:.2} s after its start, beside {count} silent connections",
        begun.elapsed().as_secs_f64()
    );
    assert!(begun.elapsed() < JOINS, "{:?}", begun.elapsed());
}

#[test]
fn silent_connections_lock_nobody_out_of_tcp() {
    a_mirror_joins_beside_silence(false);
}

#[test]
fn silent_connections_lock_nobody_out_of_tls() {
    a_mirror_joins_beside_silence(true);
}

//! Places in which the executable is called, and what is sent to it there.

pub(crate) mod counted_pair;
pub(crate) mod documented;
pub(crate) mod folder;
pub(crate) mod home;
pub(crate) mod report;

use std::collections::BTreeSet;
use std::net::{SocketAddr, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::time::{SystemTime, UNIX_EPOCH};

use frames::time::NS_PER_DAY;
use frames::{Geodetic, SystemFrame};

pub(crate) use documented::texts;
pub(crate) use folder::Folder;
pub(crate) use home::{Home, Running, kill, until};
pub(crate) use test_support::S;

/// Latitude and longitude of the origin of the tests' deployments, degrees.
pub(crate) const PLACE: [f64; 2] = [41.297063, 2.078447];

/// The executable, to be called.
pub(crate) fn koseki() -> Command {
    Command::new(env!("CARGO_BIN_EXE_koseki"))
}

/// A file or folder of the repository, by its path there.
pub(crate) fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

/// The time now, nanoseconds since 1970 (UTC).
pub(crate) fn utc_ns() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as i64
}

/// Nanoseconds since midnight (UTC) of the day of `begun_ns`, as tables count times: they go on across midnight.
pub(crate) fn since_first_day_ns(begun_ns: i64, time_ns: i64) -> i64 {
    time_ns - begun_ns.div_euclid(NS_PER_DAY) * NS_PER_DAY
}

/// A counter in a report; an absent one is 0.
pub(crate) fn counter(counters: &serde_json::Value, label: &str) -> u64 {
    counters[label].as_u64().unwrap_or(0)
}

/// The origin of the tests' deployments, and the system frame there.
pub(crate) fn system() -> (Geodetic, SystemFrame) {
    let place = Geodetic::from_degrees(PLACE[0], PLACE[1], 0.0).unwrap();
    (place, SystemFrame::at(place))
}

/// An address on the loopback interface whose UDP port was free a moment ago; no other test gets it.
pub(crate) fn free_address() -> SocketAddr {
    static GIVEN: Mutex<BTreeSet<u16>> = Mutex::new(BTreeSet::new());
    loop {
        let address = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        if GIVEN.lock().unwrap().insert(address.port()) {
            return address;
        }
    }
}

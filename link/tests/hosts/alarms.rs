//! What a link finds out of order is an alarm of its deployment.

use koseki_client::messages::SystemTrack;
use koseki_client::messages::layout::Sample as _;
use runtime::Now;
use zenoh::Wait as _;
use zenoh::query::{Query, Queryable};

use crate::host::{Host, free_port, until};
use crate::refusals::{intruder, of_layout};
use crate::relay::{Delays, Relay};

const COMMON: &str = "[frame]\nlatitude_deg = 41.3\nlongitude_deg = 2.1\n[recorder]\nenabled = false\n\
     [[source]]\nname = \"radar\"\nperiod_s = 600.0\n[source.external]\n";

#[test]
fn another_clock_another_layout_and_a_lost_peer_are_alarms() {
    let (Some(west), Some(east)) = (Host::new(), Host::new()) else {
        return;
    };
    let (port, door) = (free_port(), free_port());
    let relay = Relay::to(port, Delays::NONE);
    let away = format!(
        "name = \"west\"\n{COMMON}[[link]]\nname = \"out\"\nlisten = [\"tcp/127.0.0.1:{port}\"]\n\
         send = [\"sensor/radar/tracks\"]\n"
    );
    let here = format!(
        "name = \"east\"\n{COMMON}[[link]]\nname = \"in\"\nlisten = [\"tcp/127.0.0.1:{door}\"]\n\
         connect = [\"tcp/127.0.0.1:{}\"]\nsend = []\n\
         [[link.receive]]\ndeployment = \"west\"\ntopic = \"sensor/radar/tracks\"\n",
        relay.port()
    );
    let mut west_up = west.up("west", &away, &[]);
    let mut east_up = east.up("east", &here, &[]);
    west_up.until_up();
    east_up.until_up();
    let status = || east.status("east");
    let stands = |alarm: &str| status().contains(&format!("\"alarm\": \"{alarm}\""));
    let intruder = intruder(&format!("tcp/127.0.0.1:{door}"), status);
    let clock = clock_ahead(&intruder, "north", 500_000_000);
    until(|| stands("host-clock-off"), status);
    assert!(!stands("layout-mismatch") && !stands("peer-missing"), "{}", status());
    clock.undeclare().wait().unwrap();
    until(
        || {
            // As a build whose sensor tracks are laid out in another way would send it.
            let key = format!("koseki/{:016x}/west/sensor/radar/tracks", SystemTrack::SCHEMA);
            intruder.put(key, of_layout(SystemTrack::SCHEMA)).wait().unwrap();
            stands("layout-mismatch")
        },
        status,
    );
    assert!(status().contains("1 of another layout"), "{}", status());
    relay.cut();
    until(|| stands("peer-missing"), status);
    assert!(status().contains("west is not there"), "{}", status());
}

/// Answers as the link of a deployment whose host has a UTC that is ahead by `ahead_ns`.
fn clock_ahead(session: &zenoh::Session, deployment: &str, ahead_ns: i64) -> Queryable<()> {
    let key = format!("koseki-clock/{deployment}/out");
    let of_answers = key.clone();
    let answer = move |query: Query| {
        let now = Now::read();
        let octets = [now.mono_ns.to_le_bytes(), (now.utc_ns + ahead_ns).to_le_bytes()].concat();
        // A failure means that the requesting link is gone.
        let _ = query.reply(of_answers.as_str(), octets).wait();
    };
    session.declare_queryable(key).callback(answer).wait().unwrap()
}

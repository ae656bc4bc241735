//! The metrics, collected over the loopback network as Prometheus does it.

use std::collections::BTreeMap;
use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};

use crate::watched::{Bench, S};
use messages::{Counter, ProcessKind};

/// What is collected at `url`: each sample by its name with labels.
fn collect(url: &str) -> BTreeMap<String, f64> {
    let (address, path) = url.strip_prefix("http://").unwrap().split_once('/').unwrap();
    let mut stream = TcpStream::connect(address.parse::<SocketAddr>().unwrap()).unwrap();
    write!(
        stream,
        "GET /{path} HTTP/1.1\r\nHost: {address}\r\nAccept: text/plain\r\n\r\n"
    )
    .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    let head = head.to_ascii_lowercase();
    assert!(head.starts_with("http/1.1 200 ok\r\n"), "{head}");
    assert!(
        head.contains("\r\ncontent-type: application/openmetrics-text; version=1.0.0"),
        "{head}"
    );
    assert!(
        head.contains(&format!("\r\ncontent-length: {}\r\n", body.len())),
        "{head}"
    );
    assert!(body.ends_with("# EOF\n"));
    let mut samples = BTreeMap::new();
    let mut families = BTreeMap::new();
    for line in body.lines() {
        let words: Vec<&str> = line.splitn(4, ' ').collect();
        match words[..] {
            ["#", "TYPE", name, kind] => {
                assert_eq!(families.insert(name, kind), None, "{name} is a family once");
            }
            ["#", "HELP" | "UNIT", _, text] => assert!(!text.is_empty(), "{line}"),
            ["#", "EOF"] => {}
            _ => {
                let (name, value) = line.rsplit_once(' ').unwrap();
                let of_family = name.split('{').next().unwrap();
                assert!(
                    families.iter().any(|(family, kind)| match *kind {
                        "counter" => of_family == format!("{family}_total"),
                        "gauge" => of_family == *family,
                        _ => of_family
                            .strip_prefix(family)
                            .is_some_and(|end| ["_sum", "_count", "_bucket"].contains(&end)),
                    }),
                    "{line} belongs to no family"
                );
                let value: f64 = value.parse().unwrap();
                assert_eq!(samples.insert(name.to_owned(), value), None, "{name} is there once");
            }
        }
    }
    samples
}

const SERVED: &str = "monitor.prometheus=\"127.0.0.1:0\"";

fn url(bench: &Bench) -> String {
    bench.monitor.metrics().unwrap().unwrap()
}

#[test]
fn everything_that_is_known_is_collected() {
    let mut bench = Bench::new(&[SERVED, "monitor.wait=poll"]);
    let before = collect(&url(&bench));
    assert_eq!(before["koseki_system_tracks{state=\"confirmed\"}"], 0.0);
    assert_eq!(before["koseki_process_up{kind=\"fusion\",process=\"fusion\"}"], 0.0);
    bench.fuse(0, 10, 1_500_000);
    bench.fuse(3, 20, 4_000);
    let rejected = [(Counter::RejectedJump, 4), (Counter::Published, 100)];
    bench.say(ProcessKind::Adapter, "radar-west", 0, &rejected);
    bench.say(
        ProcessKind::Fusion,
        "fusion",
        3,
        &[(Counter::Lost, 7), (Counter::DroppedQueue, 2)],
    );
    let levels = [
        (Counter::LiveTracks, 12),
        (Counter::CoastedTracks, 2),
        (Counter::TentativeTracks, 1),
    ];
    bench.say(ProcessKind::Fusion, "fusion", messages::NO_SOURCE, &levels);
    // What fusion and an adapter of one source say of themselves as a whole has what they say of their sources.
    bench.say(ProcessKind::Fusion, "fusion", 0, &[(Counter::Taken, 10)]);
    let levels_and_total = [&levels[..], &[(Counter::Taken, 10), (Counter::Lost, 7)]].concat();
    bench.say(ProcessKind::Fusion, "fusion", messages::NO_SOURCE, &levels_and_total);
    let whole = [(Counter::Records, 50), (Counter::Datagrams, 5)];
    bench.say(ProcessKind::Adapter, "ads-b", messages::NO_SOURCE, &whole);
    bench.pass(S);
    bench.turn();
    let samples = collect(&url(&bench));
    for (name, expected) in [
        (
            "koseki_stage_latency_seconds_count{stage=\"taken_to_fused\",source=\"radar-west\"}",
            10.0,
        ),
        (
            "koseki_stage_latency_seconds_count{stage=\"end_to_end\",source=\"ads-b\"}",
            20.0,
        ),
        (
            "koseki_stage_latency_seconds_bucket{le=\"0.00001\",stage=\"end_to_end\",source=\"ads-b\"}",
            0.0,
        ),
        (
            "koseki_stage_latency_seconds_bucket{le=\"0.00002\",stage=\"end_to_end\",source=\"ads-b\"}",
            20.0,
        ),
        (
            "koseki_stage_latency_seconds_bucket{le=\"+Inf\",stage=\"end_to_end\",source=\"ads-b\"}",
            20.0,
        ),
        ("koseki_stage_deadline_seconds{stage=\"taken_to_fused\"}", 0.001),
        (
            "koseki_stage_late_total{stage=\"taken_to_fused\",source=\"radar-west\"}",
            10.0,
        ),
        (
            "koseki_stage_late_total{stage=\"taken_to_fused\",source=\"ads-b\"}",
            0.0,
        ),
        (
            "koseki_rejected_jump_total{kind=\"adapter\",process=\"radar-west\",source=\"radar-west\"}",
            4.0,
        ),
        (
            "koseki_rejected_time_total{kind=\"adapter\",process=\"radar-west\",source=\"radar-west\"}",
            0.0,
        ),
        (
            "koseki_lost_total{kind=\"fusion\",process=\"fusion\",source=\"ads-b\"}",
            7.0,
        ),
        (
            "koseki_dropped_queue_total{kind=\"fusion\",process=\"fusion\",source=\"ads-b\"}",
            2.0,
        ),
        ("koseki_system_tracks{state=\"confirmed\"}", 10.0),
        ("koseki_system_tracks{state=\"coasted\"}", 2.0),
        ("koseki_process_restarts_total{kind=\"fusion\",process=\"fusion\"}", 0.0),
        ("koseki_monitor_missed_states_total", 0.0),
    ] {
        assert_eq!(samples.get(name), Some(&expected), "{name}");
    }
    assert!(
        !samples.keys().any(|name| name.contains("fused_to_received")),
        "not measured"
    );
    let sum_of = |family: &str| -> f64 {
        let samples = samples.iter().filter(|(name, _)| name.starts_with(family));
        samples.map(|(_, value)| value).sum()
    };
    for (family, expected) in [("lost", 7.0), ("records", 50.0), ("datagrams", 5.0)] {
        assert_eq!(sum_of(&format!("koseki_{family}_total{{")), expected, "{family}");
    }
    let of_fusion = |source: &str| {
        let labels = format!("{{kind=\"fusion\",process=\"fusion\",source=\"{source}\"}}");
        samples[&format!("koseki_taken_total{labels}")]
    };
    assert_eq!([of_fusion(""), of_fusion("radar-west")], [0.0, 10.0]);
    let sum = samples["koseki_stage_latency_seconds_sum{stage=\"end_to_end\",source=\"ads-b\"}"];
    assert!((sum / (20.0 * 12e-6) - 1.0).abs() < 1e-3, "{sum}");
}

#[test]
fn what_is_handed_over_is_that_of_the_last_interval_and_of_the_end() {
    let mut bench = Bench::new(&[SERVED]);
    let count = |bench: &Bench| {
        let samples = collect(&url(bench));
        samples
            .get("koseki_stage_latency_seconds_count{stage=\"age\",source=\"radar-west\"}")
            .copied()
    };
    bench.fuse(0, 5, 1_000);
    bench.turn();
    assert_eq!(count(&bench), None, "the interval is not over");
    bench.pass(S);
    bench.turn();
    assert_eq!(count(&bench), Some(5.0));
    bench.fuse(0, 5, 1_000);
    bench.close();
    assert_eq!(count(&bench), Some(10.0), "served until the monitor is gone");
}

#[test]
fn whoever_has_asked_when_the_monitor_ends_is_answered() {
    let bench = Bench::new(&[SERVED]);
    let address: SocketAddr = url(&bench)["http://".len()..]
        .strip_suffix("/metrics")
        .unwrap()
        .parse()
        .unwrap();
    let clients: Vec<TcpStream> = (0..3)
        .map(|_| {
            let mut client = TcpStream::connect(address).unwrap();
            client
                .write_all(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n")
                .unwrap();
            client
        })
        .collect();
    drop(bench);
    for mut client in clients {
        let mut answer = String::new();
        client.read_to_string(&mut answer).unwrap();
        assert!(answer.ends_with("# EOF\n"), "{answer}");
    }
    assert!(TcpStream::connect(address).is_err(), "nobody listens any more");
}

#[test]
fn a_port_in_use_is_named_with_its_key_and_the_monitor_goes_on() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap();
    let served = format!("monitor.prometheus=\"{address}\"");
    let mut bench = Bench::new(&[&served]);
    let refusal = bench.monitor.metrics().unwrap().unwrap_err().to_owned();
    for expected in [
        "monitor.prometheus: ",
        &address.to_string(),
        "in use",
        "take another port",
    ] {
        assert!(refusal.contains(expected), "{refusal}");
    }
    assert_eq!(refusal.lines().count(), 1);
    assert_eq!(bench.own_health().note, refusal);
    bench.fuse(0, 5, 1_000);
    bench.turn();
    assert_eq!(bench.own_health().counters[Counter::Taken], 5);
}

#[test]
fn without_the_key_nothing_is_served() {
    assert!(Bench::new(&[]).monitor.metrics().is_none());
}

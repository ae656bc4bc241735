//! Datagrams over the loopback interface: what is received, what is refused, and what is counted.
//!
//! Sending over loopback puts a datagram into the receiver's buffer, or drops it there, before the call returns; so no
//! test has to wait for one to arrive.

use std::net::{IpAddr, Ipv6Addr, SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use net::{
    AllowedSenders, BATCH_MAX, Interface, NetError, ReceiverCounters, ReceiverSettings, SenderSettings, UdpReceiver,
    UdpSender,
};

/// Far longer than anything here takes, so that a machine under load fails no test.
const PATIENCE: Duration = Duration::from_secs(30);

fn settings(address: &str) -> ReceiverSettings {
    ReceiverSettings {
        receive_buffer_octets: 1 << 18,
        ..ReceiverSettings::new(address.parse().unwrap(), 0)
    }
}

fn group_settings(group: &str) -> ReceiverSettings {
    ReceiverSettings {
        interface: Some(Interface::Name("lo".to_owned())),
        ..settings(group)
    }
}

fn open(settings: &ReceiverSettings) -> UdpReceiver {
    UdpReceiver::open(settings).unwrap()
}

/// A sender to where `receiver` receives.
fn sender_to(destination: SocketAddr) -> UdpSender {
    let mut settings = SenderSettings::new(destination);
    if destination.ip().is_multicast() {
        settings.interface = Some("127.0.0.1".parse().unwrap());
    }
    UdpSender::open(&settings).unwrap()
}

/// Everything that is in the receiver's buffer now.
fn drain(receiver: &mut UdpReceiver) -> Vec<Vec<u8>> {
    let mut found = Vec::new();
    loop {
        let before = taken(receiver.counters());
        receiver
            .receive(Duration::ZERO, |datagram| found.push(datagram.bytes.to_vec()))
            .unwrap();
        if taken(receiver.counters()) == before {
            return found;
        }
    }
}

/// Datagrams that the kernel delivered.
fn taken(counters: ReceiverCounters) -> u64 {
    counters.datagrams + counters.refused_senders + counters.oversized + counters.empty + counters.unstamped
}

#[test]
fn a_datagram_arrives_whole_with_sender_and_time() {
    let mut receiver = open(&settings("127.0.0.1"));
    let other = UdpSocket::bind("127.0.0.1:0").unwrap();
    let mut stamps = Vec::new();
    for payload in [&b"first"[..], &[0xff; 20_000]] {
        other.send_to(payload, receiver.local_address()).unwrap();
        let visited = receiver.receive(PATIENCE, |datagram| {
            assert_eq!(datagram.bytes, payload);
            assert_eq!(datagram.sender, other.local_addr().unwrap());
            stamps.push(datagram.received_utc_ns);
        });
        assert_eq!(visited.unwrap(), 1);
    }
    let year_ns = 365 * 86_400 * 1_000_000_000_i64;
    assert!(
        stamps[0] > 50 * year_ns && stamps[0] < 200 * year_ns,
        "since 1970: {stamps:?}"
    );
    let expected = ReceiverCounters {
        datagrams: 2,
        octets: 20_005,
        ..ReceiverCounters::default()
    };
    assert_eq!(receiver.counters(), expected);
    assert_eq!(receiver.warning(), None);
}

#[test]
fn time_stamps_are_of_the_arrival_and_not_of_the_reading() {
    let (mut early, mut late) = (open(&settings("127.0.0.1")), open(&settings("127.0.0.1")));
    let mut senders = [sender_to(early.local_address()), sender_to(late.local_address())];
    // While the kernel is turning its stamping on, it stamps what is read; a machine that stamps so always never
    // passes.
    for _ in 0..10_000 {
        for sender in &mut senders {
            sender.send(b"in the order of sending").unwrap();
        }
        let stamp = |receiver: &mut UdpReceiver| {
            let mut stamp = 0;
            let visited = receiver.receive(PATIENCE, |datagram| stamp = datagram.received_utc_ns);
            assert_eq!(visited.unwrap(), 1);
            stamp
        };
        let read_first = stamp(&mut late);
        let read_last = stamp(&mut early);
        if read_last < read_first {
            return;
        }
    }
    panic!("the datagram that was sent first and read last is never the earlier one");
}

#[test]
fn nothing_to_receive_is_no_error() {
    let mut receiver = open(&settings("127.0.0.1"));
    let mut visited = |timeout| receiver.receive(timeout, |_| panic!("nobody sent")).unwrap();
    assert_eq!(visited(Duration::ZERO), 0);
    assert_eq!(visited(Duration::from_millis(1)), 0);
}

#[test]
fn one_call_takes_one_batch() {
    let mut receiver = open(&settings("127.0.0.1"));
    let mut sender = sender_to(receiver.local_address());
    for number in 0..BATCH_MAX as u8 + 5 {
        sender.send(&[number]).unwrap();
    }
    let mut numbers = Vec::new();
    let mut receive = || receiver.receive(PATIENCE, |datagram| numbers.push(datagram.bytes[0]));
    assert_eq!(receive().unwrap(), BATCH_MAX);
    assert_eq!(receive().unwrap(), 5);
    assert!(
        numbers.iter().copied().eq(0..BATCH_MAX as u8 + 5),
        "in order: {numbers:?}"
    );
    assert_eq!(sender.counters().sent, BATCH_MAX as u64 + 5);
}

#[test]
fn empty_and_oversized_datagrams_are_counted_and_harmless() {
    let mut receiver = open(&ReceiverSettings {
        datagram_octets_max: 100,
        ..settings("127.0.0.1")
    });
    let other = UdpSocket::bind("127.0.0.1:0").unwrap();
    for octets in [0, 100, 101, 60_000, 1] {
        other.send_to(&vec![7; octets], receiver.local_address()).unwrap();
    }
    let lengths: Vec<_> = drain(&mut receiver).iter().map(Vec::len).collect();
    assert_eq!(lengths, [100, 1]);
    let counters = receiver.counters();
    assert_eq!((counters.empty, counters.oversized, counters.octets), (1, 2, 101));
}

#[test]
fn the_longest_datagram_there_is_arrives() {
    let mut receiver = open(&settings("127.0.0.1"));
    let payload: Vec<u8> = (0..65_507_u32).map(|place| place as u8).collect();
    sender_to(receiver.local_address()).send(&payload).unwrap();
    assert_eq!(drain(&mut receiver), [payload]);
    assert!(
        sender_to(receiver.local_address()).send(&[0; 65_508]).is_err(),
        "longer than IPv4 allows"
    );
}

#[test]
fn senders_that_are_not_listed_are_refused() {
    let mut receiver = open(&ReceiverSettings {
        allowed_senders: AllowedSenders::parse(["127.0.1.0/24", "127.0.2.7"]).unwrap(),
        ..settings("127.0.0.1")
    });
    for from in ["127.0.1.1", "127.0.1.255", "127.0.2.7", "127.0.2.8", "127.0.0.1"] {
        let other = UdpSocket::bind((from, 0)).unwrap();
        other.send_to(from.as_bytes(), receiver.local_address()).unwrap();
    }
    assert_eq!(drain(&mut receiver), [&b"127.0.1.1"[..], b"127.0.1.255", b"127.0.2.7"]);
    assert_eq!(receiver.counters().refused_senders, 2);
}

#[test]
fn a_flood_from_elsewhere_holds_nobody_up() {
    let mut receiver = open(&ReceiverSettings {
        allowed_senders: AllowedSenders::parse(["127.0.0.1"]).unwrap(),
        ..settings("127.0.0.1")
    });
    let destination = receiver.local_address();
    let stop = AtomicBool::new(false);
    thread::scope(|scope| {
        let _stop = StopOnDrop(&stop);
        scope.spawn(|| {
            let flood = UdpSocket::bind("127.0.0.66:0").unwrap();
            while !stop.load(Ordering::Relaxed) {
                let _ = flood.send_to(&[0; 1000], destination);
            }
        });
        let mut sender = sender_to(destination);
        let mut calls_after_flood_began = 0;
        // The flood may fill the buffer at any moment, so the listed sender tries until it was heard several times.
        while receiver.counters().datagrams < 5 || calls_after_flood_began < 20 {
            sender.send(b"listed").unwrap();
            let before = taken(receiver.counters());
            receiver
                .receive(PATIENCE, |datagram| assert_eq!(datagram.bytes, b"listed"))
                .unwrap();
            assert!(taken(receiver.counters()) - before <= BATCH_MAX as u64);
            calls_after_flood_began += u32::from(receiver.counters().refused_senders > 0);
        }
    });
}

/// Ends the flood also when the test fails.
struct StopOnDrop<'a>(&'a AtomicBool);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[test]
fn what_the_kernel_drops_is_counted() {
    const SENT: u64 = 500;
    let mut receiver = open(&ReceiverSettings {
        receive_buffer_octets: 8_192,
        ..settings("127.0.0.1")
    });
    let mut sender = sender_to(receiver.local_address());
    let mut received = 0;
    for round in 1..=3 {
        for _ in 0..SENT {
            sender.send(&[1; 500]).unwrap();
        }
        received += drain(&mut receiver).len() as u64;
        assert!(received < round * SENT, "8 KiB do not hold {SENT} datagrams");
        // The count travels with a later datagram.
        sender.send(b"messenger").unwrap();
        assert_eq!(drain(&mut receiver), [b"messenger"]);
        assert_eq!(receiver.counters().kernel_drops, round * SENT - received);
    }
}

#[test]
fn a_buffer_that_the_kernel_cuts_down_gives_a_warning() {
    let limit = std::fs::read_to_string("/proc/sys/net/core/rmem_max").unwrap();
    let limit: usize = limit.trim().parse().unwrap();
    let receiver = |octets| {
        open(&ReceiverSettings {
            receive_buffer_octets: octets,
            ..settings("127.0.0.1")
        })
    };
    assert_eq!(receiver(8_192).receive_buffer_octets(), 8_192);
    assert_eq!(receiver(8_192).warning(), None);
    if limit >= 1 << 30 {
        println!("skipped the rest: this machine's net.core.rmem_max of {limit} octets cuts nothing down");
        return;
    }
    let small = receiver(1 << 30);
    assert_eq!(small.receive_buffer_octets(), limit);
    let warning = small.warning().unwrap();
    let remedy = format!("net.core.rmem_max={}", 1 << 30);
    assert!(
        warning.contains(&remedy) && warning.contains(&limit.to_string()),
        "{warning}"
    );
}

#[test]
fn every_reader_of_a_group_gets_every_datagram() {
    let mut first = open(&group_settings("239.255.17.1"));
    let port = first.local_address().port();
    let mut second = open(&ReceiverSettings {
        port,
        interface: Some(Interface::Address("127.0.0.1".parse().unwrap())),
        ..group_settings("239.255.17.1")
    });
    let mut sender = sender_to(first.local_address());
    sender.send(b"one").unwrap();
    sender.send(b"two").unwrap();
    for receiver in [&mut first, &mut second] {
        let mut senders = Vec::new();
        let visited = receiver.receive(PATIENCE, |datagram| senders.push(datagram.sender.ip()));
        assert_eq!(visited.unwrap(), 2);
        assert!(senders.iter().all(IpAddr::is_loopback), "{senders:?}");
    }
}

#[test]
fn groups_do_not_hear_each_other() {
    let mut first = open(&group_settings("239.255.17.2"));
    let mut second = open(&ReceiverSettings {
        port: first.local_address().port(),
        ..group_settings("239.255.17.3")
    });
    sender_to(first.local_address()).send(b"first").unwrap();
    sender_to(second.local_address()).send(b"second").unwrap();
    // Nor does a datagram to the port alone reach a group.
    let unicast = UdpSocket::bind("127.0.0.1:0").unwrap();
    let _ = unicast.send_to(b"nobody", ("127.0.0.1", first.local_address().port()));
    assert_eq!(drain(&mut first), [b"first"]);
    assert_eq!(drain(&mut second), [b"second"]);
}

#[test]
fn an_address_in_use_is_not_shared() {
    let first = open(&settings("127.0.0.1"));
    let error = UdpReceiver::open(&ReceiverSettings {
        port: first.local_address().port(),
        ..settings("127.0.0.1")
    })
    .unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains(&first.local_address().to_string()) && text.contains("end the process"),
        "{text}"
    );
}

#[test]
fn ipv6_works_alike() {
    let mut receiver = match UdpReceiver::open(&settings("::1")) {
        Ok(receiver) => receiver,
        Err(error @ NetError::Refused { .. }) => {
            println!("skipped: this machine has no IPv6 loopback ({error})");
            return;
        }
        Err(error) => panic!("{error}"),
    };
    let mut sender = sender_to(receiver.local_address());
    sender.send(b"over IPv6").unwrap();
    let visited = receiver.receive(PATIENCE, |datagram| {
        assert_eq!(datagram.bytes, b"over IPv6");
        assert!(datagram.sender.is_ipv6() && datagram.received_utc_ns > 0);
    });
    assert_eq!(visited.unwrap(), 1);
}

/// Machines route no IPv6 multicast over loopback, so what the kernel says of the membership must do.
#[test]
fn ipv6_groups_are_joined_on_their_interface() {
    // Memberships are the machine's: a group of its own for each run of this test.
    let group = Ipv6Addr::from(0xff11 << 112 | u128::from(std::process::id()));
    let listed = group.octets().map(|octet| format!("{octet:02x}")).concat();
    let memberships = || std::fs::read_to_string("/proc/net/igmp6").unwrap_or_default();
    let joined = || {
        let of_group = |line: &&str| line.contains(&listed);
        memberships().lines().find(of_group).map(str::to_owned)
    };
    if !memberships().contains(" lo ") {
        println!("skipped: this machine has no IPv6 on loopback");
        return;
    }
    assert_eq!(joined(), None);
    let receiver = open(&group_settings(&group.to_string()));
    assert!(joined().is_some_and(|line| line.contains(" lo ")), "{}", memberships());
    let local = receiver.local_address();
    assert!(
        matches!(local, SocketAddr::V6(local) if *local.ip() == group && local.scope_id() != 0),
        "{local}"
    );
    drop(receiver);
    assert_eq!(joined(), None, "left with the socket");
}

#[test]
fn nobody_listening_is_counted_and_a_listener_that_comes_misses_nothing() {
    let destination = open(&settings("127.0.0.1")).local_address();
    let mut sender = sender_to(destination);
    sender.send(b"to nobody").unwrap();
    sender.send(b"to nobody again").unwrap();
    let mut receiver = open(&ReceiverSettings {
        port: destination.port(),
        ..settings("127.0.0.1")
    });
    sender.send(b"to somebody").unwrap();
    assert_eq!(drain(&mut receiver), [b"to somebody"]);
    let counters = sender.counters();
    assert_eq!((counters.sent, counters.failed, counters.unheard), (3, 0, 2));
}

#[test]
fn what_cannot_be_sent_is_counted_and_the_next_goes_through() {
    let mut receiver = open(&settings("127.0.0.1"));
    let mut sender = sender_to(receiver.local_address());
    assert!(sender.send(&[0; 70_000]).is_err());
    sender.send(b"next").unwrap();
    assert_eq!(drain(&mut receiver), [b"next"]);
    let counters = sender.counters();
    assert_eq!((counters.sent, counters.octets, counters.failed), (1, 4, 1));
}

#[test]
fn settings_that_cannot_be_meant_are_refused_with_what_to_change() {
    let good = settings("127.0.0.1");
    let senders = |entry| AllowedSenders::parse([entry]).unwrap();
    for (bad, expected) in [
        (settings("239.255.17.9"), "name the interface"),
        (
            ReceiverSettings {
                interface: Some(Interface::Name("lo".to_owned())),
                ..good.clone()
            },
            "leave it out",
        ),
        (
            ReceiverSettings {
                allowed_senders: senders("::1"),
                ..good.clone()
            },
            "one is of IPv4",
        ),
        (
            ReceiverSettings {
                receive_buffer_octets: 100,
                ..good.clone()
            },
            "4096 to 1073741824",
        ),
        (
            ReceiverSettings {
                datagram_octets_max: 0,
                ..good.clone()
            },
            "1 to 65535",
        ),
        (
            ReceiverSettings {
                datagram_octets_max: 65_536,
                ..good.clone()
            },
            "1 to 65535",
        ),
        (
            ReceiverSettings {
                interface: Some(Interface::Name("nosuch0".to_owned())),
                ..settings("239.255.17.9")
            },
            "lo (127.0.0.1",
        ),
        (settings("203.0.113.77"), "`ip address`"),
    ] {
        let text = UdpReceiver::open(&bad).unwrap_err().to_string();
        assert!(text.contains(expected), "{text}");
    }
    for (destination, time_to_live, expected) in [
        ("127.0.0.1:0", None, "port above 0"),
        ("0.0.0.0:5000", None, "no destination"),
        ("127.0.0.1:5000", Some(0), "take 1"),
        ("239.255.17.9:5000", None, "name the interface"),
    ] {
        let mut settings = SenderSettings::new(destination.parse().unwrap());
        settings.time_to_live = time_to_live;
        let text = UdpSender::open(&settings).unwrap_err().to_string();
        assert!(text.contains(expected), "{text}");
    }
}

use super::*;

const S: i64 = 1_000_000_000;

const LIMITS: DoorLimits = DoorLimits {
    connections_max: 4,
    address_max: 3,
    ..DoorLimits::OF_SENDERS
};

fn peer(text: &str) -> Peer {
    Peer(Some(text.parse().unwrap()))
}

fn here(port: u16) -> Peer {
    Peer(Some(([127, 0, 0, 1], port).into()))
}

fn admit(door: &mut Door<u16>, now_ns: i64, port: u16) -> Result<Admitted<u16>, (DoorRefusal, u16)> {
    door.admit(here(port), now_ns, port)
}

#[test]
fn silent_connections_give_way_the_oldest_first_and_keep_nobody_out() {
    let mut door = Door::new(LIMITS);
    for port in 0..3 {
        assert_eq!(admit(&mut door, i64::from(port), port).unwrap().instead_of, None);
    }
    for port in 3..300 {
        assert_eq!(
            admit(&mut door, i64::from(port), port).unwrap().instead_of,
            Some((DoorRefusal::GaveWay, port - 3))
        );
    }
    let counters = door.counters();
    assert_eq!((counters.admitted, counters.refused(DoorRefusal::GaveWay)), (300, 297));
    assert_eq!(counters.last, Some((here(296), DoorRefusal::GaveWay)));
    assert_eq!(
        counters.to_string(),
        "gave-way 297; the last one: gave-way, 127.0.0.1:296"
    );
    assert_eq!(door.len(), 3);
}

#[test]
fn connections_that_send_stay_until_they_have_been_silent() {
    let mut door = Door::new(LIMITS);
    for port in 0..3 {
        let ticket = admit(&mut door, 0, port).unwrap().ticket;
        door.heard(ticket, i64::from(port) * S);
    }
    assert_eq!(admit(&mut door, 59 * S, 3).unwrap_err(), (DoorRefusal::Address, 3));
    // The first one has been silent for 60 s, the second one for 59 s.
    assert_eq!(
        admit(&mut door, 60 * S, 4).unwrap().instead_of,
        Some((DoorRefusal::Idle, 0))
    );
    // Beside it, the newest is the only one that has sent nothing.
    assert_eq!(
        admit(&mut door, 60 * S, 5).unwrap().instead_of,
        Some((DoorRefusal::GaveWay, 4))
    );
    assert_eq!(door.counters().refused(DoorRefusal::Idle), 1);
    assert_eq!(door.counters().all_refused(), 3);
}

#[test]
fn whoever_sends_nothing_whole_ends_in_time_and_whoever_falls_silent_later() {
    let mut door = Door::new(LIMITS);
    let ticket = admit(&mut door, 0, 1).unwrap().ticket;
    admit(&mut door, S, 2).unwrap();
    door.heard(ticket, 0);
    assert_eq!(door.expired(11 * S - 1), []);
    assert_eq!(door.expired(11 * S), [(DoorRefusal::Silent, 2)]);
    assert_eq!(door.expired(600 * S - 1), []);
    assert_eq!(door.expired(600 * S), [(DoorRefusal::Idle, 1)]);
    assert!(door.is_empty());
    assert_eq!(door.counters().last, Some((here(1), DoorRefusal::Idle)));
}

#[test]
fn places_in_all_and_of_an_address_are_apart_and_a_network_of_ipv6_is_one_address() {
    let mut door = Door::new(DoorLimits {
        address_max: 2,
        ..DoorLimits::OF_READERS
    });
    for (one, same, third, other) in [
        (
            "[2001:db8::1]:1",
            "[2001:db8::ffff:2]:1",
            "[2001:db8::3]:9",
            "[2001:db8:0:1::1]:1",
        ),
        ("192.0.2.1:1", "192.0.2.1:2", "[::ffff:192.0.2.1]:3", "192.0.2.2:1"),
        ("127.0.0.1:1", "127.0.0.1:2", "127.0.0.1:3", "127.0.0.2:3"),
    ] {
        for place in [one, same, other] {
            assert!(door.admit(peer(place), 0, 0).is_ok(), "{place}");
        }
        assert_eq!(
            door.admit(peer(third), 0, 0).unwrap_err().0,
            DoorRefusal::Address,
            "{third}"
        );
    }
    let mut door = Door::new(LIMITS);
    for host in 1..=4 {
        let ticket = door.admit(peer(&format!("192.0.2.{host}:1")), 0, host).unwrap().ticket;
        door.heard(ticket, 0);
    }
    assert_eq!(
        door.admit(peer("192.0.2.9:1"), 0, 9).unwrap_err(),
        (DoorRefusal::Full, 9)
    );
    door.leave(2);
    assert!(door.admit(peer("192.0.2.9:1"), 0, 9).is_ok());
}

#[test]
fn readers_neither_give_way_nor_expire_and_slow_ones_are_counted() {
    let mut door = Door::new(DoorLimits {
        connections_max: 2,
        ..DoorLimits::OF_READERS
    });
    for port in [1, 2] {
        admit(&mut door, 0, port).unwrap();
    }
    assert_eq!(admit(&mut door, 1000 * S, 3).unwrap_err(), (DoorRefusal::Full, 3));
    assert_eq!(door.expired(i64::MAX), []);
    door.retain(|port| match port {
        1 => Ok(Some(DoorRefusal::Slow)),
        _ => Err(Ended),
    });
    assert_eq!((door.len(), door.counters().refused(DoorRefusal::Slow)), (0, 1));
    assert_eq!(door.counters().last, Some((here(1), DoorRefusal::Slow)));
}

#[test]
fn every_reason_has_a_count_and_a_word_of_its_own() {
    for (place, reason) in DoorRefusal::ALL.into_iter().enumerate() {
        assert_eq!(reason as usize, place);
        let same = DoorRefusal::ALL
            .into_iter()
            .filter(|other| other.word() == reason.word());
        assert_eq!(same.count(), 1);
    }
}

//! Readers of a server of bytes: how many, and who.

use std::io::Read as _;
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::time::Duration;

use net::{DoorLimits, DoorRefusal, LineServer, Reach};
use socket2::{Domain, Socket, Type};

/// Longest wait of a test for what has to come.
const STEP: Duration = Duration::from_secs(5);

/// A reader whose own address is `from`.
fn reader(from: Ipv4Addr, to: SocketAddr) -> TcpStream {
    let socket = Socket::new(Domain::IPV4, Type::STREAM, None).unwrap();
    socket.bind(&SocketAddr::from((from, 0)).into()).unwrap();
    socket.connect(&to.into()).unwrap();
    let stream = TcpStream::from(socket);
    stream.set_read_timeout(Some(STEP)).unwrap();
    stream
}

#[test]
fn readers_of_one_address_leave_places_for_those_of_others_and_refusals_are_counted() {
    let mut server = LineServer::open("127.0.0.1:0".parse().unwrap(), Reach::OtherMachines).unwrap();
    let to = server.local_address().unwrap();
    let [one, other] = [1, 2].map(|host| Ipv4Addr::new(127, 0, 0, host));
    let limit = DoorLimits::OF_READERS.address_max;
    let mut readers: Vec<TcpStream> = (0..=limit).map(|_| reader(one, to)).collect();
    readers.push(reader(other, to));
    assert_eq!(server.news(0), None);
    // A connection may be a moment under way.
    let mut tries = 0;
    while server.counters().admitted + server.counters().all_refused() < readers.len() as u64 {
        server.accept().unwrap();
        tries += 1;
        assert!(tries < 5000);
        std::thread::sleep(Duration::from_millis(1));
    }
    server.send(b"line\n");
    let refused = readers.remove(limit);
    let refused_at = refused.local_addr().unwrap();
    assert_eq!((&refused).read(&mut [0; 5]).unwrap(), 0, "closed");
    for mut reader in readers {
        let mut line = [0; 5];
        reader.read_exact(&mut line).unwrap();
        assert_eq!(&line, b"line\n");
    }
    let counters = server.news(0).unwrap();
    assert_eq!(counters.refused(DoorRefusal::Address), 1);
    assert_eq!(
        counters.to_string(),
        format!("too-many-of-address 1; the last one: too-many-of-address, {refused_at}")
    );
    assert_eq!(server.news(i64::MAX), None, "reported once");
}

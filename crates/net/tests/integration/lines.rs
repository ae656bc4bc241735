//! Lines from servers that behave, hang up, fall silent, or never end a line.
//!
//! The client is told the time, so pauses pass as soon as a test says so. Each test of each run has an address of its
//! own in 127.0.0.0/8, so that no other one can take a port that it gives up for a while.

use std::io::Write;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::time::Duration;

use net::{LinesSettings, TcpLines};
use rustix::event::{PollFd, PollFlags, poll};
use socket2::{Domain, Socket, Type};
use test_support::S;

/// How long a call may wait for the other end of a loopback connection.
const STEP: Duration = Duration::from_secs(5);
/// Calls after which a test that has got nowhere gives up.
const CALLS_MAX: usize = 100;

struct Client {
    lines: TcpLines,
    now_ns: i64,
    found: Vec<String>,
}

impl Client {
    fn new(settings: LinesSettings) -> Self {
        Self {
            lines: TcpLines::new(settings).unwrap(),
            now_ns: 0,
            found: Vec::new(),
        }
    }

    fn poll(&mut self, timeout: Duration) -> usize {
        let found = &mut self.found;
        let keep = |line: &[u8]| found.push(String::from_utf8_lossy(line).into_owned());
        self.lines.poll(self.now_ns, timeout, keep)
    }

    /// Polls until `condition` holds.
    fn until(&mut self, what: &str, condition: impl Fn(&Self) -> bool) {
        for _ in 0..CALLS_MAX {
            if condition(self) {
                return;
            }
            self.poll(STEP);
        }
        panic!("{what}: {:?} {:?}", self.lines, self.found);
    }

    fn connect(&mut self, listener: &TcpListener) -> TcpStream {
        self.until("no connection", |client| client.lines.is_connected());
        listener.accept().unwrap().0
    }
}

fn settings(server: SocketAddr) -> LinesSettings {
    LinesSettings {
        pause_min: Duration::from_secs(1),
        pause_max: Duration::from_secs(4),
        line_octets_max: Some(100),
        ..LinesSettings::new(server)
    }
}

/// An address of this process and of the test with a number from 1.
fn own_address(test: u8) -> IpAddr {
    let [.., high, low] = std::process::id().to_be_bytes();
    Ipv4Addr::new(127, high, low, test).into()
}

fn listen(test: u8) -> (TcpListener, SocketAddr) {
    let listener = TcpListener::bind((own_address(test), 0)).unwrap();
    let address = listener.local_addr().unwrap();
    (listener, address)
}

#[test]
fn lines_arrive_whole_however_they_were_sent() {
    let (listener, address) = listen(1);
    let mut client = Client::new(settings(address));
    let mut server = client.connect(&listener);
    server.write_all(b"MSG,1\r\nMSG,2\r\n\r\nMS").unwrap();
    client.until("two lines", |client| client.found.len() == 2);
    server.write_all(b"G,3\n").unwrap();
    client.until("the third line", |client| client.found.len() == 3);
    assert_eq!(client.found, ["MSG,1", "MSG,2", "MSG,3"]);
    let counters = client.lines.counters();
    assert_eq!((counters.lines, counters.octets, counters.connections), (3, 22, 1));
}

#[test]
fn nothing_to_read_waits_no_longer_than_allowed() {
    let (listener, address) = listen(2);
    let mut client = Client::new(settings(address));
    let _server = client.connect(&listener);
    assert_eq!(client.poll(Duration::ZERO), 0);
    assert_eq!(client.poll(Duration::from_millis(1)), 0);
    assert!(client.lines.is_connected());
}

#[test]
fn a_server_that_dies_is_found_again_when_it_comes_back() {
    let (listener, address) = listen(3);
    let mut client = Client::new(settings(address));
    let mut server = client.connect(&listener);
    server.write_all(b"before\nhalf a li").unwrap();
    client.until("a line", |client| client.found.len() == 1);
    drop((server, listener));
    client.until("the loss", |client| client.lines.counters().lost_connections == 1);
    assert_eq!(client.lines.counters().cut, 1);

    // Down: every attempt fails, after pauses of 1, 2, 4, 4, ... seconds.
    for (failures, pause_s) in [(1, 1), (2, 2), (3, 4), (4, 4)] {
        client.poll(Duration::ZERO);
        client.now_ns += pause_s * S - 1;
        client.poll(Duration::ZERO);
        assert_eq!(
            client.lines.counters().failed_attempts,
            failures - 1,
            "not before the pause is over"
        );
        client.now_ns += 1;
        client.until("a failure", |client| {
            client.lines.counters().failed_attempts == failures
        });
    }

    let listener = TcpListener::bind(address).unwrap();
    client.poll(Duration::ZERO);
    client.now_ns += 4 * S;
    let mut server = client.connect(&listener);
    server.write_all(b"ne after\nafter\n").unwrap();
    client.until("lines after", |client| client.found.len() == 3);
    assert_eq!(client.found, ["before", "ne after", "after"]);
    assert_eq!(client.lines.counters().connections, 2);

    // A line has come, so the pauses start over.
    drop(server);
    client.until("the second loss", |client| {
        client.lines.counters().lost_connections == 2
    });
    client.poll(Duration::ZERO);
    client.now_ns += S;
    client.connect(&listener);
}

#[test]
fn a_server_that_only_hangs_up_is_asked_less_and_less_often() {
    let (listener, address) = listen(4);
    let mut client = Client::new(settings(address));
    for (losses, pause_s) in [(1, 1), (2, 2), (3, 4), (4, 4)] {
        drop(client.connect(&listener));
        client.until("the loss", |client| client.lines.counters().lost_connections == losses);
        client.poll(Duration::ZERO);
        client.now_ns += pause_s * S - 1;
        client.poll(Duration::ZERO);
        client.poll(Duration::ZERO);
        assert!(!client.lines.is_connected(), "before {pause_s} s were over");
        client.now_ns += 1;
    }
}

#[test]
fn a_silent_connection_is_given_up() {
    let (listener, address) = listen(5);
    let mut client = Client::new(settings(address));
    let mut server = client.connect(&listener);
    client.poll(Duration::ZERO);
    client.now_ns += 59 * S;
    server.write_all(b"still there\n").unwrap();
    client.until("a line", |client| client.found.len() == 1);
    client.poll(Duration::ZERO);
    client.now_ns += 59 * S;
    client.poll(Duration::ZERO);
    assert!(client.lines.is_connected(), "silence counts from the last octet");
    client.now_ns += S;
    client.poll(STEP);
    assert!(!client.lines.is_connected());
    assert_eq!(client.lines.counters().silent_connections, 1);
    client.poll(Duration::ZERO);
    client.now_ns += S;
    client.connect(&listener);
}

#[test]
fn a_line_that_never_ends_is_passed_over() {
    let (listener, address) = listen(6);
    let mut client = Client::new(settings(address));
    let mut server = client.connect(&listener);
    server.write_all(b"first\n").unwrap();
    let endless = vec![b'x'; 100_000];
    for octets in (1..=20).map(|round| 6 + round * 100_000) {
        // More than the sockets hold, so that it is read while it is written.
        server.write_all(&endless).unwrap();
        client.until("the octets", |client| client.lines.counters().octets == octets);
    }
    assert_eq!(client.lines.counters().oversized, 1);
    server.write_all(b"\nlast\n").unwrap();
    client.until("the last line", |client| client.found.len() == 2);
    assert_eq!(client.found, ["first", "last"]);
    let counters = client.lines.counters();
    assert_eq!((counters.oversized, counters.cut), (1, 0));
}

#[test]
fn an_attempt_that_takes_too_long_is_given_up() {
    // A listener that has room for one waiting connection answers nobody else.
    let listener = Socket::new(Domain::IPV4, Type::STREAM, None).unwrap();
    listener.bind(&SocketAddr::new(own_address(7), 0).into()).unwrap();
    listener.listen(0).unwrap();
    let address = listener.local_addr().unwrap().as_socket().unwrap();
    let _waiting = TcpStream::connect(address).unwrap();
    let mut descriptors = [PollFd::new(&listener, PollFlags::IN)];
    poll(&mut descriptors, None).unwrap();

    let mut client = Client::new(settings(address));
    client.poll(Duration::ZERO);
    client.poll(Duration::ZERO);
    client.now_ns += 5 * S - 1;
    client.poll(Duration::ZERO);
    assert_eq!(client.lines.counters().failed_attempts, 0);
    client.now_ns += 1;
    client.poll(STEP);
    assert_eq!(client.lines.counters().failed_attempts, 1);
    assert!(!client.lines.is_connected());
}

#[test]
fn settings_that_cannot_be_meant_are_refused() {
    let good = settings("127.0.17.8:30003".parse().unwrap());
    let zero = Duration::ZERO;
    for (bad, expected) in [
        (settings("127.0.17.8:0".parse().unwrap()), "no server"),
        (settings("239.255.17.9:30003".parse().unwrap()), "no server"),
        (
            LinesSettings {
                connect_max: zero,
                ..good
            },
            "longest attempt",
        ),
        (
            LinesSettings {
                pause_max: zero,
                ..good
            },
            "at least the shortest pause, 1s",
        ),
        (
            LinesSettings {
                silence_max: zero,
                ..good
            },
            "longest silence",
        ),
        (
            LinesSettings {
                line_octets_max: Some(0),
                ..good
            },
            "1 to 1048576",
        ),
        (
            LinesSettings {
                line_octets_max: Some(2 << 20),
                ..good
            },
            "1 to 1048576",
        ),
    ] {
        let text = TcpLines::new(bad).unwrap_err().to_string();
        assert!(text.contains(expected), "{text}");
    }
}

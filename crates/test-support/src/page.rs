//! Tests for any server of metrics, independent of its implementation.

use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

/// Longest time for which bad clients may hold up an honest one: collectors give up after ten seconds.
const HELD_UP_MAX: Duration = Duration::from_secs(4);
/// How long a client waits before it fails the test.
const PATIENCE: Duration = Duration::from_secs(60);

/// A running server of one page, [`Served::TEXT`], at [`Served::PATH`], which may also be asked for as
/// [`Served::HOST`].
#[derive(Debug)]
pub struct Served {
    /// Address of the server, on the loopback interface.
    pub address: SocketAddr,
}

impl Served {
    /// Path of the page.
    pub const PATH: &str = "/page";
    /// Its text.
    pub const TEXT: &str = "What there is.\n";
    /// Its type.
    pub const CONTENT_TYPE: &str = "text/plain; version=1";
    /// A configured name of the server.
    pub const HOST: &str = "metrics.example";

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.set_nodelay(true).unwrap();
        stream
    }

    /// The answer to `request`, each part of which is sent by itself.
    fn answer(&self, request: &[&[u8]]) -> String {
        let mut stream = self.connect();
        for part in request {
            stream.write_all(part).unwrap();
        }
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    /// Fails if the page is not collected, or not in time.
    fn collect(&self) {
        let begin = Instant::now();
        let answer = self.answer(&[format!("GET /page HTTP/1.1\r\nHost: {}\r\n\r\n", self.address).as_bytes()]);
        assert!(
            answer.starts_with("HTTP/1.1 200 OK\r\n") && answer.ends_with(Self::TEXT),
            "{answer}"
        );
        assert!(begin.elapsed() < HELD_UP_MAX, "held up for {:?}", begin.elapsed());
    }
}

/// Fails if `server` does not keep the contract of a page of metrics.
pub fn check(server: &Served) {
    the_page_is_served_whole(server);
    everything_else_is_refused(server);
    only_the_own_names_are_answered_to(server);
    bad_clients_hold_up_nobody(server);
}

fn the_page_is_served_whole(server: &Served) {
    let parts: [&[u8]; 3] = [b"GET /page?x=1 HTTP/1.1\r\nHo", b"st: localhost\r\n", b"\r\n"];
    let answer = server.answer(&parts);
    let (head, text) = answer.split_once("\r\n\r\n").unwrap();
    assert_eq!(text, Served::TEXT);
    let head = head.to_ascii_lowercase() + "\r\n";
    assert!(head.starts_with("http/1.1 200 ok\r\n"), "{head}");
    for line in [
        format!("content-type: {}", Served::CONTENT_TYPE),
        format!("content-length: {}", Served::TEXT.len()),
        "connection: close".to_owned(),
    ] {
        assert!(head.contains(&format!("\r\n{line}\r\n")), "{head}");
    }
    assert!(!head.contains("access-control"), "{head}");
    let head = server.answer(&[b"HEAD /page HTTP/1.0\r\n\r\n"]);
    assert!(
        head.starts_with("HTTP/1.0 200 OK\r\n") && head.ends_with("\r\n\r\n"),
        "{head}"
    );
}

fn everything_else_is_refused(server: &Served) {
    for (request, status) in [
        (&b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"[..], "404 Not Found"),
        (
            b"GET /page/../etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n",
            "404 Not Found",
        ),
        (
            b"POST /page HTTP/1.1\r\nHost: localhost\r\n\r\n",
            "405 Method Not Allowed",
        ),
        (b"GET /page HTTP/1.1\r\n\r\n", "400 Bad Request"),
        (
            b"GET /page HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n\r\n",
            "400 Bad Request",
        ),
        (b"\x16\x03\x01 nonsense\r\n\r\n", "400 Bad Request"),
        (&[b'A'; 8192], "4"),
    ] {
        let answer = server.answer(&[request]);
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")), "{answer}");
    }
}

fn only_the_own_names_are_answered_to(server: &Served) {
    let port = server.address.port();
    for (host, is_own) in [
        ("localhost".to_owned(), true),
        (format!("LocalHost:{port}"), true),
        (format!("127.0.0.1:{port}"), true),
        (format!("[::1]:{port}"), true),
        (format!("{}:{port}", Served::HOST), true),
        ("evil.example".to_owned(), false),
        (format!("evil.example:{port}"), false),
        ("localhost.evil.example".to_owned(), false),
        (format!("{}.evil.example", Served::HOST), false),
        ("localhost:80@evil.example".to_owned(), false),
        ("192.0.2.1".to_owned(), false),
        (String::new(), false),
    ] {
        let answer = server.answer(&[format!("GET /page HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes()]);
        assert_eq!(answer.starts_with("HTTP/1.1 200 OK\r\n"), is_own, "{host}: {answer}");
        assert_eq!(answer.contains(Served::TEXT), is_own, "{host}");
    }
}

fn bad_clients_hold_up_nobody(server: &Served) {
    // Silent clients, more than there is room for, and clients that send byte by byte.
    let silent: Vec<TcpStream> = (0..100).map(|_| server.connect()).collect();
    server.collect();
    let mut dripping: Vec<TcpStream> = (0..5).map(|_| server.connect()).collect();
    for octet in b"GET /page HTTP/1" {
        for client in &mut dripping {
            // It may have been turned away.
            let _ = client.write_all(&[*octet]);
        }
        server.collect();
    }
    drop((silent, dripping));
    // Some that ask and do not read.
    let deaf: Vec<TcpStream> = (0..100)
        .map(|_| {
            let mut client = server.connect();
            let _ = client.write_all(b"GET /page HTTP/1.1\r\nHost: localhost\r\n\r\n");
            client
        })
        .collect();
    server.collect();
    drop(deaf);
    // A thousand, of which as many stay as this process can hold beside others.
    let mut held = std::collections::VecDeque::new();
    for _ in 0..1_000 {
        held.push_back(server.connect());
        if held.len() > 300 {
            held.pop_front();
        }
    }
    server.collect();
}

//! A server under all that clients do to it.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use test_support::page::{Served, check};
use web::axum::Router;
use web::axum::body::{Body, Bytes};
use web::axum::http::header::CONTENT_TYPE;
use web::axum::response::Response;
use web::axum::routing::get;
use web::tokio::time::sleep;
use web::{CONNECTIONS_MAX, Guard, LongAnswer, PATIENCE, RequestRefusal, Server};

fn server() -> Server {
    let page = get(|| async { ([(CONTENT_TYPE, Served::CONTENT_TYPE)], Served::TEXT) });
    let guard = Guard {
        hosts: vec![Served::HOST.to_owned()],
        ..Guard::default()
    };
    let router = Router::new().route(Served::PATH, page);
    Server::start("page", "127.0.0.1:0".parse().unwrap(), guard, router).unwrap()
}

#[test]
fn it_is_served_as_a_page_of_metrics_must_be() {
    let server = server();
    check(&Served {
        address: server.address(),
    });
    for refusal in [
        RequestRefusal::Host,
        RequestRefusal::Method,
        RequestRefusal::Malformed,
        RequestRefusal::Full,
    ] {
        assert!(server.counts().of(refusal) > 0, "{refusal:?}");
    }
}

#[test]
fn every_answer_says_what_browsers_may_do_with_it() {
    let server = server();
    for path in [Served::PATH, "/nothing"] {
        let mut stream = TcpStream::connect(server.address()).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let answer = answer.to_ascii_lowercase();
        assert!(
            answer.contains("content-security-policy: default-src 'self'; "),
            "{answer}"
        );
        assert!(answer.contains("x-content-type-options: nosniff"), "{answer}");
        assert!(!answer.contains("access-control"), "{answer}");
    }
}

fn answer(server: &Server, request: &str) -> String {
    let mut stream = TcpStream::connect(server.address()).unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

#[test]
fn a_browser_shows_the_token_once_and_is_sent_on() {
    let guard = Guard {
        hosts: Vec::new(),
        token: Some("0123456789abcdef".to_owned()),
        ..Guard::default()
    };
    let router = Router::new().route("/", get(|| async { "the picture" }));
    let server = Server::start("page", "127.0.0.1:0".parse().unwrap(), guard, router).unwrap();
    let ask = |path: &str, more: &str| {
        answer(
            &server,
            &format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n{more}\r\n"),
        )
    };
    for path in ["/", "/?token=", "/?token=0123456789abcdeg", "/nothing"] {
        assert!(ask(path, "").starts_with("HTTP/1.1 403"), "{path}");
    }
    assert_eq!(server.counts().of(RequestRefusal::Token), 4);
    let sent_on = ask("/?token=0123456789abcdef", "");
    assert!(sent_on.starts_with("HTTP/1.1 303"), "{sent_on}");
    let line = |name: &str| sent_on.lines().find_map(|line| line.strip_prefix(name)).unwrap();
    assert_eq!(line("location: "), "/");
    let cookie = line("set-cookie: ").split(';').next().unwrap();
    let shown = ask("/", &format!("Cookie: {cookie}\r\n"));
    assert!(
        shown.starts_with("HTTP/1.1 200") && shown.ends_with("the picture"),
        "{shown}"
    );
    assert!(ask("/", "Cookie: koseki_token=0123456789abcdeg\r\n").starts_with("HTTP/1.1 403"));
    assert_eq!(server.counts().of(RequestRefusal::Token), 5);
}

#[test]
fn of_a_thousand_connections_that_say_nothing_the_oldest_give_way() {
    let server = server();
    let mut silent = std::collections::VecDeque::new();
    for _ in 0..1_000 {
        silent.push_back(TcpStream::connect(server.address()).unwrap());
        // As many as the server holds need not be held here.
        if silent.len() > 2 * CONNECTIONS_MAX {
            silent.pop_front();
        }
    }
    let shown = answer(&server, "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
    assert!(shown.starts_with("HTTP/1.1 404"), "there is still an answer: {shown}");
    // All came before the one that was answered, and those that the client closed had to be found out.
    let mut gone = silent.pop_front().unwrap();
    assert!(!matches!(gone.read(&mut [0]), Ok(1..)), "the oldest is closed");
    assert!(server.counts().of(RequestRefusal::Full) > 0);
}

#[test]
fn an_address_in_use_is_named_with_a_remedy() {
    let server = server();
    let error = web::listen(server.address()).unwrap_err().to_string();
    let named = error.contains(&server.address().to_string()) && error.contains("ss -ltnp");
    assert!(named, "{error}");
}

/// Server of an answer without end: a mebibyte at a time.
fn endless() -> Server {
    let body = || {
        futures_util::stream::unfold((), |()| async {
            sleep(Duration::from_millis(20)).await;
            Some((Ok::<_, std::io::Error>(Bytes::from_static(&[b'x'; 1 << 20])), ()))
        })
    };
    let page = get(move || async move {
        let mut answer = Response::new(Body::from_stream(body()));
        answer.extensions_mut().insert(LongAnswer);
        answer
    });
    let router = Router::new().route("/endless", page);
    Server::start("page", "127.0.0.1:0".parse().unwrap(), Guard::default(), router).unwrap()
}

#[test]
fn an_answer_without_end_lasts_as_long_as_its_client_reads() {
    let server = endless();
    let ask = || {
        let mut stream = TcpStream::connect(server.address()).unwrap();
        stream
            .write_all(b"GET /endless HTTP/1.1\r\nHost: localhost\r\n\r\n")
            .unwrap();
        stream
    };
    let (mut reads, mut waits) = (ask(), ask());
    let (begun, mut octets) = (Instant::now(), vec![0; 1 << 20]);
    while begun.elapsed() < 2 * PATIENCE || server.counts().of(RequestRefusal::Slow) == 0 {
        assert!(reads.read(&mut octets).unwrap() > 0, "the reader is not dropped");
    }
    assert_eq!(server.counts().total(), 1);
    // What waits in the system's buffers is still there, then comes the end.
    loop {
        match waits.read(&mut octets) {
            Ok(0) | Err(_) => break,
            Ok(_) => {}
        }
    }
}

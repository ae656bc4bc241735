//! A server under all that clients do to it.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;

use test_support::page::{Served, check};
use web::axum::Router;
use web::axum::http::header::CONTENT_TYPE;
use web::axum::routing::get;
use web::{Guard, Refusal, Server};

fn server() -> Server {
    let page = get(|| async { ([(CONTENT_TYPE, Served::CONTENT_TYPE)], Served::TEXT) });
    let guard = Guard {
        hosts: vec![Served::HOST.to_owned()],
        token: None,
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
    for refusal in [Refusal::Host, Refusal::Method, Refusal::Malformed, Refusal::Full] {
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

#[test]
fn an_address_in_use_is_named_with_a_remedy() {
    let server = server();
    let error = web::listen(server.address()).unwrap_err().to_string();
    let named = error.contains(&server.address().to_string()) && error.contains("ss -ltnp");
    assert!(named, "{error}");
}

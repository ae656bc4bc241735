//! The page of metrics, under all that clients do to it.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use net::PageServer;
use test_support::page::{Served, check};

/// The server on a thread, as the monitor has it.
struct OnThread {
    address: SocketAddr,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl OnThread {
    fn start() -> Self {
        let address = "127.0.0.1:0".parse().unwrap();
        let server = PageServer::open(address, Served::PATH, Served::CONTENT_TYPE).unwrap();
        let mut server = server.with_hosts(vec![Served::HOST.to_owned()]);
        let address = server.local_address().unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let of_thread = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            while !of_thread.load(Ordering::Relaxed) {
                let text = || Served::TEXT.to_owned();
                server.serve(Duration::from_millis(20), Instant::now, text).unwrap();
            }
        });
        let thread = Some(thread);
        Self { address, stop, thread }
    }
}

impl Drop for OnThread {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.take().unwrap().join().unwrap();
    }
}

#[test]
fn it_is_served_as_a_page_of_metrics_must_be() {
    let server = OnThread::start();
    check(&Served {
        address: server.address,
    });
}

#[test]
fn time_and_number_of_connections_are_limited() {
    let mut server = PageServer::open("127.0.0.1:0".parse().unwrap(), "/page", "text/plain").unwrap();
    let address = server.local_address().unwrap();
    let page = || panic!("nobody asked for it");
    let begin = Instant::now();
    let silent = std::net::TcpStream::connect(address).unwrap();
    while server.is_idle() {
        server.serve(Duration::from_secs(1), || begin, page).unwrap();
    }
    server
        .serve(Duration::ZERO, || begin + net::PAGE_PATIENCE / 2, page)
        .unwrap();
    assert!(!server.is_idle());
    server
        .serve(Duration::from_secs(60), || begin + net::PAGE_PATIENCE, page)
        .unwrap();
    assert!(server.is_idle(), "its time is over, whatever it does");
    drop(silent);
}

#[test]
fn an_address_in_use_is_named_with_a_remedy() {
    let server = OnThread::start();
    let error = PageServer::open(server.address, "/page", "text/plain")
        .unwrap_err()
        .to_string();
    assert!(
        error.contains(&server.address.to_string()) && error.contains("ss -ltunp"),
        "{error}"
    );
}

//! A relay between two hosts: what passes is late by a time that wavers, and it can be cut.

use std::collections::VecDeque;
use std::io::{Read as _, Write as _};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::thread;
use std::time::{Duration, Instant};

/// Delays of a relay.
#[derive(Clone, Copy)]
pub(crate) struct Delays {
    /// Mean time that everything takes.
    pub(crate) mean: Duration,
    /// How far it wavers to either side.
    pub(crate) jitter: Duration,
}

impl Delays {
    pub(crate) const NONE: Self = Self {
        mean: Duration::ZERO,
        jitter: Duration::ZERO,
    };
}

/// A relay, until the test ends.
pub(crate) struct Relay {
    port: u16,
    state: Arc<Mutex<State>>,
}

#[derive(Default)]
struct State {
    is_cut: bool,
    connections: Vec<TcpStream>,
}

fn lock(state: &Mutex<State>) -> MutexGuard<'_, State> {
    state.lock().unwrap()
}

impl Relay {
    /// Relays connections from a port of its own to `port`.
    pub(crate) fn to(port: u16, delays: Delays) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let own = listener.local_addr().unwrap().port();
        let state = Arc::new(Mutex::new(State::default()));
        let of_thread = Arc::clone(&state);
        thread::spawn(move || {
            for near in listener.incoming() {
                let Ok(near) = near else { return };
                let mut state = lock(&of_thread);
                // Whoever asks before the other side is there asks again.
                let Ok(far) = TcpStream::connect(("127.0.0.1", port)) else {
                    continue;
                };
                if state.is_cut {
                    continue;
                }
                state
                    .connections
                    .extend([near.try_clone().unwrap(), far.try_clone().unwrap()]);
                pass(near.try_clone().unwrap(), far.try_clone().unwrap(), delays, 1);
                pass(far, near, delays, 2);
            }
        });
        Self { port: own, state }
    }

    pub(crate) fn port(&self) -> u16 {
        self.port
    }

    /// Ends all connections, and lets none through.
    pub(crate) fn cut(&self) {
        let mut state = lock(&self.state);
        state.is_cut = true;
        for connection in state.connections.drain(..) {
            let _ = connection.shutdown(Shutdown::Both);
        }
    }

    pub(crate) fn mend(&self) {
        lock(&self.state).is_cut = false;
    }
}

type Waiting = Arc<(Mutex<VecDeque<(Instant, Vec<u8>)>>, Condvar)>;

fn pass(mut from: TcpStream, mut to: TcpStream, delays: Delays, seed: u64) {
    let waiting = Waiting::default();
    let read = Arc::clone(&waiting);
    thread::spawn(move || {
        let mut octets = vec![0; 1 << 16];
        let mut random = seed;
        let mut last = Instant::now();
        loop {
            let count = from.read(&mut octets).unwrap_or(0);
            // A generator of Knuth's: how late each piece is must be the same in each run.
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let share = (random >> 40) as f64 / (1u64 << 24) as f64;
            let delay = delays.mean - delays.jitter + delays.jitter.mul_f64(2.0 * share);
            // In order: it is one stream.
            last = last.max(Instant::now() + delay);
            read.0.lock().unwrap().push_back((last, octets[..count].to_vec()));
            read.1.notify_one();
            if count == 0 {
                return;
            }
        }
    });
    thread::spawn(move || {
        loop {
            let mut queue = waiting.0.lock().unwrap();
            while queue.is_empty() {
                queue = waiting.1.wait(queue).unwrap();
            }
            let Some((due, octets)) = queue.pop_front() else {
                continue;
            };
            drop(queue);
            thread::sleep(due.saturating_duration_since(Instant::now()));
            if octets.is_empty() || to.write_all(&octets).is_err() {
                let _ = to.shutdown(Shutdown::Both);
                return;
            }
        }
    });
}

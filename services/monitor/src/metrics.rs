//! Serves the metrics, on a thread of its own.
//!
//! The monitor hands over what it knows at the end of each interval; whoever asks gets the latest of that. So however
//! often, slowly or wrongly somebody asks, the monitor's own work is not touched: the two share a pointer, which is
//! held for as long as it takes to copy it.

use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::Context as _;
use net::PageServer;
use runtime::clock;

use crate::exposition::{CONTENT_TYPE, Snapshot};

const PATH: &str = "/metrics";
/// Longest wait for a client before looking whether it is time to stop.
const PATIENCE: Duration = Duration::from_millis(100);
/// Looks at clients at the end, if some had come by then that are not answered yet.
const LAST_LOOKS: usize = 20;
/// How long the last client may take at the end, and the pause between two looks.
const END_PATIENCE: Duration = Duration::from_secs(2);
const END_PAUSE: Duration = Duration::from_millis(5);

/// Page of metrics.
#[derive(Debug)]
pub(crate) struct Metrics {
    address: SocketAddr,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    latest: Mutex<Arc<Snapshot>>,
    stop: AtomicBool,
}

impl Shared {
    fn latest(&self) -> MutexGuard<'_, Arc<Snapshot>> {
        // Nothing that is done while it is held can panic.
        self.latest.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn text(&self) -> String {
        let latest = Arc::clone(&self.latest());
        Snapshot::clone(&latest).text()
    }
}

impl Metrics {
    /// Serves at `address`, which may also be asked for as one of `hosts`, at first what is in `begin`.
    ///
    /// # Errors
    /// If the address cannot be listened at: it is taken, say, by another monitor.
    pub(crate) fn serve(address: SocketAddr, hosts: &[String], begin: Snapshot) -> anyhow::Result<Self> {
        let server = PageServer::open(address, PATH, CONTENT_TYPE).context("monitor.prometheus")?;
        let mut server = server.with_hosts(hosts.to_vec());
        let address = server.local_address().context("monitor.prometheus")?;
        let shared = Arc::new(Shared {
            latest: Mutex::new(Arc::new(begin)),
            stop: AtomicBool::new(false),
        });
        let of_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("metrics".to_owned())
            .spawn(move || answer(&mut server, &of_thread))
            .context("starting the thread that serves metrics")?;
        Ok(Self {
            address,
            shared,
            thread: Some(thread),
        })
    }

    /// Where they are.
    pub(crate) fn url(&self) -> String {
        format!("http://{}{PATH}", self.address)
    }

    /// From now on, this is served.
    pub(crate) fn hand_over(&self, snapshot: Snapshot) {
        let snapshot = Arc::new(snapshot);
        let before = std::mem::replace(&mut *self.shared.latest(), snapshot);
        // Not while it is held.
        drop(before);
    }
}

impl Drop for Metrics {
    /// Whoever had asked by now is answered, unless that takes too long.
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        let Some(thread) = self.thread.take() else { return };
        let looks = END_PATIENCE.as_millis() / END_PAUSE.as_millis();
        for _ in 0..looks {
            if thread.is_finished() {
                let _ = thread.join();
                return;
            }
            std::thread::sleep(END_PAUSE);
        }
    }
}

fn answer(server: &mut PageServer, shared: &Shared) {
    let mut last_looks = LAST_LOOKS;
    while last_looks > 0 {
        let stop = shared.stop.load(Ordering::Relaxed);
        let patience = if stop { END_PAUSE } else { PATIENCE };
        if server.serve(patience, clock::instant, || shared.text()).is_err() {
            // The system cannot wait for a socket. Without metrics, the monitor is still a monitor.
            return;
        }
        // Whoever had come by then is accepted in the first of these looks, and answered in the next two.
        if stop {
            last_looks = if server.is_idle() { 0 } else { last_looks - 1 };
        }
    }
}

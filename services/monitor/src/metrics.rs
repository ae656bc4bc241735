//! Serves the metrics, on a thread of its own.
//!
//! The monitor hands over what it knows at the end of each interval; whoever asks gets the latest of that. So however
//! often, slowly or wrongly somebody asks, the monitor's own work is not touched: the two share a pointer, which is
//! held for as long as it takes to copy it.

use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use anyhow::Context as _;
use web::axum::Router;
use web::axum::http::header::CONTENT_TYPE;
use web::axum::routing::get;
use web::{Guard, Server};

use crate::exposition::{self, Snapshot};

const PATH: &str = "/metrics";

/// Page of metrics.
#[derive(Debug)]
pub(crate) struct Metrics {
    server: Server,
    latest: Arc<Latest>,
}

#[derive(Debug)]
struct Latest(Mutex<Arc<Snapshot>>);

impl Latest {
    fn lock(&self) -> MutexGuard<'_, Arc<Snapshot>> {
        // Nothing that is done while it is held can panic.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn text(&self) -> String {
        let latest = Arc::clone(&self.lock());
        Snapshot::clone(&latest).text()
    }
}

impl Metrics {
    /// Serves at `address`, which may also be asked for as one of `hosts`, at first what is in `begin`.
    ///
    /// # Errors
    /// If the address cannot be listened at: it is taken, say, by another monitor.
    pub(crate) fn serve(address: SocketAddr, hosts: &[String], begin: Snapshot) -> anyhow::Result<Self> {
        let latest = Arc::new(Latest(Mutex::new(Arc::new(begin))));
        let of_server = Arc::clone(&latest);
        let page = get(move || async move { ([(CONTENT_TYPE, exposition::CONTENT_TYPE)], of_server.text()) });
        let elsewhere = format!("There is nothing here but {PATH}.\n");
        let elsewhere = || async { (web::axum::http::StatusCode::NOT_FOUND, elsewhere) };
        let guard = Guard {
            hosts: hosts.to_vec(),
            token: None,
        };
        let router = Router::new().route(PATH, page).fallback(elsewhere);
        let server = Server::start("metrics", address, guard, router).context("monitor.prometheus")?;
        Ok(Self { server, latest })
    }

    /// Where they are.
    pub(crate) fn url(&self) -> String {
        format!("http://{}{PATH}", self.server.address())
    }

    /// From now on, this is served.
    pub(crate) fn hand_over(&self, snapshot: Snapshot) {
        let snapshot = Arc::new(snapshot);
        let before = std::mem::replace(&mut *self.latest.lock(), snapshot);
        // Not while it is held.
        drop(before);
    }
}

//! Server of metrics on a separate thread.
//!
//! At the end of each interval, the monitor hands over a page; the server returns the latest page. Frequent, slow or
//! malformed requests therefore do not affect the monitor: both share a pointer, locked only for a copy.

use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use anyhow::Context as _;
use web::axum::Router;
use web::axum::http::header::CONTENT_TYPE;
use web::axum::routing::get;
use web::{Guard, Server};

use crate::exposition::{self, MetricsSnapshot};

const PATH: &str = "/metrics";

/// Page of metrics.
#[derive(Debug)]
pub(crate) struct Metrics {
    server: Server,
    latest: Arc<LatestMetrics>,
}

#[derive(Debug)]
struct LatestMetrics(Mutex<Arc<MetricsSnapshot>>);

impl LatestMetrics {
    fn lock(&self) -> MutexGuard<'_, Arc<MetricsSnapshot>> {
        // No code under the lock can panic.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn text(&self) -> String {
        let latest = Arc::clone(&self.lock());
        MetricsSnapshot::clone(&latest).text()
    }
}

impl Metrics {
    /// Serves at `address`, which requests may also name by any of `hosts`; the first page is `begin`.
    ///
    /// # Errors
    /// If the address cannot be opened, for example because of use by another monitor.
    pub(crate) fn serve(address: SocketAddr, hosts: &[String], begin: MetricsSnapshot) -> anyhow::Result<Self> {
        let latest = Arc::new(LatestMetrics(Mutex::new(Arc::new(begin))));
        let of_server = Arc::clone(&latest);
        let page = get(move || async move { ([(CONTENT_TYPE, exposition::CONTENT_TYPE)], of_server.text()) });
        let elsewhere = format!("There is nothing here but {PATH}.\n");
        let elsewhere = || async { (web::axum::http::StatusCode::NOT_FOUND, elsewhere) };
        let guard = Guard {
            hosts: hosts.to_vec(),
            ..Guard::default()
        };
        let router = Router::new().route(PATH, page).fallback(elsewhere);
        let server = Server::start("metrics", address, guard, router).context("monitor.prometheus")?;
        Ok(Self { server, latest })
    }

    /// Returns the address of the server.
    pub(crate) fn url(&self) -> String {
        format!("http://{}{PATH}", self.server.address())
    }

    /// Replaces the page.
    pub(crate) fn hand_over(&self, snapshot: MetricsSnapshot) {
        let snapshot = Arc::new(snapshot);
        let before = std::mem::replace(&mut *self.latest.lock(), snapshot);
        // Not under the lock.
        drop(before);
    }
}

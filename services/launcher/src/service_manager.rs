//! Words to the machine's service manager (systemd): that the deployment runs, that the launcher is alive, and how it
//! is. Where none has started the launcher (`NOTIFY_SOCKET` is not set) they go nowhere.

use std::time::{Duration, Instant};

use runtime::clock::instant;
use sd_notify::NotifyState;

/// Variables that speak to the launcher alone.
pub(crate) const VARIABLES: [&str; 3] = ["NOTIFY_SOCKET", "WATCHDOG_PID", "WATCHDOG_USEC"];
/// Signs of life within the time that the manager allows between two.
const SIGNS: u32 = 4;

/// The launcher's line to the service manager.
#[derive(Debug)]
pub(crate) struct ServiceManager {
    period: Option<Duration>,
    signed: Option<Instant>,
    status: String,
}

impl ServiceManager {
    pub(crate) fn new() -> Self {
        Self {
            period: sd_notify::watchdog_enabled().map(|allowed| allowed / SIGNS),
            signed: None,
            status: String::new(),
        }
    }

    /// Says that the deployment runs.
    pub(crate) fn ready(&mut self) {
        tell(&[NotifyState::Ready]);
    }

    /// Says that the deployment is about to stop.
    pub(crate) fn stopping(&mut self) {
        tell(&[NotifyState::Stopping]);
    }

    /// Gives a sign of life, if it is time to, and says how the deployment is, if that has changed.
    pub(crate) fn sign(&mut self, status: String) {
        if status != self.status {
            tell(&[NotifyState::Status(&status)]);
            self.status = status;
        }
        let Some(period) = self.period else { return };
        let now = instant();
        if self.signed.is_none_or(|signed| now.duration_since(signed) >= period) {
            tell(&[NotifyState::Watchdog]);
            self.signed = Some(now);
        }
    }
}

/// A manager that does not listen is no reason to end a deployment.
fn tell(state: &[NotifyState<'_>]) {
    let _ = sd_notify::notify(state);
}

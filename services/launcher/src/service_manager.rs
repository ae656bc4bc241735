//! Notices to the machine's service manager (systemd): the deployment runs, the launcher lives, and the present
//! state. Without a service manager (`NOTIFY_SOCKET` is not set) notices have no effect.

use std::time::{Duration, Instant};

use runtime::clock::instant;
use sd_notify::NotifyState;

/// Variables for the launcher alone, not for children.
pub(crate) const VARIABLES: [&str; 3] = ["NOTIFY_SOCKET", "WATCHDOG_PID", "WATCHDOG_USEC"];
/// Number of signs of life within the interval that the manager permits.
const SIGNS: u32 = 4;

/// Launcher's connection to the service manager.
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

    /// Reports that the deployment runs.
    pub(crate) fn ready(&mut self) {
        tell(&[NotifyState::Ready]);
    }

    /// Reports that the deployment is being stopped.
    pub(crate) fn stopping(&mut self) {
        tell(&[NotifyState::Stopping]);
    }

    /// Sends a sign of life if due, and the state of the deployment if the state has changed.
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

/// A manager that does not listen does not end a deployment.
fn tell(state: &[NotifyState<'_>]) {
    let _ = sd_notify::notify(state);
}

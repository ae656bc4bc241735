//! Errors of opening a socket, with remedies.

use std::io;

use thiserror::Error;

/// A setting cannot be used, or the machine refused the setting.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NetError {
    /// A value that is invalid on any machine.
    #[error("{setting} {value}: {reason}")]
    Setting {
        /// Which setting.
        setting: &'static str,
        /// Value of the setting.
        value: String,
        /// Reason of the error, and the permitted values.
        reason: String,
    },

    /// Other machines reach an address without permission; a sentence with the remedy.
    #[error("{0}")]
    Reach(String),

    /// The machine has no such network interface.
    #[error("interface {interface}: this machine has none of that name or address; it has {present}")]
    NoInterface {
        /// The interface as configured.
        interface: String,
        /// The existing interfaces, with addresses.
        present: String,
    },

    /// The operating system refused.
    #[error("{action}: {reason}{}", remedy(reason))]
    Refused {
        /// The attempted action.
        action: String,
        /// Reason of the refusal.
        reason: io::Error,
    },
}

impl NetError {
    pub(crate) fn setting(setting: &'static str, value: impl ToString, reason: impl Into<String>) -> Self {
        Self::Setting {
            setting,
            value: value.to_string(),
            reason: reason.into(),
        }
    }

    /// Returns a closure for `map_err` that names the action refused by the operating system.
    pub(crate) fn refused<E: Into<io::Error>>(action: impl ToString) -> impl FnOnce(E) -> Self {
        move |reason| Self::Refused {
            action: action.to_string(),
            reason: reason.into(),
        }
    }
}

fn remedy(reason: &io::Error) -> &'static str {
    match reason.kind() {
        io::ErrorKind::AddrInUse => "; end the process that holds it (`ss -ltunp` names it), or take another port",
        io::ErrorKind::AddrNotAvailable => "; take an address of one of this machine's interfaces (`ip address`)",
        io::ErrorKind::PermissionDenied => "; take a port above 1023, or grant CAP_NET_BIND_SERVICE",
        io::ErrorKind::NetworkUnreachable => "; name an interface, or give the machine a route to it (`ip route`)",
        _ => "",
    }
}

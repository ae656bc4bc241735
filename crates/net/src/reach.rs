//! Whether other machines may reach the services of this machine.
//!
//! A socket on a loopback address serves this machine alone. At any other address, 0.0.0.0 among them, the socket
//! serves all hosts that reach the machine: the track picture leaves the machine, or reports come in. That must not
//! happen by mistake, and an address does not show the reach at a glance. Each listening socket is therefore opened
//! with a permission beside the address.

use std::net::SocketAddr;

/// Hosts that may reach a listening socket.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// This machine alone.
    ThisMachine {
        /// Option that permits more, as in "--remote" or "remote = true".
        permission: &'static str,
    },
    /// Other machines, too.
    OtherMachines,
}

impl Reach {
    /// Other machines if `is_permitted`, by the option named `permission`.
    pub fn permitted(is_permitted: bool, permission: &'static str) -> Self {
        match is_permitted {
            true => Self::OtherMachines,
            false => Self::ThisMachine { permission },
        }
    }

    /// Checks an address to listen at.
    ///
    /// # Errors
    /// The address, the mistake and the remedy.
    pub fn check(self, address: SocketAddr) -> Result<(), String> {
        match self {
            Self::ThisMachine { permission } if !address.ip().to_canonical().is_loopback() => Err(format!(
                "{address} can be reached from other machines; use a loopback address as in 127.0.0.1:{}, or permit it by \
                 {permission}",
                address.port()
            )),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_of_other_machines_needs_the_permission_that_is_named() {
        let check =
            |address: &str, is_permitted| Reach::permitted(is_permitted, "--remote").check(address.parse().unwrap());
        for address in ["127.0.0.1:9", "127.8.8.8:9", "[::1]:9", "[::ffff:127.0.0.1]:9"] {
            assert_eq!(check(address, false), Ok(()), "{address}");
        }
        for address in [
            "0.0.0.0:9",
            "192.0.2.1:9",
            "[::]:9",
            "[::ffff:0.0.0.0]:9",
            "[fe80::1]:9",
        ] {
            let said = check(address, false).unwrap_err();
            assert!(said.contains("127.0.0.1:9, or permit it by --remote"), "{said}");
            assert_eq!(check(address, true), Ok(()), "{address}");
        }
    }
}

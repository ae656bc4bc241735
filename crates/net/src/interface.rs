//! Network interfaces by name or by address.
//!
//! A machine may have several interfaces, for example a first to the sensors and a second to the offices. A group must
//! be joined, and multicast be sent, on the right interface; the kernel's own choice follows the routes and may be
//! wrong. Therefore the interface is always named explicitly, by name (the same on machines of the same kind) or by
//! address (unchanged after a renaming). The kernel uses a number, which is looked up when a socket is opened.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::fmt;
use std::net::{IpAddr, Ipv4Addr};
use std::os::fd::AsFd;
use std::str::FromStr;

use nix::ifaddrs::getifaddrs;
use nix::sys::socket::SockaddrStorage;
use rustix::net::netdevice::name_to_index;

use crate::NetError;

/// A network interface of this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Interface {
    /// By name, for example `eth0`.
    Name(String),
    /// Any address of the interface.
    Address(IpAddr),
}

/// Identity of an interface in the form of the kernel's socket options.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InterfaceIdentity {
    /// Number of the interface.
    pub(crate) index: u32,
    /// IPv4 source address: the configured address, else the first address of the interface.
    pub(crate) ipv4: Option<Ipv4Addr>,
}

impl Interface {
    /// The interface that a configuration states, by address, name or number.
    pub(crate) fn stated(text: &str) -> Self {
        let Ok(interface) = text.parse();
        interface
    }

    /// Looks the interface up; `socket` is any.
    ///
    /// # Errors
    /// If the machine has no such interface.
    pub(crate) fn find(&self, socket: impl AsFd) -> Result<InterfaceIdentity, NetError> {
        let interfaces = interfaces()?;
        let found = interfaces.iter().find(|(name, addresses)| match self {
            Self::Name(wanted) => wanted == *name,
            Self::Address(wanted) => addresses.contains(wanted),
        });
        let Some((name, addresses)) = found else {
            return Err(NetError::NoInterface {
                interface: self.to_string(),
                present: listed(&interfaces),
            });
        };
        let named = match self {
            Self::Address(IpAddr::V4(address)) => Some(*address),
            _ => None,
        };
        Ok(InterfaceIdentity {
            index: name_to_index(socket, name).map_err(NetError::refused(format!("using interface {name}")))?,
            ipv4: named.or_else(|| addresses.iter().find_map(ipv4)),
        })
    }
}

impl FromStr for Interface {
    type Err = Infallible;

    /// Parses an address; any other text is a name.
    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(text.parse().map_or_else(|_| Self::Name(text.to_owned()), Self::Address))
    }
}

impl fmt::Display for Interface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name) => f.write_str(name),
            Self::Address(address) => address.fmt(f),
        }
    }
}

/// The addresses of every interface, by name.
fn interfaces() -> Result<BTreeMap<String, Vec<IpAddr>>, NetError> {
    let mut found: BTreeMap<String, Vec<IpAddr>> = BTreeMap::new();
    for entry in getifaddrs().map_err(NetError::refused("listing the interfaces"))? {
        let addresses = found.entry(entry.interface_name).or_default();
        addresses.extend(entry.address.as_ref().and_then(ip));
    }
    Ok(found)
}

fn ip(address: &SockaddrStorage) -> Option<IpAddr> {
    let v4 = address.as_sockaddr_in().map(|address| IpAddr::V4(address.ip()));
    v4.or_else(|| address.as_sockaddr_in6().map(|address| IpAddr::V6(address.ip())))
}

fn ipv4(address: &IpAddr) -> Option<Ipv4Addr> {
    match address {
        IpAddr::V4(address) => Some(*address),
        IpAddr::V6(_) => None,
    }
}

fn listed(interfaces: &BTreeMap<String, Vec<IpAddr>>) -> String {
    let one = |(name, addresses): (&String, &Vec<IpAddr>)| {
        let addresses: Vec<_> = addresses.iter().map(IpAddr::to_string).collect();
        match addresses.is_empty() {
            true => name.clone(),
            false => format!("{name} ({})", addresses.join(" ")),
        }
    };
    interfaces.iter().map(one).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use std::net::UdpSocket;

    use super::*;

    #[test]
    fn loopback_is_found_by_name_and_by_address() {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        let find = |text: &str| text.parse::<Interface>().unwrap().find(&socket).unwrap();
        assert_eq!(find("lo"), find("127.0.0.1"));
        assert_eq!(find("lo").ipv4, Some(Ipv4Addr::LOCALHOST));
    }

    #[test]
    fn an_interface_that_is_not_there_is_named_with_those_that_are() {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        for absent in ["nosuch0", "203.0.113.77"] {
            let error = absent.parse::<Interface>().unwrap().find(&socket).unwrap_err();
            let text = error.to_string();
            assert!(text.contains(absent) && text.contains("lo (127.0.0.1"), "{text}");
        }
    }
}

//! List of permitted senders.
//!
//! A datagram's sender is easily forged, so a list of senders is no defence against an attacker on the same network. A
//! list is a defence against mistakes, which are the rule: a simulator left running on the operational group, a second
//! radar configured with the first radar's port. Datagrams from elsewhere are counted and not looked into.

use std::net::IpAddr;

use ipnet::IpNet;

use crate::NetError;

/// Most entries of a list: each datagram is compared with all entries.
const ENTRIES_MAX: usize = 64;

/// Addresses and networks from which datagrams are accepted; all, if the list is empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AllowedSenders {
    networks: Vec<IpNet>,
}

impl AllowedSenders {
    /// A list of addresses (`192.0.2.17`, `2001:db8::17`) and networks in CIDR form (`192.0.2.0/24`).
    ///
    /// # Errors
    /// [`NetError::Setting`] for an entry that is neither, for a network with bits set behind the prefix, and for more
    /// than 64 entries.
    pub fn parse<'a>(entries: impl IntoIterator<Item = &'a str>) -> Result<Self, NetError> {
        let networks = entries.into_iter().map(parse_one).collect::<Result<Vec<_>, _>>()?;
        if networks.len() > ENTRIES_MAX {
            let reason = format!("too many entries, at most {ENTRIES_MAX}; name networks instead of addresses");
            return Err(NetError::setting("allowed senders", networks.len(), reason));
        }
        Ok(Self { networks })
    }

    /// Whether datagrams from `address` are accepted.
    pub fn allow(&self, address: IpAddr) -> bool {
        self.networks.is_empty() || self.networks.iter().any(|network| network.contains(&address))
    }

    /// An entry that no sender to a socket at `local` can have, being of the other kind of address.
    pub(crate) fn unreachable_from(&self, local: IpAddr) -> Option<IpNet> {
        let other_kind = |network: &&IpNet| network.addr().is_ipv4() != local.is_ipv4();
        self.networks.iter().find(other_kind).copied()
    }
}

fn parse_one(entry: &str) -> Result<IpNet, NetError> {
    if let Ok(address) = entry.parse::<IpAddr>() {
        return Ok(address.into());
    }
    let network: IpNet = entry.parse().map_err(|_| {
        let reason = "neither an address (192.0.2.17) nor a network (192.0.2.0/24)";
        NetError::setting("allowed sender", entry, reason)
    })?;
    if network.trunc() != network {
        let reason = format!("has bits set behind its prefix; write {}", network.trunc());
        return Err(NetError::setting("allowed sender", entry, reason));
    }
    Ok(network)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn allows(entries: &[&str], address: &str) -> bool {
        let senders = AllowedSenders::parse(entries.iter().copied()).unwrap();
        senders.allow(address.parse().unwrap())
    }

    #[test]
    fn addresses_and_networks_are_accepted_and_others_are_not() {
        let entries = ["192.0.2.17", "198.51.100.64/26", "2001:db8::/32"];
        for inside in ["192.0.2.17", "198.51.100.64", "198.51.100.127", "2001:db8:1::9"] {
            assert!(allows(&entries, inside), "{inside}");
        }
        for outside in [
            "192.0.2.18",
            "198.51.100.63",
            "198.51.100.128",
            "2001:db9::1",
            "::ffff:192.0.2.17",
        ] {
            assert!(!allows(&entries, outside), "{outside}");
        }
        assert!(allows(&[], "203.0.113.1"), "an empty list accepts all");
        assert!(allows(&["0.0.0.0/0"], "203.0.113.1") && !allows(&["0.0.0.0/0"], "::1"));
    }

    #[test]
    fn entries_that_cannot_be_meant_are_refused_with_what_to_write() {
        for (entry, expected) in [
            ("radar-1", "neither an address"),
            ("192.0.2.0/33", "neither an address"),
            ("", "neither an address"),
            ("192.0.2.17/24", "write 192.0.2.0/24"),
        ] {
            let error = AllowedSenders::parse([entry]).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        assert!(
            AllowedSenders::parse(["192.0.2.1"; 65])
                .unwrap_err()
                .to_string()
                .contains("64")
        );
    }
}

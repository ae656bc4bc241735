//! Loopback address of a deployment, so that deployments with the same ports run side by side.

use std::hash::Hasher as _;
use std::net::Ipv4Addr;
use std::path::Path;

use rustc_hash::FxHasher;

/// Returns the loopback address of the deployment with its shared memory at `root`.
///
/// All of 127.0.0.0/8 is the machine itself. With an address of its own for each deployment, several deployments with
/// the same ports run side by side without a search for free ports. Addresses are of the upper half, since systems
/// give addresses of the lower half to their own services.
pub(crate) fn loopback_of(root: &Path) -> Ipv4Addr {
    let mut hasher = FxHasher::default();
    hasher.write(root.as_os_str().as_encoded_bytes());
    let [.., a, b, c] = (hasher.finish() >> 8).to_be_bytes();
    Ipv4Addr::new(127, 128 | a, b, c.clamp(1, 254))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_deployment_has_a_loopback_address_of_its_own() {
        let address = |i: u32| loopback_of(Path::new(&format!("/run/koseki/instance-{i}")));
        let mut addresses: Vec<Ipv4Addr> = (0..1000).map(address).collect();
        assert!(addresses.iter().all(Ipv4Addr::is_loopback));
        assert_eq!(address(5), address(5));
        addresses.sort_unstable();
        addresses.dedup();
        assert!(addresses.len() >= 999, "{} different ones", addresses.len());
    }
}

//! What can be known of the network before anything starts: whether ports are free and interfaces there.
//!
//! A process that cannot have its socket says so itself, again and again, among what all others say at their start.
//! Asked beforehand, it is one line with a remedy. It is no reason not to start: another program may hold the port for
//! a moment only, and an interface may come up; unless the source is required.

use anyhow::bail;
use configuration::{Config, Transport};
use net::{UdpReceiver, UdpSender};

use crate::say;

/// Tries every socket of the deployment, and says which cannot be had.
///
/// # Errors
/// If one belongs to a source that is required.
pub(crate) fn check(config: &Config) -> anyhow::Result<()> {
    for receiver in &config.receivers {
        // A port of the deployment's own loopback address is its own; a server may come up when it likes.
        let Transport::Udp(settings) = &receiver.transport else {
            continue;
        };
        let Err(error) = UdpReceiver::open(settings) else {
            continue;
        };
        let what = format!("receiver {}: {error}", receiver.name);
        let mut behind = config.sources.iter().filter(|source| source.adapter == receiver.name);
        if let Some(source) = behind.find(|source| source.required) {
            bail!("{what}; source {} behind it is required", source.name);
        }
        say(&format!("{what}; it is tried again until it works"));
    }
    for gateway in &config.gateways {
        if let Err(error) = UdpSender::open(&gateway.sender) {
            say(&format!(
                "gateway {}: {error}; it is tried again until it works",
                gateway.name
            ));
        }
    }
    Ok(())
}

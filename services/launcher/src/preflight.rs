//! Checks of the network before the start: free ports and existing interfaces.
//!
//! A process without its socket reports the fault itself, many times, among the messages of all other processes. A
//! check before the start gives one line with a remedy. A failed check does not prevent the start, since another
//! program may hold the port only for a moment, and an interface may come up; a required source is the exception.

use anyhow::bail;
use deployment::{Deployment, ReceiverTransport};
use net::{UdpReceiver, UdpSender};

use crate::say;

/// Tries every socket of the deployment, and reports the unavailable sockets.
///
/// # Errors
/// If an unavailable socket belongs to a required source.
pub(crate) fn check(config: &Deployment) -> anyhow::Result<()> {
    for receiver in &config.receivers {
        // Ports at the deployment's own loopback address are its own; a server may start at any time.
        let ReceiverTransport::Udp(settings) = &receiver.transport else {
            continue;
        };
        let Err(error) = UdpReceiver::open(settings) else {
            continue;
        };
        let what = format!("receiver {}: {error}", receiver.name);
        let sources = config.sources.iter().chain(&config.tracker_sensors);
        let mut behind = sources.filter(|source| source.adapter == receiver.name);
        if let Some(source) = behind.find(|source| source.required) {
            bail!("{what}; source {} behind it is required", source.name);
        }
        say(&format!("{what}; it is tried again until it works"));
    }
    for gateway in &config.services.gateways {
        let Some(sender) = &gateway.sender else { continue };
        if let Err(error) = UdpSender::open(sender) {
            say(&format!(
                "gateway {}: {error}; it is tried again until it works",
                gateway.name
            ));
        }
    }
    Ok(())
}

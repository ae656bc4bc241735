//! Checks of the machine before the start: open files, free ports and existing interfaces.
//!
//! A process without a socket reports the fault itself, many times, among the messages of all other processes. A check
//! before the start gives a single line with a remedy. A failed check does not prevent the start, since another program
//! may hold the port only for a moment, and an interface may come up; a required source is the exception.

use anyhow::{bail, ensure};
use deployment::{Deployment, ReceiverTransport};
use net::{ReceiverSettings, SenderSettings, UdpReceiver, UdpSender};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::say;

/// Files that a process of a small deployment has open, and as many to spare.
const FILES_LEAST: u64 = 256;
/// Files that a process of the largest deployment has open, and as many to spare.
const FILES_MOST: u64 = 65_536;

/// Checks how many files a process may have open, then tries every socket of the deployment, and reports the
/// unavailable sockets.
///
/// # Errors
/// If the files are too few, or an unavailable socket belongs to a required source.
pub(crate) fn check(config: &Deployment) -> anyhow::Result<()> {
    open_files()?;
    for receiver in &config.receivers {
        // Ports at the deployment's own loopback address belong to the deployment; a server may start at any time.
        let ReceiverTransport::Udp(input) = &receiver.transport else {
            continue;
        };
        let interface = input.interface.as_deref();
        let settings = ReceiverSettings::stated(input.listen, interface, &input.senders, input.buffer_bytes);
        let Err(error) = settings.and_then(|settings| UdpReceiver::open(&settings)) else {
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
        let Some(output) = &gateway.sender else { continue };
        let sender = SenderSettings::stated(output.send_to, output.interface.as_deref(), output.ttl);
        if let Err(error) = UdpSender::open(&sender) {
            say(&format!(
                "gateway {}: {error}; it is tried again until it works",
                gateway.name
            ));
        }
    }
    Ok(())
}

/// Permits this process and all children the largest number of open files ever needed, if this user may permit that
/// many.
///
/// Without, the ports of a process fail in succession, and the deployment continues without some processes.
fn open_files() -> anyhow::Result<()> {
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    let Some(limit) = current.filter(|current| *current < FILES_MOST) else {
        return Ok(());
    };
    let raised = maximum.map_or(FILES_MOST, |maximum| maximum.min(FILES_MOST));
    let wanted = Rlimit {
        current: Some(raised),
        maximum,
    };
    // If the system refuses, the present limit holds.
    let limit = setrlimit(Resource::Nofile, wanted).map_or(limit, |()| raised);
    ensure!(
        limit >= FILES_LEAST,
        "a process may have only {limit} files open, and needs up to {FILES_LEAST}: raise `ulimit -n`, or LimitNOFILE of \
         the unit"
    );
    Ok(())
}

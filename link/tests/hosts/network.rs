//! Two hosts with clocks and addresses of their own: namespaces of the kernel, joined by a wire.
//!
//! `unshare` makes them and `ip` the wire, where this process may; else both hosts are this one, on loopback. They go
//! with the processes that hold them.

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};

use crate::host::{Host, free_port, until};

/// Seconds by which the monotonic clocks of the namespaces are ahead of the machine's.
const AHEAD_S: [u32; 2] = [100_000, 5_000_000];
/// The same after a reboot.
const REBOOTED_S: u32 = 300;
/// Addresses of the namespaces, in a network that only they know.
const ADDRESSES: [&str; 2] = ["10.77.0.1", "10.77.0.2"];

/// A namespace, held by a process that only sleeps.
struct Namespace {
    holder: Child,
    /// Process in it.
    inside: u32,
}

impl Namespace {
    fn ahead_by(seconds: u32) -> Option<Self> {
        let seconds = seconds.to_string();
        let mut holder = Command::new("unshare")
            .args(["--net", "--time", "--fork", "--kill-child"])
            .args(["--monotonic", &seconds, "--boottime", &seconds])
            .args(["sh", "-c", "echo $$; exec sleep 1000000"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut said = String::new();
        BufReader::new(holder.stdout.take()?).read_line(&mut said).ok()?;
        match said.trim().parse() {
            Ok(inside) => Some(Self { holder, inside }),
            Err(_) => {
                let _ = holder.wait();
                None
            }
        }
    }

    fn ip(&self, arguments: &[&str]) -> bool {
        let mut enter = Command::new("nsenter");
        enter.args(["--target", &self.inside.to_string(), "--net", "ip"]);
        enter.args(arguments).stderr(Stdio::null());
        enter.status().is_ok_and(|status| status.success())
    }
}

impl Drop for Namespace {
    fn drop(&mut self) {
        let _ = self.holder.kill();
        let _ = self.holder.wait();
    }
}

/// Two hosts, and how the second reaches the first.
pub(crate) struct Network {
    // Their deployments are gone before; folders go before namespaces.
    pub(crate) hosts: [Host; 2],
    pub(crate) endpoint: String,
    namespaces: Option<[Namespace; 2]>,
    /// That of the first host's clocks after a reboot.
    rebooted: Option<Namespace>,
}

fn namespaces() -> Option<[Namespace; 2]> {
    let [first, second] = AHEAD_S.map(Namespace::ahead_by);
    let both = [first?, second?];
    let [first, second] = [&both[0], &both[1]].map(|each| each.inside.to_string());
    let mut wire = Command::new("ip");
    wire.args(["link", "add", "wire", "netns", &first, "type", "veth"]);
    wire.args(["peer", "name", "wire", "netns", &second])
        .stderr(Stdio::null());
    let is_joined = wire.status().is_ok_and(|status| status.success());
    let is_up = both.iter().zip(ADDRESSES).all(|(namespace, address)| {
        namespace.ip(&["addr", "add", &format!("{address}/24"), "dev", "wire"])
            && namespace.ip(&["link", "set", "lo", "up"])
            && namespace.ip(&["link", "set", "wire", "up"])
    });
    (is_joined && is_up).then_some(both)
}

impl Network {
    /// Two hosts with nothing on them. `None` where Koseki has not been built.
    pub(crate) fn new() -> Option<Self> {
        let mut hosts = [Host::new()?, Host::new()?];
        let namespaces = namespaces();
        let endpoint = match &namespaces {
            Some(namespaces) => {
                for (host, namespace) in hosts.iter_mut().zip(namespaces) {
                    host.enters(namespace.inside);
                }
                format!("tcp/{}:7447", ADDRESSES[0])
            }
            None => {
                println!("namespaces are not permitted, or ip is missing: both hosts are this one, with one clock");
                format!("tcp/127.0.0.1:{}", free_port())
            }
        };
        Some(Self {
            hosts,
            endpoint,
            namespaces,
            rebooted: None,
        })
    }

    /// Has the first host's monotonic clock begin again, for what is started on it from now on. Without namespaces it
    /// cannot, which is `false`.
    pub(crate) fn reboot(&mut self) -> bool {
        if self.namespaces.is_none() {
            return false;
        }
        self.rebooted = Namespace::ahead_by(REBOOTED_S);
        let inside = self.rebooted.as_ref().map(|namespace| namespace.inside);
        inside.is_some_and(|inside| {
            self.hosts[0].has_clocks_of(inside);
            true
        })
    }

    /// Takes the wire down, or up again. Without namespaces there is none, which is `false`.
    pub(crate) fn wire(&self, state: &str) -> bool {
        let first = self.namespaces.iter().flatten().next();
        first.is_some_and(|first| first.ip(&["link", "set", "wire", state]))
    }

    /// Waits until a deployment on the second host says of its peers what `wanted` says.
    pub(crate) fn until_said(&self, instance: &str, wanted: &str) {
        let status = || self.hosts[1].status(instance);
        until(|| status().contains(wanted), status);
    }
}

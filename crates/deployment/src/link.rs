//! Links to deployments on other hosts (PL-13): their keys, and their place in a deployment.
//!
//! The keys stand here, because `koseki-link` is built apart from the other processes, and the executable checks them.

use std::collections::BTreeSet;
use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};

use messages::{SensorTrack, Streamed as _, WideArea};
use settings::SettingsError;

use crate::names::check_name;
use crate::source::{Input, Source};
use crate::wide_area::{WideAreaInput, WideAreaSensor};

settings::settings! {
    /// A link to deployments on other hosts.
    pub struct Link {
        check Link::check;
        /// Name of the link process.
        name: String;
        /// Endpoints at which links of other hosts reach this one, as in `"tls/[::]:7447"` or `"tcp/127.0.0.1:7447"`.
        listen: Vec<String> = Vec::new();
        /// Endpoints of links on other hosts.
        connect: Vec<String> = Vec::new();
        /// Topics that are sent to other links on request, such as `"sensor/NAME/tracks"`.
        send: Vec<String> = vec!["system/tracks".to_owned()];
        /// Topics of other deployments to receive.
        receive: Vec<RemoteTopic> = Vec::new();
        /// Size of the queue for the network, megabytes. In a full queue, a newer state of a system track replaces an
        /// older state; of other samples the newest are dropped. Both are counted.
        queue_mb: u32 = 16, in [1, 4096];
        /// Certificate of the authority that signed the others' certificates, a file in PEM. Relative paths of a link
        /// begin in the folder of the configuration.
        authority: Option<String> = None;
        /// Certificate that this host shows, a file in PEM.
        certificate: Option<String> = None;
        /// Private key of the certificate, a file in PEM.
        private_key: Option<String> = None;
        /// User name of this host, for links that demand a user name.
        user: Option<String> = None;
        /// File with the user's password on its first line.
        password_file: Option<String> = None;
        /// File with a line `USER:PASSWORD` per permitted user; other users are rejected.
        users_file: Option<String> = None;
        /// Peers of the link, with their rights. Without a list of peers, every link that can connect has all rights.
        peers as "peer": Vec<LinkPeer> = Vec::new();
        /// Allow TCP to other machines without encryption: every host on the path can read and change the data.
        insecure: bool = false;
    }

    /// Another link that a link deals with.
    pub struct LinkPeer {
        /// Common name of the peer's certificate, or the peer's user name.
        name: String;
        /// Topics that the peer may request.
        read: Option<Vec<String>> = None, usually "all that are sent";
        /// Deployment whose topics the peer may send.
        deployment: Option<String> = None, usually "that of its name";
    }

    /// A topic of another deployment.
    pub struct RemoteTopic {
        /// Name of the other deployment.
        deployment: String;
        /// Topic there, as in `"sensor/radar/tracks"`.
        topic: String;
        /// Topic here, of a source or wide-area sensor that is `external`.
        into: Option<String> = None, usually "the same name";
    }
}

/// Files for TLS: each side shows a certificate that the other one's authority has signed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkTls {
    /// Certificate of the authority that signed the others' certificates.
    pub authority: PathBuf,
    /// Certificate that this host shows.
    pub certificate: PathBuf,
    /// Private key of that certificate.
    pub key: PathBuf,
}

impl Link {
    fn check(&self) -> Result<(), SettingsError> {
        if self.listen.is_empty() && self.connect.is_empty() {
            let what = "a link that neither listens nor connects meets nobody; give listen or connect";
            return Err(SettingsError::new("listen", what));
        }
        for (key, endpoints) in [("listen", &self.listen), ("connect", &self.connect)] {
            for endpoint in endpoints {
                check_endpoint(endpoint, self.certificate.is_some(), self.insecure)
                    .map_err(|what| SettingsError::new(key, what))?;
            }
        }
        let files = [
            ("authority", &self.authority),
            ("certificate", &self.certificate),
            ("private_key", &self.private_key),
        ];
        let missing = files.iter().find(|(_, file)| file.is_none());
        if let Some((key, _)) = missing.filter(|_| files.iter().any(|(_, file)| file.is_some())) {
            let what = "is needed with the other two of the files for TLS";
            return Err(SettingsError::new(*key, what));
        }
        if self.user.is_some() != self.password_file.is_some() {
            let what = "user and password_file go together: give both or none";
            return Err(SettingsError::new("user", what));
        }
        if let Some(topic) = self.send.iter().find(|topic| !is_topic(topic)) {
            let what = format!("\"{topic}\" is no topic; write it as in \"system/tracks\" or \"sensor/NAME/tracks\"");
            return Err(SettingsError::new("send", what));
        }
        self.check_peers()
    }

    fn check_peers(&self) -> Result<(), SettingsError> {
        if !self.peers.is_empty() && self.certificate.is_none() && self.users_file.is_none() {
            let what = "nobody can be told from others without certificates or users; give authority, certificate and \
                        private_key, or users_file";
            return Err(SettingsError::new("peer", what));
        }
        let mut read = self.peers.iter().flat_map(|peer| peer.read(self));
        if let Some(unsent) = read.find(|topic| !self.send.contains(topic)) {
            let what = format!("\"{unsent}\" is not sent; give it in send, too");
            return Err(SettingsError::new("peer.read", what));
        }
        let gives =
            |deployment: &str| self.peers.is_empty() || self.peers.iter().any(|peer| peer.gives() == deployment);
        if let Some(received) = self.receive.iter().find(|received| !gives(&received.deployment)) {
            let what = format!(
                "no [[link.peer]] may give the topics of \"{0}\"; give the one that does deployment = \"{0}\", or correct \
                 receive.deployment",
                received.deployment
            );
            return Err(SettingsError::new("peer.deployment", what));
        }
        Ok(())
    }

    /// Takes the files that the link names from `folder`, unless their paths are absolute.
    pub fn take_files_from(&mut self, folder: &Path) {
        let files = [
            &mut self.authority,
            &mut self.certificate,
            &mut self.private_key,
            &mut self.password_file,
            &mut self.users_file,
        ];
        for file in files.into_iter().flatten() {
            // Both are text, so that the whole is.
            *file = folder.join(&*file).to_string_lossy().into_owned();
        }
    }

    /// Size of the queue for the network, bytes.
    pub fn queue_bytes(&self) -> usize {
        self.queue_mb as usize * 1_000_000
    }

    /// Files for TLS, if it is used.
    pub fn tls(&self) -> Option<LinkTls> {
        Some(LinkTls {
            authority: self.authority.as_ref()?.into(),
            certificate: self.certificate.as_ref()?.into(),
            key: self.private_key.as_ref()?.into(),
        })
    }
}

impl LinkPeer {
    /// Topics that the peer of `link` may request.
    pub fn read<'a>(&'a self, link: &'a Link) -> &'a [String] {
        self.read.as_ref().unwrap_or(&link.send)
    }

    /// Deployment whose topics the peer may send.
    pub fn gives(&self) -> &str {
        self.deployment.as_ref().unwrap_or(&self.name)
    }
}

impl RemoteTopic {
    /// Topic here.
    pub fn into(&self) -> &str {
        self.into.as_ref().unwrap_or(&self.topic)
    }
}

/// Checks the `links` of a deployment against its sources and wide-area sensors.
///
/// # Errors
/// A key by its path in the file, with its value and a remedy.
pub fn check_links(links: &[Link], sources: &[Source], sensors: &[WideAreaSensor]) -> Result<(), SettingsError> {
    let mut names = BTreeSet::new();
    let mut taken = BTreeSet::new();
    for (index, link) in links.iter().enumerate() {
        let key = |part: &str| format!("link[{index}].{part}");
        check_name(&key("name"), &link.name)?;
        if !names.insert(&link.name) {
            let what = format!("\"{}\" is the name of an earlier link; give each its own", link.name);
            return Err(SettingsError::new(key("name"), what));
        }
        for topic in &link.receive {
            check_remote(&key, topic, sources, sensors)?;
            if !taken.insert(topic.into()) {
                let what = format!("{} is fed by another topic already", topic.into());
                return Err(SettingsError::new(key("receive"), what));
            }
        }
    }
    Ok(())
}

fn check_remote(
    key: &impl Fn(&str) -> String,
    remote: &RemoteTopic,
    sources: &[Source],
    sensors: &[WideAreaSensor],
) -> Result<(), SettingsError> {
    check_name(&key("receive.deployment"), &remote.deployment)?;
    let into = remote.into();
    let external = sources.iter().filter(|source| matches!(source.input, Input::External));
    let tracks = external.map(|source| SensorTrack::topic(&source.name).name);
    let external = sensors
        .iter()
        .filter(|sensor| matches!(sensor.input, WideAreaInput::External));
    let counts = external.map(|sensor| WideArea::topic(&sensor.name).name);
    if !tracks.chain(counts).any(|name| name.as_str() == into) {
        let what = format!(
            "\"{into}\" is the topic of no external source or wide-area sensor of this deployment; give one that \
             [source.external] or [wide_area_sensor.external] declares, as in into = \"sensor/NAME/tracks\""
        );
        return Err(SettingsError::new(key("receive.into"), what));
    }
    Ok(())
}

struct Known;

impl messages::Visitor for Known {
    type Output = ();

    fn visit<T: messages::layout::Sample>(self, _: messages::Topic<T>) {}
}

fn is_topic(name: &str) -> bool {
    messages::visit(name, Known).is_some()
}

/// Checks an endpoint of a link: `tcp/HOST:PORT`, or with certificates `tls/HOST:PORT`. Without TLS, only this machine
/// may be at the other end, unless the network is trusted (`is_insecure`).
///
/// # Errors
/// A sentence that states what is wrong, and what to write.
pub fn check_endpoint(endpoint: &str, has_certificates: bool, is_insecure: bool) -> Result<(), String> {
    let malformed =
        || format!("\"{endpoint}\" is no endpoint; write it as in \"tcp/127.0.0.1:7447\" or \"tls/host:7447\"");
    let (protocol, place) = endpoint.split_once('/').ok_or_else(malformed)?;
    let (host, port) = place.rsplit_once(':').ok_or_else(malformed)?;
    let port: u16 = port.parse().map_err(|_| malformed())?;
    if host.is_empty() || port == 0 {
        return Err(malformed());
    }
    let address = place.parse::<SocketAddr>().map(|address| address.ip());
    let is_local = host == "localhost" || address.is_ok_and(|ip: IpAddr| ip.is_loopback());
    match protocol {
        "tls" if !has_certificates => Err(format!("{endpoint} needs authority, certificate and private_key")),
        "tls" => Ok(()),
        "tcp" if is_local || is_insecure => Ok(()),
        "tcp" => Err(format!(
            "{endpoint} can be reached from other machines, and nothing is encrypted; use tls/…, or set \
             insecure = true where the network is your own"
        )),
        _ => Err(malformed()),
    }
}

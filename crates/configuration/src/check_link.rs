//! Checking links to deployments on other hosts.

use std::collections::BTreeSet;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;

use messages::{SensorTrack, Streamed as _, WideArea};
use settings::SettingsError;

use super::check::Checked;
use super::tables::{LinkPeerTable, LinkTable, RemoteTopicTable};
use deployment::{Input, Link, LinkPeer, LinkTls, RemoteTopic, Source, WideAreaInput, WideAreaSensor, check_name};

/// The links to other hosts.
pub(super) fn check_hosts(raw: &[LinkTable], sources: &[Source], sensors: &[WideAreaSensor]) -> Checked<Vec<Link>> {
    let mut names = BTreeSet::new();
    let mut taken = BTreeSet::new();
    let mut links = Vec::new();
    for (index, each) in raw.iter().enumerate() {
        let key = |part: &str| format!("link[{index}].{part}");
        check_name(&key("name"), &each.name)?;
        if !names.insert(&each.name) {
            let what = format!("\"{}\" is the name of an earlier link; give each its own", each.name);
            return Err(SettingsError::new(key("name"), what));
        }
        let link = check_link(&key, each, sources, sensors)?;
        for topic in &link.receive {
            if !taken.insert(topic.into.clone()) {
                let what = format!("{} is fed by another topic already", topic.into);
                return Err(SettingsError::new(key("receive"), what));
            }
        }
        links.push(link);
    }
    Ok(links)
}

fn check_link(
    key: &impl Fn(&str) -> String,
    raw: &LinkTable,
    sources: &[Source],
    sensors: &[WideAreaSensor],
) -> Checked<Link> {
    if raw.listen.is_empty() && raw.connect.is_empty() {
        let what = "a link that neither listens nor connects meets nobody; give listen or connect";
        return Err(SettingsError::new(key("listen"), what));
    }
    for (part, endpoints) in [("listen", &raw.listen), ("connect", &raw.connect)] {
        for endpoint in endpoints {
            check_endpoint(endpoint, raw.certificate.is_some(), raw.insecure)
                .map_err(|what| SettingsError::new(key(part), what))?;
        }
    }
    let read = |part: &str, path: &Option<String>| {
        let missing = || SettingsError::new(key(part), "is needed with the other two of the files for TLS");
        path.as_ref().map(PathBuf::from).ok_or_else(missing)
    };
    let tls = [&raw.authority, &raw.certificate, &raw.private_key];
    let tls = match tls.iter().any(|file| file.is_some()) {
        false => None,
        true => Some(LinkTls {
            authority: read("authority", &raw.authority)?,
            certificate: read("certificate", &raw.certificate)?,
            key: read("private_key", &raw.private_key)?,
        }),
    };
    let user = match (&raw.user, &raw.password_file) {
        (None, None) => None,
        (Some(user), Some(file)) => Some((user.clone(), PathBuf::from(file))),
        _ => {
            let what = "user and password_file go together: give both or none";
            return Err(SettingsError::new(key("user"), what));
        }
    };
    for topic in &raw.send {
        if !is_topic(topic) {
            let what = format!("\"{topic}\" is no topic; write it as in \"system/tracks\" or \"sensor/NAME/tracks\"");
            return Err(SettingsError::new(key("send"), what));
        }
    }
    let peers = check_peers(key, raw)?;
    let receive = raw.receive.iter().map(|each| remote(key, each, sources, sensors));
    Ok(Link {
        name: raw.name.clone(),
        listen: raw.listen.clone(),
        connect: raw.connect.clone(),
        send: raw.send.clone(),
        receive: receive.collect::<Checked<_>>()?,
        pretended_ns: raw.pretend_utc_off_s.ns(),
        queue_octets: raw.queue_mb as usize * 1_000_000,
        tls,
        user,
        users_file: raw.users_file.as_ref().map(PathBuf::from),
        peers,
        insecure: raw.insecure,
    })
}

fn check_peers(key: &impl Fn(&str) -> String, raw: &LinkTable) -> Checked<Vec<LinkPeer>> {
    if !raw.peers.is_empty() && raw.certificate.is_none() && raw.users_file.is_none() {
        let what = "nobody can be told from others without certificates or users; give authority, certificate and \
                    private_key, or users_file";
        return Err(SettingsError::new(key("peer"), what));
    }
    let check_peer = |peer: &LinkPeerTable| {
        let read = peer.read.clone().unwrap_or_else(|| raw.send.clone());
        if let Some(unsent) = read.iter().find(|topic| !raw.send.contains(topic)) {
            let what = format!("\"{unsent}\" is not sent; give it in send, too");
            return Err(SettingsError::new(key("peer.read"), what));
        }
        Ok(LinkPeer {
            name: peer.name.clone(),
            read,
            deployment: peer.deployment.as_ref().unwrap_or(&peer.name).clone(),
        })
    };
    let peers = raw.peers.iter().map(check_peer).collect::<Checked<Vec<LinkPeer>>>()?;
    let gives = |deployment: &String| peers.is_empty() || peers.iter().any(|peer| peer.deployment == *deployment);
    if let Some(received) = raw.receive.iter().find(|received| !gives(&received.deployment)) {
        let what = format!(
            "no [[link.peer]] may give the topics of \"{0}\"; give the one that does deployment = \"{0}\"",
            received.deployment
        );
        return Err(SettingsError::new(key("peer.deployment"), what));
    }
    Ok(peers)
}

fn remote(
    key: &impl Fn(&str) -> String,
    raw: &RemoteTopicTable,
    sources: &[Source],
    sensors: &[WideAreaSensor],
) -> Checked<RemoteTopic> {
    check_name(&key("receive.deployment"), &raw.deployment)?;
    let into = raw.into.as_ref().unwrap_or(&raw.topic);
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
    Ok(RemoteTopic {
        deployment: raw.deployment.clone(),
        topic: raw.topic.clone(),
        into: into.clone(),
    })
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

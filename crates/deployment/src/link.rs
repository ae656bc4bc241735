//! Links to deployments on other hosts.

use std::path::PathBuf;

/// A link to deployments on other hosts: one process, `koseki-link` (PL-13).
#[derive(Clone, Debug, Default)]
pub struct Link {
    /// Name of the process.
    pub name: String,
    /// Endpoints at which links of other hosts reach this one, such as `tls/[::]:7447`.
    pub listen: Vec<String>,
    /// Endpoints of links on other hosts.
    pub connect: Vec<String>,
    /// Topics of this deployment that others may have.
    pub send: Vec<String>,
    /// Topics of other deployments to receive.
    pub receive: Vec<RemoteTopic>,
    /// Time by which this host's clock (UTC) pretends to be off, nanoseconds.
    pub pretended_ns: i64,
    /// Octets that wait for the network at most.
    pub queue_octets: usize,
    /// Files for TLS, if it is used.
    pub tls: Option<LinkTls>,
    /// User and file with the password, if the others ask for them.
    pub user: Option<(String, PathBuf)>,
    /// File with users and passwords, if the others must be one of them.
    pub users_file: Option<PathBuf>,
    /// Others that it deals with; empty: all that may connect.
    pub peers: Vec<LinkPeer>,
    /// Whether TCP without encryption may reach other machines.
    pub insecure: bool,
}

/// Another link that a link deals with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkPeer {
    /// Common name of the peer's certificate, or the peer's user name.
    pub name: String,
    /// Topics that the peer may request.
    pub read: Vec<String>,
    /// Deployment whose topics it may give.
    pub deployment: String,
}

/// A topic of another deployment, and where its samples go here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RemoteTopic {
    /// Name of the other deployment.
    pub deployment: String,
    /// Topic there.
    pub topic: String,
    /// Topic here.
    pub into: String,
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

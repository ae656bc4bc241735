//! The files by which a link shows who it is, examined before a session does.
//!
//! A session that refuses a certificate says little, and says it on the other host. So the same library judges the
//! same files beforehand: [`Credentials::read`] those of one link, [`Credentials::fault_at`] as the other link would.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use deployment::LinkTls;
use runtime::Now;
use rustls::CertificateError;
use rustls::RootCertStore;
use rustls::client::WebPkiServerVerifier;
use rustls::client::danger::ServerCertVerifier as _;
use rustls::crypto::CryptoProvider;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName, UnixTime};
use rustls::server::WebPkiClientVerifier;
use rustls::sign::CertifiedKey;
use time::OffsetDateTime;
use x509_parser::prelude::{FromDer as _, GeneralName, X509Certificate, X509Version};

/// Time before its end at which a certificate is to be renewed.
pub(crate) const RENEW_BEFORE: Duration = Duration::from_secs(30 * 86_400);

/// A fault of a file: the key that names it, and what to do.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct CredentialFault {
    pub(crate) key: &'static str,
    pub(crate) what: String,
}

impl CredentialFault {
    fn new(key: &'static str, what: impl Into<String>) -> Self {
        Self { key, what: what.into() }
    }
}

/// What a certificate states.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Statement {
    pub(crate) common_name: String,
    /// Names and addresses of the host.
    pub(crate) hosts: Vec<String>,
    pub(crate) from: OffsetDateTime,
    pub(crate) until: OffsetDateTime,
    is_version_3: bool,
}

/// The certificates of a link.
#[derive(Debug)]
pub(crate) struct Credentials {
    chain: Vec<CertificateDer<'static>>,
    authority: CertificateDer<'static>,
    pub(crate) own: Statement,
    pub(crate) of_authority: Statement,
}

/// The time of this host.
pub(crate) fn utc() -> SystemTime {
    SystemTime::UNIX_EPOCH + Duration::from_nanos(u64::try_from(Now::read().utc_ns).unwrap_or(0))
}

/// A date, as in 2026-12-31.
pub(crate) fn date(at: OffsetDateTime) -> String {
    at.date().to_string()
}

impl Statement {
    /// Reads the first certificate of a file in PEM.
    pub(crate) fn read(file: &Path) -> Result<(Self, Vec<CertificateDer<'static>>), String> {
        let chain = CertificateDer::pem_file_iter(file).and_then(Iterator::collect);
        let chain: Vec<CertificateDer<'static>> = chain.map_err(|error| unreadable(file, &error))?;
        let first = chain.first().ok_or_else(|| no_pem(file))?;
        let (_, parsed) = X509Certificate::from_der(first)
            .map_err(|_| format!("{}: the certificate is damaged; copy it again", file.display()))?;
        let statement = Self::of(&parsed);
        Ok((statement, chain))
    }

    fn of(certificate: &X509Certificate<'_>) -> Self {
        let mut names = certificate.subject().iter_common_name();
        let common_name = names.next().and_then(|name| name.as_str().ok()).unwrap_or_default();
        let alternatives = certificate.subject_alternative_name().ok().flatten();
        let alternatives = alternatives.iter().flat_map(|names| &names.value.general_names);
        Self {
            common_name: common_name.to_owned(),
            hosts: alternatives.filter_map(host).collect(),
            from: certificate.validity().not_before.to_datetime(),
            until: certificate.validity().not_after.to_datetime(),
            is_version_3: certificate.version() == X509Version::V3,
        }
    }

    fn fault(&self, file: &Path, now: SystemTime) -> Option<String> {
        let (file, now) = (file.display(), OffsetDateTime::from(now));
        if !self.is_version_3 {
            return Some(format!(
                "{file} is a certificate of version 1, which names no host; issue one of version 3, with the host as \
                 subjectAltName"
            ));
        }
        if now < self.from {
            let from = date(self.from);
            return Some(format!(
                "{file} is valid from {from} on; set the clock of this host, or issue another"
            ));
        }
        (now >= self.until).then(|| {
            let until = date(self.until);
            format!("{file} has expired on {until}; issue another with `koseki link renew`")
        })
    }
}

fn host(name: &GeneralName<'_>) -> Option<String> {
    match name {
        GeneralName::DNSName(name) => Some((*name).to_owned()),
        GeneralName::IPAddress(octets) => {
            let four = <[u8; 4]>::try_from(*octets).map(std::net::IpAddr::from);
            let sixteen = <[u8; 16]>::try_from(*octets).map(std::net::IpAddr::from);
            four.or(sixteen).ok().map(|address| address.to_string())
        }
        _ => None,
    }
}

fn no_pem(file: &Path) -> String {
    format!("{} has nothing of the kind; give a file in PEM", file.display())
}

fn unreadable(file: &Path, error: &rustls::pki_types::pem::Error) -> String {
    match error {
        rustls::pki_types::pem::Error::Io(error) => format!(
            "{} cannot be read: {error}; copy the file there, or make it with `koseki link init`",
            file.display()
        ),
        _ => no_pem(file),
    }
}

fn provider() -> Arc<CryptoProvider> {
    Arc::new(rustls::crypto::ring::default_provider())
}

impl Credentials {
    /// Reads the files of a link.
    ///
    /// # Errors
    /// The first file with a fault.
    pub(crate) fn read(files: &LinkTls, now: SystemTime) -> Result<Self, CredentialFault> {
        let refused = |key| move |what| CredentialFault::new(key, what);
        let (of_authority, authority) = Statement::read(&files.authority).map_err(refused("authority"))?;
        let (own, chain) = Statement::read(&files.certificate).map_err(refused("certificate"))?;
        let key = PrivateKeyDer::from_pem_file(&files.key);
        let key = key.map_err(|error| CredentialFault::new("private_key", unreadable(&files.key, &error)))?;
        let dated = [
            ("authority", &of_authority, &files.authority),
            ("certificate", &own, &files.certificate),
        ];
        for (key, statement, file) in dated {
            if let Some(what) = statement.fault(file, now) {
                return Err(CredentialFault::new(key, what));
            }
        }
        if CertifiedKey::from_der(chain.clone(), key, &provider()).is_err() {
            let (key, certificate) = (files.key.display(), files.certificate.display());
            let what = format!("{key} is not the key of {certificate}; give the key that was made with it");
            return Err(CredentialFault::new("private_key", what));
        }
        let authority = authority
            .into_iter()
            .next()
            .unwrap_or_else(|| CertificateDer::from(Vec::new()));
        let credentials = Self {
            chain,
            authority,
            own,
            of_authority,
        };
        if let Some(what) = credentials.fault_at(&credentials, None, now) {
            let certificate = files.certificate.display();
            return Err(CredentialFault::new("certificate", format!("{certificate} {what}")));
        }
        Ok(credentials)
    }

    /// What `other` would find wrong with this certificate; with `host`, by connecting there.
    pub(crate) fn fault_at(&self, other: &Self, host: Option<&str>, now: SystemTime) -> Option<String> {
        let since = now.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let now = UnixTime::since_unix_epoch(since);
        let (own, chain) = self.chain.split_first()?;
        let mut roots = RootCertStore::empty();
        if roots.add(other.authority.clone()).is_err() {
            return Some("cannot be judged: the authority is no certificate of an authority; give that".to_owned());
        }
        let roots = Arc::new(roots);
        let asks = WebPkiClientVerifier::builder_with_provider(Arc::clone(&roots), provider())
            .build()
            .ok()?;
        if let Err(error) = asks.verify_client_cert(own, chain, now) {
            return Some(self.in_words(&error, other, None));
        }
        let calls = WebPkiServerVerifier::builder_with_provider(roots, provider())
            .build()
            .ok()?;
        let named = host.or_else(|| self.own.hosts.first().map(String::as_str))?;
        let Ok(name) = ServerName::try_from(named.to_owned()) else {
            return Some(format!("cannot name \"{named}\"; give a name or an address of a host"));
        };
        let verdict = calls.verify_server_cert(own, chain, &name, &[], now);
        verdict.err().map(|error| self.in_words(&error, other, Some(named)))
    }

    fn in_words(&self, error: &rustls::Error, other: &Self, host: Option<&str>) -> String {
        let rustls::Error::InvalidCertificate(cause) = error else {
            return format!("is refused: {error}; issue another with `koseki link renew`");
        };
        match cause {
            CertificateError::UnknownIssuer | CertificateError::BadSignature => format!(
                "is not signed by the authority \"{}\"; give both sides the authority that signed their certificates",
                other.of_authority.common_name
            ),
            CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. } => format!(
                "names the host {}, not {}; issue one with that name as subjectAltName",
                match self.own.hosts.join(", ") {
                    none if none.is_empty() => "of nobody".to_owned(),
                    hosts => hosts,
                },
                host.unwrap_or_default()
            ),
            CertificateError::InvalidPurpose | CertificateError::InvalidPurposeContext { .. } => {
                "may not be used by both sides; issue one for serverAuth and clientAuth".to_owned()
            }
            CertificateError::Expired | CertificateError::ExpiredContext { .. } => {
                "or its authority has expired; issue another with `koseki link renew`".to_owned()
            }
            other => format!("is refused: {other:?}; issue another with `koseki link renew`"),
        }
    }

    /// The end of the certificate, or of its authority if that comes earlier.
    pub(crate) fn until(&self) -> OffsetDateTime {
        self.own.until.min(self.of_authority.until)
    }
}

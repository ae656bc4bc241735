//! Certificates of a test.

use std::fs;
use std::path::PathBuf;

use rcgen::{BasicConstraints, CertificateParams, CertifiedIssuer, DnType, IsCa, KeyPair, date_time_ymd};
use time::OffsetDateTime;

use crate::host::Host;

/// Who signs certificates.
pub(crate) struct Authority(CertifiedIssuer<'static, KeyPair>);

impl Authority {
    pub(crate) fn new() -> Self {
        let mut params = CertificateParams::new(Vec::new()).unwrap();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        let own = KeyPair::generate().unwrap();
        Self(CertifiedIssuer::self_signed(params, own).unwrap())
    }

    /// Its certificate, PEM.
    pub(crate) fn pem(&self) -> String {
        self.0.pem()
    }

    /// A certificate of `name` for `hosts` that is valid until then, and its key, both PEM.
    pub(crate) fn signed(&self, until: OffsetDateTime, name: &str, hosts: &[&str]) -> (String, String) {
        let hosts: Vec<String> = hosts.iter().map(|host| (*host).to_owned()).collect();
        let mut params = CertificateParams::new(hosts).unwrap();
        params.not_after = until;
        params.distinguished_name.push(DnType::CommonName, name);
        let own = KeyPair::generate().unwrap();
        let certificate = params.signed_by(&own, &self.0).unwrap();
        (certificate.pem(), own.serialize_pem())
    }

    /// Keys of a link's configuration for whoever is called `name` on `host`, and trusts `trusted`.
    pub(crate) fn certify(&self, host: &Host, name: &str, trusted: &Self) -> String {
        self.certify_until(2096, host, name, trusted)
    }

    /// The same, valid until this year begins.
    pub(crate) fn certify_until(&self, year: i32, host: &Host, name: &str, trusted: &Self) -> String {
        let (certificate, own) = self.signed(date_time_ymd(year, 1, 1), name, &["127.0.0.1"]);
        let write = |what: &str, text: String| -> PathBuf {
            let path = host.path(&format!("{name}-{what}.pem"));
            fs::write(&path, text).unwrap();
            path
        };
        let authority = write("authority", trusted.0.pem());
        let certificate = write("certificate", certificate);
        let key = write("key", own);
        format!("authority = {authority:?}\ncertificate = {certificate:?}\nprivate_key = {key:?}\n")
    }
}

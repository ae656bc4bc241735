//! An authority for links, and the certificates that it signs.

use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::os::unix::fs::{DirBuilderExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context as _;
use rcgen::{
    BasicConstraints, CertificateParams, CertifiedIssuer, DistinguishedName, DnType, ExtendedKeyUsagePurpose, IsCa,
    Issuer, KeyPair, KeyUsagePurpose,
};
use time::OffsetDateTime;

use crate::credentials::{self, Statement};

/// Time for which an authority is valid.
const AUTHORITY: Duration = Duration::from_secs(3652 * 86_400);
/// Time by which the clocks of the hosts may differ.
const CLOCKS: Duration = Duration::from_secs(86_400);

/// File of an authority's certificate, in its folder and in that of each host.
pub(crate) const AUTHORITY_FILE: &str = "authority.pem";
/// File of an authority's key, in its folder only.
const AUTHORITY_KEY: &str = "authority.key";

/// Who signs certificates.
pub(crate) struct Authority {
    issuer: Issuer<'static, KeyPair>,
    /// Its certificate, PEM.
    pub(crate) pem: String,
    pub(crate) until: OffsetDateTime,
}

/// A certificate with its key, PEM.
pub(crate) struct Issued {
    pub(crate) certificate: String,
    pub(crate) key: String,
    pub(crate) until: OffsetDateTime,
}

fn named(common_name: &str, hosts: Vec<String>, until: OffsetDateTime) -> anyhow::Result<CertificateParams> {
    let mut params = CertificateParams::new(hosts)?;
    params.distinguished_name = DistinguishedName::new();
    params.distinguished_name.push(DnType::CommonName, common_name);
    params.not_before = OffsetDateTime::from(credentials::utc()) - CLOCKS;
    params.not_after = until;
    Ok(params)
}

impl Authority {
    /// A new authority, written into the new `folder`.
    pub(crate) fn make(folder: &Path, common_name: &str) -> anyhow::Result<Self> {
        let until = OffsetDateTime::from(credentials::utc()) + AUTHORITY;
        let mut params = named(common_name, Vec::new(), until)?;
        params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
        params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
        let key = KeyPair::generate()?;
        let key_pem = key.serialize_pem();
        let pem = CertifiedIssuer::self_signed(params, key)?.pem();
        make_folder(folder, 0o700)?;
        write_new(&folder.join(AUTHORITY_KEY), &key_pem, 0o600)?;
        write_new(&folder.join(AUTHORITY_FILE), &pem, 0o644)?;
        Self::with(pem, &key_pem, until)
    }

    fn with(pem: String, key: &str, until: OffsetDateTime) -> anyhow::Result<Self> {
        let issuer = Issuer::from_ca_cert_pem(&pem, KeyPair::from_pem(key)?)?;
        Ok(Self { issuer, pem, until })
    }

    /// The authority in `folder`.
    pub(crate) fn read(folder: &Path) -> anyhow::Result<Self> {
        let file = |name: &str| -> anyhow::Result<(PathBuf, String)> {
            let path = folder.join(name);
            let text = fs::read_to_string(&path).with_context(|| {
                let folder = folder.display();
                format!("--authority {folder}: {name}: give the folder that `koseki link init` has made")
            })?;
            Ok((path, text))
        };
        let ((certificate, pem), (_, key)) = (file(AUTHORITY_FILE)?, file(AUTHORITY_KEY)?);
        let (statement, _) = Statement::read(&certificate).map_err(anyhow::Error::msg)?;
        Self::with(pem, &key, statement.until).with_context(|| format!("--authority {}", folder.display()))
    }

    /// A certificate of `common_name` for `hosts`, for either side of a connection, with a new key. The certificate
    /// ends no later than the authority.
    pub(crate) fn issue(&self, common_name: &str, hosts: &[String], days: u32) -> anyhow::Result<Issued> {
        let until = OffsetDateTime::from(credentials::utc()) + Duration::from_secs(u64::from(days) * 86_400);
        let until = until.min(self.until);
        let mut params = named(common_name, hosts.to_vec(), until)?;
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth, ExtendedKeyUsagePurpose::ClientAuth];
        params.use_authority_key_identifier_extension = true;
        let key = KeyPair::generate()?;
        Ok(Issued {
            certificate: params.signed_by(&key, &self.issuer)?.pem(),
            key: key.serialize_pem(),
            until,
        })
    }
}

/// Makes a folder that does not exist.
pub(crate) fn make_folder(folder: &Path, mode: u32) -> anyhow::Result<()> {
    if let Some(parent) = folder.parent().filter(|parent| !parent.as_os_str().is_empty()) {
        fs::create_dir_all(parent).with_context(|| format!("making {}", parent.display()))?;
    }
    let made = fs::DirBuilder::new().mode(mode).create(folder);
    made.with_context(|| format!("making {}", folder.display()))
}

/// Writes a file that does not exist.
pub(crate) fn write_new(path: &Path, text: &str, mode: u32) -> anyhow::Result<()> {
    let file = OpenOptions::new().write(true).create_new(true).mode(mode).open(path);
    let written = file.and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.sync_all()
    });
    written.with_context(|| format!("writing {}", path.display()))
}

/// Writes a file in place of the one there: readers find the old text or the new one.
pub(crate) fn replace(path: &Path, text: &str, mode: u32) -> anyhow::Result<()> {
    let mut name = path.as_os_str().to_owned();
    name.push(".new");
    let beside = PathBuf::from(name);
    // Of an attempt that was killed.
    let _ = fs::remove_file(&beside);
    write_new(&beside, text, mode)?;
    fs::rename(&beside, path).with_context(|| format!("replacing {}", path.display()))
}

//! `koseki link renew`: new certificates and keys in place of those that end.

use std::path::PathBuf;

use clap::Args;
use configuration::Config;
use serde_json::json;

use crate::credentials::{Statement, date};
use crate::init::DAYS;
use crate::issue::{Authority, replace};
use crate::mirror::UsageError;

pub(crate) const EXAMPLES: &str = "\
Examples:
  koseki link renew west/west.toml east/east.toml --authority authority

Each certificate keeps its name and its hosts, and gets a new key. A link reads its files when it starts: copy the files
to their hosts, then end the link's process there, which the launcher starts again.";

/// `koseki link renew`.
#[derive(Debug, Args)]
pub(crate) struct Renew {
    /// Configurations whose links get new certificates, TOML files
    #[arg(value_name = "CONFIG", required = true)]
    configs: Vec<PathBuf>,
    /// Folder of the authority, made by `koseki link init`
    #[arg(long, value_name = "FOLDER", default_value = "authority")]
    authority: PathBuf,
    /// Days for which the certificates are valid
    #[arg(long, value_name = "DAYS", default_value_t = DAYS, value_parser = clap::value_parser!(u32).range(1..=3650))]
    days: u32,
    /// Print what was renewed as JSON
    #[arg(long)]
    json: bool,
}

/// Renews the certificates of all links of the configurations.
///
/// # Errors
/// If a file cannot be read or written, or another authority has signed a certificate; then nothing is renewed.
pub(crate) fn run(renew: &Renew) -> anyhow::Result<()> {
    let refused = |what: String| anyhow::Error::from(UsageError(what));
    let authority = Authority::read(&renew.authority)?;
    let (_, own) = Statement::read(&renew.authority.join(crate::issue::AUTHORITY_FILE)).map_err(refused)?;
    let mut found = Vec::new();
    for path in &renew.configs {
        let config = Config::read(path, &[])?;
        let links = config.links.iter().enumerate();
        let with_tls = links.filter_map(|(index, link)| Some((index, link.tls()?)));
        let before = found.len();
        for (index, files) in with_tls {
            let named = |key: &'static str| {
                let at = format!("{}: link[{index}].{key}", path.display());
                move |what| refused(format!("{at}: {what}"))
            };
            let (statement, _) = Statement::read(&files.certificate).map_err(named("certificate"))?;
            let (_, trusted) = Statement::read(&files.authority).map_err(named("authority"))?;
            if trusted != own {
                let (there, given) = (files.authority.display(), renew.authority.display());
                let what = format!("{there} is another authority than that of --authority {given}; give its folder");
                return Err(named("authority")(what));
            }
            found.push((files, statement));
        }
        if found.len() == before {
            let path = path.display();
            return Err(refused(format!(
                "{path}: link: no link here has a certificate; give a file with one"
            )));
        }
    }
    let mut renewed = Vec::new();
    for (files, statement) in &found {
        let issued = authority.issue(&statement.common_name, &statement.hosts, renew.days)?;
        replace(&files.key, &issued.key, 0o600)?;
        replace(&files.certificate, &issued.certificate, 0o644)?;
        let until = date(issued.until);
        match renew.json {
            true => renewed.push(json!({ "certificate": files.certificate, "key": files.key, "until": until })),
            false => println!(
                "{} and its key are new, valid until {until}.",
                files.certificate.display()
            ),
        }
    }
    match renew.json {
        true => println!("{:#}", json!({ "renewed": renewed })),
        false => println!(
            "Copy both files to their hosts, and end the process of each link there: the launcher starts it again, \
             with the new files."
        ),
    }
    Ok(())
}

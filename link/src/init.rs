//! `koseki link init`: two centres that exchange tracks, from nothing or from two configurations.
//!
//! Each centre gets a folder with all that its host needs; the key of the authority stays in a folder of its own, which
//! no host needs. Nothing that exists is overwritten.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::Args;
use configuration::Config;
use serde_json::json;
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, value};

use crate::credentials::date;
use crate::issue::{AUTHORITY_FILE, Authority, Issued, make_folder, write_new};
use crate::mirror::UsageError;

/// Days for which a certificate is valid unless others are given.
pub(crate) const DAYS: u32 = 730;
/// Name of the links.
const LINK: &str = "centres";
/// What centres exchange.
const OWN_TRACKS: &str = "system/own-tracks";

pub(crate) const EXAMPLES: &str = "\
Examples:
  koseki link init west=west.example east=east.example
  koseki link init west.toml=192.0.2.4 east.toml=192.0.2.9 --out /srv/centres

A centre is NAME=HOST, or FILE.toml=HOST with a configuration that exists; the file itself stays as it is. The west listens
at its HOST; the east connects to it, and needs no HOST. Each centre's folder has its configuration, its certificate and
key, and the certificate of the authority. A centre without a file of its own has a simulated radar.";

/// `koseki link init`.
#[derive(Debug, Args)]
pub(crate) struct Init {
    /// The centre that listens: NAME=HOST, or FILE.toml=HOST
    #[arg(value_name = "WEST")]
    west: String,
    /// The centre that connects: NAME, NAME=HOST, FILE.toml or FILE.toml=HOST
    #[arg(value_name = "EAST")]
    east: String,
    /// Folder in which the folders of both centres and of the authority are made [default: the current one]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Port at which the west listens
    #[arg(long, value_name = "PORT", default_value_t = 7447, value_parser = clap::value_parser!(u16).range(1..))]
    port: u16,
    /// Days for which the certificates are valid
    #[arg(long, value_name = "DAYS", default_value_t = DAYS, value_parser = clap::value_parser!(u32).range(1..=3650))]
    days: u32,
    /// Print what was made as JSON
    #[arg(long)]
    json: bool,
}

/// One of the two centres.
struct Centre {
    name: String,
    host: Option<String>,
    /// Its configuration so far.
    document: DocumentMut,
    /// File that it comes from.
    file: Option<PathBuf>,
}

fn refused(what: String) -> anyhow::Error {
    UsageError(what).into()
}

/// The configuration of a centre that has none.
fn template(name: &str, number: i64) -> String {
    let phase_s = 2 * (number - 1);
    format!(
        r#"# The centre {name}, made by `koseki link init`. docs/hosts.md explains what joins the centres, docs/first-hour.md how
# sensors of your own take the place of the simulated radar.

name = "{name}"

[frame]
latitude_deg = 41.2971
longitude_deg = 2.0785

[scenario]
targets = 20

[[source]]
name = "radar-{name}"
period_s = 4.0
[source.simulated]
kind = "radar"
phase_s = {phase_s}.0
[source.covariance]
range_sigma_m = 50.0
azimuth_sigma_deg = 0.069
velocity_sigma_mps = 14.0
height_sigma_m = 15.0
"#
    )
}

impl Centre {
    /// The centre that an argument describes; `number` is its place, from 1.
    fn of(argument: &str, number: i64) -> anyhow::Result<Self> {
        let (what, host) = match argument.split_once('=') {
            Some((what, host)) => (what, Some(host.to_owned())),
            None => (argument, None),
        };
        if let Some(host) = &host
            && !is_host(host)
        {
            return Err(refused(format!(
                "{argument}: \"{host}\" is no host; give its name or address without a port, as in \
                 {what}=west.example or {what}=192.0.2.4 (the port: --port)"
            )));
        }
        if !what.ends_with(".toml") {
            deployment::check_name("name", what).map_err(|error| refused(format!("{argument}: {error}")))?;
            let document = template(what, number).parse().context("the template")?;
            return Ok(Self {
                name: what.to_owned(),
                host,
                document,
                file: None,
            });
        }
        let path = Path::new(what);
        let text = configuration::text(path)?;
        let name = Config::parse(path, &text, &[])?.name.clone();
        let document = text.parse().with_context(|| what.to_owned())?;
        Ok(Self {
            name,
            host,
            document,
            file: Some(path.to_owned()),
        })
    }

    /// The number of the centre in its file; 0 if it has none.
    fn origin(&self) -> i64 {
        self.document.get("origin").and_then(Item::as_integer).unwrap_or(0)
    }

    fn tables(&mut self, key: &str) -> anyhow::Result<&mut ArrayOfTables> {
        let name = &self.name;
        let tables = self
            .document
            .entry(key)
            .or_insert(Item::ArrayOfTables(ArrayOfTables::new()));
        let tables = tables.as_array_of_tables_mut();
        tables.with_context(|| format!("{name}: {key}: write it as [[{key}]]"))
    }

    /// Adds what joins this centre, of the number `origin`, with `other` by an `endpoint` of the kind `how`.
    fn join(&mut self, origin: i64, other: &str, how: &str, endpoint: &str) -> anyhow::Result<()> {
        self.document["origin"] = value(origin);
        let fusion = self.document.entry("fusion").or_insert(Item::Table(Table::new()));
        let fusion = fusion.as_table_mut().context("fusion: write it as [fusion]")?;
        fusion["exchange"] = value(true);
        let mut source = Table::new();
        source["name"] = value(other);
        source["period_s"] = value(1.0);
        source["shares"] = value("unknown");
        source["external"] = Item::Table(Table::new());
        let mut peer = Table::new();
        peer["name"] = value(other);
        let mut remote = Table::new();
        remote["deployment"] = value(other);
        remote["topic"] = value(OWN_TRACKS);
        remote["into"] = value(format!("sensor/{other}/tracks"));
        let list = |texts: &[&str]| value(texts.iter().copied().collect::<toml_edit::Array>());
        let mut link = Table::new();
        link["name"] = value(LINK);
        link[how] = list(&[endpoint]);
        link["send"] = list(&[OWN_TRACKS]);
        link["authority"] = value(AUTHORITY_FILE);
        link["certificate"] = value(format!("{}.pem", self.name));
        link["private_key"] = value(format!("{}.key", self.name));
        link["peer"] = Item::ArrayOfTables([peer].into_iter().collect());
        link["receive"] = Item::ArrayOfTables([remote].into_iter().collect());
        self.tables("source")?.push(source);
        self.tables("link")?.push(link);
        Ok(())
    }

    /// Checks the finished configuration as `koseki check` would read it.
    fn checked(&self) -> anyhow::Result<String> {
        let text = self.document.to_string();
        let path = self
            .file
            .clone()
            .unwrap_or_else(|| format!("{}.toml", self.name).into());
        Config::parse(&path, &text, &[])?;
        Ok(text)
    }

    fn place(&self) -> String {
        self.host
            .clone()
            .unwrap_or_else(|| format!("the host of {}", self.name))
    }
}

/// Whether `text` is a name or an address of a host, without a port.
fn is_host(text: &str) -> bool {
    rustls::pki_types::ServerName::try_from(text.to_owned()).is_ok()
}

/// The endpoints at which the first listens and the second connects.
fn endpoints(host: &str, port: u16) -> [String; 2] {
    let address = host.parse::<std::net::IpAddr>().ok();
    let written = match address {
        Some(std::net::IpAddr::V6(address)) => format!("[{address}]"),
        _ => host.to_owned(),
    };
    // Two centres on one machine are reached by nobody else.
    let is_here = address.is_some_and(|address| address.is_loopback());
    let listens = if is_here { written.as_str() } else { "[::]" };
    [format!("tls/{listens}:{port}"), format!("tls/{written}:{port}")]
}

/// Numbers of both centres: those in their files, else 1 and 2.
fn origins(west: &Centre, east: &Centre) -> anyhow::Result<[i64; 2]> {
    match [west.origin(), east.origin()] {
        [0, 0] => Ok([1, 2]),
        [0, taken] => Ok([if taken == 1 { 2 } else { 1 }, taken]),
        [taken, 0] => Ok([taken, if taken == 2 { 1 } else { 2 }]),
        [west, east] if west == east => Err(refused(format!(
            "origin = {west} is in both files; give each centre a number of its own"
        ))),
        both => Ok(both),
    }
}

/// Makes both centres and their authority.
///
/// # Errors
/// If an argument cannot be used, a folder exists already, or a file cannot be written.
pub(crate) fn run(init: &Init) -> anyhow::Result<()> {
    let (mut west, mut east) = (Centre::of(&init.west, 1)?, Centre::of(&init.east, 2)?);
    if west.name == east.name {
        let what = format!("{0}: both centres have this name; give each its own", west.name);
        return Err(refused(what));
    }
    let Some(host) = west.host.clone() else {
        let what = format!(
            "{0}: the east connects to this centre; give its host, as in {0}=west.example",
            init.west
        );
        return Err(refused(what));
    };
    let [listens, connects] = endpoints(&host, init.port);
    let [first, second] = origins(&west, &east)?;
    west.join(first, &east.name, "listen", &listens)?;
    east.join(second, &west.name, "connect", &connects)?;
    let texts = [west.checked()?, east.checked()?];
    let out = init.out.as_deref().unwrap_or(Path::new(""));
    let folders = [west.name.as_str(), &east.name, "authority"].map(|name| out.join(name));
    if let Some(there) = folders.iter().find(|folder| folder.symlink_metadata().is_ok()) {
        let there = there.display();
        let what = format!("{there} exists, and nothing is overwritten; remove it, or give another folder with --out");
        return Err(refused(what));
    }
    let authority = Authority::make(&folders[2], &format!("links of {} and {}", west.name, east.name))?;
    let mut made = Vec::new();
    for ((centre, text), folder) in [&west, &east].into_iter().zip(&texts).zip(&folders) {
        let hosts = [centre.host.clone().unwrap_or_else(|| centre.name.clone())];
        let issued = authority.issue(&centre.name, &hosts, init.days)?;
        write(centre, text, folder, &authority, &issued)?;
        made.push(issued);
    }
    print(init, [&west, &east], &folders, &authority, &made);
    Ok(())
}

fn write(centre: &Centre, text: &str, folder: &Path, authority: &Authority, issued: &Issued) -> anyhow::Result<()> {
    let name = &centre.name;
    make_folder(folder, 0o755)?;
    write_new(&folder.join(format!("{name}.key")), &issued.key, 0o600)?;
    write_new(&folder.join(format!("{name}.pem")), &issued.certificate, 0o644)?;
    write_new(&folder.join(AUTHORITY_FILE), &authority.pem, 0o644)?;
    write_new(&folder.join(format!("{name}.toml")), text, 0o644)
}

fn print(init: &Init, centres: [&Centre; 2], folders: &[PathBuf; 3], authority: &Authority, made: &[Issued]) {
    let configs = [0, 1].map(|each: usize| folders[each].join(format!("{}.toml", centres[each].name)));
    if init.json {
        let centre = |each: usize| {
            json!({
                "name": centres[each].name,
                "host": centres[each].host,
                "folder": folders[each],
                "configuration": configs[each],
                "certificate_until": date(made[each].until),
            })
        };
        let all = json!({
            "centres": [centre(0), centre(1)],
            "authority": { "folder": folders[2], "until": date(authority.until) },
        });
        println!("{all:#}");
        return;
    }
    let [west, east] = centres;
    let shown = folders.each_ref().map(|folder| folder.display());
    let [first, second] = configs.each_ref().map(|config| config.display());
    for (each, centre) in centres.into_iter().enumerate() {
        let (folder, name, until) = (&shown[each], &centre.name, date(made[each].until));
        println!("{folder}: {name}.toml, {name}.pem (valid until {until}), {name}.key and authority.pem.");
    }
    println!("{}: the authority, valid until {}.", shown[2], date(authority.until));
    println!("Its key signs certificates: no host needs it. Move this folder to a place apart.\n");
    println!(
        "Copy the folder {} to {}, and the folder {} to {}.",
        shown[0],
        west.place(),
        shown[1],
        east.place()
    );
    println!("Nobody else may read the keys: copy with `scp -rp`.\n");
    println!("koseki check {first} {second}    checks both sides here");
    println!(
        "koseki up {}/{}.toml    starts {} on {}",
        west.name,
        west.name,
        west.name,
        west.place()
    );
    println!(
        "koseki up {}/{}.toml    starts {} on {}",
        east.name,
        east.name,
        east.name,
        east.place()
    );
    println!(
        "koseki link renew {first} {second} --authority {}    renews the certificates",
        shown[2]
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joined(base: &str) -> Centre {
        let mut centre = Centre {
            name: "west".to_owned(),
            host: None,
            document: base.parse().unwrap(),
            file: None,
        };
        centre.join(1, "east", "listen", "tls/[::]:7447").unwrap();
        centre
    }

    #[test]
    fn both_parts_of_a_link_are_configurations_that_are_sound() {
        for number in [1, 2] {
            let text = joined(&template("west", number)).checked().unwrap();
            let config = Config::parse(Path::new("west.toml"), &text, &[]).unwrap();
            assert_eq!((config.origin, config.links.len(), config.sources.len()), (1, 1, 2));
            assert!(config.engine.exchange && config.engine.sources[1].is_centre);
        }
    }

    #[test]
    fn an_own_configuration_keeps_its_comments_and_gets_the_link() {
        let own = "# Ours.\nname = \"west\"\n[frame]\nlatitude_deg = 41.3 # the tower\nlongitude_deg = 2.1\n\
                   [[source]]\nname = \"radar\"\nperiod_s = 4.0\n[source.external]\n[fusion]\nwait = \"event\"\n";
        let text = joined(own).checked().unwrap();
        assert!(text.starts_with("# Ours.\nname = \"west\"\norigin = 1\n"), "{text}");
        assert!(
            text.contains("# the tower") && text.contains("wait = \"event\"\nexchange = true"),
            "{text}"
        );
    }

    #[test]
    fn a_link_on_one_machine_listens_there_only() {
        assert_eq!(
            endpoints("127.0.0.1", 7).map(|each| each.contains("127.0.0.1")),
            [true, true]
        );
        assert_eq!(endpoints("west.example", 7), ["tls/[::]:7", "tls/west.example:7"]);
        assert_eq!(endpoints("2001:db8::1", 7)[1], "tls/[2001:db8::1]:7");
    }

    #[test]
    fn hosts_have_no_ports_and_centres_numbers_of_their_own() {
        assert!(["west.example", "192.0.2.4", "::1"].into_iter().all(is_host));
        assert!(!is_host("west.example:7447") && !is_host("a b") && !is_host(""));
        let with = |origin: i64| joined(&format!("origin = {origin}\nname = \"west\"\n"));
        let of = |origins: [i64; 2]| {
            let [mut west, mut east] = [with(0), with(0)];
            west.document["origin"] = value(origins[0]);
            east.document["origin"] = value(origins[1]);
            super::origins(&west, &east).ok()
        };
        assert_eq!(of([0, 0]), Some([1, 2]));
        assert_eq!(of([0, 1]), Some([2, 1]));
        assert_eq!(of([2, 0]), Some([2, 1]));
        assert_eq!(of([7, 9]), Some([7, 9]));
        assert_eq!(of([7, 7]), None);
    }
}

//! `koseki-link`: exchanges topics of deployments between hosts (PL-13).
//!
//! A link is a normal process of its deployment: it subscribes to outgoing topics, and publishes incoming topics for
//! `external` sources. Between hosts, Eclipse Zenoh carries the slices in their shared-memory layout. Faults of the
//! network or of this process appear to fusion only as silent sources.

mod access;
mod agent;
mod check;
mod clocks;
mod credentials;
mod expiry;
mod feed;
mod frame;
mod gate;
mod history;
mod in_order;
mod inbound;
mod init;
mod issue;
mod keys;
mod mirror;
mod outbound;
mod outbox;
mod picture;
mod refused;
mod renew;
mod session;
mod side_endpoints;
mod side_places;
mod sides;
mod stamps;
mod stand_in;
mod wire;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context as _;
use clap::{Args, CommandFactory as _, Parser, Subcommand};
use configuration::{Config, ConfigError};
use messages::ProcessKind;
use runtime::Process;
use runtime::{Now, Options, Speed};

/// Exchanges topics of Koseki deployments between hosts
#[derive(Debug, Parser)]
#[command(version, max_term_width = 80)]
struct LinkCli {
    #[command(subcommand)]
    command: LinkCommand,
}

#[derive(Debug, Subcommand)]
enum LinkCommand {
    /// Run one link of a deployment that is up; `koseki up` and `koseki link` call this
    Join(Join),
    /// Show a deployment of another host as an instance here, for displays, gateways and other readers
    #[command(after_help = MIRROR_EXAMPLES)]
    Mirror(Mirror),
    /// Make two centres that exchange tracks: their configurations, certificates and authority
    #[command(after_help = init::EXAMPLES)]
    Init(init::Init),
    /// Renew the certificates of links
    #[command(after_help = renew::EXAMPLES)]
    Renew(renew::Renew),
    /// Check the links of a configuration, or of both that a link joins; `koseki check` calls this
    Check(check::Check),
    /// Write the man pages into a folder, for packages
    #[command(hide = true)]
    Man {
        /// The folder
        #[arg(long, value_name = "FOLDER")]
        out: PathBuf,
    },
}

const MIRROR_EXAMPLES: &str = "\
Examples:
  koseki-link mirror --config tower.toml --connect tls/tower.example:7447 --certificates
  koseki top --instance tower                 in another terminal, as if it ran here
  koseki display --config tower.toml

The configuration is the other deployment's, whose [[link]] must send the topics.";

#[derive(Debug, Args)]
struct Mirror {
    /// Configuration of the other deployment, a TOML file
    #[arg(long, value_name = "CONFIG")]
    config: PathBuf,
    /// Endpoint of its link, such as tls/tower.example:7447 (repeatable)
    #[arg(long, value_name = "ENDPOINT", required_unless_present = "listen")]
    connect: Vec<String>,
    /// Endpoint at which its link reaches this mirror (repeatable)
    #[arg(long, value_name = "ENDPOINT")]
    listen: Vec<String>,
    /// Use the certificates, or user and password, of the configuration's first link
    #[arg(long)]
    certificates: bool,
    /// Allow TCP to other machines, without encryption, where the network is your own [default: as the configuration's
    /// first link]
    #[arg(long)]
    insecure: bool,
    /// Topics [default: system/tracks,system/alarms,health,system/frame-origin]
    #[arg(
        long,
        value_name = "TOPICS",
        value_delimiter = ',',
        hide_default_value = true,
        default_value = "system/tracks,system/alarms,health,system/frame-origin"
    )]
    topics: Vec<String>,
    /// Name of the instance here [default: the configuration's name]
    #[arg(long, value_name = "NAME")]
    instance: Option<String>,
    /// Process number of the parent; this process ends with the parent
    #[arg(long, value_name = "PID", hide = true)]
    launcher: Option<u32>,
}

#[derive(Debug, Args)]
struct Join {
    /// Configuration of the deployment, a TOML file
    #[arg(long, value_name = "CONFIG")]
    config: PathBuf,
    /// Name of the link
    #[arg(long, value_name = "NAME")]
    name: String,
    /// Name of the instance [default: the configuration's name]
    #[arg(long, value_name = "NAME")]
    instance: Option<String>,
    /// Replace a value of the configuration (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Process number of the launcher; this process ends with the launcher
    #[arg(long, value_name = "PID", hide = true)]
    launcher: Option<u32>,
}

fn main() -> ExitCode {
    let LinkCli { command } = LinkCli::parse();
    let done = match command {
        LinkCommand::Join(join) => run(join),
        LinkCommand::Mirror(mirror) => mirror::run(mirror),
        LinkCommand::Init(init) => init::run(&init),
        LinkCommand::Renew(renew) => renew::run(&renew),
        LinkCommand::Check(check) => check::run(&check),
        LinkCommand::Man { out } => man_pages(&out),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            runtime::notice(format_args!("koseki-link: {error:#}"));
            ExitCode::from(if error.is::<ConfigError>() || error.is::<mirror::UsageError>() {
                2
            } else {
                1
            })
        }
    }
}

fn man_pages(folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
    clap_mangen::generate_to(LinkCli::command(), folder).with_context(|| format!("writing to {}", folder.display()))
}

fn run(join: Join) -> anyhow::Result<()> {
    let config = Config::read(&join.config, &join.set)?;
    let options = Options {
        overrides: join.set,
        instance: join.instance.unwrap_or_else(|| config.name.clone()),
        data: PathBuf::new(),
        out: PathBuf::new(),
        speed: Speed::Factor(1.0),
        seed: 1,
        scenario_start_ns: Now::read().utc_ns,
        launcher: join.launcher,
    };
    let process = Process::connect(config.deployment, options, ProcessKind::Link, &join.name)?;
    let link = process.config.link(&process.name).with_context(|| {
        let path = process.config.path.display();
        format!("{path}: no link is named \"{}\"", process.name)
    })?;
    let mut agent = agent::LinkAgent::new(&process, link)?;
    runtime::service::run(&process, &mut agent)
}

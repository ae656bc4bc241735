//! `koseki link`: finds the program `koseki-link`, and executes this program, also for the links in `koseki check`.
//!
//! The connection of hosts needs more than a hundred further crates, which a single machine does not need; therefore
//! `koseki-link` is built separately.

use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, bail};
use messages::ProcessKind;
use offline::Usage;
use serde::Deserialize;

use crate::args::{self, LinkArgs, LinkFiles, Serve};
use crate::programs::{Program, execute};

const LINK: Program = Program {
    name: "koseki-link",
    variable: "KOSEKI_LINK",
    workspace: "link",
};

/// Becomes the link, or the command on files of links, that `link` names.
///
/// # Errors
/// If the configuration has no such link, or the program is nowhere.
pub(crate) fn run(link: LinkArgs) -> anyhow::Result<()> {
    let LinkArgs { files, serve } = link;
    match (files, serve) {
        (Some(LinkFiles::Init(passed)), _) => execute(Command::new(LINK.path()?).arg("init").args(passed.arguments)),
        (Some(LinkFiles::Renew(passed)), _) => execute(Command::new(LINK.path()?).arg("renew").args(passed.arguments)),
        (None, Some(serve)) => join(serve),
        (None, None) => {
            let what = "koseki link needs --config with a configuration, or init or renew; --help shows examples";
            Err(Usage(what.to_owned()).into())
        }
    }
}

fn join(serve: Serve) -> anyhow::Result<()> {
    let (config, options) = args::deployment(&serve.config, serve.shared)?;
    let name = super::process_name(ProcessKind::Link, serve.name, &config)?;
    let mut command = Command::new(LINK.path()?);
    command.arg("join").arg("--config").arg(&serve.config);
    command.args(["--name", &name, "--instance", &options.instance]);
    command.args(options.overrides.iter().map(|set| format!("--set={set}")));
    command.args(serve.launcher.map(|launcher| format!("--launcher={launcher}")));
    execute(&mut command)
}

/// Findings of `koseki-link` about links.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct LinkFindings {
    /// Mistakes with which a link does not work: file, key, value and remedy.
    pub(crate) refused: Vec<String>,
    /// Doubts.
    pub(crate) warnings: Vec<String>,
    /// The links.
    pub(crate) links: Vec<FoundLink>,
}

/// A link, in words.
#[derive(Debug, Deserialize)]
pub(crate) struct FoundLink {
    pub(crate) name: String,
    pub(crate) text: String,
}

/// Asks `koseki-link` about the links of a single configuration, or of both at the ends of a link. Without the program,
/// a single configuration gets a warning.
///
/// # Errors
/// If the program fails, or two configurations are given without the program.
pub(crate) fn examine(configs: &[&Path], overrides: &[String]) -> anyhow::Result<LinkFindings> {
    let program = match LINK.find() {
        Some(program) => program,
        None if configs.len() > 1 => return Err(Usage(LINK.not_there()).into()),
        None => {
            let warnings = vec![format!(
                "{}; without it, no link starts, and none was checked",
                LINK.not_there()
            )];
            return Ok(LinkFindings {
                warnings,
                ..LinkFindings::default()
            });
        }
    };
    let mut command = Command::new(&program);
    command.arg("check").args(configs).arg("--json");
    command.args(overrides.iter().map(|set| format!("--set={set}")));
    let output = command
        .output()
        .with_context(|| format!("starting {}", program.display()))?;
    if !output.status.success() {
        let error = String::from_utf8_lossy(&output.stderr);
        bail!("{}: {}", program.display(), error.trim());
    }
    serde_json::from_slice(&output.stdout).with_context(|| format!("reading what {} found", program.display()))
}

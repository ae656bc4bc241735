//! `koseki link`: finds the program `koseki-link`, and executes it.
//!
//! The connection of hosts needs more than a hundred further crates, which a single machine does not need; therefore
//! it is built separately.

use std::os::unix::process::CommandExt as _;
use std::path::PathBuf;
use std::process::Command;

use anyhow::Context as _;
use messages::ProcessKind;

use crate::args::{self, Serve};

const PROGRAM: &str = "koseki-link";

/// Becomes the link that `serve` names.
///
/// # Errors
/// If the configuration has no such link, or the program is nowhere.
pub(crate) fn run(serve: Serve) -> anyhow::Result<()> {
    let (config, options) = args::deployment(&serve.config, serve.shared)?;
    let name = super::process_name(ProcessKind::Link, serve.name, &config)?;
    let program = find().with_context(|| {
        format!(
            "{PROGRAM} is not at $KOSEKI_LINK, beside koseki, in link/target or in PATH: build it with cargo build \
             --release --manifest-path link/Cargo.toml"
        )
    })?;
    let mut command = Command::new(&program);
    command.arg("join").arg("--config").arg(&serve.config);
    command.args(["--name", &name, "--instance", &options.instance]);
    command.args(options.overrides.iter().map(|set| format!("--set={set}")));
    command.args(serve.launcher.map(|launcher| format!("--launcher={launcher}")));
    let refusal = command.exec();
    Err(refusal).with_context(|| format!("starting {}", program.display()))
}

/// Returns the path of the program; `None` if not found.
pub(crate) fn find() -> Option<PathBuf> {
    let given = std::env::var_os("KOSEKI_LINK").map(PathBuf::from);
    let itself = std::env::current_exe().ok();
    let beside = itself.iter().map(|itself| itself.with_file_name(PROGRAM));
    // From target/release/koseki of a checkout: three folders up.
    let built = itself.iter().filter_map(|itself| itself.ancestors().nth(3));
    let built = built.flat_map(|checkout| {
        ["release", "debug"].map(|profile| checkout.join("link/target").join(profile).join(PROGRAM))
    });
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path: Vec<PathBuf> = std::env::split_paths(&path)
        .map(|folder| folder.join(PROGRAM))
        .collect();
    given
        .into_iter()
        .chain(beside)
        .chain(built)
        .chain(path)
        .find(|program| program.is_file())
}

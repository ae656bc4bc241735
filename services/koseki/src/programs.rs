//! Programs built separately from `koseki`: few installations need these programs, and the builds take long.
//!
//! Each has a separate workspace and folder. `koseki` finds the program, and becomes it.

use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Context as _;

/// A program that is built apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Program {
    /// File name.
    pub(crate) name: &'static str,
    /// Environment variable with the program's path.
    pub(crate) variable: &'static str,
    /// Folder of the workspace in the checkout.
    pub(crate) workspace: &'static str,
}

impl Program {
    /// Returns the path of the program; `None` if not found.
    pub(crate) fn find(self) -> Option<PathBuf> {
        let given = std::env::var_os(self.variable).map(PathBuf::from);
        let itself = std::env::current_exe().ok();
        let beside = itself.iter().map(|itself| itself.with_file_name(self.name));
        // From target/release/koseki of a checkout: three folders up.
        let checkout = itself.iter().filter_map(|itself| itself.ancestors().nth(3));
        let built = checkout.flat_map(|checkout| self.built(checkout));
        let path = std::env::var_os("PATH").unwrap_or_default();
        let path: Vec<PathBuf> = std::env::split_paths(&path)
            .map(|folder| folder.join(self.name))
            .collect();
        given
            .into_iter()
            .chain(beside)
            .chain(built)
            .chain(path)
            .find(|program| program.is_file())
    }

    /// Where cargo puts the program: into the target folder of the program's workspace, or of `koseki`.
    fn built(self, checkout: &Path) -> Vec<PathBuf> {
        let own = checkout.join(self.workspace).join("target");
        let folders = [own, checkout.join("target")];
        let profiles = ["release", "debug"].into_iter();
        profiles
            .flat_map(|profile| folders.each_ref().map(|folder| folder.join(profile).join(self.name)))
            .collect()
    }

    /// Returns the path of the program.
    ///
    /// # Errors
    /// If the program is nowhere.
    pub(crate) fn path(self) -> anyhow::Result<PathBuf> {
        self.find().with_context(|| self.not_there())
    }

    /// Remedy for a missing program.
    pub(crate) fn not_there(self) -> String {
        let Self {
            name,
            variable,
            workspace,
        } = self;
        format!(
            "{name} is not at ${variable}, beside koseki, in {workspace}/target, in target or in PATH: install the \
             package, or build it with cargo build --release --manifest-path {workspace}/Cargo.toml"
        )
    }
}

/// Becomes the program of `command`.
///
/// # Errors
/// If the program cannot be executed.
pub(crate) fn execute(command: &mut Command) -> anyhow::Result<()> {
    let refusal = command.exec();
    Err(refusal).with_context(|| format!("starting {}", command.get_program().display()))
}

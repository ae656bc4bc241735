//! `koseki bench` and `koseki torture`: executed by the program `koseki-lab`.
//!
//! Both measure and test deployments of this executable, which therefore passes on the executable's path.

use std::process::Command;

use anyhow::Context as _;

use crate::args::PassedOn;
use crate::programs::{self, Program};

const LAB: Program = Program {
    name: "koseki-lab",
    variable: "KOSEKI_LAB",
    workspace: "lab",
};

/// Becomes the `command` of koseki-lab.
///
/// # Errors
/// If the program is nowhere.
pub(crate) fn run(command: &str, passed: PassedOn) -> anyhow::Result<()> {
    let itself = std::env::current_exe().context("finding the executable")?;
    let mut lab = Command::new(LAB.path()?);
    lab.arg(command).args(passed.arguments).env("KOSEKI", itself);
    programs::execute(&mut lab)
}

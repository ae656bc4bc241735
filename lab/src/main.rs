//! `koseki-lab`: what measures Koseki ([`mod@bench`]) and what tests it by faults ([`tested`]), apart from the product.
//!
//! `koseki bench` and `koseki torture` execute this program. It drives real processes of `koseki`, whose path `koseki`
//! passes on ([`product`]). Exit codes and messages are those of `koseki`; a judge without a verdict ends with 3.

#![forbid(unsafe_code)]

mod args;
mod bench;
mod product;
mod tested;

use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

use anyhow::Context as _;
use clap::{CommandFactory as _, Parser as _};
use clap_mangen::Man;

use args::{LabCli, LabCommand};
use command_line::{CODE_FAILED, CODE_REFUSED};

/// Exit code of a command that judges others, where there is no verdict.
const CODE_NO_VERDICT: u8 = 3;

/// Command line or environment with which the program cannot work.
#[derive(Debug)]
struct Usage(String);

impl std::fmt::Display for Usage {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(&self.0)
    }
}

impl std::error::Error for Usage {}

fn main() -> ExitCode {
    let cli = match LabCli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return command_line::refuse_usage(&error, &LabCli::command()),
    };
    let done = match cli.root {
        Some(root) => command_line::with_root(&root).map_err(|refused| Usage(refused).into()),
        None => Ok(()),
    };
    match done.and_then(|()| run(cli.command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => command_line::end_with(exit_code(&error), command_line::reason(error.as_ref())),
    }
}

fn run(command: LabCommand) -> anyhow::Result<()> {
    match command {
        LabCommand::Bench(what) => bench::run(what),
        LabCommand::BenchRelay(relay) => bench_service::relay::run(&relay.options()),
        LabCommand::Torture(torture) => tested::run(&torture),
        LabCommand::Man { out } => man_pages(&out),
    }
}

fn exit_code(error: &anyhow::Error) -> u8 {
    let refused = error.is::<Usage>()
        || error.is::<configuration::ConfigError>()
        || error.is::<bench_service::MeasurementRefusal>()
        || error.is::<torture::Refused>();
    match () {
        () if refused => CODE_REFUSED,
        () if error.is::<torture::OwnFailure>() => CODE_NO_VERDICT,
        () => CODE_FAILED,
    }
}

/// Prints a result. A closed reader (`| head`) is no failure.
fn print(text: &str) -> anyhow::Result<()> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

/// Writes a page for each command; `koseki` has a page of its own.
fn man_pages(folder: &Path) -> anyhow::Result<()> {
    let write = |command: clap::Command| Man::new(command).generate_to(folder).map(drop);
    let written = std::fs::create_dir_all(folder).and_then(|()| {
        let mut program = LabCli::command().disable_help_subcommand(true);
        program.build();
        let shown = |command: &clap::Command| -> Vec<clap::Command> {
            let all = command.get_subcommands().filter(|command| !command.is_hide_set());
            all.cloned().collect()
        };
        for command in shown(&program) {
            shown(&command).into_iter().try_for_each(write)?;
            write(command)?;
        }
        Ok(())
    });
    written.with_context(|| format!("writing to {}", folder.display()))
}

//! `koseki generate`: alerting rules, and in the feature `generate` completions and man pages, generated from the
//! executable's own definitions.
//!
//! The crates that write completions and man pages are of use to packages only; the first build of a newcomer does
//! without them.

use crate::args::Generate;

/// Writes the requested files.
///
/// # Errors
/// If the output cannot be written.
pub(crate) fn run(generate: &Generate) -> anyhow::Result<()> {
    match generate {
        #[cfg(any(test, feature = "generate"))]
        Generate::Completions { shell } => crate::print(&of_commands::completions(*shell)?),
        #[cfg(any(test, feature = "generate"))]
        Generate::Man { out } => of_commands::man_pages(out),
        Generate::Alerts => crate::print(&alarms::alert_rules()),
    }
}

/// Output generated from the definitions of the commands.
#[cfg(any(test, feature = "generate"))]
mod of_commands {
    use std::io::Write as _;
    use std::path::Path;

    use anyhow::Context as _;
    use clap::CommandFactory as _;
    use clap_complete::Shell;

    use crate::args::Cli;

    /// Returns the completions of all commands for a shell.
    pub(super) fn completions(shell: Shell) -> anyhow::Result<String> {
        let mut text = Vec::new();
        clap_complete::generate(shell, &mut Cli::command(), "koseki", &mut text);
        Ok(String::from_utf8(text)?)
    }

    /// Writes a page for `koseki`, and a page for each of its commands.
    pub(super) fn man_pages(folder: &Path) -> anyhow::Result<()> {
        std::fs::create_dir_all(folder).map_err(|error| offline::unwritable(folder, &error))?;
        clap_mangen::generate_to(Cli::command(), folder).with_context(|| format!("writing to {}", folder.display()))?;
        let pages = std::fs::read_dir(folder)?.count();
        // With standard error closed, the pages are written all the same.
        let _ = writeln!(std::io::stderr(), "{pages} pages are in {}", folder.display());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::of_commands::{completions, man_pages};
    use crate::args::Cli;

    #[test]
    fn there_is_a_page_for_each_command_that_is_shown() {
        let folder = tempfile::tempdir().unwrap();
        man_pages(folder.path()).unwrap();
        let commands = Cli::command();
        let shown = commands.get_subcommands().filter(|command| !command.is_hide_set());
        for name in shown.map(clap::Command::get_name) {
            let page = std::fs::read_to_string(folder.path().join(format!("koseki-{name}.1"))).unwrap();
            assert!(page.contains(".SH SYNOPSIS"), "{name}");
        }
    }

    #[test]
    fn completions_know_every_command() {
        let text = completions(clap_complete::Shell::Bash).unwrap();
        let commands = Cli::command();
        for command in commands.get_subcommands().filter(|command| !command.is_hide_set()) {
            assert!(text.contains(&format!("koseki,{})", command.get_name())), "{command}");
        }
    }
}

//! Messages about wrong usage, each in one line.

use clap::CommandFactory as _;
use clap::error::{ContextKind, ErrorKind};

use super::Cli;

/// Returns clap's message about wrong usage in one line.
pub(crate) fn usage_line(error: &clap::Error) -> String {
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        let command = Cli::command();
        let first = std::env::args().nth(1).unwrap_or_default();
        let within = command
            .find_subcommand(&first)
            .filter(|command| command.has_subcommands());
        let shown = within
            .unwrap_or(&command)
            .get_subcommands()
            .filter(|command| !command.is_hide_set());
        let commands: Vec<&str> = shown.map(clap::Command::get_name).collect();
        let name = within.map_or_else(String::new, |command| format!(" {}", command.get_name()));
        return format!(
            "a command is missing; there are {} (see `koseki{name} --help`)",
            commands.join(", ")
        );
    }
    let what = unknown_option(error, std::env::args()).unwrap_or_else(|| offline::refusal(error));
    let first = std::env::args().nth(1);
    let command = first.filter(|word| Cli::command().find_subcommand(word).is_some());
    match command {
        Some(command) => format!("{what} (see `koseki {command} --help`)"),
        None => format!("{what} (see `koseki --help`)"),
    }
}

/// Returns the message about an unknown option of the command in `words`, with the nearest known option.
fn unknown_option(error: &clap::Error, words: impl Iterator<Item = String>) -> Option<String> {
    let found = error
        .get(ContextKind::InvalidArg)
        .filter(|_| error.kind() == ErrorKind::UnknownArgument)?;
    let found = found.to_string();
    let name = found.strip_prefix("--")?;
    let mut command = Cli::command();
    for word in words.skip(1) {
        if let Some(inner) = command.find_subcommand(&word) {
            command = inner.clone();
        }
    }
    let options: Vec<&str> = command.get_arguments().filter_map(clap::Arg::get_long).collect();
    let meant = settings::nearest(name, &options).map_or_else(String::new, |near| format!("; did you mean --{near}?"));
    Some(format!("unexpected argument '{found}' found{meant}"))
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;

    #[test]
    fn an_unknown_option_comes_with_the_nearest() {
        let said = |words: &[&str]| {
            let error = Cli::try_parse_from(words).unwrap_err();
            unknown_option(&error, words.iter().map(|word| (*word).to_owned()))
        };
        let said_of = |option: &str| said(&["koseki", "up", "a.toml", option, "5"]).unwrap();
        assert_eq!(said_of("--fr"), "unexpected argument '--fr' found; did you mean --for?");
        assert_eq!(
            said_of("--instnce"),
            "unexpected argument '--instnce' found; did you mean --instance?"
        );
        assert_eq!(said_of("--standby"), "unexpected argument '--standby' found");
        assert_eq!(said(&["koseki", "upp"]), None);
    }

    #[test]
    fn wrong_usage_is_one_line() {
        let cases: [&[&str]; 9] = [
            &["koseki", "score"],
            &["koseki", "score", "--truth", "a.csv"],
            &["koseki", "score", "tracks", "--truth", "a.csv"],
            &[
                "koseki", "score", "--truth", "a.csv", "--tracks", "b.csv", "--t0", "0.5",
            ],
            &["koseki"],
            &["koseki", "upp"],
            &["koseki", "up"],
            &["koseki", "up", "a.toml", "--speed", "fast"],
            &["koseki", "demo", "--fro", "3"],
        ];
        for case in cases {
            let error = Cli::try_parse_from(case).unwrap_err();
            let line = usage_line(&error);
            assert_eq!(line.lines().count(), 1, "{line}");
            assert!(!line.contains("error:") && line.contains("--help"), "{line}");
        }
    }
}

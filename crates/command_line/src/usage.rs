//! Messages about wrong usage, each in one line.

use clap::Command;
use clap::error::{ContextKind, ErrorKind};

/// Joins the lines of a message.
pub fn one_line(text: &str) -> String {
    text.lines().map(str::trim).collect::<Vec<_>>().join(" ")
}

/// Returns the reason for rejected command words, on one line.
pub fn refusal(error: &clap::Error) -> String {
    let text = error.to_string();
    let words: Vec<String> = text
        .lines()
        .take_while(|line| !line.starts_with("Usage:"))
        .filter(|line| !line.trim().is_empty() && !line.starts_with("For more information"))
        .filter_map(|line| match line.trim().strip_prefix("tip: ") {
            Some(tip) => similar(tip),
            None => Some(plain(line.trim())),
        })
        .collect();
    let words = words.join(" ").replace(" did you mean", "; did you mean");
    words.strip_prefix("error: ").unwrap_or(&words).to_owned()
}

/// Returns the similar words of a tip; other tips are about the syntax of arguments, which is rarely the fault.
fn similar(tip: &str) -> Option<String> {
    let (what, words) = tip.split_once(": ").unwrap_or_default();
    what.contains("similar").then(|| format!("did you mean {words}?"))
}

/// Replaces the reasons of the standard library by the values that are possible.
fn plain(line: &str) -> String {
    const REASONS: [(&str, &str); 4] = [
        ("invalid digit found in string", "write a whole number, 0 or greater"),
        (
            "cannot parse integer from empty string",
            "write a whole number, 0 or greater",
        ),
        ("number too large to fit in target type", "the number is too large"),
        (
            "invalid socket address syntax",
            "write an address and a port, as in 127.0.0.1:8600",
        ),
    ];
    let replaced = |line: String, (reason, words): (&str, &str)| line.replace(reason, words);
    let line = REASONS.into_iter().fold(line.to_owned(), replaced);
    // A number outside a range: `-1 is not in 0..=255`.
    match line
        .rsplit_once(" is not in ")
        .and_then(|(head, range)| Some((head.rsplit_once(": ")?.0, range.split_once("..=")?)))
    {
        Some((head, (low, high))) => format!("{head}: it must lie between {low} and {high}"),
        None => line,
    }
}

/// Returns clap's message about wrong usage of `program` in one line. `words` are the command line, with the program.
pub fn usage_line(error: &clap::Error, program: &Command, words: &[String]) -> String {
    let first = words.get(1).and_then(|word| program.find_subcommand(word));
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        let within = first.filter(|command| command.has_subcommands());
        let shown = within
            .unwrap_or(program)
            .get_subcommands()
            .filter(|command| !command.is_hide_set());
        let commands: Vec<&str> = shown.map(Command::get_name).collect();
        let name = within.map_or_else(String::new, |command| format!(" {}", command.get_name()));
        return format!(
            "a command is missing; there are {} (see `koseki{name} --help`)",
            commands.join(", ")
        );
    }
    let what = negative_value(error, program, words)
        .or_else(|| unknown_option(error, program, words))
        .unwrap_or_else(|| refusal(error));
    format!("{what} (see `{} --help`)", command_of(program, words).0)
}

/// Returns the message about a negative number after an option. clap takes such a word for an option; joined to the
/// option with `=` it is a value, and is refused with the range.
fn negative_value(error: &clap::Error, program: &Command, words: &[String]) -> Option<String> {
    if error.kind() != ErrorKind::UnknownArgument {
        return None;
    }
    let (_, options) = command_of(program, words);
    let takes_value = |word: &str| {
        let name = word.strip_prefix("--");
        let mut named = options.iter().filter(|option| option.get_long() == name);
        named.any(|option| name.is_some() && option.get_action().takes_values())
    };
    let is_negative = |word: &str| word.starts_with('-') && word.parse::<f64>().is_ok();
    let at = words
        .windows(2)
        .position(|pair| takes_value(&pair[0]) && is_negative(&pair[1]))?;
    let joined = format!("{}={}", words[at], words[at + 1]);
    let corrected = words[..at].iter().chain([&joined]).chain(&words[at + 2..]);
    match program.clone().try_get_matches_from(corrected) {
        Err(again) if again.kind() == ErrorKind::ValueValidation => Some(refusal(&again)),
        _ => Some(format!("a negative number follows its option with '=': write {joined}")),
    }
}

/// Returns the message about an unknown option of the command in `words`, with its place if the command has it, and
/// with the nearest known option otherwise.
fn unknown_option(error: &clap::Error, program: &Command, words: &[String]) -> Option<String> {
    let found = error
        .get(ContextKind::InvalidArg)
        .filter(|_| error.kind() == ErrorKind::UnknownArgument)?;
    let found = found.to_string();
    let name = found.strip_prefix("--")?;
    let (command, options) = command_of(program, words);
    let options: Vec<&str> = options.into_iter().filter_map(clap::Arg::get_long).collect();
    let meant = if options.contains(&name) {
        format!("; it follows the command: {command} {found}")
    } else {
        settings::nearest(name, &options).map_or_else(String::new, |near| format!("; did you mean --{near}?"))
    };
    Some(format!("unexpected argument '{found}' found{meant}"))
}

/// Returns the full name of the command in `words`, and its options. The value of an option may have the name of a
/// command: such words are commands only if there is no other one.
fn command_of<'a>(program: &'a Command, words: &[String]) -> (String, Vec<&'a clap::Arg>) {
    let is_value = |before: &String| {
        before
            .strip_prefix("--")
            .is_some_and(|option| has_value(program, option))
    };
    let pairs = || words.iter().zip(words.iter().skip(1));
    let certain = pairs().filter(|(before, _)| !is_value(before));
    let found = command_in(program, certain.map(|(_, word)| word));
    let (name, command) = found.unwrap_or_else(|| {
        let all = command_in(program, words.iter().skip(1));
        all.unwrap_or_else(|| (program.get_name().to_owned(), program))
    });
    (name, command.get_arguments().collect())
}

/// Returns the command that `words` name below `program`, with its full name.
fn command_in<'a, 'w>(program: &'a Command, words: impl Iterator<Item = &'w String>) -> Option<(String, &'a Command)> {
    let mut found = None;
    for word in words {
        let (name, command) = found
            .clone()
            .unwrap_or_else(|| (program.get_name().to_owned(), program));
        if let Some(below) = command.find_subcommand(word) {
            found = Some((format!("{name} {}", below.get_name()), below));
        }
    }
    found
}

/// Whether a command below `program` has an option of this name with a value.
fn has_value(program: &Command, name: &str) -> bool {
    let is_it = |arg: &clap::Arg| arg.get_long() == Some(name) && arg.get_action().takes_values();
    program.get_arguments().any(is_it) || program.get_subcommands().any(|below| has_value(below, name))
}

#[cfg(test)]
mod tests {
    use clap::Arg;

    use super::*;

    fn program() -> Command {
        let score = Command::new("score")
            .subcommand(Command::new("tracks"))
            .subcommand(Command::new("hidden").hide(true))
            .subcommand_required(true)
            .arg_required_else_help(true);
        let speed = Arg::new("speed").long("speed").value_parser(["1", "max"]);
        let options = ["for", "instance"].map(|name| Arg::new(name).long(name));
        let rate = Arg::new("rate").long("rate").value_parser(crate::values::above_zero);
        let up = Command::new("up")
            .arg(Arg::new("config").required(true))
            .args(options)
            .arg(speed)
            .arg(rate);
        Command::new("koseki")
            .subcommands([up, score])
            .subcommand_required(true)
            .arg_required_else_help(true)
    }

    fn line(words: &[&str]) -> String {
        let error = program().try_get_matches_from(words).unwrap_err();
        let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
        usage_line(&error, &program(), &words)
    }

    #[test]
    fn an_unknown_option_comes_with_the_nearest() {
        let said_of = |option: &str| line(&["koseki", "up", "a.toml", option, "5"]);
        let see = "(see `koseki up --help`)";
        let for_what = format!("unexpected argument '--fr' found; did you mean --for? {see}");
        assert_eq!(said_of("--fr"), for_what);
        let instance = format!("unexpected argument '--instnce' found; did you mean --instance? {see}");
        assert_eq!(said_of("--instnce"), instance);
        let unlike = format!("unexpected argument '--standby' found {see}");
        assert_eq!(said_of("--standby"), unlike);
    }

    #[test]
    fn an_option_before_its_command_gets_its_place() {
        for (words, place) in [
            (["koseki", "--for", "up", "a.toml"], "koseki up --for"),
            (["koseki", "--instance", "up", "a.toml"], "koseki up --instance"),
            (["koseki", "--instance", "score", "up"], "koseki up --instance"),
        ] {
            let line = line(&words);
            let expected = format!(
                "unexpected argument '{}' found; it follows the command: {place} ",
                words[1]
            );
            assert!(line.starts_with(&expected), "{line}");
        }
    }

    #[test]
    fn a_negative_number_is_a_value() {
        for (option, value) in [
            ("--rate", "-5"),
            ("--rate", "-0.5"),
            ("--rate", "-1e3"),
            ("--rate", "-inf"),
        ] {
            let line = line(&["koseki", "up", "a.toml", option, value]);
            let expected = format!("invalid value '{value}' for '--rate <rate>': it must be ");
            assert!(line.starts_with(&expected), "{line}");
        }
        let valid = line(&["koseki", "up", "a.toml", "--for", "-5"]);
        let expected = "a negative number follows its option with '=': write --for=-5 (see `koseki up --help`)";
        assert_eq!(valid, expected);
        let unlike = line(&["koseki", "up", "a.toml", "-5"]);
        assert!(unlike.starts_with("unexpected argument '-5' found"), "{unlike}");
    }

    #[test]
    fn wrong_usage_is_one_line() {
        let cases: [(&[&str], &str); 5] = [
            (
                &["koseki"],
                "a command is missing; there are up, score (see `koseki --help`)",
            ),
            (
                &["koseki", "score"],
                "a command is missing; there are tracks (see `koseki score --help`)",
            ),
            (&["koseki", "upp"], "(see `koseki --help`)"),
            (&["koseki", "up"], "(see `koseki up --help`)"),
            (
                &["koseki", "up", "a.toml", "--speed", "fast"],
                "(see `koseki up --help`)",
            ),
        ];
        for (words, end) in cases {
            let line = line(words);
            assert_eq!(line.lines().count(), 1, "{line}");
            assert!(!line.contains("error:") && line.ends_with(end), "{line}");
        }
    }
}

//! Mistakes on the command line: each is refused in one line that names what is wrong and what is possible.

use crate::common::Folder;

/// Command lines, and words that their refusals contain.
const MISTAKES: [(&str, &[&str]); 20] = [
    ("upp", &["unrecognized subcommand 'upp'", "'up'"]),
    (
        "recording",
        &["a command is missing", "info, cut, merge, repair, export"],
    ),
    ("--json status", &["it follows the command: koseki status --json"]),
    ("--once top", &["it follows the command: koseki top --once"]),
    ("demo --for -5", &["'-5'", "--for", "more than 0"]),
    ("demo --for -0.5", &["'-0.5'", "--for", "more than 0"]),
    ("demo --for=-5", &["'-5'", "--for", "more than 0"]),
    ("top --interval -1", &["'-1'", "--interval"]),
    ("demo --fr 5", &["did you mean --for?"]),
    (
        "track absent.csv",
        &["unexpected argument 'absent.csv'", "koseki track --help"],
    ),
    ("up absent.toml", &["absent.toml", "cannot be read"]),
    ("up there.toml", &["there.toml", "did you mean config/there.toml?"]),
    ("check there.toml", &["there.toml", "did you mean config/there.toml?"]),
    ("up .", &[".: cannot be read", "directory"]),
    ("up bad.csv", &["bad.csv:1", "key with no value"]),
    (
        "fuse --tracks absent.csv --out o.csv",
        &["absent.csv", "cannot be read"],
    ),
    (
        "fuse --tracks bad.csv --out o.csv",
        &["bad.csv", "column time_s is missing"],
    ),
    (
        "simulate --scenario nowhere --for 5 --out o",
        &["nowhere", "there are demo"],
    ),
    ("tap nothing --instance none", &["nothing", "no topic"]),
    ("top --instance none", &["no instance none runs", "koseki status"]),
];

#[test]
fn mistakes_are_refused_by_what_is_wrong() {
    let folder = Folder::new();
    folder.write("bad.csv", "a,b\n");
    std::fs::create_dir(folder.path("config")).unwrap();
    folder.write("config/there.toml", "");
    for (command, expected) in MISTAKES {
        let said = folder.refusal(command);
        assert!(!said.contains("error:"), "{command}: {said}");
        for words in expected {
            assert!(said.contains(words), "{command}: {words} is missing in {said}");
        }
    }
}

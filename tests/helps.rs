//! Pages of help: each command's `-h` and `--help` fit a terminal, and show what the executable does.

use crate::architecture::prose::assert_plain;
use crate::common::Folder;

/// Columns of a terminal.
const COLUMNS: usize = 80;
/// Commands of programs that are built apart, whose pages are in these programs.
const APART: [&str; 4] = ["bench", "torture", "init", "renew"];

/// Calls `look` with each command, by its words, and its page.
fn each_page(folder: &Folder, command: &str, look: &mut impl FnMut(&str, &str)) {
    for option in ["-h", "--help"] {
        let (page, said) = folder.succeed(&format!("{command} {option}"));
        assert!(said.is_empty(), "{command} {option}: {said}");
        look(&format!("{command} {option}"), &page);
    }
    let (page, _) = folder.succeed(&format!("{command} -h"));
    let below = page.split_once("\nCommands:\n").map_or("", |(_, below)| below);
    let lines = below.lines().take_while(|line| !line.is_empty());
    let names = lines.filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    for name in names.filter(|name| !name.is_empty() && *name != "help" && !APART.contains(name)) {
        each_page(folder, &format!("{command} {name}"), look);
    }
}

#[test]
fn every_page_of_help_fits_a_terminal_and_all_are_plain() {
    let folder = Folder::new();
    let (mut pages, mut wide, mut all) = (0, String::new(), String::new());
    each_page(&folder, "", &mut |command, page| {
        pages += 1;
        all += page;
        for line in page.lines().filter(|line| line.chars().count() > COLUMNS) {
            wide.push_str(&format!("{command}: {line}\n"));
        }
    });
    assert!(wide.is_empty(), "{wide}");
    assert!(pages > 80, "{pages}");
    assert_plain("the pages of help", &all);
}

#[test]
fn the_help_of_generate_shows_what_this_executable_generates() {
    let (page, _) = Folder::new().succeed("generate --help");
    for word in ["completions", "man"] {
        let shown = page.contains(&format!("koseki generate {word}"));
        assert_eq!(shown, page.contains(&format!("\n  {word} ")), "{word}: {page}");
    }
}

#[test]
fn the_place_of_the_base_folder_is_explained_once() {
    let folder = Folder::new();
    let mut explained = Vec::new();
    each_page(&folder, "", &mut |command, page| {
        explained.extend(page.contains("/run/koseki").then(|| command.trim().to_owned()));
    });
    assert_eq!(explained, ["-h", "--help"]);
}

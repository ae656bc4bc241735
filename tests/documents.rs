//! Documents: that what they tell a reader to type works, and what they show is what comes.

use std::collections::{BTreeMap, BTreeSet};

use test_support::assert_golden;

use crate::common::{Folder, repository, texts};

/// A fenced block: the word of its language, a file that it shows or makes, and its lines.
struct Block<'t> {
    language: &'t str,
    file: Option<&'t str>,
    text: String,
}

fn blocks(document: &str) -> Vec<Block<'_>> {
    let (mut blocks, mut open): (Vec<Block<'_>>, Option<Block<'_>>) = (Vec::new(), None);
    for line in document.lines() {
        match (line.strip_prefix("```"), &mut open) {
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (Some(info), None) => {
                let mut words = info.split_whitespace();
                open = Some(Block {
                    language: words.next().unwrap_or_default(),
                    file: words.next(),
                    text: String::new(),
                });
            }
            (None, Some(block)) => block.text += &format!("{line}\n"),
            (None, None) => {}
        }
    }
    blocks
}

#[test]
fn the_first_hour_is_as_it_is_told() {
    let document = std::fs::read_to_string(repository("docs/first-hour.md")).unwrap();
    let folder = Folder::new();
    std::fs::create_dir(folder.path("config")).unwrap();
    std::fs::copy(repository("config/live.toml"), folder.path("config/live.toml")).unwrap();
    let (mut commands, mut shown) = (0, 0);
    for block in blocks(&document) {
        match (block.language, block.file) {
            ("sh", _) => {
                for command in block.text.lines().filter_map(|line| line.strip_prefix("koseki ")) {
                    folder.succeed(command);
                    commands += 1;
                }
            }
            ("text", Some(file)) => {
                let found = folder.read(file);
                let lines: BTreeSet<&str> = found.lines().collect();
                for line in block.text.lines() {
                    assert!(lines.contains(line), "{file} has no line {line:?}");
                    shown += 1;
                }
            }
            (_, Some(file)) => folder.write(file, block.text),
            _ => {}
        }
    }
    assert!(commands >= 5 && shown >= 5, "{commands} commands, {shown} lines shown");
    assert_golden(&repository("docs/pictures/fused.svg"), &folder.read("fused.svg"));
}

/// Every `koseki …` in code that a document shows, in a sentence or in a block.
fn commands(document: &str) -> Vec<String> {
    let in_blocks = blocks(document).into_iter().flat_map(|block| {
        let lines = block.text.lines().map(str::trim_start).map(str::to_owned);
        lines.collect::<Vec<_>>()
    });
    let in_sentences = document
        .lines()
        .flat_map(|line| line.split('`').skip(1).step_by(2).map(str::to_owned));
    let all = in_blocks.chain(in_sentences);
    let command = |text: String| Some(text.strip_prefix("koseki ")?.to_owned());
    all.filter_map(command).collect()
}

#[test]
fn commands_and_options_that_documents_name_exist() {
    let folder = Folder::new();
    let mut helps: BTreeMap<String, String> = BTreeMap::new();
    let mut named = 0;
    // Requirements name what is asked for, there already or not.
    let documents = texts(&["md"]).into_iter();
    for (path, text) in documents.filter(|(path, _)| !path.ends_with("requirements.md")) {
        for command in commands(&text) {
            let words: Vec<&str> = command
                .split_whitespace()
                .take_while(|word| !["#", "|", "&"].contains(word))
                .collect();
            let Some(first) = words
                .first()
                .filter(|word| word.chars().all(|c| c.is_ascii_lowercase()))
            else {
                continue;
            };
            let is_nested = matches!(*first, "bench" | "compare" | "recording" | "score");
            let second = words
                .get(1)
                .filter(|word| is_nested && word.chars().all(|c| c.is_ascii_lowercase()));
            let subcommand = second.map_or((*first).to_owned(), |second| format!("{first} {second}"));
            let help = helps
                .entry(subcommand.clone())
                .or_insert_with(|| folder.succeed(&format!("{subcommand} --help")).0);
            for option in words.iter().filter_map(|word| word.strip_prefix("--")) {
                let option = option.split(['=', ',', ')', ';', '.', ':']).next().unwrap();
                assert!(
                    help.contains(&format!("--{option}")),
                    "{path}: koseki {subcommand} has no --{option}"
                );
                named += 1;
            }
        }
    }
    assert!(
        named > 50 && helps.len() > 10,
        "{named} options of {} commands",
        helps.len()
    );
}

#[test]
fn what_documents_link_to_is_there() {
    for (path, text) in texts(&["md"]) {
        let folder = std::path::Path::new(&path).parent().unwrap().to_owned();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = link.split('#').next().unwrap();
            if !file.is_empty() && !file.contains("://") {
                let target = repository("").join(&folder).join(file);
                assert!(target.exists(), "{path} links to {link}");
            }
        }
    }
}

#[test]
fn the_kinds_of_orders_are_those_of_the_registry() {
    let document = std::fs::read_to_string(repository("docs/orders.md")).unwrap();
    for kind in messages::OrderKind::ALL {
        let row = format!("| `{}` | {} |\n", kind.usage(), kind.summary());
        assert!(document.contains(&row), "docs/orders.md lacks: {row}");
    }
}

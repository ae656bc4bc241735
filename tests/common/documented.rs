//! What documents of the repository show and name.

use std::collections::BTreeMap;
use std::fs;

use super::{Folder, repository};

/// Files of the repository with one of these extensions, by their path there, with their texts.
pub(crate) fn texts(extensions: &[&str]) -> Vec<(String, String)> {
    let top = repository("").canonicalize().unwrap();
    let (mut folders, mut found) = (vec![top.clone()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap();
            if path.is_dir() {
                if !name.starts_with('.') && !["target", "records"].contains(&name) {
                    folders.push(path);
                }
            } else if extensions
                .iter()
                .any(|extension| path.extension() == Some(extension.as_ref()))
            {
                let inside = path.strip_prefix(&top).unwrap().to_str().unwrap().to_owned();
                found.push((inside, fs::read_to_string(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

/// A fenced block: the word of its language, a file that it shows or makes, and its lines.
pub(crate) struct Block<'t> {
    pub(crate) language: &'t str,
    pub(crate) file: Option<&'t str>,
    pub(crate) text: String,
}

pub(crate) fn blocks(document: &str) -> Vec<Block<'_>> {
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

/// Checks that the commands which documents name, and for which `is_checked`, have the options named with them.
/// Returns the number of options, and of commands.
pub(crate) fn check_named_options(folder: &Folder, is_checked: impl Fn(&str) -> bool) -> (usize, usize) {
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
                .filter(|word| word.chars().all(|c| c.is_ascii_lowercase()) && is_checked(word))
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
    (named, helps.len())
}

//! Documents: that what they tell a reader to type works, and what they show is what comes.

use std::collections::BTreeSet;

use test_support::assert_golden;

use crate::common::documented::{blocks, check_named_options};
use crate::common::{Folder, repository, texts};

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

/// Commands that koseki-lab executes; its own tests check them.
const OF_LAB: [&str; 2] = ["bench", "torture"];

#[test]
fn commands_and_options_that_documents_name_exist() {
    let (named, helps) = check_named_options(&Folder::new(), |command| !OF_LAB.contains(&command));
    assert!(named > 50 && helps > 10, "{named} options of {helps} commands");
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

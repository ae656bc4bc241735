//! What the workspace depends on, against the lists of `deny.toml`, for where cargo-deny is not installed.

use std::path::Path;

use cargo_metadata::MetadataCommand;

use crate::common::repository;

/// The texts in the list called `name`.
fn list(text: &str, name: &str) -> Vec<String> {
    let (_, behind) = text.split_once(&format!("{name} = [")).unwrap();
    let (inside, _) = behind
        .split_once("\n]")
        .unwrap_or_else(|| behind.split_once(']').unwrap());
    inside.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Whether an expression such as `(MIT OR Apache-2.0) AND Unicode-3.0` can be met with these licences.
fn is_met(expression: &str, allowed: &[String]) -> bool {
    let flat = expression.replace(['(', ')'], "").replace('/', " OR ");
    let choice = |choices: &str| {
        choices
            .split(" OR ")
            .any(|licence| allowed.iter().any(|known| known == licence.trim()))
    };
    flat.split(" AND ").all(choice)
}

#[test]
fn dependencies_come_from_the_registry_under_licences_that_are_listed() {
    let rules = std::fs::read_to_string(repository("deny.toml")).unwrap();
    let allowed = list(&rules, "allow");
    assert!(allowed.iter().any(|licence| licence == "MIT"));
    let banned: Vec<&str> = rules
        .lines()
        .filter_map(|line| line.trim().strip_prefix("{ name = \"")?.split('"').next())
        .collect();
    assert!(!banned.is_empty());
    let options = ["--offline", "--filter-platform", "x86_64-unknown-linux-gnu"];
    let metadata = MetadataCommand::new()
        .manifest_path(repository("Cargo.toml"))
        .other_options(options.map(str::to_owned).to_vec())
        .exec()
        .unwrap();
    let mut seen = 0;
    for package in metadata.packages.iter().filter(|package| package.source.is_some()) {
        let (name, source) = (package.name.as_str(), package.source.as_ref().unwrap().to_string());
        assert!(source.ends_with("/crates.io-index"), "{name} comes from {source}");
        let licence = package.license.as_deref().unwrap_or_default();
        assert!(
            is_met(licence, &allowed),
            "{name} is under {licence:?}, which deny.toml does not allow"
        );
        assert!(!banned.contains(&name), "{name} is banned by deny.toml");
        seen += 1;
    }
    assert!(seen > 100, "{seen}");
}

#[test]
fn licences_are_met_by_one_choice_of_each_part() {
    let allowed = ["MIT".to_owned(), "Unicode-3.0".to_owned()];
    assert!(is_met("(MIT OR Apache-2.0) AND Unicode-3.0", &allowed) && is_met("Unlicense/MIT", &allowed));
    assert!(!is_met("MIT AND GPL-3.0", &allowed) && !is_met("", &allowed));
}

/// Texts of all Rust files in the folder of a target's root file, of that file, and of files elsewhere that they name.
fn sources(root: &Path) -> String {
    let mut text = String::new();
    let mut folders = vec![root.parent().unwrap().to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() {
                folders.push(entry);
            } else if entry.extension().is_some_and(|ending| ending == "rs") {
                let own = std::fs::read_to_string(entry).unwrap();
                let named = own
                    .lines()
                    .filter_map(|line| line.strip_prefix("#[path = \"")?.strip_suffix("\"]"));
                for file in named.filter(|file| file.starts_with("../")) {
                    text.push_str(&std::fs::read_to_string(folder.join(file)).unwrap());
                }
                text.push_str(&own);
            }
        }
    }
    text
}

#[test]
fn every_dependency_is_used() {
    let mut unused = Vec::new();
    let workspaces = ["", "lab/", "link/", "c/", "python/"].map(|folder| format!("{folder}Cargo.toml"));
    for workspace in &workspaces {
        let metadata = MetadataCommand::new()
            .manifest_path(repository(workspace))
            .no_deps()
            .other_options(vec!["--offline".to_owned()])
            .exec()
            .unwrap();
        for package in metadata.workspace_packages() {
            let texts = |is_product: bool| -> String {
                let targets = package.targets.iter().filter(|target| {
                    let is_own = target.is_lib() || target.is_bin() || target.is_custom_build();
                    is_own || target.is_cdylib() || target.is_staticlib() || !is_product
                });
                targets.map(|target| sources(target.src_path.as_std_path())).collect()
            };
            // Tests share files that lie beside their own folders.
            let all = texts(false) + &sources(package.manifest_path.as_std_path());
            let product = texts(true);
            for dependency in &package.dependencies {
                let name = dependency.rename.as_ref().unwrap_or(&dependency.name).replace('-', "_");
                let text = match dependency.kind {
                    cargo_metadata::DependencyKind::Development => &all,
                    _ => &product,
                };
                let word = |(place, _): (usize, &str)| {
                    let end = text[place + name.len()..].chars().next();
                    let before = text[..place].chars().next_back();
                    ![before, end]
                        .iter()
                        .flatten()
                        .any(|letter| letter.is_alphanumeric() || *letter == '_')
                };
                if !text.match_indices(&name).any(word) {
                    unused.push(format!("{}: {}", package.name, dependency.name));
                }
            }
        }
    }
    assert!(unused.is_empty(), "dependencies that no file uses: {unused:?}");
}

//! Product code as text: sources without their test modules.

use std::collections::BTreeSet;
use std::path::Path;

use cargo_metadata::Package;

/// A source file of a package.
pub(crate) struct Source {
    /// Path from the package's `src`, like `rules/mod.rs`.
    pub(crate) path: String,
    /// The text without test modules.
    pub(crate) text: String,
}

/// Every source file of a package that is not a test module.
pub(crate) fn sources(package: &Package) -> Vec<Source> {
    let top = package.manifest_path.parent().unwrap().join("src").into_std_path_buf();
    let (mut folders, mut found, mut of_tests) = (vec![top.clone()], Vec::new(), BTreeSet::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let (text, modules) = without_test_modules(&std::fs::read_to_string(&path).unwrap());
                for module in modules {
                    of_tests.insert(folder_of_modules(&path).join(&module));
                    of_tests.insert(path.with_file_name(module));
                }
                found.push((path, text));
            }
        }
    }
    let is_product = |path: &Path| {
        !of_tests
            .iter()
            .any(|test| path == test.with_extension("rs") || path.starts_with(test))
    };
    let product = found.into_iter().filter(|(path, _)| is_product(path));
    let relative = |path: &Path| path.strip_prefix(&top).unwrap().to_str().unwrap().to_owned();
    product
        .map(|(path, text)| Source {
            path: relative(&path),
            text,
        })
        .collect()
}

/// Where the modules lie that a file declares.
fn folder_of_modules(path: &Path) -> std::path::PathBuf {
    match path.file_stem().and_then(|name| name.to_str()) {
        Some("lib" | "main" | "mod") => path.parent().unwrap().to_owned(),
        _ => path.with_extension(""),
    }
}

/// A text without modules that are compiled for tests only, and the names (without `.rs`) of those that are files.
fn without_test_modules(text: &str) -> (String, Vec<String>) {
    let (mut product, mut files) = (String::new(), Vec::new());
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line.trim() != "#[cfg(test)]" {
            product += line;
            product.push('\n');
            continue;
        }
        let mut path = None;
        let mut item = lines.next().unwrap_or_default();
        while item.trim_start().starts_with("#[") {
            let value = item
                .trim()
                .strip_prefix("#[path = \"")
                .and_then(|rest| rest.strip_suffix(".rs\"]"));
            path = path.or(value.map(str::to_owned));
            item = lines.next().unwrap_or_default();
        }
        let declared = item.trim_start().trim_start_matches("pub(crate) ").strip_prefix("mod ");
        match declared {
            Some(name) if name.ends_with(';') => {
                files.push(path.unwrap_or_else(|| name.trim_end_matches(';').to_owned()))
            }
            Some(_) => {
                // To the brace that closes it, which stands where the item began.
                let end = format!("{}}}", &item[..item.len() - item.trim_start().len()]);
                lines.by_ref().find(|line| *line == end);
            }
            None => {
                product += item;
                product.push('\n');
            }
        }
    }
    (product, files)
}

#[test]
fn what_stands_behind_a_test_module_is_product() {
    let text = "a\n#[cfg(test)]\nmod tests {\n    b\n}\n#[cfg(test)]\n#[path = \"x_tests.rs\"]\nmod x;\n#[cfg(test)]\nfn c() {}\nd\n";
    let (product, files) = without_test_modules(text);
    assert_eq!(product, "a\nfn c() {}\nd\n");
    assert_eq!(files, ["x_tests"]);
}

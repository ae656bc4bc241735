//! Cycles of modules inside a crate, as far as their `use crate::…` and `use super::…` lines tell.
//!
//! A cycle means that none of its modules can be understood, tested or moved alone. Each file is a module here; what
//! the crate's root gives on under a shorter path (`crate::Engine`) counts for the module that it comes from. `super::`
//! paths count between siblings and their children. They do not count from a module to its parents, and `self::` paths
//! do not count: a parent and its children may use each other.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::source::Source;

/// Groups of modules each of which uses, over others of the group, itself.
pub(crate) fn cycles(sources: &[Source]) -> Vec<Vec<String>> {
    let modules: BTreeMap<String, &Source> = sources.iter().map(|source| (module(&source.path), source)).collect();
    let root = modules.get("").map(|source| uses(&source.text)).unwrap_or_default();
    let given_on: BTreeMap<&str, &str> = root
        .iter()
        .filter_map(|path| path.rsplit_once("::").map(|(of, name)| (name, of)))
        .collect();
    let find = |path: &str| {
        let first = path.split("::").next().unwrap_or_default();
        let is_module = modules
            .keys()
            .any(|module| module == first || module.starts_with(&format!("{first}::")));
        let mut path = match given_on.get(first) {
            Some(of) if !is_module => of.trim_start_matches("crate::"),
            _ => path,
        };
        while !modules.contains_key(path) {
            path = path.rsplit_once("::").map_or("", |(of, _)| of);
        }
        path.to_owned()
    };
    let mut edges: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (name, source) in modules.iter().filter(|(name, _)| !name.is_empty()) {
        let used = uses(&source.text);
        let absolute = used.iter().filter_map(|path| path.strip_prefix("crate::")).map(find);
        let relative = used.iter().filter_map(|path| absolute_path(name, path));
        let relative = relative.map(|path| find(&path)).filter(|of| !is_parent(of, name));
        let used = absolute.chain(relative);
        edges.insert(name.clone(), used.filter(|of| of != name && !of.is_empty()).collect());
    }
    groups(&edges)
}

/// Circles of the modules of a Python package in a folder; an import inside a function counts as one at the top.
pub(crate) fn python_cycles(folder: &Path) -> Vec<Vec<String>> {
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let files = files.filter(|path| path.extension().is_some_and(|extension| extension == "py"));
    let texts: BTreeMap<String, String> = files
        .map(|path| {
            let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
            (name, std::fs::read_to_string(path).unwrap())
        })
        .collect();
    let used = |text: &str| -> BTreeSet<String> {
        let lines = text.lines().map(str::trim);
        let imports = lines.filter_map(|line| line.strip_prefix("from .")?.split_once(" import "));
        let names = imports.flat_map(|(of, names)| match of {
            "" => names.split(',').map(|name| name.trim().to_owned()).collect(),
            of => vec![of.to_owned()],
        });
        names.filter(|name| texts.contains_key(name)).collect()
    };
    let edges = texts.iter().map(|(name, text)| (name.clone(), used(text)));
    groups(&edges.collect())
}

/// Groups of modules each of which uses, over others of the group, itself.
fn groups(edges: &BTreeMap<String, BTreeSet<String>>) -> Vec<Vec<String>> {
    let reach: BTreeMap<&String, BTreeSet<&String>> = edges.keys().map(|from| (from, reachable(from, edges))).collect();
    let mut groups = BTreeSet::new();
    for (name, reached) in &reach {
        let group: Vec<String> = reached
            .iter()
            .filter(|other| reach[**other].contains(name))
            .map(|other| (*other).clone())
            .collect();
        if group.len() > 1 {
            groups.insert(group);
        }
    }
    groups.into_iter().collect()
}

/// All modules that one uses, over others, too.
fn reachable<'a>(from: &str, edges: &'a BTreeMap<String, BTreeSet<String>>) -> BTreeSet<&'a String> {
    let mut found = BTreeSet::new();
    let mut next: Vec<&String> = edges[from].iter().collect();
    while let Some(name) = next.pop() {
        if found.insert(name) {
            next.extend(&edges[name]);
        }
    }
    found
}

/// The path from the crate's root of a path in `module` that begins with `super::`.
fn absolute_path(module: &str, path: &str) -> Option<String> {
    let mut rest = path.strip_prefix("super::")?;
    let mut above = module.rsplit_once("::").map_or("", |(above, _)| above);
    while let Some(further) = rest.strip_prefix("super::") {
        rest = further;
        above = above.rsplit_once("::").map_or("", |(above, _)| above);
    }
    Some(format!("{above}::{rest}").trim_start_matches("::").to_owned())
}

fn is_parent(parent: &str, module: &str) -> bool {
    module.strip_prefix(parent).is_some_and(|child| child.starts_with("::"))
}

/// The module in a file: `rules::auto` in `rules/auto.rs`, `rules` in `rules/mod.rs`, nothing in `lib.rs`.
fn module(path: &str) -> String {
    let path = path.trim_end_matches(".rs").trim_end_matches("/mod");
    match path {
        "lib" | "main" => String::new(),
        _ => path.replace('/', "::"),
    }
}

/// Every path that a text uses, each with all its parts. `super::` in an indented line may be that of an inline module,
/// so it is skipped.
fn uses(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let statement = ["pub(crate) ", "pub(super) ", "pub "]
            .iter()
            .find_map(|visibility| line.trim().strip_prefix(visibility))
            .unwrap_or(line.trim());
        let Some(first) = statement.strip_prefix("use ") else {
            continue;
        };
        let mut tree = first.to_owned();
        while !tree.ends_with(';') {
            tree += lines.next().expect("a statement ends").trim();
        }
        if line.starts_with(' ') && tree.starts_with("super::") {
            continue;
        }
        expand("", tree.trim_end_matches(';'), &mut found);
    }
    found
}

/// The paths of a tree like `crate::{a::B, c}`.
fn expand(before: &str, tree: &str, found: &mut Vec<String>) {
    let tree = tree.trim();
    let Some((head, rest)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().unwrap_or_default().trim();
        if !path.is_empty() {
            found.push(format!("{before}{path}"));
        }
        return;
    };
    let before = format!("{before}{head}");
    let inside = rest.strip_suffix('}').expect("its brace is closed");
    let (mut depth, mut begin) = (0, 0);
    for (at, character) in inside.char_indices() {
        match character {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                expand(&before, &inside[begin..at], found);
                begin = at + 1;
            }
            _ => {}
        }
    }
    expand(&before, &inside[begin..], found);
}

#[test]
fn cycles_are_found_over_several_modules_and_shorter_paths() {
    let source = |path: &str, text: &str| Source {
        path: path.to_owned(),
        text: text.to_owned(),
    };
    let mut sources = vec![
        source(
            "lib.rs",
            "mod a;\nmod b;\nmod c;\npub use b::{Bee, inner::Deep as D};\n",
        ),
        source(
            "a.rs",
            "use std::fmt;\nuse crate::Bee;\n\nfn a() {\n    let x = 1;\n    use crate::c::C;\n}\n",
        ),
        source("b/mod.rs", "use crate::{\n    c::{C, Other},\n    d,\n};\n"),
        source("c.rs", "pub(crate) use crate::e::E;\n"),
        source("d.rs", ""),
        source("e.rs", "// use crate::a::A;\n"),
    ];
    assert_eq!(cycles(&sources), [[""; 0]; 0]);
    sources[5].text += "use crate::a::A;\n";
    assert_eq!(cycles(&sources), [["a", "b", "c", "e"]]);
}

#[test]
fn cycles_are_found_over_relative_paths() {
    let source = |path: &str, text: &str| Source {
        path: path.to_owned(),
        text: text.to_owned(),
    };
    let mut sources = vec![
        source("lib.rs", "mod a;\nmod top;\n"),
        source("a/mod.rs", "use crate::a::b::Bee;\nuse crate::a::c::d::Deep;\n"),
        source("a/b.rs", "pub(super) use super::{\n    A,\n    c::d::Deep,\n};\n"),
        source("a/c/mod.rs", ""),
        source(
            "a/c/d.rs",
            "use super::super::A;\nmod inline {\n    use super::super::super::top::Top;\n}\n",
        ),
        source("top.rs", "use super::a::A;\n"),
    ];
    assert_eq!(cycles(&sources), [[""; 0]; 0], "a child may use its parent");
    sources[4].text += "use super::super::b::Bee;\n";
    assert_eq!(cycles(&sources), [["a::b", "a::c::d"]]);
    sources[4].text += "use super::super::super::top::Top;\n";
    assert_eq!(cycles(&sources), [["a", "a::b", "a::c::d", "top"]]);
}

#[test]
fn cycles_are_found_among_python_modules() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "__init__.py",
        "from . import b\nfrom .a import A\nfrom . import _compiled\n",
    );
    write("a.py", "import numpy as np\n\ndef f():\n    from . import b\n");
    write("b.py", "from .c import C, D\n");
    write("c.py", "");
    assert_eq!(python_cycles(folder.path()), [[""; 0]; 0]);
    write("c.py", "    from . import _compiled, a\n");
    assert_eq!(python_cycles(folder.path()), [["a", "b", "c"]]);
}

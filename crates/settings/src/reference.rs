//! All keys for people: as a document, and as a text for a terminal.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::{Key, KeyTable, KeyValue, unit_of};

/// Text of an option that is `None`.
const OFF: &str = "\"off\"";

/// A document in Markdown with a section for each table of `files`, which are (title, sentence, table): name, type,
/// unit, range, default and text of every key. A table that stands at several places is written once.
pub fn reference(files: &[(&str, &str, &dyn KeyTable)]) -> String {
    let mut out = String::new();
    let mut written = BTreeMap::new();
    for (title, text, table) in files {
        let _ = writeln!(out, "\n## {title}\n\n{text}");
        section(&mut out, &mut written, title, "", *table);
    }
    out
}

fn section(out: &mut String, written: &mut BTreeMap<String, String>, file: &str, path: &str, table: &dyn KeyTable) {
    if !path.is_empty() {
        let _ = writeln!(out, "\n### `{path}`\n\n{}", joined(table.doc()));
    }
    let place = if path.is_empty() {
        format!("*{file}*")
    } else {
        format!("`{path}` (*{file}*)")
    };
    let mut fresh = Vec::new();
    let bases = table.bases();
    // A table that only joins others has no keys to write.
    let own = (bases.is_empty() || !table.keys().is_empty()).then_some(table);
    for part in bases.into_iter().chain(own) {
        if table_once(out, written, &place, part) {
            fresh.extend(part.keys().into_iter().zip(part.values()));
        }
    }
    for (key, value) in fresh {
        let Some(inner) = value.table() else { continue };
        let name = key.name;
        let path = match (path.trim_matches(['[', ']']), value.kind().starts_with("list")) {
            ("", false) => format!("[{name}]"),
            ("", true) => format!("[[{name}]]"),
            (before, false) => format!("[{before}.{name}]"),
            (before, true) => format!("[[{before}.{name}]]"),
        };
        section(out, written, file, &path, &*inner);
    }
}

/// Writes the keys of a table, or a reference to their first place; returns whether the keys were written.
fn table_once(out: &mut String, written: &mut BTreeMap<String, String>, place: &str, table: &dyn KeyTable) -> bool {
    let rows = rows(table);
    match written.get(&rows) {
        Some(before) => {
            let _ = writeln!(out, "\nThe keys of {before} stand here, too.");
            false
        }
        None => {
            out.push_str(&rows);
            written.insert(rows, place.to_owned());
            true
        }
    }
}

fn rows(table: &dyn KeyTable) -> String {
    let mut out = String::new();
    let own: Vec<_> = table.keys().into_iter().zip(table.values()).collect();
    if own.is_empty() {
        return "\nIt has no keys of its own.\n".to_owned();
    }
    let _ = writeln!(
        out,
        "\n| Key | Type | Unit | Range | Default | |\n|---|---|---|---|---|---|"
    );
    for (key, value) in own {
        let (unit, range) = (unit_of(key.name), key.range.text());
        let default = match (key.usually, key.is_required, value.table()) {
            (Some(words), ..) => words.to_owned(),
            (None, true, _) => "*must be given*".to_owned(),
            (None, false, Some(_)) if value.text().is_empty() => "*its own defaults*".to_owned(),
            (None, false, _) => format!("`{}`", value.text()),
        };
        let (kind, doc) = (value.kind().replace('|', "\\|"), joined(key.doc).replace('|', "\\|"));
        let _ = writeln!(
            out,
            "| `{}` | {kind} | {unit} | {range} | {default} | {doc} |",
            key.name
        );
    }
    out
}

/// The keys of a table and of its bases.
fn all(table: &dyn KeyTable) -> Vec<(&'static Key, &dyn KeyValue)> {
    let own = table.keys().into_iter().zip(table.values());
    own.chain(table.bases().into_iter().flat_map(all)).collect()
}

/// Returns a line per key with its default and the first sentence of its documentation, in the form of a file, each
/// line after `indent`. Tables follow the keys of their parent.
pub fn help(table: &dyn KeyTable, indent: &str) -> String {
    let mut out = String::new();
    help_table(&mut out, table, indent, "");
    out
}

fn help_table(out: &mut String, table: &dyn KeyTable, indent: &str, path: &str) {
    let (tables, leaves): (Vec<_>, Vec<_>) = all(table).into_iter().partition(|(_, value)| value.table().is_some());
    for (key, value) in leaves {
        let default = match (key.usually, key.is_required) {
            (Some(words), _) => format!("[{words}]"),
            (None, true) => "[must be given]".to_owned(),
            (None, false) => format!("= {}", value.text()),
        };
        help_line(out, indent, &format!("{} {default}", key.name), &sentence(key.doc));
    }
    for (key, value) in tables {
        let Some(inner) = value.table() else { continue };
        let path = if path.is_empty() {
            key.name.to_owned()
        } else {
            format!("{path}.{}", key.name)
        };
        let header = match value.kind().starts_with("list") {
            true => format!("[[{path}]]"),
            false => format!("[{path}]"),
        };
        let off = if value.text() == OFF { "; off unless given" } else { "" };
        help_line(out, indent, &header, &format!("{}{off}", sentence(key.doc)));
        help_table(out, &*inner, indent, &path);
    }
}

/// Column of the comments, and greatest width of a line.
const COMMENT_AT: usize = 30;
const LINE: usize = 80;

/// Writes a line in the form of a file, with a comment of as many lines as necessary.
fn help_line(out: &mut String, indent: &str, text: &str, comment: &str) {
    let mut line = format!("{text:<COMMENT_AT$} #");
    if text.chars().count() > COMMENT_AT {
        let _ = writeln!(out, "{indent}{text}");
        line = format!("{:<COMMENT_AT$} #", "");
    }
    for word in comment.split_whitespace() {
        if indent.len() + line.chars().count() + 1 + word.chars().count() > LINE {
            let _ = writeln!(out, "{indent}{line}");
            line = format!("{:<COMMENT_AT$} #", "");
        }
        line.push(' ');
        line.push_str(word);
    }
    let _ = writeln!(out, "{indent}{line}");
}

/// The lines of a document text as one.
fn joined(doc: &str) -> String {
    doc.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The first sentence.
fn sentence(doc: &str) -> String {
    let doc = joined(doc);
    let end = doc.find(". ").unwrap_or(doc.len());
    doc[..end].trim_end_matches('.').to_owned()
}

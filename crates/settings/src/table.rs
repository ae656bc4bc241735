//! Reading and checking tables.

use toml::de::DeValue;

use crate::leaves::found;
use crate::{Key, KeyTable, Node, Place, SettingsError};

/// Reads the table at `at`; keys missing in the file keep their values.
///
/// # Errors
/// If the node is no table, has unknown keys, lacks a mandatory key, or has invalid values.
pub fn read_table(table: &mut dyn KeyTable, node: &Node<'_>, at: &Place<'_>) -> Result<(), SettingsError> {
    let DeValue::Table(given) = node.get_ref() else {
        let what = format!("{} is no table; write its keys below [{at}]", found(node));
        return Err(at.error(what));
    };
    for (name, node) in given {
        let name = name.get_ref();
        if !read_key(table, name, node, &at.key(name))? {
            let names: Vec<&str> = keys(table).into_iter().map(|key| key.name).collect();
            let meant = nearest(name, &names).map_or_else(String::new, |near| format!("; did you mean {near}?"));
            let names = if names.is_empty() { vec!["none"] } else { names };
            let what = format!("unknown key; there are: {}{meant}", names.join(", "));
            return Err(at.key(name).error(what));
        }
    }
    let missing = |key: &&Key| key.is_required && !given.contains_key(key.name);
    if let Some(key) = keys(table).into_iter().find(missing) {
        return Err(at.key(key.name).error("missing; the key is mandatory"));
    }
    check_all_together(table, at)
}

/// Returns the most similar of `names`, if similar enough to `name` for a misspelling: much alike, or with one letter
/// missing, added, exchanged or wrong.
pub fn nearest<'a>(name: &str, names: &[&'a str]) -> Option<&'a str> {
    let similar = names.iter().map(|known| (strsim::jaro_winkler(name, known), *known));
    let (similarity, known) = similar.max_by(|(a, _), (b, _)| a.total_cmp(b))?;
    let is_near = |known: &&&str| name.len() > 1 && strsim::damerau_levenshtein(name, known) == 1;
    let near = names.iter().find(is_near).copied();
    (similarity > 0.85).then_some(known).or(near)
}

/// Reads a key of a table or of a base of the table; returns whether the key exists.
fn read_key(table: &mut dyn KeyTable, name: &str, node: &Node<'_>, at: &Place<'_>) -> Result<bool, SettingsError> {
    let own = table.keys();
    if let Some(index) = own.iter().position(|key| key.name == name) {
        let range = own[index].range;
        return table.values_mut()[index].read(node, range, at).map(|()| true);
    }
    for base in table.bases_mut() {
        if read_key(base, name, node, at)? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Returns the table's own keys and the keys of its bases.
fn keys(table: &dyn KeyTable) -> Vec<&'static Key> {
    let own = table.keys().into_iter();
    own.chain(table.bases().into_iter().flat_map(keys)).collect()
}

fn check_all_together(table: &dyn KeyTable, at: &Place<'_>) -> Result<(), SettingsError> {
    table
        .bases()
        .into_iter()
        .try_for_each(|base| check_all_together(base, at))?;
    table.check_together().map_err(|error| error.under(&at.to_string()))
}

/// Checks every value of a table that stands at `at`.
///
/// # Errors
/// The first value that cannot be used.
pub fn check_table(table: &dyn KeyTable, at: &Place<'_>) -> Result<(), SettingsError> {
    table.bases().into_iter().try_for_each(|base| check_table(base, at))?;
    let mut all = table.keys().into_iter().zip(table.values());
    all.try_for_each(|(key, value)| value.check(key.range, &at.key(key.name)))?;
    table.check_together().map_err(|error| error.under(&at.to_string()))
}

/// Checks every value of settings that no file gave.
///
/// # Errors
/// The first value that cannot be used.
pub fn check(table: &dyn KeyTable) -> Result<(), SettingsError> {
    check_table(table, &Place::ROOT)
}

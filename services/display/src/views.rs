//! Named views that all pages share, and the start view.
//!
//! A view is the part of the page's address after `#`. `GET /api/views.json` lists the views for everybody. `POST
//! /api/views` takes a JSON object with `name`, `address` (`null` removes the view) and `operator`; the guard admits
//! operators only. The views are kept in the file `[display.views] file`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use anyhow::Context as _;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::kept_file;

/// Maximum number of views.
const VIEWS_MAX: usize = 64;
/// Maximum length of a view's name and of its address, characters.
const NAME_MAX: usize = 40;
const ADDRESS_MAX: usize = 2000;

/// View under its name.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
pub(crate) struct NamedView {
    /// Part of the page's address after `#`.
    address: String,
    /// Operator who kept the view.
    operator: String,
}

/// Views of a display.
#[derive(Debug, Default)]
pub(crate) struct Views {
    start: String,
    file: Option<PathBuf>,
    named: Mutex<BTreeMap<String, NamedView>>,
}

impl Views {
    /// Reads the views in `file`; a missing file has none. `start` is the address of the start view.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub(crate) fn open(start: &str, file: Option<PathBuf>) -> anyhow::Result<Self> {
        let named = match &file {
            Some(path) if path.exists() => {
                let text =
                    std::fs::read_to_string(path).with_context(|| format!("{}: display.views.file", path.display()))?;
                let wrong = || {
                    format!(
                        "{}: no views; correct the file, or remove it (display.views.file)",
                        path.display()
                    )
                };
                serde_json::from_str(&text).with_context(wrong)?
            }
            _ => BTreeMap::new(),
        };
        Ok(Self {
            start: start.trim_start_matches('#').to_owned(),
            file,
            named: Mutex::new(named),
        })
    }

    /// Returns the views for pages and scripts: `start`, `is_kept`, `views` [{`name`, `address`, `operator`}].
    pub(crate) fn list(&self) -> Value {
        let named = self.named();
        let views = named
            .iter()
            .map(|(name, view)| json!({"name": name, "address": view.address, "operator": view.operator}));
        json!({
            "start": self.start,
            "is_kept": self.file.is_some(),
            "views": views.collect::<Vec<_>>(),
        })
    }

    /// Keeps a view, or removes it if there is no address.
    ///
    /// # Errors
    /// A sentence, if the display keeps no views, a text is too long, or the file cannot be written.
    pub(crate) fn keep(&self, name: &str, address: Option<&str>, operator: &str) -> Result<(), String> {
        let file = self
            .file
            .as_ref()
            .ok_or("This display keeps no views: [display.views] names no file")?;
        let is_name = !name.trim().is_empty() && !name.chars().any(char::is_control);
        if !is_name || name.chars().count() > NAME_MAX {
            return Err(format!("The name of a view has 1 to {NAME_MAX} characters"));
        }
        if address.is_some_and(|address| address.chars().count() > ADDRESS_MAX) {
            return Err(format!("The address of a view has at most {ADDRESS_MAX} characters"));
        }
        let mut named = self.named();
        let mut next = named.clone();
        match address {
            Some(address) => {
                let view = NamedView {
                    address: address.trim_start_matches('#').to_owned(),
                    operator: operator.to_owned(),
                };
                next.insert(name.to_owned(), view);
            }
            None => drop(next.remove(name)),
        }
        if next.len() > VIEWS_MAX {
            return Err(format!("A display keeps at most {VIEWS_MAX} views: remove one"));
        }
        kept_file::write(file, &next).map_err(|error| format!("{}: {error}", file.display()))?;
        *named = next;
        Ok(())
    }

    fn named(&self) -> MutexGuard<'_, BTreeMap<String, NamedView>> {
        self.named.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_outlasts_the_display_until_it_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("views.json");
        let views = Views::open("#theme=day", Some(file.clone())).unwrap();
        views.keep("tower", Some("#e=1&scale=20"), "anna").unwrap();
        let again = Views::open("", Some(file.clone())).unwrap();
        assert_eq!(
            again.list()["views"],
            json!([{"name": "tower", "address": "e=1&scale=20", "operator": "anna"}])
        );
        assert_eq!(views.list()["start"], "theme=day");
        again.keep("tower", None, "anna").unwrap();
        assert_eq!(Views::open("", Some(file)).unwrap().list()["views"], json!([]));
        assert_eq!(
            std::fs::read_dir(folder.path()).unwrap().count(),
            1,
            "nothing is left beside it"
        );
    }

    #[test]
    fn wrong_views_are_refused_with_the_limit_and_change_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("views.json");
        let views = Views::open("", Some(file.clone())).unwrap();
        let long = "x".repeat(ADDRESS_MAX + 1);
        for (name, address, said) in [
            ("", "", "1 to 40 characters"),
            ("a\nb", "", "1 to 40 characters"),
            (&"x".repeat(NAME_MAX + 1), "", "1 to 40 characters"),
            ("tower", &long, "at most 2000 characters"),
        ] {
            assert!(
                views.keep(name, Some(address), "anna").unwrap_err().contains(said),
                "{name}"
            );
        }
        for number in 0..VIEWS_MAX {
            views.keep(&number.to_string(), Some(""), "anna").unwrap();
        }
        assert!(
            views
                .keep("more", Some(""), "anna")
                .unwrap_err()
                .contains("at most 64 views")
        );
        assert!(
            Views::default()
                .keep("a", Some(""), "anna")
                .unwrap_err()
                .contains("names no file")
        );
        std::fs::write(&file, "{").unwrap();
        let error = format!("{:#}", Views::open("", Some(file)).unwrap_err());
        assert!(error.contains("display.views.file"), "{error}");
    }
}

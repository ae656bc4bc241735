//! Texts as they should be, in `tests/golden`. A change of what is printed is a visible change of a file.

use std::path::Path;

/// Compares `text` with the golden file `name`; with `UPDATE_GOLDEN` in the environment, rewrites that file.
pub(crate) fn assert(name: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, text).unwrap();
    }
    let golden = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text, golden, "differs from {name}; UPDATE_GOLDEN=1 accepts it");
}

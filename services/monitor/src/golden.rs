//! Golden texts in `tests/golden`.

use std::path::Path;

/// Compares `text` with the golden file `name`.
pub(crate) fn assert(name: &str, text: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    test_support::assert_golden(&folder.join(name), text);
}

//! Writes the C header and the Python module of the samples into `layout/`, and the codes into the Python package.

use std::path::Path;

fn main() -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("layout");
    std::fs::write(folder.join("koseki_messages.h"), messages::layout::c_header())?;
    std::fs::write(folder.join("koseki_messages.py"), messages::layout::python_module())?;
    // A published crate has no package beside it.
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../python/koseki");
    match package.is_dir() {
        true => std::fs::write(package.join("_codes.py"), messages::layout::python_codes()),
        false => Ok(()),
    }
}

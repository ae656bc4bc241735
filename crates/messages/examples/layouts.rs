//! Writes the C header and the Python module of the samples into `layout/`.

use std::path::Path;

fn main() -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("layout");
    std::fs::write(folder.join("koseki_messages.h"), messages::layout::c_header())?;
    std::fs::write(folder.join("koseki_messages.py"), messages::layout::python_module())
}

//! The option `--root`: base folder of instances.

use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::Command;

/// Variable that names the base folder.
const VARIABLE: &str = "KOSEKI_ROOT";

/// Sets the base folder of instances. Environment variables can only be set for a new program, so that the process
/// executes itself again, unless the variable has this value already.
///
/// # Errors
/// If the folder has no absolute path, or the program cannot be executed; the message names the option.
pub fn with_root(root: &Path) -> Result<(), String> {
    let refused = |error| format!("--root {}: {error}", root.display());
    let root = std::path::absolute(root).map_err(refused)?;
    if std::env::var_os(VARIABLE).is_some_and(|set| set == root.as_os_str()) {
        return Ok(());
    }
    let itself = std::env::current_exe().map_err(refused)?;
    let mut again = Command::new(itself);
    let arguments = std::env::args_os().skip(1);
    Err(refused(again.args(arguments).env(VARIABLE, &root).exec()))
}

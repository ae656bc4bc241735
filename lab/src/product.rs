//! The product under test: the executable `koseki`.

use std::path::PathBuf;

use anyhow::Context as _;

use crate::Usage;

/// Environment variable with the path of `koseki`; set by `koseki` itself.
const VARIABLE: &str = "KOSEKI";

/// Returns the path of `koseki`.
///
/// # Errors
/// If it is neither in `$KOSEKI` nor beside this program.
pub(crate) fn koseki() -> anyhow::Result<PathBuf> {
    let itself = std::env::current_exe().context("finding the executable")?;
    let given = std::env::var_os(VARIABLE).map(PathBuf::from);
    let beside = itself.with_file_name("koseki");
    let found = given.into_iter().chain([beside]).find(|path| path.is_file());
    let nowhere = || {
        Usage(format!(
            "koseki is neither at ${VARIABLE} nor beside {}",
            itself.display()
        ))
    };
    Ok(found.ok_or_else(nowhere)?)
}

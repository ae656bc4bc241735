//! Separate file systems, which can be full without harm to others.
//!
//! If the user has the right, the command executes itself again in a separate mount namespace. There, file systems in
//! memory replace `/dev/shm` and the folder of recordings. A full file system is exactly as large as the content;
//! afterwards there is room again. The namespace and the content end with the last process.

use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::Context as _;
use rustix::fs::statvfs;
use rustix::process::geteuid;

/// Variable that marks the namespace.
const VARIABLE: &str = "KOSEKI_TORTURE_NAMESPACE";
/// Place of POSIX shared memory.
pub(super) const SHARED_MEMORY: &str = "/dev/shm";
/// Size of a file system; only used pages take memory.
const ROOM: &str = "size=1g";
/// Attempts to fill a file system with content that may grow meanwhile.
const ATTEMPTS: usize = 20;

/// Whether this process has separate file systems.
pub(super) fn are_there() -> bool {
    std::env::var_os(VARIABLE).is_some()
}

/// Executes the command again in a separate namespace without returning, if possible and not done yet.
///
/// # Errors
/// If the executable is not found, or cannot be run.
pub(super) fn enter() -> anyhow::Result<()> {
    const UNSHARE: [&str; 3] = ["--mount", "--propagation=private", "--"];
    let mut probe = Command::new("unshare");
    probe.args(UNSHARE).arg("true").stderr(Stdio::null());
    let may = geteuid().is_root() && probe.status().is_ok_and(|status| status.success());
    if are_there() || !may {
        return Ok(());
    }
    let mut again = Command::new("unshare");
    again
        .args(UNSHARE)
        .arg(std::env::current_exe()?)
        .args(std::env::args_os().skip(1));
    Err(again.env(VARIABLE, "1").exec()).context("running in a namespace of its own")
}

/// Puts an empty file system in the place of `folder`.
///
/// # Errors
/// If mounting fails.
pub(super) fn mount(folder: &Path) -> anyhow::Result<()> {
    run(
        "mount",
        &["-t", "tmpfs", "-o", &format!("mode=1777,{ROOM}"), "tmpfs"],
        folder,
    )
}

/// Takes the file system away again.
pub(super) fn unmount(folder: &Path) {
    // The mount goes with the namespace at the latest.
    let _ = run("umount", &["--lazy"], folder);
}

/// Leaves no room in the file system at `folder`.
///
/// # Errors
/// If the content keeps growing.
pub(super) fn fill(folder: &Path) -> anyhow::Result<()> {
    for _ in 0..ATTEMPTS {
        let found = statvfs(folder)?;
        let used = ((found.f_blocks - found.f_bfree) * found.f_frsize).max(found.f_frsize);
        if run("mount", &["-o", &format!("remount,size={used}")], folder).is_ok() {
            return Ok(());
        }
    }
    anyhow::bail!("{} could not be filled", folder.display())
}

/// Makes room again.
///
/// # Errors
/// If mounting fails.
pub(super) fn make_room(folder: &Path) -> anyhow::Result<()> {
    run("mount", &["-o", &format!("remount,{ROOM}")], folder)
}

fn run(program: &str, arguments: &[&str], folder: &Path) -> anyhow::Result<()> {
    let output = Command::new(program).args(arguments).arg(folder).output();
    let output = output.with_context(|| format!("running {program}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    anyhow::ensure!(
        output.status.success(),
        "{program} {}: {}",
        folder.display(),
        said.trim()
    );
    Ok(())
}

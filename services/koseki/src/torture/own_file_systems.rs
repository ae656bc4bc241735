//! File systems of its own, which can be full without harm to others.
//!
//! Where the user may, the command runs itself once more in a mount namespace of its own. There, a file system in
//! memory takes the place of `/dev/shm`, and another one that of the folder for recordings. A full one is as large as
//! what is in it; afterwards it has room again. The namespace ends with its last process, and what was in it is gone.

use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::Context as _;
use rustix::fs::statvfs;
use rustix::process::geteuid;

/// Variable that says that the namespace is there.
const VARIABLE: &str = "KOSEKI_TORTURE_NAMESPACE";
/// Place of POSIX shared memory.
pub(super) const SHARED_MEMORY: &str = "/dev/shm";
/// Room of a file system, of which only what is used takes memory.
const ROOM: &str = "size=1g";
/// Attempts to make a file system full: what is in it may grow meanwhile.
const ATTEMPTS: usize = 20;

/// Whether this process has file systems of its own.
pub(super) fn are_there() -> bool {
    std::env::var_os(VARIABLE).is_some()
}

/// Runs the command again in a namespace of its own, and does not return, if it can be and has not been done.
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
/// If it cannot be mounted.
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
/// If it goes on growing.
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
/// If it cannot be mounted so.
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

//! Folder of a start: files of a start are never touched by another start.
//!
//! The requested folder contains a folder per start, named after the time of the start (UTC), as in `20261122T231500Z`,
//! so that names sort by age. The link `latest` beside these folders points to the newest. Processes that are restarted
//! within the deployment continue in the same folder; the next start of the deployment has a new folder.

use std::fs::create_dir;
use std::io::ErrorKind;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use jiff::Timestamp;

/// Name of the link to the newest folder.
const LATEST: &str = "latest";
/// Maximum number of starts within a second.
const STARTS_MAX: u32 = 1000;

/// Creates the folder of a start at `utc_ns` (nanoseconds since 1970) in `out`, which is created if missing.
///
/// # Errors
/// If a folder cannot be created.
pub(crate) fn begin(out: &Path, utc_ns: i64) -> anyhow::Result<PathBuf> {
    std::fs::create_dir_all(out).with_context(|| format!("making the folder {}", out.display()))?;
    let time = Timestamp::from_nanosecond(utc_ns.into()).context("reading the clock")?;
    let time = time.strftime("%Y%m%dT%H%M%SZ").to_string();
    for start in 1..STARTS_MAX {
        let name = match start {
            1 => time.clone(),
            more => format!("{time}-{more}"),
        };
        let folder = out.join(&name);
        match create_dir(&folder) {
            Ok(()) => {
                link_latest(out, &name);
                return Ok(folder);
            }
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error).with_context(|| format!("making the folder {}", folder.display())),
        }
    }
    anyhow::bail!("{} has a thousand folders of {time}; name another", out.display())
}

/// Points the link to the folder `name`, in a single step. The link is a convenience: a file system without links, or
/// another file of this name, does not prevent the start.
fn link_latest(out: &Path, name: &str) {
    let latest = out.join(LATEST);
    if latest.symlink_metadata().is_ok_and(|found| !found.is_symlink()) {
        return;
    }
    let new = out.join(format!(".{LATEST}-{name}"));
    if symlink(name, &new)
        .and_then(|()| std::fs::rename(&new, &latest))
        .is_err()
    {
        let _ = std::fs::remove_file(&new);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2026-11-22 23:15 UTC.
    const START_NS: i64 = 1_795_389_300_000_000_000;

    #[test]
    fn each_start_has_a_folder_of_its_own_and_the_link_leads_to_the_newest() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("new/out");
        let first = begin(&out, START_NS).unwrap();
        assert_eq!(first, out.join("20261122T231500Z"));
        std::fs::write(out.join("latest/system_tracks.csv"), "first").unwrap();
        let again = begin(&out, START_NS + 1).unwrap();
        assert_eq!(again, out.join("20261122T231500Z-2"));
        assert_eq!(
            out.join("latest").canonicalize().unwrap(),
            again.canonicalize().unwrap()
        );
        assert_eq!(std::fs::read(first.join("system_tracks.csv")).unwrap(), b"first");
        assert_eq!(
            begin(&out, START_NS + 61_000_000_000).unwrap(),
            out.join("20261122T231601Z")
        );
        let names = std::fs::read_dir(&out).unwrap().count();
        assert_eq!(names, 4, "three folders and the link");
    }

    #[test]
    fn something_else_called_latest_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("latest"), "of somebody").unwrap();
        begin(folder.path(), START_NS).unwrap();
        assert_eq!(std::fs::read(folder.path().join("latest")).unwrap(), b"of somebody");
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_named() {
        let error = begin(Path::new("/proc/none"), START_NS).unwrap_err();
        assert!(error.to_string().contains("/proc/none"));
    }
}

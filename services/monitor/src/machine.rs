//! Room left on the machine, on disk and in memory.

use std::fs;
use std::path::{Path, PathBuf};

use rustix::fs::statvfs;
use rustix::process::{Pid, test_kill_process};

/// Folder of shared memory.
const SHARED_MEMORY: &str = "/dev/shm";
const KIB: u64 = 1024;

/// Room left, bytes; `None` if not stated by the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Room {
    /// On the disk of the files.
    pub(crate) disk: Option<u64>,
    /// Of memory available to programs.
    pub(crate) memory: Option<u64>,
    /// Of shared memory.
    pub(crate) shared: Option<u64>,
}

/// Machine of the deployment.
#[derive(Debug)]
pub(crate) struct Machine {
    /// Folder of the files, if files are written.
    pub(crate) folder: Option<PathBuf>,
}

impl Machine {
    /// Returns the room left.
    pub(crate) fn room(&self) -> Room {
        Room {
            // A folder that does not exist yet is on its parent's disk.
            disk: self
                .folder
                .as_deref()
                .and_then(|folder| folder.ancestors().find_map(free)),
            memory: fs::read_to_string("/proc/meminfo")
                .ok()
                .and_then(|text| available(&text)),
            shared: free(Path::new(SHARED_MEMORY)),
        }
    }
}

/// Whether no process has this number.
pub(crate) fn is_gone(pid: u32) -> bool {
    let pid = i32::try_from(pid).ok().and_then(Pid::from_raw);
    pid.is_some_and(|pid| test_kill_process(pid) == Err(rustix::io::Errno::SRCH))
}

fn free(folder: &Path) -> Option<u64> {
    // The parent of a relative path of a single part is empty and means the present folder.
    let folder = if folder == Path::new("") {
        Path::new(".")
    } else {
        folder
    };
    let found = statvfs(folder).ok()?;
    Some(found.f_bavail * found.f_frsize)
}

fn available(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * KIB)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machine_tells_what_room_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let machine = Machine {
            folder: Some(folder.path().join("not/yet/made")),
        };
        let room = machine.room();
        assert!(room.disk.is_some() && room.memory.is_some(), "{room:?}");
        assert_eq!(Machine { folder: None }.room().disk, None);
        assert!(free(Path::new("")).is_some());
    }

    #[test]
    fn available_memory_is_read_in_octets() {
        let text = "MemTotal:       16384 kB\nMemFree:          100 kB\nMemAvailable:     2048 kB\n";
        assert_eq!(
            (available(text), available("MemFree: 1 kB\n")),
            (Some(2048 * 1024), None)
        );
    }
}

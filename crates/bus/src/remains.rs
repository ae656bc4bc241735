//! Files of dead processes that iceoryx2 leaves behind.
//!
//! iceoryx2 removes a dead process's files by the process's own description and by the entries of ports in each topic.
//! A process killed at certain moments has neither: before it has described itself, or while a cleaner removes the
//! description, or between the creation of a connection of two ports and the entry of the ports in their topic. The
//! files carry the numbers of their node or of their two ports; every such number contains the process number. A file
//! is removed if no living process and no node with a description has that process number.

use std::fs;
use std::path::{Path, PathBuf};

use iceoryx2::node::{NodeState, NodeView as _};
use rustix::process::{Pid, test_kill_process};

use crate::error::{BusError, io_error};
use crate::root::{NODES, Root};
use crate::seal::SHARED_MEMORY_DIR;

/// Ending of the name of a connection between two ports.
const CONNECTION: &str = ".connection";

/// File of iceoryx2, and the nodes or ports that own the file.
struct Owned {
    path: PathBuf,
    /// As listed: the process may remove a folder at any time.
    is_folder: bool,
    owners: Vec<u128>,
}

impl Root {
    /// Removes the files of dead processes that iceoryx2 leaves behind.
    pub(crate) fn remove_remains(&self, prefix: &str) -> Result<(), BusError> {
        // Listed before the living are: a process that joins meanwhile is not in the list.
        let mut files = owned_files(&self.path().join(NODES), |name| {
            let number = name.strip_prefix(prefix).unwrap_or(name).split('.').next()?;
            Some(vec![number.parse().ok()?])
        })?;
        files.sort_by_key(|file| !file.is_folder);
        files.extend(owned_files(Path::new(SHARED_MEMORY_DIR), |name| {
            let ports = name.strip_prefix(prefix)?.strip_suffix(CONNECTION)?;
            ports.split('_').map(|port| port.parse().ok()).collect()
        })?);
        let mut known = Vec::new();
        self.visit_nodes(|state| match state {
            NodeState::Alive(view) => known.push(process_of(view.id().value())),
            NodeState::Dead(view) if view.details().is_some() => known.push(process_of(view.id().value())),
            _ => {}
        })?;
        let is_alive = |owner: &u128| {
            let process = process_of(*owner);
            known.contains(&process) || is_process(process)
        };
        for file in files.iter().filter(|file| !file.owners.iter().any(is_alive)) {
            // A file that cannot be removed now, or is gone, is found or not found the next time.
            let _ = match file.is_folder {
                true => fs::remove_dir_all(&file.path),
                false => fs::remove_file(&file.path),
            };
        }
        Ok(())
    }
}

/// Returns the files of `folder` with owners in the names.
fn owned_files(folder: &Path, owners: impl Fn(&str) -> Option<Vec<u128>>) -> Result<Vec<Owned>, BusError> {
    let entries = fs::read_dir(folder).map_err(io_error("read", folder))?;
    let owned = |entry: fs::DirEntry| {
        Some(Owned {
            owners: owners(entry.file_name().to_str()?)?,
            path: entry.path(),
            is_folder: entry.file_type().ok()?.is_dir(),
        })
    };
    Ok(entries.flatten().filter_map(owned).collect())
}

/// Returns the process number in a number of iceoryx2: seconds, nanoseconds, process, count, of 32 bits each.
fn process_of(number: u128) -> i32 {
    (number >> 64) as i32
}

/// Returns whether the process lives, or waits for the collection of its exit code.
fn is_process(process: i32) -> bool {
    Pid::from_raw(process).is_some_and(|pid| test_kill_process(pid) != Err(rustix::io::Errno::SRCH))
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;
    use crate::Bus;
    use crate::transport::SharedMemory;

    /// Process number of a process that has ended.
    fn dead_process() -> u128 {
        let mut child = Command::new("true").spawn().unwrap();
        let process = child.id();
        child.wait().unwrap();
        process.into()
    }

    #[test]
    fn connections_go_with_their_last_process() {
        let base = tempfile::tempdir().unwrap();
        let root = Root::in_base(base.path(), "remains").unwrap();
        let _claim = root.claim().unwrap();
        let _bus = Bus::<SharedMemory>::open(&root, "keeper").unwrap();
        let prefix = root.prefix().unwrap().unwrap();
        let port = |process: u128, count: u128| 7 << 96 | process << 64 | count;
        let connection = |one: u128, other: u128| {
            let path = Path::new(SHARED_MEMORY_DIR).join(format!("{prefix}{one}_{other}{CONNECTION}"));
            fs::write(&path, []).unwrap();
            path
        };
        let (dead, own) = (dead_process(), u128::from(std::process::id()));
        let stale = connection(port(dead, 1), port(dead, 2));
        let half = connection(port(dead, 1), port(own, 2));
        root.remove_remains(&prefix).unwrap();
        assert_eq!((stale.exists(), half.exists()), (false, true));
        fs::remove_file(half).unwrap();
    }
}

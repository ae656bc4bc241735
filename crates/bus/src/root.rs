//! Root of an instance: the folder, the right to run the instance, and the complete removal of all files.
//!
//! Several deployments (and any number of tests) run on the same machine without seeing each other. Each is an
//! *instance* with a name, and all traces of an instance have known places:
//!
//! - `<base>/<instance>/`: iceoryx2's files (lists of services and processes, and sockets for wake-ups), and the
//!   instance's [seal](crate::seal), with the start of the names of the instance's memory;
//! - `/dev/shm/<prefix>…`: the memory itself;
//! - `<base>/<instance>.lock`: locked by the process that runs the instance, and holding the process number;
//! - `<base>/<instance>.checkpoint` and the link's target: see [`outlasting`](crate::outlasting).
//!
//! The [base folder](crate::base) is private, and only a folder that bears the seal is ever removed.
//!
//! A killed process leaves files behind, and iceoryx2 can get stuck on such files: a service whose only process was
//! killed during its creation can never be opened again. Removing files by age would take memory from live processes.
//! Instead, a single process, the launcher, *claims* the instance: the launcher takes the lock (released by the system
//! at any death of the process), checks that no process uses the instance, and then removes everything. All other
//! processes only open objects created by the keeper; meanwhile they hold the seal, so that no process can join an
//! instance during its removal. If the launcher ends before the readers, the last leaving reader removes the instance.
//!
//! Limits: Linux only (`/dev/shm`); all processes of an instance belong to the same user and must name the base folder
//! by the same path.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read as _, Seek as _, Write as _};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::node::{Node, NodeState, NodeView as _};
use iceoryx2::prelude::{CallbackProgression, Config, FileName, SemanticString as _};
use rustix::fs::{FlockOperation, flock};

use crate::base;
use crate::error::{BusError, io_error};
use crate::process::MemberProcess;
use crate::quality::LEAVERS_MAX;
use crate::seal::{self, NO_LINKS, PREFIX_LEN, SHARED_MEMORY_DIR, Seal};
use crate::transport::SharedMemory;

/// Most characters in the name of an instance.
pub const INSTANCE_NAME_MAX: usize = 40;

/// Longest path of a socket that the system accepts.
const SOCKET_PATH_MAX: usize = 107;
/// Length that iceoryx2 appends to the folder for a socket, besides the prefix: '/', a 128-bit number, ".event".
const SOCKET_NAME_LEN: usize = 1 + 39 + 6;
/// Longest folder of an instance.
const ROOT_PATH_MAX: usize = SOCKET_PATH_MAX - SOCKET_NAME_LEN - PREFIX_LEN;

/// Folder of iceoryx2's files about processes, in the instance's.
pub(crate) const NODES: &str = "nodes";
/// End of the name of iceoryx2's count of processes.
const COUNTER_SUFFIX: &str = ".global_mgmt";
/// Time for which iceoryx2 waits for another process in the middle of a creation. This time also bounds the delay of a
/// publisher by a subscriber killed in the middle of a connection.
pub(crate) const CREATION_TIMEOUT: Duration = Duration::from_millis(250);

/// An instance: its name and its paths. Creating a value touches no file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Root {
    instance: String,
    base: PathBuf,
    path: PathBuf,
}

impl Root {
    /// The instance called `instance` in the [base folder of this process](base::find).
    ///
    /// # Errors
    /// If the name is not usable.
    pub fn new(instance: &str) -> Result<Self, BusError> {
        Self::in_base(base::find(), instance)
    }

    /// The instance called `instance` in the folder `base`.
    ///
    /// # Errors
    /// If the name is not usable, or too long for that folder.
    pub fn in_base(base: impl AsRef<Path>, instance: &str) -> Result<Self, BusError> {
        let allowed = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '_';
        let length = instance.len();
        if length == 0 || length > INSTANCE_NAME_MAX || !instance.chars().all(allowed) {
            return Err(BusError::InstanceName {
                name: instance.to_owned(),
                limit: INSTANCE_NAME_MAX,
            });
        }
        let base = base.as_ref();
        let base = std::path::absolute(base).map_err(io_error("find", base))?;
        let path = base.join(instance);
        let length = path.as_os_str().len();
        if length > ROOT_PATH_MAX {
            return Err(BusError::PathTooLong {
                path,
                length,
                limit: ROOT_PATH_MAX,
            });
        }
        Ok(Self {
            instance: instance.to_owned(),
            base,
            path,
        })
    }

    /// The instance's name.
    pub fn instance(&self) -> &str {
        &self.instance
    }

    /// The folder that contains the instances.
    pub fn base(&self) -> &Path {
        &self.base
    }

    /// The instance's folder: iceoryx2's `root-path`, for its tools and other languages.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the start of the names of the instance's memory: iceoryx2's `prefix`, for its tools and other
    /// languages. Each run has a new random prefix. `None` if the instance neither runs nor has remains.
    ///
    /// # Errors
    /// If the seal cannot be read, or is none.
    pub fn prefix(&self) -> Result<Option<String>, BusError> {
        Ok(Seal::open(&self.path)?.and_then(|seal| seal.prefix))
    }

    /// Makes this process the runner of the instance, and removes the remains of an earlier, killed run.
    ///
    /// # Errors
    /// [`BusError::AlreadyRunning`] if a live process holds the claim; [`BusError::StillUsed`] if processes outlived
    /// their launcher; [`BusError::BaseNotPrivate`] if the base folder is not safe; [`BusError::NotOurs`] if something
    /// else has the place of the instance's folder. Nothing is changed then.
    pub fn claim(&self) -> Result<Claim, BusError> {
        tame_logging();
        base::make(&self.base)?;
        let lock = self.lock(&seal::Patience::begin())?;
        // From here on this process holds the lock, and every return without a `Claim` releases the lock.
        match self.wipe().and_then(|wiped| Seal::make(&self.path).map(|()| wiped)) {
            Ok(wiped) => Ok(Claim {
                root: self.clone(),
                _lock: lock,
                wiped,
                replaced: Vec::new(),
            }),
            Err(error) => {
                // The lock file shows that an instance exists.
                if !matches!(Seal::open(&self.path), Ok(Some(_))) {
                    let _ = fs::remove_file(self.lock_path());
                }
                Err(error)
            }
        }
    }

    /// Returns the process that runs the instance: `None` without such a process, `Some(None)` with an unreadable
    /// number.
    ///
    /// # Errors
    /// If the lock file cannot be read, or the base folder is not safe.
    pub fn holder(&self) -> Result<Option<Option<u32>>, BusError> {
        if !base::check(&self.base)? {
            return Ok(None);
        }
        let path = self.lock_path();
        let mut lock = match OpenOptions::new().read(true).custom_flags(NO_LINKS).open(&path) {
            Ok(lock) => lock,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(io_error("read", &path)(error)),
        };
        match flock(&lock, FlockOperation::NonBlockingLockShared) {
            Ok(()) => Ok(None),
            Err(rustix::io::Errno::WOULDBLOCK) => Ok(Some(read_pid(&mut lock))),
            Err(error) => Err(io_error("lock", &path)(error.into())),
        }
    }

    /// The live processes that have joined the instance.
    ///
    /// # Errors
    /// If the processes cannot be listed.
    pub fn processes(&self) -> Result<Vec<MemberProcess>, BusError> {
        let mut processes = Vec::new();
        self.visit_nodes(|state| match state {
            NodeState::Alive(view) => processes.push(match view.details() {
                Some(details) => MemberProcess {
                    pid: details.process_id().value().unsigned_abs(),
                    name: details.name().as_str().to_owned(),
                },
                None => MemberProcess::unknown(),
            }),
            NodeState::Inaccessible(_) => processes.push(MemberProcess::unknown()),
            NodeState::Dead(_) | NodeState::Undefined(_) => {}
        })?;
        Ok(processes)
    }

    /// iceoryx2's numbers of the processes that have joined the instance, and of the dead that are still to be removed.
    pub(crate) fn nodes(&self) -> Result<Vec<u128>, BusError> {
        let mut nodes = Vec::new();
        self.visit_nodes(|state| {
            nodes.push(match state {
                NodeState::Alive(view) => view.id().value(),
                NodeState::Dead(view) => view.id().value(),
                NodeState::Inaccessible(id) | NodeState::Undefined(id) => id.value(),
            });
        })?;
        Ok(nodes)
    }

    /// Shows the state of each process that has joined the instance to `visit`.
    pub(crate) fn visit_nodes(&self, mut visit: impl FnMut(NodeState<SharedMemory>)) -> Result<(), BusError> {
        tame_logging();
        let Some(prefix) = self.prefix()? else {
            return Ok(());
        };
        let config = self.config(&prefix, LEAVERS_MAX)?;
        let listed = Node::<SharedMemory>::list(&config, |state| {
            visit(state);
            CallbackProgression::Continue
        });
        listed.map_err(|error| io_error("list the processes of", &self.path)(io::Error::other(error.to_string())))
    }

    /// Every instance in the folder `base` that runs, or ran and was not removed; in the order of names.
    ///
    /// # Errors
    /// If the folder cannot be read, or is not safe. A missing folder contains no instance.
    pub fn list(base: impl AsRef<Path>) -> Result<Vec<InstanceEntry>, BusError> {
        let base = base.as_ref();
        let entries = match fs::read_dir(base) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(io_error("read", base)(error)),
        };
        let mut instances = Vec::new();
        for entry in entries {
            let name = entry.map_err(io_error("read", base))?.file_name();
            let name = name.to_str().and_then(|name| name.strip_suffix(".lock"));
            let Some(root) = name.and_then(|name| Self::in_base(base, name).ok()) else {
                continue;
            };
            let holder = root.holder()?;
            instances.push(InstanceEntry {
                root,
                runs: holder.is_some(),
                pid: holder.flatten(),
            });
        }
        instances.sort_by(|a, b| a.root.instance.cmp(&b.root.instance));
        Ok(instances)
    }

    /// Returns iceoryx2's settings for this instance. No file is read: the machine's own configuration of iceoryx2
    /// does not apply. Names of memory begin with `prefix`; subscribers keep the unread slices of `leavers` ended
    /// publishers.
    pub(crate) fn config(&self, prefix: &str, leavers: usize) -> Result<Config, BusError> {
        let unusable = |error: String| io_error("use", &self.path)(io::Error::other(error));
        let path = self.path.as_os_str().as_encoded_bytes();
        let path = iceoryx2::prelude::Path::new(path).map_err(|e| unusable(format!("{e:?}")))?;
        let mut config = Config::default();
        config.global.set_root_path(&path);
        config.global.prefix = FileName::new(prefix.as_bytes()).map_err(|e| unusable(format!("{e:?}")))?;
        config.global.creation_timeout = CREATION_TIMEOUT;
        config.defaults.publish_subscribe.subscriber_expired_connection_buffer = leavers;
        // Dead processes are removed on request, not whenever a process joins or leaves.
        config.global.service.cleanup_dead_nodes_on_open = false;
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        Ok(config)
    }

    fn lock_path(&self) -> PathBuf {
        self.base.join(format!("{}.lock", self.instance))
    }

    /// Takes the lock and writes this process's number into the lock file.
    fn lock(&self, patience: &seal::Patience) -> Result<File, BusError> {
        let path = self.lock_path();
        loop {
            let mut lock = OpenOptions::new()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .mode(0o600)
                .custom_flags(NO_LINKS)
                .open(&path)
                .map_err(io_error("open", &path))?;
            match flock(&lock, FlockOperation::NonBlockingLockExclusive) {
                // The file may have been removed after the opening here, by a process that ended the instance.
                Ok(()) if seal::is_same_file(&lock, &path) => {
                    let empty = lock.metadata().is_ok_and(|found| found.len() == 0);
                    if !empty && read_pid(&mut lock).is_none() {
                        return Err(BusError::NotOurs { path });
                    }
                    lock.set_len(0)
                        .and_then(|()| lock.rewind())
                        .and_then(|()| writeln!(lock, "{}", std::process::id()))
                        .map_err(io_error("write", &path))?;
                    return Ok(lock);
                }
                Ok(()) => {}
                Err(rustix::io::Errno::WOULDBLOCK) if patience.is_over() => {
                    return Err(BusError::AlreadyRunning {
                        instance: self.instance.clone(),
                        pid: read_pid(&mut lock),
                    });
                }
                Err(rustix::io::Errno::WOULDBLOCK) => patience.pause(),
                Err(error) => return Err(io_error("lock", &path)(error.into())),
            }
        }
    }

    /// Removes all files of an unused instance except the lock. Only for the holder of the lock.
    fn wipe(&self) -> Result<Wiped, BusError> {
        let Some(seal) = Seal::open(&self.path)? else {
            return Ok(Wiped::default());
        };
        let mut processes = self.processes()?;
        let alone = seal.lock_alone().map_err(io_error("lock the seal in", &self.path))?;
        if !alone && processes.is_empty() {
            // The process is joining or leaving.
            processes.push(MemberProcess::unknown());
        }
        if !processes.is_empty() {
            return Err(BusError::StillUsed {
                instance: self.instance.clone(),
                processes,
            });
        }
        self.wipe_sealed(&seal)
    }

    /// Removes the instance completely, for the last leaving member: the instance does not run any more, and `seal`
    /// is locked exclusively.
    pub(crate) fn clear_alone(&self, seal: &Seal) -> Result<(), BusError> {
        // A process that runs the instance by now removes the files itself.
        let _lock = self.lock(&seal::Patience::begin_short())?;
        if self.processes()?.is_empty() {
            self.wipe_sealed(seal)?;
            self.remove_lock()?;
        }
        Ok(())
    }

    fn remove_lock(&self) -> Result<(), BusError> {
        let path = self.lock_path();
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(io_error("remove", &path)(error)),
            _ => Ok(()),
        }
    }

    fn wipe_sealed(&self, seal: &Seal) -> Result<Wiped, BusError> {
        let mut wiped = Wiped::default();
        if let Some(prefix) = &seal.prefix {
            wipe_memory(prefix, &mut wiped)?;
        }
        count_files(&self.path, &mut wiped)?;
        fs::remove_dir_all(&self.path).map_err(io_error("remove", &self.path))?;
        Ok(wiped)
    }
}

/// iceoryx2 counts processes in a file writable by every user of the machine; a truncated file would kill the next
/// process that counts. Therefore this file is replaced by a private copy immediately after its creation: an opened
/// original has no effect any more.
pub(crate) fn close_to_others(prefix: &str) -> Result<(), BusError> {
    let folder = Path::new(SHARED_MEMORY_DIR);
    for entry in fs::read_dir(folder).map_err(io_error("read", folder))?.flatten() {
        let name = entry.file_name();
        let counts = |name: &&str| name.starts_with(prefix) && name.ends_with(COUNTER_SUFFIX);
        let Some(name) = name.to_str().filter(counts) else {
            continue;
        };
        let open = |found: &fs::Metadata| base::is_own(found) && found.mode() & 0o077 != 0;
        if !entry.metadata().is_ok_and(|found| open(&found)) {
            continue;
        }
        let (path, copy) = (entry.path(), folder.join(format!("{name}.{}", std::process::id())));
        let replaced = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&copy);
        let replaced = replaced
            .and_then(|mut file| file.write_all(&fs::read(&path)?))
            .and_then(|()| fs::rename(&copy, &path));
        replaced.map_err(io_error("replace", &path))?;
    }
    Ok(())
}

/// Removes the memory with names that begin with `prefix`, except files of other users.
pub(crate) fn wipe_memory(prefix: &str, wiped: &mut Wiped) -> Result<(), BusError> {
    let folder = Path::new(SHARED_MEMORY_DIR);
    for entry in fs::read_dir(folder).map_err(io_error("read", folder))? {
        let entry = entry.map_err(io_error("read", folder))?;
        let named = entry.file_name().to_str().is_some_and(|name| name.starts_with(prefix));
        // Files appear and vanish here at any time; a vanished file need not be removed.
        let Some(found) = entry.metadata().ok().filter(|found| named && base::is_own(found)) else {
            continue;
        };
        let path = entry.path();
        match fs::remove_file(&path) {
            Ok(()) => wiped.add(&found),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(io_error("remove", &path)(error)),
        }
    }
    Ok(())
}

/// Right to run an instance. Dropping the claim removes the instance, if unused; after a kill, the next claim removes
/// the instance.
#[derive(Debug)]
#[must_use = "the instance is held only as long as the claim lives"]
pub struct Claim {
    root: Root,
    _lock: File,
    wiped: Wiped,
    /// Prefixes of memory that was replaced: a process that was just joining makes files even later.
    replaced: Vec<String>,
}

impl Claim {
    /// The instance.
    pub fn root(&self) -> &Root {
        &self.root
    }

    /// Remains of an earlier run.
    pub fn wiped(&self) -> Wiped {
        self.wiped
    }

    /// Removes every file of the instance except the lock, even in use, and starts again: for corrupt memory. Mappings
    /// of joined processes remain.
    ///
    /// # Errors
    /// If a file cannot be removed.
    pub fn empty(&mut self) -> Result<Wiped, BusError> {
        let wiped = match Seal::open(&self.root.path)? {
            Some(seal) => {
                self.replaced.extend(seal.prefix.clone());
                self.root.wipe_sealed(&seal)?
            }
            None => Wiped::default(),
        };
        Seal::make(&self.root.path)?;
        Ok(wiped)
    }

    /// Removes every file of the instance, including the lock. Every [`Bus`](crate::Bus) and port of this process must
    /// be gone.
    ///
    /// # Errors
    /// [`BusError::StillUsed`] if a process (perhaps this one) still uses the instance; nothing is removed then.
    pub fn remove(self) -> Result<Wiped, BusError> {
        self.clear()
    }

    fn clear(&self) -> Result<Wiped, BusError> {
        let mut wiped = self.root.wipe()?;
        for prefix in &self.replaced {
            wipe_memory(prefix, &mut wiped)?;
        }
        self.root.remove_lock()?;
        Ok(wiped)
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        // Files in use remain, together with the lock file.
        let _ = self.clear();
    }
}

/// How much was removed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wiped {
    /// Files, sockets included.
    pub files: u64,
    /// Bytes of the removed files in memory and on disk.
    pub bytes: u64,
}

impl Wiped {
    fn add(&mut self, found: &fs::Metadata) {
        /// Unit of `st_blocks`, independent of the file system's block size.
        const BLOCK_BYTES: u64 = 512;
        self.files += 1;
        self.bytes += found.blocks() * BLOCK_BYTES;
    }
}

/// An instance that was found in a base folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InstanceEntry {
    /// The instance.
    pub root: Root,
    /// Whether a live process runs the instance.
    pub runs: bool,
    /// Number of that process in the operating system.
    pub pid: Option<u32>,
}

/// Restricts iceoryx2's output to errors. `IOX2_LOG_LEVEL` overrides the restriction for debugging.
pub(crate) fn tame_logging() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        iceoryx2::prelude::set_log_level_from_env_or(iceoryx2::prelude::LogLevel::Error);
    });
}

fn count_files(folder: &Path, wiped: &mut Wiped) -> Result<(), BusError> {
    for entry in fs::read_dir(folder).map_err(io_error("read", folder))? {
        let entry = entry.map_err(io_error("read", folder))?;
        let found = entry.metadata().map_err(io_error("read", &entry.path()))?;
        if found.is_dir() {
            count_files(&entry.path(), wiped)?;
        } else {
            wiped.add(&found);
        }
    }
    Ok(())
}

fn read_pid(lock: &mut File) -> Option<u32> {
    let mut text = String::new();
    lock.rewind().ok()?;
    lock.read_to_string(&mut text).ok()?;
    text.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_could_escape_the_base_folder_are_refused() {
        for name in ["", ".", "..", "a/b", "a b", "ä", &"x".repeat(41)] {
            let refused = Root::in_base("/tmp/b", name);
            assert!(matches!(refused, Err(BusError::InstanceName { .. })), "{name}");
        }
        let root = Root::in_base("/tmp/b", "Berlin-2_a").unwrap();
        assert_eq!(root.path(), Path::new("/tmp/b/Berlin-2_a"));
    }

    #[test]
    fn a_folder_too_deep_for_sockets_is_refused_with_both_numbers() {
        let base = format!("/{}", "d".repeat(ROOT_PATH_MAX - 4));
        assert!(Root::in_base(&base, "ab").is_ok());
        let error = Root::in_base(&base, "abc").unwrap_err();
        assert!(error.to_string().contains(&format!("{}", ROOT_PATH_MAX + 1)));
        assert!(error.to_string().contains(&format!("{ROOT_PATH_MAX}")));
    }
}

//! Membership of a process in an instance.

use rustix::fs::{FlockOperation, flock};

use crate::error::BusError;
use crate::root::{Root, Wiped, wipe_memory};
use crate::seal::{SEAL, Seal, is_same_file};

/// Membership of a process in an instance. Ends when dropped, which must be after the process's last port. If the
/// instance has no launcher any more and no other member, the instance ends with the membership.
#[derive(Debug)]
pub(crate) struct Membership {
    root: Root,
    seal: Seal,
}

impl Membership {
    /// Joins the instance; also returns the start of the names of the instance's memory. `None` if the instance does
    /// not run.
    pub(crate) fn begin(root: &Root) -> Result<Option<(Self, String)>, BusError> {
        if root.holder()?.is_none() {
            return Ok(None);
        }
        let Some(seal) = Seal::open(root.path())? else {
            return Ok(None);
        };
        // A failed lock means that the instance is being removed; and if the folder was removed before the lock,
        // another instance may have taken the place.
        if flock(&seal.file, FlockOperation::NonBlockingLockShared).is_err()
            || !is_same_file(&seal.file, &root.path().join(SEAL))
        {
            return Ok(None);
        }
        let prefix = seal.prefix.clone();
        let root = root.clone();
        Ok(prefix.map(|prefix| (Self { root, seal }, prefix)))
    }
}

impl Drop for Membership {
    fn drop(&mut self) {
        // Only the last leaving member can lock alone, because all members release the locks before the attempt. After
        // a failure, for example because a killed launcher's lock remains, the next start removes the files.
        let _ = flock(&self.seal.file, FlockOperation::Unlock);
        if !is_same_file(&self.seal.file, &self.root.path().join(SEAL)) {
            // The memory was replaced during this membership. Memory created by this process since then belongs to no
            // instance.
            if let Some(prefix) = self.seal.prefix.as_ref().filter(|_| self.is_last()) {
                let _ = wipe_memory(prefix, &mut Wiped::default());
            }
        } else if matches!(self.root.holder(), Ok(None)) && self.is_last() {
            let _ = self.root.clear_alone(&self.seal);
        }
    }
}

impl Membership {
    fn is_last(&self) -> bool {
        self.seal.try_lock_alone().unwrap_or(false)
    }
}

//! A process's part in an instance.

use rustix::fs::{FlockOperation, flock};

use crate::error::BusError;
use crate::root::{Root, Wiped, wipe_memory};
use crate::seal::{SEAL, Seal, is_same_file};

/// A process's part in an instance. It ends when dropped, which must be after the process's last port. If nobody runs
/// the instance any more and nobody else has joined it, the instance ends with it.
#[derive(Debug)]
pub(crate) struct Membership {
    root: Root,
    seal: Seal,
}

impl Membership {
    /// Joins the instance; also says with what the names of its memory begin. `None` if nobody runs it.
    pub(crate) fn begin(root: &Root) -> Result<Option<(Self, String)>, BusError> {
        if root.holder()?.is_none() {
            return Ok(None);
        }
        let Some(seal) = Seal::open(root.path())? else {
            return Ok(None);
        };
        // Where it cannot be locked, the instance is being removed; and if it was removed before it was locked, another
        // may have taken its place.
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
        // The last one that leaves is the only one who can lock it alone, for all have given up their locks before they
        // try. If something fails, as where a launcher that was killed still holds its lock, the next start clears up.
        let _ = flock(&self.seal.file, FlockOperation::Unlock);
        if !is_same_file(&self.seal.file, &self.root.path().join(SEAL)) {
            // The memory was replaced while this process had it. What it made there since then is nobody's.
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

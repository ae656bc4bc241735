//! A program's connection to a deployment, and whether that still runs.

use bus::{Bus, Root, SharedMemoryAnyThread};

use crate::clock::mono_ns;
use crate::error::Error;

/// Shared memory, with ports that may move between threads.
pub(crate) type Medium = SharedMemoryAnyThread;

/// Pause between two looks whether the deployment still runs, nanoseconds.
pub(crate) const LOOK_NS: u64 = 250_000_000;

/// A program's connection to a deployment.
#[derive(Debug)]
pub(crate) struct Connection {
    pub(crate) bus: Bus<Medium>,
    looked_ns: u64,
}

impl Connection {
    pub(crate) fn open(root: &Root) -> Result<Self, Error> {
        let program = std::env::current_exe().ok();
        let name = program.as_ref().and_then(|path| path.file_stem()?.to_str());
        Ok(Self {
            bus: Bus::open(root, name.unwrap_or("client"))?,
            looked_ns: mono_ns(),
        })
    }

    /// Whether the deployment has ended, or was replaced. Looks now and then only.
    pub(crate) fn has_ended(&mut self) -> Result<bool, Error> {
        let now_ns = mono_ns();
        if now_ns - self.looked_ns < LOOK_NS {
            return Ok(false);
        }
        self.looked_ns = now_ns;
        Ok(!self.bus.goes_on()?)
    }

    pub(crate) fn ended(&self) -> Error {
        Error::Ended {
            instance: self.bus.root().instance().to_owned(),
        }
    }
}

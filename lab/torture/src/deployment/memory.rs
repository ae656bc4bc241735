//! Shared memory of the deployment, and methods to corrupt the memory.
//!
//! Corrupted memory may kill the readers. So another process reads a sample before the judge's subscriber joins: memory
//! that is fatal for a reader is a finding, and must not end this command.

use std::collections::BTreeSet;
use std::fs::{self, OpenOptions};
use std::os::unix::fs::FileExt as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::Context as _;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use runtime::clock::instant;

use super::{Deployment, INSTANCE, PAUSE};
use crate::judge::event::What;
use crate::own_file_systems::{self, SHARED_MEMORY};

/// Time within which processes fall over memory that was spoilt, or do not.
const CORRUPTION_SHOWS: Duration = Duration::from_secs(10);
/// Time that another process has for reading a single sample of corrupted memory.
const PROBE_PATIENCE: Duration = Duration::from_secs(10);

impl Deployment {
    /// Returns the start of the names of the instance's memory; also `None` during a rebuild.
    pub(super) fn prefix(&self) -> Option<String> {
        self.root.prefix().ok().flatten()
    }

    /// Files of the deployment in shared memory.
    pub(super) fn memory(&self, prefix: Option<String>) -> anyhow::Result<BTreeSet<String>> {
        let prefixes: Vec<String> = prefix.into_iter().chain([self.root.kept_prefix()]).collect();
        let names = fs::read_dir(SHARED_MEMORY)?.flatten();
        let names = names.map(|entry| entry.file_name().to_string_lossy().into_owned());
        Ok(names
            .filter(|name| prefixes.iter().any(|prefix| name.starts_with(prefix)))
            .collect())
    }

    /// Fills shared memory for a while without a subscriber, which that can kill.
    pub(crate) fn full_memory(&mut self, time: Duration) -> anyhow::Result<()> {
        let folder = Path::new(SHARED_MEMORY);
        self.look_away(true);
        own_file_systems::fill(folder)?;
        std::thread::sleep(time);
        own_file_systems::make_room(folder)
    }

    /// Writes random bytes into the shared memory of the topics, and waits until the deployment has replaced the
    /// memory, or probably continues without replacement.
    pub(crate) fn corrupt(&mut self, random: &mut ChaCha8Rng) -> anyhow::Result<()> {
        const BYTES: usize = 4000;
        self.look_away(true);
        let prefix = self.prefix();
        let names = self.memory(prefix.clone())?;
        let of_topics = |name: &&String| {
            [".data", ".connection", ".dynamic"]
                .iter()
                .any(|end| name.ends_with(end))
        };
        let names: Vec<&String> = names.iter().filter(of_topics).collect();
        anyhow::ensure!(!names.is_empty(), "there is no shared memory");
        for _ in 0..BYTES {
            let path = Path::new(SHARED_MEMORY).join(names[random.random_range(0..names.len())]);
            let (share, byte) = (random.random::<f64>(), random.random::<u8>());
            // Files come and go.
            if let Ok(file) = OpenOptions::new().write(true).open(path) {
                let length = file.metadata().map_or(0, |found| found.len());
                if length > 0 {
                    let _ = file.write_at(&[byte], (share * length as f64) as u64);
                }
            }
        }
        self.is_spoilt = true;
        let begun = instant();
        while instant() - begun < CORRUPTION_SHOWS && self.prefix() == prefix {
            self.heed_stop()?;
            std::thread::sleep(PAUSE);
        }
        if self.prefix() != prefix {
            self.ledger.now(What::Rebuilt);
        }
        Ok(())
    }

    /// Whether the memory can be read: after corruption, whether another process has read a sample.
    pub(super) fn may_be_read(&mut self) -> anyhow::Result<bool> {
        if !self.is_spoilt {
            return Ok(true);
        }
        let Some((probe, begun)) = &mut self.probe else {
            let mut command = Command::new(&self.executable);
            command
                .args(["tap", "--count=1"])
                .arg(format!("--instance={INSTANCE}"))
                .env("KOSEKI_ROOT", self.root.base())
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(Stdio::null());
            self.probe = Some((command.spawn().context("starting a reader")?, instant()));
            return Ok(false);
        };
        match probe.try_wait()? {
            Some(status) => {
                self.is_spoilt = !status.success();
                self.obstacle = format!("another reader: {status}");
            }
            None if instant() - *begun > PROBE_PATIENCE => {
                "another reader saw no state".clone_into(&mut self.obstacle);
                probe.kill()?;
                probe.wait()?;
            }
            None => return Ok(false),
        }
        self.probe = None;
        Ok(!self.is_spoilt)
    }
}

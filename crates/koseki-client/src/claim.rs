//! One publisher a source: a second one would double the information in the reports.
//!
//! A publisher locks a file in the folder of the instance. The operating system releases the lock when the process
//! ends, however it ends, so a successor is accepted at once. Adapters and links lock nothing; they are found by their
//! lines in shared memory ([`bus::PublisherLine`]). The line of a killed publisher lives on until the dead are removed:
//! the file therefore lists the latest publishers that held the lock, and their lines do not count.
//!
//! The monitor is informed of a refusal ([`crate::refusals`]). Limits: a child that a publisher's process forks holds
//! the lock, too. A link or an adapter that starts later is not refused; the monitor raises an alarm while both
//! publish.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Seek as _, Write as _};

use bus::{PublisherState, Root};
use messages::{Outgoing, Topic};

use crate::connection::Connection;
use crate::error::Error;
use crate::refusals::{self, FOLDER, Refusal, Refused};

/// Most former publishers that a file lists: their lines are marked within seconds, and a topic has few lines.
const FORMER_MAX: usize = 16;

/// Right to publish on a topic, until it is dropped.
#[derive(Debug)]
pub(crate) struct Claim {
    _locked: File,
}

impl Claim {
    /// Claims `topic` for the publisher with this incarnation.
    ///
    /// # Errors
    /// [`Error::Fed`] if another process publishes on the topic.
    pub(crate) fn take<T: Outgoing>(
        root: &Root,
        connection: &Connection,
        topic: &Topic<T>,
        incarnation: u64,
    ) -> Result<Self, Error> {
        let taken = Self::try_take(root, connection, topic, incarnation);
        if let Err(Error::Fed { topic, by }) = &taken {
            let refused = Refused::Publisher {
                process: std::process::id(),
                holder: by.clone(),
            };
            let name = topic.clone();
            // The error itself reaches the caller in any case.
            let _ = refusals::note(root, &[Refusal { name, refused }]);
        }
        taken
    }

    fn try_take<T: Outgoing>(
        root: &Root,
        connection: &Connection,
        topic: &Topic<T>,
        incarnation: u64,
    ) -> Result<Self, Error> {
        let folder = root.path().join(FOLDER);
        let path = folder.join(topic.name.as_str().replace('/', "."));
        let failed = |source: io::Error| Error::Claim {
            path: path.clone(),
            source,
        };
        fs::create_dir_all(&folder).map_err(failed)?;
        let mut options = OpenOptions::new();
        let opened = options.create(true).read(true).write(true).truncate(false).open(&path);
        let mut file = opened.map_err(failed)?;
        let fed = |by: String| Error::Fed {
            topic: topic.name.as_str().to_owned(),
            by,
        };
        let is_locked = match file.try_lock() {
            Ok(()) => false,
            Err(TryLockError::WouldBlock) => true,
            Err(TryLockError::Error(error)) => return Err(failed(error)),
        };
        let mut text = String::new();
        file.read_to_string(&mut text).map_err(failed)?;
        let mut lines = text.lines();
        let process = lines.next().unwrap_or_default().to_owned();
        if is_locked {
            return Err(fed(format!("process {process}")));
        }
        let mut former: Vec<u64> = lines.filter_map(|line| line.parse().ok()).collect();
        let is_of_another =
            |line: &bus::PublisherLine| line.life == PublisherState::Lives && !former.contains(&line.incarnation);
        if connection.bus.publisher_lines(topic)?.iter().any(is_of_another) {
            return Err(fed("an adapter or a link".to_owned()));
        }
        former.push(incarnation);
        let kept = &former[former.len().saturating_sub(FORMER_MAX)..];
        let former: String = kept.iter().map(|incarnation| format!("{incarnation}\n")).collect();
        let text = format!("{}\n{former}", std::process::id());
        file.rewind()
            .and_then(|()| file.set_len(0))
            .and_then(|()| file.write_all(text.as_bytes()))
            .map_err(failed)?;
        Ok(Self { _locked: file })
    }
}

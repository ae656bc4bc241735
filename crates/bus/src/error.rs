//! Errors, each with a remedy.
//!
//! Every message names the object, the attempted action, the limit (if any), and the remedy. Errors possible in the
//! steady state own no heap memory: a topic's name is shared with the port.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use thiserror::Error;

use crate::process::MemberProcess;

/// An operation of this crate failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BusError {
    /// The name of an instance has a forbidden form.
    #[error("instance name \"{name}\" is not usable: take 1 to {limit} letters, digits, '-' and '_'")]
    InstanceName {
        /// The name as given.
        name: String,
        /// Most characters.
        limit: usize,
    },

    /// A deployment's folder is so deep that the names of sockets in the folder would not fit.
    #[error(
        "{} is {length} bytes long, which leaves no room for the names of sockets in it: at most {limit} bytes work; \
         take a shorter instance name or another base folder",
        path.display()
    )]
    PathTooLong {
        /// The folder.
        path: PathBuf,
        /// Length of the path in bytes.
        length: usize,
        /// Most bytes.
        limit: usize,
    },

    /// The base folder is open to other users, or could be exchanged by other users.
    #[error(
        "base folder: {} {fault}: take a folder of your own, in folders of your own (mode 0700), with --root or \
         $KOSEKI_ROOT",
        path.display()
    )]
    BaseNotPrivate {
        /// The folder, or a folder above.
        path: PathBuf,
        /// Reason of the refusal.
        fault: &'static str,
    },

    /// Something that Koseki has not made has the place of an instance's folder or lock.
    #[error(
        "{} was not created by Koseki, and is not changed: move it away, or use another instance name or base folder",
        path.display()
    )]
    NotOurs {
        /// Path of the existing file or folder.
        path: PathBuf,
    },

    /// A live process runs this instance already.
    #[error(
        "instance {instance} is already run by process {}: end that one first, or take another instance name",
        Pid(*pid)
    )]
    AlreadyRunning {
        /// The instance.
        instance: String,
        /// The process, where readable.
        pid: Option<u32>,
    },

    /// The instance's launcher is gone, but processes that the launcher started still run.
    #[error(
        "instance {instance} has no launcher, but its shared memory is still used by {}: end these processes first",
        Processes(processes)
    )]
    StillUsed {
        /// The instance.
        instance: String,
        /// Processes that use the instance.
        processes: Vec<MemberProcess>,
    },

    /// The instance does not run.
    #[error(
        "instance {instance} is not running: start it with `koseki up`, or name the instance that runs (its folder is \
         sought in {}, which KOSEKI_ROOT sets)",
        base.display()
    )]
    NotRunning {
        /// The instance.
        instance: String,
        /// The folder that contains the instances.
        base: PathBuf,
    },

    /// A file operation failed.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// Attempt that failed.
        action: &'static str,
        /// On which file or folder.
        path: PathBuf,
        /// Cause of the failure.
        source: io::Error,
    },

    /// The process could not connect to the instance.
    #[error(
        "process {process} cannot join instance {instance}: {reason}; check the rights of {}",
        path.display()
    )]
    Join {
        /// The process's name.
        process: String,
        /// The instance.
        instance: String,
        /// Folder of the instance.
        path: PathBuf,
        /// iceoryx2's reason.
        reason: String,
    },

    /// The topic does not exist.
    #[error(
        "topic {topic} does not exist (asked for {waited_ms} ms): is `koseki up` running, and does its configuration \
         have this topic?"
    )]
    NoSuchTopic {
        /// The topic.
        topic: Arc<str>,
        /// Duration of the attempts.
        waited_ms: u128,
    },

    /// The topic exists with another type or with smaller sizes.
    #[error(
        "topic {topic} exists with another sample type or other sizes ({reason}): start all processes from one build"
    )]
    Incompatible {
        /// The topic.
        topic: Arc<str>,
        /// iceoryx2's reason.
        reason: String,
    },

    /// The topic has no place left.
    #[error("topic {topic} has no free place for another {role}: the limit is {limit}; end an unneeded {role}")]
    Full {
        /// The topic.
        topic: Arc<str>,
        /// Which kind of place.
        role: PortRole,
        /// How many there are.
        limit: usize,
    },

    /// The topic permits no queue of this length.
    #[error(
        "topic {topic}: a queue of {queue} slices is refused: the length is from 1 to {limit}; request such a length, \
         or, for system/tracks, raise `[machine] queue_slices` in the configuration"
    )]
    Queue {
        /// The topic.
        topic: Arc<str>,
        /// Length as requested, slices.
        queue: usize,
        /// Greatest length, slices.
        limit: usize,
    },

    /// The topic could not be opened or created, or a port of the topic could not be created.
    #[error("topic {topic}: cannot {action}: {reason}; if the instance was killed during its start, start it again")]
    Topic {
        /// The topic.
        topic: Arc<str>,
        /// Attempt that failed.
        action: &'static str,
        /// iceoryx2's reason.
        reason: String,
    },

    /// A waiter watches as many topics as possible.
    #[error("topic {topic}: this waiter already watches {limit} topics, and that is its limit")]
    WatchedTooMany {
        /// The topic.
        topic: Arc<str>,
        /// Most topics.
        limit: usize,
    },

    /// A slice could not be sent. The slice's samples keep their sequence numbers, so that subscribers count the
    /// samples as lost.
    #[error(
        "topic {topic}: {samples} samples were not sent: {reason}; remove dead processes, they may hold the memory"
    )]
    Send {
        /// The topic.
        topic: Arc<str>,
        /// How many samples.
        samples: usize,
        /// iceoryx2's reason.
        reason: &'static str,
    },

    /// Nothing could be taken.
    #[error("topic {topic}: nothing can be taken: {reason}; try again, and remove dead processes")]
    Take {
        /// The topic.
        topic: Arc<str>,
        /// iceoryx2's reason.
        reason: &'static str,
    },

    /// The subscriber keeps as many slices as permitted.
    #[error("topic {topic}: {limit} slices are kept, which is the limit: release a slice, or copy its samples")]
    Borrowed {
        /// The topic.
        topic: Arc<str>,
        /// Most slices that a subscriber may keep.
        limit: usize,
    },

    /// Waiting failed.
    #[error("cannot wait for {watched} topics: {source}")]
    Wait {
        /// How many topics are watched.
        watched: usize,
        /// Why.
        source: io::Error,
    },

    /// The shared memory is too small. Without this check, the first write past the end would kill the writer.
    #[error(
        "{} has {free} bytes free, but the topics need up to {needed}: free some, make it larger (`mount -o \
         remount,size=…`), or configure fewer sources",
        path.display()
    )]
    Space {
        /// Where the shared memory is.
        path: PathBuf,
        /// Bytes that the topics need.
        needed: u64,
        /// Bytes that are free.
        free: u64,
    },
}

/// A kind of place that a topic has a limited number of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortRole {
    /// A port that sends.
    Publisher,
    /// A port that takes.
    Subscriber,
    /// A port that waits.
    Listener,
    /// A process that has opened the topic.
    Process,
}

impl fmt::Display for PortRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Publisher => "publisher",
            Self::Subscriber => "subscriber",
            Self::Listener => "listener",
            Self::Process => "process",
        })
    }
}

struct Pid(Option<u32>);

impl fmt::Display for Pid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(pid) => write!(f, "{pid}"),
            None => f.write_str("(unknown)"),
        }
    }
}

struct Processes<'a>(&'a [MemberProcess]);

impl fmt::Display for Processes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, process) in self.0.iter().enumerate() {
            let separator = if index == 0 { "" } else { ", " };
            write!(f, "{separator}{} ({})", process.pid, process.name)?;
        }
        Ok(())
    }
}

/// Returns a closure for `map_err` that names the action on `path` refused by the operating system.
pub(crate) fn io_error(action: &'static str, path: &Path) -> impl Fn(io::Error) -> BusError {
    let path = path.to_owned();
    move |source| BusError::Io {
        action,
        path: path.clone(),
        source,
    }
}

//! Process of an instance, in the view of other processes.

/// A live process that has joined an instance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MemberProcess {
    /// Number in the operating system; 0 if unreadable.
    pub pid: u32,
    /// The name given by the process.
    pub name: String,
}

impl MemberProcess {
    pub(crate) fn unknown() -> Self {
        Self {
            pid: 0,
            name: "unknown".to_owned(),
        }
    }
}

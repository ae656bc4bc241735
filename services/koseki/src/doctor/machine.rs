//! The machine as described by the kernel's files.

use std::fs;
use std::path::PathBuf;
use std::str::FromStr;

/// Right to any priority (`capabilities(7)`).
pub(super) const CAP_SYS_NICE: u32 = 23;
/// Right to lock any amount of memory.
pub(super) const CAP_IPC_LOCK: u32 = 14;

/// Names, cut to 15 characters as the kernel does, of services that set the clock.
const CLOCK_SETTERS: [&str; 6] = ["chronyd", "ntpd", "openntpd", "systemd-timesyn", "ptp4l", "phc2sys"];

/// Machine, as files below a folder.
#[derive(Debug)]
pub(super) struct MachineFiles {
    root: PathBuf,
}

impl MachineFiles {
    /// The machine below `root`: `/` is this machine.
    pub(super) fn at(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into() }
    }

    /// Content of a file without surrounding white space; `None` without such a file.
    pub(super) fn text(&self, path: &str) -> Option<String> {
        let text = fs::read_to_string(self.root.join(path)).ok()?;
        Some(text.trim().to_owned())
    }

    /// Number in a file.
    pub(super) fn number<T: FromStr>(&self, path: &str) -> Option<T> {
        self.text(path)?.parse().ok()
    }

    /// The word in brackets among the words of a file.
    pub(super) fn chosen(&self, path: &str) -> Option<String> {
        let text = self.text(path)?;
        let (_, rest) = text.split_once('[')?;
        Some(rest.split_once(']')?.0.to_owned())
    }

    /// Numbers of cores that a file lists.
    pub(super) fn cores(&self, path: &str) -> Vec<usize> {
        let listed = self.text(path).and_then(|text| runtime::cores::parse_list(&text));
        listed.unwrap_or_default()
    }

    /// Whether this process has a right.
    pub(super) fn may(&self, capability: u32) -> bool {
        let status = self.text("proc/self/status").unwrap_or_default();
        let mut lines = status.lines().filter_map(|line| line.strip_prefix("CapEff:"));
        let granted = lines.next().and_then(|hex| u64::from_str_radix(hex.trim(), 16).ok());
        granted.is_some_and(|granted| granted >> capability & 1 == 1)
    }

    /// Limit of this process that the kernel calls `name`; the largest number for none.
    pub(super) fn limit(&self, name: &str) -> Option<u64> {
        let limits = self.text("proc/self/limits")?;
        let value = limits.lines().find_map(|line| line.strip_prefix(name))?;
        match value.split_whitespace().next()? {
            "unlimited" => Some(u64::MAX),
            number => number.parse().ok(),
        }
    }

    /// Longest time in which a core comes back from an idle state that is switched on, microseconds; `None` without
    /// idle states.
    pub(super) fn deepest_idle_us(&self) -> Option<u64> {
        let states = (0..16).map(|state| format!("sys/devices/system/cpu/cpu0/cpuidle/state{state}"));
        let is_on = |state: &String| {
            self.text(&format!("{state}/disable"))
                .is_none_or(|disabled| disabled == "0")
        };
        states
            .filter(is_on)
            .filter_map(|state| self.number(&format!("{state}/latency")))
            .max()
    }

    /// Name of a service that runs and sets the clock.
    pub(super) fn clock_setter(&self) -> Option<String> {
        let processes = fs::read_dir(self.root.join("proc")).ok()?;
        let mut names = processes.filter_map(|process| {
            let name = fs::read_to_string(process.ok()?.path().join("comm")).ok()?;
            Some(name.trim().to_owned())
        });
        names.find(|name| CLOCK_SETTERS.contains(&name.as_str()))
    }
}

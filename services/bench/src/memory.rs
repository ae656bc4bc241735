//! Memory use and page faults of a process.

use std::fs;

use anyhow::Context as _;
use serde::{Deserialize, Serialize};

/// Memory of one process at one moment. In a steady state, pages and faults do not increase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProcessMemory {
    /// Pages in physical memory.
    pub resident_pages: u64,
    /// Page faults so far without disk access.
    pub minor_faults: u64,
    /// Page faults so far with disk access.
    pub major_faults: u64,
}

impl ProcessMemory {
    /// Reads the current values of the process `pid`.
    pub(crate) fn of(pid: u32) -> anyhow::Result<Self> {
        let statm = fs::read_to_string(format!("/proc/{pid}/statm"))?;
        let stat = fs::read_to_string(format!("/proc/{pid}/stat"))?;
        Self::parse(&statm, &stat).with_context(|| format!("/proc/{pid}: unknown form"))
    }

    fn parse(statm: &str, stat: &str) -> Option<Self> {
        let resident_pages = statm.split_whitespace().nth(1)?.parse().ok()?;
        // The name in parentheses may contain anything; the state follows it.
        let rest = &stat[stat.rfind(')')? + 1..];
        let mut fields = rest.split_whitespace().skip(7);
        let minor_faults = fields.next()?.parse().ok()?;
        let major_faults = fields.nth(1)?.parse().ok()?;
        Some(Self {
            resident_pages,
            minor_faults,
            major_faults,
        })
    }
}

/// Returns the memory of this process that is in use, octets.
pub(crate) fn resident_octets() -> anyhow::Result<f64> {
    let status = fs::read_to_string("/proc/self/status")?;
    parse_resident(&status).context("/proc/self/status: unknown form")
}

fn parse_resident(status: &str) -> Option<f64> {
    let mut lines = status.lines();
    let kilobytes = lines.find_map(|line| line.strip_prefix("VmRSS:")?.trim().strip_suffix(" kB"))?;
    kilobytes.trim().parse::<f64>().ok().map(|kilobytes| 1024.0 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_in_use_is_that_of_the_status() {
        let status = "Name:\ta b\nVmPeak:\t  9000 kB\nVmRSS:\t    1234 kB\nThreads:\t1\n";
        assert_eq!(parse_resident(status), Some(1234.0 * 1024.0));
        assert_eq!(parse_resident("Name:\ta\n"), None);
        let before = resident_octets().unwrap();
        let used = std::hint::black_box(vec![1u8; 32 << 20]);
        let grown = resident_octets().unwrap() - before;
        assert!(grown > 16e6 && used.len() == 32 << 20, "{grown}");
    }

    #[test]
    fn read_as_the_kernel_writes_it() {
        let stat = "17 (a ) b) S 1 17 17 0 -1 4194304 1234 5 6 7 8 9 0 0 20 0 1 0 100 1000 300 184\n";
        let memory = ProcessMemory::parse("5000 300 200 1 0 90 0\n", stat).unwrap();
        assert_eq!(
            (memory.resident_pages, memory.minor_faults, memory.major_faults),
            (300, 1234, 6)
        );
        let own = ProcessMemory::of(std::process::id()).unwrap();
        assert!(own.resident_pages > 0 && own.minor_faults > 0);
        assert_eq!(ProcessMemory::parse("", ""), None);
    }
}

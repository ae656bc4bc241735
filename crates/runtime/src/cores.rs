//! Assignment of a core to a thread (PL-5).

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use thread_priority::unix::{
    RealtimeThreadSchedulePolicy, ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
};
use thread_priority::{ThreadPriority, ThreadPriorityValue};

/// Stack of a real-time thread, bytes: touched before the loop begins.
const STACK_BYTES: usize = 256 << 10;

/// Placement of a real-time thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Placement {
    /// Core of the thread.
    pub core: Option<usize>,
    /// `SCHED_FIFO` priority, 1 to 99.
    pub realtime_priority: Option<i32>,
    /// Whether to lock all memory, so that no page fault occurs later.
    pub lock_memory: bool,
}

impl From<&deployment::Fusion> for Placement {
    fn from(fusion: &deployment::Fusion) -> Self {
        Self {
            core: fusion.core,
            realtime_priority: fusion.realtime_priority,
            lock_memory: fusion.lock_memory,
        }
    }
}

/// File in which the kernel lists the cores that are switched on.
const ONLINE: &str = "/sys/devices/system/cpu/online";

/// Returns the numbers of the cores that are switched on, rising. A thread can be pinned to each of them, also to
/// isolated cores (`isolcpus`) and to cores outside this process's affinity mask; a cpuset can still refuse a core.
pub fn online() -> Vec<usize> {
    let listed = std::fs::read_to_string(ONLINE).ok().and_then(|text| parse_list(&text));
    listed.unwrap_or_else(available)
}

/// Parses the kernel's list of numbers, as in `0-3,8`; `None` if `text` is no list.
pub fn parse_list(text: &str) -> Option<Vec<usize>> {
    let mut numbers = Vec::new();
    for range in text.trim().split(',') {
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        let (first, last): (usize, usize) = (first.parse().ok()?, last.parse().ok()?);
        numbers.extend(first..=last);
    }
    Some(numbers)
}

/// Returns the numbers of the cores in this process's affinity mask, to which the scheduler assigns the process.
pub fn available() -> Vec<usize> {
    core_affinity::get_core_ids()
        .unwrap_or_default()
        .into_iter()
        .map(|core| core.id)
        .collect()
}

/// Applies `placement` to the calling thread. Returns one sentence for each refusal of the machine, with the
/// permission that is missing.
pub fn take_place(placement: Placement) -> Vec<String> {
    let mut refused = Vec::new();
    if let Some(core) = placement.core
        && let Err(reason) = pin_to(core)
    {
        refused.push(reason);
    }
    if let Some(priority) = placement.realtime_priority
        && let Err(reason) = become_fifo(priority)
    {
        refused.push(format!(
            "SCHED_FIFO priority {priority} was refused ({reason}): grant CAP_SYS_NICE or raise the limit `ulimit -r`"
        ));
    }
    if placement.lock_memory {
        touch_stack();
        if let Err(error) = mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE) {
            refused.push(format!(
                "locking memory was refused ({error}): grant CAP_IPC_LOCK or raise the limit `ulimit -l`"
            ));
        }
    }
    refused
}

/// Pins the calling thread to `core`.
///
/// # Errors
/// One sentence, if the machine refuses.
pub fn pin_to(core: usize) -> Result<(), String> {
    let is_pinned = core_affinity::set_for_current(core_affinity::CoreId { id: core });
    is_pinned.then_some(()).ok_or_else(|| {
        format!(
            "core {core} cannot be taken: the machine has cores {:?}, of which its cpuset or container may grant fewer",
            online()
        )
    })
}

/// Permits all cores that are switched on to the calling thread.
///
/// # Errors
/// One sentence, if the machine refuses.
pub fn unpin() -> Result<(), String> {
    let mut all = CpuSet::new();
    for core in online().into_iter().filter(|core| *core < CpuSet::MAX_CPU) {
        all.set(core);
    }
    sched_setaffinity(None, &all).map_err(|error| format!("the core cannot be left: {error}"))
}

/// Removes `core` from the cores of the calling thread, if there is another. Best effort: a refusal changes nothing.
pub fn stay_away_from(core: usize) {
    if let Ok(mut allowed) = sched_getaffinity(None)
        && core < CpuSet::MAX_CPU
    {
        allowed.unset(core);
        if allowed.count() > 0 {
            let _ = sched_setaffinity(None, &allowed);
        }
    }
}

/// Touches the pages of the stack, so that the kernel provides them now. Locked pages of the heap exist already.
#[inline(never)]
fn touch_stack() {
    let mut stack = [0u8; STACK_BYTES];
    std::hint::black_box(&mut stack);
}

fn become_fifo(priority: i32) -> Result<(), String> {
    let value = u8::try_from(priority)
        .ok()
        .and_then(|value| ThreadPriorityValue::try_from(value).ok());
    let value = value.ok_or_else(|| "it must lie between 1 and 99".to_owned())?;
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Crossplatform(value), policy)
        .map_err(|error| format!("{error:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_cores_are_read_as_the_kernel_writes_them() {
        assert_eq!(parse_list("0\n"), Some(vec![0]));
        assert_eq!(parse_list("0-3,5,7-8\n"), Some(vec![0, 1, 2, 3, 5, 7, 8]));
        assert_eq!(parse_list("\n"), None);
        assert_eq!(parse_list("0-x\n"), None);
    }

    #[test]
    fn what_a_process_may_use_is_switched_on() {
        let online = online();
        assert!(available().iter().all(|core| online.contains(core)), "{online:?}");
    }
}

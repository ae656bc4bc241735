//! `koseki doctor`: checks whether this machine is fit for a deployment, and prints remedies.
//!
//! The output has a line per check: result, requirement, and, if they differ, the remedy as a command. The
//! requirements follow from the configuration, if given, otherwise from a deployment that waits by event.
//! docs/real-time.md explains them.

mod machine;

use std::fmt::Write as _;
use std::path::Path;

use deployment::{ReceiverTransport, WaitWord};
use messages::codes;
use serde::{Serialize, Serializer};

use crate::args::Doctor;
use crate::config::Config;
use machine::MachineFiles;

/// Smallest limit of open files: each process has several for each topic and process in use.
const FILES_WANTED: u64 = 4096;

codes! {
    /// Verdict on a result.
    enum RunVerdict {
        /// As wanted.
        Good, "good";
        /// Koseki runs, but would run better with the requirement fulfilled.
        Improvable, "improvable";
        /// Impossible here, and the configuration asks for it.
        Lacking, "lacking";
    }
}

impl Serialize for RunVerdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word())
    }
}

/// Answer to a question.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct FindingKind {
    subject: &'static str,
    verdict: RunVerdict,
    found: String,
    wanted: String,
    /// Remedy as a command; `None` where no remedy is needed, or no command is one.
    mend: Option<String>,
}

/// Demands of a deployment on the machine.
#[derive(Clone, Debug)]
struct Wants {
    core: Option<usize>,
    realtime_priority: Option<i32>,
    lock_memory: bool,
    /// Whether a refusal of the above is an error.
    required: bool,
    spins: bool,
    rests: bool,
    /// Largest buffer of a receiver, bytes; 0 without receivers.
    receive_buffer: u64,
    shared_memory: u64,
}

impl Wants {
    fn of(config: &Config) -> Self {
        let fusion = &config.fusion;
        let buffer = |transport: &ReceiverTransport| match transport {
            ReceiverTransport::Udp(input) => input.buffer_bytes as u64,
            _ => 0,
        };
        let buffers = config.receivers.iter().map(|receiver| buffer(&receiver.transport));
        Self {
            core: fusion.core,
            realtime_priority: fusion.realtime_priority,
            lock_memory: fusion.lock_memory,
            required: fusion.required,
            spins: fusion.wait != WaitWord::Event,
            rests: fusion.rests,
            receive_buffer: buffers.max().unwrap_or(0),
            shared_memory: launcher::needed_bytes(config),
        }
    }

    /// Verdict on a right that was asked for and is not granted.
    fn refused(&self) -> RunVerdict {
        match self.required {
            true => RunVerdict::Lacking,
            false => RunVerdict::Improvable,
        }
    }
}

/// Runs the checks, and prints the results.
///
/// # Errors
/// If the configuration cannot be read, or a requested resource is unavailable.
pub(crate) fn run(doctor: &Doctor) -> anyhow::Result<()> {
    let path = doctor
        .config
        .as_deref()
        .unwrap_or(Path::new(configuration::BUILT_IN_DEMO));
    let wants = Wants::of(&Config::read(path, &doctor.set)?);
    let free = bus::free_space().ok();
    let findings = examine(&MachineFiles::at("/"), &wants, free);
    match doctor.json {
        true => crate::print(&(serde_json::to_string_pretty(&findings)? + "\n"))?,
        false => crate::print(&text(&findings))?,
    }
    let lacking = count(&findings, RunVerdict::Lacking);
    anyhow::ensure!(
        lacking == 0,
        "{lacking} requirements of {} cannot be satisfied",
        path.display()
    );
    Ok(())
}

fn count(findings: &[FindingKind], verdict: RunVerdict) -> usize {
    findings.iter().filter(|finding| finding.verdict == verdict).count()
}

fn text(findings: &[FindingKind]) -> String {
    let mut text = String::new();
    for finding in findings {
        let wanted = match finding.verdict {
            RunVerdict::Good => String::new(),
            _ => format!("; wanted: {}", finding.wanted),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:<10}  {:<20}  {}{wanted}",
            finding.verdict.word(),
            finding.subject,
            finding.found
        );
        if let Some(mend) = &finding.mend {
            let _ = writeln!(text, "{:<10}  {:<20}  mend: {mend}", "", "");
        }
    }
    let [good, improvable, lacking] =
        [RunVerdict::Good, RunVerdict::Improvable, RunVerdict::Lacking].map(|verdict| count(findings, verdict));
    let _ = writeln!(
        text,
        "\n{good} of {} as wanted, {improvable} could be better, {lacking} lacking; docs/real-time.md explains the requirements",
        findings.len()
    );
    text
}

/// Asks every question; `free` octets of shared memory are left, if that is known.
fn examine(machine: &MachineFiles, wants: &Wants, free: Option<u64>) -> Vec<FindingKind> {
    vec![
        cores(machine, wants),
        isolation(machine, wants),
        governor(machine),
        idle_states(machine, wants),
        realtime_priority(machine, wants),
        realtime_throttling(machine, wants),
        locked_memory(machine, wants),
        open_files(machine),
        receive_buffer(machine, wants),
        shared_memory(wants, free),
        huge_pages(machine),
        clock_source(machine),
        clock_service(machine),
    ]
}

/// A finding that is good if `is_good`, else `otherwise` with the remedy as a command.
fn finding(
    subject: &'static str,
    (is_good, otherwise): (bool, RunVerdict),
    found: impl Into<String>,
    wanted: impl Into<String>,
    mend: impl Into<String>,
) -> FindingKind {
    FindingKind {
        subject,
        verdict: if is_good { RunVerdict::Good } else { otherwise },
        found: found.into(),
        wanted: wanted.into(),
        mend: (!is_good).then(|| mend.into()).filter(|mend| !mend.is_empty()),
    }
}

fn cores(machine: &MachineFiles, wants: &Wants) -> FindingKind {
    let online = machine.cores("sys/devices/system/cpu/online");
    let found = format!("{} switched on", online.len());
    match wants.core {
        Some(core) => finding(
            "cores",
            (online.contains(&core), wants.refused()),
            found,
            format!("core {core} among them, as configured in fusion.core"),
            format!("echo 1 > /sys/devices/system/cpu/cpu{core}/online; or name another core in fusion.core"),
        ),
        None => finding(
            "cores",
            (online.len() > 1, RunVerdict::Improvable),
            found,
            "at least 2: one for fusion, and one for all others",
            "",
        ),
    }
}

fn isolation(machine: &MachineFiles, wants: &Wants) -> FindingKind {
    let isolated = machine.cores("sys/devices/system/cpu/isolated");
    let found = match isolated.is_empty() {
        true => "none".to_owned(),
        false => format!("{isolated:?}"),
    };
    let Some(core) = wants.core else {
        let wanted = "nothing: fusion has no core of its own (fusion.core)";
        return finding("isolated cores", (true, RunVerdict::Good), found, wanted, "");
    };
    finding(
        "isolated cores",
        (isolated.contains(&core), RunVerdict::Improvable),
        found,
        format!("core {core}: nothing else runs on fusion's core"),
        format!("add the kernel parameters isolcpus=managed_irq,domain,{core} nohz_full={core} rcu_nocbs={core}"),
    )
}

fn governor(machine: &MachineFiles) -> FindingKind {
    let cores = machine.cores("sys/devices/system/cpu/online");
    let path = |core: &usize| format!("sys/devices/system/cpu/cpu{core}/cpufreq/scaling_governor");
    let governors: Vec<String> = cores.iter().filter_map(|core| machine.text(&path(core))).collect();
    let slow = governors.iter().filter(|governor| *governor != "performance").count();
    let found = match governors.first() {
        None => "none here: the processor or the host decides".to_owned(),
        Some(_) if slow == 0 => "performance".to_owned(),
        Some(_) => format!("{slow} of {} cores have another than performance", governors.len()),
    };
    finding(
        "governor",
        (slow == 0, RunVerdict::Improvable),
        found,
        "performance on every core",
        "cpupower frequency-set -g performance",
    )
}

fn idle_states(machine: &MachineFiles, wants: &Wants) -> FindingKind {
    let deepest = machine.deepest_idle_us();
    let found = match deepest {
        None => "none here: the host decides".to_owned(),
        Some(us) => format!("a sleeping core comes back after up to {us} µs"),
    };
    finding(
        "idle states",
        (wants.spins || deepest.is_none_or(|us| us <= 10), RunVerdict::Improvable),
        found,
        "at most 10 µs, since fusion sleeps between reports",
        "cpupower idle-set -D 10; or hold /dev/cpu_dma_latency open with 0 written to it",
    )
}

fn realtime_priority(machine: &MachineFiles, wants: &Wants) -> FindingKind {
    let wished = wants.realtime_priority.unwrap_or(0);
    let limit = machine.limit("Max realtime priority");
    let (is_granted, found) = match (machine.may(machine::CAP_SYS_NICE), limit) {
        (true, _) => (true, "any (CAP_SYS_NICE)".to_owned()),
        (false, Some(limit)) => (limit >= wished.max(0) as u64, format!("up to {limit}")),
        (false, None) => (false, "unknown".to_owned()),
    };
    finding(
        "real-time priority",
        (is_granted, wants.refused()),
        found,
        format!("up to {wished}, as configured in fusion.realtime_priority"),
        format!("LimitRTPRIO={wished} in the unit; or `ulimit -r {wished}` after a line in /etc/security/limits.d"),
    )
}

fn realtime_throttling(machine: &MachineFiles, wants: &Wants) -> FindingKind {
    let runtime_us: Option<i64> = machine.number("proc/sys/kernel/sched_rt_runtime_us");
    let matters = wants.spins && wants.realtime_priority.is_some() && !wants.rests;
    finding(
        "real-time throttling",
        (!matters || runtime_us == Some(-1), RunVerdict::Improvable),
        match runtime_us {
            Some(-1) => "off".to_owned(),
            Some(us) => format!("real-time threads may have {us} µs of each second"),
            None => "unknown".to_owned(),
        },
        "off, since fusion spins at real-time priority without rests",
        "sysctl -w kernel.sched_rt_runtime_us=-1; or set fusion.rests = true",
    )
}

fn locked_memory(machine: &MachineFiles, wants: &Wants) -> FindingKind {
    let limit = machine.limit("Max locked memory");
    let is_free = machine.may(machine::CAP_IPC_LOCK) || limit == Some(u64::MAX);
    let found = match (is_free, limit) {
        (true, _) => "as much as there is".to_owned(),
        (false, Some(limit)) => format!("{limit} octets"),
        (false, None) => "unknown".to_owned(),
    };
    finding(
        "locked memory",
        (!wants.lock_memory || is_free, wants.refused()),
        found,
        "no limit, since fusion.lock_memory is set",
        "LimitMEMLOCK=infinity in the unit; or `ulimit -l unlimited` after a line in /etc/security/limits.d",
    )
}

fn open_files(machine: &MachineFiles) -> FindingKind {
    let limit = machine.limit("Max open files");
    finding(
        "open files",
        (limit.is_some_and(|limit| limit >= FILES_WANTED), RunVerdict::Improvable),
        limit.map_or("unknown".to_owned(), |limit| format!("up to {limit} for each process")),
        format!("at least {FILES_WANTED}"),
        "LimitNOFILE=65536 in the unit; or `ulimit -n 65536`",
    )
}

fn receive_buffer(machine: &MachineFiles, wants: &Wants) -> FindingKind {
    let granted: Option<u64> = machine.number("proc/sys/net/core/rmem_max");
    let wished = wants.receive_buffer;
    finding(
        "receive buffer",
        (granted.is_some_and(|granted| granted >= wished), RunVerdict::Improvable),
        granted.map_or("unknown".to_owned(), |granted| {
            format!("up to {granted} octets for each socket")
        }),
        format!("{wished} octets, as configured in the receivers' buffer_bytes"),
        format!("sysctl -w net.core.rmem_max={wished}"),
    )
}

fn shared_memory(wants: &Wants, free: Option<u64>) -> FindingKind {
    let needed = wants.shared_memory;
    finding(
        "shared memory",
        (free.is_none_or(|free| free >= needed), RunVerdict::Lacking),
        free.map_or("unknown".to_owned(), |free| {
            format!("{} free", crate::check::size(free))
        }),
        format!("{}, the most that the topics can take", crate::check::size(needed)),
        format!("mount -o remount,size={needed} /dev/shm"),
    )
}

fn huge_pages(machine: &MachineFiles) -> FindingKind {
    let defrag = machine.chosen("sys/kernel/mm/transparent_hugepage/defrag");
    let is_calm = defrag.as_deref().is_none_or(|word| word != "always");
    finding(
        "huge pages",
        (is_calm, RunVerdict::Improvable),
        defrag.map_or("not in this kernel".to_owned(), |word| {
            format!("made on demand: {word}")
        }),
        "never while a process waits that did not ask for one",
        "echo never > /sys/kernel/mm/transparent_hugepage/defrag",
    )
}

fn clock_source(machine: &MachineFiles) -> FindingKind {
    let source = machine.text("sys/devices/system/clocksource/clocksource0/current_clocksource");
    let slow = ["hpet", "acpi_pm", "jiffies", "xen", "refined-jiffies"];
    let is_fast = source.as_deref().is_some_and(|source| !slow.contains(&source));
    finding(
        "clock source",
        (is_fast, RunVerdict::Improvable),
        source.unwrap_or_else(|| "unknown".to_owned()),
        "one that is read without a system call, as tsc",
        "kernel parameter clocksource=tsc, if the processor's counter is invariant",
    )
}

fn clock_service(machine: &MachineFiles) -> FindingKind {
    let setter = machine.clock_setter();
    finding(
        "clock's service",
        (setter.is_some(), RunVerdict::Improvable),
        setter.unwrap_or_else(|| "none runs here; a host or container may set the clock from outside".to_owned()),
        "a service that keeps UTC: sensors' times are compared with it",
        "systemctl enable --now chrony   (or systemd-timesyncd, ptp4l)",
    )
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const FREE: u64 = 1 << 30;

    /// A machine of files, and the folder of these files.
    fn machine(files: &[(&str, &str)]) -> (tempfile::TempDir, MachineFiles) {
        let folder = tempfile::tempdir().unwrap();
        for (path, text) in files {
            let path = folder.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let machine = MachineFiles::at(folder.path());
        (folder, machine)
    }

    const LIMITS: &str = "\
Limit                     Soft Limit           Hard Limit           Units
Max locked memory         8388608              8388608              bytes
Max open files            1024                 524288               files
Max realtime priority     0                    0
";

    const TUNED: [(&str, &str); 12] = [
        ("sys/devices/system/cpu/online", "0-3\n"),
        ("sys/devices/system/cpu/isolated", "1\n"),
        ("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n"),
        ("sys/devices/system/cpu/cpu0/cpuidle/state1/latency", "2\n"),
        ("proc/self/status", "Name:\tkoseki\nCapEff:\t0000000000804000\n"),
        (
            "proc/self/limits",
            "Max open files            65536                65536                files\n",
        ),
        ("proc/sys/kernel/sched_rt_runtime_us", "-1\n"),
        ("proc/sys/net/core/rmem_max", "8388608\n"),
        (
            "sys/kernel/mm/transparent_hugepage/defrag",
            "always defer defer+madvise madvise [never]\n",
        ),
        (
            "sys/devices/system/clocksource/clocksource0/current_clocksource",
            "tsc\n",
        ),
        ("proc/81/comm", "sh\n"),
        ("proc/902/comm", "chronyd\n"),
    ];

    fn demanding() -> Wants {
        Wants {
            core: Some(1),
            realtime_priority: Some(80),
            lock_memory: true,
            required: true,
            spins: true,
            rests: false,
            receive_buffer: 4 << 20,
            shared_memory: 1 << 20,
        }
    }

    #[test]
    fn a_tuned_machine_is_good_throughout() {
        let (_folder, machine) = machine(&TUNED);
        let findings = examine(&machine, &demanding(), Some(FREE));
        let bad: Vec<_> = findings
            .iter()
            .filter(|finding| finding.verdict != RunVerdict::Good)
            .collect();
        assert!(bad.is_empty(), "{bad:#?}");
        assert!(
            text(&findings).ends_with("0 could be better, 0 lacking; docs/real-time.md explains the requirements\n")
        );
    }

    #[test]
    fn what_differs_is_named_with_a_command_that_mends_it() {
        let mended = |path: &str, text: &str, subject: &str, wants: &Wants| {
            let mut files = TUNED.to_vec();
            files.retain(|(name, _)| *name != path);
            files.push((path, text));
            let (_folder, machine) = machine(&files);
            let findings = examine(&machine, wants, Some(FREE));
            let differing: Vec<_> = findings
                .iter()
                .filter(|finding| finding.verdict != RunVerdict::Good)
                .collect();
            let subjects: Vec<_> = differing.iter().map(|finding| finding.subject).collect();
            assert_eq!(subjects, [subject], "{path}");
            (differing[0].verdict, differing[0].mend.clone().unwrap_or_default())
        };
        for (path, text, subject, verdict, mend) in [
            (
                "sys/devices/system/cpu/isolated",
                "\n",
                "isolated cores",
                RunVerdict::Improvable,
                "nohz_full=1",
            ),
            (
                "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor",
                "powersave\n",
                "governor",
                RunVerdict::Improvable,
                "-g performance",
            ),
            (
                "proc/sys/kernel/sched_rt_runtime_us",
                "950000\n",
                "real-time throttling",
                RunVerdict::Improvable,
                "=-1",
            ),
            (
                "proc/sys/net/core/rmem_max",
                "212992\n",
                "receive buffer",
                RunVerdict::Improvable,
                "rmem_max=4194304",
            ),
            (
                "sys/kernel/mm/transparent_hugepage/defrag",
                "[always] never\n",
                "huge pages",
                RunVerdict::Improvable,
                "echo never",
            ),
            (
                "sys/devices/system/clocksource/clocksource0/current_clocksource",
                "hpet\n",
                "clock source",
                RunVerdict::Improvable,
                "clocksource=tsc",
            ),
            (
                "proc/902/comm",
                "bash\n",
                "clock's service",
                RunVerdict::Improvable,
                "chrony",
            ),
        ] {
            let (found, command) = mended(path, text, subject, &demanding());
            assert_eq!(found, verdict, "{path}");
            assert!(command.contains(mend), "{command}");
        }
        let sleeps = Wants {
            spins: false,
            ..demanding()
        };
        let idle = "sys/devices/system/cpu/cpu0/cpuidle/state1/latency";
        assert!(
            mended(idle, "133\n", "idle states", &sleeps)
                .1
                .contains("idle-set -D 10")
        );
    }

    #[test]
    fn what_is_required_and_not_granted_is_lacking() {
        let mut files = TUNED.to_vec();
        files.retain(|(name, _)| !name.starts_with("proc/self"));
        files.push(("proc/self/status", "CapEff:\t0000000000000000\n"));
        files.push(("proc/self/limits", LIMITS));
        let (_folder, machine) = machine(&files);
        let verdicts = |wants: &Wants, free| {
            let findings = examine(&machine, wants, free);
            let of = |verdict| findings.iter().filter(move |finding| finding.verdict == verdict);
            let names = |verdict| of(verdict).map(|finding| finding.subject).collect::<Vec<_>>();
            (names(RunVerdict::Lacking), names(RunVerdict::Improvable))
        };
        let rights = vec!["real-time priority", "locked memory"];
        assert_eq!(verdicts(&demanding(), Some(FREE)), (rights, vec!["open files"]));
        let modest = Wants {
            realtime_priority: None,
            lock_memory: false,
            ..demanding()
        };
        assert_eq!(verdicts(&modest, Some(10)), (vec!["shared memory"], vec!["open files"]));
    }
}

//! Monitor: reports during operation and at the end whether the deployment works (PL-9).
//!
//! An operator asks four questions. Does everything arrive? How long does it take? Is the track picture right? Is
//! every process present? No process can answer for the others. Therefore every process publishes counters (health
//! messages), every system track carries the stamps of its stages, and the monitor combines both:
//!
//! | module | purpose |
//! |---|---|
//! | [`MonitorAgent`] | decides *when*: takes messages, closes intervals, shows, writes, ends |
//! | `survey` | all observations, and the derived summaries: an overview per interval, and the [`Report`] |
//! | `conditions` | detect alarm conditions in these data: of sources (clocks, biases, silence), counters, processes |
//! | `shares` | detects sources that fusion uses too little: isolated, contradicted, or with impossible times |
//! | `machine` | detects alarm conditions in the machine's resources |
//! | `alarm_desk` | raises and clears alarms, and publishes the standing alarms |
//! | `truth_watch` | compares the picture with the truth, where the world is simulated |
//! | `display` | an overview as text, on a screen or in a line: pure functions |
//! | `report_text`, `verdict` | turn the report into text: pure functions |
//! | `screen`, `files` | where text and files go |
//! | [`top`] | `koseki top`: the same in another terminal |
//! | `exposition`, `metrics` | the same for Prometheus, served on a separate thread |
//!
//! # How loss is proved
//! Loss is a difference of counters that different processes keep: the publisher's count of published samples, the
//! reader's count of taken samples, and the reader's count of samples missing in the sequence ("lost"). The remainder
//! is *unread*: published in the absence of the reader, which had not started, was being restarted, or had stopped.
//! Everything has arrived only if both are 0. Limit: a killed process loses up to 0.2 s of counts, the time between two
//! health messages. A restarted monitor does not have the counts that other processes kept before their own restarts.
//!
//! # What the latencies are
//! The monitor is a subscriber like any other. There are two ways to wait, and `[monitor] wait` chooses between them:
//!
//! - **event**: the monitor sleeps until notified, and measures the same time from fusion to "received" as any
//!   subscriber. Fusion pays the price, by waking a further reader: some ten microseconds per slice.
//! - **poll**: the monitor waits for no notification, and checks for new slices every few milliseconds, at no cost to
//!   fusion. The time from fusion to "received" would then measure the monitor's own pause. Therefore that stage is not
//!   measured, and end to end and age are taken to the moment at which fusion published. `koseki bench` measures the
//!   rest.
//!
//! If fusion spins for low latency, poll is the default. A queue of 256 slices holds 30 ms of data at half a million
//! states per second in slices of 64, so that the default pause of 5 ms leaves room for the work at the end of an
//! interval. Each slice is stamped when taken, not once per turn.
//!
//! In a replay at the highest speed, reports wait in full queues all the time. Such latencies do not occur in
//! operation, so that none are recorded then. The adapters wait for fusion and the recorder, but not for the monitor:
//! the monitor may miss states, counts the missed states, and affects no other process.
//!
//! Architecture invariant: the monitor only reads data. No action of the monitor can delay a publisher. The monitor's
//! own topics are for users: alarms, and the origin of the system frame.

#![forbid(unsafe_code)]

mod agent;
mod alarm_desk;
#[cfg(test)]
mod board_tests;
mod conditions;
mod counters;
mod display;
mod exposition;
mod feeders;
mod files;
#[cfg(test)]
mod golden;
mod machine;
mod metrics;
mod report;
mod report_text;
mod screen;
mod settings;
#[cfg(test)]
mod settings_tests;
mod shares;
mod survey;
mod text;
pub mod top;
mod truth_watch;
mod verdict;

pub use agent::{ClockReader, MonitorAgent};
pub use observed::{ObservedProcess, ProcessState, TrackCounts};
pub use report::{AlarmReport, Hop, ProcessCounters, Report, Restarts, SourceReport, SourceStageReport, Verdict};
pub use scoring::PictureTarget;
pub use screen::Screen;
pub use settings::{Keys, MonitorWait, Settings};
pub use truth_watch::{SimulatedTargets, VisibleAt};

/// Runs the monitor until a stop request.
///
/// # Errors
/// If a file cannot be written or shared memory fails.
pub fn run(process: &runtime::Process, settings: &Settings, targets: Option<SimulatedTargets>) -> anyhow::Result<()> {
    let say = |line: &str| {
        runtime::notice(format_args!("koseki: {}: {line}", process.name));
    };
    let mut agent = MonitorAgent::new(
        (&process.config, settings),
        &process.options,
        &process.name,
        &process.bus,
        Box::new(runtime::Now::read),
        Screen::standard_output(),
    )?;
    if let Some(targets) = targets {
        agent.compare_with(targets);
    }
    match agent.metrics() {
        None => {}
        Some(Ok(url)) => say(&format!("metrics are at {url}")),
        Some(Err(refusal)) => say(&format!("{refusal}; it goes on without metrics")),
    }
    runtime::service::run(process, &mut agent)
}

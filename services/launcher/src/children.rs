//! All children of a deployment: the state of the whole, and operations on several children.

use std::ops::{Deref, DerefMut};
use std::time::{Duration, Instant};

use deployment::Deployment;
use messages::ProcessKind;
use runtime::clock::instant;

use crate::backoff::Backoff;
use crate::child::Child;
use crate::part::{ProcessPart, parts};
use crate::wake::Wake;

/// Time for a child to stop, before SIGKILL.
const STOP_PATIENCE: Duration = Duration::from_secs(5);
/// The longest pause of fusion is this fraction of `checkpoint.max_age_s`.
const PAUSES_PER_AGE: u32 = 5;

/// Children of a deployment, in the order of the parts.
#[derive(Debug)]
pub(crate) struct Children(Vec<Child>);

impl Children {
    /// Creates the children of `config`; none is started.
    pub(crate) fn of(config: &Deployment) -> Self {
        let child = |part: ProcessPart| {
            let backoff = backoff(&part, config);
            Child::new(part, backoff)
        };
        Self(parts(config).into_iter().map(child).collect())
    }

    /// Returns the time of the next restart.
    pub(crate) fn next_restart(&self) -> Option<Instant> {
        self.iter().filter_map(Child::restart_due).min()
    }

    /// Whether the child at `index` reads adapters, and another reader has finished.
    pub(crate) fn has_outlived_a_reader(&self, index: usize) -> bool {
        let is_reader = |child: &Child| self.readers().any(|reader| reader.part() == child.part());
        is_reader(&self[index]) && self.readers().any(Child::is_finished)
    }

    /// Returns the readers of the adapters, which finish when all recordings have ended.
    pub(crate) fn readers(&self) -> impl Iterator<Item = &Child> {
        let reads = |child: &&Child| matches!(child.part().kind, ProcessKind::Fusion | ProcessKind::Recorder);
        self.iter().filter(reads)
    }

    /// Ends the pauses of fusion processes if no fusion can lead: tracks end after a long time without a leader.
    /// Returns whether the pause of the child at `index` is among these.
    pub(crate) fn hasten_fusion(&mut self, now: Instant, index: usize) -> bool {
        let is_fusion = |child: &Child| child.part().kind == ProcessKind::Fusion;
        if self.iter().any(|child| is_fusion(child) && child.is_up()) {
            return false;
        }
        let mut is_hastened = false;
        for (place, child) in self.iter_mut().enumerate() {
            is_hastened |= is_fusion(child) && child.hasten(now) && place == index;
        }
        is_hastened
    }

    /// If the leading fusion has ended, the standby leads from now on, and the restarted process becomes the standby.
    pub(crate) fn hand_over(&mut self, index: usize) {
        let is_leader = self[index].part() == &ProcessPart::leader();
        let is_standby = |child: &Child| child.part().kind == ProcessKind::Fusion && child.is_up();
        if let Some(other) = self.iter().position(is_standby).filter(|_| is_leader)
            && let Ok([ended, leads]) = self.get_disjoint_mut([index, other])
        {
            ended.exchange_names(leads);
        }
    }

    /// Returns the children that are due to start again, with a sentence for each.
    pub(crate) fn down(&self) -> Vec<(ProcessKind, String)> {
        let down = self.iter().filter(|child| child.restart_due().is_some());
        let said = down.map(|child| {
            let end = child.last_end().map(ToString::to_string).unwrap_or_default();
            let title = child.part().title();
            (
                child.part().kind,
                format!("{title} was not there in the end: the last time, it {end}"),
            )
        });
        said.collect()
    }

    /// Returns the titles of the services, and the names of the adapters.
    pub(crate) fn listed(&self) -> String {
        let names = |adapters: bool| -> Vec<String> {
            let parts = self.iter().map(Child::part);
            let chosen = parts.filter(|part| (part.kind == ProcessKind::Adapter) == adapters);
            chosen
                .map(|part| if adapters { part.name.clone() } else { part.title() })
                .collect()
        };
        let (services, adapters) = (names(false).join(", "), names(true));
        let count = match adapters.len() {
            1 => "1 adapter".to_owned(),
            count => format!("{count} adapters"),
        };
        format!("{services}, and {count} ({})", adapters.join(", "))
    }

    /// Returns a line for the service manager; `is_started` after the last stage of the start.
    pub(crate) fn status(&self, is_started: bool) -> String {
        let down: Vec<String> = self
            .iter()
            .filter(|child| !child.is_up())
            .map(|child| match child.last_end() {
                Some(end) => format!("{} {end}", child.part().title()),
                None => child.part().title(),
            })
            .collect();
        match (is_started, down.is_empty()) {
            (_, true) => format!("{} processes run", self.len()),
            (true, false) => format!("down: {}", down.join(", ")),
            (false, false) => format!("starting: {}", down.join(", ")),
        }
    }

    /// Stops the children of a kind; SIGKILL ends the wait. Each problem is a sentence.
    pub(crate) fn stop(&mut self, kind: ProcessKind, wake: &Wake, problems: &mut Vec<String>) {
        let mut waited_for: Vec<&mut Child> = self.iter_mut().filter(|child| child.part().kind == kind).collect();
        waited_for.retain_mut(|child| child.ask_to_stop());
        let start = instant();
        while !waited_for.is_empty() {
            waited_for.retain_mut(|child| match child.has_stopped() {
                Ok(stopped) => !stopped,
                Err(problem) => {
                    problems.push(problem);
                    false
                }
            });
            if instant() - start >= STOP_PATIENCE {
                break;
            }
            if !waited_for.is_empty() {
                wake.wait(Wake::TICK);
            }
        }
        for child in waited_for {
            child.kill();
            let patience = STOP_PATIENCE.as_secs();
            problems.push(format!(
                "{} did not stop within {patience} s and was killed",
                child.part().title()
            ));
        }
    }
}

impl Deref for Children {
    type Target = [Child];

    fn deref(&self) -> &[Child] {
        &self.0
    }
}

impl DerefMut for Children {
    fn deref_mut(&mut self) -> &mut [Child] {
        &mut self.0
    }
}

/// Returns the pauses before restarts of `part`: the pauses of fusion stay below a quarter of the age at which tracks
/// end.
fn backoff(part: &ProcessPart, config: &Deployment) -> Backoff {
    match (part.kind, config.checkpoint.max_age_ns()) {
        (ProcessKind::Fusion, Some(max_age_ns)) => {
            Backoff::with_longest(Duration::from_nanos(max_age_ns.max(0) as u64) / PAUSES_PER_AGE)
        }
        _ => Backoff::new(),
    }
}

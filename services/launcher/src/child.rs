//! Child process through all restarts.

use std::os::fd::OwnedFd;
use std::os::unix::process::CommandExt as _;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use messages::{LifeState, ProcessKind};
use runtime::clock::instant;
use rustix::process::{Pid, Signal, kill_process};

use crate::backoff::Backoff;
use crate::end::End;
use crate::link::{ChildFacts, ProcessHealth};
use crate::part::ProcessPart;

/// Failures in a row after which the deployment ends, of a needed or required child that does not come up.
pub(crate) const CHANCES: u32 = 8;
/// Factor on the limit of silence while a child starts.
const START_ALLOWANCE: u32 = 6;
/// Time for a killed process to disappear, and the pause between two looks.
const KILL_PATIENCE: Duration = Duration::from_secs(2);
const KILL_PAUSE: Duration = Duration::from_millis(1);
/// Maximum time between two looks that count: after a longer time, the observer did not run, and the child may not
/// have run either.
const LOOKED_AWAY: Duration = Duration::from_secs(1);

/// Process of the deployment, with the present operating system process.
#[derive(Debug)]
pub(crate) struct Child {
    part: ProcessPart,
    state: ChildPhase,
    backoff: Backoff,
    restarts: u32,
    /// Whether a process of this child has ever reported running.
    was_up: bool,
    last_end: Option<End>,
}

#[derive(Debug)]
enum ChildPhase {
    /// Waits for the child's stage of the first start or of a rebuild.
    Unborn { gap_since: Option<Instant> },
    /// Has a process.
    Alive {
        process: std::process::Child,
        since: Instant,
        /// Whether the process has reported running.
        running: bool,
        /// End of the predecessor, until the process reports running.
        gap_since: Option<Instant>,
        /// Latest sign of life, monotonic, nanoseconds, by the process itself.
        moved_ns: i64,
        /// Time without a sign of life, as far as the keeper looked.
        still: Duration,
        /// Whether the process was killed because of a hang.
        condemned: bool,
    },
    /// Has ended, and waits for the restart.
    Waiting {
        ended: Instant,
        until: Instant,
        /// Whether the process that ended had come up.
        had_come_up: bool,
    },
    /// Has ended for good.
    Ended,
}

/// Consequence of a child's end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Sequel {
    /// None: the work is done.
    Finished,
    /// Restart after this time.
    RestartIn(Duration),
    /// End of the deployment: the child refuses the configuration.
    Refused,
    /// End of the deployment: the child is needed and does not come up.
    GiveUp,
}

impl Child {
    /// Creates a child that waits for a stage, with pauses before restarts by `backoff`.
    pub(crate) fn new(part: ProcessPart, backoff: Backoff) -> Self {
        Self {
            part,
            state: ChildPhase::Unborn { gap_since: None },
            backoff,
            restarts: 0,
            was_up: false,
            last_end: None,
        }
    }

    pub(crate) fn part(&self) -> &ProcessPart {
        &self.part
    }

    /// Exchanges names with another child of the same kind after an exchange of roles.
    pub(crate) fn exchange_names(&mut self, other: &mut Self) {
        std::mem::swap(&mut self.part.name, &mut other.part.name);
    }

    /// Returns the number of restarts.
    pub(crate) fn restarts(&self) -> u32 {
        self.restarts
    }

    /// Returns the number of ends in a row, each after a short life.
    pub(crate) fn failures(&self) -> u32 {
        self.backoff.failures()
    }

    /// Returns the last end, unless the child finished.
    pub(crate) fn last_end(&self) -> Option<&End> {
        self.last_end.as_ref().filter(|end| !end.is_finished())
    }

    /// Returns the process number, if there is a process.
    pub(crate) fn pid(&self) -> Option<u32> {
        match &self.state {
            ChildPhase::Alive { process, .. } => Some(process.id()),
            _ => None,
        }
    }

    pub(crate) fn is_unborn(&self) -> bool {
        matches!(self.state, ChildPhase::Unborn { .. })
    }

    /// Whether the child has finished, with exit code 0.
    pub(crate) fn is_finished(&self) -> bool {
        matches!(self.state, ChildPhase::Ended) && self.last_end.as_ref().is_some_and(End::is_finished)
    }

    /// Whether the child runs or has finished.
    pub(crate) fn is_up(&self) -> bool {
        matches!(self.state, ChildPhase::Alive { running: true, .. }) || self.is_finished()
    }

    /// Returns the state of life for health messages.
    fn life(&self) -> LifeState {
        match &self.state {
            ChildPhase::Alive { running: true, .. } => LifeState::Running,
            ChildPhase::Unborn { .. } | ChildPhase::Alive { running: false, .. } => LifeState::Starting,
            ChildPhase::Ended if self.is_finished() => LifeState::Finished,
            ChildPhase::Waiting { .. } | ChildPhase::Ended => LifeState::Failed,
        }
    }

    /// Returns the facts for health messages.
    pub(crate) fn facts(&self) -> ChildFacts {
        ChildFacts {
            name: self.part.name.clone(),
            process_id: self.pid().unwrap_or(0),
            source: self.part.source,
            life: self.life() as u8,
            restarts: self.restarts,
            last_end: self.last_end().map(ToString::to_string).unwrap_or_default(),
        }
    }

    /// Returns the time of the next start, if any is due.
    pub(crate) fn restart_due(&self) -> Option<Instant> {
        match self.state {
            ChildPhase::Waiting { until, .. } => Some(until),
            _ => None,
        }
    }

    /// Ends the pause before the next start, if the process had come up. Returns whether there was a pause.
    pub(crate) fn hasten(&mut self, now: Instant) -> bool {
        match &mut self.state {
            ChildPhase::Waiting {
                until,
                had_come_up: true,
                ..
            } => {
                let is_hastened = *until > now;
                *until = now.min(*until);
                is_hastened
            }
            _ => false,
        }
    }

    /// Starts the process with `input` as standard input. An error counts as an end.
    pub(crate) fn start(&mut self, command: &mut Command, input: Option<OwnedFd>) -> Option<Sequel> {
        let gap_since = match self.state {
            ChildPhase::Waiting { ended, .. } => Some(ended),
            ChildPhase::Unborn { gap_since } => gap_since,
            _ => None,
        };
        self.restarts += u32::from(gap_since.is_some());
        // Only the monitor writes to standard output. In a separate process group, the child does not receive Ctrl-C:
        // the launcher decides the order of the stop.
        let output = match self.part.kind {
            ProcessKind::Monitor => Stdio::inherit(),
            _ => Stdio::null(),
        };
        let input = input.map_or_else(Stdio::null, Stdio::from);
        let since = instant();
        match command.stdin(input).stdout(output).process_group(0).spawn() {
            Ok(process) => {
                self.state = ChildPhase::Alive {
                    process,
                    since,
                    running: false,
                    gap_since,
                    moved_ns: i64::MIN,
                    still: Duration::ZERO,
                    condemned: false,
                };
                None
            }
            Err(error) => Some(self.ended(End::NotStarted(error.to_string()), Duration::ZERO, false, since)),
        }
    }

    /// Notes a sign of life. Returns the time without a process if this is the first sign of life after a restart.
    pub(crate) fn hear(&mut self, said: ProcessHealth, now: Instant) -> Option<Duration> {
        let ChildPhase::Alive {
            running,
            gap_since,
            moved_ns,
            still,
            ..
        } = &mut self.state
        else {
            return None;
        };
        if said.said_ns > *moved_ns {
            (*moved_ns, *still) = (said.said_ns, Duration::ZERO);
        }
        if !matches!(
            LifeState::from_code(said.life),
            Some(LifeState::Running | LifeState::Finished)
        ) {
            return None;
        }
        (*running, self.was_up) = (true, true);
        gap_since.take().map(|ended| now.duration_since(ended))
    }

    /// Notes a look for signs of life, `passed` after the look before. A process without a sign of life for `limit` is
    /// killed; [`Self::reap`] reports the end.
    pub(crate) fn looked(&mut self, elapsed: Duration, limit: Duration) {
        let ChildPhase::Alive {
            process,
            running,
            still,
            condemned,
            ..
        } = &mut self.state
        else {
            return;
        };
        if *condemned {
            return;
        }
        *still = if elapsed >= LOOKED_AWAY {
            Duration::ZERO
        } else {
            *still + elapsed
        };
        let limit = if *running { limit } else { START_ALLOWANCE * limit };
        if *still >= limit && waits_for_disk(process) {
            // The process cannot even be killed, and continues when the disk answers.
            *still = Duration::ZERO;
        } else if *still >= limit {
            *condemned = true;
            signal(process, Signal::KILL);
        }
    }

    /// Returns the consequence of the process's end, if the process has ended.
    pub(crate) fn reap(&mut self, now: Instant) -> Option<Sequel> {
        let ChildPhase::Alive {
            process,
            since,
            running,
            still,
            condemned,
            ..
        } = &mut self.state
        else {
            return None;
        };
        let end = match process.try_wait() {
            Ok(None) => return None,
            Ok(Some(_)) if *condemned => End::StoodStill(*still),
            Ok(Some(status)) => End::from(status),
            // Possible only if another waiter has collected the process: the kind of end is unknown.
            Err(error) => End::NotStarted(error.to_string()),
        };
        let (lived, came_up) = (now.duration_since(*since), *running);
        Some(self.ended(end, lived, came_up, now))
    }

    fn ended(&mut self, end: End, lived: Duration, came_up: bool, now: Instant) -> Sequel {
        let (finished, refused, killed) = (end.is_finished(), end.is_refused(), end.is_killed());
        self.last_end = Some(end);
        self.state = ChildPhase::Ended;
        if finished {
            return Sequel::Finished;
        }
        if refused {
            return Sequel::Refused;
        }
        let pause = self.backoff.ended(lived, came_up);
        let give_up = match self.part.kind {
            // The fault may recur in new memory; the successor of a killed process may complain about the remains.
            ProcessKind::Keeper => !self.was_up && !killed && (self.failures() == 1 || self.failures() >= CHANCES),
            ProcessKind::Fusion => !self.was_up && self.failures() >= CHANCES,
            _ => self.part.required && self.failures() >= CHANCES,
        };
        if give_up {
            return Sequel::GiveUp;
        }
        self.state = ChildPhase::Waiting {
            ended: now,
            until: now + pause,
            had_come_up: came_up,
        };
        Sequel::RestartIn(pause)
    }

    /// Kills the process for a rebuild of the deployment: the child starts again in the child's stage.
    pub(crate) fn tear_down(&mut self, now: Instant) {
        let gap_since = match self.state {
            ChildPhase::Alive { gap_since, .. } => Some(gap_since.unwrap_or(now)),
            ChildPhase::Waiting { ended, .. } => Some(ended),
            ChildPhase::Unborn { gap_since } => gap_since,
            ChildPhase::Ended => Some(now),
        };
        self.kill();
        self.state = ChildPhase::Unborn { gap_since };
    }

    /// Requests a stop. Returns whether there is a process to wait for; no restart follows.
    pub(crate) fn ask_to_stop(&mut self) -> bool {
        match &self.state {
            ChildPhase::Alive { process, .. } => {
                signal(process, Signal::TERM);
                true
            }
            ChildPhase::Waiting { .. } | ChildPhase::Unborn { .. } => {
                self.state = ChildPhase::Ended;
                false
            }
            ChildPhase::Ended => false,
        }
    }

    /// Whether the process has stopped after the request. An error describes a process that did not stop well.
    pub(crate) fn has_stopped(&mut self) -> Result<bool, String> {
        let ChildPhase::Alive { process, running, .. } = &mut self.state else {
            return Ok(true);
        };
        let (end, running) = match process.try_wait() {
            Ok(None) => return Ok(false),
            Ok(Some(status)) => (End::from(status), *running),
            Err(error) => (End::NotStarted(error.to_string()), *running),
        };
        self.state = ChildPhase::Ended;
        let well = end.is_finished() || (end.is_request_to_stop() && !running);
        let problem = format!("{} {end} when it was asked to stop", self.part.title());
        self.last_end = Some(end);
        if well { Ok(true) } else { Err(problem) }
    }

    /// Kills the process and waits for the end, for a limited time: the kernel can hold back a process that waits for a
    /// disk or is stopped by a debugger.
    pub(crate) fn kill(&mut self) {
        if let ChildPhase::Alive { process, .. } = &mut self.state {
            signal(process, Signal::KILL);
            let killed = instant();
            while matches!(process.try_wait(), Ok(None)) && instant() - killed < KILL_PATIENCE {
                std::thread::sleep(KILL_PAUSE);
            }
            self.last_end = Some(End::Signal(Signal::KILL.as_raw()));
        }
        self.state = ChildPhase::Ended;
    }
}

/// Whether the kernel neither runs nor kills the process's first thread: state D, behind the name in brackets.
fn waits_for_disk(process: &std::process::Child) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", process.id()));
    stat.is_ok_and(|stat| stat.rsplit(") ").next().is_some_and(|rest| rest.starts_with('D')))
}

/// A process that has not been collected keeps the process number, so that the signal cannot reach another process.
fn signal(process: &std::process::Child, signal: Signal) {
    // Fails only if the process has ended, as intended.
    let _ = kill_process(Pid::from_child(process), signal);
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::NO_SOURCE;

    fn child_of(kind: ProcessKind, required: bool) -> Child {
        let part = ProcessPart {
            kind,
            name: kind.word().to_owned(),
            source: NO_SOURCE,
            required,
        };
        Child::new(part, Backoff::new())
    }

    fn child() -> Child {
        child_of(ProcessKind::Fusion, false)
    }

    fn said(life: LifeState, said_ns: i64) -> ProcessHealth {
        ProcessHealth {
            life: life as u8,
            said_ns,
            has_reports: false,
        }
    }

    fn fails_so_often(child: &mut Child) -> u32 {
        let nowhere = || Command::new("/nowhere/koseki");
        let failed = (1..=2 * CHANCES).find(|_| child.start(&mut nowhere(), None) == Some(Sequel::GiveUp));
        failed.unwrap_or(u32::MAX)
    }

    fn until_ended(child: &mut Child) -> Sequel {
        let start = Instant::now();
        loop {
            if let Some(sequel) = child.reap(Instant::now()) {
                return sequel;
            }
            assert!(start.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn shell(script: &str) -> Command {
        let mut command = Command::new("/bin/sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn exit_code_0_is_the_end_and_2_a_refusal() {
        let mut child = child();
        assert_eq!(child.start(&mut shell("exit 0"), None), None);
        assert_eq!(until_ended(&mut child), Sequel::Finished);
        assert!(child.is_finished() && child.is_up());
        let mut child = self::child();
        child.start(&mut shell("exit 2"), None);
        assert_eq!(until_ended(&mut child), Sequel::Refused);
        assert_eq!(child.life(), LifeState::Failed);
    }

    #[test]
    fn a_killed_child_is_restarted_counted_and_timed() {
        let mut child = child();
        child.start(&mut shell("kill -KILL $$"), None);
        assert!(matches!(until_ended(&mut child), Sequel::RestartIn(_)));
        assert_eq!(child.last_end(), Some(&End::Signal(9)));
        assert!(child.restart_due().is_some());
        child.start(&mut shell("sleep 60"), None);
        assert_eq!(child.restarts(), 1);
        assert_eq!(child.hear(said(LifeState::Starting, 1), Instant::now()), None);
        assert!(child.hear(said(LifeState::Running, 2), Instant::now()).is_some());
        assert_eq!(
            child.hear(said(LifeState::Running, 2), Instant::now()),
            None,
            "said once"
        );
        child.kill();
        assert!(child.pid().is_none() && child.restart_due().is_none());
    }

    #[test]
    fn only_the_pause_of_one_that_had_come_up_can_be_ended() {
        for comes_up in [false, true] {
            let mut child = child();
            child.start(&mut shell("kill -STOP $$"), None);
            if comes_up {
                child.hear(said(LifeState::Running, 1), Instant::now());
            }
            let ChildPhase::Alive { process, .. } = &child.state else {
                panic!("it has a process");
            };
            signal(process, Signal::KILL);
            assert!(matches!(until_ended(&mut child), Sequel::RestartIn(_)));
            let now = child.restart_due().unwrap() - Duration::from_nanos(1);
            assert_eq!(child.hasten(now), comes_up);
            assert_eq!(child.restart_due().unwrap() <= now, comes_up);
            assert!(!child.hasten(now), "there is no pause left, or none that may be ended");
        }
    }

    #[test]
    fn one_that_cannot_be_started_is_tried_again() {
        let mut child = child();
        let sequel = child.start(&mut Command::new("/nowhere/koseki"), None);
        assert!(matches!(sequel, Some(Sequel::RestartIn(_))));
        assert!(child.last_end().unwrap().to_string().contains("could not be started"));
    }

    #[test]
    fn a_request_to_stop_may_come_before_the_child_listens_for_it() {
        let mut child = child();
        child.start(&mut shell("sleep 60"), None);
        assert!(child.ask_to_stop());
        let start = Instant::now();
        while !child.has_stopped().unwrap() {
            assert!(start.elapsed() < Duration::from_secs(60));
        }
        assert!(!child.ask_to_stop(), "it is gone");
    }

    #[test]
    fn only_what_the_deployment_cannot_do_without_has_a_limited_number_of_chances() {
        use ProcessKind::{Adapter, Fusion, Keeper};
        assert_eq!(fails_so_often(&mut child_of(Adapter, false)), u32::MAX);
        assert_eq!(fails_so_often(&mut child_of(Adapter, true)), CHANCES);
        assert_eq!(fails_so_often(&mut child_of(Fusion, false)), CHANCES);
        assert_eq!(fails_so_often(&mut child_of(Keeper, false)), 1);
        let mut fusion = child_of(Fusion, false);
        fusion.start(&mut shell("sleep 60"), None);
        fusion.hear(said(LifeState::Running, 1), Instant::now());
        fusion.kill();
        assert_eq!(fails_so_often(&mut fusion), u32::MAX, "it has been up");
    }

    #[test]
    fn one_that_stands_still_is_killed_unless_nobody_could_have_seen_it_move() {
        let limit = Duration::from_secs(5);
        let second = Duration::from_millis(999);
        let mut child = child();
        child.start(&mut shell("sleep 60"), None);
        child.hear(said(LifeState::Running, 1), Instant::now());
        for round in 2..100 {
            child.looked(second, limit);
            child.hear(said(LifeState::Running, round), Instant::now());
        }
        // A repeated message is no sign of life, and a look after a long pause proves no hang.
        for _ in 0..5 {
            child.looked(second, limit);
            child.hear(said(LifeState::Running, 99), Instant::now());
        }
        child.looked(LOOKED_AWAY, limit);
        for _ in 0..5 {
            child.looked(second, limit);
        }
        assert_eq!(child.reap(Instant::now()), None);
        // A starting process may wait for the disk at that moment: the process gets the time again.
        let start = Instant::now();
        let sequel = loop {
            child.looked(second, limit);
            if let Some(sequel) = child.reap(Instant::now()) {
                break sequel;
            }
            assert!(start.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(1));
        };
        assert!(matches!(sequel, Sequel::RestartIn(_)));
        assert!(
            child
                .last_end()
                .unwrap()
                .to_string()
                .starts_with("stood still for 6.0 s")
        );
    }
}

//! `koseki torture`: random faults in a separate deployment, and a judge of the effects on a subscriber.
//!
//! The deployment has a separate folder, removed at the end, beside other deployments of the machine. The seed alone
//! determines the faults and the times (`schedule`), so that a run can be repeated. The simulated world continues after
//! any death, even of the launcher: an address is the same target for the whole run, with a known position (`world`).
//!
//! The `judge` does no input or output: the judge takes events, which can be recorded and judged again (`ledger`), and
//! can therefore be tested: `self_test` inserts many defects into a sound record, and the judge must find each. After
//! each fault the deployment must recover by itself. Otherwise the deployment is started again, and the failure is a
//! finding. A failure of this command itself is no verdict ([`OwnFailure`]).

#![forbid(unsafe_code)]

mod args;
mod deployment;
mod faults;
mod judge;
mod ledger;
mod onlooker;
mod own_file_systems;
mod report;
mod resources;
mod schedule;
mod self_test;
mod undisturbed;
mod world;

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use runtime::clock::instant;
use runtime::signals::Stop;

use crate::deployment::{Broken, Deployment, Interrupted};
pub use args::{EXAMPLES, Torture};
use judge::Judge;
use judge::event::{Part, What};
use report::{Happened, Outcome, Report};
use schedule::{FAULTS, Fault, Planned, Schedule};
pub use undisturbed::Engines;

/// Time after a fault within which everything must be back: a process that dies again and again is started ever later.
const PATIENCE: Duration = Duration::from_secs(60);
/// Time for which the judge continues after the last fault.
const AFTERWARDS: Duration = Duration::from_secs(5);
/// Time between two measurements of resources, seconds.
const RESOURCES_S: f64 = 15.0;

/// Deployment under test, as described by the file.
#[derive(Debug)]
pub struct Tested {
    /// Executable of the deployment's processes.
    pub executable: PathBuf,
    /// File of the configuration.
    pub path: PathBuf,
    /// The deployment.
    pub deployment: ::deployment::Deployment,
    /// Engines of the deployment's processes.
    pub engines: Engines,
    /// Time without a report after which a track ends, seconds.
    pub terminate_s: f64,
}

/// Wrong arguments, with a remedy.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Refused(String);

/// The command itself has failed, or was interrupted: there is no verdict.
#[derive(Debug)]
pub struct OwnFailure;

impl fmt::Display for OwnFailure {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "no verdict")
    }
}

/// Reader of the configuration that the arguments name.
pub type ReadTested = fn(&Torture) -> anyhow::Result<Tested>;

/// Runs the faults in the deployment that `read` gives, judges a record, or tests the judge; prints the result.
///
/// # Errors
/// If anything was wrong; [`OwnFailure`] if the fault was this command's.
pub fn run(torture: &Torture, read: ReadTested) -> anyhow::Result<()> {
    if let Some(record) = &torture.self_test {
        return self_test::run(record.as_deref());
    }
    if let Some(record) = &torture.judge {
        return judge_again(record);
    }
    let is_known = |name: &&String| *name == "none" || FAULTS.iter().any(|fault| fault.name == name.as_str());
    if let Some(unknown) = torture.only.iter().find(|name| !is_known(name)) {
        let names: Vec<&str> = FAULTS.iter().map(|fault| fault.name).collect();
        return Err(Refused(format!("--only {unknown}: there are none and {}", names.join(", "))).into());
    }
    own_file_systems::enter()?;
    let mut run = Run {
        torture,
        read,
        report: Report {
            seed: torture.seed,
            ..Report::default()
        },
        begun: instant(),
    };
    // Before anything is started: whether the report can be written.
    run.report
        .write(torture.json.as_deref())
        .map_err(|error| Refused(format!("--json: {error:#}")))?;
    let ended = catch_unwind(AssertUnwindSafe(|| run.whole()));
    let ended = ended.unwrap_or_else(|_| Err(anyhow::anyhow!("this command has panicked: see above")));
    run.conclude(ended)
}

fn judge_again(record: &std::path::Path) -> anyhow::Result<()> {
    let (conditions, events) = ledger::read(record)?;
    let mut judge = Judge::new(conditions);
    let limits = judge.limits();
    events.iter().for_each(|event| judge.take(event));
    let verdict = judge.verdict();
    print!("{}", report::verdict_text(&verdict, &limits));
    anyhow::ensure!(verdict.findings.is_empty(), "{}", verdict.wrong());
    Ok(())
}

struct Run<'a> {
    torture: &'a Torture,
    read: ReadTested,
    report: Report,
    begun: Instant,
}

impl Run<'_> {
    fn whole(&mut self) -> anyhow::Result<()> {
        let mut deployment = Deployment::start(self.torture, (self.read)(self.torture)?, Stop::on_signals()?)?;
        self.begun = instant();
        self.report.limits = Some(deployment.ledger().judge().limits());
        println!("limits: {}", deployment.ledger().judge().limits());
        let mut ended = self.faults(&mut deployment);
        if ended.is_ok() {
            ended = deployment.watch(AFTERWARDS).and_then(|()| deployment.stop());
        }
        if let Some(broken) = ended.as_ref().err().and_then(|error| error.downcast_ref::<Broken>()) {
            let missing = broken.to_string();
            deployment.ledger().now(What::NotBack { missing });
            ended = Ok(());
        }
        self.note(&mut deployment);
        ended.and(deployment.ledger().close())
    }

    /// Writes the present result.
    fn note(&mut self, deployment: &mut Deployment) {
        let report = &mut self.report;
        (report.take_overs, report.take_overs_from_still) = deployment.take_overs();
        report.verdict = Some(deployment.ledger().judge().verdict());
        report.seconds = (instant() - self.begun).as_secs_f64();
    }

    fn faults(&mut self, deployment: &mut Deployment) -> anyhow::Result<()> {
        let only = &self.torture.only;
        let wanted = |fault: &&Fault| only.is_empty() || only.iter().any(|name| name == fault.name);
        let possible = FAULTS.iter().filter(wanted).filter(|fault| deployment.has(fault.needs));
        let mut schedule = Schedule::new(self.torture.seed, deployment.cast(), possible.collect());
        let end = Duration::from_secs_f64(60.0 * self.torture.minutes);
        let mut next_resources_s = 0.0;
        while instant() - self.begun < end {
            let now_s = (instant() - self.begun).as_secs_f64();
            if now_s >= next_resources_s {
                self.report.resources.push(deployment.resources(now_s)?);
                next_resources_s = now_s + RESOURCES_S;
            }
            match schedule.next() {
                Some(planned) => self.fault(&planned, deployment)?,
                None => deployment.watch(AFTERWARDS)?,
            }
        }
        Ok(())
    }

    fn fault(&mut self, planned: &Planned, deployment: &mut Deployment) -> anyhow::Result<()> {
        deployment.watch(planned.pause)?;
        let (fault, act) = (planned.fault, planned.act.to_string());
        let caused = instant();
        let at_s = (caused - self.begun).as_secs_f64();
        let wrong = deployment.ledger().judge().findings().total();
        let takes = faults::takes(&planned.act, deployment);
        deployment.ledger().now(What::FaultBegins {
            fault: fault.name.to_owned(),
            act: act.clone(),
            takes: takes.clone(),
        });
        self.report.faults.push(Happened {
            at_s,
            fault: fault.name,
            act: act.clone(),
            back_s: None,
        });
        faults::cause(&planned.act, deployment)?;
        deployment.ledger().now(What::FaultEnds);
        // Spoilt memory may end processes later, too.
        let is_steady = takes.contains(&Part::Memory) || takes.contains(&Part::Numbers);
        let back = match deployment.until_back(PATIENCE, is_steady)? {
            None => {
                deployment.ledger().now(What::Back);
                let back_s = (instant() - caused).as_secs_f64();
                if let Some(happened) = self.report.faults.last_mut() {
                    happened.back_s = Some(back_s);
                }
                format!("back after {back_s:.2} s")
            }
            Some(missing) => {
                let back = missing.clone();
                deployment.ledger().now(What::NotBack { missing });
                deployment.ledger().now(What::Helped);
                deployment.restart()?;
                back
            }
        };
        println!("{at_s:7.1} s  {:<20} {act}; {back}", fault.name);
        let more = deployment.ledger().judge().findings().total() - wrong;
        if more > 0 {
            println!(
                "           {more} more findings: {}",
                deployment.ledger().judge().verdict().wrong()
            );
        }
        self.note(deployment);
        self.report.write(self.torture.json.as_deref())
    }

    /// Writes and prints the result; the error is the exit code.
    fn conclude(mut self, ended: anyhow::Result<()>) -> anyhow::Result<()> {
        let report = &mut self.report;
        let is_faulty = report
            .verdict
            .as_ref()
            .is_some_and(|verdict| !verdict.findings.is_empty());
        let interrupted = ended.as_ref().is_err_and(|error| error.is::<Interrupted>());
        report.outcome = match &ended {
            Ok(()) if is_faulty => Outcome::Faulty,
            Ok(()) => Outcome::Sound,
            Err(_) if interrupted && is_faulty => Outcome::Faulty,
            Err(_) if interrupted => Outcome::Interrupted,
            Err(_) => Outcome::Failed,
        };
        if let Err(error) = &ended {
            report.failure = Some(format!("{error:#}"));
        }
        let written = report.write(self.torture.json.as_deref());
        print!("{}", report.text());
        match (report.outcome, ended) {
            (Outcome::Faulty, _) => anyhow::bail!(
                "{}; seed {} has the same schedule of faults",
                report.wrong(),
                report.seed
            ),
            (_, Err(error)) => Err(error.context(OwnFailure)),
            (_, Ok(())) => written.map_err(|error| error.context(OwnFailure)),
        }
    }
}
